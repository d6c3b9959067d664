"""Ideal arms: the nearest one to a tolerance that the user names, and whether there is one to name.

`ideal` is `rankdrop.robot.numbers.square_up` with other tolerances; `near_ideal` finds the smallest of them with which
an arm gains structure, and `what_holds` says what that is.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import pairwise, product
from math import ceil, degrees, floor, log10, pi, radians
from typing import NamedTuple

from rankdrop.errors import OptionError
from rankdrop.robot.arm_reach import extent
from rankdrop.robot.files import LONGEST_TEXT
from rankdrop.robot.model import Robot, once
from rankdrop.robot.numbers import LinkNumbers, numbers_of, offsets_along, parallel, parallel_runs
from rankdrop.robot.square_up import ExactChange, meeting, square_up
from rankdrop.tolerances import NOTHING, SQUARE

_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "µm": 1e-6, "μm": 1e-6, "um": 1e-6}
_TURNS = {"deg": radians(1.0), "°": radians(1.0), "rad": 1.0, "mrad": 1e-3}
_ONE = re.compile(r"\s*+(\d++\.?\d*+(?:[eE][+-]?\d++)?|\.\d++(?:[eE][+-]?\d++)?)\s*+([A-Za-zµμ°]++)\s*+")
_WIDEST = radians(5.0)  # angles are multiples of 15°: at half of that every angle would be one
_LONGEST = 0.1  # of the arm's size: with more it is another arm
_WIDER = (1.0, 1.5, 2.0, 3.0)  # a frame may have to turn by more than the axes in it do

NEAR = 0.015
"""Structure is near where it is missed by this share of the arm's size, or this angle [rad]: Gen3's 12 mm of 1.2 m are,
20 mm between the axes of an elbow are a design."""

INTENDED = 3e-4
"""A file's arm that misses structure by a length up to this is meant to have it [m]: CAD exports are no better."""
_CALIBRATED = 2e-3, 1e-3  # [rad], [m]: what calibration adds to a drawing
_SMALL_ARM = 0.3  # [m]; of smaller arms such lengths may be a design


class Hold(StrEnum):
    """What holds between joint axes."""

    POINT = "in one point"
    SHOULDER = "spherical shoulder"
    WRIST = "spherical wrist"
    PARALLEL = "parallel"
    COMMON = "on one line"
    MEETING = "meeting"
    SQUARE = "at right angles"
    FLUSH = "no offset"


class AxesHold(NamedTuple):
    """What holds between which joint axes, numbers from 1; "no offset" is between the common normals of parallel ones.
    """

    what: Hold
    joints: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Tolerance:
    """How far an arm may be from an ideal one.

    Attributes:
        length: [m]; None is what files are read with, see `square_up`.
        angle: [rad]; None is 2e-5.
    """

    length: float | None = None
    angle: float | None = None

    @property
    def text(self) -> str:
        """As it is typed: "1mm,0.5deg"."""
        if self.length is None:
            parts = []
        else:
            parts = [f"{self.length * 1e3:.12g}mm"]
        return ",".join(parts + ([] if self.angle is None else [f"{degrees(self.angle):.12g}deg"]))


@dataclass(frozen=True, slots=True)
class Near:
    """An ideal arm that is near.

    Attributes:
        gained: what holds in it exactly and in the arm itself only nearly, the most telling first.
        length, angle: the largest change of a length [m] and of an angle [rad] on the way to it; 0 for none.
        tolerance: with which `ideal` finds it, in round numbers.
    """

    gained: tuple[AxesHold, ...]
    length: float
    angle: float
    tolerance: Tolerance


def read_tolerance(text: str, *, where: str = "--ideal") -> Tolerance:
    """A tolerance as it is typed: a length, an angle or both, each with its unit.

    Args:
        text: "1mm,0.5deg", "0.3 mm", "1mrad".
        where: of errors.

    Raises:
        OptionError: no number with a unit, two of one kind, not positive, an angle above 5°.

    Example:
        >>> read_tolerance("1mm, 0.5deg").length, read_tolerance("0.3 mm").angle
        (0.001, None)
    """
    allowed = "a length (µm, um, mm, cm, m), an angle (deg, °, rad, mrad) or both, such as 1mm,0.5deg"
    sizes: dict[str, float] = {}
    for part in text.split(","):
        if len(part) <= LONGEST_TEXT:
            match = _ONE.fullmatch(part)
        else:
            match = None
        units = next((u for u in (_UNITS, _TURNS) if match is not None and match[2] in u), None)
        if match is None or units is None:
            raise OptionError("this is not a tolerance", where=where, got=repr(text), allowed=allowed)
        key = "length" if units is _UNITS else "angle"
        if key in sizes:
            raise OptionError(f"the {key} is given twice", where=where, got=repr(text), allowed=allowed)
        sizes[key] = float(match[1]) * units[match[2]]
    given = Tolerance(**sizes)
    _check(given, where)
    return given


