"""Derived families in q and in the arm's unit, assumptions on the lengths, and irreducible sets put together in rows.

A family is the record of `families/record.py`; `Family.exact` holds its polynomials.

`tidy` shortens the conditions of a set by the sums of angles that are constant on it, which are found at random points:
θ5 = θ3 + π is seen at once there, among resultants it is not. `merge` puts sets that differ in one simple angle, or in
one sum of angles by π, into one row.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from itertools import combinations, product
from math import cos, pi, remainder
from typing import TypeVar

import numpy as np

from rankdrop.algebra.decompose import decompose
from rankdrop.algebra.field import Point
from rankdrop.algebra.polynomial import SIMPLE, Polynomial, primitive, used_by
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.work import Work
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact.arm.chain import numbers_in_units, polynomial_in_units
from rankdrop.exact.arm.parts import parts_of, scale_angle, values_in_turns, whole_angles
from rankdrop.families.evidence import FamilyEvidence, ObtainedFrom
from rankdrop.families.record import ExactConditions, Family, Pin, exact_of
from rankdrop.formula.equation import Equation
from rankdrop.formula.writing import AnglePin, Condition, pin_of
from rankdrop.lists import flat_map
from rankdrop.robot.model import Robot
from rankdrop.sections import words_of
from rankdrop.units import exponent, into_units

EVIDENCE = FamilyEvidence(ObtainedFrom.EXACT)
"""Of families that were derived."""
Stated = AnglePin | Condition
"""A condition that was derived."""


def pins_in_q(robot: Robot, pins: Iterable[AnglePin], shifts: Sequence[float]) -> tuple[Pin, ...]:
    """Joints at simple angles θ as values of q = θ − shift in (−π, π], under the names of the arm's joints.

    Of a part of an angle (`AnglePin.part`) they are those of the part.
    """
    in_q = []
    for pin in pins:
        values = tuple(_angle(angle - shifts[pin.joint - 1] / pin.part) for angle in pin.angles)
        in_q.append(Pin(robot.variables[pin.joint - 1].name, pin.joint, values))
    return tuple(in_q)


def slides_at_zero(robot: Robot, conditions: Iterable[Condition]) -> tuple[Pin, ...]:
    """Sliding joints that a condition q = 0 of their own holds, under the names of the arm's joints."""
    alone = [condition for condition in conditions if len(condition.polynomial) == 1 and len(condition.joints) == 1]
    joints = [condition.joints[0] for condition in alone if condition.joints[0] in condition.ring.prismatic]
    return tuple(Pin(robot.variables[joint - 1].name, joint, (0.0,)) for joint in joints)


def equations_of(
    stated: Iterable[Stated], numbers: Mapping[str, float], shifts: Sequence[float]
) -> tuple[Equation, ...]:
    """Conditions as equations in q with numbers for the lengths, as `analyze` has them."""
    return tuple(condition.equation(numbers, len(shifts), shifts) for condition in stated)


def polynomials_in_units(exact: ExactConditions, robot: Robot) -> tuple[Condition, ...]:
    """The polynomials of a family's conditions for the arm in its own unit of length, `units.in_units(robot)`."""
    power = exponent(robot)
    return tuple(
        Condition(condition.ring, polynomial_in_units(condition.polynomial, exact.numbers, power))
        for condition in exact.polynomials
    )


def derived_in_units(family: Family, robot: Robot, numbers: Mapping[str, float] | None = None) -> Family:
    """A derived family of an arm as one of `units.in_units(robot)`, with equations made of its polynomials again.

    Args:
        family: with exact conditions, which stay those of the arm as given.
        robot: the arm as given, or one of the same kind.
        numbers: values of its letters [m]; None for those that the family was derived with.
    """
    parts = parts_of(robot)
    return replace(
        family,
        equations=tuple(scale_angle(equation, parts) for equation in equations_in_parts(family, robot, numbers)),
        witness=tuple(float(x) for x in into_units(robot, family.witness)),
    )


