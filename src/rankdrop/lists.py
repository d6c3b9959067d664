"""All parts of all items of a list, a list without some of its items, and the smallest of some sets."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import chain
from typing import TypeVar

From = TypeVar("From")
To = TypeVar("To")


def flat_map(function: Callable[[From], Iterable[To]], items: Iterable[From]) -> list[To]:
    """All parts of all items, f(item) the parts of one.

    Example:
        >>> flat_map(range, [1, 3])
        [0, 0, 1, 2]
    """
    return list(chain.from_iterable(map(function, items)))


def leave_out(items: Iterable[From], left_out: Iterable[From]) -> list[From]:
    """Items but those that are the same objects as some left out; equal ones stay.

    Example:
        >>> first, second = [1], [1]
        >>> leave_out([first, second], [second]) == [first]
        True
    """
    gone = {id(item) for item in left_out}
    return [item for item in items if id(item) not in gone]


def smallest_sets(sets: Iterable[frozenset[From]]) -> list[frozenset[From]]:
    """The sets that contain none of the others.

    Example:
        >>> [sorted(members) for members in smallest_sets([frozenset("ab"), frozenset("a"), frozenset("c")])]
        [['a'], ['c']]
    """
    every = list(sets)
    kept = []
    for members in every:
        if not any(other < members for other in every):
            kept.append(members)
    return kept
