"""Kinematic singularity analysis of robot arms: every family, of every corank, with its conditions.

    >>> import rankdrop
    >>> found = rankdrop.analyze(rankdrop.open_robot("scara"), starts=200)
    >>> [str(equation) for family in found.families for equation in family.equations]
    ['sin θ2']
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)  # what there is stands in __init__.pyi