def equations_in_parts(
    family: Family, robot: Robot, numbers: Mapping[str, float] | None = None
) -> tuple[Equation, ...]:
    """The equations of `derived_in_units` in the variables of `in_parts(robot)`; arguments as there."""
    exact = exact_of(family)
    if numbers is None:
        numbers = exact.numbers
    stated: tuple[Stated, ...] = (*exact.pins, *polynomials_in_units(exact, robot))
    return equations_of(stated, numbers_in_units(numbers, exponent(robot)), exact.shifts)


def families_in_whole_angles(robot: Robot, families: Iterable[Family]) -> tuple[Family, ...]:
    """Families of `in_parts(robot)`, as they are derived, as those of the arm: their angles are b φ."""
    return tuple(_in_whole_angles(family, robot) for family in families)


def _in_whole_angles(family: Family, robot: Robot) -> Family:
    parts, exact = parts_of(robot), exact_of(family)
    if max(parts) == 1:
        return family

    def pin_in_whole_angles(pin: Pin) -> Pin:
        place = pin.number - 1
        inside = partial(values_in_turns, part=parts[place], lower=robot.lower[place], upper=robot.upper[place])
        return replace(pin, values=tuple(flat_map(inside, pin.values)))

    return replace(
        family,
        pinned=tuple(map(pin_in_whole_angles, family.pinned)),
        equations=tuple(scale_angle(equation, parts) for equation in family.equations),
        witness=tuple(float(x) for x in whole_angles(robot, np.array(family.witness))),
        exact=replace(exact, pinned=tuple(map(pin_in_whole_angles, exact.pinned))),
    )


def _angle(value: float) -> float:
    angle = remainder(value, 2 * pi)
    return pi if angle <= -pi else angle


@dataclass(frozen=True, slots=True)
class EqualLengths:
    """Two lengths that are equal or opposite: length = sign · other.

    Attributes:
        length, other: letters.
        sign: 1 or −1.
    """

    length: str
    sign: int
    other: str


@dataclass(frozen=True, slots=True)
class SpecialFamily:
    """A family that an arm of special lengths has besides.

    Attributes:
        conditions: all of them, for people.
        corank: freedoms that it takes away.
    """

    conditions: tuple[str, ...]
    corank: int


@dataclass(frozen=True, slots=True)
class Assumption:
    """Lengths for which the derivation does not hold as it stands.

    Attributes:
        text: what was assumed: "d3 ≠ d5".
        holds: whether it is true of the arm's own lengths.
        derived: whether the special arm was derived.
        equal: the lengths for which it fails; None for other lengths than equal or opposite ones.
        families: the first families that the special arm has besides; none where it was not derived.
        more: number of its other families.
    """

    text: str
    holds: bool
    derived: bool
    equal: EqualLengths | None = None
    families: tuple[SpecialFamily, ...] = ()
    more: int = 0

    @property
    def words(self) -> str:
        """What happens where it fails: "if d3 = d5, θ4 = π alone loses two freedoms"; "" where nothing is known."""
        sentence: str = words_of(self).special_sentence(self)
        return sentence


class Unreal(StrEnum):
    """Why a set of lower rank is left out: no real configuration on it is known.

    PROVEN: the arm's lengths exclude one. NOT_FOUND: a search found none. NOR_MODULO_PRIMES: nor is a point modulo any
    of several primes.
    """

    PROVEN = "proven"
    NOT_FOUND = "not found"
    NOR_MODULO_PRIMES = "nor modulo primes"


@dataclass(frozen=True, slots=True)
class UnrealSet:
    """A set of lower rank on which no real configuration is known.

    Attributes:
        conditions: of the set, for people.
        reason: why it is left out.
        tried: random starts of the search, or primes.
        negative: where it is proven, the expression in the lengths that is negative, which excludes real points; ""
            where it is a number.
    """

    conditions: str
    reason: Unreal
    tried: int = 0
    negative: str = ""

    def __str__(self) -> str:
        """In words: "θ4 = 0: no real point was found from 96 random starts"."""
        words: str = words_of(self).unreal_words(self)
        return words


