"""Singular configurations found with the numeric Jacobian alone, and how many of them given conditions explain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.searching import refine, search
from rankdrop.family.equation import Equation, System, normalised
from rankdrop.family.record import Check
from rankdrop.family.which import on_one_of
from rankdrop.local.block import generic_rank
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances

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
