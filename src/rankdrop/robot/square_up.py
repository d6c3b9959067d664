"""An arm rebuilt without noise: axes exactly parallel, at right angles or meeting where they nearly are.

A file's numbers carry the noise of the program that wrote them: twists of 90.0004°, axes that miss each other by a
fraction of a micrometre. `square_up` makes an arm exact from the base on: first the pose of every link in the one
before, exact angles and tidy lengths; then, where the links' own frames say nothing, Denavit and Hartenberg's numbers
between consecutive axes. Lengths are worked out about the axes that were squared, so that a twist that is mended leaves
no offset behind. `as_intended` is the last step of every reader.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import atan2, degrees, floor, hypot, log10, pi, sqrt

import numpy as np

from rankdrop.robot.arm_reach import astray, extent
from rankdrop.robot.model import Array, Joint, Robot, screw_of
from rankdrop.robot.note import Moved, NoteOn, RobotNote
from rankdrop.robot.numbers import (
    LinkNumbers,
    axis_lines,
    common_normals,
    frame_at,
    numbers_of,
    offsets_along,
    parallel_runs,
    section_numbers,
    wrap_angle,
)
from rankdrop.robot.quantities import Angles
from rankdrop.robot.transform import cos_sin, inverse, nearest_rotation, norm, rotation, times, translation
from rankdrop.tolerances import MEETING, NOTHING, SQUARE

STEP = pi / 12
"""Angles between parts of an arm are multiples of 15°, or nothing is known of them."""
_SAME = 1e-13
"""Rebuilt numbers that differ by no more are the arm's own [1, m]: the rounding of a chain of products."""
_PASSES = 5
"""Making the axes exact may leave a frame that is exact but for noise, and the other way round; two are enough."""
ORDINARY = (0.03, 30.0)
"""Sizes of arms [m]: three decades, so that every arm is of this size in just one of km, m, mm and µm."""
_Frame = tuple[Array, Array, bool]  # as given, as made, whether it is far from the arm


@dataclass(frozen=True, slots=True)
class ExactChange:
    """One number of the chain that was made exact.

    Attributes:
        kind: "twist" (angle from one axis to the next), "angle" (about an axis, from one common normal to the next),
            "distance" (between two axes along their normal), "offset" (along an axis, between two normals; of axes that
            are parallel, the sum), "base" and "tip" (how far the first axis is turned in the base, the tip in the last
            link; 0 after).
        joints: numbers from 1 in the chain, mimic joints counted: the two joints of a twist or a distance, the one of
            all else, all those of parallel axes.
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
        return abs(wrap_angle(by) if self.turns else by)

    @property
    def name(self) -> str:
        """Denavit and Hartenberg's letter with the number of the joint: "α2", "d4", "d2 + d3"; else "base", "tip"."""
        letter = {"twist": "α", "angle": "θ", "distance": "a", "offset": "d"}.get(self.kind)
        if letter is None:
            return self.kind
        if self.kind == "offset":
            numbers = self.joints
        else:
            numbers = self.joints[:1]
        return " + ".join(f"{letter}{number}" for number in numbers)

    @property
    def text(self) -> str:
        """In words: "d4 from 0.3 mm to 0", "α2 from 90.06° to 90°", "tip turned by 0.0006°"."""
        if self.kind in ("base", "tip"):
            return f"{self.kind} turned by {degrees(self.by):.2g}°"
        before, after = self.ends
        return f"{self.name} from {before} to {after}"

    @property
    def ends(self) -> tuple[str, str]:
        """Its values before and after in words: ("0.3 mm", "0"), ("90.06°", "90°")."""
        return self._value_words(self.before), self._value_words(self.after)

    def _value_words(self, value: float) -> str:
        """With one digit more than it was moved by."""
        if value == 0.0 and not self.turns:
            return "0"
        if self.turns:
            factor, unit = (degrees(1.0), "°")
        else:
            factor, unit = (1e3, " mm")
        places = max(0, 1 - floor(log10(self.by * factor)))
        text = f"{round(value * factor, places) + 0.0:.{places}f}"
        return (text.rstrip("0").rstrip(".") if places else text).replace("-", "−") + unit

    @property
    def turns(self) -> bool:
        """Whether it is an angle."""
        return self.kind not in ("distance", "offset")


def changes_between(old: Robot, new: Robot, *, angle: float, length: float) -> tuple[ExactChange, ...]:
    """Every number of the chain that differs by more than a nanometre or a billionth of a radian.

    Args:
        old, new: the same chain, its normals chosen alike: the second made of the first.
        angle, length: the tolerances it was made with.
    """
    before = numbers_of(old, angle=angle, length=length)
    after = numbers_of(new, angle=angle, length=length)
    first, last = (angle_between(x, y) for x, y in zip(_ends(old), _ends(new), strict=True))
    ends = [ExactChange("base", (1,), first, 0.0), ExactChange("tip", (len(before),), last, 0.0)]
    changes = [*_differences(before, after), *ends]
    return tuple(change for change in changes if change.by > NOTHING)