def ideal(
    robot: Robot, *, length: float | None = None, angle: float | None = None
) -> tuple[Robot, tuple[ExactChange, ...]]:
    """The nearest arm whose structure is exact, to a tolerance, and what was moved.

    Axes that are parallel, or at a multiple of 15°, to `angle` are exactly so; those that come within `length` meet,
    three of them in one point where the offset between is as small; offsets along parallel axes that cancel to `length`
    cancel. It is `square_up` with other tolerances: everything else is kept, and the result is `robot` itself where
    nothing changes. A length changes by more than `length` where an axis is turned about a frame that is far from it.

    Args:
        robot: any arm.
        length: [m]; None takes 2 µm.
        angle: [rad]; None takes 2e-5.

    Raises:
        OptionError: not positive, an angle above 5°, a length above a tenth of the arm.
    """
    _check(Tolerance(length, angle), "ideal")
    size = extent(robot)
    if length is not None and length > _LONGEST * size:
        raise OptionError(
            "the length is too large for this arm: it would be another one", where="ideal", got=f"{length:g} m",
            allowed=f"up to {_LONGEST * size:.2g} m, a tenth of its size",
        )  # fmt: skip
    return square_up(robot, angle=SQUARE if angle is None else angle, length=length)


def ideal_name(robot: Robot) -> str:
    """Name of the ideal arm near an arm."""
    return f"{robot.name}_ideal"


def intended_tolerance(robot: Robot) -> Tolerance | None:
    """The tolerance of the ideal arm that a file is meant to describe; None where the file is taken as it is.

    That is an arm of a file, of more than 0.3 m, which misses structure by a length up to `INTENDED`, or in angles and
    lengths by what a calibration adds.
    """
    if robot.source.kind != "catalogue" and extent(robot) > _SMALL_ARM:
        near = near_ideal(robot)
    else:
        near = None
    if near is None or near.angle > _CALIBRATED[0]:
        return None
    if near.length <= (_CALIBRATED[1] if near.angle else INTENDED):
        return near.tolerance
    return None


@once
def near_ideal(robot: Robot) -> Near | None:
    """The ideal arm within `NEAR`, where it has structure that the arm misses; else None. Found once for an arm.

    Its tolerance is the smallest of two digits that finds all of it.
    """
    ideal, changes = square_up(robot, angle=NEAR, length=NEAR * extent(robot))
    gained = what_holds(ideal, robot)
    if not gained:
        return None
    length, twist, angle = (
        max((change.by for change in changes if change.kind in kinds), default=0.0)
        for kinds in (("distance", "offset"), ("twist",), ("twist", "angle", "base", "tip"))
    )
    far = length if length > meeting(robot) else None
    for wider, turn in product(_WIDER, dict.fromkeys((0.0, twist, angle))):
        tolerance = _wide(Tolerance(far, turn if turn > SQUARE else None), wider)
        near = _found_with(robot, tolerance, gained)
        if near is not None and near.length < (tolerance.length or 0.0) / 2:  # another number set it
            near = _found_with(robot, _wide(replace(tolerance, length=near.length), 1.0), gained) or near
        if near is not None:
            return near if near.tolerance.text else None  # else the arm is read as that one already
    return None


def _wide(given: Tolerance, factor: float) -> Tolerance:
    """A tolerance times a factor, rounded up to two digits."""
    if given.length is None:
        length = None
    else:
        length = _round_up(given.length * factor, 1e-3)
    return Tolerance(length, None if given.angle is None else _round_up(given.angle * factor, radians(1.0)))


def _found_with(robot: Robot, tolerance: Tolerance, gained: tuple[AxesHold, ...]) -> Near | None:
    if tolerance.angle is not None and tolerance.angle > _WIDEST:
        return None
    made, moved = square_up(robot, angle=tolerance.angle or SQUARE, length=tolerance.length)
    if what_holds(made, robot) != gained:
        return None
    length, angle = (max((x.by for x in moved if x.turns is turns), default=0.0) for turns in (False, True))
    return Near(gained, length if length > meeting(robot) else 0.0, angle if angle > SQUARE else 0.0, tolerance)


def what_holds(robot: Robot, less: Robot | None = None) -> tuple[AxesHold, ...]:
    """What holds between the axes, the most telling first.

    Args:
        robot: an arm of exact structure.
        less: what holds in this arm too is left out.
    """
    if less is not None:
        known = set(_holding(less))
    else:
        known = set()
    new = [fact for fact in _holding(robot) if fact not in known and not _follows(fact, known)]
    return tuple(_merge_facts(new, len(robot.joints)))


def _follows(fact: AxesHold, known: set[AxesHold]) -> bool:
    """Whether no offset along parallel axes is what each of them had without."""
    what, joints = fact
    return what is Hold.FLUSH and len(joints) > 1 and all(AxesHold(what, (joint,)) in known for joint in joints)


