"""Joint paths of a redundant arm, planned over the whole of its self-motions for a tool path.

At every place of the tool's path the configurations that reach it are one or more curves (surfaces, with two joints to
spare). From the configurations that can be begun at, layers of them are made place by place,

    q′ = the solution of the pose k + 1 that Newton's method comes to from q + δ·w,   δ ∈ {−h, 0, h}, w a null motion,

so that every layer holds, a spacing apart, what can be reached from the start without leaving the tool path; dynamic
programming over them finds the joint path with the least

    ∑ ‖Δq‖²/(h·room²),   room = σ_r/‖∇σ_r‖,

short in the metric in which singular configurations are far away. It is global where following a gradient is not: a
singular set of codimension two is passed on either side, whatever the slope says at the start. What no layer reaches at
this spacing may be there all the same.

Source: dynamic programming over path parameter and redundancy is by Pashkevich, Dolgui and Chumakov, Int. J. Computer
Integrated Manufacturing 17 (2004), and Ferrentino and Chiacchio, J. Mechanisms Robotics 12 (2020).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rankdrop import _core
from rankdrop.path.check.tool_branch import Followed
from rankdrop.path.curve import Index
from rankdrop.path.mend.joint_tool_path import JointToolPath, Run
from rankdrop.poses.inverse import Aim
from rankdrop.robot.model import Array

Layer = tuple[Array, Array, Index]
"""Configurations (M, n) at one place, what they cost from the start, and which of the layer before each is from."""

_STEP = 0.09  # h, of a null motion between two layers [rad; slides divided by the length scale]
_SPACING = 0.06  # of configurations in a layer [rad]; both with one joint to spare, five times that with more
_WIDEST = 600  # configurations of a layer, the cheapest
_LAYERS = (40, 160)  # at least, at most
_LONG = 0.03  # joint motion of the old path from layer to layer that is aimed at [rad]
_JUMP = 3.0  # of one configuration from layer to layer at most, as a multiple of h
_FAR = 0.5  # room beyond which more is no better [rad]
_NEAR = 0.01  # … and below which a configuration is not taken
_ROUNDS = 40  # of smoothing
_KEPT = 0.8  # share of the least room that smoothing leaves
_OFF = 0.1  # of a configuration between layers from the curve through them [rad]


def plan_path(
    tool: JointToolPath, starts: Array, report: Callable[[int, int], None], *, around: bool
) -> tuple[Array, Array, float]:
    """The best joint path that was found for a tool path of a redundant arm.

    Args:
        tool: the tool's path.
        starts: (S, n) configurations at its first pose.
        report: how many layers are done, of how many.
        around: begin anywhere on their self-motions.

    Returns:
        (K,) places of the layers up to the last one reached, (K, n) the path there, empty where no path of this spacing
        reaches the end of the tool's path, and the least room on it [rad].
    """
    layers = tool.spread(int(np.clip(np.ceil(float(tool.lengths[-1]) / _LONG), *_LAYERS)))
    now = _cheapest(layers, starts, np.zeros(len(starts)), np.full(len(starts), -1))
    if around:
        now = _self_motion_layer(layers, now)
    reached = [now]
    for k in range(1, len(layers.place)):
        report(k, len(layers.place))
        now = _next_layer(layers, now, k)
        if not len(now[0]):
            return layers.place[:k], np.empty((0, tool.robot.n)), 0.0
        reached.append(now)
    rows = [int(now[1].argmin())]
    for _, _, parent in reached[:0:-1]:
        rows.append(int(parent[rows[-1]]))
    q = np.array([layer[0][row] for layer, row in zip(reached, rows[::-1], strict=True)])
    q = _smooth(layers, q, fixed=not around)
    return layers.place, q, float(_room(layers, q).min())


def plan_as_run(place: Array, plan: Array) -> Run:
    """A plan (K, n) at places (K,) as a joint path at the places of any tool path, polished to the poses there."""

    def run(tool: JointToolPath) -> Followed:
        guess = _interpolate_plan(place, plan, tool.place)
        q, arrived = tool.aim.solve(tool.poses, guess)
        off = np.linalg.norm((q - guess) / tool.aim.joints, axis=1)
        good = arrived & (off <= _OFF) & tool.in_limits(q)
        if good.all():
            return Followed(q, tool.place + 1.0, True, float(len(q)), q[-1])
        count = int(good.argmin())
        return Followed(q[:count], tool.place[:count] + 1.0, False, float(count), q[max(0, count - 1)], "stuck")

    return run


def _interpolate_plan(place: Array, q: Array, wanted: Array) -> Array:
    """(N, n) at places (N,) of the cubics through the layers with the slopes of their neighbours (Catmull and Rom)."""
    k = np.clip(np.searchsorted(place, wanted, side="right") - 1, 0, len(place) - 2)
    slope = np.gradient(q, place, axis=0)
    h = (place[k + 1] - place[k])[:, None]
    t = (wanted - place[k])[:, None] / h
    a, b = (1 + 2 * t) * (1 - t) ** 2, t**2 * (3 - 2 * t)
    return np.asarray(
        a * q[k] + b * q[k + 1] + h * (t * (1 - t) ** 2 * slope[k] - t**2 * (1 - t) * slope[k + 1])
    )  # fmt: skip


def _room(tool: JointToolPath, q: Array) -> Array:
    """(N,) first-order distance from the singular set, no more than is of use."""
    return np.minimum(_FAR, tool.room(q))


def _next_layer(tool: JointToolPath, now: Layer, k: int) -> Layer:
    aim, (before, paid, _) = tool.aim, now
    guess, origin = _null_motion_guesses(aim, before)
    q, arrived = aim.solve(np.broadcast_to(tool.poses[k], (len(guess), 4, 4)), guess)
    far = np.linalg.norm((q - before[origin]) / aim.joints, axis=1)
    good = arrived & (far <= _JUMP * _sizes(aim)[0]) & tool.in_limits(q)
    q, origin, far = q[good], origin[good], far[good]
    if not len(q):
        return q, far, origin
    free = _room(tool, q)
    good = (free > _NEAR) & (far <= 2 * free)
    q, origin, far, free = q[good], origin[good], far[good], free[good]
    return _cheapest(tool, q, paid[origin] + far**2 / (_sizes(aim)[0] * free**2), origin)


def _self_motion_layer(tool: JointToolPath, now: Layer) -> Layer:
    """All of the self-motions of the first layer, as far as they are inside the limits and regular."""
    q = fresh = now[0]
    while len(fresh) and len(q) < _WIDEST:
        guess, _ = _null_motion_guesses(tool.aim, fresh)
        moved, arrived = tool.aim.solve(np.broadcast_to(tool.poses[0], (len(guess), 4, 4)), guess)
        moved = moved[arrived & tool.in_limits(moved)]
        if len(moved):
            moved = moved[_room(tool, moved) > _NEAR]
        both = np.concatenate([q, moved])
        both, _, _ = _cheapest(tool, both, np.arange(len(both), dtype=np.float64), np.zeros(len(both), dtype=np.int64))
        fresh, q = both[len(q) :], both
    return q, np.zeros(len(q)), np.full(len(q), -1)


def _cheapest(tool: JointToolPath, q: Array, cost: Array, parent: Index) -> Layer:
    """The cheapest of configurations that are nearer to each other than the spacing."""
    robot, spacing = tool.robot, _sizes(tool.aim)[1]
    bounded = tool.limits & np.isfinite(robot.upper - robot.lower)
    turning = np.flatnonzero(robot.periodic & ~bounded)
    order = np.argsort(cost, kind="stable")
    places = q[order] / tool.aim.joints
    taken: list[int] = []
    left = np.ones(len(q), dtype=np.bool_)
    for i in range(len(q)):
        if not left[i]:
            continue
        taken.append(i)
        if len(taken) == _WIDEST:
            break
        gap = places[i:] - places[i]
        gap[:, turning] -= 2 * np.pi * np.round(gap[:, turning] / (2 * np.pi))
        left[i:] &= (gap * gap).sum(axis=1) > spacing**2
    rows = order[np.array(taken, dtype=np.int64)]
    return q[rows], cost[rows], parent[rows]


def _smooth(tool: JointToolPath, q: Array, *, fixed: bool) -> Array:
    """The path drawn straight as far as it does not come much nearer to a singularity."""
    least = _KEPT * float(_room(tool, q).min())
    first = 1 if fixed else 0
    for _ in range(_ROUNDS):
        padded = np.concatenate([q[:1], q, q[-1:]])
        wanted = (padded[:-2] + 2 * q + padded[2:]) / 4
        moved, arrived = tool.aim.solve(tool.poses[first:], wanted[first:])
        if not arrived.all() or not tool.in_limits(moved).all() or float(_room(tool, moved).min()) < least:
            break
        q = np.concatenate([q[:first], moved])
    return q


def _sizes(aim: Aim) -> tuple[float, float]:
    """Of a null motion between layers, and between the configurations of one [rad]."""
    if aim.robot.n - aim.rank == 1:
        return (_STEP, _SPACING)
    return (5 * _STEP, 5 * _SPACING)


def _null_motion_guesses(aim: Aim, q: Array) -> tuple[Array, Index]:
    """Guesses (G, n): each as it is, and a step along every null motion, both ways; and which each is of."""
    _, _, v = _core.svd(np.ascontiguousarray(aim.jacobian(q)))
    null = v[:, :, aim.rank :] * aim.joints[:, None] * _sizes(aim)[0]
    ways = [q, *(q + sign * null[:, :, i] for i in range(null.shape[2]) for sign in (1.0, -1.0))]
    return np.concatenate(ways), np.tile(np.arange(len(q)), len(ways))
