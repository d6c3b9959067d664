"""Numbers of aspects of random arms, beside an independent flood fill of the torus of joint angles at two resolutions.

    python benchmarks/aspects.py [--each 20] [--seed 0] [--kinds 3R,wrist] [--quick] [--json]

The flood fill is NumPy alone: Denavit-Hartenberg transforms, the geometric Jacobian and its determinant are written
here. The determinant is a trigonometric polynomial of degree 2 in each joint angle, so that its values at 7 angles of
each joint give those at all others; that is checked at random configurations. Grid points of one sign of the
determinant are joined along the axes of the grid by union-find; where the values bend so much that they may pass zero
twice in between, 16 points there decide. Each connected set is a region, and a set of fewer points than a line of the
grid is dropped.

The torus has the joints on which the determinant depends. The others are fixed, as a circle of each is in one piece:
the first and the last joint of six, joint 1 of three, joint 4 where a spherical wrist makes the determinant a product.

Where the two resolutions find different numbers, a third one takes the place of the coarser one; where these differ as
well, the case is not decided by the grid. Two regions that come nearer than a cell, or one that is narrower than a
cell, are such cases. Exit code 1: both resolutions find one number, and rankdrop has another one.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import measure  # first: sets the number of threads
import numpy as np
from numpy.typing import NDArray

from rankdrop.aspects.arm import count_of_arm
from rankdrop.aspects.count import AspectCount
from rankdrop.robot.dh import from_dh
from rankdrop.task import resolve_task

Array = NDArray[np.float64]
Labels = NDArray[np.int64]
Rows = tuple[tuple[float, float, float], ...]
"""Rows (d, a, α) of the standard convention [m, m, rad]."""

H = np.pi / 2
SAMPLES = 7  # of the determinant along each joint: enough for degree 3
SIZES = {2: (150, 400, 1000), 3: (48, 72, 108), 4: (20, 30, 40)}
"""Grid points along each joint, by the number of joints: the first two, and the last two where these disagree."""
SMALL = {2: (60, 90), 3: (24, 36), 4: (12, 18)}
"""Of a small run."""
BETWEEN = 16  # parts of a step of the grid, where two points of one sign may have zeros between them
CHUNK = 100_000  # of such steps at once
CHECKED = 200  # random configurations at which the interpolation is checked


def links(rows: Rows, q: Array) -> tuple[list[Array], list[Array], Array]:
    """Axes z_i (N, 3), points o_i on them (N, 3), and the tip (N, 3) at configurations q (N, n)."""
    turn = np.tile(np.eye(3), (len(q), 1, 1))
    at = np.zeros((len(q), 3))
    axes, points = [], []
    for (d, a, alpha), theta in zip(rows, q.T, strict=True):
        axes.append(turn[:, :, 2])
        points.append(at)
        c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
        zero, one = np.zeros_like(c), np.ones_like(c)
        step = np.stack([c, -s * ca, s * sa, s, c * ca, -c * sa, zero, sa * one, ca * one], axis=1).reshape(-1, 3, 3)
        shift = np.stack([a * c, a * s, d * one], axis=1)
        at = at + np.einsum("nij,nj->ni", turn, shift)
        turn = turn @ step
    return axes, points, at


def determinant(rows: Rows, q: Array) -> Array:
    """(N,) det J at q (N, n): of the tip's velocity for three joints, of its whole twist for six."""
    axes, points, tip = links(rows, q)
    columns = []
    for axis, point in zip(axes, points, strict=True):
        column = np.cross(axis, tip - point)
        if len(rows) == 6:
            column = np.concatenate([column, axis], axis=1)
        columns.append(column)
    return np.asarray(np.linalg.det(np.stack(columns, axis=2)))


def joints_that_matter(rows: Rows) -> list[int]:
    """Joints (from 0) that change the determinant at random configurations."""
    base, other = np.random.default_rng(7).uniform(-np.pi, np.pi, (2, 40, len(rows)))
    there = determinant(rows, base)
    found = []
    for joint in range(len(rows)):
        moved = base.copy()
        moved[:, joint] = other[:, joint]
        if np.abs(determinant(rows, moved) - there).max() > 1e-10 * np.abs(there).max():
            found.append(joint)
    return found


