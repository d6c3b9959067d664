"""How far: distances to every family, of one configuration and of many; the monitor; shares of the joint space."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
