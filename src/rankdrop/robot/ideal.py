"""Ideal arms: the one that a file means, the nearest one to a tolerance, and whether there is one to name.

A file's numbers carry the noise of the program that wrote them: twists of 90.0004°, axes that miss each other by a
fraction of a micrometre. `squared` rebuilds an arm without it, axes exactly parallel, at right angles or meeting where
they nearly are, from the base on: first the pose of every link in the one before, exact angles and tidy lengths; then,
where the links' own frames say nothing, Denavit and Hartenberg's numbers between consecutive axes. Lengths are worked
out about the axes that were squared, so that a twist that is mended leaves no offset behind. `as_intended` is the last
step of every reader; `ideal` takes tolerances that the user names.
"""

from __future__ import annotations

import re
import weakref
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from math import atan2, ceil, degrees, floor, log10, pi, radians

import numpy as np

from rankdrop.errors import OptionError
from rankdrop.robot.files import LONGEST_TEXT
from rankdrop.robot.model import Array, Joint, JointKind, Robot
from rankdrop.robot.numbers import (
    Change,
    Numbers,
    along,
    apart,
    astray,
    axis_lines,
    between,
    changes_between,
    common_normals,
    extent,
    frame_at,
    numbers_of,
    parallel,
    parallel_runs,
)
from rankdrop.robot.quantities import Angles, count
from rankdrop.robot.transform import cos_sin, dot, inverse, nearest_rotation, norm, rotation, times, translation
from rankdrop.tolerances import MEETING, NOTHING, SQUARE

STEP = pi / 12
"""Angles between parts of an arm are multiples of 15°, or nothing is known of them."""


def step_for(angle: float) -> float:
    """Angles are multiples of this to a tolerance [rad]: of 15° but for noise, of 90° where more is forgiven.

    One of 7 angles is a multiple of 15° to 1°: that would be chance.
    """
    return STEP if angle <= SQUARE else pi / 2


def exact_angle(value: float, angle: float, step: float = STEP) -> float:
    """The multiple of a step, of 15°, that is within `angle` of a value, else the value itself [rad]."""
    nearest = round(value / step) * step
    return nearest if abs(value - nearest) <= angle else value


def exact_rotation(turn: Array, angle: float) -> Array:
    """(3, 3) the rotation by a multiple of `step_for(angle)` near one to `angle`, else the nearest rotation.

    Rotations by quarter turns about coordinate axes, and those times one by 15°, 30° … about a coordinate axis: they
    have one entry of ±1. Every direction moves by at most `angle`.
    """
    step = step_for(angle)
    row, column = np.unravel_index(int(np.argmax(np.abs(turn))), (3, 3))
    rows, columns = [(row + k) % 3 for k in (1, 2)], [(column + k) % 3 for k in (1, 2)]
    sign = float(np.sign(turn[row, column]))
    block = turn[np.ix_(rows, columns)]
    # det(turn) = sign · det(block), so the block is a rotation or one with its last column reversed
    nearest = round(atan2(block[1, 0] - sign * block[0, 1], block[0, 0] + sign * block[1, 1]) / step)
    c, s = cos_sin(nearest * step)
    found = np.zeros((3, 3))
    found[row, column] = sign
    found[np.ix_(rows, columns)] = [[c, -sign * s], [s, sign * c]]
    return found if apart(found, turn) <= angle else nearest_rotation(turn)


def exact_direction(direction: Array, angle: float) -> Array:
    """(3,) the direction in a coordinate plane, at a multiple of `step_for(angle)`, near one; else that one."""
    step = step_for(angle)
    out = int(np.argmin(np.abs(direction)))
    i, j = (out + 1) % 3, (out + 2) % 3
    c, s = cos_sin(round(atan2(direction[j], direction[i]) / step) * step)
    found = np.zeros(3)
    found[i], found[j] = c, s
    return found if norm(found - direction) <= angle else direction


