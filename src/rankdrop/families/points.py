"""Points of a family, and the way back onto the singular set.

A cloud is found by searches with the numeric Jacobian alone, and shows how much given conditions explain. Other points
are solutions of a family's equations from random starts, each one checked in the Jacobian itself.

Back onto the set leads Gauss–Newton on the block F with D as its derivative, along chosen directions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.incidence import ways_to
from rankdrop.families.record import Check, Family
from rankdrop.families.rescaling import family_in_metres, rescale_equation, slides_of
from rankdrop.families.searching import refine, search
from rankdrop.formula.equation import Equation, Mask, System, normalised_equation
from rankdrop.local.block import generic_rank
from rankdrop.problem import Problem, wrap_joints
from rankdrop.robot.model import Array, Robot
from rankdrop.solve import newton
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_metres, into_metres, metre_exponent, out_of_metres, task_in_metres

Rows = NDArray[np.int64]
EDGE = 1e-9  # a slide this far beyond its travel stands at its end [m]

ITERATIONS = 30
STEP = 0.3  # longest step [rad; slides in length scales]

MOST_STARTS = 200_000

ROUNDS = 20
"""The search for a cloud is begun anew so many times at most; less than a tenth of `count` in a round ends it."""
FURTHER = 1e-2
"""Longest way that a configuration is searched on [rad]: what moves on was not singular to begin with."""


def members(
    robot: Robot, task: Task, family: Family, count: int, seed: int, *, tolerances: Tolerances = DEFAULT
) -> Array:
    """Random configurations of one family.

    Args:
        robot, task: the arm.
        family: of this arm and task.
        count: random starts; a start that leads nowhere is left out.
        seed: of the starts.
        tolerances: `singular` decides whether a point counts.

    Returns:
        (≤ count, n) turning joints in (−π, π], slides within their travel [rad, m]; none where the family has no
        equations.
    """
    if not family.named or not family.equations:
        return np.empty((0, robot.n))
    problem = Problem(in_metres(robot), task_in_metres(task, robot), family.corank, tolerances)
    q = _solve_from_starts(problem, family_in_metres(family, robot), problem.sample(count, seed))
    return out_of_metres(robot, q)


def _solve_from_starts(problem: Problem, family: Family, starts: Array, along: Array | None = None) -> Array:
    """(≤ N, n) points of a family that starts (N, n) lead to, moved along some directions: singular, within travel."""
    points, solved = family.system.solve(starts, along=along)
    points = wrap_joints(problem.robot, points[solved])
    return points[problem.singular(points) & within_travel(problem, family, points)]


def general_member(
    robot: Robot, task: Task, family: Family, moving: Sequence[int], seed: int, others: Sequence[Family] = ()
) -> Array:
    """A point of the family far from more special ones: the smallest σ that is kept, and what the equations of the
    other families leave, are large there.

    Joints that the family leaves free take simple values (multiples of 0.1), but for those that are to be moved.

    Args:
        moving: joints from 0 that a slice will move.
        seed: of the starts.
        others: further families of the arm.

    Returns:
        (n,) [rad, m]; the witness where no other point is found.
    """
    if not family.named or not family.equations:
        return np.array(family.witness)
    problem = Problem(in_metres(robot), task_in_metres(task, robot), family.corank)
    own = family_in_metres(family, robot)
    held = {pin.number - 1 for pin in own.pinned}
    bound = held | {number - 1 for number in own.coupled}
    along = np.eye(robot.n)[:, sorted(held | (set(moving) & bound or bound))]
    points = _solve_from_starts(problem, own, np.round(problem.sample(256, seed), 1), along)
    if not len(points):
        return np.array(family.witness)
    if problem.rank:
        room = problem.sigma(points)[:, problem.rank - 1]
    else:
        room = np.ones(len(points))
    for other in others:
        if other.id != family.id and other.equations:
            values = family_in_metres(other, robot).system.values(points)
            room = np.minimum(room, np.abs(values).max(axis=1))
    return out_of_metres(robot, points[int(room.argmax())])


def set_joints(q: Array, moving: Sequence[int], points: Array) -> Array:
    """(N, n) a configuration with some joints (from 0) at each of points (N, d)."""
    full = np.repeat(q[None], len(points), axis=0)
    full[:, list(moving)] = points
    return full


def within_travel(problem: Problem, family: Family, q: Array) -> Mask:
    """(N,) whether every joint that does not go round is inside the box that samples come from.

    A slide that the family pins beyond its travel (Stanford arm: at 0) is let go there, or nothing would be seen.
    """
    low, high = (np.array(end) for end in problem.box)
    for pinned in family.pinned:
        j = pinned.number - 1
        low[j], high[j] = min(low[j], *pinned.values), max(high[j], *pinned.values)
    inside = (q >= low - EDGE) & (q <= high + EDGE)
    return np.asarray((inside | problem.robot.periodic).all(axis=1))


def near_family(
    family: Family, q: Array, within: float, scale: Array, turns: Mask, walk: Callable[[Rows, Array, Array], Mask]
) -> Mask:
    """Which configurations lie within a distance of a family.

    Args:
        family: with equations.
        q: (N, n).
        within: the distance [rad; slides divided by the length scale].
        scale: (n,) unit of motion of each joint.
        turns: (n,) joints whose differences are taken the short way round.
        walk: (R,) which of the configurations it is told, by (R,) their rows and (R, n) with pinned joints put where
            they belong, are within (R,) distances of a zero of the equations of coupled joints.
    """
    numbers = [pin.number - 1 for pin in family.pinned]
    turn = 2 * np.pi * turns[numbers]
    near = np.zeros(len(q), dtype=np.bool_)
    for values in product(*(pin.values for pin in family.pinned)):
        gap = q[:, numbers] - np.array(values)
        gap -= turn * np.round(gap / np.where(turn > 0.0, turn, 1.0))
        room = within**2 - ((gap / scale[numbers]) ** 2).sum(axis=1)
        rows = np.flatnonzero((room >= 0.0) & ~near)
        if not family.coupled:
            near[rows] = True
        elif len(rows):
            at = q[rows]
            at[:, numbers] -= gap[rows]
            near[rows] = walk(rows, at, np.sqrt(room[rows]))
    return near


def move_to_singularity(problem: Problem, starts: Array, along: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Move configurations within q + span(along) until the rank is at most that of the problem.

    Each step is the shortest least-squares solution of D(Δ) = −F with Δ in the span, measured in scaled joint
    coordinates. A start near which the span does not meet the set does not arrive, and says so.

    Args:
        problem: the arm and the corank; `singular` decides what has arrived, `target` where a start stops.
        starts: (N, n) configurations [rad, m].
        along: (n, d) orthonormal directions in scaled joint coordinates (`Problem.scale`).

    Returns:
        (N, n) end points and (N,) whether σ beyond the rank is zero there.

    Raises:
        ConfigurationError: starts have the wrong shape.
        OptionError: there is no block beyond that rank.
    """
    def block_residual(q: Array) -> tuple[Mask, Array, Array]:
        here = problem.block(q)
        going = here.sigma[:, problem.rank] > problem.tolerances.target
        return going, here.f.reshape(len(q), -1), here.d.reshape(len(q), -1, problem.n)

    q = newton(block_residual, starts, scale=problem.scale[:, None] * along, iterations=ITERATIONS, step=STEP)
    return q, problem.singular(q)


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
        if wanted == corank:
            enough = count
        else:
            enough = max(count // 10, 1)
        distinct, lost = 0, 0
        for part in range(ROUNDS):
            run = search(robot, wanted, task=task, starts=enough, seed=seed + 1000 * wanted + part)
            if not run.complete:
                raise KeyboardInterrupt  # the core met Ctrl-C and handed over what it had
            arrived = run.outcome == 0
            parts.append(run.converged)
            coranks.append(generic - (run.sigma[arrived][:, :generic] > run.tolerances.singular).sum(axis=1))
            new = int((coranks[-1] == wanted).sum())
            distinct, lost = distinct + new, lost + int(arrived.sum())
            if distinct >= enough or new < enough / 10:
                break
        if not lost:
            break
    return Cloud(robot, task, np.concatenate(parts), np.concatenate(coranks))


def count_explained(
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
    robot = points.robot
    problem = Problem(in_metres(robot), task_in_metres(points.task, robot), 1, tolerances)
    power, slides = -metre_exponent(robot), slides_of(robot)
    systems = []
    for family in families:
        equations = (rescale_equation(equation, slides, power) for equation in family)
        systems.append(System(tuple(normalised_equation(equation.terms) for equation in equations)))
    remaining = np.arange(len(points.q))
    for further in (False, True):
        q = into_metres(robot, _further(points, remaining) if further else points.q)
        for system in systems:
            remaining = remaining[np.isinf(ways_to(problem, system, q[remaining])) | ~problem.singular(q[remaining])]
    return Check(len(points.q), len(points.q) - len(remaining)), remaining


def _further(points: Cloud, indices: NDArray[np.int64]) -> Array:
    """The configurations, those of the indices searched on from where the search ended.

    Where σ has a zero of fourth order, σ of 1e-11 is met 4e-3 rad before it: too far to tell of what it is a zero.
    """
    q = points.q.copy()
    for corank in np.unique(points.corank[indices]):
        mine = indices[points.corank[indices] == corank]
        solved = refine(points.robot, q[mine], int(corank), task=points.task).q
        near = np.abs(solved - q[mine]).max(axis=1) <= FURTHER
        q[mine[near]] = solved[near]
    return q
