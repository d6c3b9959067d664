"""Points of a family: its equations solved from random starts, each one checked in the Jacobian itself."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rankdrop.families.linear import wrap
from rankdrop.family.record import Family, family_in_metres
from rankdrop.family.system import Mask, System
from rankdrop.local.block import generic_rank, sample, sampling_box, singular_values
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
    points, solved = System(family.equations).solve(sample(robot, task, count, seed))
    points = wrapped(robot, points[solved])
    return points[lies(robot, task, points, family.corank, tolerances) & within_travel(robot, task, family, points)]


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
    starts = np.round(sample(robot, task, 256, seed), 1)
    bound = [number - 1 for number in (*family.coupled, *(one.number for one in family.pinned))]
    tied = sorted(set(moving) & set(bound)) or bound
    held = [number - 1 for number in (one.number for one in family.pinned)]
    along = np.eye(robot.n)[:, sorted({*tied, *held})]
    points, solved = System(family.equations).solve(starts, along=along)
    points = wrapped(robot, points[solved])
    points = points[lies(robot, task, points, family.corank) & within_travel(robot, task, family, points)]
    if not len(points):
        return np.array(family.witness)
    kept = generic_rank(robot, task) - family.corank
    room = singular_values(robot, points, task)[:, kept - 1] if kept else np.ones(len(points))
    for other in others:
        if other.id != family.id and other.equations:
            room = np.minimum(room, np.abs(System(other.equations).values(points)).max(axis=1))
    return np.asarray(points[int(room.argmax())])


def lies(robot: Robot, task: Task, q: Array, corank: int, tolerances: Tolerances = DEFAULT) -> Mask:
    """(N,) whether the Jacobian at q (N, n) has lost `corank` of its generic rank: σ ≤ `singular`."""
    if not len(q):
        return np.zeros(0, dtype=np.bool_)
    rank = generic_rank(robot, task) - corank
    return np.asarray(singular_values(robot, q, task)[:, rank] <= tolerances.singular)


def wrapped(robot: Robot, q: Array) -> Array:
    """Turning joints in (−π, π]."""
    return np.asarray(np.where(robot.periodic, wrap(q), q))


def within_travel(robot: Robot, task: Task, family: Family, q: Array) -> Mask:
    """(N,) whether every joint that does not go round is inside the box that samples come from.

    A slide that the family pins beyond its travel (Stanford arm: at 0) is let go there, or nothing would be seen.
    """
    low, high = (np.array(end) for end in sampling_box(robot, task, limits=False))
    for pinned in family.pinned:
        j = pinned.number - 1
        low[j], high[j] = min(low[j], *pinned.values), max(high[j], *pinned.values)
    inside = (q >= low - EDGE) & (q <= high + EDGE)
    return np.asarray((inside | robot.periodic).all(axis=1))
