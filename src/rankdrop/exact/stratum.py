"""A case of the hand calculation: a set on which some trigonometric polynomials vanish and others do not.

A stratum is kept twice: as its two lists of trigonometric polynomials, which are what is read and what makes strata
disjoint, and as sets (`ZeroSet`) that together are the stratum: each with joints pinned at simple angles, irreducible
half-angle equations, and atoms that are nowhere zero on it. Pieces of one stratum may meet: sin θ4 = 0 is one condition
with the pieces θ4 = 0 and θ4 = π.

`atoms_on` puts what is known on a piece into a condition, `meet` cuts a piece by an atom. An equation is solved where
lengths alone decide its variable. Every step is a proof, as long as one more equation is on the piece at most; of more,
only whether an equation itself is among the atoms of a condition is seen. Factors in lengths alone are taken for ≠ 0:
`assumed` holds them by their text, one record for all strata of a derivation.

`factor_on_stratum` writes a polynomial on a stratum as a product of conditions, each one trigonometric polynomial.
Factors are unique in half-angle tangents only. What belongs together is joined again: θ = 0 and θ = π to sin θ, ±π/2 to
cos θ. Where the stratum has several pieces (c4 = ±1), factors that all pieces share stay factors, and what is left of
each piece is joined by Σ_ε (1 + ε c4)/2 · R_ε, one polynomial with c4 in it.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial, reduce
from itertools import combinations, product
from math import prod

from rankdrop.algebra.field import P, random_point, value_at
from rankdrop.algebra.polynomial import (
    SIMPLE,
    Atom,
    Equality,
    Factors,
    Polynomial,
    coefficients,
    order,
    primitive,
    reduced_roots,
    variables_in,
)
from rankdrop.algebra.ring import Form, Ring, letters_polynomial, polynomial_of
from rankdrop.algebra.solving import Solved, plainly_positive, substitute_solution
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.lists import flat_map

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
        holding = flat_map(lambda piece: _holding(piece, condition, self.assumed), self.pieces)
        parts = {(part.key, frozenset(part.nonzero)): part for part in holding}
        return replace(self, pieces=_largest([*parts.values()]), equalities=(*self.equalities, condition.whole))

    def avoid(self, condition: Equality) -> Stratum:
        """The part where a condition ≠ 0 holds; its polynomial is given."""
        every = [(piece, atoms_on(piece, condition, self.assumed)) for piece in self.pieces]
        kept = tuple(piece.remove_zeros(*atoms) for piece, atoms in every if atoms is not None)
        return replace(self, pieces=kept, inequalities=(*self.inequalities, condition.whole))

    def separating_polynomial(self, other: Stratum) -> Polynomial | None:
        """A polynomial that is = 0 on one of the two strata and ≠ 0 on the other: they have no point in common."""
        pairs = ((self, other), (other, self))
        return next((p for first, second in pairs for p in first.equalities if p in second.inequalities), None)

    @cached_property
    def pins(self) -> dict[int, tuple[str, ...]]:
        """Joints pinned on every piece, each with the angles it takes there."""
        joints = [set(piece.pins) for piece in self.pieces]
        if joints:
            shared = sorted(set.intersection(*joints))
        else:
            shared = []
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
        present = self.combinations
        return len(every) == len(present) and all(atom in present for atom in every) and all(
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
    def equations_with_pins(self) -> tuple[Polynomial, ...]:
        """The equalities as they read with the pinned joints at their angles, those that pin first."""
        pinned = [_pin_polynomial(self.ring, j, angles) for j, angles in self.pins.items()]
        equations = list(_once([primitive(p) for p in (self.short(p) for p in self.equalities) if p != 0]))
        equations = [p for p in equations if p not in pinned]
        for p in equations[::-1]:
            others = [q for q in equations if q is not p]
            if others and _follows(self.ring, p, [*pinned, *others]):
                equations = others
        return (*pinned, *equations)

    @cached_property
    def open(self) -> tuple[Polynomial, ...]:
        """The inequalities that do not follow from the pinned joints, as they read there."""
        ring = self.ring
        kept = [p for p in self.inequalities if any(ring.factor(ring.at(p, x.pins)).atoms for x in self.pieces)]
        return _once([primitive(self.short(p)) for p in kept])


def atoms_on(piece: ZeroSet, condition: Equality, assumed: Assumed | None = None) -> tuple[Atom, ...] | None:
    """The atoms under which a condition holds on a piece, those nowhere zero there left out; None where it always does.

    Args:
        piece: of a stratum.
        condition: by its atoms, or, where it has none, by its polynomial.
        assumed: filled with factors in lengths alone; None where nothing is concluded.
    """
    met: list[Atom] = []
    if condition.atoms:
        parts = [_restrict_atom(piece, atom, assumed) for atom in condition.atoms]
    else:
        restricted = piece.ring.at(condition.whole, piece.pins)
        parts = [None if restricted == 0 else _substitute_solutions(piece, piece.ring.to_half(restricted), assumed)]
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
    if atom.is_pin:
        return _rebuild_set(piece, {**piece.pins, atom.joint: atom.value}, piece.equations, assumed)
    if _root(piece.ring, atom.f) is not None:
        return _rebuild_set(piece, piece.pins, piece.equations, assumed, atom.f)
    if any(_contradict(piece.ring, atom.f, f, assumed) for f in piece.equations):
        return []
    return [_with_equations(piece, piece.pins, (*piece.equations, atom.f))]


def vanishes(piece: ZeroSet, p: Polynomial, rng: random.Random, points: int = 3) -> bool:
    """Whether p is zero on a whole piece: exact for one equation beside solved ones, else at random points."""
    if not piece.several:
        return atoms_on(piece, Equality((), p)) is None
    p = piece.ring.at(p, piece.pins)
    if p != 0:
        drawn = piece.points(rng, points)
    else:
        drawn = []
    return bool(p == 0) or (len(drawn) == points and all(value_at(piece.ring, p, point) == 0 for point in drawn))


def _with_equations(
    piece: ZeroSet, pins: Mapping[int, str], equations: Sequence[Polynomial], nonzero: Sequence[Atom] | None = None
) -> ZeroSet:
    """The set of these equations and pins; the inequations are those of a piece where none are given."""
    roots = [(f, _root(piece.ring, f)) for f in equations]
    solved, rest = tuple(root for _, root in roots if root is not None), tuple(f for f, root in roots if root is None)
    if nonzero is None:
        kept = piece.nonzero
    else:
        kept = tuple(dict.fromkeys(nonzero))
    return ZeroSet(piece.ring, pins, solved, rest, nonzero=kept, equations=tuple(equations))


def _restrict_atom(piece: ZeroSet, atom: Atom, assumed: Assumed | None = None) -> Sequence[Atom] | None:
    """The atoms that an atom comes to on a piece; None where it holds everywhere."""
    ring = piece.ring
    if not atom.is_pin:
        degrees = atom.f.degrees()
        pins = {j: value for j, value in piece.pins.items() if degrees[ring.index[f"t{j}"]]}
        if not pins and not any(degrees[solved.place] for solved in piece.solved):
            return (atom,)
        return _substitute_solutions(piece, ring.form(atom.f).at(pins), assumed)
    pinned = piece.pins.get(atom.joint)
    if pinned is not None:
        return None if pinned == atom.value else ()
    if any(solved.place == ring.index[f"t{atom.joint}"] for solved in piece.solved):
        return ()
    return (atom,)


def _never(piece: ZeroSet, atom: Atom) -> bool:
    """Whether an atom is known to be nowhere zero on a piece, over the reals."""
    return atom in piece.nonzero or (atom.f is not None and plainly_positive(piece.ring, atom.f))


def _lies_inside(piece: ZeroSet, other: ZeroSet) -> bool:
    """Whether a piece is seen to lie in the closed set of another, their inequations aside."""
    if any(piece.pins.get(j) != value for j, value in other.pins.items()):
        return False
    return all(
        f in piece.equations or _restrict_atom(piece, piece.ring.atom(f)) is None for f in other.equations
    )


def _rebuild_set(
    piece: ZeroSet, pins: Mapping[int, str], equations: Sequence[Polynomial], assumed: Assumed, *solving: Polynomial
) -> list[ZeroSet]:
    """A piece put together anew with more joints pinned, or another variable solved."""
    solved = [f for f in equations if _root(piece.ring, f) is not None]
    start = _with_equations(piece, pins, (*solving, *solved))
    nonzero: list[Atom] = []
    for atom in piece.nonzero:
        left = _restrict_atom(start, atom, assumed)
        if left is None:
            return []
        nonzero += left
    parts = [_with_equations(start, pins, start.equations, nonzero)]
    for f in equations:
        if _root(piece.ring, f) is None:
            condition = Equality((Atom(0, "", f, str(f)),))
            parts = flat_map(partial(_holding, condition=condition, assumed=assumed), parts)
    return parts


def _holding(piece: ZeroSet, condition: Equality, assumed: Assumed) -> list[ZeroSet]:
    """Pieces that together are the part of one where a condition holds, which may fall into factors there."""
    atoms = atoms_on(piece, condition, assumed)
    if atoms is None:
        return [piece]
    return flat_map(lambda atom: meet(piece, atom, assumed), atoms)


def _contradict(ring: Ring, f: Polynomial, g: Polynomial, assumed: Assumed) -> bool:
    """Whether two equations in one and the same variable have no common zero for general lengths."""
    places = [k for k in variables_in(f) if k < ring.moving]
    if len(places) != 1 or places != [k for k in variables_in(g) if k < ring.moving]:
        return False
    letters = ring.form(f.resultant(g, ring.names[places[0]])).factors().letters
    assumed.update((str(factor), factor) for factor, _ in letters)
    return True


def _substitute_solutions(piece: ZeroSet, form: Form, assumed: Assumed | None) -> list[Atom] | None:
    """The atoms of a form without the pinned joints, the solved variables put in; None where it is zero."""
    f, degrees = form.f, list(form.degrees)
    for solved in piece.solved:
        if solved.place < piece.ring.angles:
            degrees[solved.place] = 0  # it is not at π
        if f != 0 and f.degrees()[solved.place]:
            f = reduced_roots(substitute_solution(f, solved))
    if f == 0:
        return None
    letters, atoms = Form(piece.ring, f, tuple(degrees)).factors()
    if assumed is not None:
        assumed.update((str(factor), factor) for factor, _ in letters)
    return [atom for atom, _ in atoms]


def _root(ring: Ring, f: Polynomial) -> Solved | None:
    """An equation linear in one variable that moves, with no other one in it, solved."""
    places = [k for k in variables_in(f) if k < ring.moving]
    if len(places) != 1 or f.degrees()[places[0]] != 1:
        return None
    constant, slope = coefficients(f, places[0])
    return Solved(places[0], -constant, slope)


def _largest(pieces: Sequence[ZeroSet]) -> tuple[ZeroSet, ...]:
    """The pieces less those that lie in another."""
    kept: list[ZeroSet] = []
    for k, piece in enumerate(pieces):
        others = [*kept, *pieces[k + 1 :]]
        if not any(_lies_inside(piece, other) for other in others):
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
    return tuple({str(p): p for p in polynomials}.values())


def _pin_polynomial(ring: Ring, j: int, angles: tuple[str, ...]) -> Polynomial:
    """One trigonometric polynomial that is zero where a joint stands at one of some angles, and nowhere else."""
    return _times(ring, [f.whole for f in join_pins(ring, [ring.pin(j, value) for value in angles])])


@dataclass(frozen=True)
class VanishingProduct:
    """What makes a polynomial vanish on a stratum.

    Attributes:
        polynomial: as it reads on the stratum.
        factors: it vanishes where one of these conditions holds. Those known to be nowhere zero on the stratum are
            left out.
        letters: factors in lengths alone (half-angle ring).
    """

    polynomial: Polynomial
    factors: tuple[Equality, ...]
    letters: tuple[Polynomial, ...]


def factor_on_stratum(stratum: Stratum, p: Polynomial) -> VanishingProduct | None:
    """The factors of a trigonometric polynomial on a stratum, short ones first; None where it vanishes on a piece."""
    ring = stratum.ring
    p = stratum.short(p)
    every: list[Factors] = []
    lists: list[list[Atom]] = []  # those that may hold
    for there in stratum.combinations:
        restricted = ring.at(p, there)
        if restricted != 0:
            atoms = _open_atoms(stratum, there, restricted)
        else:
            atoms = None
        if atoms is None:
            return None
        lists.append(atoms)
        every.append(ring.factor(restricted))
    shared = _in_all(lists)
    rests = [[atom for atom in atoms if atom not in shared] for atoms in lists]
    pins = [atom for atom in _in_all([[atom for atom, _ in product.atoms] for product in every]) if atom.is_pin]
    factors = [_shorter(ring, f, pins) for f in join_pins(ring, shared)]  # pins ≠ 0 in the cases of other factors
    letters = {str(f): (f, power) for product in every for f, power in product.letters}  # by text: they have no hash
    if any(rests):
        rest = _combine(stratum, _without_letters(ring, p, letters.values()), shared, rests)
        factors.append(Equality(tuple(rests[0]) if len(rests) == 1 else (), rest))
    return VanishingProduct(p, tuple(sorted(factors, key=_length)), tuple(letters[key][0] for key in sorted(letters)))


def _in_all(lists: Sequence[Sequence[Atom]]) -> list[Atom]:
    return [atom for atom in lists[0] if all(atom in other for other in lists[1:])]


def _length(factor: Equality) -> tuple[int, int, str]:
    f: Polynomial = factor.whole
    return len(f), f.total_degree(), str(f)


def _open_atoms(stratum: Stratum, pins: Mapping[int, str], p: Polynomial) -> list[Atom] | None:
    """Atoms of a polynomial that may hold on a piece with these pins; None where one always holds on one."""
    pieces = [piece for piece in stratum.pieces if piece.pins == pins]
    lists = {atom: [atoms_on(piece, Equality((atom,))) for piece in pieces] for atom, _ in stratum.ring.factor(p).atoms}
    if any(matching is None for atoms in lists.values() for matching in atoms):
        return None
    return [atom for atom, matching in lists.items() if any(matching)]


def join_pins(ring: Ring, atoms: Sequence[Atom]) -> list[Equality]:
    """Conditions, one per atom or per pair of angles that one sine or cosine pins."""
    left = list(atoms)
    joined = []
    for j in dict.fromkeys(atom.joint for atom in atoms if atom.is_pin):
        for pair, generator in zip(TOGETHER, (ring.s[j], ring.c[j]), strict=True):
            both = tuple(ring.pin(j, value) for value in pair)
            if all(atom in left for atom in both):
                joined.append(Equality(both, generator))
                left = [atom for atom in left if atom not in both]
    return joined + [Equality((atom,), polynomial_of(ring, atom)) for atom in left]


def _combine(stratum: Stratum, p: Polynomial, shared: Sequence[Atom], rests: Sequence[Sequence[Atom]]) -> Polynomial:
    """One polynomial that vanishes on each piece where its own remaining atoms do."""
    ring = stratum.ring
    if not shared or not stratum.regular:
        return primitive(p)  # the shared factors, if any, come before it and are ≠ 0
    point = random_point(ring, random.Random(0))
    common = _times(ring, [f.whole for f in join_pins(ring, shared)])
    total, first = ring.zero, 0
    for pins, atoms in zip(stratum.combinations, rests, strict=True):
        part = _unsquare(ring, atoms, shared)
        below = value_at(ring, ring.reduce(common * part), point)
        ratio = value_at(ring, ring.at(p, pins), point) * pow(below, -1, P) % P
        first = first or ratio
        if (ratio + first) % P == 0:
            part = -part  # as the signs of p are, so that R reads as p does
        others = (ring.pin(j, value) for j, angles in stratum.pins.items() for value in angles if value != pins[j])
        total += prod((polynomial_of(ring, atom) for atom in others), start=part)
    return primitive(stratum.short(total))


def _unsquare(ring: Ring, atoms: Sequence[Atom], spare: Sequence[Atom]) -> Polynomial:
    """A trigonometric polynomial with the zeros of some atoms and, rather than their squares, of a few spare ones."""
    for count in range(len(spare) + 1):
        for chosen in combinations(spare, count):
            every = [*atoms, *chosen]
            if any(atom.value == "pi" for atom in every):
                continue
            root = ring.to_trig(prod(map(ring.half_of, every), start=ring.half.constant(1)))
            if root is not None:
                return root
    return _times(ring, [f.whole for f in join_pins(ring, atoms)])


def _shorter(ring: Ring, factor: Equality, pins: Sequence[Atom]) -> Equality:
    """A condition in half angles times the half angle of a pin, where that is shorter than its square."""
    if len(factor.atoms) != 1 or factor.atoms[0].is_pin:
        return factor
    other = _unsquare(ring, factor.atoms, pins)
    if 2 < len(other) < factor.terms:
        return replace(factor, whole=other)
    return factor


def _without_letters(ring: Ring, p: Polynomial, letters: Iterable[tuple[Polynomial, int]]) -> Polynomial:
    """p divided by factors in lengths alone (half-angle ring), as often as they divide it."""
    for divisor in (letters_polynomial(ring, f) for f, power in letters for _ in range(power)):
        quotient, remainder = divmod(p, divisor)
        p = quotient if remainder == 0 else p
    return p


def _times(ring: Ring, factors: Sequence[Polynomial]) -> Polynomial:
    return reduce(lambda one, two: ring.reduce(one * two), factors, ring.one)
