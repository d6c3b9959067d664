"""What lies between the axes of a chain: lines, common normals, Denavit and Hartenberg's numbers, whatever its frames.

Between axis i and axis i+1 runs a common normal x_i. Parallel axes have many: there it starts where the frame of the
joint stands, or where the normal before ended; but where the arm is, if these are far off. (The feet of normals between
axes that are nearly parallel are: tables of calibrated arms have offsets of 300 m.) Where the joints carry frames that
follow either convention of Denavit and Hartenberg, the normals are directed as theirs.

From the normals follow the numbers, in floating point; and what became other in an arm that was made exact: which
number of the chain, from what to what. Last the one length that stands for the whole arm: its reach, the sum of its
links.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import asin, atan2, degrees, floor, hypot, log10, pi, sqrt
from weakref import WeakKeyDictionary

import numpy as np

from rankdrop.robot.model import Array, Joint, JointKind, Robot
from rankdrop.robot.transform import dot, norm, times
from rankdrop.tolerances import NOTHING

FAR = 2.0
"""Frames farther from their axis's place in the arm than this times its size are no part of it."""
_NOTHING = 1e-12  # share of the coordinates that a length is made of at which it is rounding


Line = tuple[Array, Array]
"""An axis: (3,) its direction, of length 1; (3,) a point on it [m]."""
Normal = tuple[Array, Array, Array]
"""A common normal of two axes: (3,) its direction, of length 1; (3,) its feet on the axis before and after [m]."""


def anchors(robot: Robot) -> Array:
    """(N, 3) a point of every axis near the arm [m]: from the tip on, the one nearest to the next.

    It depends on frames where slides are: their lines go through their frames.
    """
    point = np.array(robot.home[:3, 3])
    found = np.zeros((len(robot.joints), 3))
    for i, joint in reversed(list(enumerate(robot.joints))):
        slides = joint.kind is JointKind.PRISMATIC
        point = _nearest((joint.screw[:3], joint.frame[:3, 3]) if slides else _turning_line(joint.screw), point)
        found[i] = point
    return found


def extent(robot: Robot) -> float:
    """Length of the way along `anchors` to the tip [m]; 1 where it is nothing."""
    points = np.vstack([anchors(robot), robot.home[:3, 3]])
    total = sum(norm(step) for step in np.diff(points, axis=0))
    return total if total > _NOTHING * float(np.abs(points).max()) else 1.0


def astray(robot: Robot) -> list[bool]:
    """Which frames stand so far from the anchor of their axis that they are not on the arm."""
    far = FAR * extent(robot)
    pairs = zip(robot.joints, anchors(robot), strict=True)
    return [norm(joint.frame[:3, 3] - anchor) > far for joint, anchor in pairs]


def axis_lines(robot: Robot, *, length: float) -> list[Line]:
    """The axes of all joints at q = 0, in the base frame.

    A slide has a direction only; its line goes where its frame stands, or the frame before, where frames stand on the
    axis after their joint.

    Args:
        robot: joints of any kind.
        length: frames this near to an axis stand on it [m].
    """
    joints = robot.joints
    turning = [joint for joint in joints if joint.kind is not JointKind.PRISMATIC]
    on_own = all(_distance(joint.frame[:3, 3], _turning_line(joint.screw)) <= length for joint in turning)
    lines = []
    for i, joint in enumerate(joints):
        if joint.kind is not JointKind.PRISMATIC:
            lines.append(_turning_line(joint.screw))
        else:
            frame = joint.frame if on_own or i == 0 else joints[i - 1].frame
            lines.append((joint.screw[:3], frame[:3, 3]))
    return lines


def common_normals(robot: Robot, lines: list[Line], *, angle: float, length: float) -> list[Normal]:
    """The n + 1 normals of n axes: before the first axis, n − 1 between consecutive ones, after the last.

    The first has no length and stands where the next one starts; the last where the one before ends.

    Args:
        robot, lines: from `axis_lines`.
        angle: axes that are parallel to this are parallel [rad].
        length: axes this near meet; frames this near to an axis stand on it [m].
    """
    between: list[Normal] = []
    far = FAR * extent(robot)
    near = anchors(robot)
    for i in range(len(lines) - 1):
        before = between[-1] if between else None
        place = (robot.joints[i].frame, near[i], far)
        between.append(_normal(lines[i], lines[i + 1], place, before, angle, length))
    if not between:  # one joint alone
        axis, point = lines[0]
        return [(_perpendicular(axis), point, point)] * 2
    (first, start, _), (last, _, end) = between[0], between[-1]
    return [(first, start, start), *between, (last, end, end)]


