"""Ways from one configuration to another on which det J keeps its sign: a roadmap of the joint space.

Random configurations are joined with near ones wherever the straight way between keeps the sign at its sample points.
A way is the one whose smallest |det J| is the largest that the roadmap has, made shorter where that does not cost half
of it. Whatever comes out is then proven free, or is not used: that no way is found says nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rankdrop.certify.ball import settings_of
from rankdrop.kinematics import task_jacobian
from rankdrop.local.block import joint_scale, limit_box, sample, sampling_box
from rankdrop.motion.curve import curve
from rankdrop.motion.prove import prove
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT

EVALUATIONS = 5_000
"""Enclosures that one proof of a way may cost; those that succeed take some dozens."""
_NODES = {1: 100, 2: 400, 3: 800}  # by how many joints det J depends on
_MOST_NODES = 1_500
_NEIGHBOURS = 12
_STEP = 0.08  # between sample points of a straight way [rad; slides scaled]
_FINER = ((2e-2, 10), (2e-4, 100))
"""Below such a share of the usual |det J| so many times as many sample points: two sheets of the singular set near to
each other leave the sign on their far side as it was, and values of the second order between."""
_PART = 200_000  # configurations looked at together
_TRIES = 3  # ways that are tried where the proof of one fails
_SHORTER = 0.5  # share of the smallest |det J| that a shorter way keeps

Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Change:
    """A path between two solutions of one pose, or any two configurations, proven free of singularities.

    Attributes:
        q: (T, n) corners [rad, m], straight lines in joint space between them; the end is a solution up to whole turns.
        clearance: the smallest |det J| at sample points of it, J without unit.
        evaluations: enclosures that the proof took.
        own: it starts at the configuration that was asked about.
    """

    q: Array
    clearance: float
    evaluations: int
    own: bool = False


@dataclass(eq=False)
class Roadmap:
    """Random configurations, and which of them straight ways join.

    Attributes:
        robot, task: as many joints as rows.
        seed: of the configurations.
        limits: whether joints keep their limits; else turning joints go round.
        matters: (n,) joints on which det J depends.
    """

    robot: Robot
    task: Task
    seed: int
    limits: bool
    matters: NDArray[np.bool_] = field(init=False)
    _usual: float = field(init=False)  # median |det J|
    _nodes: Array = field(init=False)  # (N, n) in scaled joints
    _edges: Index = field(init=False)  # (E, 2)
    _weights: Array = field(init=False)  # (E,)

    def __post_init__(self) -> None:
        robot, task = self.robot, self.task
        self.scale = joint_scale(robot, task)
        self.matters = _matters(robot, task, self.scale)
        low, high = limit_box(robot, task) if self.limits else sampling_box(robot, task, limits=False)
        self._low, self._high = low / self.scale, high / self.scale
        count = _NODES.get(int(self.matters.sum()), _MOST_NODES)
        nodes = sample(robot, task, count, self.seed, limits=self.limits) / self.scale
        middle = np.where(np.isfinite(self._low + self._high), 0.5 * (self._low + self._high), 0.0)
        self._nodes = np.where(self.matters, nodes, middle)
        values = self._determinants(self._nodes)
        signs, self._usual = np.sign(values), float(np.median(np.abs(values)))
        pairs = [self._near(self._nodes[[i]], signs[[i]], self._nodes, signs, skip=i) for i in range(count)]
        joined = [(i, j) for i, found in enumerate(pairs) for j in found]
        edges = np.unique(np.sort(np.array(joined, dtype=np.int64).reshape(-1, 2), axis=1), axis=0)
        self._edges, self._weights = self._kept(self._nodes, edges)

    def ways(self, q: Array) -> dict[tuple[int, int], Change]:
        """Ways between some configurations: enough of them that all that are joined are joined through these.

        Args:
            q: (k, n) regular configurations; with `limits` inside them.

        Returns:
            (i, j) with i < j -> the way from i to j.
        """
        q = q / self.scale
        k = len(q)
        nodes = np.concatenate([np.where(self.matters, q, self._nodes[0]), self._nodes])
        signs = np.sign(self._determinants(nodes))
        new = [(i, j) for i in range(k) for j in self._near(nodes[[i]], signs[[i]], nodes[k:], signs[k:], skip=-1) + k]
        new += [(i, j) for i in range(k) for j in range(i) if signs[i] == signs[j]]
        edges, weights = self._kept(nodes, np.array(new, dtype=np.int64).reshape(-1, 2))
        edges, weights = np.concatenate([edges, self._edges + k]), np.concatenate([weights, self._weights])
        found: dict[tuple[int, int], Change] = {}
        groups = list(range(k))
        for i in range(k):
            for j in range(i + 1, k):
                if groups[i] == groups[j] or signs[i] != signs[j]:
                    continue
                way = self._way(nodes, edges, weights, (i, j), q)
                if way is not None:
                    found[i, j] = way
                    groups = [groups[i] if g == groups[j] else g for g in groups]
        return found

    def _way(self, nodes: Array, edges: Index, weights: Array, ends: tuple[int, int], q: Array) -> Change | None:
        usable = np.ones(len(edges), dtype=np.bool_)
        for _ in range(_TRIES):
            chain = _widest(len(nodes), edges[usable], weights[usable], *ends)
            if not chain:
                return None
            unwound = self._unwound(nodes[chain])
            for corners in (self._shortened(unwound), unwound):
                way = self._proven(corners, q[ends[0]], q[ends[1]])
                if way is not None:
                    return way
            on_it = {tuple(sorted(pair)) for pair in pairwise(chain)}
            usable &= np.array([tuple(sorted(pair)) not in on_it for pair in edges.tolist()])
        return None

    def _proven(self, corners: Array, start: Array, end: Array) -> Change | None:
        """The way through corners, the joints that do not matter going evenly from start to end; None if not proven."""
        length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
        share = length / length[-1] if length[-1] > 0 else np.linspace(0.0, 1.0, len(corners))
        free = start + share[:, None] * self._difference(start, end)
        q = np.where(self.matters, corners, free) * self.scale
        found = prove(self.robot, settings_of(self.robot, self.task), curve(q, None), singular=DEFAULT.singular,
                      evaluations=EVALUATIONS)  # fmt: skip
        if found.slivers or not found.complete:
            return None
        pairs = np.stack([np.arange(len(q) - 1), np.arange(1, len(q))], axis=1)
        return Change(q, float(self._least(q[pairs[:, 0]] / self.scale, q[pairs[:, 1]] / self.scale).min()),
                   found.evaluations)  # fmt: skip

    def _unwound(self, corners: Array) -> Array:
        """The corners one after another, each the short way from the one before."""
        steps = [self._difference(one, other) for one, other in pairwise(corners)]
        return np.asarray(corners[0] + np.concatenate([np.zeros((1, corners.shape[1])), np.cumsum(steps, axis=0)]))

    def _shortened(self, corners: Array) -> Array:
        """Fewer corners, where the smallest |det J| is not halved."""
        least = _SHORTER * float(self._least(corners[:-1], corners[1:]).min())
        kept, at = [0], 0
        while at < len(corners) - 1:
            ahead = np.arange(at + 1, len(corners))
            clear = self._least(np.repeat(corners[[at]], len(ahead), axis=0), corners[ahead]) >= least
            at = int(ahead[clear].max()) if clear.any() else at + 1
            kept.append(at)
        return corners[kept]

    def _near(self, q: Array, sign: Array, others: Array, signs: Array, *, skip: int) -> Index:
        """Indices of the nearest configurations of the same sign."""
        gap = np.linalg.norm(self._difference(q, others)[:, self.matters], axis=1)
        gap[signs != sign] = np.inf
        if skip >= 0:
            gap[skip] = np.inf
        near = np.argpartition(gap, min(_NEIGHBOURS, len(gap) - 1))[:_NEIGHBOURS]
        return np.asarray(near[np.isfinite(gap[near])], dtype=np.int64)

    def _kept(self, nodes: Array, edges: Index) -> tuple[Index, Array]:
        """The edges on which the sign is kept, and their smallest |det J|."""
        start = nodes[edges[:, 0]]
        weights = self._least(start, start + self._difference(start, nodes[edges[:, 1]]))
        return edges[weights > 0.0], weights[weights > 0.0]

    def _least(self, start: Array, end: Array) -> Array:
        """(E,) the smallest |det J| on straight ways; negative where the sign changes."""
        least = self._sampled(start, end, 1)
        for share, finer in _FINER:
            small = (least > 0.0) & (least < share * self._usual)
            least[small] = self._sampled(start[small], end[small], finer)
        return least

    def _sampled(self, start: Array, end: Array, finer: int) -> Array:
        least = np.full(len(start), np.inf)
        if not len(start):
            return least
        points = finer * int(np.ceil(np.linalg.norm(end - start, axis=1).max() / _STEP)) + 2
        share = np.linspace(0.0, 1.0, points)[None, :, None]
        part = max(1, _PART // points)
        for first in range(0, len(start), part):
            some = slice(first, first + part)
            at = start[some, None] + share * (end[some, None] - start[some, None])
            values = self._determinants(at.reshape(-1, at.shape[2])).reshape(at.shape[:2])
            least[some] = (values * np.sign(values[:, :1])).min(axis=1)
        return least

    def _determinants(self, nodes: Array) -> Array:
        return np.asarray(np.linalg.det(task_jacobian(self.robot, nodes * self.scale, self.task) * self.scale))

    def _difference(self, one: Array, other: Array) -> Array:
        gap = other - one
        if self.limits:
            return gap
        return np.where(self.robot.periodic, gap - 2 * np.pi * np.round(gap / (2 * np.pi)), gap)


def _matters(robot: Robot, task: Task, scale: Array) -> NDArray[np.bool_]:
    """(n,) joints on which det J depends, seen at random configurations."""
    base, other = np.split(sample(robot, task, 64, 20231), 2)

    def values(q: Array) -> Array:
        return np.asarray(np.linalg.det(task_jacobian(robot, q, task) * scale))

    found = np.zeros(robot.n, dtype=np.bool_)
    for j in range(robot.n):
        moved = base.copy()
        moved[:, j] = other[:, j]
        found[j] = bool(np.abs(values(moved) - values(base)).max() > 1e-10)
    return found


def _widest(count: int, edges: Index, weights: Array, start: int, end: int) -> list[int]:
    """Nodes of the path whose lightest edge is heaviest; [] where the two are not joined."""
    parent = list(range(count))

    def root(i: int) -> int:
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    tree: dict[int, list[int]] = {}
    for a, b in edges[np.argsort(-weights, kind="stable")].tolist():
        one, other = root(a), root(b)
        if one == other:
            continue
        parent[one] = other
        tree.setdefault(a, []).append(b)
        tree.setdefault(b, []).append(a)
        if root(start) == root(end):
            return _through(tree, start, end)
    return []


def _through(tree: dict[int, list[int]], start: int, end: int) -> list[int]:
    came, stack = {start: start}, [start]
    while stack:
        at = stack.pop()
        for other in tree.get(at, []):
            if other not in came:
                came[other] = at
                stack.append(other)
    chain = [end]
    while chain[-1] != start:
        chain.append(came[chain[-1]])
    return chain[::-1]
