"""A set of configurations given by conditions = 0 and conditions ≠ 0, as the hand calculation splits it into cases.

A stratum is kept twice: as its two lists of trigonometric polynomials, which are what is read and what makes strata
disjoint, and as `Piece`s that together are the stratum: each with joints pinned at simple angles, irreducible
half-angle equations, and atoms that are nowhere zero on it. Pieces of one stratum may meet: sin θ4 = 0 is one condition
with the pieces θ4 = 0 and θ4 = π.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

from rankdrop.exact.algebra.polynomial import COS_SIN, SIMPLE, Polynomial, primitive
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.suppression.piece import Factor, Piece

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
    """

    ring: Ring
    pieces: tuple[Piece, ...]
    equalities: tuple[Polynomial, ...] = ()
    inequalities: tuple[Polynomial, ...] = ()

    @classmethod
    def whole(cls, ring: Ring, assumed: dict[str, Polynomial] | None = None) -> Stratum:
        """Every configuration; `assumed` is the record of lengths taken for ≠ 0, see `Piece`."""
        return cls(ring, (Piece(ring, {}, assumed={} if assumed is None else assumed),))

    def meet(self, condition: Factor) -> Stratum:
        """The part where a condition = 0 holds.

        Example:
            >>> from rankdrop.exact.suppression.piece import Factor
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


def _largest(pieces: Sequence[Piece]) -> tuple[Piece, ...]:
    """The pieces less those that lie in another."""
    kept: list[Piece] = []
    for k, piece in enumerate(pieces):
        others = [*kept, *pieces[k + 1 :]]
        if not any(piece.inside(other) for other in others):
            kept.append(piece)
    return tuple(kept)


def _follows(ring: Ring, p: Polynomial, others: Sequence[Polynomial]) -> bool:
    """Whether p vanishes wherever the others do, as far as that is plain."""
    stratum = Stratum.whole(ring)
    for q in others:
        stratum = stratum.meet(Factor(q))
    return bool(stratum.pieces) and all(
        piece.irreducible and piece.factors(Factor(p), False) is None for piece in stratum.pieces
    )


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


