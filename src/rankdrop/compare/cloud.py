"""Singular configurations found with the numeric Jacobian alone, and how many of them given conditions explain.

Sets without a point modulo any of the primes, though they may be real: what is known of them all the same.

The rank tree tells sets apart at random points modulo primes. With letters for lengths a set has such points for about
every other value of them, with numbers modulo about every other prime; a few have none modulo all that are tried.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rankdrop.exact.algebra.field import PRIMES
from rankdrop.exact.algebra.zeroset import ZeroSet
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.family import ExactFamily
from rankdrop.exact.merge import alone, merge
from rankdrop.exact.reading.lint import round_points
from rankdrop.exact.tree import Tree
from rankdrop.families.searching import refine, search
from rankdrop.family.equation import Equation, normalised
from rankdrop.family.record import Check
from rankdrop.family.system import System
from rankdrop.family.which import on_one_of
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import into_units

ROUNDS = 20
"""The search for a cloud is begun anew so many times at most; less than a tenth of `count` in a round ends it."""
FURTHER = 1e-2
"""Longest way that a configuration is searched on [rad]: what moves on was not singular to begin with."""
WITHIN = 1e-3
"""Longest way from a point of a cloud to a family that is walked [rad]."""


@dataclass(frozen=True, eq=False)
class Cloud:
    """Singular configurations found numerically.

    Attributes:
        robot, task: of the arm.
        q: (N, n) configurations [rad, m].
        corank: (N,) rank lost at each.
    """

    robot: Robot
    task: Task
    q: Array
    corank: NDArray[np.int64]

    def up_to(self, corank: int) -> Cloud:
        """The configurations that lose no more than so many ranks."""
        kept = self.corank <= corank
        return Cloud(self.robot, self.task, self.q[kept], self.corank[kept])


def cloud(robot: Robot, task: Task, corank: int, count: int, seed: int = 0) -> Cloud:
    """Singular configurations of one corank and of every higher one, found from random starts.

    Args:
        robot: the arm.
        task: from `resolve_task`.
        corank: k ≥ 1.
        count: configurations of exactly this corank at least, where the search finds as many; of each higher corank
            a tenth of that is looked for.
        seed: of the starts.

    Returns:
        Cloud, polished as `search` does; empty where nothing was found, which proves nothing.

    Raises:
        OptionError: no such corank for this arm and task.
    """
    generic = generic_rank(robot, task)
    parts: list[Array] = [np.zeros((0, robot.n))]
    coranks: list[NDArray[np.int64]] = [np.zeros(0, dtype=np.int64)]
    for wanted in range(corank, generic + 1):
        enough = count if wanted == corank else max(count // 10, 1)
        found, lost = 0, 0
        for part in range(ROUNDS):
            run = search(robot, wanted, task=task, starts=enough, seed=seed + 1000 * wanted + part)
            if not run.complete:
                raise KeyboardInterrupt  # the core met Ctrl-C and handed over what it had
            kept = run.outcome == 0
            parts.append(run.converged)
            coranks.append(generic - (run.sigma[kept][:, :generic] > run.tolerances.singular).sum(axis=1))
            new = int((coranks[-1] == wanted).sum())
            found, lost = found + new, lost + int(kept.sum())
            if found >= enough or new < enough / 10:
                break
        if not lost:
            break
    return Cloud(robot, task, np.concatenate(parts), np.concatenate(coranks))


def explained(
    points: Cloud, families: Sequence[Sequence[Equation]], tolerances: Tolerances = DEFAULT
) -> tuple[Check, NDArray[np.int64]]:
    """How many points of a cloud lie on one of the families, each given by all of its equations.

    A point lies on a family when the way to its zero set, walked by Gauss–Newton, is at most `explained`; where sheets
    cross, also when σ stays zero on the whole way (`families_at`).

    Args:
        points: from `cloud`.
        families: the equations of each family, all of which hold on it; a family without equations holds everywhere.
        tolerances: `explained` and `singular`.

    Returns:
        (Check, (L,) indices of the points left over).
    """
    systems = [System(tuple(normalised(equation.terms) for equation in family)) for family in families]
    left = np.arange(len(points.q))
    for system in systems:
        way, _ = system.nearest(points.q[left], WITHIN)
        left = left[way > tolerances.explained]
        if not len(left):
            break
    crossing = [system.equations for system in systems]

    def over(indices: NDArray[np.int64], q: Array) -> NDArray[np.int64]:
        on = [on_one_of(crossing, points.robot, q[i], points.task, tolerances) for i in indices]
        return indices[[not one for one in on]]

    left = over(left, points.q)
    if len(left):
        left = over(left, _further(points, left))
    return Check(len(points.q), len(points.q) - len(left)), left


def _further(points: Cloud, indices: NDArray[np.int64]) -> Array:
    """The configurations, those of the indices searched on from where the search ended.

    Where σ has a zero of fourth order, σ of 1e-11 is met 4e-3 rad before it: too far to tell of what it is a zero.
    """
    q = points.q.copy()
    for corank in np.unique(points.corank[indices]):
        mine = indices[points.corank[indices] == corank]
        found = refine(points.robot, q[mine], int(corank), task=points.task).q
        near = np.abs(found - q[mine]).max(axis=1) <= FURTHER
        q[mine[near]] = found[near]
    return q


_POINTS = 24  # real points looked at on each
_LONG = 40  # terms of a set's conditions beyond which they tell nobody anything


def sets_without_points(
    chain: Chain, tree: Tree, families: Sequence[ExactFamily], seed: int
) -> tuple[list[str], list[str]]:
    """What the tree leaves open for want of points, and the sets on which no real point was found, in sentences.

    A set is no loss where all real points found lie on the families of a rank as low, or where the rank is not lower
    there and no smaller set inside it is looked for. That none was found is no proof that there is none.
    """
    lost: dict[str, ZeroSet] = {}
    unmet: dict[str, ZeroSet] = {}
    for piece, order, last in tree.without_points:
        theta = [point for point, _ in zip(round_points(piece, chain, seed=seed), range(_POINTS), strict=False)]
        if not theta:
            unmet[piece.key] = piece
        elif piece.key not in lost and not _settled(chain, tree, families, np.array(theta), order, last):
            lost[piece.key] = piece
    short = [piece for piece in unmet.values() if _terms(piece) <= _LONG]
    words = f"no real point was found, nor one modulo {len(PRIMES)} primes"
    told = [f"{', '.join(row.texts)}: {words}" for row in merge(short)]
    if len(unmet) > len(short):
        told.append(f"{len(unmet) - len(short)} sets with long conditions: no real point was found on them either")
    return [_sentence(list(lost.values()))] if lost else [], told


def _sentence(lost: Sequence[ZeroSet]) -> str:
    sets = "1 set of real configurations" if len(lost) == 1 else f"{len(lost)} sets of real configurations"
    shortest = min(lost, key=_terms)
    texts = ", ".join(alone(shortest).texts) if _terms(shortest) <= _LONG else ""
    where = f" ({'' if len(lost) == 1 else 'one is '}{texts})" if texts else ""
    return (
        f"{sets}{where} could not be looked into: roots of numbers that stand in the conditions exist modulo none of "
        f"the {len(PRIMES)} primes by which ranks are taken. Whether the rank drops inside is not known; "
        "--lengths letters may avoid this"
    )


def _terms(piece: ZeroSet) -> int:
    return sum(map(len, piece.equations))


def _settled(
    chain: Chain,
    tree: Tree,
    families: Sequence[ExactFamily],
    theta: Array,
    order: int,
    last: bool,
) -> bool:
    q = into_units(chain.robot, theta - chain.shifts)
    rank = (singular_values(chain.own, q, chain.own_task) > DEFAULT.singular).sum(axis=1)
    low = rank < order
    if not low.any():
        return last
    corank = tree.generic_rank - rank
    for k in sorted(set(corank[low].tolist())):
        here = q[low & (corank == k)]
        known = [family.in_units(chain).equations for family in families if family.corank >= k]
        _, over = explained(Cloud(chain.own, chain.own_task, here, np.full(len(here), k)), known)
        if len(over):
            return False
    return bool(low.all()) or last