READABLE = 40
"""Terms of a set's conditions beyond which they are not written out."""
_MOST = 4  # joints in a sum
_SIMPLE = {(1, 0): "0", (-1, 0): "pi", (0, 1): "pi/2", (0, -1): "-pi/2"}  # by cosine and sine


def tidy(piece: ZeroSet, work: Work) -> ZeroSet:
    """The same set with its constant sums of angles among the conditions, and the other conditions shortened by them.

    Raises:
        OutOfTime: the deadline has passed.
    """
    if len(piece.equations) < 2 or piece.zero or not piece.samples:
        return piece
    ring = piece.ring
    relations = list(_relations(piece))
    if not relations or all(str(f) in {str(primitive(g)) for g in piece.equations} for f in relations):
        return piece
    most = piece.codimension - len(piece.pins)
    system = [ring.form(f) for f in (*relations, *piece.equations)]
    for other in decompose(ring, piece.pins, system, most, work):
        if other.codimension == piece.codimension and other.lies_inside(piece) and piece.lies_inside(other):
            return other
    return piece


def _relations(piece: ZeroSet) -> Iterator[Polynomial]:
    """Polynomials of Σ ± θ_j = 0, π or ±π/2 that hold on a set, for its joints that are bound together."""
    ring = piece.ring
    bound = {place for place in used_by(piece.equations) if place < ring.angles}
    joints = [j for j in ring.revolute if ring.index[f"t{j}"] in bound]
    covered: list[set[int]] = []
    for size in range(2, _MOST + 1):
        for chosen in combinations(joints, size):
            if any(known <= set(chosen) for known in covered):
                continue
            for signs in product((1, -1), repeat=size - 1):
                turns = tuple(zip(chosen, (1, *signs), strict=True))
                f = _constant(ring, turns, piece.samples)
                if f is not None:
                    covered.append(set(chosen))
                    yield f
                    break


def _constant(ring: Ring, turns: tuple[tuple[int, int], ...], points: list[Point]) -> Polynomial | None:
    """The polynomial of Σ turns_j θ_j = value where that holds at all points for a simple value."""
    met = {_sum(turns, point) for point in points}
    if len(met) == 1:
        value = _SIMPLE.get(met.pop())
    else:
        value = None
    if value is None:
        return None
    real, imaginary = ring.half.constant(1), ring.half.constant(0)
    for joint, sign in turns:  # Π (1 + i sign t): its argument is half the sum
        t = ring.t[joint] * sign
        real, imaginary = real - imaginary * t, imaginary + real * t
    return primitive({"0": imaginary, "pi": real, "pi/2": imaginary - real, "-pi/2": imaginary + real}[value])


def _sum(turns: tuple[tuple[int, int], ...], point: Point) -> tuple[int, int]:
    """(cos, sin) of a sum of angles modulo the prime of a point, between −p/2 and p/2."""
    cosine, sine, prime = 1, 0, point.prime
    for joint, sign in turns:
        c, s = point[f"c{joint}"], sign * point[f"s{joint}"]
        cosine, sine = (cosine * c - sine * s) % prime, (sine * c + cosine * s) % prime
    return cosine - prime * (2 * cosine > prime), sine - prime * (2 * sine > prime)


_SAME = 1e-9  # cosines and sines of whole turns and quarters, to rounding

Merged = TypeVar("Merged")
Pins = dict[int, tuple[str, ...]]
"""Joint number -> the simple angles it stands at."""


