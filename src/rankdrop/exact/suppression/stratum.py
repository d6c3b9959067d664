"""A case of the hand calculation: where some trigonometric polynomials vanish and others do not.

A stratum is kept twice: as its two lists of trigonometric polynomials, which are what is read and what makes strata
disjoint, and as sets (`ZeroSet`) that together are the stratum: each with joints pinned at simple angles, irreducible
half-angle equations, and atoms that are nowhere zero on it. Pieces of one stratum may meet: sin θ4 = 0 is one condition
with the pieces θ4 = 0 and θ4 = π.

On a piece an equation is solved where lengths alone decide its variable. What else vanishes is put into conditions, and
every step on a piece is a proof, as long as one more equation is on it at most; of more, only whether an equation
itself is among the atoms of a condition is seen. Factors in lengths alone are taken for ≠ 0: `assumed` holds them by
their text, one record for all strata of a derivation.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

from rankdrop.exact.algebra.field import value_at
from rankdrop.exact.algebra.polynomial import (
    COS_SIN,
    SIMPLE,
    Atom,
    Equality,
    Polynomial,
    coefficients,
    order,
    primitive,
    used,
)
from rankdrop.exact.algebra.ring import Form, Ring
from rankdrop.exact.algebra.solving import Solved, plainly_positive
from rankdrop.exact.algebra.zeroset import ZeroSet

Assumed = dict[str, Polynomial]
"""Half-angle polynomials in lengths alone that were taken for ≠ 0, by their text."""
TOGETHER = (("0", "pi"), ("pi/2", "-pi/2"))
"""Angles that one condition pins together: sin θ = 0 and cos θ = 0."""


@dataclass(frozen=True)
class Stratum:
    """Where some trigonometric polynomials vanish and others do not.

    Attributes:
        ring: of all polynomials.
        pieces: together the stratum; none where it is seen to be empty.
        equalities: polynomials = 0, in the order in which they were asked for.
        inequalities: polynomials ≠ 0.
        assumed: factors in lengths alone that were taken for ≠ 0.
    """

    ring: Ring
    pieces: tuple[ZeroSet, ...]
    equalities: tuple[Polynomial, ...] = ()
    inequalities: tuple[Polynomial, ...] = ()
    assumed: Assumed = field(default_factory=dict, compare=False, repr=False)

    @classmethod
    def whole(cls, ring: Ring, assumed: Assumed | None = None) -> Stratum:
        """Every configuration; `assumed` is the record of lengths taken for ≠ 0."""
        return cls(ring, (ZeroSet.whole(ring),), assumed={} if assumed is None else assumed)

    def meet(self, condition: Equality) -> Stratum:
        """The part where a condition = 0 holds; its polynomial is given.

        Example:
            >>> ring = Ring([1, 2])
            >>> [dict(piece.pins) for piece in Stratum.whole(ring).meet(Equality((), ring.s[2])).pieces]
            [{2: '0'}, {2: 'pi'}]
        """
        parts: dict[tuple[object, ...], ZeroSet] = {}
        for piece in self.pieces:
            atoms = atoms_on(piece, condition, self.assumed)
            here = [piece] if atoms is None else [part for one in atoms for part in meet(piece, one, self.assumed)]
            parts.update(((part.key, frozenset(part.nonzero)), part) for part in here)
        return replace(self, pieces=_largest([*parts.values()]), equalities=(*self.equalities, condition.whole))

    def avoid(self, condition: Equality) -> Stratum:
        """The part where a condition ≠ 0 holds; its polynomial is given."""
        kept = []
        for piece in self.pieces:
            atoms = atoms_on(piece, condition, self.assumed)
            if atoms is not None:
                kept.append(piece.without(*atoms))
        return replace(self, pieces=tuple(kept), inequalities=(*self.inequalities, condition.whole))

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
        return all(vanishes(piece, p, rng, points) for piece in self.pieces)

    @cached_property
    def closed(self) -> tuple[Polynomial, ...]:
        """The equalities as they read with the pinned joints at their angles, those that pin first."""
        pinned = [_pin_polynomial(self.ring, j, angles) for j, angles in self.pins.items()]
        found = list(_once([primitive(p) for p in (self.short(p) for p in self.equalities) if p != 0]))
        found = [p for p in found if p not in pinned]
        for p in found[::-1]:
            others = [q for q in found if q is not p]
            if others and _follows(self.ring, p, [*pinned, *others]):
                found = others
        return (*pinned, *found)

    @cached_property
    def open(self) -> tuple[Polynomial, ...]:
        """The inequalities that do not follow from the pinned joints, as they read there."""
        found = []
        for p in self.inequalities:
            if any(piece.ring.factor(piece.ring.at(p, piece.pins)).atoms for piece in self.pieces):
                found.append(primitive(self.short(p)))
        return _once(found)


def atoms_on(piece: ZeroSet, condition: Equality, assumed: Assumed | None = None) -> tuple[Atom, ...] | None:
    """The atoms under which a condition holds on a piece, those nowhere zero there left out; None where it always does.

    Args:
        piece: of a stratum.
        condition: by its atoms, or, where it has none, by its polynomial.
        assumed: filled with factors in lengths alone; None where nothing is concluded.
    """
    met: list[Atom] = []
    if condition.atoms:
        parts = [_restricted(piece, atom, assumed) for atom in condition.atoms]
    else:
        here = piece.ring.at(condition.whole, piece.pins)
        parts = [None if here == 0 else _put_in(piece, piece.ring.to_half(here), assumed)]
    for part in parts:
        if part is None:
            return None
        met += part
    if any(atom.f is not None and atom.f in piece.equations for atom in met):
        return None
    return tuple(atom for atom in sorted(set(met), key=order) if not _never(piece, atom))


def meet(piece: ZeroSet, atom: Atom, assumed: Assumed) -> list[ZeroSet]:
    """Pieces that together are the part where an atom from `atoms_on` holds; none where that is seen to be empty."""
    if _never(piece, atom):
        return []
    if atom.pinned:
        return _again(piece, {**piece.pins, atom.joint: atom.value}, piece.equations, assumed)
    if _root(piece.ring, atom.f) is not None:
        return _again(piece, piece.pins, piece.equations, assumed, atom.f)
    if any(_contradict(piece.ring, atom.f, f, assumed) for f in piece.equations):
        return []
    return [_with_equations(piece, piece.pins, (*piece.equations, atom.f))]


def vanishes(piece: ZeroSet, p: Polynomial, rng: random.Random, points: int = 3) -> bool:
    """Whether p is zero on a whole piece: exact for one equation beside solved ones, else at random points."""
    if not piece.several:
        return atoms_on(piece, Equality((), p)) is None
    p = piece.ring.at(p, piece.pins)
    drawn = piece.points(rng, points) if p != 0 else []
    return bool(p == 0) or (len(drawn) == points and all(value_at(piece.ring, p, point) == 0 for point in drawn))


def _with_equations(
    piece: ZeroSet, pins: Mapping[int, str], equations: Sequence[Polynomial], nonzero: Sequence[Atom] | None = None
) -> ZeroSet:
    """The set of these equations and pins; the inequations are those of a piece where none are given."""
    solved = {f: root for f in range(len(equations)) if (root := _root(piece.ring, equations[f])) is not None}
    rest = tuple(f for place, f in enumerate(equations) if place not in solved)
    kept = piece.nonzero if nonzero is None else tuple(dict.fromkeys(nonzero))
    return ZeroSet(piece.ring, pins, tuple(solved.values()), rest, nonzero=kept, equations=tuple(equations))


def _restricted(piece: ZeroSet, atom: Atom, assumed: Assumed | None = None) -> Sequence[Atom] | None:
    """The atoms that an atom comes to on a piece; None where it holds everywhere."""
    ring = piece.ring
    if not atom.pinned:
        degrees = atom.f.degrees()
        pins = {j: value for j, value in piece.pins.items() if degrees[ring.index[f"t{j}"]]}
        return _put_in(piece, ring.form(atom.f).at(pins), assumed)
    here = piece.pins.get(atom.joint)
    if here is not None:
        return None if here == atom.value else ()
    return () if any(one.place == ring.index[f"t{atom.joint}"] for one in piece.solved) else (atom,)


def _never(piece: ZeroSet, atom: Atom) -> bool:
    """Whether an atom is known to be nowhere zero on a piece, over the reals."""
    return atom in piece.nonzero or (atom.f is not None and plainly_positive(piece.ring, atom.f))


def _inside(piece: ZeroSet, other: ZeroSet) -> bool:
    """Whether a piece is seen to lie in the closed set of another, their inequations aside."""
    if any(piece.pins.get(j) != value for j, value in other.pins.items()):
        return False
    return all(
        f in piece.equations or _restricted(piece, piece.ring.atom(f)) is None for f in other.equations
    )


def _again(
    piece: ZeroSet, pins: Mapping[int, str], equations: Sequence[Polynomial], assumed: Assumed, *solving: Polynomial
) -> list[ZeroSet]:
    """A piece put together anew with more joints pinned, or another variable solved."""
    solved = [f for f in equations if _root(piece.ring, f) is not None]
    start = _with_equations(piece, pins, (*solving, *solved))
    nonzero: list[Atom] = []
    for atom in piece.nonzero:
        left = _restricted(start, atom, assumed)
        if left is None:
            return []
        nonzero += left
    parts = [_with_equations(start, pins, start.equations, nonzero)]
    for f in equations:
        if _root(piece.ring, f) is None:
            parts = [one for part in parts for one in _holding(part, f, assumed)]
    return parts


def _holding(piece: ZeroSet, f: Polynomial, assumed: Assumed) -> list[ZeroSet]:
    """Pieces that together are the part of one where f = 0, which may fall into factors there."""
    atoms = atoms_on(piece, Equality((Atom(0, "", f, str(f)),)), assumed)
    return [piece] if atoms is None else [part for atom in atoms for part in meet(piece, atom, assumed)]


def _contradict(ring: Ring, f: Polynomial, g: Polynomial, assumed: Assumed) -> bool:
    """Whether two equations in one and the same variable have no common zero for general lengths."""
    places = [k for k in used(f) if k < ring.moving]
    if len(places) != 1 or places != [k for k in used(g) if k < ring.moving]:
        return False
    letters = ring.form(f.resultant(g, ring.names[places[0]])).factors().letters
    assumed.update((str(factor), factor) for factor, _ in letters)
    return True


def _put_in(piece: ZeroSet, form: Form, assumed: Assumed | None) -> list[Atom] | None:
    """The atoms of a form without the pinned joints, the solved variables put in; None where it is zero."""
    f, degrees = form.f, list(form.degrees)
    for one in piece.solved:
        if one.place < piece.ring.angles:
            degrees[one.place] = 0  # it is not at π
        if f != 0 and f.degrees()[one.place]:
            parts = coefficients(f, one.place)
            top, bottom, power = one.numerator, one.denominator, len(parts) - 1
            f = sum((part * top**k * bottom ** (power - k) for k, part in enumerate(parts)), f * 0)
    if f == 0:
        return None
    _, letters, atoms = Form(piece.ring, f, tuple(degrees)).factors()
    if assumed is not None:
        assumed.update((str(factor), factor) for factor, _ in letters)
    return [atom for atom, _ in atoms]


def _root(ring: Ring, f: Polynomial) -> Solved | None:
    """An equation linear in one variable that moves, with no other one in it, solved."""
    places = [k for k in used(f) if k < ring.moving]
    if len(places) != 1 or f.degrees()[places[0]] != 1:
        return None
    constant, slope = coefficients(f, places[0])
    return Solved(places[0], -constant, slope)


def _largest(pieces: Sequence[ZeroSet]) -> tuple[ZeroSet, ...]:
    """The pieces less those that lie in another."""
    kept: list[ZeroSet] = []
    for k, piece in enumerate(pieces):
        others = [*kept, *pieces[k + 1 :]]
        if not any(_inside(piece, other) for other in others):
            kept.append(piece)
    return tuple(kept)


def _follows(ring: Ring, p: Polynomial, others: Sequence[Polynomial]) -> bool:
    """Whether p vanishes wherever the others do, as far as that is plain."""
    stratum = Stratum.whole(ring)
    for q in others:
        stratum = stratum.meet(Equality((), q))
    return bool(stratum.pieces) and all(
        not piece.several and atoms_on(piece, Equality((), p)) is None for piece in stratum.pieces
    )


def _once(polynomials: Sequence[Polynomial]) -> tuple[Polynomial, ...]:
    """Each of them once."""
    return tuple({str(p): p for p in polynomials}.values())


def _pin_polynomial(ring: Ring, j: int, angles: tuple[str, ...]) -> Polynomial:
    """One trigonometric polynomial that is zero where a joint stands at one of some angles, and nowhere else."""
    if angles == TOGETHER[0]:
        return ring.s[j]
    if angles == TOGETHER[1]:
        return ring.c[j]
    found = ring.one
    for value in angles:
        cosine, sine = COS_SIN[value]
        found = found * (1 - ring.c[j] * cosine - ring.s[j] * sine)  # zero exactly at the angle
    return ring.reduce(found)


