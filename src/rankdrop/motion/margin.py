"""Is every point of a path at least so far from every singular configuration? Proven by balls that cover the path.

A piece of the path lies within ρ of its middle; a ball of radius d + ρ around the middle that is proven free keeps the
distance d on all of the piece. One enclosure is tried first, branch and bound on short pieces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rankdrop.certify.ball import LARGEST, certified_radius
from rankdrop.certify.setting import Setting, enclose
from rankdrop.motion.bound import ROUNDED
from rankdrop.motion.curve import Curve, boxes, halves
from rankdrop.motion.prove import box_tree
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task

_BALL = 20_000  # enclosures of branch and bound for one ball
_SHORT = 0.5  # pieces with ρ below this share of the distance get branch and bound
_SHORTEST = 0.05  # … and below this are given up
_OUTRIGHT = 1e-9  # of a radius: what bisection leaves open


@dataclass(frozen=True, slots=True)
class Margin:
    """What is proven of a distance.

    Attributes:
        proven: the distance is kept everywhere.
        open: stretch where it could not be proven; −1 where it is.
        evaluations: enclosures spent.
    """

    proven: bool
    open: int
    evaluations: int


def margin(robot: Robot, task: Task, setting: Setting, path: Curve, distance: float, evaluations: int) -> Margin:
    """Try to prove that no singular configuration is nearer to the path than a distance.

    Args:
        robot, task: the arm and its task.
        setting: that the path was proven free from.
        path: the curve.
        distance: d > 0 [rad; slides divided by the length scale]; beyond π it is not tried.
        evaluations: enclosures to be spent at most.
    """
    if distance >= LARGEST:
        return Margin(False, 0, 0)
    spent = 0
    tree = box_tree(path)
    nodes = np.zeros(1, dtype=np.int64)
    for level in range(len(tree) - 1, -1, -1):
        low, high = tree[level]
        centre, rho = _ball(low[nodes], high[nodes], setting)
        spent += len(nodes)
        nodes = nodes[~_kept(robot, setting, centre, rho, distance)]
        if level:
            nodes = np.stack([2 * nodes, 2 * nodes + 1], axis=1).reshape(-1)
            nodes = nodes[nodes < len(tree[level - 1][0])]
    control, stretch = path.control[nodes], nodes
    while len(control):
        centre, rho = _ball(*boxes(control), setting)
        spent += len(control)
        if spent > evaluations:
            return Margin(False, int(stretch[0]), spent)
        kept = _kept(robot, setting, centre, rho, distance)
        for i in np.flatnonzero(~kept & (rho < _SHORT * distance)):
            ball = certified_radius(robot, centre[i], task, at_most=_radius(distance, rho[i]), evaluations=_BALL)
            spent += ball.evaluations
            kept[i] = ball.radius == ball.at_most
            if spent > evaluations or (not kept[i] and rho[i] < _SHORTEST * distance):
                return Margin(False, int(stretch[i]), spent)
        control, stretch = halves(control[~kept]), np.repeat(stretch[~kept], 2)
    return Margin(True, -1, spent)


def _ball(low: Array, high: Array, setting: Setting) -> tuple[Array, Array]:
    """Middles of boxes, and how far their corners are [rad; slides scaled]."""
    centre = np.ascontiguousarray((low + high) / 2)
    half = ((high - low) / 2 + ROUNDED * (setting.scale + np.abs(centre))) / setting.scale
    return centre, np.linalg.norm(half[:, setting.matters], axis=1)


def _radius(distance: float, rho: float) -> float:
    return min((distance + float(rho)) * (1 + _OUTRIGHT), LARGEST)


def _kept(robot: Robot, setting: Setting, centre: Array, rho: Array, distance: float) -> NDArray[np.bool_]:
    kept = np.zeros(len(centre), dtype=np.bool_)
    tried = np.flatnonzero(distance + rho < LARGEST)
    if len(tried):
        radius = enclose(robot, setting, np.ascontiguousarray(centre[tried]), radius=LARGEST)[1]
        kept[tried] = radius * (1 - _OUTRIGHT) >= distance + rho[tried]
    return kept
