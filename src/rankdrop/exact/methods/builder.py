"""A derivation in the making: minors, factors and conjunctions, all against one clock.

A case of a derivation: what is taken to vanish in it, and what not to.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations

from rankdrop.errors import OptionError
from rankdrop.exact.algebra.factoring import factors_within
from rankdrop.exact.algebra.polynomial import Atom, Equality, Polynomial, order
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.algebra.work import OutOfTime, Work
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.verify import random_points, rank_check
from rankdrop.exact.methods.derivation import Conjunction, Derivation

Columns = Sequence[Sequence[Polynomial]]
"""Columns of a matrix over the trigonometric ring."""


class DerivationBuilder:
    """What a method fills in; all that it may spend.

    Args:
        chain: the arm.
        method: its name.
        seconds: of wall time.
        frame: link in whose frame the screws of a pose are taken; None for the one where they are shortest.
        basic: numbers of the joints whose screws are taken first, where the method chooses some; None for no wish.

    Attributes:
        columns: of the Jacobian.
        conditions, notes, sizes, left, generic: as of `Derivation`.
    """

    def __init__(
        self,
        chain: Chain,
        method: str,
        seconds: float,
        *,
        frame: int | None = None,
        basic: tuple[int, ...] | None = None,
    ) -> None:
        self.chain, self.ring, self.method = chain, chain.ring, method
        self.basic = basic
        self.columns: Columns = chain.columns if frame is None else chain.screws(frame)
        self.conditions: list[Conjunction] = []
        self.notes: list[str] = []
        self.sizes: dict[str, int] = {}
        self.left: list[str] = []
        self.generic = False
        self._whole = 0  # polynomials that were left unfactored
        self._atoms: dict[str, tuple[Atom, ...]] = {}
        self._pinned: dict[tuple[Atom, Atom], frozenset[Atom] | None] = {}
        self._work, self._seconds = Work(seconds), seconds

    @property
    def remaining(self) -> float:
        """Wall time that is left [s]."""
        return self._work.left

    def check(self, what: str) -> None:
        """Go on with `what` if there is time.

        Raises:
            OutOfTime: there is none; says what was about to be done.
        """
        try:
            self._work.check()
        except OutOfTime:
            raise OutOfTime(what) from None

    def finished(self) -> Derivation:
        """The derivation as it stands."""
        if self._whole:
            self.left.append(f"factors of {self._whole} polynomial{'s' if self._whole > 1 else ''}")
        return Derivation(
            self.chain, self.method, tuple(self.conditions), self.generic, tuple(self._work.assumed.values()),
            tuple(self.notes), self.sizes, tuple(self.left), self._seconds - self.remaining,
        )  # fmt: skip

    def full_rank(self) -> int:
        """The rank of almost every configuration, which has to be that of a matrix of full rank.

        Raises:
            OptionError: the task asks for more than the arm can do anywhere.
        """
        rank, full = max(rank_check(self.chain, random_points(self.chain, 3))), min(self.chain.task.m, self.chain.n)
        if rank < full:
            raise OptionError(
                f"the method {self.method} sees a rank that is not full, and this one never is",
                where=f"robot {self.chain.robot.name!r}, task {self.chain.task.name}",
                got=f"rank {rank} of {full}",
                mend="leave out of the task what the arm cannot do anywhere, or use the rank tree",
            )
        return rank

    def minor(self, columns: Columns, rows: Iterable[int]) -> Polynomial:
        """Determinant of the given rows of as many columns.

        Raises:
            OutOfTime: no time is left.
        """
        self.check("minors")
        return self.ring.determinant([[column[row] for column in columns] for row in rows])

    def minors(self, columns: Columns, size: int) -> Iterator[Polynomial]:
        """Every minor of one size.

        Raises:
            OutOfTime: no time is left.
        """
        for chosen in combinations(columns, size):
            for rows in combinations(range(len(columns[0])), size):
                yield self.minor(chosen, rows)

    def atoms(self, p: Polynomial) -> tuple[Atom, ...] | None:
        """The atoms of p ≠ 0, shortest first; None where there was not the time. Lengths are taken not to vanish.

        Raises:
            OutOfTime: no time is left.
        """
        key = str(p)
        if key not in self._atoms:
            self.check(f"factors of a polynomial of {len(p)} terms")
            found = factors_within(self.ring, p, self.remaining)
            if found is None:
                return None
            for factor, _ in found.letters:
                self._assume(factor)
            self._atoms[key] = tuple(atom for atom, _ in found.atoms)
        return self._atoms[key]

    def pinned(self, atom: Atom, pin: Atom) -> frozenset[Atom] | None:
        """Atoms of an atom once a joint is pinned; None where it vanishes, empty where it never does."""
        key = (atom, pin)
        if key not in self._pinned:
            self._pinned[key] = _pinned(self.ring, atom, pin)
        return self._pinned[key]

    def equality(self, p: Polynomial) -> Equality:
        """p = 0: factored if there is time, and whole where there is not: the condition is right, if long."""
        atoms = self.atoms(p) if self.remaining > 0 else None
        if atoms is None:
            self._whole += 1
            return Equality((), p)
        return Equality(atoms)

    def _assume(self, factor: Polynomial) -> None:
        """Take a factor in lengths alone for ≠ 0; where it is 0 for this arm that is said among what is left."""
        key = str(factor)
        if key in self._work.assumed:
            return
        self._work.assume(factor)
        total = Fraction(0)
        for powers, coefficient in factor.terms():
            term = Fraction(int(coefficient.p), int(coefficient.q))
            for name, power in zip(self.ring.names, powers, strict=True):
                if power:
                    term *= self.chain.letters[name] ** int(power)
            total += term
        if total == 0:
            self.left.append(f"the arm with {key} = 0, which this arm has: its conditions are not these")


def conjunctions(
    equalities: Iterable[Equality], unequal: tuple[tuple[Equality, ...], ...] = ()
) -> tuple[Conjunction, ...]:
    """Polynomials that all vanish, as conjunctions: each common factor alone, and what is left of all of them.

    Args:
        equalities: all of which hold.
        unequal: goes with each conjunction.

    Returns:
        One conjunction without equalities where none was given: it holds everywhere. None at all where a polynomial
        never vanishes.
    """
    given = list(equalities)
    whole = [equality for equality in given if equality.whole is not None]
    sets = {frozenset(equality.atoms) for equality in given if equality.whole is None}
    common = frozenset.intersection(*sets) if sets and not whole else frozenset()
    rest = {found - common for found in sets}
    found = [Conjunction((Equality((atom,)),), unequal) for atom in sorted(common, key=order)]
    if all(rest):  # a polynomial that is the common factors alone leaves no more
        least = [one for one in rest if not any(other < one for other in rest)]
        kept = [Equality(tuple(sorted(one, key=order))) for one in least]
        kept.sort(key=lambda equality: (equality.terms, [atom.key for atom in equality.atoms]))
        found.append(Conjunction((*kept, *whole), unequal))
    return tuple(found)


def _pinned(ring: Ring, atom: Atom, pin: Atom) -> frozenset[Atom] | None:
    """As `DerivationBuilder.pinned`."""
    if atom.f is None:
        if atom.joint != pin.joint:
            return frozenset({atom})
        return None if atom.value == pin.value else frozenset()
    form = ring.form(atom.f).at({pin.joint: pin.value})
    return None if form.f == 0 else frozenset(found for found, _ in form.factors().atoms)


Atoms = frozenset[Atom]
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
    zero: Atoms = frozenset()
    product: frozenset[Atoms] = frozenset()
    nonzero: Atoms = frozenset()

    def columns(self, ring: Ring, columns: Columns) -> Columns:
        """A matrix with the pinned joints put in."""
        pins = dict(self.pins)
        return [[ring.at(x, pins) for x in column] for column in columns] if pins else columns

    def factors(self, builder: DerivationBuilder, p: Polynomial) -> Atoms | None:
        """Atoms of p that may vanish here, the pins put in; empty where p never does, None where it always does.

        p may vanish in the whole case without a factor that tells of it: then some of the atoms do, and following them
        leads to the same case again, or to an empty one.

        Raises:
            OutOfTime: no time is left, or p is too long to be factored in it.
        """
        if p == 0:
            return None
        atoms = builder.atoms(p)
        if atoms is None:
            raise OutOfTime(f"factors of a polynomial of {len(p)} terms")
        if self.zero.intersection(atoms):
            return None
        return frozenset(atoms) - self.nonzero

    def with_zero(self, builder: DerivationBuilder, atom: Atom) -> Case | None:
        """The part where the atom vanishes; None where that is seen to be empty."""
        if atom in self.nonzero:
            return None
        if not atom.pinned:
            return replace(self, zero=self.zero | {atom}).simplified()
        if any(joint == atom.joint for joint, _ in self.pins):
            return self if (atom.joint, atom.value) in self.pins else None
        case = Case(pins=tuple(sorted((*self.pins, (atom.joint, atom.value)))))
        for old in self.nonzero:
            found = builder.pinned(old, atom)
            if found is None:
                return None
            case = replace(case, nonzero=case.nonzero | found)
        vanishing = [frozenset({old}) for old in self.zero] + list(self.product)
        for product in vanishing:
            parts = [builder.pinned(old, atom) for old in product]
            if None not in parts:
                found = frozenset[Atom]().union(*(part for part in parts if part is not None))
                case = replace(case, product=case.product | {found})
        return case.simplified()

    def with_nonzero(self, *atoms: Atom) -> Case:
        """The part where none of the atoms vanishes."""
        return replace(self, nonzero=self.nonzero.union(atoms))

    def simplified(self) -> Case | None:
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


def branches(builder: DerivationBuilder, case: Case, atoms: Atoms) -> list[Case]:
    """The disjoint parts of a case where a product vanishes: each factor in turn, those before it not."""
    found, before = [], case
    for atom in sorted(atoms, key=order):
        part = before.with_zero(builder, atom)
        if part is not None:
            found.append(part)
        before = before.with_nonzero(atom)
    return found


def size(polynomials: Iterable[Polynomial]) -> int:
    """Terms of several polynomials together."""
    return sum(len(p) for p in polynomials)
