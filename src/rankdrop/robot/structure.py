"""The arm that a noisy one is meant to be: axes exactly parallel, at right angles, meeting, where they nearly are.

A file's numbers carry the noise of the program that wrote them: twists of 90.0004°, axes that miss each other by a
fraction of a micrometre. `squared` rebuilds an arm without it, from the base on: first the pose of every link in the
one before, then, where the links' own frames say nothing, Denavit and Hartenberg's numbers between consecutive axes.
Lengths are worked out about the axes that were squared, so that a twist that is mended leaves no offset behind.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import atan2, pi

import numpy as np

from rankdrop.robot.model import Array, Joint, JointKind, Robot
from rankdrop.robot.normals import Line, Normal, axis_lines, common_normals, frame_at
from rankdrop.robot.squaring import STEP, exact_angle, exact_direction, exact_rotation, tidy
from rankdrop.robot.transform import rotation, translation
from rankdrop.tolerances import MEETING, NOTHING, SQUARE

_SAME = 1e-13
"""Rebuilt numbers that differ by no more are the arm's own [1, m]: the rounding of a chain of products."""
ORDINARY = (0.03, 30.0)
"""Sizes of arms [m] for which `MEETING` is meant; beyond them it goes with the arm, which then is in other units."""


@dataclass(frozen=True, slots=True)
class Change:
    """One number of the chain that was made exact.

    Attributes:
        kind: "twist" (angle from one axis to the next), "angle" (about an axis, from one common normal to the next),
            "distance" (between two axes along their normal), "offset" (along an axis, between two normals), "base" and
            "tip" (how far the first axis is turned in the base, the tip in the last link; 0 after).
        joints: numbers from 1 in the chain, mimic joints counted: the two joints of a twist or a distance, the one of
            all else.
        before, after: its value [rad, m].
    """

    kind: str
    joints: tuple[int, ...]
    before: float
    after: float

    @property
    def by(self) -> float:
        """How far it was moved [rad, m]; 180° and −180° are the same."""
        by = self.after - self.before
        return abs(_wrapped(by) if self.turns else by)

    @property
    def turns(self) -> bool:
        """Whether it is an angle."""
        return self.kind not in ("distance", "offset")


@dataclass(frozen=True, slots=True)
class _Numbers:
    """Denavit and Hartenberg's numbers of one joint and the link after it."""

    phase: float  # [rad]
    d: float  # [m]
    a: float  # [m]
    twist: float  # [rad]


def squared(robot: Robot, *, angle: float = SQUARE, length: float | None = None) -> tuple[Robot, tuple[Change, ...]]:
    """The arm whose structure holds exactly where it holds to small tolerances.

    Twists and the angles between common normals become multiples of 15°, distances and offsets zero, also those that
    cancel along parallel axes. What is left is kept; limits, names, velocities, mimic relations and notes are too.

    Args:
        robot: any arm.
        angle: how exact an angle has to be [rad]. Every axis turns against the one before by no more.
        length: how exact a length has to be [m]; None is 2 µm, for arms of 3 cm to 30 m.

    Returns:
        (arm, changes by more than a nanometre or a billionth of a radian). The arm is `robot` itself where no number
        changes by more than rounding. Applied again it changes nothing.

    Example:
        >>> from rankdrop.robot.dh import from_dh
        >>> noisy = from_dh([(0.4, 1.5708, 0, 0), (0.4, 0, 1e-6, 0), (0.2, 0, 0, 0)], convention="standard")
        >>> arm, changes = squared(noisy)
        >>> arm.joints[2].screw[3:], [change.kind for change in changes]
        (array([ 0., -1.,  0.]), ['twist', 'offset'])
    """
    limit = meeting(robot) if length is None else length
    framed = _frames_squared(robot, angle)
    found = _sections_squared(framed, angle, limit)
    if _same(robot, found):
        return robot, ()
    return found, _changes(robot, found, angle, limit)


def meeting(robot: Robot) -> float:
    """How near axes have to come to meet [m]: `MEETING`, in proportion for an arm in other units than metres."""
    size = extent(robot)
    low, high = ORDINARY
    return MEETING * (size / low if size < low else max(size / high, 1.0))


def extent(robot: Robot) -> float:
    """Sum of the distances between the points where consecutive links are joined, and to the tip [m]; 1 if zero."""
    points = [line.point for line in _points(robot)] + [robot.home[:3, 3]]
    total = float(sum(np.linalg.norm(two - one) for one, two in pairwise(points)))
    return total if total > NOTHING**2 else 1.0


def _points(robot: Robot) -> list[Line]:
    lines = axis_lines(robot, length=0.0)
    return [
        Line(line.direction, line.point + line.direction * float((joint.frame[:3, 3] - line.point) @ line.direction))
        for line, joint in zip(lines, robot.joints, strict=True)
    ]


