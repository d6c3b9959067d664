"""The posture in which a family is shown: one of its members that people would choose, see `rankdrop.local.fault`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rankdrop.family.naming import lost_motions
from rankdrop.family.record import Family, family_from_metres, family_in_metres
from rankdrop.family.system import System
from rankdrop.local.posture import candidates, fault
from rankdrop.problem import Problem, into_limits, wrapped
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT
from rankdrop.units import in_metres, metre_exponent, task_in_metres

_CANDIDATES = 256
_WORTH = 0.15  # the witness stays unless another member is better by this much of `fault`
_POINTS = 24  # members from which the frame of the words is chosen
_ROOM = 1e-3  # the singular value that is kept is at least this [1]: not on a more special family
_SHARED = 1.0  # added to `fault` of a member that lies on another family too: it is an example of both


def posed(robot: Robot, task: Task, family: Family, others: Sequence[Family] = ()) -> Family:
    """The family with its witness in a good posture: inside the limits, above the base, not self-folded.

    The equations are solved from round configurations inside the limits; of the members found, each checked in the
    Jacobian itself (σ ≤ 1e-9, of exactly the corank), the one with the least `fault` becomes the witness. Lost
    directions and their words are told there anew. Everything else stays, and so does the witness where no member is
    clearly better, or where the family has no equations.

    Args:
        robot, task: the arm.
        family: of this arm and task.
        others: all families of the arm; a member that lies on none of these of the same corank is preferred.

    Example:
        >>> from rankdrop.results.known import shipped
        >>> from rankdrop.local import fault
        >>> found = shipped("ur5")
        >>> before = found.families[0]
        >>> after = posed(found.robot, found.task, before)
        >>> bool(fault(found.robot, [after.witness])[0] <= fault(found.robot, [before.witness])[0])
        True
    """
    own = np.array(family.witness)
    if metre_exponent(robot):
        there = posed(
            in_metres(robot), task_in_metres(task, robot), family_in_metres(family, robot),
            [family_in_metres(one, robot) for one in others],
        )  # fmt: skip
        moved = family_from_metres(there, robot, metre_exponent(robot))
        return replace(moved, lost_words=there.lost_words)  # which are told in the arm's own unit already
    beside = [one.system for one in others if one.id != family.id and one.corank == family.corank and one.equations]
    least = fault(robot, own[None])[0] + _SHARED * _shared(beside, own[None])[0] - _WORTH
    found = _members(robot, task, family) if least >= 0.0 else np.empty((0, robot.n))
    if not len(found):
        return family
    problem = Problem(robot, task, family.corank)
    gap = problem.sigma(found)[:, problem.rank - 1] if problem.rank else np.ones(len(found))
    found, gap = found[gap > _ROOM], gap[gap > _ROOM]
    if not len(found):
        return family
    faults = fault(robot, found) + _SHARED * _shared(beside, found)
    best = int((faults - 0.3 * gap / gap.max() + 0.1 * _turned(robot, found)).argmin())
    if faults[best] > least:
        return family
    directions, words = lost_motions(problem, found[best], found[:_POINTS])
    return replace(family, witness=tuple(float(x) for x in found[best]), lost_directions=directions, lost_words=words)


def _shared(systems: Sequence[System], q: Array) -> Array:
    """(N,) 1 where a configuration solves one of the systems, else 0."""
    on = np.zeros(len(q))
    for system in systems:
        on[(np.abs(system.values(q)) <= DEFAULT.explained).all(axis=1)] = 1.0
    return on


def _members(robot: Robot, task: Task, family: Family) -> Array:
    """(≤ 256, n) members near round configurations, free joints exactly at these, turned into the limits."""
    if not family.named or not family.equations:
        return np.empty((0, robot.n))
    bound = [number - 1 for number in (*family.coupled, *(one.number for one in family.pinned))]
    starts = candidates(robot, task, _CANDIDATES, 0)
    points, solved = family.system.solve(starts, along=np.eye(robot.n)[:, sorted(set(bound))])
    points = wrapped(robot, points[solved])
    return into_limits(robot, points[Problem(robot, task, family.corank).singular(points)])


def _turned(robot: Robot, q: Array) -> Array:
    """(N,) how far from zero the turning joints stand, as a share of half a turn, the first one twice."""
    away = np.where(robot.periodic, np.abs(q) / np.pi, 0.0)
    return np.asarray(away.sum(axis=1) + away[:, 0])
