"""What a family of singular configurations is: record, conditions as equations, name, which one q lies on."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
