"""A robot as data, its readers (URDF, xacro, MJCF, DH and screw tables), the catalogue, the ideal arm near it."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
