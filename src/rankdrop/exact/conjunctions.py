"""What a method of derivation computes: polynomial conditions, and whether they hold at configurations.

`Conjunction` is one condition, `SetDerivation` all of them, and what makes them: minors, factors and conjunctions, all
against one clock. A case of a derivation is a set of configurations (`ZeroSet`): what vanishes on it, and what does
not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.algebra.field import ModularPoint, holds
from rankdrop.algebra.halt import Halt, HaltKind
from rankdrop.algebra.matrix import each_entry, submatrix
from rankdrop.algebra.polynomial import Atom, Equality, Polynomial, order
from rankdrop.algebra.ring import Ring, add_terms, numeric_terms
from rankdrop.algebra.work import OutOfTime, Work
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.errors import OptionError
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.verify import random_points, rank_check
from rankdrop.exact.letters import sign_of
from rankdrop.exact.stratum import atoms_on, meet
from rankdrop.families.unfinished import Unfinished, UnfinishedKind
from rankdrop.formula.writing import RADIANS
from rankdrop.lists import smallest_sets
from rankdrop.robot.model import Array
from rankdrop.units import into_units

STEP = 1e-5
"""Of central differences [rad, m]: rounding leaves 1e-11 of the gradient, the third derivative 1e-10."""


NOISE = 1e-10
"""Slopes below it, relative to the coefficients, may be rounding: ten times what `STEP` leaves of it."""

ZERO = 1e-5
"""A condition holds within this distance of its zeros [rad]: where sheets cross, σ = 1e-13 leaves 3e-7."""
CLEAR = 1e-8
"""… and what must not vanish does not where this far off; less than `ZERO`, so that cases overlap and leave no gap."""

Columns = Sequence[Sequence[Polynomial]]
"""Columns of a matrix over the trigonometric ring."""
TOLD = 1
"""Pinned joints of a case up to which its screw, and where that vanishes, is told."""
Pins = tuple[tuple[int, str], ...]
"""Pinned joints of a case: its columns depend on nothing else."""
Note = tuple[str, dict[str, Any]]
"""What a method notes on the way, and its figures."""

Atoms = frozenset[Atom]
"""The atoms of one polynomial, which vanishes where one of them does."""


class ZeroDistances:
    """Distances of configurations from the zeros of polynomials, to first order: |f|/|∇f|, half the distance from the
    zeros of a sum of squares; where the slope may be rounding, the smaller of that and √|f|.

    What was asked for once is kept: the cases of a derivation speak of few different polynomials.

    Args:
        chain: the arm.
        q: (N, n) configurations [rad, m].
    """

    def __init__(self, chain: Chain, q: ArrayLike) -> None:
        self._chain = chain
        self._theta = into_units(chain.robot, np.atleast_2d(np.asarray(q, dtype=np.float64))) + chain.shifts
        self._known: dict[str, Array] = {}

    def __len__(self) -> int:
        return len(self._theta)

    def of(self, f: Polynomial | Atom) -> Array:
        """(N,) [rad; slides in the arm's own unit] of a trigonometric polynomial or an atom; f is divided by the size
        of its coefficients.
        """
        key = f.key if isinstance(f, Atom) else str(f)
        if key in self._known:
            return self._known[key]
        chain, theta = self._chain, self._theta
        if isinstance(f, Atom) and f.f is None:
            distances = 2 * np.abs(np.sin((theta[:, f.joint - 1] - RADIANS[f.value]) / 2))
        else:
            steps = STEP * np.eye(chain.n)[:, None]
            values, scales = values_of(chain, f, np.concatenate([theta[None], theta + steps, theta - steps]))
            value, scale = values[0], scales[0]
            slope = (values[1 : chain.n + 1] - values[chain.n + 1 :]).T / (2 * STEP)
            size, steep = np.abs(value) / scale, np.linalg.norm(slope, axis=1) / scale
            ratio = size / np.maximum(steep, 1e-300)
            distances = np.where(steep > NOISE, ratio, np.minimum(ratio, np.sqrt(size)))
        return self._known.setdefault(key, np.asarray(distances))


def values_of(chain: Chain, f: Polynomial | Atom, theta: Array) -> tuple[Array, Array]:
    """(value, size of the terms), both (...), less the same number, lengths in the arm's own unit, at θ (..., n).

    Of an atom it is the homogeneous value, which is finite at θ = π; angles enter sizes as 1, slides as 1 at least.
    """
    p = chain.own_polynomial(f.f if isinstance(f, Atom) else f)
    powers = chain.ring.powers_at(p, theta)
    numbers: dict[tuple[int, ...], float] = {}  # terms that differ in lengths alone are one
    amounts: dict[tuple[int, ...], float] = {}
    for number, exponents in numeric_terms(p, chain.own_numbers):
        moving = exponents[: len(powers)]
        numbers[moving] = numbers.get(moving, 0.0) + number
        amounts[moving] = amounts.get(moving, 0.0) + abs(number)
    sizes = [[np.maximum(np.abs(x), 1.0) for x in powers_of_variable] for powers_of_variable in powers]
    return (
        add_terms(((number, exponents) for exponents, number in numbers.items()), powers),
        add_terms(((amount, exponents) for exponents, amount in amounts.items()), sizes),
    )


def _distance(equality: Equality, distances: ZeroDistances) -> Array:
    """First-order distance of configurations from where it holds: (N,) [rad, m]; of atoms the nearest."""
    if equality.whole is None:
        parts = equality.atoms
    else:
        parts = (equality.whole,)
    return np.asarray(np.min([distances.of(part) for part in parts], axis=0, initial=np.inf))


@dataclass(frozen=True)
class Conjunction:
    """Conditions that hold together.

    Attributes:
        equal: all of them vanish; none at all holds everywhere.
        unequal: of each group at least one does not vanish.
    """

    equal: tuple[Equality, ...]
    unequal: tuple[tuple[Equality, ...], ...] = ()

    def holds(self, distances: ZeroDistances) -> NDArray[np.bool_]:
        """Whether it holds at configurations, within `ZERO`: (N,)."""
        met = np.ones(len(distances), dtype=np.bool_)
        for equality in self.equal:
            met &= _distance(equality, distances) <= ZERO
            if not met.any():
                return met
        for group in self.unequal:
            met &= np.max([_distance(equality, distances) for equality in group], axis=0) > CLEAR
        return met

    def holds_at(self, ring: Ring, point: ModularPoint) -> bool:
        """Whether it holds at a point modulo a prime, exactly."""
        if not all(_vanishes(equality, ring, point) for equality in self.equal):
            return False
        return not any(all(_vanishes(equality, ring, point) for equality in group) for group in self.unequal)


def _vanishes(equality: Equality, ring: Ring, point: ModularPoint) -> bool:
    if equality.whole is None:
        return any(holds(ring, atom, point) for atom in equality.atoms)
    return holds(ring, equality.whole, point)


class SetDerivation:
    """A singular set as one method finds it, and while it does: what it may spend, and what it fills in.

    Args:
        chain: the arm and its task.
        method: one of `METHODS`.
        seconds: of work.
        frame: link in whose frame the screws of a pose are taken; None for the one where they are shortest.
        basic: numbers of the joints whose screws are taken first, where the method chooses some; None for no wish.
        corank: k of the configurations that are derived, of rank m − k or less.

    Attributes:
        columns: of the Jacobian.
        conditions: a configuration is singular where one of these holds.
        generic: whether configurations were left out that `notes` tell of: the conditions are necessary off them only.
        notes: what is to be said of the answer: a word for what it is, and its figures.
        sizes: figures of what was met on the way ("minors", "terms", …).
        left: what was not finished within the limit; empty where everything was.
    """

    def __init__(
        self,
        chain: Chain,
        method: str,
        seconds: float,
        *,
        frame: int | None = None,
        basic: tuple[int, ...] | None = None,
        corank: int = 1,
    ) -> None:
        self.chain, self.ring, self.method = chain, chain.ring, method
        self.basic, self.corank = basic, corank
        self.columns: Columns = chain.columns if frame is None else chain.screws(frame)
        self.conditions: list[Conjunction] = []
        self.notes: list[Note] = []
        self.sizes: dict[str, int] = {}
        self.left: list[Unfinished] = []
        self.generic = False
        self._whole = 0  # polynomials that were left unfactored
        self._atoms: dict[str, tuple[Atom, ...]] = {}
        self._work = Work(seconds)

    def note(self, what: str, **facts: Any) -> None:
        """One more fact that is to be said."""
        self.notes.append((what, facts))

    @property
    def remaining(self) -> float:
        """Wall time that is left [s]."""
        return self._work.remaining

    def check(self, step: Halt) -> None:
        """Continue with a step if there is time.

        Raises:
            OutOfTime: there is none; names the step.
        """
        try:
            self._work.check()
        except OutOfTime:
            raise OutOfTime(step) from None

    def case_by_case(self, treat: Callable[[ZeroSet], list[ZeroSet]]) -> None:
        """Treat the whole space, then the exceptional cases that follow from each case, until none is left.

        Args:
            treat: adds the conditions of a case; gives the disjoint cases in which its choice says nothing.

        Raises:
            OutOfTime: no time is left: the conditions are `generic`.
        """
        self.generic = True
        waiting = [ZeroSet.whole(self.ring)]
        while waiting:
            case = waiting.pop(0)
            cases = Halt(HaltKind.EXCEPTIONAL_CASES, number=len(waiting) + 1)
            try:
                self.check(cases)
                waiting += treat(case)
            except OutOfTime as error:
                raise OutOfTime(replace(error.halt, waiting=cases)) from error
        self.generic = False

    @property
    def complete(self) -> bool:
        """Whether every case was finished."""
        return not self.left

    @property
    def assumptions(self) -> tuple[Polynomial, ...]:
        """Polynomials in lengths, of the half-angle ring, taken not to vanish."""
        return tuple(self._work.assumed.values())

    def holds(self, q: ArrayLike) -> NDArray[np.bool_]:
        """Whether one of the conditions holds at configurations q (N, n), within `ZERO`: (N,)."""
        distances = ZeroDistances(self.chain, q)
        none = np.zeros(len(distances), dtype=np.bool_)
        return np.asarray(np.logical_or.reduce([none, *(condition.holds(distances) for condition in self.conditions)]))

    def holds_at(self, point: ModularPoint) -> bool:
        """Whether one of the conditions holds at a point modulo a prime, exactly."""
        return any(condition.holds_at(self.ring, point) for condition in self.conditions)

    def finish(self) -> None:
        """Name the factors that were not found, and the lengths assumed ≠ 0 that are 0 for this arm."""
        zero = [factor for factor in self.assumptions if sign_of(self.chain, factor) == 0]
        self.left += [self._record_unfinished(UnfinishedKind.ZERO_LENGTHS, conditions=str(factor)) for factor in zero]
        if self._whole:
            self.left.append(self._record_unfinished(UnfinishedKind.FACTORS, number=self._whole))

    def halt(self, halt: Halt) -> None:
        """Note that the method was ended before its end."""
        self.left.append(self._record_unfinished(UnfinishedKind.METHOD, halt=halt))

    def _record_unfinished(self, kind: UnfinishedKind, **facts: Any) -> Unfinished:
        return Unfinished(kind, method=self.method.replace("_", "-"), corank=self.corank, **facts)

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
        self.check(Halt(HaltKind.MINORS))
        return self.ring.determinant(submatrix(columns, range(len(columns)), rows))

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
            self.check(Halt(HaltKind.FACTORS, terms=len(p)))
            factors = self.ring.factors_within(p, self.remaining)
            if factors is None:
                return None
            for factor, _ in factors.letters:
                self._work.assume(factor)
            self._atoms[key] = tuple(atom for atom, _ in factors.atoms)
        return self._atoms[key]

    def factors(self, piece: ZeroSet, p: Polynomial) -> Atoms | None:
        """Atoms of p that may vanish on a set, the pins put in; empty where p never does, None where it always does.

        Raises:
            OutOfTime: no time is left, or p is too long to be factored in it.
        """
        if p == 0:
            return None
        atoms = self.atoms(p)
        if atoms is None:
            raise OutOfTime(Halt(HaltKind.FACTORS, terms=len(p)))
        if atoms:
            atoms_here = atoms_on(piece, Equality(atoms), self._work.assumed)
        else:
            atoms_here = ()
        if atoms_here is None:
            return None
        return frozenset(atoms_here)

    def branches(self, piece: ZeroSet, atoms: Atoms) -> list[ZeroSet]:
        """The disjoint parts of a set where a product vanishes: each factor in turn, those before it not."""
        pieces: list[ZeroSet] = []
        for atom in sorted(atoms, key=order):
            pieces += meet(piece, atom, self._work.assumed)
            piece = piece.remove_zeros(atom)
        return pieces

    def factored_equality(self, p: Polynomial) -> Equality:
        """p = 0: factored if there is time, and whole where there is not: the condition is right, if long."""
        try:
            atoms = self.atoms(p)
        except OutOfTime:
            atoms = None
        if atoms is None:
            return Equality((), p)
        return Equality(atoms)

    def equality(self, p: Polynomial) -> Equality:
        """`factored`; a polynomial that stays whole is counted as not finished."""
        factored = self.factored_equality(p)
        self._whole += factored.whole is not None
        return factored


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
    if sets and not whole:
        common = frozenset.intersection(*sets)
    else:
        common = frozenset()
    rest = {cases - common for cases in sets}
    cases = [Conjunction((Equality((atom,)),), unequal) for atom in sorted(common, key=order)]
    if all(rest):  # a polynomial that is the common factors alone leaves no more
        least = [equality_of(cases_left) for cases_left in smallest_sets(rest)]
        cases.append(Conjunction((*sorted(least, key=place_of), *whole), unequal))
    return tuple(cases)


def equality_of(atoms: Atoms) -> Equality:
    """One polynomial of these factors."""
    return Equality(tuple(sorted(atoms, key=order)))


def place_of(equality: Equality) -> tuple[int, list[str]]:
    """Sort key of polynomials that vanish together: short ones first."""
    return equality.terms, [atom.key for atom in equality.atoms]


def columns_on(piece: ZeroSet, columns: Columns) -> Columns:
    """A matrix with the pinned joints put in."""
    if piece.pins:
        return each_entry(lambda x: piece.ring.at(x, piece.pins), columns)
    return columns


def conditions_on(piece: ZeroSet) -> tuple[Equality, ...]:
    """Everything that vanishes on a set."""
    pins = [piece.ring.pin(joint, value) for joint, value in sorted(piece.pins.items())]
    return tuple(Equality((atom,)) for atom in (*pins, *sorted(map(piece.ring.atom, piece.equations), key=order)))


def condition_within(
    piece: ZeroSet, condition: Conjunction, unequal: tuple[tuple[Equality, ...], ...] = ()
) -> Conjunction:
    """A condition that holds on a set, with what vanishes there and what does not."""
    nonzero = tuple((Equality((atom,)),) for atom in sorted(piece.nonzero, key=order))
    return Conjunction((*conditions_on(piece), *condition.equal), (*nonzero, *unequal))
