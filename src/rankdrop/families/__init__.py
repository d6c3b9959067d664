"""Families found numerically, over the joint space: search, rows, evidence; distances, slices, surfaces, walks."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
