"""A derivation in the making: minors, factors and conjunctions, all against one clock."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import combinations

from rankdrop.errors import OptionError
from rankdrop.exact.algebra.atom import Atom, order
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.algebra.work import OutOfTime, Work
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.methods.apart import factors_within
from rankdrop.exact.methods.derivation import Conjunction, Derivation, Equality
from rankdrop.exact.verify import random_points, rank_check

Columns = Sequence[Sequence[Polynomial]]
"""Columns of a matrix over the trigonometric ring."""


class Draft:
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


def pieces(
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
    """As `Draft.pinned`. A degree that falls is a zero at θ = π."""
    if atom.f is None:
        if atom.joint != pin.joint:
            return frozenset({atom})
        return None if atom.value == pin.value else frozenset()
    f = ring.half_at(atom.f, {pin.joint: pin.value})
    if f == 0:
        return None
    degrees, before = f.degrees(), atom.f.degrees()
    fallen = {
        ring.pin(j, "pi") for place, j in enumerate(ring.revolute) if j != pin.joint and degrees[place] < before[place]
    }
    return frozenset(fallen | {found for found, _ in ring.split(f)[2]})
