"""At one configuration: rank, lost motions, joints to blame, ways out, the nearest singularity, what motion costs."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
