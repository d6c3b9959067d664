"""Points of a family: its equations solved from random starts, each one checked in the Jacobian itself."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rankdrop.family.record import Family, family_in_metres
from rankdrop.family.system import Mask, System
from rankdrop.problem import Problem, wrapped
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_metres, metre_exponent, out_of_metres, task_in_metres

EDGE = 1e-9  # a slide this far beyond its travel stands at its end [m]


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
    if metre_exponent(robot):
        there, own = in_metres(robot), family_in_metres(family, robot)
        found = members(there, task_in_metres(task, robot), own, count, seed, tolerances=tolerances)
        return out_of_metres(robot, found)
    problem = Problem(robot, task, family.corank, tolerances)
    points, solved = System(family.equations).solve(problem.sample(count, seed))
    points = wrapped(robot, points[solved])
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
    if metre_exponent(robot):
        there, own = in_metres(robot), family_in_metres(family, robot)
        rest = [family_in_metres(other, robot) for other in others]
        return out_of_metres(robot, general_member(there, task_in_metres(task, robot), own, moving, seed, rest))
    problem = Problem(robot, task, family.corank)
    starts = np.round(problem.sample(256, seed), 1)
    bound = [number - 1 for number in (*family.coupled, *(one.number for one in family.pinned))]
    tied = sorted(set(moving) & set(bound)) or bound
    held = [number - 1 for number in (one.number for one in family.pinned)]
    along = np.eye(robot.n)[:, sorted({*tied, *held})]
    points, solved = System(family.equations).solve(starts, along=along)
    points = wrapped(robot, points[solved])
    points = points[problem.singular(points) & within_travel(problem, family, points)]
    if not len(points):
        return np.array(family.witness)
    room = problem.sigma(points)[:, problem.rank - 1] if problem.rank else np.ones(len(points))
    for other in others:
        if other.id != family.id and other.equations:
            room = np.minimum(room, np.abs(System(other.equations).values(points)).max(axis=1))
    return np.asarray(points[int(room.argmax())])


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