def tidy(lengths: Array, unit: float = 1.0) -> Array:
    """Lengths that are a whole number of micrometres to a nanometre are that: 0.240000000000178 m is 0.24.

    Args:
        lengths: in any unit.
        unit: a power of 1000: a metre in it.
    """
    step = 1e6 / unit  # a whole number, or what it divides: 0.24 comes out as it is written
    whole = np.rint(lengths * step) / step
    return np.asarray(np.where(np.abs(lengths - whole) < NOTHING * unit, whole, lengths)) + 0.0


_SAME = 1e-13
"""Rebuilt numbers that differ by no more are the arm's own [1, m]: the rounding of a chain of products."""
_PASSES = 5
"""Making the axes exact may leave a frame that is exact but for noise, and the other way round; two are enough."""
ORDINARY = (0.03, 30.0)
"""Sizes of arms [m]: three decades, so that every arm is of this size in just one of km, m, mm and µm."""


def squared(robot: Robot, *, angle: float = SQUARE, length: float | None = None) -> tuple[Robot, tuple[Change, ...]]:
    """The arm whose structure holds exactly where it holds to small tolerances.

    Twists and the angles between common normals become multiples of 15° (with a wider tolerance for angles than that of
    noise: the latter of 90°, since more would be chance), distances and offsets zero, also those that
    cancel along parallel axes. What is left is kept; limits, names, velocities, mimic relations and notes are too.

    Args:
        robot: any arm.
        angle: how exact an angle has to be [rad]; between the tip and the last link never less than 2e-5.
        length: how exact a length has to be [m]; None is 2 µm, also of an arm whose numbers are millimetres.

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
    found = robot
    for _ in range(_PASSES):
        before, found = found, _sections_squared(_frames_squared(found, angle), angle, limit)
        if _have_same_home(before, found):
            found = before
            break
    if _have_same_home(robot, found):
        return robot, ()
    return found, changes_between(robot, found, angle=angle, length=limit)


def meeting(robot: Robot) -> float:
    """How near axes have to come to meet: `MEETING` in the unit of length in which the arm is of `ORDINARY` size."""
    return MEETING * _unit(robot)


def _unit(robot: Robot) -> float:
    """1 for an arm in metres, 1000 for one whose numbers are millimetres: a power of 1000."""
    size, (low, high) = extent(robot), ORDINARY
    power = 0
    while size > high * 1000.0**power:
        power += 1
    while 0.0 < size <= low * 1000.0**power:
        power -= 1
    return float(1000.0**power)


_Frame = tuple[Array, Array, bool]  # as given, as made, whether it is far from the arm


def _frames_squared(robot: Robot, angle: float) -> Robot:
    """Every link's pose in the one before, and every axis in its link, made exact.

    Frames far from the arm are carried along as they are: a small turn of them would be a long way of the axes.
    """
    old, new, stray, unit = np.eye(4), np.eye(4), False, _unit(robot)
    joints = []
    for joint, far in zip(robot.joints, astray(robot), strict=True):
        after_old = np.asarray(joint.frame)
        after_new = times(new, _pose_squared(times(inverse(old), after_old), unit, 0.0 if far or stray else angle))
        screw = _screw_squared(joint, (old, new, stray), (after_old, after_new, far), unit, angle)
        joints.append(replace(joint, screw=screw, frame=after_new))
        old, new, stray = after_old, after_new, far
    home = times(new, _pose_squared(times(inverse(old), robot.home), unit, 0.0 if stray else min(angle, SQUARE)))
    return replace(robot, joints=tuple(joints), home=home)


def _pose_squared(pose: Array, unit: float, angle: float, length: float = 0.0) -> Array:
    """Pose of one frame in another, rotation exact; parts of the way up to `length` are zero."""
    found = np.eye(4)
    found[:3, :3] = exact_rotation(pose[:3, :3], angle)
    found[:3, 3] = np.where(np.abs(pose[:3, 3]) <= length, 0.0, tidy(pose[:3, 3], unit))
    return found


def _screw_squared(joint: Joint, before: _Frame, after: _Frame, unit: float, angle: float) -> Array:
    """The screw in the frame of whichever link's origin is nearer to the axis, made exact there, back in the base."""
    own = [_in_frame(joint.screw, old) for old, _, _ in (after, before)]
    use = 0 if joint.kind is JointKind.PRISMATIC or _miss(own[0]) <= _miss(own[1]) + NOTHING * unit else 1
    _, frame, far = (after, before)[use]
    direction, point, pitch = _line_of(own[use], joint.kind)
    axis = times(frame[:3, :3], exact_direction(direction, 0.0 if far else angle))
    return _screw(joint.kind, axis, times(frame[:3, :3], tidy(point, unit)) + frame[:3, 3], pitch)


