"""Singular configurations found with the numeric Jacobian alone, and how many of them given conditions explain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rankdrop.exact.arm.verify import Check
from rankdrop.families.searching import search
from rankdrop.family.equation import Equation, normalised
from rankdrop.family.system import System
from rankdrop.family.which import families_at
from rankdrop.local.block import generic_rank
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances

ROUNDS = 20
"""The search for a cloud is begun anew so many times at most; less than a tenth of `count` in a round ends it."""
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
    crossing = [_Given(system.equations) for system in systems]
    over = [i for i in left if not families_at(crossing, points.robot, points.q[i], points.task, tolerances)]
    return Check(len(points.q), len(points.q) - len(over)), np.array(over, dtype=np.int64)


@dataclass(frozen=True)
class _Given:
    """Equations as `families_at` reads a family; the rank lost at a point is at least 1, which is all that is asked."""

    equations: tuple[Equation, ...]
    name: str = ""
    corank: int = 1
    dimension: int = 0