def frame_at(x: Array, z: Array, origin: Array) -> Array:
    """(4, 4) a frame with its z axis along `z`, its x axis along the part of `x` that is perpendicular to z."""
    across = x - z * dot(x, z)
    across = across / norm(across)
    frame = np.eye(4)
    frame[:3, 0], frame[:3, 1], frame[:3, 2], frame[:3, 3] = across, np.cross(z, across), z, origin
    return frame


def _turning_line(screw: Array) -> Line:
    omega = screw[3:]
    return omega, np.cross(omega, screw[:3])


def _normal(
    one: Line, two: Line, place: tuple[Array, Array, float], before: Normal | None, angle: float, length: float
) -> Normal:
    """Common normal of two axes; `place`: frame of the joint between, where the arm is, and what is far from there.

    `before` is the normal before.
    """
    hint, anchor, far_off = place
    (axis, point), (other, beyond) = one, two
    cross = np.cross(axis, other)
    if norm(cross) > angle:
        x = cross / norm(cross)
        near, far = _feet(one, two)
        if abs(dot(far - near, x)) > length:
            x = x * np.sign(dot(far - near, x))
    else:
        start = before[2] if before is not None else point
        on_axis = min(_distance(hint[:3, 3], one), _distance(hint[:3, 3], two)) < length
        near = _nearest(one, hint[:3, 3] if on_axis else start)
        if norm(near - anchor) > far_off:
            near = _nearest(one, anchor)
        # where axis two crosses the plane: the axes are parallel to `angle` only, and part far away
        far = beyond + other * (dot(near - beyond, axis) / dot(other, axis))
        across = far - near
        if norm(across) > length:
            x = across / norm(across)
        else:
            x = hint[:3, 0] - axis * dot(hint[:3, 0], axis)
            if norm(x) < 0.5:
                x = before[0] if before is not None else _perpendicular(axis)
            x = x / norm(x)
    if dot(hint[:3, 0], x) < -1 + max(angle, 1e-6):  # along the frame's, but for the way
        x = -x
    return x, near, far


def _feet(one: Line, two: Line) -> tuple[Array, Array]:
    (a, start), (b, end) = one, two
    gap = end - start
    lean, along_a, along_b = dot(a, b), dot(a, gap), dot(b, gap)  # s − lean t = along_a, lean s − t = along_b
    across = np.cross(a, b)
    less = dot(across, across)  # 1 − lean², without cancelling
    s, t = (along_a - lean * along_b) / less, (lean * along_a - along_b) / less
    return start + s * a, end + t * b


def _nearest(line: Line, point: Array) -> Array:
    direction, start = line
    return start + direction * dot(point - start, direction)


def _distance(point: Array, line: Line) -> float:
    direction, start = line
    return norm(np.cross(point - start, direction))


def _perpendicular(z: Array) -> Array:
    x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    return np.asarray(x / norm(x))


@dataclass(frozen=True, slots=True)
class Numbers:
    """One joint and the link after it.

    Attributes:
        phase: angle about the axis from the normal before to the one after, at q = 0 [rad].
        d: offset along the axis between these normals, at q = 0 [m].
        a: distance from this axis to the next one along their normal [m].
        twist: angle from this axis to the next one about their normal [rad].
        tilt: where the two count as parallel, how far the next one leans along the normal [rad]; else 0.
    """

    phase: float
    d: float
    a: float
    twist: float
    tilt: float = 0.0


def numbers_of(robot: Robot, *, angle: float, length: float) -> list[Numbers]:
    """The numbers of all joints of a robot, mimic joints too; the link after the last has no length and no twist.

    Args:
        robot: joints of any kind.
        angle: axes that are parallel to this have a normal where their frames stand [rad].
        length: axes this near meet [m].
    """
    lines = axis_lines(robot, length=length)
    return between(lines, common_normals(robot, lines, angle=angle, length=length))


