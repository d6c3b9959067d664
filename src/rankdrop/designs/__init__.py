"""Many designs: variants of an arm, or several arms, each measured for the same task and held beside the others."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
