"""What the monitor sees along a joint trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rankdrop.families import Monitor
from rankdrop.motion import Trajectory
from rankdrop.robot import Array

PLOTTED = 600
"""Points of a plot: more than a panel has pixels."""


@dataclass(frozen=True, eq=False)
class Track:
    """What the monitor sees along a trajectory.

    Attributes:
        times: (T,) [s].
        sigma: (T,) σ_r [1].
        shown: (P,) rows to plot: at most about `PLOTTED`, and of every part the one with the smallest σ, as a dip of
            one row between two that are plotted would be lost otherwise.
        distance: (P,) distance to the singular set at these rows, as `Monitor.distances` measures it [rad].
        worst: index of the row with the smallest σ_r.
        singular: number of rows that are singular.
    """

    times: Array
    sigma: Array
    shown: NDArray[np.intp]
    distance: Array
    worst: int
    singular: int


def track_of(trajectory: Trajectory, monitor: Monitor) -> Track:
    """σ at every row, and distances at those that are shown: they take a millisecond or more."""
    seen = monitor.look(trajectory.q)
    r = monitor.generic_rank
    sigma = seen.sigma[:, r - 1] if r else np.zeros(len(trajectory.q))
    shown = thinned(sigma)
    far = monitor.distances(trajectory.q[shown], along=True).nearest()[1]
    return Track(trajectory.times, sigma, shown, far, int(sigma.argmin()), int((seen.corank > 0).sum()))


def thinned(sigma: Array, count: int = PLOTTED) -> NDArray[np.intp]:
    """(P,) indices of rows to plot of those with σ (T,); see `Track.shown`."""
    total = len(sigma)
    if total <= count:
        return np.arange(total)
    edges = np.linspace(0, total, count // 2 + 1).astype(int)
    keep = {0, total - 1}
    for low, high in pairwise(edges.tolist()):
        keep |= {low, low + int(sigma[low:high].argmin())}
    return np.array(sorted(keep), dtype=np.intp)