def _frames_squared(robot: Robot, angle: float) -> Robot:
    """Every link's pose in the one before, and every axis in its link, made exact."""
    old, new = np.eye(4), np.eye(4)
    joints = []
    for joint in robot.joints:
        after_old = np.asarray(joint.frame)
        after_new = new @ _pose_squared(np.linalg.inv(old) @ after_old, angle)
        screw = _screw_squared(joint, (old, new), (after_old, after_new), angle)
        joints.append(replace(joint, screw=screw, frame=after_new))
        old, new = after_old, after_new
    home = new @ _pose_squared(np.linalg.inv(old) @ robot.home, angle)
    return replace(robot, joints=tuple(joints), home=home)


def _pose_squared(pose: Array, angle: float) -> Array:
    found = np.eye(4)
    found[:3, :3] = exact_rotation(pose[:3, :3], angle)
    found[:3, 3] = tidy(pose[:3, 3])
    return found


def _screw_squared(joint: Joint, before: tuple[Array, Array], after: tuple[Array, Array], angle: float) -> Array:
    """The screw in the frame of whichever link's origin is nearer to the axis, made exact there, back in the base."""
    own = [_in_frame(joint.screw, old) for old, _ in (after, before)]
    use = 0 if joint.kind is JointKind.PRISMATIC or _miss(own[0]) <= _miss(own[1]) + NOTHING else 1
    frame = (after, before)[use][1]
    direction, point, pitch = _line_of(own[use], joint.kind)
    axis, point = frame[:3, :3] @ exact_direction(direction, angle), frame[:3, :3] @ tidy(point) + frame[:3, 3]
    return _screw(joint.kind, axis, point, pitch)


def _in_frame(screw: Array, frame: Array) -> Array:
    turn, origin = frame[:3, :3], frame[:3, 3]
    return np.concatenate([turn.T @ (screw[:3] - np.cross(origin, screw[3:])), turn.T @ screw[3:]])


def _miss(screw: Array) -> float:
    return float(np.linalg.norm(np.cross(screw[3:], screw[:3])))


def _line_of(screw: Array, kind: JointKind) -> tuple[Array, Array, float]:
    """Direction, the point nearest to the origin, pitch."""
    if kind is JointKind.PRISMATIC:
        return screw[:3], np.zeros(3), 0.0
    pitch = float(screw[:3] @ screw[3:]) if kind is JointKind.HELICAL else 0.0
    return screw[3:], np.cross(screw[3:], screw[:3]), pitch


def _screw(kind: JointKind, direction: Array, point: Array, pitch: float) -> Array:
    if kind is JointKind.PRISMATIC:
        return np.concatenate([direction, np.zeros(3)]) + 0.0
    return np.concatenate([np.cross(point, direction) + pitch * direction, direction]) + 0.0  # + 0.0 turns −0 into 0


def _sections_squared(robot: Robot, angle: float, length: float) -> Robot:
    """Denavit and Hartenberg's numbers made exact, and the arm built of them again where that changes one."""
    lines = axis_lines(robot, length=length)
    normals = common_normals(robot, lines, angle=angle, length=length)
    given = _numbers(lines, normals)
    made = [_exact(one, angle, length) for one in given]
    made = _cancelled(made, [joint.kind is JointKind.PRISMATIC for joint in robot.joints], length)
    if all(_near(one, other) for one, other in zip(given, made, strict=True)):
        return robot
    old = frame_at(normals[0].direction, lines[0].direction, normals[0].far)
    pose = old.copy()
    joints = []
    for i, (joint, numbers) in enumerate(zip(robot.joints, made, strict=True)):
        pose = pose @ rotation("z", numbers.phase) @ translation(0.0, 0.0, numbers.d)
        after = frame_at(normals[i + 1].direction, lines[i].direction, normals[i + 1].near)
        moved = pose @ np.linalg.inv(after)
        screw = _screw(joint.kind, pose[:3, 2], pose[:3, 3], _line_of(joint.screw, joint.kind)[2])
        joints.append(replace(joint, screw=screw, frame=moved @ joint.frame))
        pose = pose @ translation(numbers.a, 0.0, 0.0) @ rotation("x", numbers.twist)
    return replace(robot, joints=tuple(joints), home=moved @ robot.home)


