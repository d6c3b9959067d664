"""An irreducible closed set of configurations, exactly.

Some joints are pinned at simple angles; each further condition is solved, where it can be, for a variable it is linear
in:  t_k = N / D  with N and D in the variables that are left. What cannot be solved so is kept as an irreducible
polynomial. Such a set is given by its free variables, so a random point of it is found by filling in, modulo a prime,
and a polynomial vanishes on the whole set when it vanishes at a random point of it (see `field`).
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

from rankdrop.exact.algebra.field import (
    PRIMES,
    Evaluator,
    P,
    Point,
    common_zeros,
    complete,
    half_evaluator,
    half_value,
    put_common_zero,
    roots,
    stands,
    trig_evaluator,
)
from rankdrop.exact.algebra.polynomial import TANGENT, Polynomial, used
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.algebra.solving import Solved

_TRIES = 80
_FIRST = 16  # of them modulo the first prime; then modulo each of the others in turn, which have other roots
_PLANES = 12  # on which a set that has points modulo each prime is missed with a chance of 6e-6
_POINTS = 2  # random points on which something has to hold to be believed: one would do, to within 1e-15


@dataclass(frozen=True, eq=False)
class Variety:
    """An irreducible closed set of configurations.

    Attributes:
        ring: of its polynomials.
        pins: simple angles (out of `atom.SIMPLE`) of pinned joints, by number.
        solved: conditions solved for one variable each; a later one may use what an earlier one has left free.
        rest: irreducible conditions that are not linear in any variable. Two of them may hold on several sets: then
            `also` and `apart` tell which of these are meant, and everything is asked at points of every one of them.
            Each further one is in a variable that those before it are not in, for which it is solved.
        also: trigonometric polynomials that vanish on this set.
        apart: trigonometric polynomials that vanish nowhere on it: an open part of what the conditions hold on.
        equations: irreducible half-angle polynomials that vanish on the set; with the pins they are its conditions.
        known: more half-angle polynomials that vanish on it. Where the denominator of a solution vanishes the equations
            may say nothing of a variable, on sets as large as this one; these, which they were made from, still do.
    """

    ring: Ring
    pins: Mapping[int, str]
    solved: tuple[Solved, ...] = ()
    rest: tuple[Polynomial, ...] = ()
    also: tuple[Polynomial, ...] = ()
    apart: tuple[Polynomial, ...] = ()
    equations: tuple[Polynomial, ...] = ()
    known: tuple[Polynomial, ...] = ()

    @classmethod
    def whole(cls, ring: Ring) -> Variety:
        """Every configuration."""
        return cls(ring, {})

    @property
    def codimension(self) -> int:
        """Number of joints less the dimension."""
        return len(self.pins) + len(self.solved) + len(self.rest)

    @property
    def dimension(self) -> int:
        """Freedoms of the arm on it."""
        return self.ring.moving - self.codimension

    @cached_property
    def key(self) -> str:
        """Text that tells this set's conditions."""
        pins = ",".join(f"θ{j}={value}" for j, value in sorted(self.pins.items()))
        return pins + "|" + ";".join(sorted(map(str, self.equations)))

    def point(self, rng: random.Random) -> Point | None:
        """A random point of the set modulo a prime; None where none was met (some sets have none: 1 + t² = 0)."""
        ring, evaluate = self.ring, half_evaluator(self.ring)
        for number in range(_TRIES):
            values = self._start(rng, P if number < _FIRST else PRIMES[number % len(PRIMES)])
            if not self._solve_rest(values, rng) or not self._fill_in(values, evaluate):
                continue
            point = complete(ring, values, self.pins)
            if point is not None and self._chosen(point):
                return point
        return None

    def _start(self, rng: random.Random, prime: int) -> Point:
        """Random values of all variables, the pinned ones aside."""
        values = Point({name: rng.randrange(2, prime) for name in self.ring.names}, prime)
        values.update((f"t{j}", TANGENT[value] % prime) for j, value in self.pins.items() if value != "pi")
        return values

    def _chosen(self, point: Point) -> bool:
        evaluate = trig_evaluator(self.ring)
        return all(evaluate(p, point) == 0 for p in self.also) and all(evaluate(p, point) for p in self.apart)

    def _fill_in(self, values: Point, evaluate: Evaluator) -> bool:
        prime = values.prime
        for one in reversed(self.solved):
            bottom = evaluate(one.denominator, values)
            if bottom == 0:
                return False
            values[self.ring.names[one.place]] = evaluate(one.numerator, values) * pow(bottom, -1, prime) % prime
        return True

    def _solve_rest(self, values: Point, rng: random.Random) -> bool:
        """Fill in values of as many variables as there are unsolved conditions."""
        if not self.rest:
            return True
        ring, evaluate = self.ring, half_evaluator(self.ring)
        taken = {one.place for one in self.solved}
        places = [[p for p in used(f) if p < ring.moving and p not in taken] for f in self.rest]
        if len(self.rest) == 1:
            name = ring.names[rng.choice(places[0])]
            found = roots(evaluate.in_one(self.rest[0], name, values), values.prime)
            if found:
                values[name] = rng.choice(found)
            return bool(found)
        f, g = self.rest[:2]
        pairs = [(a, b) for a in places[0] for b in places[1] if a != b]
        if not pairs:
            return False
        a, b = (ring.names[p] for p in rng.choice(pairs))
        if not put_common_zero(evaluate, f, g, (a, b), values, rng):
            return False
        towers = list(self._towers(values, 2, evaluate))
        if towers:
            values.update(rng.choice(towers))
        return bool(towers)

    def _towers(self, values: Point, place: int, evaluate: Evaluator) -> Iterator[Point]:
        """All ways to solve the conditions from the third on, one after the other, each for a variable of its own."""
        if place >= len(self.rest):
            yield values
            return
        own = self._own(place)
        if own is None:
            return
        name = self.ring.names[own]
        for root in roots(evaluate.in_one(self.rest[place], name, values), values.prime):
            yield from self._towers(values.changed({name: root}), place + 1, evaluate)

    def _own(self, place: int) -> int | None:
        """A variable of an unsolved condition that those before it are not in; None where there is none."""
        before = {p for f in self.rest[:place] for p in used(f)} | {one.place for one in self.solved}
        return next((p for p in used(self.rest[place]) if p < self.ring.moving and p not in before), None)

    def points(self, rng: random.Random, count: int = _POINTS) -> list[Point]:
        """Random points modulo primes, fewer than `count` where they are not met."""
        found = (self.point(rng) for _ in range(count))
        return [point for point in found if point is not None]

    @property
    def several(self) -> bool:
        """Whether the conditions may hold on several irreducible sets at once."""
        return len(self.rest) > 1

    @cached_property
    def samples(self) -> list[Point]:
        """Random points, always the same: two, or, where there may be several sets, some on every one of them."""
        rng = random.Random(self.key)
        return list(self._spread(rng)) if self.several else self.points(rng, _POINTS)

    def _spread(self, rng: random.Random) -> Iterator[Point]:
        """All points on planes in which two variables move and the others stand still at random.

        Every irreducible set of the codimension of the two conditions meets such planes of some pair of variables. It
        has no zero on one of them with a chance of 1/e at most, on all `_PLANES` with 6e-6. A set that is irreducible
        over the rationals alone, such as t² = 53, has zeros modulo some primes only: each plane has its own, and
        where the variables have single values every prime is tried.
        """
        ring, evaluate = self.ring, half_evaluator(self.ring)
        taken = {one.place for one in self.solved}
        f, g = self.rest[:2]
        one, two = ({p for p in used(h) if p < ring.moving and p not in taken} for h in (f, g))
        points = not ring.letters and len({p for h in self.rest for p in used(h)}) == len(self.rest)
        pairs = [
            (a, b) for a, b in combinations(sorted(one | two), 2) if (a in one and b in two) or (b in one and a in two)
        ]
        for a, b in pairs:
            names = ring.names[a], ring.names[b]
            for prime in PRIMES if points else PRIMES[:_PLANES]:
                values = self._start(rng, prime)
                two_in = (evaluate.in_two(h, *names, values) for h in (f, g))
                zeros = (values.changed(dict(zip(names, zero, strict=True))) for zero in common_zeros(*two_in))
                for here in (tower for zero in zeros for tower in self._towers(zero, 2, evaluate)):
                    point = complete(ring, here, self.pins) if self._fill_in(here, evaluate) else None
                    if point is not None and self._chosen(point):
                        yield point

    def parted(self, p: Polynomial, f: Polynomial) -> tuple[Variety | None, Variety | None]:
        """The sets among several on which a condition holds, and those on which it does not; None for no such set.

        Args:
            p: trigonometric polynomial.
            f: half-angle polynomial with the same zeros, for the equations.
        """
        evaluate = trig_evaluator(self.ring)
        values = [evaluate(p, point) for point in self.samples]
        inside = replace(self, also=(*self.also, p), equations=(*self.equations, f))
        outside = replace(self, apart=(*self.apart, p))
        for part, zero in ((inside, True), (outside, False)):
            kept = [point for point, value in zip(self.samples, values, strict=True) if (value == 0) == zero]
            part.__dict__["samples"] = kept  # what is known already is not looked for again
        if not inside.samples:
            return None, self
        return (self, None) if not outside.samples else (inside, outside)

    def vanishes(self, p: Polynomial) -> bool:
        """Whether a trigonometric polynomial is zero on the whole set."""
        evaluate = trig_evaluator(self.ring)
        return bool(self.samples) and all(evaluate(p, point) == 0 for point in self.samples)

    def half_vanishes(self, f: Polynomial) -> bool:
        """Whether a half-angle polynomial is zero on the whole set, the joints at π included."""
        there = {j: "pi" for j, value in self.pins.items() if value == "pi"}
        f = self.ring.half_at(f, there)
        if f == 0:
            return True
        evaluate = half_evaluator(self.ring)
        return bool(self.samples) and all(evaluate(f, point) == 0 for point in self.samples)

    def stands(self, joint: int, value: str) -> bool:
        """Whether a revolute joint is at a simple angle on the whole set."""
        return bool(self.samples) and all(stands(point, joint, value) for point in self.samples)

    def holds_at(self, points: Sequence[Point]) -> bool:
        """Whether every condition of this set holds at points modulo primes that give values to all its variables."""
        trig = trig_evaluator(self.ring)
        return all(
            all(stands(point, joint, value) for joint, value in self.pins.items())
            and not any(half_value(self.ring, f, point) for f in (*self.equations, *self.known))
            and not any(trig(p, point) for p in self.also)
            for point in points
        )

    def satisfies(self, other: Variety) -> bool:
        """Whether every condition of another set holds on this one.

        The conditions may hold elsewhere too: with A t + B = 0 and a third condition, also where A = B = 0. So this set
        need not lie inside the other one: see `inside`.
        """
        if self.codimension < other.codimension or not self.samples:
            return False
        return other.holds_at(self.samples)

    def inside(self, other: Variety) -> bool:
        """Whether this set lies inside another one; False, too, where that is open.

        It is where the conditions hold and every solution of the other set exists. Where a denominator vanishes on
        this set, points of it may or may not be limits of points of the other.
        """
        return self.satisfies(other) and all(other._solves(point) for point in self.samples)

    def _solves(self, point: Point) -> bool:
        """Whether every solution exists at a point and is the one there, and the point is in the part that is meant."""
        ring, evaluate = self.ring, half_evaluator(self.ring)
        trig = trig_evaluator(ring)
        if not all(trig(p, point) for p in self.apart):
            return False
        far = {j: "pi" for j in ring.revolute if f"t{j}" not in point}
        for one in self.solved:
            if ring.names[one.place] not in point:
                return False
            degrees = tuple(map(max, one.numerator.degrees(), one.denominator.degrees()))
            bottom, top = (ring.half_at(f, far, degrees) for f in (one.denominator, one.numerator))
            divisor = evaluate(bottom, point)
            if divisor == 0 or (point[ring.names[one.place]] * divisor - evaluate(top, point)) % point.prime:
                return False
        return True


def independent(found: Sequence[Variety]) -> list[Variety]:
    """The sets that lie in no other one."""
    kept: list[Variety] = []
    for one in sorted(found, key=lambda v: v.codimension):
        if not any(one.inside(other) for other in kept):
            kept.append(one)
    return kept
