"""The records of exact conditions: a family, and what was assumed of the lengths."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import pi, remainder

import numpy as np

from rankdrop.exact.algebra.zeroset import ZeroSet
from rankdrop.exact.arm.chain import numbers_in_units, polynomial_in_units
from rankdrop.exact.writing import AnglePin, Condition
from rankdrop.family.equation import Equation
from rankdrop.family.record import Check, Family, Order, Pin, Sampled, place_of
from rankdrop.robot.model import Robot
from rankdrop.units import exponent, into_units


@dataclass(frozen=True, eq=False)
class ExactFamily:
    """One family of singular configurations, exactly.

    Attributes:
        id: "k1.f1": corank 1, first family.
        name: as `analyze` names it.
        corank: rank lost on the family.
        dimension, codimension: of the family in joint space, and what it lacks of the number of joints.
        pins: joints at simple angles: every combination belongs to the family.
        conditions: what else has to hold, irreducible polynomials; all of them at once.
        free, coupled: numbers of the joints that do not matter, and of those in `conditions`.
        reality: "" where the family is real whatever the lengths are; else when it is, in words.
        witness: a real configuration on it, of exactly this corank [rad, m].
        lost_words: the motions lost, one sentence each.
        rank_check: exact rank modulo a prime at random points of the family: is it as claimed?
        numbers: values of the letters [m].
        shifts: θ = q + shift, per joint [rad].
        pieces: its irreducible sets, one for each combination of pins.
    """

    id: str
    name: str
    corank: int
    dimension: int
    codimension: int
    pins: tuple[AnglePin, ...]
    conditions: tuple[Condition, ...]
    free: tuple[int, ...]
    coupled: tuple[int, ...]
    reality: str
    witness: tuple[float, ...]
    lost_words: tuple[str, ...]
    rank_check: Check
    numbers: dict[str, float]
    shifts: tuple[float, ...]
    pieces: tuple[ZeroSet, ...]

    def in_units(self, robot: Robot) -> ExactFamily:
        """A family of an arm as one of `units.in_units(robot)`: its equations and its witness."""
        power = exponent(robot)
        return replace(
            self,
            conditions=tuple(
                Condition(one.ring, polynomial_in_units(one.polynomial, self.numbers, power)) for one in self.conditions
            ),
            witness=tuple(float(x) for x in into_units(robot, self.witness)),
            numbers=numbers_in_units(self.numbers, power),
        )

    def pinned(self, robot: Robot) -> tuple[Pin, ...]:
        """Its pins as values of q in (−π, π], under the names of the arm's joints."""
        return tuple(
            Pin(
                robot.variables[pin.joint - 1].name, pin.joint,
                tuple(_angle(angle - self.shifts[pin.joint - 1]) for angle in pin.angles),
            )
            for pin in self.pins
        )  # fmt: skip

    def as_family(self, robot: Robot) -> Family:
        """The family as `analyze` lists it, before any test: `robot` is the arm whose units it is in."""
        return Family(
            id=self.id, name=self.name, corank=self.corank, dimension=self.dimension, pinned=self.pinned(robot),
            free=self.free, coupled=self.coupled, equations=self.equations, witness=self.witness,
            lost_directions=np.empty((0, 6)), lost_words=self.lost_words,
            evidence=Sampled("exact condition", Check(0, 0), Check(0, 0)),
        )  # fmt: skip

    def place(self, robot: Robot) -> Order:
        """Its place among the families of its corank."""
        short_first = sorted(f"{len(one.polynomial):06} {one.polynomial}" for one in self.conditions)
        return place_of(self.dimension, self.pinned(robot), self.coupled, short_first)

    @property
    def stated(self) -> tuple[AnglePin | Condition, ...]:
        """Every condition, those of pinned joints first."""
        return (*self.pins, *self.conditions)

    @cached_property
    def texts(self) -> tuple[str, ...]:
        """Every condition for people: "θ4 = 0 or π", "a2 c2 + a3 c23 = 0"."""
        return tuple(one.text() for one in self.stated)

    @cached_property
    def latex(self) -> tuple[str, ...]:
        """Every condition as LaTeX mathematics."""
        return tuple(one.latex() for one in self.stated)

    @cached_property
    def equations(self) -> tuple[Equation, ...]:
        """Every condition as an equation in q with numbers for the lengths, as `analyze` has them."""
        n = len(self.shifts)
        return tuple(one.equation(self.numbers, n, self.shifts) for one in self.stated)


def _angle(value: float) -> float:
    angle = remainder(value, 2 * pi)
    return pi if angle <= -pi else angle


@dataclass(frozen=True, slots=True)
class Assumption:
    """Lengths for which the derivation does not hold as it stands.

    Attributes:
        text: what was assumed: "d3 ≠ d5".
        holds: whether it is true of the arm's own lengths.
        words: what happens where it fails: "if d3 = d5, θ4 = π alone loses two freedoms"; "" where nothing is known.
        derived: whether the special arm was derived.
    """

    text: str
    holds: bool
    words: str
    derived: bool
