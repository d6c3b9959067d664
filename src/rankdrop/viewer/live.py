"""What is known of a configuration the moment it is reached: fast enough for every movement of a slider."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.families import Monitor, Sighting
from rankdrop.family import Family
from rankdrop.kinematics import link_poses
from rankdrop.local import LARGEST_CHAIN, Circuit, blame, lost_directions
from rankdrop.results import first_verdict
from rankdrop.robot import Array, Robot
from rankdrop.task import Task
from rankdrop.viewer.scene import Arrow, arrows, body_of


@dataclass(frozen=True, eq=False)
class Now:
    """One configuration as it is drawn.

    Attributes:
        q: (n,) [rad, m].
        verdict: "regular", "near", "singular", "always-singular" by the distance.
        seen: what the monitor says: σ, corank, family, residual.
        family: the one q lies on; None at a regular configuration, or where no known one holds.
        nearest: the known one that is nearest; None where another singular configuration is, or none was reached.
        distance: to it, or to that configuration, as `Monitor.distances` measures it [rad]; inf where none was reached.
        at_least: no singular configuration is nearer than this: proven [rad].
        links: (N + 2, 4, 4) from `link_poses`.
        lost: (k, 6) lost directions in the task's frame; at a configuration that is not singular the weakest one.
        arrows: they as arrows, one each.
        blamed: circuits to blame; empty where the configuration is not singular.
        outside: joints (from 1) beyond a limit.
    """

    q: Array
    verdict: str
    seen: Sighting
    family: Family | None
    nearest: Family | None
    distance: float
    at_least: float
    links: Array
    lost: Array
    arrows: tuple[Arrow, ...]
    blamed: tuple[Circuit, ...]
    outside: tuple[int, ...]

    @property
    def sigma(self) -> Array:
        """(min(m, n),) singular values, descending."""
        return self.seen.sigma


class Live:
    """One arm and task under watch.

    Args:
        robot, task: the arm.
        families: known ones; those that have no equations are never named.
    """

    def __init__(self, robot: Robot, task: Task, families: tuple[Family, ...]) -> None:
        self.robot, self.task, self.families = robot, task, families
        self.monitor = Monitor(robot, task, families)
        self.generic_rank = self.monitor.generic_rank
        self.body = body_of(robot)
        self._lower, self._upper = robot.lower - 1e-9, robot.upper + 1e-9

    def look(self, q: Array) -> Now:
        """Everything that is cheap, at one configuration (n,) [rad, m]."""
        q = np.array(q, dtype=np.float64)
        seen = self.monitor.look_one(q)
        far = self.monitor.distances(q[None])
        nearest, distance = (one[0] for one in far.nearest())
        links = link_poses(self.robot, q)
        r = self.generic_rank
        lost = lost_directions(self.robot, q, self.task, max(1, seen.corank)) if r else np.zeros((0, 6))
        blamed: tuple[Circuit, ...] = ()
        if seen.corank and self.robot.n <= LARGEST_CHAIN:
            blamed = blame(self.robot, q, self.task)
        sigma = float(seen.sigma[r - 1]) if r else 0.0
        return Now(
            q=q,
            verdict=first_verdict(seen.corank, r, min(self.task.m, self.robot.n), sigma, float(distance)),
            seen=seen,
            family=self.families[seen.family] if seen.family >= 0 else None,
            nearest=self.families[nearest] if nearest >= 0 else None,
            distance=float(distance),
            at_least=float(far.at_least[0]),
            links=links,
            lost=lost,
            arrows=arrows(lost, links, self.task, self.body.size),
            blamed=blamed,
            outside=tuple(int(i) + 1 for i in np.flatnonzero((q < self._lower) | (q > self._upper))),
        )