def between(lines: Sequence[Line], normals: Sequence[Normal]) -> list[Numbers]:
    """The numbers of n axes with their n + 1 normals."""
    found = []
    for i, line in enumerate(lines):
        (before, _, start), (after, near, far), z = normals[i], normals[i + 1], line[0]
        phase, d = _turn(before, after, z), dot(near - start, z)
        a = twist = tilt = 0.0
        if i + 1 < len(lines):
            next_z = lines[i + 1][0]
            twist, a = _turn(z, next_z, after), dot(far - near, after)
            tilt = asin(max(-1.0, min(1.0, dot(next_z, after))))
        found.append(Numbers(phase, d, a, twist, tilt))
    return found


def parallel_runs(numbers: Sequence[Numbers]) -> list[list[int]]:
    """Indices of axes, from 0, parted where two that follow each other are not exactly parallel."""
    runs = [[0]]
    for i, one in enumerate(numbers[:-1]):
        if parallel(one.twist):
            runs[-1].append(i + 1)
        else:
            runs.append([i + 1])
    return runs


def along(numbers: Sequence[Numbers], run: Sequence[int]) -> list[float]:
    """The offsets of axes that are parallel, all in the direction of the first [m]; only their sum moves axes."""
    sign, found = 1.0, []
    for k in run:
        found.append(sign * numbers[k].d)
        sign *= 1.0 if abs(numbers[k].twist) < 1.0 else -1.0
    return found


def parallel(twist: float) -> bool:
    """Whether a twist is that of parallel axes, whichever way they point."""
    return abs(twist - round(twist / pi) * pi) < NOTHING


def wrapped(angle: float) -> float:
    """The same angle in −π … π."""
    return (angle + pi) % (2 * pi) - pi


def _turn(one: Array, two: Array, about: Array) -> float:
    return atan2(dot(np.cross(one, two), about), dot(one, two))


@dataclass(frozen=True, slots=True)
class Change:
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
        return abs(wrapped(by) if self.turns else by)

    @property
    def name(self) -> str:
        """Denavit and Hartenberg's letter with the number of the joint: "α2", "d4", "d2 + d3"; else "base", "tip"."""
        letter = {"twist": "α", "angle": "θ", "distance": "a", "offset": "d"}.get(self.kind)
        if letter is None:
            return self.kind
        numbers = self.joints if self.kind == "offset" else self.joints[:1]
        return " + ".join(f"{letter}{number}" for number in numbers)

    @property
    def text(self) -> str:
        """In words: "d4 from 0.3 mm to 0", "α2 from 90.06° to 90°", "tip turned by 0.0006°"."""
        if self.kind in ("base", "tip"):
            return f"{self.kind} turned by {degrees(self.by):.2g}°"
        return f"{self.name} from {self._written(self.before)} to {self._written(self.after)}"

    def _written(self, value: float) -> str:
        """With one digit more than it was moved by."""
        if value == 0.0 and not self.turns:
            return "0"
        factor, unit = (degrees(1.0), "°") if self.turns else (1e3, " mm")
        places = max(0, 1 - floor(log10(self.by * factor)))
        text = f"{round(value * factor, places) + 0.0:.{places}f}"
        return (text.rstrip("0").rstrip(".") if places else text).replace("-", "−") + unit

    @property
    def turns(self) -> bool:
        """Whether it is an angle."""
        return self.kind not in ("distance", "offset")


def changes_between(old: Robot, new: Robot, *, angle: float, length: float) -> tuple[Change, ...]:
    """Every number of the chain that differs by more than a nanometre or a billionth of a radian.

    Args:
        old, new: the same chain, its normals chosen alike: the second made of the first.
        angle, length: the tolerances it was made with.
    """
    before = numbers_of(old, angle=angle, length=length)
    after = numbers_of(new, angle=angle, length=length)
    first, last = (apart(x, y) for x, y in zip(_ends(old), _ends(new), strict=True))
    found = [*_differences(before, after), Change("base", (1,), first, 0.0), Change("tip", (len(before),), last, 0.0)]
    return tuple(change for change in found if change.by > NOTHING)


