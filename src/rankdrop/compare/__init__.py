"""Families found numerically held against families derived exactly: one partition, one identity."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