def _check(given: Tolerance, where: str) -> None:
    for name, value, unit in (("length", given.length, "m"), ("angle", given.angle, "rad")):
        if value is not None and not value > 0:
            raise OptionError(f"the {name} of a tolerance is positive", where=where, got=f"{value:g} {unit}")
    if given.angle is not None and given.angle > _WIDEST:
        raise OptionError(
            "the angle is too large", where=where, got=f"{degrees(given.angle):.3g}°", allowed="up to 5°: "
            "angles of an ideal arm are multiples of 15°",
        )  # fmt: skip


def _round_up(value: float, unit: float) -> float:
    """The next number of two digits above a value, in the unit."""
    share = value / unit * (1 + 1e-6)  # the value itself is inside
    power = 10.0 ** (floor(log10(share)) - 1)
    return float(f"{ceil(share / power) * power:.3g}") * unit


def _holding(robot: Robot) -> list[AxesHold]:
    """All that holds, each pair of axes by itself."""
    numbers = numbers_of(robot, angle=NOTHING, length=NOTHING)
    slides = [joint.slides for joint in robot.joints]
    return [*_points(numbers, slides), *_parallels(numbers, slides), *_pairs(numbers, slides)]


def _points(numbers: Sequence[LinkNumbers], slides: Sequence[bool]) -> Iterator[AxesHold]:
    """Three joints in a row that turn about axes through one point."""
    for i in range(len(numbers) - 2):
        if not any(slides[i : i + 3]) and _point(numbers, i):
            yield AxesHold(Hold.POINT, (i + 1, i + 2, i + 3))


def _parallels(numbers: Sequence[LinkNumbers], slides: Sequence[bool]) -> Iterator[AxesHold]:
    """Pairs of parallel axes in a row, and runs of them without an offset along them."""
    for run in parallel_runs(numbers):
        yield from (AxesHold(Hold.PARALLEL, (i + 1, j + 1)) for i, j in pairwise(run))
        inside = run[0] > 0 and run[-1] < len(numbers) - 1 and not any(slides[k] for k in run)
        if inside and abs(sum(offsets_along(numbers, run))) < NOTHING:
            yield AxesHold(Hold.FLUSH, tuple(k + 1 for k in run))


def _pairs(numbers: Sequence[LinkNumbers], slides: Sequence[bool]) -> Iterator[AxesHold]:
    """Pairs of axes in a row that are one line, meet, or stand at right angles."""
    for i, (axis, _) in enumerate(pairwise(numbers)):
        pair = (i + 1, i + 2)
        if abs(axis.a) < NOTHING and not slides[i] and not slides[i + 1]:
            yield AxesHold(Hold.COMMON if parallel(axis.twist) else Hold.MEETING, pair)
        if abs(abs(axis.twist) - pi / 2) < NOTHING:
            yield AxesHold(Hold.SQUARE, pair)


def _point(numbers: Sequence[LinkNumbers], i: int) -> bool:
    first, middle = numbers[i], numbers[i + 1]
    lengths = first.a, middle.d, middle.a
    return all(abs(x) < NOTHING for x in lengths) and not parallel(first.twist) and not parallel(middle.twist)


_ORDER = (Hold.PARALLEL, Hold.COMMON, Hold.MEETING, Hold.SQUARE, Hold.FLUSH)
"""Relations beyond axes in one point, the most telling first."""


def _merge_facts(facts: Sequence[AxesHold], n: int) -> list[AxesHold]:
    """Facts put together, without those that others imply.

    Args:
        facts: of pairs of axes, of three in one point, and of runs of parallel ones.
        n: number of joints.
    """
    points = [fact.joints for fact in facts if fact.what is Hold.POINT]
    names: dict[tuple[int, ...], Hold] = {(n - 2, n - 1, n): Hold.WRIST}
    if n > 3:
        names[1, 2, 3] = Hold.SHOULDER
    points.sort(key=lambda joints: (joints not in names, -joints[0]))
    merged = [AxesHold(names.get(joints, Hold.POINT), joints) for joints in points]
    within = _in_points(points)
    for what in _ORDER:
        alike = [fact.joints for fact in facts if fact.what is what]
        if what in (Hold.PARALLEL, Hold.COMMON):
            alike = _chain_pairs(alike)
        if what is not Hold.SQUARE:
            alike = [joints for joints in alike if joints not in within]
        merged += [AxesHold(what, joints) for joints in alike]
    return merged


def _in_points(points: Iterable[tuple[int, ...]]) -> set[tuple[int, ...]]:
    """Axes of which more is said already, of three axes in one point: pairs of them, and the one in the middle."""
    within: set[tuple[int, ...]] = set()
    for joints in points:
        within |= {*pairwise(joints), (joints[1],)}
    return within


def _chain_pairs(pairs: Sequence[tuple[int, ...]]) -> list[tuple[int, ...]]:
    neighbours: list[tuple[int, ...]] = []
    for pair in sorted(pairs):
        if neighbours and neighbours[-1][-1] == pair[0]:
            neighbours[-1] = (*neighbours[-1], *pair[1:])
        else:
            neighbours.append(pair)
    return neighbours
