"""A set of configurations over the exact ring: what vanishes on it, and what does not.

Some joints are pinned at simple angles; each further condition is solved, where it can be, for a variable it is linear
in:  t_k = N / D  with N and D in the variables that are left. What cannot be solved so is kept as an irreducible
polynomial. Such a set is given by its free variables, so a random point of it is found by filling in, modulo a prime,
and a polynomial vanishes on the whole set when it vanishes at a random point of it (see `field`).

The rank tree's sets, the pieces of a case of a hand calculation, and what is left of a condition that a person wrote
are all such sets.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, permutations

from rankdrop.algebra.field import (
    ModularPoint,
    bivariate,
    common_zeros,
    complete,
    half_angle_value,
    holds,
    residue,
    roots,
    roots_at,
    slice_at,
    stands,
    univariate,
    value_at,
    zeros_in_space,
)
from rankdrop.algebra.polynomial import TANGENT, Atom, Polynomial, used_by, variables_in
from rankdrop.algebra.ring import Form, Ring
from rankdrop.algebra.roots import FURTHER, ROOTS, Number, primes_with
from rankdrop.algebra.solving import Solved
from rankdrop.lists import leave_out

_TRIES = 80
_FIRST = 16  # of them modulo the first prime; then modulo each of the others in turn, which have other roots
_PLANES = 12  # on which a set that has points modulo each prime is missed with a chance of 6e-6
_POINTS = 2  # random points on which something has to hold to be believed: one would do, to within 1e-15


@dataclass(frozen=True, eq=False)
class ZeroSet:
    """A constructible set of configurations: conditions = 0, and conditions ≠ 0.

    Attributes:
        ring: of its polynomials.
        pins: simple angles (out of `SIMPLE`) of pinned joints, by number.
        solved: conditions solved for one variable each; a later one may use what an earlier one has left free.
        rest: irreducible conditions that are not linear in any variable. With at most one the set is irreducible. Two
            of them may hold on several sets: then `zero` and `nonzero` tell which of these are meant, and everything is
            asked at points of every one of them. In the rank tree each further one is in a variable that those before
            it are not in, for which it is solved.
        zero: trigonometric polynomials that vanish on it besides.
        nonzero: atoms and trigonometric polynomials that vanish nowhere on it: an open part of what the others hold on.
        equations: irreducible half-angle polynomials that vanish on the set; with the pins they are its conditions.
        lengths: values of letters at its points; letters that are not named have random ones.
        known: more half-angle polynomials that vanish on it. Where the denominator of a solution vanishes the equations
            may say nothing of a variable, on sets as large as this one; these, which they were made from, still do.
    """

    ring: Ring
    pins: Mapping[int, str]
    solved: tuple[Solved, ...] = ()
    rest: tuple[Polynomial, ...] = ()
    zero: tuple[Polynomial, ...] = ()
    nonzero: tuple[Atom | Polynomial, ...] = ()
    equations: tuple[Polynomial, ...] = ()
    known: tuple[Polynomial, ...] = ()
    lengths: tuple[tuple[str, Number], ...] = ()

    @classmethod
    def whole(cls, ring: Ring) -> ZeroSet:
        """Every configuration."""
        return cls(ring, {})

    @classmethod
    def where_atom(cls, ring: Ring, atom: Atom) -> ZeroSet:
        """The configurations at which one atom holds."""
        equations = () if atom.is_pin else (atom.f,)
        return cls(ring, {atom.joint: atom.value} if atom.is_pin else {}, rest=equations, equations=equations)

    @cached_property
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

    def point(self, rng: random.Random) -> ModularPoint | None:
        """A random point of the set modulo a prime; None where none was met (some sets have none: 1 + t² = 0)."""
        if self._base > 2:
            if self.samples:
                return rng.choice(self.samples)
            return None
        for number in range(_TRIES):
            values = self._start(rng, self.ring.primes[0 if number < _FIRST else number % len(self.ring.primes)])
            if not self._solve_rest(values, rng) or not self._fill_in(values):
                continue
            point = complete(self.ring, values, self.pins)
            if point is not None and self._chosen(point):
                return point
        return None

    def _start(self, rng: random.Random, prime: int) -> ModularPoint:
        values = ModularPoint({name: rng.randrange(2, prime) for name in self.ring.names}, prime)
        values.update(roots_at(self.ring, prime))
        values.update((name, residue(value, prime)) for name, value in self.lengths)
        values.update((f"t{j}", TANGENT[value] % prime) for j, value in self.pins.items() if value != "pi")
        return values

    def _chosen(self, point: ModularPoint) -> bool:
        """Whether what else vanishes does at a point of the conditions, and what does not does not."""
        return all(value_at(self.ring, p, point) == 0 for p in self.zero) and not any(
            holds(self.ring, condition, point) for condition in self.nonzero
        )

    def _fill_in(self, values: ModularPoint) -> bool:
        """Give the solved variables their values; whether each has one."""
        prime = values.prime
        for solved in reversed(self.solved):
            bottom = value_at(self.ring, solved.denominator, values)
            if bottom == 0:
                return False
            top = value_at(self.ring, solved.numerator, values)
            values[self.ring.names[solved.place]] = top * pow(bottom, -1, prime) % prime
        return True

    def _solve_rest(self, values: ModularPoint, rng: random.Random) -> bool:
        """Change values of as many variables as there are unsolved conditions, so that these hold; whether they do.

        Conditions in a variable that no other one is in are solved for it at last; two that are left then are solved
        together; of more the long ones have to follow from the short ones.
        """
        names = {id(f): {self.ring.names[k] for k in self._moving(f)} for f in self.rest}
        waiting, last, implied = sorted(self.rest, key=len), list[tuple[Polynomial, str]](), list[Polynomial]()
        while waiting:
            alone = [(f, names[id(f)].difference(*(names[id(g)] for g in waiting if g is not f))) for f in waiting]
            free = [(f, sorted(mine)) for f, mine in alone if mine]
            if free:
                f, mine = rng.choice(free)
                last.append((f, rng.choice(mine)))
                waiting = [g for g in waiting if g is not f]
            elif len(waiting) > 2:
                implied.append(waiting.pop())
            elif len(waiting) == 2 and self._solve_pair(waiting, names, values, rng):
                break
            else:
                return False
        for f, name in reversed(last):
            line = univariate(self.ring, f, name, values)
            candidates = roots(line, values.prime)
            if any(line):  # else it follows from the others
                if not candidates:
                    return False
                values[name] = rng.choice(candidates)
        return all(value_at(self.ring, f, values) == 0 for f in implied)

    def _solve_pair(
        self, pair: list[Polynomial], names: Mapping[int, set[str]], values: ModularPoint, rng: random.Random
    ) -> bool:
        """Change values of two variables that two conditions share so that both hold; whether they do."""
        shared = sorted(names[id(pair[0])] & names[id(pair[1])])
        if len(shared) < 2:
            return False
        x, y = rng.sample(shared, 2)
        zeros = list(common_zeros(*(bivariate(self.ring, f, x, y, values) for f in pair)))
        if zeros:
            values.update(zip((x, y), rng.choice(zeros), strict=True))
        return bool(zeros)

    def _moving(self, f: Polynomial) -> list[int]:
        """Places of the variables of joints in a condition that no other one is solved for."""
        taken = {solved.place for solved in self.solved}
        return [place for place in variables_in(f) if place < self.ring.moving and place not in taken]

    def _towers(self, values: ModularPoint, place: int) -> Iterator[ModularPoint]:
        """All ways to solve the conditions from the third on, one after the other, each for a variable of its own."""
        if place >= len(self.rest):
            yield values
            return
        variable = self._new_variable(self._unsolved_in_order, place)
        if variable is None:
            return
        name = self.ring.names[variable]
        for root in roots(univariate(self.ring, self._unsolved_in_order[place], name, values), values.prime):
            yield from self._towers(values.replace_values({name: root}), place + 1)

    def _new_variable(self, conditions: Sequence[Polynomial], place: int) -> int | None:
        """A variable of one of some conditions that those before it are not in; None where there is none."""
        before = used_by(conditions[:place]) | {solved.place for solved in self.solved}
        return next((p for p in variables_in(conditions[place]) if p < self.ring.moving and p not in before), None)

    @cached_property
    def _unsolved_in_order(self) -> tuple[Polynomial, ...]:
        """The unsolved conditions: two, then those that have a variable of their own each; as given without such two.

        A short pair is preferred.
        """
        if len(self.rest) <= 2:
            return self.rest
        for pair in combinations(sorted(self.rest, key=len), 2):
            ordered = list(pair)
            waiting = leave_out(sorted(self.rest, key=len), pair)
            while waiting:
                top = next((f for f in waiting if self._new_variable([*ordered, f], len(ordered)) is not None), None)
                if top is None:
                    break
                ordered.append(top)
                waiting = [f for f in waiting if f is not top]
            if not waiting:
                return tuple(ordered)
        return self.rest

    def points(self, rng: random.Random, count: int = _POINTS) -> list[ModularPoint]:
        """Random points modulo primes, fewer than `count` where they are not met."""
        drawn = (self.point(rng) for _ in range(count))
        return [point for point in drawn if point is not None]

    @property
    def several(self) -> bool:
        """Whether the conditions may hold on several irreducible sets at once."""
        return len(self.rest) > 1

    def remove_zeros(self, *nonzero: Atom) -> ZeroSet:
        """The part on which none of some atoms vanishes."""
        return replace(self, nonzero=tuple(dict.fromkeys((*self.nonzero, *nonzero))))

    @cached_property
    def samples(self) -> list[ModularPoint]:
        """Random points, always the same: two, or, where there may be several sets, some on every one of them."""
        rng = random.Random(self.key)
        if not self.several:
            return self.points(rng, _POINTS)
        for primes in self._prime_rounds():
            drawn = self._spread(rng, primes)
            if drawn is None:
                return []
            if drawn:
                return drawn
        return []

    def _prime_rounds(self) -> Iterator[Sequence[int]]:
        """Primes for the slices of one round each: a further round where the ones before met no point at all.

        Where the variables have single values every prime of the ring is taken in one round: each has other roots.
        """
        ring = self.ring
        roots = tuple(name for name in ring.letters if name in ROOTS)
        places = {p for p in used_by(self.rest) if p < ring.moving or ring.names[p] not in ROOTS}
        if len(places) == len(self.rest) and max(places) < ring.moving:
            yield ring.primes
        else:
            yield ring.primes[:_PLANES]
        further = primes_with(roots, FURTHER)
        for start in range(0, len(further), _PLANES):
            yield further[start : start + _PLANES]

    @cached_property
    def _base(self) -> int:
        """How many unsolved conditions are solved together: three where the third has no variable of its own."""
        if len(self.rest) > 2 and self._new_variable(self._unsolved_in_order, 2) is None:
            return 3
        return 2

    def _spread(self, rng: random.Random, primes: Sequence[int]) -> list[ModularPoint] | None:
        """All points on slices in which two or three variables move and the others stand still at random.

        Every irreducible set of the codimension of the conditions meets such slices of some variables. It has no zero
        on one of them with a chance of 1/e at most, on all `_PLANES` with 6e-6. A set that is irreducible over the
        rationals alone, such as t² = 53, has zeros modulo some primes only: each slice has its own. Of a set that
        contains k such roots one after the other about one slice in 2^k has points.

        Returns:
            None where three conditions have zeros on a slice that are not isolated: then a set is larger than thought.
        """
        ring, first = self.ring, self._unsolved_in_order[: self._base]
        moving_of = [{*self._moving(f)} for f in first]
        points: list[ModularPoint] = []
        for moving in combinations(sorted(set.union(*moving_of)), len(first)):
            if not _has_matching(moving_of, moving):
                continue
            names = [ring.names[place] for place in moving]
            for prime in primes:
                values = self._start(rng, prime)
                forms = [slice_at(ring, h, names, values) for h in first]
                zeros = list(common_zeros(*forms)) if len(first) == 2 else zeros_in_space(forms)
                if zeros is None:
                    return None
                for zero in zeros:
                    points += self._above(values.replace_values(dict(zip(names, zero, strict=True))))
        return points

    def _above(self, values: ModularPoint) -> Iterator[ModularPoint]:
        """The points of the set at which the first conditions are solved."""
        for solved in self._towers(values, self._base):
            if self._fill_in(solved):
                point = complete(self.ring, solved, self.pins)
            else:
                point = None
            if point is not None and self._chosen(point):
                yield point

    def split_by_zero(self, p: Polynomial, f: Polynomial) -> tuple[ZeroSet | None, ZeroSet | None]:
        """The sets among several on which a condition holds, and those on which it does not; None for no such set.

        Args:
            p: trigonometric polynomial.
            f: half-angle polynomial with the same zeros, for the equations.
        """
        values = [value_at(self.ring, p, point) for point in self.samples]
        inside = replace(self, zero=(*self.zero, p), equations=(*self.equations, f))
        outside = replace(self, nonzero=(*self.nonzero, p))
        for part, zero in ((inside, True), (outside, False)):
            kept = [point for point, value in zip(self.samples, values, strict=True) if (value == 0) == zero]
            part.__dict__["samples"] = kept  # what is known already is not looked for again
        if not inside.samples:
            return None, self
        if not outside.samples:
            return (self, None)
        return (inside, outside)

    def saying(self, f: Polynomial, p: Polynomial) -> ZeroSet:
        """The same set with one more of its conditions told: a half-angle polynomial f that vanishes on all of it.

        Args:
            f: for the equations.
            p: trigonometric polynomial with the same zeros.
        """
        extended = replace(self, equations=(*self.equations, f), zero=(*self.zero, p))
        if self._base > 2:  # what takes seconds to find is not looked for again
            extended.__dict__["samples"] = self.samples
        return extended

    def vanishes(self, p: Polynomial) -> bool:
        """Whether a trigonometric polynomial is zero on the whole set."""
        return bool(self.samples) and all(value_at(self.ring, p, point) == 0 for point in self.samples)

    def half_vanishes(self, f: Polynomial) -> bool:
        """Whether a half-angle polynomial is zero on the whole set, the joints at π included."""
        there = {j: "pi" for j, value in self.pins.items() if value == "pi"}
        f = self.ring.form(f).at(there).f
        if f == 0:
            return True
        return bool(self.samples) and all(value_at(self.ring, f, point) == 0 for point in self.samples)

    def stands(self, joint: int, value: str) -> bool:
        """Whether a revolute joint is at a simple angle on the whole set."""
        return bool(self.samples) and all(stands(point, joint, value) for point in self.samples)

    def holds_at(self, points: Sequence[ModularPoint]) -> bool:
        """Whether every condition of this set holds at points modulo primes that give values to all its variables."""
        return all(
            all(stands(point, joint, value) for joint, value in self.pins.items())
            and not any(half_angle_value(self.ring, f, point) for f in (*self.equations, *self.known))
            and not any(value_at(self.ring, p, point) for p in self.zero)
            for point in points
        )

    def satisfies(self, other: ZeroSet) -> bool:
        """Whether every condition of another set holds on this one.

        The conditions may hold elsewhere too: with A t + B = 0 and a third condition, also where A = B = 0. So this set
        need not lie inside the other one: see `inside`.
        """
        if self.codimension < other.codimension or not self.samples:
            return False
        return other.holds_at(self.samples)

    def lies_inside(self, other: ZeroSet) -> bool:
        """Whether this set lies inside another one; False, too, where that is open.

        It is where the conditions hold and every solution of the other set exists. Where a denominator vanishes on
        this set, points of it may or may not be limits of points of the other.
        """
        return self.satisfies(other) and all(other._solves(point) for point in self.samples)

    def _solves(self, point: ModularPoint) -> bool:
        """Whether every solution exists at a point and is the one there, and the point is in the part that is meant."""
        ring = self.ring
        if any(holds(ring, solved, point) for solved in self.nonzero):
            return False
        far = {j: "pi" for j in ring.revolute if f"t{j}" not in point}
        for solved in self.solved:
            if ring.names[solved.place] not in point:
                return False
            degrees = tuple(map(max, *(ring.form(f).degrees for f in (solved.numerator, solved.denominator))))
            bottom, top = (Form(ring, f, degrees).at(far).f for f in (solved.denominator, solved.numerator))
            divisor = value_at(self.ring, bottom, point)
            if divisor == 0 or (point[ring.names[solved.place]] * divisor - value_at(ring, top, point)) % point.prime:
                return False
        return True


def _has_matching(places: Sequence[set[int]], moving: Sequence[int]) -> bool:
    """Whether each condition can be given a moving variable of its own."""
    return any(all(place in mine for place, mine in zip(order, places, strict=True)) for order in permutations(moving))


def independent(pieces: Sequence[ZeroSet]) -> list[ZeroSet]:
    """The sets that lie in no other one."""
    kept: list[ZeroSet] = []
    for piece in sorted(pieces, key=lambda v: v.codimension):
        if not any(piece.lies_inside(other) for other in kept):
            kept.append(piece)
    return kept
