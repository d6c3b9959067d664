"""Paths: read, checked between their samples, and how near they come to a singularity."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
