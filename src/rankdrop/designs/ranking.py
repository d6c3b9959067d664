"""Variants compared: how the families of neighbours differ, and which variants are better beyond the error of samples.

Families are told apart by what does not depend on lengths (`form_of`), pieces of one form taken together. A
family *splits* where it is there on one side, and on the other two or more of the same corank and dimension are there
instead, whose joints are among its own; the same the other way round is that families *join*. All of this compares two
arms that were searched by sampling: a change between them lies somewhere on the way, and one that comes and goes
between two neighbours is not seen.

Every variant is measured on the same random configurations and poses. So two variants are compared by paired
differences: of a share of samples, error² = Σ (d − mean d)²/N² with d the difference at each sample. σ over a region
has proven bounds: a variant is worse only where its upper bound is below the lower bound of another one. A measure that
is neither sampled nor bounded has no error.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import degrees
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rankdrop.designs.deviations import Record, deviations
from rankdrop.designs.spec import Spec
from rankdrop.families import Family
from rankdrop.robot import Array, JointKind, Robot

APPEARS, VANISHES, SPLITS, JOIN = "appears", "vanishes", "splits", "join"
_RIGHT = 90.0  # degrees: values at multiples of this belong to a form, others depend on the lengths
_ROUND = 1e-6  # degrees
_ZERO = 1e-9  # [m]
PinForm = tuple[int, bool, tuple[float, ...], int]
"""(joint, whether it slides, values that do not depend on lengths [degrees, m], number of other values)."""
Form = tuple[int, int, tuple[PinForm, ...], tuple[int, ...]]
"""(corank, dimension, pinned joints, coupled joints) of a family."""

Rows = NDArray[np.intp]
BLOCK = 500
LEVEL = 0.05
"""Chance that any two equal variants of a sweep are called different."""


@dataclass(frozen=True, slots=True)
class NeighbourChange:
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
class SameFamilies:
    """Variants with the same families.

    Attributes:
        keys: of the families.
        variants: numbers from 0.
        ranges: of every parameter over them, (lowest, highest).
    """

    keys: tuple[str, ...]
    variants: tuple[int, ...]
    ranges: tuple[tuple[float, float], ...]


def structures(records: Sequence[Mapping[str, Any]]) -> list[SameFamilies]:
    """Variants by their set of families, the commonest first. Variants whose families are in doubt are left out."""
    groups: dict[tuple[str, ...], list[int]] = {}
    for record in records:
        if (keys := keys_of(record)) is not None:
            groups.setdefault(keys, []).append(int(record["number"]))
    structures_of = []
    for keys, members in sorted(groups.items(), key=lambda item: (-len(item[1]), item[0])):
        values = np.array([records[i]["values"] for i in members]).reshape(len(members), -1)
        ranges = tuple((float(low), float(high)) for low, high in zip(values.min(0), values.max(0), strict=True))
        structures_of.append(SameFamilies(keys, tuple(members), ranges))
    return structures_of


def form_of(family: Family, robot: Robot) -> Form:
    """What a family is, apart from the arm's lengths: corank, dimension, pinned joints, coupled joints.

    Values that are multiples of 90°, and zero of a slide, belong to it; others move with the lengths, and only their
    number does.
    """
    pins = []
    for pin in sorted(family.pinned, key=lambda pin: pin.number):
        slides = robot.variables[pin.number - 1].kind is JointKind.PRISMATIC
        if slides:
            if any(abs(value) <= _ZERO for value in pin.values):
                kept = [0.0]
            else:
                kept = []
            others = sum(abs(value) > _ZERO for value in pin.values)
        else:
            angles = sorted(round(degrees(value), 6) + 0.0 for value in pin.values)
            kept = [angle for angle in angles if abs(angle / _RIGHT - round(angle / _RIGHT)) < _ROUND]
            others = len(angles) - len(kept)
        pins.append((pin.number, slides, tuple(kept), others))
    return family.corank, family.dimension, tuple(pins), tuple(family.coupled)


def key_of(form: Form) -> str:
    """A form in words: "k1, dim 5: θ3 = 0°, 180°; joints 4, 5 coupled"."""
    corank, dimension, pins, coupled = form
    parts = []
    for number, slides, values, others in pins:
        told = [f"{value:g}{' m' if slides else '°'}".replace("-", "−") for value in values]
        parts.append(f"{'q' if slides else 'θ'}{number} = {', '.join(told + [f'{others} other'] * (others > 0))}")
    if coupled:
        tied = [f"joints {', '.join(map(str, coupled))} coupled"]
    else:
        tied = []
    return f"k{corank}, dim {dimension}: {'; '.join([*parts, *tied]) or 'everywhere'}"


def forms_of(record: Mapping[str, Any]) -> dict[str, Form] | None:
    """The forms of a variant's families by their key; None where they were not asked for or do not hold.

    Forms that differ by the values of pinned joints alone are taken together.
    """
    if record.get("verdict") != "verified":
        return None
    alike: dict[tuple[Any, ...], list[Form]] = {}
    for family in record["families"]:
        corank, dimension, pins, coupled = family["structure"]
        form = corank, dimension, tuple((n, slides, tuple(x), m) for n, slides, x, m in pins), tuple(coupled)
        alike.setdefault((corank, dimension, tuple(n for n, *_ in pins), form[3]), []).append(form)
    return dict(sorted((key_of(form), form) for form in map(_union, alike.values())))


def keys_of(record: Mapping[str, Any]) -> tuple[str, ...] | None:
    """The keys of a variant's families, sorted, each once; None where they were not asked for or do not hold."""
    forms = forms_of(record)
    if forms is None:
        return None
    return tuple(forms)


