"""Relations of the axes at one configuration."""

from __future__ import annotations

from collections.abc import Sequence

from rankdrop.local.axes import numbers
from rankdrop.local.relations import Relation

_VERBS = {
    "aligned": "aligned",
    "parallel": "parallel",
    "concurrent": "meet in one point",
    "intersecting": "intersect",
}


def relation_words(relation: Relation) -> str:
    """What some axes have in common.

    Example:
        >>> relation_words(Relation((4, 5, 6), "concurrent", structural=True))
        'axes 4, 5, 6 meet in one point'
        >>> relation_words(Relation((1, 3, 4), "parallel", structural=False, slides=(3,)))
        'axes 1, 4 and slide 3 parallel'
    """
    axes = [number for number in relation.joints if number not in relation.slides]
    members = [*_members("axis", "axes", axes), *_members("slide", "slides", relation.slides)]
    return f"{' and '.join(members)} {_VERBS[relation.kind]}"


def _members(singular: str, plural: str, joints: Sequence[int]) -> list[str]:
    """The joints of one kind, numbers from 1: "axes 1, 4"; nothing where there are none."""
    listed = numbers([number - 1 for number in joints])
    if not joints:
        return []
    if len(joints) == 1:
        return [f"{singular} {listed}"]
    return [f"{plural} {listed}"]