def _in_frame(screw: Array, frame: Array) -> Array:
    turn, origin = frame[:3, :3], frame[:3, 3]
    return np.concatenate([times(turn.T, screw[:3] - np.cross(origin, screw[3:])), times(turn.T, screw[3:])])


def _miss(screw: Array) -> float:
    return norm(np.cross(screw[3:], screw[:3]))


def _line_of(screw: Array, kind: JointKind) -> tuple[Array, Array, float]:
    """Direction, the point nearest to the origin, pitch."""
    if kind is JointKind.PRISMATIC:
        return screw[:3], np.zeros(3), 0.0
    pitch = dot(screw[:3], screw[3:]) if kind is JointKind.HELICAL else 0.0
    return screw[3:], np.cross(screw[3:], screw[:3]), pitch


def _screw(kind: JointKind, direction: Array, point: Array, pitch: float) -> Array:
    if kind is JointKind.PRISMATIC:
        return np.concatenate([direction, np.zeros(3)]) + 0.0
    return np.concatenate([np.cross(point, direction) + pitch * direction, direction]) + 0.0  # + 0.0 turns −0 into 0


def _sections_squared(robot: Robot, angle: float, length: float) -> Robot:
    """Denavit and Hartenberg's numbers made exact, and the arm built of them again where that changes one."""
    unit = _unit(robot)
    lines = axis_lines(robot, length=length)
    normals = common_normals(robot, lines, angle=angle, length=length)
    made = [_exact(one, unit, angle, length) for one in between(lines, normals)]
    made = _cancelled(made, [joint.kind is JointKind.PRISMATIC for joint in robot.joints], length)
    pose = _pose_squared(frame_at(normals[0][0], lines[0][0], normals[0][2]), unit, angle)
    joints = []
    for i, (joint, numbers) in enumerate(zip(robot.joints, made, strict=True)):
        pose = times(pose, rotation("z", numbers.phase), translation(0.0, 0.0, numbers.d))
        after = frame_at(normals[i + 1][0], lines[i][0], normals[i + 1][1])
        frame = times(pose, _pose_squared(times(inverse(after), joint.frame), unit, angle, length))
        screw = _screw(joint.kind, pose[:3, 2], pose[:3, 3], _line_of(joint.screw, joint.kind)[2])
        joints.append(replace(joint, screw=screw, frame=frame))
        pose = times(pose, translation(numbers.a, 0.0, 0.0), rotation("x", numbers.twist))
    at_tip = _pose_squared(times(inverse(robot.joints[-1].frame), robot.home), unit, min(angle, SQUARE))
    home = times(joints[-1].frame, at_tip)
    found = replace(robot, joints=tuple(joints), home=home)
    return robot if _have_same_home(robot, found) else found


def _exact(given: Numbers, unit: float, angle: float, length: float) -> Numbers:
    d, a = (0.0 if abs(x) <= length else float(tidy(np.array(x), unit)) for x in (given.d, given.a))
    phase = exact_angle(given.phase, angle, step_for(angle))  # that of a joint that turns counts from anywhere
    return Numbers(phase, d, a, exact_angle(given.twist, angle))


def _cancelled(made: Sequence[Numbers], slides: Sequence[bool], length: float) -> list[Numbers]:
    """Offsets along parallel axes add up; where they cancel but for `length`, they cancel exactly."""
    found = list(made)
    for run in parallel_runs(found):
        if run[0] == 0 or run[-1] == len(found) - 1 or any(slides[k] for k in run):
            continue  # no normal before the first axis and after the last; the offset of a slide is a variable
        offsets = along(found, run)
        if 0.0 < abs(sum(offsets)) <= length:
            last = max(i for i, d in enumerate(offsets) if d != 0.0)
            place = run[last]
            same_way = offsets[last] == found[place].d
            found[place] = replace(found[place], d=-sum(offsets[:last]) if same_way else sum(offsets[:last]))
    return found