def _union(forms: Sequence[Form]) -> Form:
    corank, dimension, _, coupled = forms[0]
    pins = []
    for column in zip(*(form[2] for form in forms), strict=True):
        values = set[float]().union(*(pin[2] for pin in column))
        pins.append((*column[0][:2], tuple(sorted(values)), max(pin[3] for pin in column)))
    return corank, dimension, tuple(pins), coupled


def _joints_of(form: Form) -> set[int]:
    return {number for number, *_ in form[2]} | set(form[3])


def changes(
    records: Sequence[Mapping[str, Any]], names: Sequence[str], pairs: Sequence[tuple[int, int]]
) -> list[NeighbourChange]:
    """What differs between neighbours.

    Args:
        records: of the variants, by their number.
        names: of the parameters.
        pairs: of neighbours, numbers from 0.
    """
    differences: list[NeighbourChange] = []
    for first, second in pairs:
        before, after = forms_of(records[first]), forms_of(records[second])
        if before is None or after is None or before == after:
            continue
        apart = [k for k, (a, b) in enumerate(zip(records[first]["values"], records[second]["values"], strict=True))
                 if a != b]  # fmt: skip
        single = apart[0] if len(apart) == 1 else None
        where = ("", float("nan"), float("nan")) if single is None else (
            names[single], float(records[first]["values"][single]), float(records[second]["values"][single])
        )  # fmt: skip
        differences += [NeighbourChange(*what, first, second, *where) for what in _differences(before, after)]
    return differences


def _differences(
    one: Mapping[str, Form], other: Mapping[str, Form]
) -> list[tuple[str, tuple[str, ...], tuple[str, ...]]]:
    forms = {**one, **other}
    gone, new = sorted(one.keys() - other.keys()), sorted(other.keys() - one.keys())
    differences: list[tuple[str, tuple[str, ...], tuple[str, ...]]] = []
    for kind, whole, parts in ((SPLITS, gone, new), (JOIN, new, gone)):
        for key in list(whole):
            pieces = [part for part in parts if _part(forms[part], forms[key])]
            if len(pieces) > 1:
                differences.append((kind, (key,), tuple(pieces)) if kind == SPLITS else (kind, tuple(pieces), (key,)))
                whole.remove(key)
                for piece in pieces:
                    parts.remove(piece)
    differences += [(VANISHES, (key,), ()) for key in gone]
    return differences + [(APPEARS, (), (key,)) for key in new]


def _part(part: Form, whole: Form) -> bool:
    return part[:2] == whole[:2] and _joints_of(part) <= _joints_of(whole)


def neighbours(spec: Spec, records: Sequence[Mapping[str, Any]]) -> list[tuple[int, int]]:
    """Pairs of neighbours: on a grid one step along one parameter, else each variant and the nearest two.

    Distances are measured in the ranges of the parameters.
    """
    count = len(records)
    if spec.kind == "grid":
        grid = [len(parameter.values) for parameter in spec.parameters]
        index = np.arange(count).reshape(grid)
        edges = []
        for axis in range(len(grid)):
            before = np.take(index, range(grid[axis] - 1), axis).reshape(-1)
            after = np.take(index, range(1, grid[axis]), axis).reshape(-1)
            edges += [(int(a), int(b)) for a, b in zip(before, after, strict=True)]
        return sorted(edges)
    unit = spec.in_unit_box(np.array([record["values"] for record in records]))
    pairs = set()
    for i in range(count):
        away = np.linalg.norm(unit - unit[i], axis=1)
        away[i] = np.inf
        for j in np.argsort(away, kind="stable")[: min(2, count - 1)]:
            pairs.add((min(i, int(j)), max(i, int(j))))
    return sorted(pairs)


def bits_to_text(mask: NDArray[np.bool_]) -> str:
    """Samples as hexadecimal digits, a bit each, the first one highest."""
    return np.packbits(mask).tobytes().hex()