def _differences(before: Sequence[LinkNumbers], after: Sequence[LinkNumbers]) -> Iterator[ExactChange]:
    for run in parallel_runs(after):
        for i in run:
            first, second, pair = before[i], after[i], (i + 1, i + 2)
            if i == run[0]:
                joints = tuple(k + 1 for k in run)
                yield ExactChange("offset", joints, sum(offsets_along(before, run)), sum(offsets_along(after, run)))
            yield ExactChange("angle", (i + 1,), first.phase, second.phase)
            yield ExactChange("distance", pair, first.a, second.a)
            lean = abs(first.tilt) > NOTHING
            turned = hypot(wrap_angle(first.twist - second.twist), first.tilt)
            yield ExactChange("twist", pair, second.twist + turned if lean else first.twist, second.twist)


def _ends(robot: Robot) -> tuple[Array, Array]:
    """Direction of the first axis in the base, axes of the tip in the last link (its frame)."""
    return robot.joints[0].axis, times(robot.joints[-1].frame[:3, :3].T, robot.home[:3, :3])


def angle_between(one: Array, two: Array) -> float:
    """Angle between two directions or two rotations that are near [rad]: ‖A − B‖ = 2 √2 sin(angle / 2)."""
    return norm(one - two) / (sqrt(2.0) if one.ndim == 2 else 1.0)


def step_for(angle: float) -> float:
    """Angles are multiples of this to a tolerance [rad]: of 15° but for noise, of 90° where more is forgiven.

    One of 7 angles is a multiple of 15° to 1°: that would be chance.
    """
    return STEP if angle <= SQUARE else pi / 2


def exact_angle(value: float, angle: float, step: float = STEP) -> float:
    """The multiple of a step, of 15°, that is within `angle` of a value, else the value itself [rad]."""
    nearest = round(value / step) * step
    if abs(value - nearest) <= angle:
        return nearest
    return value


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
    rotation = np.zeros((3, 3))
    rotation[row, column] = sign
    rotation[np.ix_(rows, columns)] = [[c, -sign * s], [s, sign * c]]
    if angle_between(rotation, turn) <= angle:
        return rotation
    return nearest_rotation(turn)


def exact_direction(direction: Array, angle: float) -> Array:
    """(3,) the direction in a coordinate plane, at a multiple of `step_for(angle)`, near one; else that one."""
    step = step_for(angle)
    out = int(np.argmin(np.abs(direction)))
    i, j = (out + 1) % 3, (out + 2) % 3
    c, s = cos_sin(round(atan2(direction[j], direction[i]) / step) * step)
    exact = np.zeros(3)
    exact[i], exact[j] = c, s
    if norm(exact - direction) <= angle:
        return exact
    return direction


def tidy(lengths: Array, unit: float = 1.0) -> Array:
    """Lengths that are a whole number of micrometres to a nanometre are that: 0.240000000000178 m is 0.24.

    Args:
        lengths: in any unit.
        unit: a power of 1000: a metre in it.
    """
    step = 1e6 / unit  # a whole number, or what it divides: 0.24 comes out as it is written
    whole = np.rint(lengths * step) / step
    return np.asarray(np.where(np.abs(lengths - whole) < NOTHING * unit, whole, lengths)) + 0.0


def square_up(
    robot: Robot, *, angle: float = SQUARE, length: float | None = None
) -> tuple[Robot, tuple[ExactChange, ...]]:
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
        >>> arm, changes = square_up(noisy)
        >>> arm.joints[2].screw[3:], [change.kind for change in changes]
        (array([ 0., -1.,  0.]), ['twist', 'offset'])
    """
    if length is None:
        limit = meeting(robot)
    else:
        limit = length
    ideal = robot
    for _ in range(_PASSES):
        before, ideal = ideal, _sections_squared(_frames_squared(ideal, angle), angle, limit)
        if _have_same_home(before, ideal):
            ideal = before
            break
    if _have_same_home(robot, ideal):
        return robot, ()
    return ideal, changes_between(robot, ideal, angle=angle, length=limit)


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
    squared = np.eye(4)
    squared[:3, :3] = exact_rotation(pose[:3, :3], angle)
    squared[:3, 3] = np.where(np.abs(pose[:3, 3]) <= length, 0.0, tidy(pose[:3, 3], unit))
    return squared


def _screw_squared(joint: Joint, before: _Frame, after: _Frame, unit: float, angle: float) -> Array:
    """The screw in the frame of whichever link's origin is nearer to the axis, made exact there, back in the base."""
    lines = [_line_in(joint, old) for old, _, _ in (after, before)]
    if norm(lines[0][1]) <= norm(lines[1][1]) + NOTHING * unit:
        use = 0
    else:
        use = 1
    _, frame, far = (after, before)[use]
    direction, point = lines[use]
    axis = times(frame[:3, :3], exact_direction(direction, 0.0 if far else angle))
    return screw_of(joint.kind, axis, times(frame[:3, :3], tidy(point, unit)) + frame[:3, 3], joint.pitch)


