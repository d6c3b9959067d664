"""How the families of variants differ from those of their neighbours: one appears, one vanishes, one splits, some join.

Families are told apart by what does not depend on lengths (`measure.key_of`), pieces of one form taken together. A
family *splits* where it is there on one side, and on the other two or more of the same corank and dimension are there
instead, whose joints are among its own; the same the other way round is that families *join*. All of this compares two
arms that were searched by sampling: a change between them lies somewhere on the way, and one that comes and goes
between two neighbours is not seen.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rankdrop.robot.model import Array

APPEARS, VANISHES, SPLITS, JOIN = "appears", "vanishes", "splits", "join"
_HEAD = re.compile(r"k(\d+), dim (\d+): ")
_JOINT = re.compile(r"(?:θ|q|joints )([\d, ]+)(?= =| coupled)")


@dataclass(frozen=True, slots=True)
class Change:
    """What differs from one variant to a neighbour.

    Attributes:
        kind: one of the four words.
        before, after: keys of the families, on the one side and on the other.
        first, second: numbers of the two variants, from 0.
        parameter: the one that differs between them; "" where several do.
        low, high: its values at the two [m, rad]; NaN where several differ.
    """

    kind: str
    before: tuple[str, ...]
    after: tuple[str, ...]
    first: int
    second: int
    parameter: str
    low: float
    high: float

    @property
    def what(self) -> tuple[str, tuple[str, ...], tuple[str, ...]]:
        """The change without the place."""
        return self.kind, self.before, self.after


@dataclass(frozen=True, slots=True)
class Structure:
    """Variants with the same families.

    Attributes:
        keys: of the families.
        variants: numbers from 0.
        ranges: of every parameter over them, (lowest, highest).
    """

    keys: tuple[str, ...]
    variants: tuple[int, ...]
    ranges: tuple[tuple[float, float], ...]


def structures(records: Sequence[Mapping[str, Any]]) -> list[Structure]:
    """Variants by their set of families, the commonest first. Variants whose families are in doubt are left out."""
    groups: dict[tuple[str, ...], list[int]] = {}
    for record in records:
        if (keys := keys_of(record)) is not None:
            groups.setdefault(keys, []).append(int(record["number"]))
    found = []
    for keys, members in sorted(groups.items(), key=lambda item: (-len(item[1]), item[0])):
        values = np.array([records[i]["values"] for i in members]).reshape(len(members), -1)
        ranges = tuple((float(low), float(high)) for low, high in zip(values.min(0), values.max(0), strict=True))
        found.append(Structure(keys, tuple(members), ranges))
    return found


def keys_of(record: Mapping[str, Any]) -> tuple[str, ...] | None:
    """The keys of a variant's families, sorted, each once; None where they were not asked for or do not hold."""
    if record.get("verdict") != "verified":
        return None
    return tuple(sorted(_united([one["key"] for one in record["families"]])))


def _united(keys: Sequence[str]) -> set[str]:
    """Keys in which pieces that differ by the values of one pinned joint alone are taken together."""
    found: dict[tuple[Any, ...], list[str]] = {}
    for key in keys:
        found.setdefault((key.partition(": ")[0], joints_of(key)), []).append(key)
    return {alike[0] if len(set(alike)) == 1 else _union(alike) for alike in found.values()}


def _union(keys: Sequence[str]) -> str:
    head = _HEAD.match(keys[0])
    start = head[0] if head else ""
    parts = [key[len(start):].split("; ") for key in keys]
    joined = []
    for column in zip(*parts, strict=True):
        name, _, _ = column[0].partition(" = ")
        values = {value for part in column for value in part.partition(" = ")[2].split(", ") if value}
        joined.append(f"{name} = {', '.join(sorted(values, key=_order))}" if values else column[0])
    return start + "; ".join(joined)


def _order(value: str) -> tuple[float, str]:
    number = value.removesuffix("°").replace("−", "-")
    try:
        return float(number), value
    except ValueError:
        return 1e9, value


def joints_of(key: str) -> frozenset[tuple[int, bool]]:
    """(joint, whether it is coupled) of a key."""
    found = set()
    for part in key.partition(": ")[2].split("; "):
        for match in _JOINT.finditer(part):
            found |= {(int(x), part.endswith("coupled")) for x in match[1].split(",")}
    return frozenset(found)


def changes(
    records: Sequence[Mapping[str, Any]], names: Sequence[str], pairs: Sequence[tuple[int, int]]
) -> list[Change]:
    """What differs between neighbours.

    Args:
        records: of the variants, by their number.
        names: of the parameters.
        pairs: of neighbours, numbers from 0.
    """
    found: list[Change] = []
    for first, second in pairs:
        one, other = keys_of(records[first]), keys_of(records[second])
        if one is None or other is None or one == other:
            continue
        apart = [k for k, (a, b) in enumerate(zip(records[first]["values"], records[second]["values"], strict=True))
                 if a != b]  # fmt: skip
        single = apart[0] if len(apart) == 1 else None
        where = ("", float("nan"), float("nan")) if single is None else (
            names[single], float(records[first]["values"][single]), float(records[second]["values"][single])
        )  # fmt: skip
        found += [Change(*what, first, second, *where) for what in _differences(set(one), set(other))]
    return found


def _differences(one: set[str], other: set[str]) -> list[tuple[str, tuple[str, ...], tuple[str, ...]]]:
    gone, new = sorted(one - other), sorted(other - one)
    found: list[tuple[str, tuple[str, ...], tuple[str, ...]]] = []
    for kind, whole, parts in ((SPLITS, gone, new), (JOIN, new, gone)):
        for key in list(whole):
            pieces = [part for part in parts if _part(part, key)]
            if len(pieces) > 1:
                found.append((kind, (key,), tuple(pieces)) if kind == SPLITS else (kind, tuple(pieces), (key,)))
                whole.remove(key)
                for piece in pieces:
                    parts.remove(piece)
    found += [(VANISHES, (key,), ()) for key in gone]
    return found + [(APPEARS, (), (key,)) for key in new]


def _part(part: str, whole: str) -> bool:
    a, b = _HEAD.match(part), _HEAD.match(whole)
    inner = {joint for joint, _ in joints_of(part)} <= {joint for joint, _ in joints_of(whole)}
    return a is not None and b is not None and a[0] == b[0] and inner


def neighbours(values: Array, grid: Sequence[int] | None, low: Array, high: Array) -> list[tuple[int, int]]:
    """Pairs of neighbours: on a grid one step along one parameter, else each variant and the nearest two.

    Args:
        values: (V, p) of the parameters.
        grid: how many values each has; None for what is no grid.
        low, high: (p,) of their ranges, in which distances are measured.
    """
    count = len(values)
    if grid is not None:
        index = np.arange(count).reshape(grid)
        found = []
        for axis in range(len(grid)):
            before = np.take(index, range(grid[axis] - 1), axis).reshape(-1)
            after = np.take(index, range(1, grid[axis]), axis).reshape(-1)
            found += [(int(a), int(b)) for a, b in zip(before, after, strict=True)]
        return sorted(found)
    unit = (values - low) / np.where(high > low, high - low, 1.0)
    pairs = set()
    for i in range(count):
        away = np.linalg.norm(unit - unit[i], axis=1)
        away[i] = np.inf
        for j in np.argsort(away, kind="stable")[: min(2, count - 1)]:
            pairs.add((min(i, int(j)), max(i, int(j))))
    return sorted(pairs)
