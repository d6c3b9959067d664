"""Cases of an exact derivation that were not taken apart: conditions as they stand, with a configuration on each.

The rank tree splits the configurations of lower rank into cases. Where it stops, a case is still an exact statement:
the rank is lower than r where its conditions hold and all minors of order r of the Jacobian vanish. Real configurations
of it are solved for numerically from random starts; finding none proves nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import comb

import numpy as np
from numpy.typing import NDArray

from rankdrop.algebra.polynomial import Polynomial
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.parts import parts_of, scale_angle, whole_angles
from rankdrop.exact.tree import OpenCase, RankTree
from rankdrop.formula.equation import Equation, System
from rankdrop.formula.writing import AnglePin, Condition, pin_of
from rankdrop.problem import Problem, wrap_joints
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import words_of
from rankdrop.solve import newton
from rankdrop.tolerances import REAL_STARTS
from rankdrop.units import out_of_units

_WITNESSES = 8  # configurations of a case that are tried with many digits
_ITERATIONS = 60
_READABLE = 40  # terms of a condition that is written out

OffFamilies = Callable[[Array, int], NDArray[np.int64]]
"""(N, n) configurations, corank -> which of them lie on no family of that corank or a larger one."""

Followed = Callable[[int, Array], Array]
"""Corank, (n,) configuration of the arm in its own unit -> (k, n) those next to it, itself included, that are singular
with many digits."""


@dataclass(frozen=True, slots=True)
class PolynomialSize:
    """A condition by its size.

    Attributes:
        joints: numbers of the joints in it.
        degree: total, in the tangents of half the joint angles and in slides.
        terms: number of terms.
    """

    joints: tuple[int, ...]
    degree: int
    terms: int


@dataclass(frozen=True, eq=False)
class UndividedSet:
    """One case: the rank is lower than `order` where its conditions hold and all minors of that order vanish.

    Attributes:
        corank: of configurations on it, or more.
        pins: joints at simple angles.
        polynomials: what else vanishes there, by size.
        order: r, of the minors.
        minors: number of minors; of the Jacobian less the rows and columns that are cleared exactly.
        degree: of a minor, at most, in sines and cosines of the joints and in slides.
        starts: random starts from which configurations on it were solved for.
        found: how many of them ended at a configuration of rank lower than `order`.
        off: how many of these lie on no family of that corank.
        witness: one of them, on no family where there is one [rad, m]; None where none was found.
        equations: its conditions in q, for the arm in its own unit of length.
        stated: the same conditions exactly, in θ and the letters of the arm, short ones first; they may hold on several
            irreducible sets.
    """

    corank: int
    pins: tuple[AnglePin, ...]
    polynomials: tuple[PolynomialSize, ...]
    order: int
    minors: int
    degree: int
    starts: int
    found: int
    off: int
    witness: tuple[float, ...] | None
    equations: tuple[Equation, ...]
    stated: tuple[AnglePin | Condition, ...] = ()

    @cached_property
    def texts(self) -> tuple[str, ...]:
        """Every condition for people, as families have them; none where one has more than `_READABLE` terms."""
        if any(isinstance(condition, Condition) and len(condition.polynomial) > _READABLE for condition in self.stated):
            return ()
        return tuple(condition.text() for condition in self.stated)

    @property
    def words(self) -> str:
        """In words: "corank 1 or more where θ2 = 0, 2 polynomials in joints 3, 4 vanish together …"."""
        words: str = words_of(self).undivided_words(self)
        return words


def undivided_sets(
    chain: Chain, tree: RankTree, off_families: OffFamilies, followed: Followed, seed: int
) -> tuple[UndividedSet, ...]:
    """The open cases of a tree, each with real configurations on it.

    Args:
        chain: the arm.
        tree: of the arm.
        off_families: tries configurations on the families made from it.
        followed: from one that may become the witness: next to a multiple zero Newton's method ends too early.
        seed: of the random starts.
    """
    return tuple(_describe_undivided(chain, tree, case, off_families, followed, seed) for case in tree.cases)


def _describe_undivided(
    chain: Chain, tree: RankTree, case: OpenCase, off_families: OffFamilies, followed: Followed, seed: int
) -> UndividedSet:
    piece, order = case.piece, case.order - tree.cleared
    corank = tree.generic_rank - case.order + 1
    pins = tuple(pin_of(chain.ring, joint, (value,)) for joint, value in sorted(piece.pins.items()))
    polynomials = sorted(piece.equations, key=len)
    equations = equations_of(chain, piece)
    q = _points(chain, corank, equations, seed)
    off = off_families(q, corank)
    columns, _ = chain.cleared_columns
    return UndividedSet(
        corank=corank,
        pins=pins,
        polynomials=tuple(size_of(chain, f) for f in polynomials),
        order=order,
        minors=comb(len(columns), order) * comb(len(columns[0]), order),
        degree=_degree(chain, piece, columns, order),
        starts=REAL_STARTS,
        found=len(q),
        off=len(off),
        witness=_witness(chain, q[off] if len(off) else q, System(equations), partial(followed, corank)),
        equations=equations,
        stated=(*pins, *(Condition(chain.ring, f) for f in polynomials)),
    )


def cases_in_whole_angles(robot: Robot, cases: Sequence[UndividedSet]) -> tuple[UndividedSet, ...]:
    """Cases of `in_parts(robot)`, as they are derived, as those of the arm."""
    return tuple(_in_whole_angles(case, robot) for case in cases)


def _in_whole_angles(case: UndividedSet, robot: Robot) -> UndividedSet:
    witness = case.witness
    if witness is not None:
        witness = tuple(float(x) for x in whole_angles(robot, np.array(witness)))
    return replace(
        case, equations=tuple(scale_angle(equation, parts_of(robot)) for equation in case.equations), witness=witness
    )


def equations_of(chain: Chain, piece: ZeroSet) -> tuple[Equation, ...]:
    """The conditions of a set as equations in configurations of `Chain.own`."""
    own = [Condition(chain.ring, chain.own_polynomial(f)) for f in piece.equations]
    stated: list[AnglePin | Condition] = [
        *(pin_of(chain.ring, joint, (value,)) for joint, value in piece.pins.items()), *own
    ]  # fmt: skip
    return tuple(condition.equation(chain.own_numbers, chain.n, chain.whole_shifts.tolist()) for condition in stated)


def size_of(chain: Chain, f: Polynomial) -> PolynomialSize:
    """Joints, degree and number of terms of a half-angle polynomial."""
    degree = max(sum(map(int, powers[: chain.ring.moving])) for powers in f.monoms())
    return PolynomialSize(Condition(chain.ring, f).joints, degree, len(f))


def _degree(chain: Chain, piece: ZeroSet, columns: Sequence[Sequence[Polynomial]], order: int) -> int:
    """Largest degree that a minor may have on a set: the sum of those of as many columns."""
    ring = chain.ring
    degrees = []
    for column in columns:
        here = [ring.at(x, piece.pins) for x in column]
        degrees.append(max((_moving_degree(chain, x) for x in here if x != 0), default=0))
    return sum(sorted(degrees)[-order:])


def _moving_degree(chain: Chain, x: Polynomial) -> int:
    """Total degree of a trigonometric polynomial in sines, cosines and slides."""
    variables = chain.ring.angles + chain.ring.moving  # a sine and a cosine of each angle, then slides
    return max(sum(map(int, powers[:variables])) for powers in x.monoms())


def _points(chain: Chain, corank: int, equations: Sequence[Equation], seed: int) -> Array:
    """(k, n) configurations of `Chain.own` that satisfy some equations and lose so many freedoms."""
    problem, system = Problem(chain.own, chain.own_task, corank), System(tuple(equations))

    def equations_at(q: Array) -> tuple[NDArray[np.bool_], Array, Array]:
        here = problem.block(q)
        values, slopes = system.linear(q)
        going = (here.sigma[:, problem.rank] > problem.tolerances.target) | (np.abs(values).max(axis=1) > 1e-13)
        f = np.concatenate([values, here.f.reshape(len(q), -1)], axis=1)
        return going, f, np.concatenate([slopes, here.d.reshape(len(q), -1, problem.n)], axis=1)

    starts, _ = system.solve(problem.sample(REAL_STARTS, seed))
    q = wrap_joints(chain.own, newton(equations_at, starts, scale=problem.scale, iterations=_ITERATIONS))
    return q[system.zero(q) & problem.singular(q)]


def _witness(
    chain: Chain, q: Array, system: System, followed: Callable[[Array], Array]
) -> tuple[float, ...] | None:
    """The first of a few configurations that is singular with many digits, or leads to one on the set; else the first.
    """
    if not len(q):
        return None
    chosen = q[0]
    for place in q[:_WITNESSES]:
        ends = followed(place)
        on = ends[system.zero(ends)]
        if len(on):
            chosen = on[0]
            break
    return tuple(float(x) for x in out_of_units(chain.robot, chosen))
