"""What is said of an analysis, once, for the terminal, the report, notebooks and papers, which only lay it out."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
