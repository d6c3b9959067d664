"""Joints pinned, equations = 0, atoms ≠ 0: a piece of what a hand calculation calls a case.

Unlike a `Variety` it need not be irreducible, and it knows what does not vanish on it.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from rankdrop.exact.algebra.field import Evaluator, P, Point, complete, half_evaluator, holds, put_common_zero, roots
from rankdrop.exact.algebra.polynomial import Atom, Polynomial, coefficients, order, used
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.algebra.solving import plainly_positive

TRIES = 40
"""Random points tried before a piece counts as one without points: an equation has a root modulo P every other time."""


@dataclass(frozen=True)
class Factor:
    """A condition: a trigonometric polynomial that vanishes or does not.

    Attributes:
        polynomial: of the trigonometric ring.
        atoms: under each of which it vanishes; None where that is found out by factoring it.
    """

    polynomial: Polynomial
    atoms: tuple[Atom, ...] | None = None


@dataclass(frozen=True)
class Piece:
    """Joints pinned, equations = 0, atoms ≠ 0.

    Attributes:
        ring: of all polynomials.
        pins: simple angle of each pinned joint.
        equations: irreducible primitive half-angle polynomials without the pinned joints.
        excluded: atoms that are nowhere zero on the piece, without the pinned joints.
        assumed: half-angle polynomials in lengths alone that were taken for ≠ 0, by their text; one record that all
            pieces of a derivation fill.
    """

    ring: Ring
    pins: Mapping[int, str]
    equations: tuple[Polynomial, ...] = ()
    excluded: frozenset[Atom] = frozenset()
    assumed: dict[str, Polynomial] = field(default_factory=dict, compare=False, repr=False)

    @cached_property
    def key(self) -> tuple[object, ...]:
        """The same for equal pieces."""
        return (tuple(sorted(self.pins.items())), tuple(sorted(map(str, self.equations))), self.excluded)

    @cached_property
    def solved(self) -> dict[int, tuple[Polynomial, Polynomial]]:
        """Variables of the half-angle ring that lengths alone decide: place -> (N, D), the variable is N / D."""
        return dict(root for root in (_root(self.ring, f) for f in self.equations) if root is not None)

    @property
    def irreducible(self) -> bool:
        """Whether it is known to be: one equation at most beside solved ones."""
        return len(self.equations) - len(self.solved) <= 1

    def factors(self, condition: Factor, note: bool = True) -> tuple[Atom, ...] | None:
        """The atoms under which a condition holds here; None where it holds everywhere.

        Atoms that are nowhere zero on the piece are left out. Exact for one equation at most beside solved ones; with
        more, only whether an equation itself is among the atoms is seen.

        Args:
            condition: = 0.
            note: whether factors in lengths alone are put down as assumed.
        """
        found: list[Atom] = []
        if condition.atoms is None:
            rest = self.ring.at(condition.polynomial, self.pins)
            if rest == 0:
                return None
            f, degree = self.ring.to_half(rest)
            here = self._substituted(f, [2 * m for m in degree], {}, note)
            if here is None:
                return None
            found += here
        else:
            for atom in condition.atoms:
                here = self.restricted(atom, note)
                if here is None:
                    return None
                found += here
        if any(atom.f is not None and atom.f in self.equations for atom in found):
            return None
        return tuple(atom for atom in sorted(set(found), key=order) if not self.never(atom))

    def restricted(self, atom: Atom, note: bool = True) -> Sequence[Atom] | None:
        """The atoms that an atom comes to on the piece; None where it holds everywhere."""
        if not atom.pinned:
            degrees = atom.f.degrees()
            pins = {j: value for j, value in self.pins.items() if degrees[self.ring.index[f"t{j}"]]}
            return self._substituted(atom.f, degrees, pins, note)
        here = self.pins.get(atom.joint)
        if here is not None:
            return None if here == atom.value else ()
        return () if self.ring.index[f"t{atom.joint}"] in self.solved else (atom,)

    def never(self, atom: Atom) -> bool:
        """Whether an atom is known to be nowhere zero on the piece, over the reals."""
        return atom in self.excluded or (atom.f is not None and plainly_positive(self.ring, atom.f))

    def meet(self, atom: Atom) -> list[Piece]:
        """Pieces that together are the part where an atom holds; none where that is seen to be empty.

        Args:
            atom: from `factors`.
        """
        if self.never(atom):
            return []
        if atom.pinned:
            return self._again({**self.pins, atom.joint: atom.value}, self.equations)
        if _root(self.ring, atom.f) is not None:
            return self._again(self.pins, self.equations, atom.f)
        if any(self._contradict(atom.f, f) for f in self.equations):
            return []
        return [replace(self, equations=(*self.equations, atom.f))]

    def avoid(self, atoms: Sequence[Atom]) -> Piece:
        """The part where none of some atoms from `factors` holds."""
        return replace(self, excluded=self.excluded | frozenset(atoms))

    def inside(self, other: Piece) -> bool:
        """Whether the piece is seen to lie in the closed set of another, their inequalities aside."""
        if any(self.pins.get(j) != value for j, value in other.pins.items()):
            return False
        return all(f in self.equations or self.restricted(self.ring.atom(f), False) is None for f in other.equations)

    def _again(self, pins: Mapping[int, str], equations: Sequence[Polynomial], *solving: Polynomial) -> list[Piece]:
        """The piece put together anew with more joints pinned, or another variable solved."""
        start = replace(self, pins=pins, equations=(*solving, *(f for f in equations if _root(self.ring, f))))
        excluded: list[Atom] = []
        for atom in self.excluded:
            left = start.restricted(atom)
            if left is None:
                return []
            excluded += left
        parts = [replace(start, excluded=frozenset(excluded))]
        for f in equations:
            if _root(self.ring, f) is None:
                parts = [one for part in parts for one in part._holding(f)]
        return parts

    def _holding(self, f: Polynomial) -> list[Piece]:
        """Pieces that together are the part where f = 0, which may fall apart here."""
        atoms = self.factors(Factor(None, (Atom(0, "", f, str(f)),)))
        return [self] if atoms is None else [part for atom in atoms for part in self.meet(atom)]

    def _contradict(self, f: Polynomial, g: Polynomial) -> bool:
        """Whether two equations in one and the same variable have no common zero for general lengths."""
        places = [k for k in used(f) if k < self.ring.moving]
        if len(places) != 1 or places != [k for k in used(g) if k < self.ring.moving]:
            return False
        for factor, _ in self.ring.split(f.resultant(g, self.ring.names[places[0]]))[1]:
            self._note(factor)
        return True

    def _substituted(
        self, f: Polynomial, formal: Sequence[int], pins: Mapping[int, str], note: bool
    ) -> Sequence[Atom] | None:
        """The atoms of a half-angle polynomial of these degrees with joints pinned and variables solved."""
        ring = self.ring
        g = ring.half_at(f, pins)
        for place, (top, bottom) in self.solved.items():
            if g != 0 and g.degrees()[place]:
                parts = coefficients(g, place)
                g = sum((part * top**k * bottom ** (len(parts) - 1 - k) for k, part in enumerate(parts)), g * 0)
        if g == 0:
            return None
        degrees = g.degrees()
        at_pi = [
            ring.pin(j, "pi")  # a lower degree is a zero at θ = π
            for k, j in enumerate(ring.revolute)
            if j not in pins and k not in self.solved and degrees[k] < formal[k]
        ]
        _, letters, atoms = ring.split(g)
        if note:
            for factor, _ in letters:
                self._note(factor)
        return [*at_pi, *(atom for atom, _ in atoms)]

    def _note(self, factor: Polynomial) -> None:
        self.assumed[str(factor)] = factor

    def vanishes(self, p: Polynomial, rng: random.Random, points: int = 3) -> bool:
        """Whether p is zero on the whole piece: exact for one equation beside solved ones, else at random points."""
        if self.irreducible:
            return self.factors(Factor(p), False) is None
        p = self.ring.at(p, self.pins)
        if p == 0:
            return True
        f, _ = self.ring.to_half(p)
        half = half_evaluator(self.ring)
        drawn = [self.point(rng) for _ in range(points)]
        return all(point is not None and half(f, point) == 0 for point in drawn)

    def point(self, rng: random.Random) -> Point | None:
        """A random point of the piece modulo P, lengths random too; None where none is found."""
        half = half_evaluator(self.ring)
        skipped = {f"t{j}" for j in self.pins}
        for _ in range(TRIES):
            values = {name: rng.randrange(2, P) for name in self.ring.names if name not in skipped}
            if not _solve(self.ring, half, self.equations, values, rng):
                continue
            point = complete(self.ring, values, self.pins)
            if point is not None and not any(holds(self.ring, atom, point) for atom in self.excluded):
                return point
        return None


def _root(ring: Ring, f: Polynomial) -> tuple[int, tuple[Polynomial, Polynomial]] | None:
    """(place, (N, D)) where f is linear in one variable that moves and holds no other: that variable is N / D."""
    places = [k for k in used(f) if k < ring.moving]
    if len(places) != 1 or f.degrees()[places[0]] != 1:
        return None
    constant, slope = coefficients(f, places[0])
    return places[0], (-constant, slope)


def _solve(
    ring: Ring, half: Evaluator, equations: Sequence[Polynomial], values: dict[str, int], rng: random.Random
) -> bool:
    """Change some of the values so that the equations hold; whether that was done."""
    names = {id(f): [ring.names[k] for k in used(f) if k < ring.moving] for f in equations}
    waiting = sorted(equations, key=len)
    later: list[tuple[Polynomial, str]] = []  # solved last, for a variable of their own
    implied: list[Polynomial] = []  # more equations than can be solved: the long ones have to follow from the others
    while waiting:
        own = ((f, [x for x in names[id(f)] if all(x not in names[id(g)] for g in waiting if g is not f)])
               for f in waiting)  # fmt: skip
        free = [(f, mine) for f, mine in own if mine]
        if free:
            f, mine = rng.choice(free)
            later.append((f, rng.choice(mine)))
            waiting = [g for g in waiting if g is not f]
        elif len(waiting) > 2:
            implied.append(waiting.pop())
        else:
            break
    if waiting and not _solve_two(half, waiting, names, values, rng):
        return False
    for f, name in reversed(later):
        line = half.in_one(f, name, values)
        candidates = roots(line)
        if any(line):  # else it follows from the others
            if not candidates:
                return False
            values[name] = rng.choice(candidates)
    return all(half(f, values) == 0 for f in implied)


def _solve_two(
    half: Evaluator,
    two: Sequence[Polynomial],
    names: Mapping[int, list[str]],
    values: dict[str, int],
    rng: random.Random,
) -> bool:
    shared = [x for x in names[id(two[0])] if x in names[id(two[1])]]
    if len(shared) < 2:
        return False
    x, y = rng.sample(shared, 2)
    return put_common_zero(half, two[0], two[1], (x, y), values, rng)
