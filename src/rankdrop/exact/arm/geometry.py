"""The lengths and twists of an arm, made exact, and which of its lengths are letters.

A chain as twists, lengths and offsets between consecutive axes, read off the joint screws, then made exact.

Between axis i and axis i+1 runs a common normal x_i. Along it the axes are a_i apart and twisted by α_i; along axis i
the feet of x_{i−1} and x_i are d_i apart, and the angle between these normals is θ_i = q_i + φ_i (a slide: a constant
angle, and distance d_i + q_i). These are Denavit and Hartenberg's numbers. Where the joints carry frames that follow
either of the two conventions, the normals are directed as theirs, so that the numbers are those of the table.

Letters have names, values, and places where each stands.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import acos, atan2, degrees, pi, radians, remainder, tan

import numpy as np

from rankdrop.algebra.roots import ROOTS, Number, surd
from rankdrop.errors import OptionError, RobotError
from rankdrop.exact.arm.parts import parts_of
from rankdrop.lists import flat_map
from rankdrop.robot.arm_reach import Line, reach
from rankdrop.robot.model import Array, Joint, JointKind, Robot
from rankdrop.robot.numbers import Normal, axis_lines, common_normals, frame_at
from rankdrop.robot.quantities import LETTERS_ALLOWED, is_letter
from rankdrop.tolerances import ALIGNED, NOTHING
from rankdrop.units import exponent, shift_decimal

_NOISE = {"angle": 1e-12, "twist": 1e-12, "a": 1e-13, "d": 1e-13}
"""What floating-point numbers leave of angles [rad] and lengths [the arm's own unit] that a file gives exactly."""
ZERO, ONE = Fraction(0), Fraction(1)
DIGITS = 12
"""Lengths are read as decimals of so many places of the arm's own unit: far below any drawing, far above rounding."""


_QUARTERS: tuple[tuple[Number, Number], ...] = ((ONE, ZERO), (ZERO, ONE), (-ONE, ZERO), (ZERO, -ONE))
"""(cos, sin) of whole quarter turns."""

LARGEST = 12
"""Largest multiplier of a joint that follows another one, in parts of its leader's angle: degrees grow with it."""

MANY = 14
"""More different lengths than this stay numbers unless letters are asked for."""

ODD = 1
"""Different twists that are no quarter turns, such as the 60° of a wrist, beyond which lengths stay numbers."""

Place = tuple[int, str]
"""(index of a section, "a" or "d")."""


@dataclass(frozen=True, slots=True)
class ExactAngle:
    """An angle by its exact cosine and sine.

    Attributes:
        cos, sin: cos² + sin² = 1.
        error: the given angle less this one [rad].
    """

    cos: Number
    sin: Number
    error: float

    def __float__(self) -> float:
        """The given angle [rad]."""
        return atan2(self.sin, self.cos) + self.error

    @property
    def rational(self) -> tuple[Fraction, Fraction]:
        """Rational (cos, sin), to 1e-12 where they are not: for what is decided to the precision of balls."""
        if isinstance(self.cos, Fraction) and isinstance(self.sin, Fraction):
            return self.cos, self.sin
        return rational_circle(atan2(self.sin, self.cos))

    @property
    def quarters(self) -> int | None:
        """0, 1, 2 or 3 quarter turns; None for another angle."""
        if (self.cos, self.sin) in _QUARTERS:
            return _QUARTERS.index((self.cos, self.sin))
        return None


@dataclass(frozen=True, slots=True)
class JointAndLink:
    """Joint i and the link after it.

    Attributes:
        kind: of the joint.
        phase: θ_i at q = 0 (for a slide its constant angle).
        shift: b θ_i = q_i + shift [rad], b the part: 0 where the phase is a whole number of quarter turns, which
            `phase` then holds; else the phase itself, and θ_i is what conditions speak of. 0 of a joint that follows
            another one.
        d: distance along axis i between the two normals [m], at q = 0 for a slide.
        a: distance between axes i and i+1 along the normal [m].
        twist: from axis i to axis i+1 about the normal.
        variable: number of the variable that moves the joint, from 1.
        multiplier: m of the joint: its angle is phase + m θ_v, its distance d + m q_v, with v the variable; whole for
            an angle. The part for a turning joint that is a variable of its own, 1 for a slide.
        part: b of the variable: conditions speak of θ_v, of which b make the variable's own angle; mostly 1.
    """

    kind: JointKind
    phase: ExactAngle
    shift: float
    d: Fraction
    a: Fraction
    twist: ExactAngle
    variable: int
    multiplier: Fraction
    part: int = 1

    @property
    def rate(self) -> Fraction:
        """How fast the joint moves when its variable does, 1 for a variable of its own."""
        return self.multiplier / self.part


@dataclass(frozen=True, slots=True)
class Deviation:
    """A number of the arm that is not quite another one.

    Attributes:
        kind: "twist", "angle" (about an axis), "a" or "d": what the derivation rounds; of the tip "a", "y" and "d", its
            x, y and z. "point" (three axes nearly meet in one) or "parallel" (two axes nearly are): near structure.
        joints: numbers, from 1; n + 1 for the tip.
        miss: by how much [rad, m].
        given: the number that is rounded [rad, m]; 0 of near structure.
        counted: length that counts as one metre where the miss is told [m].
    """

    kind: str
    joints: tuple[int, ...]
    miss: float
    given: float = 0.0
    counted: float = 1.0


def sections(robot: Robot, unit: float = 1.0) -> tuple[tuple[JointAndLink, ...], tuple[Deviation, ...]]:
    """The n sections of a chain, the last one up to the tip's foot on the last axis, and what was rounded.

    Args:
        robot: revolute and prismatic joints; one that follows another is of its leader's kind.
        unit: in metres, of its lengths.

    Returns:
        (sections, roundings): a rounding for each twist, phase or length that is changed by more than the noise of
        floating-point numbers.

    Raises:
        RobotError: a helical joint, or one that follows another in a way that is not algebraic.
    """
    _check(robot)
    parts = parts_of(robot)
    lines, normals = _lines_and_normals(robot)
    angles = [_angle(normals[i][0], normals[i + 1][0], line[0]) for i, line in enumerate(lines)]
    shifts = {joint.name: _shift(joint, angle) for joint, angle in zip(robot.joints, angles, strict=True)}
    roundings: list[Deviation] = []
    out = []
    for i, joint in enumerate(robot.joints):
        (_, _, start), (after, near, far), z = normals[i], normals[i + 1], lines[i][0]
        angle, distance, twist = angles[i], float((near - start) @ z), turn(0.0)
        turns = joint.kind is JointKind.REVOLUTE
        part = parts[robot.drivers[i]]
        multiplier = Fraction(round(part * joint.multiplier) if turns else repr(float(joint.multiplier)))
        # φ + m q + b = (φ + b − m s) + m θ, where θ = q + s is what conditions speak of; s = 0 of a slide
        if joint.mimic is None:
            shift = shifts[joint.name]
        else:
            shift = 0.0
        if joint.mimic is not None and turns:
            angle = remainder(angle + joint.offset - joint.multiplier * shifts[joint.driver], 2 * pi)
        elif joint.mimic is not None:
            distance += joint.offset
        phase = turn(0.0 if shift else angle)
        lengths = {"d": distance, "a": 0.0}
        if i + 1 < len(robot.joints):
            next_z = lines[i + 1][0]
            twist = turn(atan2(float(np.cross(z, next_z) @ after), float(z @ next_z)))
            lengths["a"] = float((far - near) @ after)
        exact = {which: _length(value) for which, value in lengths.items()}
        errors = {
            "angle": (angle, phase.error), "twist": (float(twist), twist.error),
            **{which: (value, value - float(exact[which])) for which, value in lengths.items() if exact[which]},
        }  # fmt: skip
        for what, (value, error) in errors.items():
            if abs(error) > _NOISE[what]:
                size = unit if what in "ad" else 1.0
                roundings.append(Deviation(what, (i + 1,), size * error, size * value))
        variable = robot.drivers[i] + 1
        out.append(JointAndLink(joint.kind, phase, shift, exact["d"], exact["a"], twist, variable, multiplier, part))
    return tuple(out), tuple(roundings)


def _angle(before: Array, after: Array, z: Array) -> float:
    """Angle about an axis from the normal before it to the one after [rad]."""
    return atan2(float(np.cross(before, after) @ z), float(before @ after))


def _shift(joint: Joint, angle: float) -> float:
    """θ − q of a joint with this angle at q = 0: 0 where that is a whole number of quarter turns [rad]."""
    if joint.kind is JointKind.REVOLUTE and turn(angle).quarters is None:
        return angle
    return 0.0


def tip_roundings(tip: Array, joint: int, unit: float) -> tuple[Deviation, ...]:
    """Coordinates of the tip in the frame of the last link that `decimals` changes, as roundings of a joint more."""
    coordinates = zip("ayd", map(float, tip), map(float, decimals(tip)), strict=True)
    return tuple(
        Deviation(kind, (joint,), unit * (given - exact), unit * given)
        for kind, given, exact in coordinates if abs(given - exact) > _NOISE["a"]
    )  # fmt: skip


def turn(angle: float) -> ExactAngle:
    """The angle as a multiple of 15° or 18° where it is that to `ALIGNED`, else by a rational tangent of its half.

    The rational differs from tan(angle / 2) by less than 1e-12.
    """
    whole = min((step * round(degrees(angle) / step) for step in (90, 15, 18)), key=lambda x: abs(angle - radians(x)))
    error = angle - radians(whole)
    if abs(error) > ALIGNED:
        c, s = rational_circle(angle)
        return ExactAngle(c, s, remainder(angle - atan2(s, c), 2 * pi))
    quarters, rest = divmod(whole, 90)
    cosine, sine = surd(rest)
    for _ in range(quarters % 4):
        cosine, sine = -sine, cosine
    return ExactAngle(cosine, sine, error)


def rational_circle(angle: float) -> tuple[Fraction, Fraction]:
    """(cos, sin) by a rational tangent of half the angle, of at most six digits above and below."""
    t = Fraction(tan(angle / 2)).limit_denominator(10**6)
    return (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)


def exact_cosine(value: float) -> Number:
    """The cosine of a multiple of 15° or 18° where a number is that, else its decimal of `DIGITS` places."""
    cosine = turn(acos(max(-1.0, min(1.0, value)))).cos
    if abs(float(cosine) - value) <= _NOISE["twist"]:
        return cosine
    return decimals([value])[0]


def _length(value: float) -> Fraction:
    if abs(value) < NOTHING:  # below the grid a file's zero is read to
        return Fraction(0)
    return Fraction(f"{round(value, DIGITS):.{DIGITS}f}")


def _check(robot: Robot) -> None:
    kinds = {joint.name: joint.kind for joint in robot.joints}
    parts = dict(zip((joint.name for joint in robot.variables), parts_of(robot), strict=True))
    for joint in robot.joints:
        where = f"robot {robot.name!r}, joint {joint.name!r}"
        if joint.kind is JointKind.HELICAL:
            raise RobotError(
                "the conditions of a helical joint are not algebraic",
                where=where,
                allowed="revolute, prismatic",
                mend="rankdrop analyze finds its singularities numerically",
            )
        if joint.mimic is None:
            continue
        leader = joint.mimic.leader
        if kinds[leader] is not joint.kind:
            raise RobotError(
                "conditions are not algebraic where a slide follows a turning joint, or a turning joint a slide",
                where=where,
                got=f"{joint.kind} mimic of {kinds[leader]} joint {leader!r}",
                allowed="a joint of the same kind as the one it follows",
                mend="rankdrop analyze finds its singularities numerically",
            )
        if joint.kind is JointKind.REVOLUTE and not _is_whole(joint.multiplier * parts[joint.driver]):
            raise RobotError(
                "exact conditions need a multiplier that is whole, or a fraction of small numbers: else the sine of "
                "the follower's angle is no polynomial in the sine and cosine of a part of its leader's",
                where=where,
                got=f"{joint.multiplier:.12g} times {leader!r}",
                allowed=f"fractions p/q, to 12 digits, with p and the common denominator of all joints that follow "
                f"{leader!r} up to {LARGEST}",
                mend="write the fraction with all digits (0.666666666666667); or rankdrop analyze finds its "
                "singularities numerically",
            )


def _is_whole(multiplier: float) -> bool:
    """Whether cos and sin of a follower's angle are polynomials in those of its leader's, of degree up to `LARGEST`."""
    return abs(multiplier - round(multiplier)) <= _NOISE["angle"] and abs(multiplier) <= LARGEST


def first_and_last(robot: Robot) -> tuple[Array, Array]:
    """Frames (4, 4) at q = 0, in the base: before joint 1 (z its axis, x the first normal), and at the last normal's
    foot on axis n (z that axis, x as the last normal).
    """
    lines, normals = _lines_and_normals(robot)
    first, last = normals[0], normals[-1]
    return (
        frame_at(first[0], lines[0][0], first[2]),
        frame_at(last[0], lines[-1][0], last[1]),
    )


def _lines_and_normals(robot: Robot) -> tuple[list[Line], list[Normal]]:
    length = ALIGNED * reach(robot)
    lines = axis_lines(robot, length=length)
    return lines, common_normals(robot, lines, angle=ALIGNED, length=length)


def decimals(values: Iterable[float]) -> list[Fraction]:
    """Numbers as rationals of `DIGITS` decimals."""
    return [Fraction(f"{x:.{DIGITS}f}") for x in values]


def named_lengths(
    robot: Robot,
    links: Sequence[JointAndLink],
    lengths: str | Mapping[str, float],
    tip: Sequence[Fraction] | None,
) -> tuple[dict[str, Fraction], dict[Place, tuple[int, str]]]:
    """Letters with their values [m], and how each length reads: sign and letter. What is absent stays a number.

    Args:
        robot: its own letters come first.
        links: twists, lengths and phases along the chain.
        lengths: as in `exact_chain`.
        tip: (3,) position of the tip in the frame of the last link [m], for tasks that depend on it.

    Raises:
        OptionError: a letter that means something else in conditions, or that no length has.
    """
    given = _letter_values(lengths)
    values = _values(links, tip)
    if lengths == "numbers" or (lengths == "auto" and _without_structure(links, values)):
        return {}, {}
    if isinstance(lengths, str):
        letters = _own_letters(robot)
    else:
        letters = dict(given)
    named = {*letters}
    written: dict[Place, tuple[int, str]] = {}
    for (i, which), value in values.items():
        # a distance along an axis and one across it may agree by chance: they keep letters of their own, unless named
        same = [x for x, known in letters.items() if abs(known) == abs(value) and (x in named or x[0] == which)]
        if given and not same:
            continue
        if same:
            name = min(same, key=lambda x: x[0] != which)
        else:
            name = _free(f"{which}{min(i + 1, len(links))}", letters)
        letters.setdefault(name, value)
        written[i, which] = (1 if letters[name] == value else -1, name)
    used = {name for _, name in written.values()}
    _check_used({name: value for name, value in given.items() if name not in used}, values)
    return {name: value for name, value in letters.items() if name in used}, written


def _check_used(unused: Mapping[str, Fraction], values: Mapping[Place, Fraction]) -> None:
    if unused:
        raise OptionError(
            "no length of the arm has this value",
            where="lengths",
            got=", ".join(f"{name} = {float(value)} m" for name, value in unused.items()),
            allowed=", ".join(f"{which}{i + 1} = {float(v)} m" for (i, which), v in values.items()),
        )


def _own_letters(robot: Robot) -> dict[str, Fraction]:
    """The letters that a robot names itself [m]."""
    own = {name: value for name, value in robot.lengths if name not in ROOTS}
    power = exponent(robot)
    known = decimals(shift_decimal(value, -power) for value in own.values())
    return {name: value * Fraction(10) ** power for name, value in zip(own, known, strict=True)}


def _letter_values(lengths: str | Mapping[str, float]) -> dict[str, Fraction]:
    """The caller's letters; none where a word was said."""
    if isinstance(lengths, str):
        if lengths not in ("auto", "letters", "numbers"):
            raise OptionError(
                "lengths are letters or numbers",
                got=repr(lengths),
                allowed="auto, letters, numbers, or letter = value",
            )
        return {}
    for name in lengths:
        if not is_letter(name) or name in ROOTS:
            raise OptionError(
                "a length cannot have this name", where="lengths", got=repr(name), allowed=LETTERS_ALLOWED
            )
    return {name: Fraction(str(value)) for name, value in lengths.items()}


def _values(links: Sequence[JointAndLink], tip: Sequence[Fraction] | None) -> dict[Place, Fraction]:
    """Every length other than 0 that conditions may depend on; index n is the tip."""
    last = len(links)
    # neither the first nor the last offset moves a screw against another one
    places = [(i, which) for i in range(last) for which in "da" if 0 < i < last - 1 or (i, which) == (0, "a")]
    values: dict[Place, Fraction] = {place: getattr(links[place[0]], place[1]) for place in places}
    if tip is not None:
        values |= {(last, "a"): tip[0], (last, "d"): tip[2]}
    return {place: value for place, value in values.items() if value != 0}


def _without_structure(links: Sequence[JointAndLink], values: Mapping[Place, Fraction]) -> bool:
    """Whether letters would make conditions too long: several twists that are no quarter turns, or many lengths."""
    turns = flat_map(lambda s: (s.twist, s.phase), links)  # the phase of a variable that turns is of quarter turns
    odd = {abs(float(t.sin)) for t in turns if t.quarters is None}
    return len({abs(value) for value in values.values()}) > MANY or len(odd) > ODD


def _free(name: str, taken: Container[str]) -> str:
    """The name, with as many _ behind it as make it a new one."""
    while name in taken:
        name += "_"
    return name
