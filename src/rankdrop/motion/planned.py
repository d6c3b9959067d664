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
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.motion.follow import Followed
from rankdrop.motion.inverse import Aim
from rankdrop.motion.tool_path import ToolPath, room
from rankdrop.robot.model import Array, Robot

Index = NDArray[np.int64]

_STEP = 0.09  # h, of a null motion between two layers [rad; slides divided by the length scale]
_SPACING = 0.06  # of configurations in a layer, with one joint to spare; five times it with more
_MOST = 600  # of a layer, the cheapest
_LAYERS = (40, 160)  # at least, at most
_LONG = 0.03  # joint motion of the old path from layer to layer that is aimed at [rad]
_JUMP = 0.3  # of one configuration from layer to layer at most [rad]
_FAR = 0.5  # room beyond which more is no better [rad]
_NEAR = 0.01  # … and below which a configuration is not taken
_ROUNDS = 40  # of smoothing
_KEPT = 0.8  # share of the least room that smoothing leaves
_OFF = 0.1  # of a configuration between layers from the curve through them [rad]


@dataclass(frozen=True, eq=False)
class Plan:
    """A joint path on layers of a tool path.

    Attributes:
        place: (K,) of the layers.
        q: (K, n).
        room: the least of them [rad].
    """

    place: Array
    q: Array
    room: float

    def followed(self, tool: ToolPath) -> Followed:
        """The plan at the places of a tool path, polished to the poses there."""
        aim = Aim(tool.robot, tool.task)
        guess = self._at(tool.place)
        q, arrived = aim.solve(tool.poses, guess)
        off = np.linalg.norm((q - guess) / aim.joints, axis=1)
        good = arrived & (off <= _OFF) & _inside(tool.robot, q, limits=tool.limits)
        count = len(q) if good.all() else int(good.argmin())
        if count == len(q):
            return Followed(q, True, float(count), q[-1], "", "")
        words = "the planned path cannot be kept between its layers"
        return Followed(q[:count], False, float(count), q[max(0, count - 1)], "stuck", words)

    def _at(self, place: Array) -> Array:
        """(N, n) the cubic through the layers with the slopes of their neighbours (Catmull and Rom)."""
        k = np.clip(np.searchsorted(self.place, place, side="right") - 1, 0, len(self.place) - 2)
        width = np.diff(self.place)
        slope = np.gradient(self.q, self.place, axis=0) if len(self.place) > 2 else np.diff(self.q, axis=0) / width
        slope = np.broadcast_to(slope, self.q.shape)
        t, h = ((place - self.place[k]) / width[k])[:, None], width[k][:, None]
        a, b = (1 + 2 * t) * (1 - t) ** 2, t**2 * (3 - 2 * t)
        return np.asarray(
            a * self.q[k] + b * self.q[k + 1]
            + h * (t * (1 - t) ** 2 * slope[k] - t**2 * (1 - t) * slope[k + 1])
        )  # fmt: skip


def planned(
    tool: ToolPath, starts: Array, told: Callable[[int, int], None], *, around: bool
) -> tuple[Plan | None, float]:
    """The best joint path that was found for a tool path.

    Args:
        tool: the tool's path.
        starts: (S, n) configurations at its first pose.
        told: how many layers are done, of how many.
        around: begin anywhere on their self-motions.

    Returns:
        The plan, None where no path of this spacing reaches the end; and the place that was reached.
    """
    length = float(tool.lengths[-1])
    layers = tool.spread(int(np.clip(np.ceil(length / _LONG), *_LAYERS)))
    search = _Search(layers)
    now = _Layer.of(search.kept(starts, np.zeros(len(starts)), np.full(len(starts), -1)))
    if around:
        now = search.around(now)
    made = [now]
    for k in range(1, len(layers.place)):
        told(k, len(layers.place))
        now = search.onward(now, k)
        if not len(now.q):
            return None, float(layers.place[k - 1])
        made.append(now)
    q = search.smooth(_backwards(made), fixed=not around)
    return Plan(layers.place, q, float(search.room(q).min())), float(layers.place[-1])


@dataclass(frozen=True, eq=False)
class _Layer:
    """Configurations (M, n) at one place, what they cost from the start, and which of the layer before each is from."""

    q: Array
    cost: Array
    parent: Index

    @classmethod
    def of(cls, parts: tuple[Array, Array, Index]) -> _Layer:
        return cls(*parts)


def _backwards(made: list[_Layer]) -> Array:
    """(K, n) the cheapest way through all layers."""
    number = int(made[-1].cost.argmin())
    rows = []
    for layer in reversed(made):
        rows.append(layer.q[number])
        number = int(layer.parent[number])
    return np.array(rows[::-1])