def interpolation(angles: Array) -> Array:
    """(M, SAMPLES) weights: values of a trigonometric polynomial at angles (M,) from those at equal steps."""
    known = np.arange(SAMPLES) * 2 * np.pi / SAMPLES
    gap = angles[:, None] - known
    orders = np.arange(1, SAMPLES // 2 + 1)
    return np.asarray((1 + 2 * np.cos(gap[..., None] * orders).sum(axis=-1)) / SAMPLES)


class Torus:
    """The determinant over the joints that matter.

    Attributes:
        joints: these joints (from 0).
        values: (SAMPLES, …) at equal steps of each, divided by the largest one; the other joints at 0.3 rad.

    Raises:
        RuntimeError: the interpolation does not give the determinant.
    """

    def __init__(self, rows: Rows) -> None:
        self.joints = joints_that_matter(rows)
        steps = np.arange(SAMPLES) * 2 * np.pi / SAMPLES
        mesh = np.stack(np.meshgrid(*[steps] * len(self.joints), indexing="ij"), axis=-1).reshape(-1, len(self.joints))
        values = determinant(rows, self._configurations(rows, mesh))
        self._unit = np.abs(values).max()
        self.values = (values / self._unit).reshape((SAMPLES,) * len(self.joints))
        self._check(rows)

    def _configurations(self, rows: Rows, angles: Array) -> Array:
        q = np.full((len(angles), len(rows)), 0.3)
        q[:, self.joints] = angles
        return q

    def _check(self, rows: Rows) -> None:
        rng = np.random.default_rng(8)
        angles = rng.uniform(-np.pi, np.pi, (CHECKED, len(self.joints)))
        q = self._configurations(rows, angles)
        others = [joint for joint in range(len(rows)) if joint not in self.joints]
        q[:, others] = rng.uniform(-np.pi, np.pi, (CHECKED, len(others)))
        exact = determinant(rows, q) / self._unit
        values = np.repeat(self.values[None], CHECKED, axis=0)
        for axis in range(len(self.joints)):
            values = np.einsum("nk...,nk->n...", values, interpolation(angles[:, axis]))
        if np.abs(values - exact).max() > 1e-9:
            raise RuntimeError("the determinant is no trigonometric polynomial of the degree assumed")

    def grid(self, size: int, *, coarse: int | None = None) -> Array:
        """(size, …) values at so many equal steps of each joint, which begin off the special angles.

        Args:
            size: steps of each joint.
            coarse: an axis along which the values stay those at SAMPLES steps; None: none.
        """
        weights = interpolation(angles_of(size))
        values = self.values
        for axis in range(values.ndim):
            if axis != coarse:
                values = np.moveaxis(np.tensordot(weights, values, axes=(1, axis)), 0, axis)
        return values

    def joined(self, values: Array, axis: int) -> NDArray[np.bool_]:
        """Whether each point of a grid and the next one along an axis have one sign, and no zero lies between."""
        near = no_dip(values, axis)
        doubtful = np.argwhere((values * np.roll(values, -1, axis) > 0) & ~near)
        lines = np.moveaxis(self.grid(len(values), coarse=axis), axis, -1)
        for some in np.array_split(doubtful, len(doubtful) // CHUNK + 1):
            places = tuple(some.T)
            samples = lines[tuple(place for k, place in enumerate(places) if k != axis)]
            near[places] = free_between(samples, places[axis], len(values))
        return near

    def regions(self, size: int) -> int:
        """Connected sets of one sign at this resolution."""
        values = self.grid(size)
        number = np.arange(values.size).reshape(values.shape)
        root = np.arange(values.size)
        for axis in range(values.ndim):
            near = self.joined(values, axis)
            root = union_find(root, np.stack([number[near], np.roll(number, -1, axis)[near]]))
        counts = np.bincount(root)
        return int((counts >= size).sum())

    def at_two_resolutions(self, sizes: Sequence[int]) -> tuple[int, int]:
        """Regions at two resolutions that agree, or at the two finest ones."""
        found = (-1, -2)
        for pair in pairwise(sizes):
            coarse = found[1] if found[1] >= 0 else self.regions(pair[0])
            found = coarse, self.regions(pair[1])
            if found[0] == found[1]:
                break
        return found


def angles_of(size: int) -> Array:
    """(size,) angles of a grid."""
    return np.asarray((np.arange(size) + 0.37) * 2 * np.pi / size)


def free_between(samples: Array, step: Labels, size: int) -> NDArray[np.bool_]:
    """(N,) whether the determinant keeps its sign along a step of a grid.

    Args:
        samples: (N, SAMPLES) along the axis of the step, the other joints fixed.
        step: (N,) index of the grid point that each step begins at.
        size: grid points along the axis.
    """
    free = np.ones(len(samples), dtype=bool)
    share = np.arange(-1, BETWEEN + 2) / BETWEEN  # one point more at each end, for the bends
    for begin in np.unique(step):
        own = step == begin
        values = samples[own] @ interpolation(angles_of(size)[begin] + share * 2 * np.pi / size).T
        free[own] = no_dip(values, 1)[:, 1:-2].all(axis=1)
    return free


def no_dip(values: Array, axis: int) -> NDArray[np.bool_]:
    """Whether each point and the next one along an axis of the torus have one sign, and surely no zero between.

    A parabola through values v and v′ with second difference b dips by at most |b|/8 below the lower of the two; twice
    that is allowed for, with the larger bend of both ends. Where three factors are zero together one of the two bends
    may vanish: the smaller one would join regions there.
    """
    after, before = np.roll(values, -1, axis), np.roll(values, 1, axis)
    bend = np.abs(after - 2 * values + before)
    dip = np.maximum(bend, np.roll(bend, -1, axis)) / 4
    return np.asarray((values * after > 0) & (np.minimum(np.abs(values), np.abs(after)) > dip))


def union_find(parent: Labels, edges: Labels) -> Labels:
    """(N,) the least node of the set that each node is in: roots are hooked along edges (2, E), then paths halved.

    Args:
        parent: (N,) the root of each node before these edges.
        edges: pairs of nodes of one set.
    """
    parent = parent.copy()
    while edges.shape[1]:
        one, two = parent[edges[0]], parent[edges[1]]
        apart = one != two
        edges, one, two = edges[:, apart], one[apart], two[apart]
        np.minimum.at(parent, np.maximum(one, two), np.minimum(one, two))
        above = parent[parent]
        while not np.array_equal(above, parent):
            parent, above = above, above[above]
    return parent


def three_joints(x: Sequence[float], number: int) -> Rows:
    """Three joints that move a point: right angles between axes in every second arm, any others else."""
    first, second = (-H, H) if number % 2 else (round(x[5] + 0.4, 1), round(x[6] - 1.9, 1))
    return ((0, x[0], first), (x[1], x[2], second), (x[3], x[4], 0))


def wristed(x: Sequence[float], number: int) -> Rows:
    """A spherical wrist behind an arm with parallel axes 2, 3; every second arm has a shoulder offset."""
    offset = x[0] * (number % 2)
    return ((0.3, offset, -H), (0, x[1], 0), (0, x[2], -H), (x[3], 0, H), (0, 0, -H), (0.1, 0, 0))


def three_parallel(x: Sequence[float], _: int) -> Rows:
    """Axes 2, 3, 4 parallel, as of a UR."""
    return ((x[0], 0, H), (0, x[1], 0), (0, x[2], 0), (x[3], 0, H), (x[4], 0, -H), (0.1, 0, 0))


def offset_wrist(x: Sequence[float], _: int) -> Rows:
    """Axes 4, 5 and 5, 6 meet in two points, as of a CRX."""
    return ((0.2, 0, -H), (0, x[0], 0), (0, 0, -H), (x[1], 0, H), (round(0.3 * x[2], 3), 0, -H), (0.1, 0, 0))


KINDS: dict[str, Callable[[Sequence[float], int], Rows]] = {
    "3R": three_joints, "wrist": wristed, "three parallel": three_parallel, "offset wrist": offset_wrist,
}  # fmt: skip


@dataclass(frozen=True)
class Case:
    """One arm.

    Attributes:
        number: of the arm within its kind, from 0.
        rows: of the arm.
        joints: of the grid, from 1.
        found: regions of the grid at both resolutions.
        count: of rankdrop.
        seconds: processor time of rankdrop's count, and of the flood fill.
    """

    number: int
    rows: Rows
    joints: tuple[int, ...]
    found: tuple[int, int]
    count: AspectCount
    seconds: tuple[float, float]

    @property
    def verdict(self) -> str:
        """ "agree", "differ", "not decided by the grid", or "no number" where rankdrop proves bounds only."""
        coarse, fine = self.found
        most = self.count.at_most
        if coarse != fine:
            return "not decided by the grid"
        if most is None:
            return "no number"
        if not self.count.at_least <= fine or (self.count.proven and fine > most):
            return "differ"
        return "agree" if self.count.exact else "no number"


def judged(kind: str, number: int, seed: int, sizes: Mapping[int, Sequence[int]]) -> Case:
    """Count the aspects of one random arm in both ways."""
    lengths = np.random.default_rng([seed, list(KINDS).index(kind), number]).uniform(0.2, 1.0, 8).round(2)
    rows = KINDS[kind](lengths.tolist(), number)
    table = [{"d": float(d), "a": float(a), "alpha": float(alpha)} for d, a, alpha in rows]
    arm = from_dh(table, convention="standard", task="position" if len(rows) == 3 else "pose", name=f"{kind} {number}")
    begun = time.process_time()
    count, _ = count_of_arm(arm, resolve_task(None, arm))
    counted = time.process_time()
    torus = Torus(rows)
    found = torus.at_two_resolutions(sizes[len(torus.joints)])
    joints = tuple(joint + 1 for joint in torus.joints)
    return Case(number, rows, joints, found, count, (counted - begun, time.process_time() - counted))


def summary(kind: str, cases: list[Case]) -> measure.Row:
    """One line of the table."""
    verdicts = Counter(case.verdict for case in cases)
    grids = sorted({case.joints for case in cases})
    numbers = Counter(str(case.count.at_least) if case.count.exact else "not proven" for case in cases)
    return {
        "kind": kind, "arms": len(cases), "agree": verdicts["agree"], "differ": verdicts["differ"],
        "not decided by the grid": verdicts["not decided by the grid"], "no number": verdicts["no number"],
        "aspects": ", ".join(f"{number} × {times}" for number, times in sorted(numbers.items())),
        "grid over joints": "; ".join(", ".join(map(str, joints)) for joints in grids),
        "slowest count [s CPU]": max(case.seconds[0] for case in cases),
        "flood fill [s CPU]": sum(case.seconds[1] for case in cases),
    }  # fmt: skip


def main(argv: list[str] | None = None) -> int:
    """Count the aspects of random arms in both ways; 1 if a number differs."""
    parser = argparse.ArgumentParser(description="Numbers of aspects beside an independent flood fill.")
    parser.add_argument("--each", type=int, default=20, help="random arms of each kind (20)")
    parser.add_argument("--seed", type=int, default=0, help="of the random arms (0)")
    parser.add_argument("--kinds", default=",".join(KINDS), help=f"with commas: {', '.join(KINDS)}")
    measure.options(parser)
    arguments = parser.parse_args(argv)
    kinds = arguments.kinds.split(",")
    unknown = [kind for kind in kinds if kind not in KINDS]
    if unknown:
        parser.error(f"--kinds: no kind {unknown[0]!r}; allowed: {', '.join(KINDS)}")
    if arguments.each < 1:
        parser.error(f"--each: {arguments.each} arms; at least 1")
    each, sizes = arguments.each, SIZES
    if arguments.quick:
        each, sizes = min(each, 2), SMALL
    rows = []
    for kind in kinds:
        cases = [judged(kind, number, arguments.seed, sizes) for number in range(each)]
        rows.append(summary(kind, cases))
        for case in cases:
            if case.verdict != "agree":
                bounds = f"{case.count.at_least} to {case.count.at_most}"
                print(f"{kind} {case.number}: {case.verdict}: rankdrop {bounds}, grid {case.found}; rows {case.rows}",
                      file=sys.stderr, flush=True)  # fmt: skip
    measure.report("the number of aspects of random arms is that of an independent flood fill at two resolutions; "
                   "joints that the determinant does not depend on are fixed", rows, ratio="differ", target=0,
                   at_most=True, arguments=arguments)  # fmt: skip
    return int(any(row["differ"] for row in rows))


if __name__ == "__main__":
    sys.exit(main())
