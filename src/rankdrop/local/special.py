"""The part of the arm that is special at a singular configuration: shoulder, elbow or wrist, as facts.

Each part has one condition, measured as an angle that is 0 where the condition holds exactly:

- wrist: the directions of the last three axes lie in one plane; the middle joint of the three is at 0 or π from it;
- elbow: the arm is stretched or folded; the angle at the elbow axis between shoulder point S and wrist point W, which
  is the tip for a task without rotation; or the axes before and behind the elbow are one line; an arm of slides with a
  wrist has none;
- shoulder: W lies in the plane through axis 1 along axis 2 (distance to the plane over the distance of W from axis 2);
  with seven axes, the directions of the first three lie in one plane.

Of more than seven axes the last seven are the arm, and those before are the base that carries it.

An arm of ideal geometry satisfies such a condition exactly. An arm with offsets has one long condition instead, whose
sheets pass near those of the ideal arm: the smallest angle says which sheet is at hand. `text/special.py` words it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from math import atan2, pi, sqrt

import numpy as np

from rankdrop.local.axes import Scene
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.robot.model import Array, JointKind, Robot, once
from rankdrop.robot.numbers import wrap_angle
from rankdrop.task import Task

Vector = tuple[float, float, float]

EXACT = 1e-6
"""An angle up to this is 0 [rad]."""
ARM_AXES = 7
"""Axes of an arm with three in the shoulder, one in the elbow and three in the wrist; more are of a base."""
_STRUCTURE = 3  # random configurations; what holds at all of them says nothing about one
_COSTS = 1e-7  # σ_r above it: no rank is lost
_SAMPLES, _HALVED = 25, 60  # values of a joint between which the wrist passes above axis 1, and halvings of an interval
_FLAT = 1e-9  # shorter projections have no direction, as shares of the reach


class Part(StrEnum):
    """A part of the arm, from the base outwards."""

    SHOULDER = "shoulder"
    ELBOW = "elbow"
    WRIST = "wrist"


class Shape(StrEnum):
    """What is special about a part: a joint at a value, the arm stretched or folded, the wrist in the plane through
    axis 1 along axis 2, or on axis 2; the tip in its place for a task without rotation."""

    JOINT = "joint"
    STRETCHED = "stretched"
    FOLDED = "folded"
    ABOVE_AXIS = "above-axis"
    ON_AXIS = "on-axis"
    TIP_ABOVE_AXIS = "tip-above-axis"
    TIP_ON_AXIS = "tip-on-axis"


@dataclass(frozen=True, slots=True)
class Special:
    """One part of the arm and what is special about it.

    Attributes:
        part, shape: the part, and its condition.
        joint: from 1, the joint that measures the condition; the axis of shapes that name one.
        value: of that joint where the condition holds exactly, the nearest one [rad].
        off: how far the configuration is from the condition, in [0, π/2] [rad].
        exact: `off` is 0 to 1e-6.
    """

    part: Part
    shape: Shape
    joint: int
    value: float
    off: float
    exact: bool


ON_JOINTS = (Shape.JOINT, Shape.STRETCHED, Shape.FOLDED)
"""Shapes where one joint has a value."""


def specials_at(robot: Robot, task: Task, q: Array, corank: int) -> tuple[Special, ...]:
    """The parts of the arm that are special at a singular configuration.

    They are all with an exact condition, else those nearest to their conditions, as many as rank is lost. Where more
    conditions hold than rank is lost, those that cost this arm no rank are left out: with five joints a wrist above
    axis 1 still has all its motions.

    Args:
        robot: the arm.
        task: the rows that matter; without rotation the wrist does not, without translation only joints do.
        q: (n,) singular configuration [rad, m].
        corank: at q.

    Returns:
        From the base outwards; empty for an arm with fewer than two axes.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("ur5e")
        >>> found = specials_at(arm, resolve_task(None, arm), np.array([0.0, -1.0, 1.0, 0.5, 0.0, 0.0]), 1)
        >>> [(one.part.value, one.joint, one.exact) for one in found]
        [('wrist', 5, True)]
    """
    specials = measured_at(robot, task, q)
    exact = [special for special in specials if special.exact]
    if len(exact) > max(corank, 1):
        free = _without_cost(robot, task)
        costly = [special for special in exact if (special.part, special.joint) not in free]
        if len(costly) >= max(corank, 1):
            exact = costly
    chosen = exact or sorted(specials, key=lambda special: special.off)[: max(corank, 1)]
    order = [*Part]
    return tuple(sorted(chosen, key=lambda special: order.index(special.part)))


def exact_at(robot: Robot, task: Task, q: Array) -> list[Special]:
    """All conditions that hold at q (n,), those too that cost this arm no rank by themselves."""
    return [special for special in measured_at(robot, task, q) if special.exact]


def measured_at(robot: Robot, task: Task, q: Array) -> list[Special]:
    """Conditions of the arm, measured at q (n,), but for those that hold everywhere, and those that slides make up for
    and that do not hold here.
    """
    turns, moves = bool({3, 4, 5} & set(task.rows)), bool({0, 1, 2} & set(task.rows))
    left_out = _always(robot, turns, moves)
    candidates = _candidates(robot, q, turns, moves)
    found = [special for special in candidates if (special.part, special.joint) not in left_out]
    if not any(joint.kind is JointKind.PRISMATIC for joint in robot.variables):
        return found
    free = _without_cost(robot, task)
    kept = []
    for special in found:
        if special.exact or special.shape is Shape.JOINT or (special.part, special.joint) not in free:
            kept.append(special)
    return kept


@once
def _always(robot: Robot, turns: bool, moves: bool) -> frozenset[tuple[Part, int]]:
    """Conditions that hold at every configuration."""
    draws = np.random.default_rng(3).uniform(-pi, pi, (_STRUCTURE, robot.n))
    seen = []
    for q in draws:
        exact = (special for special in _candidates(robot, q, turns, moves) if special.exact)
        seen.append({(special.part, special.joint) for special in exact})
    return frozenset(set.intersection(*seen))


@once
def _without_cost(robot: Robot, task: Task) -> frozenset[tuple[Part, int]]:
    """Conditions that lose no rank where they hold alone, at a random configuration moved onto them."""
    turns, moves = bool({3, 4, 5} & set(task.rows)), bool({0, 1, 2} & set(task.rows))
    rank = generic_rank(robot, task)
    free: set[tuple[Part, int]] = set()
    for q in np.random.default_rng(4).uniform(-2.0, 2.0, (_STRUCTURE, robot.n)):
        for special in _candidates(robot, q, turns, moves):
            if special.shape in (Shape.ABOVE_AXIS, Shape.TIP_ABOVE_AXIS):
                place = _moved_above_axis(robot, q, turns)
            else:
                place = q.copy()
                place[special.joint - 1] = special.value
            if place is not None and singular_values(robot, place, task)[rank - 1] > _COSTS:
                free.add((special.part, special.joint))
    return frozenset(free)


def _moved_above_axis(robot: Robot, q: Array, turns: bool) -> Array | None:
    """(n,) q with the joint of axis 2 or 3 moved so that the wrist is above axis 1; None where neither does it."""
    for axis in (1, 2):
        joint = Scene(robot, q[None]).axes[axis]

        def gap(value: float, joint: int = joint) -> float:
            place = q.copy()
            place[joint] = value
            scene = Scene(robot, place[None])
            return _axes_of(scene, turns).from_shoulder_plane(_vector(scene.tip[0].tolist()))[0]

        values = np.linspace(-pi, pi, _SAMPLES)
        gaps = np.array([gap(value) for value in values])
        changes = np.flatnonzero(gaps[:-1] * gaps[1:] < 0)
        if len(changes):
            low, high = values[changes[0]], values[changes[0] + 1]
            for _ in range(_HALVED):
                middle = (low + high) / 2
                if gap(low) * gap(middle) <= 0:
                    high = middle
                else:
                    low = middle
            place = q.copy()
            place[joint] = low
            return place
    return None


def _triples(count: int, turns: bool, sliding: bool) -> list[tuple[Part, int]]:
    """Parts that are three axes in a row, with the middle one, of an arm of so many axes.

    The wrist counts where the task turns, with five axes or more, or with three where slides carry it.
    """
    triples = []
    if sliding or (turns and count >= 5):
        triples.append((Part.WRIST, count - 2))
    if count >= ARM_AXES:
        triples.append((Part.SHOULDER, count - ARM_AXES + 1))
    return triples


def _candidates(robot: Robot, q: Array, turns: bool, moves: bool) -> Iterator[Special]:
    """Every condition of the arm, measured at q (n,); `turns`, `moves`: rotation and translation matter."""
    scene = Scene.at(robot, q)
    axes = scene.axes
    if len(axes) < 2:
        return
    arm = _axes_of(scene, turns)
    joints, values = [i + 1 for i in axes], q[list(axes)].tolist()
    tip = _vector(scene.tip[0].tolist())
    sliding = turns and len(axes) < robot.n and arm.is_carried_wrist
    crossed = not _parallel(arm.z[0], arm.z[1])
    if not sliding and not (crossed and len(axes) == 2):  # a pan-tilt has no elbow
        yield from _elbow(arm, joints[arm.elbow], values[arm.elbow], tip, turns, moves)
    for part, middle in _triples(len(axes), turns, sliding):
        turn = arm.turn(middle)
        if turn is not None:
            yield _condition_missed_by(part, Shape.JOINT, joints[middle], values[middle], turn)
    least = 4 if turns or len(axes) < robot.n else 2  # two or three joints place a tip, and turn nothing on purpose
    if moves and least <= len(axes) <= 6 and crossed:
        yield _shoulder(arm, joints, tip)


def _axes_of(scene: Scene, turns: bool) -> _Axes:
    """The axes of the one configuration of a scene; `turns`: rotation matters."""
    axes = list(scene.axes)
    tip = None if turns else _vector(scene.tip[0].tolist())
    points = [_vector(row) for row in scene.p[axes, 0].tolist()]
    return _Axes([_vector(row) for row in scene.z[axes, 0].tolist()], points, tip, scene.length)


def _elbow(arm: _Axes, joint: int, value: float, tip: Vector, turns: bool, moves: bool) -> Iterator[Special]:
    """The condition of the elbow, which this joint measures; none where an upper arm or forearm has no length."""
    if turns and arm.aligned(arm.elbow - 1, arm.elbow + 1):
        yield Special(Part.ELBOW, Shape.JOINT, joint, wrap_angle(value), 0.0, exact=True)
    elif moves and (turn := arm.elbow_turn(tip)) is not None:
        shape = Shape.STRETCHED if abs(turn) <= pi / 2 else Shape.FOLDED
        yield _condition_missed_by(Part.ELBOW, shape, joint, value, turn)


def _shoulder(arm: _Axes, joints: list[int], tip: Vector) -> Special:
    """The condition of the shoulder: the wrist in the plane through axis 1 along axis 2, or on axis 2."""
    if arm.tip is None:
        above, on = Shape.ABOVE_AXIS, Shape.ON_AXIS
    else:
        above, on = Shape.TIP_ABOVE_AXIS, Shape.TIP_ON_AXIS
    signed, lever = arm.from_shoulder_plane(tip)
    gap = abs(signed)
    exact = gap <= EXACT * arm.reach
    if exact and lever <= EXACT * arm.reach:
        return Special(Part.SHOULDER, on, joints[1], 0.0, 0.0, exact)
    off = atan2(gap, max(lever, _FLAT * arm.reach))
    return Special(Part.SHOULDER, above, joints[0], 0.0, off, exact)


def _condition_missed_by(part: Part, shape: Shape, joint: int, value: float, turn: float) -> Special:
    """A condition of one joint that its angle misses by `turn` modulo π."""
    off = turn - pi * round(turn / pi)
    return Special(part, shape, joint, wrap_angle(value - off), abs(off), abs(off) <= EXACT)


@dataclass(frozen=True, slots=True)
class _Axes:
    """The axes of an arm at one configuration, from the base outwards.

    Attributes:
        z: unit directions.
        p: a point on each [m].
        tip: where the tip plays the part of the wrist, its position [m]; else None.
        reach: of the arm [m].
    """

    z: list[Vector]
    p: list[Vector]
    tip: Vector | None
    reach: float

    @property
    def elbow(self) -> int:
        """Number from 0 of the elbow among the axes: second of two and in a planar arm, fourth of the last seven, else
        third.
        """
        if len(self.z) >= ARM_AXES:
            return len(self.z) - 4
        if len(self.z) <= 2 or _parallel(self.z[0], self.z[1]):
            return 1
        return 2

    @property
    def is_carried_wrist(self) -> bool:
        """Whether the last three of at most five axes meet in a point, as a wrist that slides carry; not in a plane."""
        count = len(self.z)
        if not 3 <= count < ARM_AXES - 1:
            return False
        first, middle, last = count - 3, count - 2, count - 1
        if _parallel(self.z[first], self.z[middle]) or _parallel(self.z[middle], self.z[last]):
            return False
        apart = _less(self.middle_between(middle, last), self.middle_between(first, middle))
        return _length(apart) <= EXACT * self.reach

    def aligned(self, i: int, j: int) -> bool:
        """Whether two axes are one line; False where there is no second."""
        if j >= len(self.z) or not _parallel(self.z[i], self.z[j]):
            return False
        return _length(_normal_part(_less(self.p[j], self.p[i]), self.z[i])) <= EXACT * self.reach

    def elbow_turn(self, tip: Vector) -> float | None:
        """Angle from the upper arm to the forearm about the elbow axis [rad]; None where one has no length there."""
        elbow = self.elbow
        axis, at = self.z[elbow], self.p[elbow]
        parallel = _parallel(self.z[elbow - 1], axis)
        if parallel:
            start = self.p[elbow - 1]
        else:
            start = self.middle_between(max(elbow - 2, 0), elbow - 1)
        upper, lower = _normal_part(_less(at, start), axis), _normal_part(_less(self.wrist_point(tip), at), axis)
        if min(_length(upper), _length(lower)) <= _FLAT * self.reach:
            return None
        return _angle(upper, lower, axis)

    def turn(self, middle: int) -> float | None:
        """Angle between two axes about the one between them [rad]; None where one is parallel to that."""
        axis = self.z[middle]
        first, last = _normal_part(self.z[middle - 1], axis), _normal_part(self.z[middle + 1], axis)
        if min(_length(first), _length(last)) < EXACT:
            return None
        return _angle(first, last, axis)

    def from_shoulder_plane(self, tip: Vector) -> tuple[float, float]:
        """Distances of the wrist from the plane through axis 1 along axis 2, with a sign, and from axis 2 [m]."""
        bundle = len(self.z) == 6 and _parallel(self.z[self.elbow], self.z[self.elbow + 1])
        if bundle and self.tip is None:
            point = self.middle_between(4, 5)
        else:
            point = self.wrist_point(tip)
        normal = _cross(self.z[0], self.z[1])
        gap = _dot(_less(point, self.p[0]), normal) / _length(normal)
        return gap, _length(_normal_part(_less(point, self.p[1]), self.z[1]))

    def wrist_point(self, tip: Vector) -> Vector:
        """The point that the axes behind the elbow turn about; the tip where there is none."""
        after = self.elbow + 1
        if self.tip is not None:
            return self.tip
        if after < len(self.z) and _parallel(self.z[after - 1], self.z[after]):
            return self.p[after]
        if after >= len(self.z) - 1:
            return tip
        first = max(after, len(self.z) - 3)
        return self.middle_between(first, first + 1)

    def middle_between(self, i: int, j: int) -> Vector:
        """Middle of the common perpendicular of two axes; a point on the second where they are parallel."""
        skew = _cross(self.z[i], self.z[j])
        square = _dot(skew, skew)
        if square < EXACT:
            return self.p[j]
        apart = _less(self.p[j], self.p[i])
        special = _dot(_cross(apart, self.z[j]), skew) / square
        t = _dot(_cross(apart, self.z[i]), skew) / square
        a, b = (_plus(self.p[k], self.z[k], along) for k, along in ((i, special), (j, t)))
        return ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2)


# Vectors as tuples: of three numbers they take a tenth of the time of arrays.


def _vector(row: list[float]) -> Vector:
    return row[0], row[1], row[2]


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _plus(a: Vector, b: Vector, times: float) -> Vector:
    return a[0] + times * b[0], a[1] + times * b[1], a[2] + times * b[2]


def _less(a: Vector, b: Vector) -> Vector:
    return _plus(a, b, -1.0)


def _length(a: Vector) -> float:
    return sqrt(_dot(a, a))


def _parallel(a: Vector, b: Vector) -> bool:
    return _length(_cross(a, b)) < EXACT


def _normal_part(vector: Vector, axis: Vector) -> Vector:
    """The part of a vector that is normal to an axis."""
    return _plus(vector, axis, -_dot(axis, vector))


def _angle(a: Vector, b: Vector, axis: Vector) -> float:
    """From a to b about an axis that is normal to both, in (−π, π] [rad]."""
    return atan2(_dot(_cross(a, b), axis), _dot(a, b))
