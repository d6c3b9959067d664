"""Kinematic singularity analysis of robot arms: every family, of every corank, with its conditions.

    >>> import rankdrop
    >>> found = rankdrop.analyze(rankdrop.open_robot("scara"), starts=200)
    >>> [str(equation) for family in found.families for equation in family.equations]
    ['sin θ2']
"""

import lazy_loader

_named, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)  # what there is stands in __init__.pyi
__all__ += ["__version__"]


def __getattr__(name: str) -> object:
    """What the package gives, imported when it is asked for; the version takes a tenth of a second to find out."""
    if name == "__version__":
        from rankdrop.version import VERSION

        return VERSION
    return _named(name)