def _have_same_home(first: Robot, two: Robot) -> bool:
    pairs = [(first.home, two.home)]
    for mine, other in zip(first.joints, two.joints, strict=True):
        pairs += [(mine.screw, other.screw), (mine.frame, other.frame)]
    return all(float(np.abs(x - y).max()) <= _SAME * max(1.0, float(np.abs(x).max())) for x, y in pairs)


def as_intended(robot: Robot, angles: Angles) -> Robot:
    """The arm with exact structure where its file's numbers hold it but for noise, and a note on what was changed.

    Args:
        robot: read with `angles`; a fixed angle of more than two turns brings a note.
        angles: what the reader took decimals for; with `as_written` the numbers stay as they are.
    """
    if angles.largest > 4 * pi:
        most = angles.largest
        note = f"a fixed angle of {most:g} rad is many turns; {most:g}° is {radians(most):.4g}"
        robot = replace(robot, notes=(*robot.notes, note))
    if angles.as_written:
        return robot
    found, changes = squared(robot)
    note = _note([abs(x) for x in angles.changes if abs(x) > NOTHING], changes)
    return replace(found, notes=(*found.notes, note)) if note else found


def _note(angles: Sequence[float], changes: Sequence[Change]) -> str:
    """One line, empty where no number was changed by more than a nanometre or a billionth of a radian."""
    parts = []
    if angles:
        means = "the multiple of 15° it rounds" if len(angles) == 1 else "the multiples of 15° they round"
        parts.append(f"{count(len(angles), 'angle')} taken as {means}, at most {max(angles):.2g} rad")
    turned = [change.by for change in changes if change.turns]
    moved = [change.by for change in changes if not change.turns]
    if changes:
        what = [count(len(turned), "axis", "axes")] if turned else []
        what += [count(len(moved), "length")] if moved else []
        most = [f"{max(turned):.2g} rad"] if turned else []
        most += [f"{max(moved) * 1e6:.2g} µm"] if moved else []
        parts.append(f"{' and '.join(what)} squared, at most {', '.join(most)}")
    return "; ".join([*parts, "--as-written keeps the file's numbers"]) if parts else ""


_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "µm": 1e-6, "μm": 1e-6, "um": 1e-6}
_TURNS = {"deg": radians(1.0), "°": radians(1.0), "rad": 1.0, "mrad": 1e-3}
_ONE = re.compile(r"\s*(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)\s*([A-Za-zµμ°]+)\s*")
_Fact = tuple[str, tuple[int, ...]]  # what, of which joints
_WIDEST = radians(5.0)  # angles are multiples of 15°: at half of that every angle would be one
_LONGEST = 0.1  # of the arm's size: with more it is another arm
_WIDER = (1.0, 1.5, 2.0, 3.0)  # a frame may have to turn by more than the axes in it do
NEAR = 0.015
"""Structure is near where it is missed by this share of the arm's size, or this angle [rad]: Gen3's 12 mm of 1.2 m are,
20 mm between the axes of an elbow are a design."""


@dataclass(frozen=True, slots=True)
class Tolerance:
    """How far an arm may be from an ideal one.

    Attributes:
        length: [m]; None is what files are read with, `squared`.
        angle: [rad]; None is 2e-5.
    """

    length: float | None = None
    angle: float | None = None

    @property
    def text(self) -> str:
        """As it is typed: "1mm,0.5deg"."""
        parts = [] if self.length is None else [f"{self.length * 1e3:.12g}mm"]
        return ",".join(parts + ([] if self.angle is None else [f"{degrees(self.angle):.12g}deg"]))


