"""The posture in which a family is drawn: upright where the family has such a member, inside the limits.

`posed` chooses a witness that nothing speaks against. In a picture that is not enough: an arm that
lies along the floor is a thin line in a wide frame. Of the members near round configurations the one is drawn that
stands up, and is no worse in `fault`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rankdrop.families.naming import lost_motions
from rankdrop.families.record import Family, family_in_metres
from rankdrop.families.table import posed
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.local.posture import candidates, fault, spine, start_posture
from rankdrop.problem import Problem, into_limits, wrapped
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.numbers import reach
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT
from rankdrop.units import in_metres, into_metres, out_of_metres, task_in_metres

VIEW = -0.9
"""Azimuth from which pictures are seen [rad]."""
TALL = 0.55
"""Height of the highest point of an arm over its base from which it counts as upright [reach]."""
_WIDE = 0.4  # seen narrower than this, an arm points at the reader [reach]
_ACROSS = np.array([-np.sin(VIEW), np.cos(VIEW), 0.0])
_CANDIDATES = 256
_POINTS = 24  # members from which the frame of the words is chosen
_ROOM = 1e-3  # the singular value that is kept is at least this [1]: not on a more special family
_SHARED = 1.0  # added for a member that lies on another family too: it is an example of both
_SLACK = 0.15  # of `fault` that a taller posture may cost


def height(robot: Robot, q: Array) -> Array:
    """(N,) height of the highest point of the links over the base at configurations (N, n) [reach]."""
    return np.asarray(spine(robot, np.asarray(q))[:, :, 2].max(axis=1) / max(reach(robot), 1e-9))


def upright(robot: Robot, task: Task, family: Family, others: Sequence[Family] = ()) -> Family:
    """The family as `posed` gives it, with its witness upright where a member is, not worse in any other way.

    Args:
        robot, task: the arm.
        family: of this arm and task.
        others: all families of the arm; a member that lies on another one of the same corank is no example.

    Returns:
        The family with its witness and the directions lost there.
    """
    family = posed(robot, task, family, others)
    here = in_metres(robot)
    own = into_metres(robot, family.witness)[None]
    if _poor(here, own)[0] == 0.0 or not family.named or not family.equations:
        return family
    problem = Problem(here, task_in_metres(task, robot), family.corank)
    found = _members(problem, family_in_metres(family, robot))
    rest = [one for one in others if one.id != family.id and one.corank == family.corank and one.equations]
    systems = [family_in_metres(one, robot).system for one in rest]

    def against(q: Array) -> Array:
        on = [(np.abs(one.values(q)) <= DEFAULT.explained).all(axis=1) for one in systems]
        return np.asarray(fault(here, q) + _SHARED * np.any(np.stack([np.zeros(len(q), bool), *on]), axis=0))

    if not len(found):
        return family
    gap = problem.sigma(found)[:, problem.rank - 1] if problem.rank else np.ones(len(found))
    worse = against(found) > against(own)[0] + _SLACK
    kept = (gap > _ROOM) & ~worse & (_poor(here, found) < _poor(here, own)[0] - 0.05)
    found, gap = found[kept], gap[kept]
    if not len(found):
        return family
    turned = np.where(here.periodic, np.abs(found) / np.pi, 0.0).sum(axis=1)
    cost = _poor(here, found) + against(found) - 0.3 * gap / gap.max() + 0.1 * turned
    best = found[int(cost.argmin())]
    directions, lost = lost_motions(problem, best, found[:_POINTS])
    witness = tuple(float(x) for x in out_of_metres(robot, best))
    return replace(family, witness=witness, lost_directions=directions, lost_freedoms=lost)


def upright_start(robot: Robot, task: Task) -> Array:
    """(n,) where pictures begin: like `rankdrop.local.start_posture`, and upright where that costs nothing [rad, m]."""
    usual = start_posture(robot, task)
    if _poor(robot, usual[None])[0] == 0.0:
        return usual
    q = np.vstack([usual, candidates(robot, task, 2 * _CANDIDATES, 0)])
    rank = generic_rank(robot, task)
    sigma = singular_values(robot, q, task)[:, rank - 1] if rank else np.ones(len(q))
    turned = np.where(robot.periodic, np.abs(q) / np.pi, 0.0).mean(axis=1)
    cost = 2.0 * fault(robot, q) + _poor(robot, q) - sigma / max(float(sigma.max()), 1e-12) + 0.8 * turned
    return np.asarray(q[int(cost.argmin())])


def _poor(robot: Robot, q: Array) -> Array:
    """(N,) 0 … 2.6: how much of its height, and of its width as the reader sees it, an arm lacks at q (N, n)."""
    across = spine(robot, q) @ _ACROSS / max(reach(robot), 1e-9)
    lying = np.clip(TALL - height(robot, q), 0.0, None) / TALL
    thin = np.clip(_WIDE - np.ptp(across, axis=1), 0.0, None) / _WIDE
    return np.asarray(2.0 * lying + 0.6 * thin)


def _members(problem: Problem, family: Family) -> Array:
    """(≤ 256, n) members near round configurations, free joints exactly at these, inside the limits."""
    bound = {number - 1 for number in (*family.coupled, *(one.number for one in family.pinned))}
    starts = candidates(problem.robot, problem.task, _CANDIDATES, 0)
    points, solved = family.system.solve(starts, along=np.eye(problem.n)[:, sorted(bound)])
    points = wrapped(problem.robot, points[solved])
    return into_limits(problem.robot, points[problem.singular(points)])
