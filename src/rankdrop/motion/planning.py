"""Joint paths of a redundant arm for a tool path, searched for over the whole of its self-motions.

At every place of the tool's path the configurations that reach it are one or more curves (surfaces, with two joints to
spare), the self-motions. From the configurations that can be begun at, layers of them are made place by place,

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
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.motion.follow import Followed
from rankdrop.motion.inverse import Aim
from rankdrop.motion.tool_path import Run, ToolPath, room
from rankdrop.robot.model import Array

Index = NDArray[np.int64]
Layer = tuple[Array, Array, Index]
"""Configurations (M, n) at one place, what they cost from the start, and which of the layer before each is from."""

_STEP = 0.09  # h, of a null motion between two layers [rad; slides divided by the length scale]
_SPACING = 0.06  # of configurations in a layer [rad]; both with one joint to spare, five times that with more
_MOST = 600  # of a layer, the cheapest
_LAYERS = (40, 160)  # at least, at most
_LONG = 0.03  # joint motion of the old path from layer to layer that is aimed at [rad]
_JUMP = 3.0  # of one configuration from layer to layer at most, as a multiple of h
_FAR = 0.5  # room beyond which more is no better [rad]
_NEAR = 0.01  # … and below which a configuration is not taken
_ROUNDS = 40  # of smoothing
_KEPT = 0.8  # share of the least room that smoothing leaves
_OFF = 0.1  # of a configuration between layers from the curve through them [rad]


def planned(
    tool: ToolPath, starts: Array, report: Callable[[int, int], None], *, around: bool
) -> tuple[Array, Array, float]:
    """The best joint path that was found for a tool path.

    Args:
        tool: the tool's path.
        starts: (S, n) configurations at its first pose.
        report: how many layers are done, of how many.
        around: begin anywhere on their self-motions.

    Returns:
        (K,) places of the layers up to the last one reached, (K, n) the path there, empty where no path of this spacing
        reaches the end of the tool's path, and the least room on it [rad].
    """
    length = float(tool.lengths[-1])
    layers = tool.spread(int(np.clip(np.ceil(length / _LONG), *_LAYERS)))
    aim = Aim(tool.robot, tool.task)
    now = _kept(layers, aim, starts, np.zeros(len(starts)), np.full(len(starts), -1))
    if around:
        now = _around(layers, aim, now)
    made = [now]
    for k in range(1, len(layers.place)):
        report(k, len(layers.place))
        now = _onward(layers, aim, now, k)
        if not len(now[0]):
            return layers.place[:k], np.empty((0, tool.robot.n)), 0.0
        made.append(now)
    q = _smooth(layers, aim, _backwards(made), fixed=not around)
    return layers.place, q, float(_room(layers, aim, q).min())


def along(place: Array, plan: Array) -> Run:
    """A plan (K, n) at places (K,) as a joint path at the places of any tool path, polished to the poses there."""

    def run(tool: ToolPath) -> Followed:
        aim = Aim(tool.robot, tool.task)
        guess = _between(place, plan, tool.place)
        q, arrived = aim.solve(tool.poses, guess)
        off = np.linalg.norm((q - guess) / aim.joints, axis=1)
        good = arrived & (off <= _OFF) & _inside(tool, q)
        if good.all():
            return Followed(q, tool.place, True, float(len(q)), q[-1])
        count = int(good.argmin())
        return Followed(q[:count], tool.place[:count], False, float(count), q[max(0, count - 1)], "stuck")

    return run


def _between(place: Array, q: Array, wanted: Array) -> Array:
    """(N, n) at places (N,) of the cubics through the layers with the slopes of their neighbours (Catmull and Rom)."""
    k = np.clip(np.searchsorted(place, wanted, side="right") - 1, 0, len(place) - 2)
    slope = np.gradient(q, place, axis=0)
    h = (place[k + 1] - place[k])[:, None]
    t = (wanted - place[k])[:, None] / h
    a, b = (1 + 2 * t) * (1 - t) ** 2, t**2 * (3 - 2 * t)
    return np.asarray(
        a * q[k] + b * q[k + 1] + h * (t * (1 - t) ** 2 * slope[k] - t**2 * (1 - t) * slope[k + 1])
    )  # fmt: skip


def _backwards(made: list[Layer]) -> Array:
    """(K, n) the cheapest way through all layers."""
    number = int(made[-1][1].argmin())
    rows = []
    for q, _, parent in reversed(made):
        rows.append(q[number])
        number = int(parent[number])
    return np.array(rows[::-1])


def _room(tool: ToolPath, aim: Aim, q: Array) -> Array:
    """(N,) first-order distance from the singular set, no more than is of use."""
    return np.minimum(_FAR, room(tool.robot, tool.task, q, aim.rank))


def _onward(tool: ToolPath, aim: Aim, now: Layer, k: int) -> Layer:
    before, paid, _ = now
    guess, origin = _moved(aim, before)
    q, arrived = aim.solve(np.broadcast_to(tool.poses[k], (len(guess), 4, 4)), guess)
    far = np.linalg.norm((q - before[origin]) / aim.joints, axis=1)
    good = arrived & (far <= _JUMP * _sizes(aim)[0]) & _inside(tool, q)
    q, origin, far = q[good], origin[good], far[good]
    if not len(q):
        return q, far, origin
    free = _room(tool, aim, q)
    good = (free > _NEAR) & (far <= 2 * free)
    q, origin, far, free = q[good], origin[good], far[good], free[good]
    return _kept(tool, aim, q, paid[origin] + far**2 / (_sizes(aim)[0] * free**2), origin)


def _around(tool: ToolPath, aim: Aim, now: Layer) -> Layer:
    """All of the self-motions of the first layer, as far as they are inside the limits and regular."""
    q = fresh = now[0]
    while len(fresh) and len(q) < _MOST:
        guess, _ = _moved(aim, fresh)
        moved, arrived = aim.solve(np.broadcast_to(tool.poses[0], (len(guess), 4, 4)), guess)
        moved = moved[arrived & _inside(tool, moved)]
        moved = moved[_room(tool, aim, moved) > _NEAR] if len(moved) else moved
        both = np.concatenate([q, moved])
        both, _, _ = _kept(tool, aim, both, np.arange(len(both), dtype=np.float64), np.zeros(len(both), dtype=np.int64))
        fresh, q = both[len(q) :], both
    return q, np.zeros(len(q)), np.full(len(q), -1)


def _kept(tool: ToolPath, aim: Aim, q: Array, cost: Array, parent: Index) -> Layer:
    """The cheapest of configurations that are nearer to each other than the spacing."""
    robot, spacing = tool.robot, _sizes(aim)[1]
    bounded = tool.limits & np.isfinite(robot.upper - robot.lower)
    turning = np.flatnonzero(robot.periodic & ~bounded)
    order = np.argsort(cost, kind="stable")
    places = q[order] / aim.joints
    taken: list[int] = []
    left = np.ones(len(q), dtype=np.bool_)
    for i in range(len(q)):
        if not left[i]:
            continue
        taken.append(i)
        if len(taken) == _MOST:
            break
        gap = places[i:] - places[i]
        gap[:, turning] -= 2 * np.pi * np.round(gap[:, turning] / (2 * np.pi))
        left[i:] &= (gap * gap).sum(axis=1) > spacing**2
    rows = order[np.array(taken, dtype=np.int64)]
    return q[rows], cost[rows], parent[rows]


def _smooth(tool: ToolPath, aim: Aim, q: Array, *, fixed: bool) -> Array:
    """The path drawn straight as far as it does not come much nearer to a singularity."""
    least = _KEPT * float(_room(tool, aim, q).min())
    first = 1 if fixed else 0
    for _ in range(_ROUNDS):
        padded = np.concatenate([q[:1], q, q[-1:]])
        wanted = (padded[:-2] + 2 * q + padded[2:]) / 4
        moved, arrived = aim.solve(tool.poses[first:], wanted[first:])
        if not arrived.all() or not _inside(tool, moved).all() or float(_room(tool, aim, moved).min()) < least:
            break
        q = np.concatenate([q[:first], moved])
    return q


def _sizes(aim: Aim) -> tuple[float, float]:
    """Of a null motion between layers, and between the configurations of one [rad]."""
    return (_STEP, _SPACING) if aim.robot.n - aim.rank == 1 else (5 * _STEP, 5 * _SPACING)


def _moved(aim: Aim, q: Array) -> tuple[Array, Index]:
    """Guesses (G, n): each as it is, and a step along every null motion, both ways; and which each is of."""
    _, _, v = _core.svd(np.ascontiguousarray(aim.jacobian(q)))
    null = v[:, :, aim.rank :] * aim.joints[:, None] * _sizes(aim)[0]
    ways = [q, *(q + sign * null[:, :, i] for i in range(null.shape[2]) for sign in (1.0, -1.0))]
    return np.concatenate(ways), np.tile(np.arange(len(q)), len(ways))


def _inside(tool: ToolPath, q: Array) -> NDArray[np.bool_]:
    """(N,) within the joint limits, where they count."""
    if not tool.limits:
        return np.ones(len(q), dtype=np.bool_)
    return np.asarray(((q >= tool.robot.lower - 1e-9) & (q <= tool.robot.upper + 1e-9)).all(axis=1))
