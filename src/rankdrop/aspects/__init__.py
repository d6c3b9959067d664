"""How many aspects an arm has: regions of its joint space that singularities part."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
