"""Names of one table: no two families of an arm are called the same, and none is longer than it has to be."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

from rankdrop.families.name import (
    FamilyName,
)
from rankdrop.families.naming import shorten_names

_SHORT = 24  # characters of a condition that stands in a name


def distinct_names(
    names: Sequence[FamilyName], conditions: Sequence[Callable[[], Sequence[str]]]
) -> list[FamilyName]:
    """Names made unique: of those with the same words each gets the first short condition that only it has; then short.

    Args:
        names: of the families of one corank, in their order.
        conditions: of each, how to get its conditions for people; asked where it is needed only.

    Returns:
        The names; where no short condition tells them apart they are counted: "wrist (second)".

    Example:
        >>> from rankdrop.families.name import ArmPart
        >>> elbow, wrist = FamilyName((ArmPart.ELBOW,)), FamilyName((ArmPart.WRIST,))
        >>> found = distinct_names([elbow, wrist, elbow], [lambda: ["θ3 = 0"], lambda: ["θ5 = 0"], lambda: ["θ3 = π"]])
        >>> [str(name) for name in found]
        ['elbow (θ3 = 0)', 'wrist', 'elbow (θ3 = π)']
    """
    result = list(names)
    words = [str(name) for name in names]
    for same, count in Counter(words).items():
        if count == 1:
            continue
        places = [place for place, other in enumerate(words) if other == same]
        texts = [conditions[place]() for place in places]
        for number, place in enumerate(places):
            own = _own_condition(texts, number)
            if own is None:
                result[place] = replace(names[place], ordinal=number + 1)
            else:
                result[place] = replace(names[place], condition=own)
    return shorten_names(result)


def _own_condition(texts: Sequence[Sequence[str]], number: int) -> str | None:
    """The first short condition that only one of several families has."""
    others = set[str]().union(*(conditions for k, conditions in enumerate(texts) if k != number))
    return next((text for text in texts[number] if text not in others and len(text) <= _SHORT), None)