@dataclass(frozen=True, slots=True)
class Near:
    """An ideal arm that is near.

    Attributes:
        gained: what holds in it exactly and in the arm itself only nearly, in words, the most telling first.
        length, angle: the largest change of a length [m] and of an angle [rad] on the way to it; 0 for none.
        tolerance: with which `ideal` finds it, in round numbers.
    """

    gained: tuple[str, ...]
    length: float
    angle: float
    tolerance: Tolerance

    @property
    def text(self) -> str:
        """One line, without the command: "this arm is within 0.3 mm, 0.06° of one with a spherical wrist"."""
        parts = [f"{self.length * 1e3:.2g} mm"] if self.length else []
        parts += [f"{degrees(self.angle):.2g}°"] if self.angle else []
        more = f" and {len(self.gained) - 2} more" if len(self.gained) > 2 else ""
        joint = ", " if more else " and "
        return f"this arm is within {', '.join(parts)} of one with {joint.join(self.gained[:2])}{more}"

    @property
    def line(self) -> str:
        """`text` and the option with which commands take the ideal arm."""
        return f"{self.text}: see --ideal {self.tolerance.text}"


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
    found: dict[str, float] = {}
    for part in text.split(","):
        match = _ONE.fullmatch(part) if len(part) <= LONGEST_TEXT else None
        units = next((u for u in (_UNITS, _TURNS) if match is not None and match[2] in u), None)
        if match is None or units is None:
            raise OptionError("this is not a tolerance", where=where, got=repr(text), allowed=allowed)
        key = "length" if units is _UNITS else "angle"
        if key in found:
            raise OptionError(f"the {key} is given twice", where=where, got=repr(text), allowed=allowed)
        found[key] = float(match[1]) * units[match[2]]
    given = Tolerance(**found)
    _check(given, where)
    return given


def ideal(
    robot: Robot, *, length: float | None = None, angle: float | None = None
) -> tuple[Robot, tuple[Change, ...]]:
    """The nearest arm whose structure is exact, to a tolerance, and what was moved.

    Axes that are parallel, or at a multiple of 15°, to `angle` are exactly so; those that come within `length` meet,
    three of them in one point where the offset between is as small; offsets along parallel axes that cancel to `length`
    cancel. It is `squared` with other tolerances: everything else is kept, and the result is `robot` itself where
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
    return squared(robot, angle=SQUARE if angle is None else angle, length=length)


_near: dict[int, Near | None] = {}  # by id, as long as the arm is there


def near_ideal(robot: Robot) -> Near | None:
    """The ideal arm within `NEAR`, where it has structure that the arm misses; else None. Found once for an arm.

    Its tolerance is the smallest of two digits that finds all of it.
    """
    key = id(robot)
    if key not in _near:
        _near[key] = _ideal(robot)
        weakref.finalize(robot, _near.pop, key, None)
    return _near[key]


INTENDED = 3e-4
"""A file's arm that misses structure by a length up to this is meant to have it [m]: CAD exports are no better."""
_CALIBRATED = 2e-3, 1e-3  # [rad], [m]: what calibration adds to a drawing
_SMALL_ARM = 0.3  # [m]; of smaller arms such lengths may be a design


def intended_tolerance(robot: Robot) -> Tolerance | None:
    """The tolerance of the ideal arm that a file is meant to describe; None where the file is taken as it is.

    That is an arm of a file, of more than 0.3 m, which misses structure by a length up to `INTENDED`, or in angles and
    lengths by what a calibration adds.
    """
    near = near_ideal(robot) if robot.source.kind != "catalogue" and extent(robot) > _SMALL_ARM else None
    if near is None or near.angle > _CALIBRATED[0]:
        return None
    return near.tolerance if near.length <= (_CALIBRATED[1] if near.angle else INTENDED) else None


def _ideal(robot: Robot) -> Near | None:
    found, changes = squared(robot, angle=NEAR, length=NEAR * extent(robot))
    gained = structure_words(found, robot)
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
    length = None if given.length is None else _round_up(given.length * factor, 1e-3)
    return Tolerance(length, None if given.angle is None else _round_up(given.angle * factor, radians(1.0)))


def _found_with(robot: Robot, tolerance: Tolerance, gained: tuple[str, ...]) -> Near | None:
    if tolerance.angle is not None and tolerance.angle > _WIDEST:
        return None
    made, moved = squared(robot, angle=tolerance.angle or SQUARE, length=tolerance.length)
    if structure_words(made, robot) != gained:
        return None
    length, angle = (max((x.by for x in moved if x.turns is turns), default=0.0) for turns in (False, True))
    return Near(gained, length if length > meeting(robot) else 0.0, angle if angle > SQUARE else 0.0, tolerance)


