"""Is a path free? Files are read, curves checked between their samples, crossings mended."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
