"""What the verbs return: records, their JSON and text, the verdict on them, and what is shipped for the catalogue."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
