"""A set of configurations given by conditions = 0 and conditions ≠ 0, as the hand calculation splits it into cases.

A stratum is kept twice: as its two lists of trigonometric polynomials, which are what is read and what makes strata
disjoint, and as `Piece`s that together are the stratum: each with joints pinned at simple angles, irreducible half-angle
equations, and atoms that are nowhere zero on it. Pieces of one stratum may meet: sin θ4 = 0 is one condition with the
pieces θ4 = 0 and θ4 = π.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

from rankdrop.exact.field import Evaluator, P, Point, common_zeros, complete, roots
from rankdrop.exact.flint import Polynomial
from rankdrop.exact.ring import COS_SIN, SIMPLE, Atom, Ring, coefficients, primitive, used

TRIES = 40
"""Random points tried before a piece counts as one without points: an equation has a root modulo P every other time."""
TOGETHER = (("0", "pi"), ("pi/2", "-pi/2"))
"""Angles that one condition pins together: sin θ = 0 and cos θ = 0."""


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
        return tuple(atom for atom in dict.fromkeys(found) if not self.never(atom))

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
        return atom in self.excluded or (atom.f is not None and is_positive(self.ring, atom.f))

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
        if len(factor) > 1:  # a length alone is not zero
            self.assumed[str(factor)] = factor

    def vanishes(self, p: Polynomial, rng: random.Random, points: int = 3) -> bool:
        """Whether p is zero on the whole piece: exact for one equation beside solved ones, else at random points."""
        if len(self.equations) - len(self.solved) <= 1:
            return self.factors(Factor(p), False) is None
        p = self.ring.at(p, self.pins)
        if p == 0:
            return True
        f, _ = self.ring.to_half(p)
        half = Evaluator(self.ring.names)
        drawn = [self.point(rng) for _ in range(points)]
        return all(point is not None and half(f, point) == 0 for point in drawn)

    def point(self, rng: random.Random) -> Point | None:
        """A random point of the piece modulo P, lengths random too; None where none is found."""
        half = Evaluator(self.ring.names)
        skipped = {f"t{j}" for j in self.pins}
        for _ in range(TRIES):
            values = {name: rng.randrange(2, P) for name in self.ring.names if name not in skipped}
            if not _solve(self.ring, half, self.equations, values, rng):
                continue
            point = complete(self.ring, values, self.pins)
            if point is not None and all(self._misses(atom, point, half) for atom in self.excluded):
                return point
        return None

    def _misses(self, atom: Atom, point: Point, half: Evaluator) -> bool:
        if atom.pinned:
            cosine, sine = COS_SIN[atom.value]
            return (point[f"c{atom.joint}"], point[f"s{atom.joint}"]) != (cosine % P, sine % P)
        return half(atom.f, point) != 0


@dataclass(frozen=True)
class Stratum:
    """Where some trigonometric polynomials vanish and others do not.

    Attributes:
        ring: of all polynomials.
        pieces: together the stratum; none where it is seen to be empty.
        equalities: polynomials = 0, in the order in which they were asked for.
        inequalities: polynomials ≠ 0.
    """

    ring: Ring
    pieces: tuple[Piece, ...]
    equalities: tuple[Polynomial, ...] = ()
    inequalities: tuple[Polynomial, ...] = ()

    @classmethod
    def whole(cls, ring: Ring) -> Stratum:
        """Every configuration."""
        return cls(ring, (Piece(ring, {}),))

    @property
    def assumed(self) -> dict[str, Polynomial]:
        """Half-angle polynomials in lengths alone that were taken for ≠ 0 up to now; empty for the empty stratum."""
        return self.pieces[0].assumed if self.pieces else {}

    def meet(self, condition: Factor) -> Stratum:
        """The part where a condition = 0 holds.

        Example:
            >>> ring = Ring([1, 2])
            >>> [dict(piece.pins) for piece in Stratum.whole(ring).meet(Factor(ring.s[2])).pieces]
            [{2: '0'}, {2: 'pi'}]
        """
        found: dict[tuple[object, ...], Piece] = {}
        for piece in self.pieces:
            atoms = piece.factors(condition)
            parts = [piece] if atoms is None else [part for atom in atoms for part in piece.meet(atom)]
            found.update((part.key, part) for part in parts)
        kept = _largest(list(found.values()))
        return replace(self, pieces=kept, equalities=(*self.equalities, condition.polynomial))

    def avoid(self, condition: Factor) -> Stratum:
        """The part where a condition ≠ 0 holds."""
        kept = []
        for piece in self.pieces:
            atoms = piece.factors(condition)
            if atoms is not None:
                kept.append(piece.avoid(atoms))
        return replace(self, pieces=tuple(kept), inequalities=(*self.inequalities, condition.polynomial))

    def apart(self, other: Stratum) -> Polynomial | None:
        """A polynomial that is = 0 on one of the two strata and ≠ 0 on the other: they have no point in common."""
        for one, two in ((self, other), (other, self)):
            for p in one.equalities:
                if p in two.inequalities:
                    return p
        return None

    @cached_property
    def pins(self) -> dict[int, tuple[str, ...]]:
        """Joints pinned on every piece, each with the angles it takes there."""
        joints = [set(piece.pins) for piece in self.pieces]
        shared = sorted(set.intersection(*joints)) if joints else []
        return {j: tuple(sorted({piece.pins[j] for piece in self.pieces}, key=SIMPLE.index)) for j in shared}

    @property
    def combinations(self) -> list[dict[int, str]]:
        """The different pins of the pieces."""
        return [dict(pins) for pins in dict.fromkeys(tuple(sorted(piece.pins.items())) for piece in self.pieces)]

    @property
    def regular(self) -> bool:
        """Whether the pieces pin the same joints, in every combination of their angles, and pairs are `TOGETHER`."""
        values = self.pins.values()
        every = [dict(zip(self.pins, choice, strict=True)) for choice in product(*values)]
        here = self.combinations
        return len(every) == len(here) and all(one in here for one in every) and all(
            len(angles) == 1 or angles in TOGETHER for angles in values
        )  # fmt: skip

    def short(self, p: Polynomial) -> Polynomial:
        """p as it reads on the stratum: with sin θ4 = 0, s4 is gone and c4 = ±1 stays."""
        ring = self.ring
        p = ring.at(p, {j: angles[0] for j, angles in self.pins.items() if len(angles) == 1})
        for j, angles in self.pins.items():
            if angles == TOGETHER[0] and p != 0:
                p = p.subs({f"s{j}": 0})
                p = p % (ring.c[j] ** 2 - 1) if p != 0 else p
            elif angles == TOGETHER[1] and p != 0:
                p = p.subs({f"c{j}": 0})
        return ring.reduce(p) if p != 0 else p

    def vanishes(self, p: Polynomial, rng: random.Random, points: int = 3) -> bool:
        """Whether p is zero on the whole stratum: exact for pieces of one equation, else at random points of each."""
        return all(piece.vanishes(p, rng, points) for piece in self.pieces)

    @property
    def closed(self) -> tuple[Polynomial, ...]:
        """The equalities as they read with the pinned joints at their angles, those that pin first."""
        pinned = [_pin_polynomial(self.ring, j, angles) for j, angles in self.pins.items()]
        rest = [primitive(p) for p in (self.short(p) for p in self.equalities) if p != 0]
        return _once([*pinned, *rest])

    @property
    def open(self) -> tuple[Polynomial, ...]:
        """The inequalities that do not follow from the pinned joints, as they read there."""
        found = []
        for p in self.inequalities:
            if any(piece.ring.factor(piece.ring.at(p, piece.pins)).atoms for piece in self.pieces):
                found.append(primitive(self.short(p)))
        return _once(found)


def _root(ring: Ring, f: Polynomial) -> tuple[int, tuple[Polynomial, Polynomial]] | None:
    """(place, (N, D)) where f is linear in one variable that moves and holds no other: that variable is N / D."""
    places = [k for k in used(f) if k < ring.moving]
    if len(places) != 1 or f.degrees()[places[0]] != 1:
        return None
    constant, slope = coefficients(f, places[0])
    return places[0], (-constant, slope)


def is_positive(ring: Ring, f: Polynomial) -> bool:
    """Whether f is plainly without a real zero: even powers, coefficients of one sign, one term of lengths alone."""
    terms = list(f.terms())
    alike = len({value > 0 for _, value in terms}) == 1
    even = all(power % 2 == 0 for powers, _ in terms for power in powers)
    return alike and even and any(not any(powers[: ring.moving]) for powers, _ in terms)


def _largest(pieces: Sequence[Piece]) -> tuple[Piece, ...]:
    """The pieces less those that lie in another."""
    kept: list[Piece] = []
    for k, piece in enumerate(pieces):
        others = [*kept, *pieces[k + 1 :]]
        if not any(piece.inside(other) for other in others):
            kept.append(piece)
    return tuple(kept)


def _once(polynomials: Sequence[Polynomial]) -> tuple[Polynomial, ...]:
    """Each of them once."""
    return tuple({str(p): p for p in polynomials}.values())


def _pin_polynomial(ring: Ring, j: int, angles: tuple[str, ...]) -> Polynomial:
    if angles == TOGETHER[0]:
        return ring.s[j]
    if angles == TOGETHER[1]:
        return ring.c[j]
    found = ring.one
    for value in angles:
        cosine, sine = COS_SIN[value]
        found = found * (1 - ring.c[j] * cosine - ring.s[j] * sine)  # zero exactly at the angle
    return ring.reduce(found)


def _solve(
    ring: Ring, half: Evaluator, equations: Sequence[Polynomial], values: dict[str, int], rng: random.Random
) -> bool:
    """Change some of the values so that the equations hold; whether that was done."""
    names = {id(f): [ring.names[k] for k in used(f) if k < ring.moving] for f in equations}
    waiting, later = list(equations), []
    while waiting:
        # an equation with a variable of its own can be solved last
        own = [(f, [x for x in names[id(f)] if all(x not in names[id(g)] for g in waiting if g is not f)])
               for f in waiting]  # fmt: skip
        free = [(f, mine) for f, mine in own if mine]
        if not free:
            break
        f, mine = rng.choice(free)
        later.append((f, rng.choice(mine)))
        waiting = [g for g in waiting if g is not f]
    if waiting:
        if len(waiting) != 2:
            return False
        shared = [x for x in names[id(waiting[0])] if x in names[id(waiting[1])]]
        if len(shared) < 2:
            return False
        x, y = rng.sample(shared, 2)
        found = common_zeros(half.in_two(waiting[0], x, y, values), half.in_two(waiting[1], x, y, values), rng)
        if found is None:
            return False
        values[x], values[y] = found
    for f, name in reversed(later):
        line = half.in_one(f, name, values)
        candidates = roots(line)
        if any(line):  # else it follows from the others
            if not candidates:
                return False
            values[name] = rng.choice(candidates)
    return True
