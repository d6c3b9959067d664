"""Ways out of a witness, as the buttons of the page."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.family import Family
from rankdrop.local import Direction, escape, generic_rank
from rankdrop.results import motion, short
from rankdrop.robot import Array, Robot
from rankdrop.task import Task

_SINGLE = 3  # joints alone that are offered, the best first


@dataclass(frozen=True, slots=True)
class Way:
    """One motion that restores the full rank.

    Attributes:
        label: what is pressed: "joint 5 +5.7°".
        after: what it gives: "σ6 = 0.017".
        q: (n,) where it leads [rad, m].
    """

    label: str
    after: str
    q: tuple[float, ...]


def ways_out(robot: Robot, task: Task, family: Family) -> tuple[Way, ...]:
    """The best direction and the best joints alone that lead out of the witness inside the limits; () for none.

    Where the witness itself is outside the limits no motion counts as inside, and there are none.
    """
    q = np.array(family.witness)
    found = escape(robot, q, task)
    rank = f"σ{generic_rank(robot, task)}"
    ways = []
    for one in found.single:
        if one.order is None or not one.within_limits or one.step == 0 or one.sigma_after <= found.floor:
            continue
        target = q.copy()
        target[one.number - 1] += one.step
        told = f"joint {one.number} {motion(one.step, robot.variables[one.number - 1].unit)}"
        ways.append(Way(told, f"{rank} = {short(one.sigma_after, 2)}", tuple(target.tolist())))
    return (*_direction(q, found.best_direction, rank), *ways[:_SINGLE])


def _direction(q: Array, direction: Direction, rank: str) -> tuple[Way, ...]:
    if direction.step == 0 or not direction.restores or not direction.within_limits:
        return ()
    target = q + direction.step * np.array(direction.delta)
    return (Way("best direction", f"{rank} = {short(direction.sigma_after, 2)}", tuple(target.tolist())),)