def proven_bounds(record: Record, measure: str) -> tuple[float, float]:
    """Lower and upper end of a measure: of σ over a region the proven ones, of others the value."""
    if measure != "sigma":
        value = float(record["measures"][measure])
        return value, value
    region = record.get("region") or {}
    lower, upper = region.get("sigma_lower"), region.get("sigma_upper")
    return 0.0 if lower is None else float(lower), float("inf") if upper is None else float(upper)


def threshold(variants: int, measures: int = 1) -> float:
    """Standard errors beyond which a difference counts, for all pairs of so many variants together (Bonferroni).

    Example:
        >>> round(threshold(2), 2), round(threshold(200), 2)
        (1.96, 4.71)
    """
    return NormalDist().inv_cdf(1.0 - LEVEL / (max(2, variants) * (max(2, variants) - 1) * max(1, measures)))


class Ranking(NamedTuple):
    """The best of a set of variants.

    Attributes:
        best: numbers, from 0, of the variants that no other one dominates.
        differ: whether some of the best differ from one another beyond the error.
    """

    best: list[int]
    differ: bool


def rank(records: Sequence[Record], goals: Mapping[str, str]) -> Ranking:
    """Compare variants pair by pair.

    A variant dominates another one where it is better beyond the error by one measure and worse beyond the error by
    none.

    Args:
        records: of the variants. One with an error, or without one of the measures, is not ranked.
        goals: measure -> "less" or "more".
    """
    numbers = [number for number, record in enumerate(records) if goals and _is_complete(record, goals)]
    compared = _Compared([records[number] for number in numbers], goals)
    every = np.arange(len(numbers))
    kept = np.concatenate([every[:0], *(rows[~compared.is_dominated(rows, every)] for rows in _blocks(every))])
    return Ranking([numbers[i] for i in kept], compared.differ(kept))


class _Compared:
    """Variants with all measures, compared pair by pair.

    Args:
        records: of the variants.
        goals: as of `rank`.
    """

    def __init__(self, records: Sequence[Record], goals: Mapping[str, str]) -> None:
        self.records, self.goals = records, goals
        self.spreads = {name: _stack_rows([deviations(record, name) for record in records]) for name in goals}
        self.beyond = threshold(len(records), sum(bool(spread.shape[1]) for spread in self.spreads.values()))

    def better(self, name: str, rows: Rows, columns: Rows) -> NDArray[np.bool_]:
        """(R, C) whether each of `rows` is better than each of `columns` by more than the error."""
        lower, upper = np.array([proven_bounds(record, name) for record in self.records]).T
        if self.goals[name] == "less":
            low, high = (lower, upper)
        else:
            low, high = (-upper, -lower)
        return _smaller(low, high, self.spreads[name], self.beyond, rows, columns)

    def is_dominated(self, rows: Rows, others: Rows) -> NDArray[np.bool_]:
        """(R,) whether one of `others` dominates each of `rows`."""
        worse = np.any([self.better(name, others, rows).T for name in self.goals], axis=0)
        better = np.any([self.better(name, rows, others) for name in self.goals], axis=0)
        return np.asarray((worse & ~better).any(axis=1))

    def differ(self, rows: Rows) -> bool:
        """Whether one of `rows` is better than another by some measure."""
        pairs = product(self.goals, _blocks(rows))
        return any(bool(self.better(name, some, rows).any()) for name, some in pairs)


def _is_complete(record: Record, goals: Mapping[str, str]) -> bool:
    return record.get("error") is None and all(record["measures"].get(name) is not None for name in goals)


def _blocks(rows: Rows) -> Iterator[Rows]:
    return (rows[first : first + BLOCK] for first in range(0, len(rows), BLOCK))


def _smaller(
    low: Array, high: Array, spread: Array, beyond: float, rows: Rows, columns: Rows
) -> NDArray[np.bool_]:  # fmt: skip
    """(R, C) whether each cost of `rows` is below each of `columns`: its upper end `high` below their lower end `low`,
    by more than so many errors |z − z'|."""
    if not spread.shape[1]:
        return np.asarray(high[rows, None] < low[None, columns])
    cost = low
    gap = cost[None, columns] - cost[rows, None]
    first, second = spread[rows], spread[columns]
    square = (first**2).sum(axis=1)[:, None] + (second**2).sum(axis=1)[None, :] - 2.0 * first @ second.T
    rounding = 1e-9 * np.maximum(np.abs(cost[rows, None]), np.abs(cost[None, columns]))
    return np.asarray(gap > np.maximum(beyond * np.sqrt(np.maximum(square, 0.0)), rounding))


def _stack_rows(rows: Sequence[Array]) -> Array:
    """(V, K) rows of one length, those without samples zero."""
    most = max((len(row) for row in rows), default=0)
    stacked = np.zeros((len(rows), most), dtype=np.float32 if most > 10_000 else np.float64)
    for row, values in zip(stacked, rows, strict=True):
        row[: len(values)] = values
    return stacked