def _line_in(joint: Joint, frame: Array) -> tuple[Array, Array]:
    """The axis of a joint in a frame: direction and the point nearest to the origin; of a slide the origin itself."""
    turn = frame[:3, :3].T
    direction = times(turn, joint.axis)
    if joint.slides:
        return direction, np.zeros(3)
    return direction, np.cross(direction, times(turn, joint.screw[:3] - np.cross(frame[:3, 3], joint.axis)))


def _sections_squared(robot: Robot, angle: float, length: float) -> Robot:
    """Denavit and Hartenberg's numbers made exact, and the arm built of them again where that changes one."""
    unit = _unit(robot)
    lines = axis_lines(robot, length=length)
    normals = common_normals(robot, lines, angle=angle, length=length)
    sections = [_exact(section, unit, angle, length) for section in section_numbers(lines, normals)]
    sections = _cancel_offsets(sections, [joint.slides for joint in robot.joints], length)
    pose = _pose_squared(frame_at(normals[0][0], lines[0][0], normals[0][2]), unit, angle)
    joints = []
    for i, (joint, numbers) in enumerate(zip(robot.joints, sections, strict=True)):
        pose = times(pose, rotation("z", numbers.phase), translation(0.0, 0.0, numbers.d))
        after = frame_at(normals[i + 1][0], lines[i][0], normals[i + 1][1])
        frame = times(pose, _pose_squared(times(inverse(after), joint.frame), unit, angle, length))
        screw = screw_of(joint.kind, pose[:3, 2], pose[:3, 3], joint.pitch)
        joints.append(replace(joint, screw=screw, frame=frame))
        pose = times(pose, translation(numbers.a, 0.0, 0.0), rotation("x", numbers.twist))
    at_tip = _pose_squared(times(inverse(robot.joints[-1].frame), robot.home), unit, min(angle, SQUARE))
    home = times(joints[-1].frame, at_tip)
    ideal = replace(robot, joints=tuple(joints), home=home)
    if _have_same_home(robot, ideal):
        return robot
    return ideal


def _exact(given: LinkNumbers, unit: float, angle: float, length: float) -> LinkNumbers:
    d, a = (0.0 if abs(x) <= length else float(tidy(np.array(x), unit)) for x in (given.d, given.a))
    phase = exact_angle(given.phase, angle, step_for(angle))  # that of a joint that turns counts from anywhere
    return LinkNumbers(phase, d, a, exact_angle(given.twist, angle))


def _cancel_offsets(sections: Sequence[LinkNumbers], slides: Sequence[bool], length: float) -> list[LinkNumbers]:
    """Offsets along parallel axes add up; where they cancel but for `length`, they cancel exactly."""
    remaining = list(sections)
    for run in parallel_runs(remaining):
        if run[0] == 0 or run[-1] == len(remaining) - 1 or any(slides[k] for k in run):
            continue  # no normal before the first axis and after the last; the offset of a slide is a variable
        offsets = offsets_along(remaining, run)
        if 0.0 < abs(sum(offsets)) <= length:
            last = max(i for i, d in enumerate(offsets) if d != 0.0)
            place = run[last]
            same_way = offsets[last] == remaining[place].d
            remaining[place] = replace(remaining[place], d=-sum(offsets[:last]) if same_way else sum(offsets[:last]))
    return remaining


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
        turns = RobotNote(NoteOn.FIXED_TURNS, value=angles.largest)
        robot = replace(robot, notes=(*robot.notes, turns))
    if angles.as_written:
        return robot
    intended, changes = square_up(robot)
    rounded = [abs(change) for change in angles.changes if abs(change) > NOTHING]
    if not rounded and not changes:
        return intended
    turned, moved = largest_changes(changes)
    note = RobotNote(
        NoteOn.SQUARED, rounded=Moved(len(rounded), max(rounded, default=0.0)), turned=turned, moved=moved
    )
    return replace(intended, notes=(*intended.notes, note))


def largest_changes(changes: Sequence[ExactChange]) -> tuple[Moved, Moved]:
    """How many angles and how many lengths were changed, and by how much at most [rad, m]."""
    turned = [change.by for change in changes if change.turns]
    moved = [change.by for change in changes if not change.turns]
    return Moved(len(turned), max(turned, default=0.0)), Moved(len(moved), max(moved, default=0.0))
