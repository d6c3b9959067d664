"""How many regions singularities leave of the joint space, and changes of posture inside one of them."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