def structure_words(robot: Robot, less: Robot | None = None) -> tuple[str, ...]:
    """What holds between the axes, in words for after "with", the most telling first.

    Args:
        robot: an arm of exact structure.
        less: what holds in this arm too is left out.
    """
    known = set(_holding(less)) if less is not None else set()
    new = [one for one in _holding(robot) if one not in known and not _follows(one, known)]
    return tuple(_merged(new, len(robot.joints)))


def _follows(fact: _Fact, known: set[_Fact]) -> bool:
    """Whether no offset along parallel axes is what each of them had without."""
    what, joints = fact
    return what == "flush" and len(joints) > 1 and all((what, (joint,)) in known for joint in joints)


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


def _holding(robot: Robot) -> list[_Fact]:
    numbers = numbers_of(robot, angle=NOTHING, length=NOTHING)
    slides = [joint.kind is JointKind.PRISMATIC for joint in robot.joints]
    found: list[_Fact] = []
    for i in range(len(numbers) - 2):
        if not any(slides[i : i + 3]) and _point(numbers, i):
            found.append(("point", (i + 1, i + 2, i + 3)))
    for run in parallel_runs(numbers):
        found += [("parallel", (i + 1, j + 1)) for i, j in pairwise(run)]
        inside = run[0] > 0 and run[-1] < len(numbers) - 1 and not any(slides[k] for k in run)
        if inside and abs(sum(along(numbers, run))) < NOTHING:
            found.append(("flush", tuple(k + 1 for k in run)))
    for i, (one, _) in enumerate(pairwise(numbers)):
        pair = (i + 1, i + 2)
        if abs(one.a) < NOTHING and not slides[i] and not slides[i + 1]:
            found.append(("common", pair) if parallel(one.twist) else ("meeting", pair))
        if abs(abs(one.twist) - pi / 2) < NOTHING:
            found.append(("square", pair))
    return found


def _point(numbers: Sequence[Numbers], i: int) -> bool:
    first, middle = numbers[i], numbers[i + 1]
    lengths = first.a, middle.d, middle.a
    return all(abs(x) < NOTHING for x in lengths) and not parallel(first.twist) and not parallel(middle.twist)


def _merged(facts: Sequence[_Fact], n: int) -> list[str]:
    points = [joints for what, joints in facts if what == "point"]
    names: dict[tuple[int, ...], str] = {(1, 2, 3): "a spherical shoulder"} if n > 3 else {}
    names[n - 2, n - 1, n] = "a spherical wrist"
    points.sort(key=lambda joints: (joints not in names, -joints[0]))
    words = [names.get(joints, f"axes {_listed(joints)} in one point") for joints in points]
    within = {pair for joints in points for pair in pairwise(joints)} | {(joints[1],) for joints in points}
    said = {"parallel": "axes {} parallel", "common": "axes {} on one line", "meeting": "axes {} meeting",
            "square": "axes {} at right angles", "flush": "no offset along axes {}"}  # fmt: skip
    for what, text in said.items():
        kept = [joints for kind, joints in facts if kind == what]
        for joints in _chained(kept) if what in ("parallel", "common") else kept:
            if what == "flush" and len(joints) == 1:
                words += [] if joints in within else [f"no offset along axis {joints[0]}"]
            elif joints not in within or what == "square":
                words.append(text.format(_listed(joints)))
    return words


def _chained(pairs: Sequence[tuple[int, ...]]) -> list[tuple[int, ...]]:
    found: list[tuple[int, ...]] = []
    for pair in sorted(pairs):
        if found and found[-1][-1] == pair[0]:
            found[-1] = (*found[-1], *pair[1:])
        else:
            found.append(pair)
    return found


def _listed(joints: Sequence[int]) -> str:
    return " and ".join(map(str, joints)) if len(joints) == 2 else ", ".join(map(str, joints))
