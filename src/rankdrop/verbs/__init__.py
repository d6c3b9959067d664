"""The verbs of the package, and what an arm does where an ideal one near it is singular."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
