"""A joint path that dips to a singularity, and its remedies."""

from __future__ import annotations

from functools import cache

import numpy as np

import rankdrop
from rankdrop.path.mend.mend import mend_path
from rankdrop.path.mend.record import Mending
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot

MIDDLE = {"irb120": (0, -40, 20, 20, 30, 10), "ur5e": (0, -80, 90, -60, 30, 0), "puma560": (0, -40, 40, 20, 30, 10)}
DEPTH, LASTS = 1.3, 0.65  # of the wrist [°], and how long it stays there [s]


def smooth(x: Array) -> Array:
    """From 0 to 1 with two continuous derivatives."""
    x = np.clip(x, 0.0, 1.0)
    return np.asarray(x**3 * (10 - 15 * x + 6 * x * x))


def dipping(name: str, rows: int, to: float = -DEPTH, dips: int = 1) -> tuple[Array, Array]:
    """A program whose wrist goes to an angle [°] for 0.65 s and comes back, at times evenly spread."""
    t = np.arange(rows) * 0.01
    slow = np.sin(np.pi * t / t[-1])[:, None] ** 2 * np.array([10, 4, 4, 8, 4, 6])
    degrees = np.array(MIDDLE[name], dtype=np.float64) + slow
    for k in range(dips):
        off = np.abs(t - t[-1] * (k + 0.5) / dips) - LASTS / 2
        share = smooth(1.0 - off / 1.5)
        degrees[:, 4] += share * (to - degrees[:, 4])
    return np.radians(degrees), t


@cache
def mended(name: str, rows: int = 1000, dips: int = 1) -> tuple[Array, Mending]:
    """The rows of a program, and its bumps."""
    q, t = dipping(name, rows, dips=dips)
    return q, mend_path(rankdrop.check_path(open_robot(name), q, t), kinds=("bump",))