def _numbers(lines: Sequence[Line], normals: Sequence[Normal]) -> list[_Numbers]:
    """Denavit and Hartenberg's numbers, the link after the last joint without length and twist."""
    found = []
    for i, line in enumerate(lines):
        before, after, z = normals[i], normals[i + 1], line.direction
        phase = _turn(before.direction, after.direction, z)
        d = float((after.near - before.far) @ z)
        a = twist = 0.0
        if i + 1 < len(lines):
            twist = _turn(z, lines[i + 1].direction, after.direction)
            a = float((after.far - after.near) @ after.direction)
        found.append(_Numbers(phase, d, a, twist))
    return found


def _turn(one: Array, two: Array, about: Array) -> float:
    return atan2(float(np.cross(one, two) @ about), float(one @ two))


def _exact(given: _Numbers, angle: float, length: float) -> _Numbers:
    d, a = (0.0 if abs(x) <= length else float(tidy(np.array(x))) for x in (given.d, given.a))
    return _Numbers(exact_angle(given.phase, angle), d, a, exact_angle(given.twist, angle))


def _cancelled(made: Sequence[_Numbers], slides: Sequence[bool], length: float) -> list[_Numbers]:
    """Offsets along parallel axes add up; where they cancel but for `length`, they cancel exactly."""
    found = list(made)
    for run in _parallel_runs(found):
        if run[0] == 0 or run[-1] == len(found) - 1 or any(slides[k] for k in run):
            continue  # no normal before the first axis and after the last; the offset of a slide is a variable
        signs = [1.0]
        for k in run[:-1]:
            signs.append(signs[-1] * (1.0 if abs(found[k].twist) < 1.0 else -1.0))
        along = [sign * found[k].d for sign, k in zip(signs, run, strict=True)]
        if 0.0 < abs(sum(along)) <= length:
            last = max(i for i, d in enumerate(along) if d != 0.0)
            rest = sum(along[:last])
            found[run[last]] = replace(found[run[last]], d=-signs[last] * rest)
    return found


def _parallel_runs(made: Sequence[_Numbers]) -> list[list[int]]:
    """Indices of axes, parted where two that follow each other are not exactly parallel."""
    runs = [[0]]
    for i, one in enumerate(made[:-1]):
        if _parallel(one.twist):
            runs[-1].append(i + 1)
        else:
            runs.append([i + 1])
    return runs


def _parallel(twist: float) -> bool:
    return round(twist / STEP) % 12 == 0 and twist == round(twist / STEP) * STEP


def _near(one: _Numbers, other: _Numbers) -> bool:
    turns = one.phase - other.phase, one.twist - other.twist
    return all(abs(x) <= _SAME for x in (*map(_wrapped, turns), one.d - other.d, one.a - other.a))


def _wrapped(angle: float) -> float:
    return (angle + pi) % (2 * pi) - pi


def _same(one: Robot, two: Robot) -> bool:
    pairs = [(one.home, two.home)]
    for mine, other in zip(one.joints, two.joints, strict=True):
        pairs += [(mine.screw, other.screw), (mine.frame, other.frame)]
    return all(float(np.abs(x - y).max()) <= _SAME * max(1.0, float(np.abs(x).max())) for x, y in pairs)


def _changes(old: Robot, new: Robot, angle: float, length: float) -> tuple[Change, ...]:
    """What the chain's numbers were and became. Both are told about normals chosen alike."""
    lines, others = axis_lines(old, length=length), axis_lines(new, length=length)
    before = _numbers(lines, common_normals(old, lines, angle=angle, length=length))
    after = _numbers(others, common_normals(new, others, angle=angle, length=length))
    first, last = (_apart(x, y) for x, y in zip(_ends(old, lines), _ends(new, others), strict=True))
    ends = [Change("base", (1,), first, 0.0), Change("tip", (len(lines),), last, 0.0)]
    return (*_differences(before, after), *(change for change in ends if change.by > NOTHING))


def _differences(before: Sequence[_Numbers], after: Sequence[_Numbers]) -> Iterable[Change]:
    for number, (one, other) in enumerate(zip(before, after, strict=True), start=1):
        for kind, joints, x, y in (
            ("angle", (number,), one.phase, other.phase),
            ("offset", (number,), one.d, other.d),
            ("distance", (number, number + 1), one.a, other.a),
            ("twist", (number, number + 1), one.twist, other.twist),
        ):
            change = Change(kind, joints, x, y)
            if change.by > NOTHING:
                yield change


def _ends(robot: Robot, lines: Sequence[Line]) -> tuple[Array, Array]:
    """Direction of the first axis in the base, axes of the tip in the last link (its frame)."""
    return lines[0].direction, robot.joints[-1].frame[:3, :3].T @ robot.home[:3, :3]


def _apart(one: Array, two: Array) -> float:
    """Angle between two directions or two rotations that are near [rad]."""
    return float(np.linalg.norm(one - two)) / (np.sqrt(2.0) if one.ndim == 2 else 1.0)
