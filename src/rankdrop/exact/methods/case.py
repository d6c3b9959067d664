"""A case of a derivation: what is taken to vanish in it, and what not to."""

from __future__ import annotations

from dataclasses import dataclass, replace

from rankdrop.exact.algebra.atom import Atom, order
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.algebra.work import OutOfTime
from rankdrop.exact.methods.derivation import Conjunction, Equality
from rankdrop.exact.methods.draft import Columns, Draft

Factors = frozenset[Atom]
"""The atoms of one polynomial, which vanishes where one of them does."""


@dataclass(frozen=True)
class Case:
    """Joints that are pinned, polynomials that vanish, and some that do not.

    Attributes:
        pins: pinned joints; they are put in wherever a polynomial is looked at.
        zero: atoms that vanish, none of them a pin.
        product: polynomials of more than one factor that vanish.
        nonzero: atoms that do not vanish.
    """

    pins: tuple[tuple[int, str], ...] = ()
    zero: Factors = frozenset()
    product: frozenset[Factors] = frozenset()
    nonzero: Factors = frozenset()

    def columns(self, ring: Ring, columns: Columns) -> Columns:
        """A matrix with the pinned joints put in."""
        pins = dict(self.pins)
        return [[ring.at(x, pins) for x in column] for column in columns] if pins else columns

    def factors(self, draft: Draft, p: Polynomial) -> Factors | None:
        """Atoms of p that may vanish here, the pins put in; empty where p never does, None where it always does.

        p may vanish in the whole case without a factor that tells of it: then some of the atoms do, and following them
        leads to the same case again, or to an empty one.

        Raises:
            OutOfTime: no time is left, or p is too long to be factored in it.
        """
        if p == 0:
            return None
        atoms = draft.atoms(p)
        if atoms is None:
            raise OutOfTime(f"factors of a polynomial of {len(p)} terms")
        if self.zero.intersection(atoms):
            return None
        return frozenset(atoms) - self.nonzero

    def with_zero(self, draft: Draft, atom: Atom) -> Case | None:
        """The part where the atom vanishes; None where that is seen to be empty."""
        if atom in self.nonzero:
            return None
        if not atom.pinned:
            return replace(self, zero=self.zero | {atom}).settled()
        if any(joint == atom.joint for joint, _ in self.pins):
            return self if (atom.joint, atom.value) in self.pins else None
        case = Case(pins=tuple(sorted((*self.pins, (atom.joint, atom.value)))))
        for old in self.nonzero:
            found = draft.pinned(old, atom)
            if found is None:
                return None
            case = replace(case, nonzero=case.nonzero | found)
        vanishing = [frozenset({old}) for old in self.zero] + list(self.product)
        for product in vanishing:
            parts = [draft.pinned(old, atom) for old in product]
            if None not in parts:
                found = frozenset[Atom]().union(*(part for part in parts if part is not None))
                case = replace(case, product=case.product | {found})
        return case.settled()

    def with_nonzero(self, *atoms: Atom) -> Case:
        """The part where none of the atoms vanishes."""
        return replace(self, nonzero=self.nonzero.union(atoms))

    def settled(self) -> Case | None:
        """Products without the factors that do not vanish; None where one of them never vanishes."""
        products = {product - self.nonzero for product in self.product}
        single = frozenset(next(iter(product)) for product in products if len(product) == 1)
        pinned = frozenset(atom for atom in single if atom.pinned)
        if frozenset() in products or self.nonzero & self.zero:
            return None
        zero = self.zero | (single - pinned)
        kept = frozenset(p for p in products if not p & zero and (len(p) > 1 or p & pinned))
        return replace(self, zero=zero, product=kept)

    def equalities(self, ring: Ring) -> tuple[Equality, ...]:
        """Everything that vanishes."""
        pins = [Equality((ring.pin(joint, value),)) for joint, value in self.pins]
        zero = [Equality((atom,)) for atom in sorted(self.zero, key=order)]
        products = [Equality(tuple(sorted(product, key=order))) for product in self.product]
        return (*pins, *zero, *sorted(products, key=lambda equality: [atom.key for atom in equality.atoms]))

    def conjunction(
        self, ring: Ring, piece: Conjunction, others: tuple[tuple[Equality, ...], ...] = ()
    ) -> Conjunction:
        """A condition within this case, with what does not vanish in it."""
        nonzero = tuple((Equality((atom,)),) for atom in sorted(self.nonzero, key=order))
        return Conjunction((*self.equalities(ring), *piece.equal), (*nonzero, *others))


def branches(draft: Draft, case: Case, atoms: Factors) -> list[Case]:
    """The disjoint parts of a case where a product vanishes: each factor in turn, those before it not."""
    found, before = [], case
    for atom in sorted(atoms, key=order):
        part = before.with_zero(draft, atom)
        if part is not None:
            found.append(part)
        before = before.with_nonzero(atom)
    return found


def size(polynomials: list[Polynomial]) -> int:
    """Terms of several polynomials together."""
    return sum(len(p) for p in polynomials)
