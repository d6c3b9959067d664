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
from math import atan2, cos, pi, sin, tan

import numpy as np

from rankdrop.errors import OptionError, RobotError
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.numbers import Line, Normal, axis_lines, common_normals, frame_at, reach
from rankdrop.robot.quantities import LETTERS_ALLOWED, is_letter
from rankdrop.tolerances import ALIGNED, NOTHING
from rankdrop.units import exponent, shifted

DIGITS = 12
"""Lengths are read as decimals of so many places of the arm's own unit: far below any drawing, far above rounding."""


@dataclass(frozen=True, slots=True)
class Turn:
    """An angle by its rational cosine and sine.

    Attributes:
        cos, sin: exact, cos² + sin² = 1.
        error: the given angle less this one [rad].
    """

    cos: Fraction
    sin: Fraction
    error: float

    @property
    def quarters(self) -> int | None:
        """0, 1, 2 or 3 quarter turns; None for another angle."""
        found = {(1, 0): 0, (0, 1): 1, (-1, 0): 2, (0, -1): 3}
        return found.get((int(self.cos), int(self.sin))) if self.cos.denominator == self.sin.denominator == 1 else None


@dataclass(frozen=True, slots=True)
class Section:
    """Joint i and the link after it.

    Attributes:
        kind: of the joint.
        phase: θ_i at q = 0 (for a slide its constant angle).
        shift: θ_i = q_i + shift [rad]: 0 where the phase is a whole number of quarter turns, which `phase` then holds;
            else the phase itself, and θ_i is what conditions speak of.
        d: distance along axis i between the two normals [m], at q = 0 for a slide.
        a: distance between axes i and i+1 along the normal [m].
        twist: from axis i to axis i+1 about the normal.
    """

    kind: JointKind
    phase: Turn
    shift: float
    d: Fraction
    a: Fraction
    twist: Turn


def sections(robot: Robot) -> tuple[tuple[Section, ...], tuple[str, ...]]:
    """The n sections of a chain, the last one up to the tip's foot on the last axis, and what was rounded.

    Args:
        robot: revolute and prismatic joints, each a variable of its own.

    Returns:
        (sections, remarks): a remark for each twist, phase or length that had to be changed by more than rounding.

    Raises:
        RobotError: a helical or a mimic joint.
    """
    _check(robot)
    lines, normals = _lines_and_normals(robot)
    remarks: list[str] = []
    found = []
    for i, joint in enumerate(robot.joints):
        before, after = normals[i], normals[i + 1]
        z = lines[i].direction
        angle = atan2(float(np.cross(before.direction, after.direction) @ z), float(before.direction @ after.direction))
        phase = turn(angle)
        shift = 0.0
        if joint.kind is JointKind.REVOLUTE and phase.quarters is None:
            phase, shift = turn(0.0), angle
        twist = turn(0.0)
        a = Fraction(0)
        if i + 1 < len(robot.joints):
            next_z = lines[i + 1].direction
            twist = turn(atan2(float(np.cross(z, next_z) @ after.direction), float(z @ next_z)))
            a = _length(float((after.far - after.near) @ after.direction))
        d = _length(float((after.near - before.far) @ z))
        remarks += _rounded(phase, f"angle of slide {joint.name}") + _rounded(twist, f"twist after {joint.name}")
        found.append(Section(joint.kind, phase, shift, d, a, twist))
    return tuple(found), tuple(remarks)


def turn(angle: float) -> Turn:
    """The angle as whole quarter turns where it is that to `ALIGNED`, else by a rational tangent of its half.

    The rational differs from tan(angle / 2) by less than 1e-12.
    """
    quarters = round(angle * 2 / pi)
    error = angle - quarters * pi / 2
    if abs(error) <= ALIGNED:
        cosine, sine = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarters % 4]
        return Turn(Fraction(cosine), Fraction(sine), error)
    t = Fraction(tan(angle / 2)).limit_denominator(10**6)
    c, s = (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)
    return Turn(c, s, atan2(sin(angle - _angle(c, s)), cos(angle - _angle(c, s))))


def _angle(cosine: Fraction, sine: Fraction) -> float:
    return atan2(float(sine), float(cosine))


def _rounded(given: Turn, what: str) -> list[str]:
    if abs(given.error) <= 1e-12:
        return []
    degrees = np.degrees(_angle(given.cos, given.sin))
    return [f"{what} taken as {degrees:.10g}°, {abs(given.error):.1e} rad from the one given"]


def _length(value: float) -> Fraction:
    if abs(value) < NOTHING:  # below the grid a file's zero is read to
        return Fraction(0)
    return Fraction(f"{round(value, DIGITS):.{DIGITS}f}")