@dataclass(frozen=True, eq=False)
class Row:
    """Irreducible sets in one row.

    Attributes:
        pins: every combination of these angles belongs to it.
        equations: half-angle polynomials that vanish on all of it; a product where a sum of angles is 0 or π.
        pieces: the sets.
    """

    pins: Pins
    equations: tuple[Polynomial, ...]
    pieces: tuple[ZeroSet, ...]

    @property
    def texts(self) -> tuple[str, ...]:
        """The conditions, for people."""
        return (
            *(pin_of(self.pieces[0].ring, *pin).text() for pin in sorted(self.pins.items())),
            *(Condition(self.pieces[0].ring, f).text() for f in sorted(self.equations, key=len)),
        )

    @property
    def terms(self) -> int:
        """Number of terms of all conditions but the pins."""
        return sum(map(len, self.equations))

    @property
    def text(self) -> str:
        """All conditions, or how long they are: they take time to be written shortly, and nobody reads them."""
        if self.terms <= READABLE:
            return ", ".join(self.texts)
        pins = (pin_of(self.pieces[0].ring, *pin).text() for pin in sorted(self.pins.items()))
        count = len(self.equations)
        return ", ".join([*pins, f"{count} condition{'s' if count > 1 else ''} of {self.terms} terms"])


def merge(pieces: Sequence[ZeroSet]) -> list[Row]:
    """Rows of sets with the same conditions whose simple angles form all combinations; large sets first.

    Two rows that differ in one sum of angles alone, which is x on the one and x + π on the other, become one too.
    """
    groups: dict[tuple[str, ...], list[Row]] = {}
    for piece in pieces:
        groups.setdefault(tuple(sorted(map(str, piece.equations))), []).append(row_of_set(piece))
    rows = [row for group in groups.values() for row in merge_pairs(group, _angles_joined)]
    return sorted(merge_pairs(rows, _sums_joined), key=_order)


def row_of_set(piece: ZeroSet) -> Row:
    """One set as a row of its own."""
    return Row({joint: (value,) for joint, value in sorted(piece.pins.items())}, tuple(piece.equations), (piece,))


def merge_pairs(rows: Sequence[Merged], join: Callable[[Merged, Merged], Merged | None]) -> list[Merged]:
    """Rows of which no two can be joined; where two were, the one row comes last."""
    kept = list(rows)
    while True:
        pairs = ((first, second, join(first, second)) for first, second in combinations(kept, 2))
        mergeable = next((pair for pair in pairs if pair[2] is not None), None)
        if mergeable is None:
            return kept
        first, second, both = mergeable
        kept = [*(row for row in kept if row is not first and row is not second), *([] if both is None else [both])]


def _angles_joined(first: Row, second: Row) -> Row | None:
    """Two rows that differ in the angles of one joint alone as one; None for others."""
    joint = _different(first.pins, second.pins)
    if joint is None:
        return None
    values = tuple(sorted({*first.pins[joint], *second.pins[joint]}, key=SIMPLE.index))
    return Row({**first.pins, joint: values}, first.equations, (*first.pieces, *second.pieces))


def _sums_joined(row: Row, other: Row) -> Row | None:
    """θ5 = θ3 and θ5 = θ3 + π: sin(θ3 − θ5) = 0."""
    if row.pins != other.pins or len(row.equations) != len(other.equations):
        return None
    ring = row.pieces[0].ring
    mine, others = ({str(f): f for f in joined.equations} for joined in (row, other))
    left, right = ([f for text, f in a.items() if text not in b] for a, b in ((mine, others), (others, mine)))
    if len(left) != 1 or len(right) != 1:
        return None
    first, second = (Condition(ring, f).relation for f in (left[0], right[0]))
    if first is None or second is None or first[0] != second[0] or abs(cos((first[1] - second[1]) / 2)) > _SAME:
        return None
    kept = tuple(f for f in row.equations if f is not left[0])
    return Row(row.pins, (left[0] * right[0], *kept), (*row.pieces, *other.pieces))


def _different(first: Pins, second: Pins) -> int | None:
    if set(first) != set(second):
        return None
    joints = [joint for joint in first if first[joint] != second[joint]]
    if len(joints) == 1:
        return joints[0]
    return None


def _order(row: Row) -> tuple[object, ...]:
    """Sort key of rows: large sets first, then few and short conditions."""
    piece = row.pieces[0]
    return piece.codimension, len(row.equations), sorted(row.pins.items()), sum(map(len, row.equations)), piece.key