def _differences(before: Sequence[Numbers], after: Sequence[Numbers]) -> Iterator[Change]:
    for run in parallel_runs(after):
        for i in run:
            one, other, pair = before[i], after[i], (i + 1, i + 2)
            if i == run[0]:
                yield Change("offset", tuple(k + 1 for k in run), sum(along(before, run)), sum(along(after, run)))
            yield Change("angle", (i + 1,), one.phase, other.phase)
            yield Change("distance", pair, one.a, other.a)
            lean = abs(one.tilt) > NOTHING
            turned = hypot(wrapped(one.twist - other.twist), one.tilt)
            yield Change("twist", pair, other.twist + turned if lean else one.twist, other.twist)


def _ends(robot: Robot) -> tuple[Array, Array]:
    """Direction of the first axis in the base, axes of the tip in the last link (its frame)."""
    first = robot.joints[0]
    direction = first.screw[:3] if first.kind is JointKind.PRISMATIC else first.screw[3:]
    return direction, times(robot.joints[-1].frame[:3, :3].T, robot.home[:3, :3])


def apart(one: Array, two: Array) -> float:
    """Angle between two directions or two rotations that are near [rad]: ‖A − B‖ = 2 √2 sin(angle / 2)."""
    return norm(one - two) / (sqrt(2.0) if one.ndim == 2 else 1.0)


FAR_SLIDE = 10.0
"""Limits of a slide that lie farther apart than this times the reach of the links say nothing of the arm: ±1e6 m of a
mobile base, a rail of 20 m under an arm of one. The Stanford arm has 6."""

_reaches: WeakKeyDictionary[Robot, float] = WeakKeyDictionary()  # a robot never changes, and every view asks
_links: WeakKeyDictionary[Robot, float] = WeakKeyDictionary()


def link_lengths(robot: Robot) -> Array:
    """Lengths ‖p_{i+1} − p_i‖ of the polygon tip → axis N → … → axis 1, p_i the point of axis i nearest to p_{i+1}.

    Each length is fixed in one link, so the result depends neither on q nor on the frames of the source. A prismatic
    joint adds its longest travel where `travel_limits` has any.

    Returns:
        (N,) length from joint i to the next one [m].
    """
    lengths = _polygon(robot)
    for i, joint in enumerate(robot.joints):
        if joint.kind is JointKind.PRISMATIC:
            travel = max(abs(end) for end in travel_limits(robot, joint))
            lengths[i] = travel if np.isfinite(travel) else 0.0
    return lengths


def travel_limits(robot: Robot, joint: Joint) -> tuple[float, float]:
    """Limits of a slide as far as they say something of the arm [m]; ±inf where there are none or too far."""
    links = _links_reach(robot)
    if links and joint.upper - joint.lower > FAR_SLIDE * links:
        lower = joint.lower if abs(joint.lower) <= FAR_SLIDE * links else -np.inf
        return lower, joint.upper if abs(joint.upper) <= FAR_SLIDE * links else np.inf
    return joint.lower, joint.upper


def reach(robot: Robot) -> float:
    """Sum of the link lengths from the first axis to the tip [m]; 1 for an arm without length (a bare wrist)."""
    known = _reaches.get(robot)
    if known is None:
        total = float(link_lengths(robot).sum())
        known = _reaches[robot] = total if total > 0.0 else 1.0
    return known


def _links_reach(robot: Robot) -> float:
    """Sum of the link lengths without the travel of slides [m]; 0 where they are nothing."""
    known = _links.get(robot)
    if known is None:
        known = _links[robot] = float(_polygon(robot).sum())
    return known


def _polygon(robot: Robot) -> Array:
    """`link_lengths` without the travel of slides; all 0 where no more than rounding is there."""
    point = robot.home[:3, 3].copy()
    lengths = np.zeros(len(robot.joints))
    size = float(np.abs(point).max())
    for i in range(len(robot.joints) - 1, -1, -1):
        joint = robot.joints[i]
        if joint.kind is JointKind.PRISMATIC:
            continue
        omega = joint.screw[3:]
        foot = np.cross(omega, joint.screw[:3])  # the axis point nearest to the base origin
        nearest = foot + omega * dot(omega, point - foot)
        lengths[i] = norm(point - nearest)
        point = nearest
        size = max(size, float(np.abs(point).max()))
    return lengths if lengths.sum() > _NOTHING * size else np.zeros(len(lengths))