def _check(robot: Robot) -> None:
    for joint in robot.joints:
        where = f"robot {robot.name!r}, joint {joint.name!r}"
        if joint.kind is JointKind.HELICAL:
            raise RobotError(
                "the conditions of a helical joint are not algebraic",
                where=where,
                allowed="revolute, prismatic",
                mend="rankdrop analyze finds its singularities numerically",
            )
        if joint.mimic is not None:
            raise RobotError(
                "exact conditions are not derived for joints that follow others",
                where=where,
                got=f"mimic of {joint.mimic.leader!r}",
                mend="rankdrop analyze finds its singularities numerically",
            )


def first_and_last(robot: Robot) -> tuple[Array, Array]:
    """Frames (4, 4) at q = 0, in the base: before joint 1 (z its axis, x the first normal), and at the last normal's
    foot on axis n (z that axis, x as the last normal).
    """
    lines, normals = _lines_and_normals(robot)
    first, last = normals[0], normals[-1]
    return (
        frame_at(first.direction, lines[0].direction, first.far),
        frame_at(last.direction, lines[-1].direction, last.near),
    )


def _lines_and_normals(robot: Robot) -> tuple[list[Line], list[Normal]]:
    length = ALIGNED * reach(robot)
    lines = axis_lines(robot, length=length)
    return lines, common_normals(robot, lines, angle=ALIGNED, length=length)


def decimals(values: Iterable[float]) -> list[Fraction]:
    """Numbers as rationals of `DIGITS` decimals."""
    return [Fraction(f"{x:.{DIGITS}f}") for x in values]


MANY = 14
"""More different lengths than this stay numbers unless letters are asked for."""

ODD = 1
"""Different twists that are no quarter turns, such as the 60° of a wrist, beyond which lengths stay numbers."""

Place = tuple[int, str]
"""(index of a section, "a" or "d")."""


def named_lengths(
    robot: Robot,
    links: Sequence[Section],
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
    given = _given(lengths)
    values = _values(links, tip)
    if lengths == "numbers" or (lengths == "auto" and _without_structure(links, values)):
        return {}, {}
    own = dict(robot.lengths) if isinstance(lengths, str) else {}
    named = given or dict(zip(own, _decimals(own.values(), exponent(robot)), strict=True))
    letters = dict(named)
    written: dict[Place, tuple[int, str]] = {}
    for (i, which), value in values.items():
        # a distance along an axis and one across it may agree by chance: they keep letters of their own, unless named
        same = [x for x, known in letters.items() if abs(known) == abs(value) and (x in named or x[0] == which)]
        if given and not same:
            continue
        name = min(same, key=lambda x: x[0] != which) if same else _free(f"{which}{min(i + 1, len(links))}", letters)
        letters.setdefault(name, value)
        written[i, which] = (1 if letters[name] == value else -1, name)
    used = {name for _, name in written.values()}
    if not used >= set(given):
        raise OptionError(
            "no length of the arm has this value",
            where="lengths",
            got=", ".join(f"{name} = {float(value)} m" for name, value in given.items() if name not in used),
            allowed=", ".join(f"{which}{i + 1} = {float(v)} m" for (i, which), v in values.items()),
        )
    return {name: value for name, value in letters.items() if name in used}, written


def _decimals(values: Iterable[float], power: int) -> list[Fraction]:
    """Lengths as decimals of 10 to a power."""
    return [one * Fraction(10) ** power for one in decimals(shifted(value, -power) for value in values)]


def _given(lengths: str | Mapping[str, float]) -> dict[str, Fraction]:
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
        if not is_letter(name):
            raise OptionError(
                "a length cannot have this name", where="lengths", got=repr(name), allowed=LETTERS_ALLOWED
            )
    return {name: Fraction(str(value)) for name, value in lengths.items()}


def _values(links: Sequence[Section], tip: Sequence[Fraction] | None) -> dict[Place, Fraction]:
    """Every length other than 0 that conditions may depend on; index n is the tip."""
    last = len(links)
    # neither the first nor the last offset moves a screw against another one
    places = [(i, which) for i in range(last) for which in "da" if 0 < i < last - 1 or (i, which) == (0, "a")]
    values: dict[Place, Fraction] = {place: getattr(links[place[0]], place[1]) for place in places}
    if tip is not None:
        values |= {(last, "a"): tip[0], (last, "d"): tip[2]}
    return {place: value for place, value in values.items() if value != 0}


def _without_structure(links: Sequence[Section], values: Mapping[Place, Fraction]) -> bool:
    """Whether letters would make conditions too long: several twists that are no quarter turns, or many lengths."""
    turns = [t for s in links for t in (s.twist, *([s.phase] if s.kind is JointKind.PRISMATIC else []))]
    odd = {abs(t.sin) for t in turns if t.quarters is None}
    return len({abs(value) for value in values.values()}) > MANY or len(odd) > ODD


def _free(name: str, taken: Container[str]) -> str:
    """The name, with as many _ behind it as make it a new one."""
    while name in taken:
        name += "_"
    return name