class _Search:
    """Layers of one tool path.

    Args:
        tool: its places are those of the layers.
    """

    def __init__(self, tool: ToolPath) -> None:
        self.tool, self.aim = tool, Aim(tool.robot, tool.task)
        self.scale = self.aim.joints
        spare = tool.robot.n - self.aim.rank
        self.spacing = _SPACING if spare == 1 else 5 * _SPACING
        self.step = _STEP if spare == 1 else 1.5 * self.spacing
        bounded = tool.limits & np.isfinite(tool.robot.upper - tool.robot.lower)
        self.turning = np.flatnonzero(tool.robot.periodic & ~bounded)

    def room(self, q: Array) -> Array:
        """(N,) first-order distance from the singular set, no more than is of use."""
        return np.minimum(_FAR, room(self.tool.robot, self.tool.task, q, self.aim.rank))

    def onward(self, now: _Layer, k: int) -> _Layer:
        """Layer k, from the one before."""
        guess, origin = self._moved(now.q)
        q, arrived = self.aim.solve(np.broadcast_to(self.tool.poses[k], (len(guess), 4, 4)), guess)
        far = np.linalg.norm((q - now.q[origin]) / self.scale, axis=1)
        good = arrived & (far <= _JUMP) & _inside(self.tool.robot, q, limits=self.tool.limits)
        q, origin, far = q[good], origin[good], far[good]
        if not len(q):
            return _Layer(q, np.empty(0), np.empty(0, dtype=np.int64))
        free = self.room(q)
        good = (free > _NEAR) & (far <= 2 * free)
        q, origin, far, free = q[good], origin[good], far[good], free[good]
        cost = now.cost[origin] + far**2 / (self.step * free**2)
        return _Layer.of(self.kept(q, cost, origin))

    def around(self, now: _Layer) -> _Layer:
        """All of the self-motions of a layer, as far as they are inside the limits and regular."""
        q, fresh = now.q, now.q
        while len(fresh) and len(q) < _MOST:
            guess, _ = self._moved(fresh)
            moved, arrived = self.aim.solve(np.broadcast_to(self.tool.poses[0], (len(guess), 4, 4)), guess)
            moved = moved[arrived & _inside(self.tool.robot, moved, limits=self.tool.limits)]
            moved = moved[self.room(moved) > _NEAR] if len(moved) else moved
            both, _, _ = self.kept(np.concatenate([q, moved]), np.arange(len(q) + len(moved), dtype=np.float64),
                                   np.zeros(len(q) + len(moved), dtype=np.int64))  # fmt: skip
            fresh, q = both[len(q) :], both
        return _Layer(q, np.zeros(len(q)), np.full(len(q), -1))

    def kept(self, q: Array, cost: Array, parent: Index) -> tuple[Array, Array, Index]:
        """The cheapest of configurations that are nearer to each other than the spacing."""
        order = np.argsort(cost, kind="stable")
        places = q[order] / self.scale
        taken: list[int] = []
        left = np.ones(len(q), dtype=np.bool_)
        for i in range(len(q)):
            if not left[i]:
                continue
            taken.append(i)
            if len(taken) == _MOST:
                break
            gap = places[i:] - places[i]
            turns = gap[:, self.turning] / (2 * np.pi)
            gap[:, self.turning] -= 2 * np.pi * np.round(turns)
            left[i:] &= (gap * gap).sum(axis=1) > self.spacing**2
        rows = order[np.array(taken, dtype=np.int64)]
        return q[rows], cost[rows], parent[rows]

    def smooth(self, q: Array, *, fixed: bool) -> Array:
        """The path drawn straight as far as it does not come much nearer to a singularity."""
        least = _KEPT * float(self.room(q).min())
        first = 1 if fixed else 0
        for _ in range(_ROUNDS):
            padded = np.concatenate([q[:1], q, q[-1:]])
            wanted = (padded[:-2] + 2 * q + padded[2:]) / 4
            moved, arrived = self.aim.solve(self.tool.poses[first:], wanted[first:])
            if not arrived.all() or not _inside(self.tool.robot, moved, limits=self.tool.limits).all():
                break
            if float(self.room(moved).min()) < least:
                break
            q = np.concatenate([q[:first], moved])
        return q

    def _moved(self, q: Array) -> tuple[Array, Index]:
        """Guesses (G, n): each as it is, and a step along every null motion, both ways; and which each is of."""
        _, _, v = _core.svd(np.ascontiguousarray(self.aim.jacobian(q)))
        null = v[:, :, self.aim.rank :] * self.scale[:, None]
        ways = [q, *(q + sign * self.step * null[:, :, i] for i in range(null.shape[2]) for sign in (1.0, -1.0))]
        return np.concatenate(ways), np.tile(np.arange(len(q)), len(ways))


def _inside(robot: Robot, q: Array, *, limits: bool) -> NDArray[np.bool_]:
    """(N,) within the joint limits, where they count."""
    if not limits:
        return np.ones(len(q), dtype=np.bool_)
    return np.asarray(((q >= robot.lower - 1e-9) & (q <= robot.upper + 1e-9)).all(axis=1))
