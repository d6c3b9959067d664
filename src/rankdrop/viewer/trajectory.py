"""What the monitor sees along a joint trajectory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.families import Monitor
from rankdrop.motion import Trajectory
from rankdrop.robot import Array


@dataclass(frozen=True, eq=False)
class Track:
    """What the monitor sees along a trajectory.

    Attributes:
        times: (T,) [s].
        sigma: (T,) σ_r [1].
        distance: (T,) first-order distance to the singular set [rad].
        worst: index of the row with the smallest σ_r.
        singular: number of rows that are singular.
    """

    times: Array
    sigma: Array
    distance: Array
    worst: int
    singular: int


def track_of(trajectory: Trajectory, monitor: Monitor) -> Track:
    """σ and distance at every row."""
    seen = monitor.look(trajectory.q)
    r = monitor.generic_rank
    sigma = seen.sigma[:, r - 1] if r else np.zeros(len(trajectory.q))
    return Track(trajectory.times, sigma, seen.distance, int(sigma.argmin()), int((seen.corank > 0).sum()))
