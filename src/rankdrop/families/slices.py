"""The singular set in two or three joints, the others held (AM Figure 5): curves and points of a plane, curves and
surfaces of a cube.

Zero sets of functions given on a grid: curves in a plane (marching squares), surfaces in space (tetrahedra). Curves in
space are walked step by step along their tangent (`rankdrop.solve.trace`), in the coordinates of the slice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import permutations
from typing import cast

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.points import general_member
from rankdrop.family.equation import SOLVED, System
from rankdrop.family.record import Family, family_in_metres
from rankdrop.problem import Problem, wrap, wrapped
from rankdrop.robot.model import Array, Robot
from rankdrop.solve import trace
from rankdrop.task import Task
from rankdrop.units import in_metres, into_metres, metre_exponent, out_of_metres, task_in_metres

Ints = NDArray[np.int64]


def curves(values: Array, x: Array, y: Array) -> list[Array]:
    """Curves on which a function changes sign, by marching squares.

    Args:
        values: (a, b) at the nodes (x_i, y_j).
        x, y: (a,) and (b,) increasing.

    Returns:
        (k, 2) polylines; a closed one ends where it begins.
    """
    import contourpy

    contours = contourpy.contour_generator(x, y, values.T, line_type=contourpy.LineType.Separate)
    return cast("list[Array]", contours.lines(0.0))


def surface(values: Array, axes: tuple[Array, Array, Array]) -> tuple[Array, Ints]:
    """The surface on which a function changes sign, by marching tetrahedra: six in every cell, around its diagonal.

    Args:
        values: (a, b, c) at the nodes.
        axes: coordinates of the nodes, increasing.

    Returns:
        (V, 3) vertices and (T, 3) triangles.
    """
    shape = values.shape
    strides = np.array([shape[1] * shape[2], shape[2], 1])
    corner = np.stack(np.meshgrid(*(np.arange(size - 1) for size in shape), indexing="ij"), axis=-1).reshape(-1, 3)
    start = corner @ strides
    flat = values.ravel()
    edges = []
    for order in permutations(range(3)):
        steps = np.cumsum([0, *(strides[axis] for axis in order)])
        tetrahedra = start[:, None] + steps  # (cells, 4) node numbers
        edges.append(_cut(tetrahedra, flat[tetrahedra] >= 0))
    pairs = np.concatenate(edges)  # (T, 3, 2) grid edges cut by the corners of each triangle
    pairs.sort(axis=-1)
    keys, triangles = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    a, b = flat[keys[:, 0]], flat[keys[:, 1]]
    share = (a / (a - b))[:, None]
    places = [np.stack([axes[k][index[k]] for k in range(3)], axis=1)
              for index in (np.unravel_index(keys[:, 0], shape), np.unravel_index(keys[:, 1], shape))]  # fmt: skip
    return places[0] + share * (places[1] - places[0]), triangles.reshape(-1, 3)


def _cut(nodes: Ints, above: NDArray[np.bool_]) -> Ints:
    """(T, 3, 2) triangles cut out of tetrahedra, as pairs of nodes: one off three, or two off two."""
    found = []
    count = above.sum(axis=1)
    for single, lone in ((1, True), (3, False)):
        rows = nodes[count == single]
        order = np.argsort(above[count == single] != lone, axis=1, kind="stable")
        rows = np.take_along_axis(rows, order, axis=1)
        found.append(np.stack([np.stack([rows[:, 0], rows[:, k]], axis=1) for k in (1, 2, 3)], axis=1))
    rows = nodes[count == 2]
    rows = np.take_along_axis(rows, np.argsort(~above[count == 2], axis=1, kind="stable"), axis=1)
    p = [np.stack([rows[:, i], rows[:, k]], axis=1) for i, k in ((0, 2), (0, 3), (1, 3), (1, 2))]
    found.append(np.stack([p[0], p[1], p[2]], axis=1))
    found.append(np.stack([p[0], p[2], p[3]], axis=1))
    return np.concatenate(found)


NODES = 161
"""Grid nodes along each side of a slice."""
BEYOND = 0.035
"""A slice shows this share of a turn beyond ±π, so that what lies at π is inside the frame."""
_SEEDS = 18  # along each side, where points are solved for
_NOTHING = 1e-9  # an equation below this on the whole slice says nothing there
_MOST_POINTS = 400


@dataclass(frozen=True, eq=False)
class Trace:
    """What one family leaves in a slice.

    Attributes:
        family: its id.
        curves: (k, 2) polylines; every vertex is singular.
        points: (p, 2) isolated points, singular too.
    """

    family: str
    curves: tuple[Array, ...]
    points: Array


@dataclass(frozen=True, eq=False)
class Slice:
    """Two joints moved, the others held.

    Attributes:
        joints: numbers (from 1) of the two, x then y.
        q: (n,) configuration through which the slice goes; its entries at the two joints are a point of `family`.
        family: id of the family that the slice was chosen for.
        x, y: (a,), (b,) values of the two joints [rad, m].
        sigma: (a, b) σ_r at the nodes, r the generic rank.
        traces: per family that is met.
        filled: ids of families that the whole slice belongs to.
    """

    joints: tuple[int, int]
    q: Array
    family: str
    x: Array
    y: Array
    sigma: Array
    traces: tuple[Trace, ...]
    filled: tuple[str, ...]


def telling_slices(
    robot: Robot, task: Task, families: Sequence[Family], *, most: int = 6, seed: int = 0
) -> tuple[Slice, ...]:
    """One slice for each family of corank 1, through a general point of it; none twice.

    The two joints are the first two that the family ties together, else that it pins, else its pinned joint and one
    that moves something. A family that an earlier slice with the same joints shows needs none of its own.

    Args:
        robot, task: the arm.
        families: of all coranks.
        most: slices at most.
        seed: of the general points.
    """
    found: list[Slice] = []
    if robot.n < 2:
        return ()
    for family in families:
        if family.corank != 1 or not family.named or len(found) == most:
            continue
        joints = telling_joints(robot, family)
        shown = {trace.family for one in found if set(one.joints) == set(joints) for trace in one.traces}
        if family.id in shown:
            continue
        q = general_member(robot, task, family, [number - 1 for number in joints], seed, families)
        found.append(slice_through(robot, task, families, q, joints, family=family.id))
    return tuple(found)


def telling_joints(robot: Robot, family: Family) -> tuple[int, int]:
    """Two joints (from 1) in whose plane a family shows: tied together, else pinned, else pinned and a neighbour."""
    pinned = [one.number for one in family.pinned]
    order = [*family.coupled, *pinned] if len(family.coupled) > 1 else [*pinned, *family.coupled]
    inner = [number for number in range(2, robot.n) if number not in order]
    outer = [number for number in (1, robot.n) if number not in order]
    order += sorted(inner, key=lambda number: abs(number - order[0])) + outer if order else [*inner, *outer]
    x, y = sorted(order[:2])
    return x, y


def slice_through(
    robot: Robot,
    task: Task,
    families: Sequence[Family],
    q: Array,
    joints: tuple[int, int],
    *,
    family: str = "",
    nodes: int = NODES,
) -> Slice:
    """The slice through q: σ_r on a grid, and the families as curves and points.

    Curves are where a family's equation changes sign, polished by Newton's method; every point drawn has been tried in
    the Jacobian (σ ≤ 1e-9), and what fails is left out.

    Args:
        robot, task: the arm.
        families: whose traces are wanted; those without equations leave none.
        q: (n,) [rad, m].
        joints: numbers (from 1) of the two joints that move.
        family: id of the family that q is on, for the record.
        nodes: along each side.
    """
    if metre_exponent(robot):
        there = [family_in_metres(one, robot) for one in families]
        found = slice_through(
            in_metres(robot), task_in_metres(task, robot), there, into_metres(robot, q), joints, family=family,
            nodes=nodes,
        )
        return _out_of_metres(found, robot)
    problem = Problem(robot, task)
    x, y = (_values(problem, number - 1, q[number - 1], nodes) for number in joints)
    plane = _Plane(problem, np.array(q), (joints[0] - 1, joints[1] - 1), x, y)
    traces, filled = [], []
    for one in families:
        if not one.named or not one.equations:
            continue
        trace = plane.trace(one)
        if trace is None:
            filled.append(one.id)
        elif trace.curves or len(trace.points):
            traces.append(trace)
    return Slice(joints, np.array(q), family, x, y, plane.sigma(), tuple(traces), tuple(filled))


def _out_of_metres(slice_: Slice, robot: Robot) -> Slice:
    units = out_of_metres(robot, np.ones(robot.n))[[number - 1 for number in slice_.joints]]
    traces = tuple(
        replace(one, curves=tuple(curve * units for curve in one.curves), points=one.points * units)
        for one in slice_.traces
    )
    q = out_of_metres(robot, slice_.q)
    return replace(slice_, q=q, x=slice_.x * units[0], y=slice_.y * units[1], traces=traces)


def _values(problem: Problem, j: int, at: float, nodes: int) -> Array:
    """A whole turn, or the travel and what q needs beyond it, with some room on either side."""
    low, high = (end[j] for end in problem.box)
    low, high = (-np.pi, np.pi) if problem.robot.periodic[j] else (min(low, at), max(high, at))
    room = BEYOND * (high - low)
    return np.linspace(low - room, high + room, nodes)


@dataclass(frozen=True, eq=False)
class _Plane:
    problem: Problem
    q: Array
    moving: tuple[int, int]
    x: Array
    y: Array

    def nodes(self) -> Array:
        """(a·b, n)."""
        grid = np.stack(np.meshgrid(self.x, self.y, indexing="ij"), axis=-1)
        return _lifted(self.q, list(self.moving), grid.reshape(-1, 2))

    def sigma(self) -> Array:
        smallest = self.problem.sigma(self.nodes())[:, self.problem.generic_rank - 1]
        return np.asarray(smallest.reshape(len(self.x), len(self.y)))

    def trace(self, family: Family) -> Trace | None:
        """What the family leaves in the plane; None where it contains all of it."""
        nodes, telling = self.nodes(), []
        for equation in family.equations:
            values = equation(nodes)
            if np.abs(values).max() <= _NOTHING:
                continue
            if values.min() > 0 or values.max() < 0:
                return Trace(family.id, (), np.empty((0, 2)))
            telling.append((equation, values.reshape(len(self.x), len(self.y))))
        if not telling:
            return None
        system = System(tuple(equation for equation, _ in telling))
        if len(telling) == 1:
            lines = [self._polished(line, system, family) for line in curves(telling[0][1], self.x, self.y)]
            return Trace(family.id, tuple(line for part in lines for line in part), np.empty((0, 2)))
        return Trace(family.id, (), self._solved(system, family))

    def _polished(self, line: Array, system: System, family: Family) -> list[Array]:
        """The line brought onto the zero set, and cut where a vertex is not singular."""
        ends, _ = system.solve(_lifted(self.q, list(self.moving), line), along=self._basis(), iterations=8)
        points = ends[:, list(self.moving)]
        cell = 1.5 * np.array([self.x[1] - self.x[0], self.y[1] - self.y[0]])
        good = (np.abs(points - line) <= cell).all(axis=1)
        good &= self.problem.at(family.corank).singular(ends)
        parts = np.split(points, np.flatnonzero(~good))
        kept = [part if good[start] else part[1:] for part, start in
                zip(parts, [0, *np.flatnonzero(~good)], strict=True)]  # fmt: skip
        return [part for part in kept if len(part) > 1]

    def _solved(self, system: System, family: Family) -> Array:
        """Isolated points, from a grid of starts."""
        starts = np.stack(np.meshgrid(*(np.linspace(v[0], v[-1], _SEEDS) for v in (self.x, self.y))), axis=-1)
        ends, solved = system.solve(_lifted(self.q, list(self.moving), starts.reshape(-1, 2)), along=self._basis())
        ends = wrapped(self.problem.robot, ends[solved])
        ends = ends[self.problem.at(family.corank).singular(ends)]
        points = ends[:, list(self.moving)]
        inside = (points >= [self.x[0], self.y[0]]) & (points <= [self.x[-1], self.y[-1]])
        points = points[inside.all(axis=1)]
        _, first = np.unique(np.round(points, 5), axis=0, return_index=True)
        return self._both_ends(points[np.sort(first)][:_MOST_POINTS])

    def _both_ends(self, points: Array) -> Array:
        """What lies within the margin at one side of a turn is shown at the other side too."""
        for k, (j, values) in enumerate(zip(self.moving, (self.x, self.y), strict=True)):
            if self.problem.robot.periodic[j] and len(points):
                turn = np.zeros(2)
                turn[k] = 2 * np.pi
                for moved in (points + turn, points - turn):
                    points = np.concatenate([points, moved[(moved[:, k] >= values[0]) & (moved[:, k] <= values[-1])]])
        return points[np.unique(np.round(points, 5), axis=0, return_index=True)[1]] if len(points) else points

    def _basis(self) -> Array:
        return np.eye(self.problem.n)[:, list(self.moving)]


STEP = 0.07
"""Between neighbours on a curve [rad]."""
_MOST = 600  # steps of one curve: seven turns; one that is longer does not come to an end


def walk(system: System, base: Array, joints: Sequence[int], seeds: Array, step: float = STEP) -> list[Array] | None:
    """Every curve of the zero set that a seed lies on; all joints of the slice turn, and curves run on past ±π.

    Args:
        system: the equations.
        base: (n,) the other joints [rad, m].
        joints: d joints from 0 that span the slice.
        seeds: (N, d) points that solve the equations.
        step: between neighbours [rad].

    Returns:
        (k, d) polylines, not wrapped; a closed one ends where it begins, up to whole turns. None where a curve does
        not come to an end: equations that nearly hold on more than a curve (Sawyer) are not to be walked.
    """
    found: list[Array] = []
    left = np.array(seeds)
    while len(left):
        line = _line(system, base, list(joints), left[0], step)
        if len(line) > _MOST:
            return None
        if len(line) > 2:
            found.append(line)
        left = left[1:]
        for start in range(0, len(line), 256):
            gap = np.abs(wrap(left[:, None] - line[None, start : start + 256])).max(axis=2).min(axis=1, initial=np.inf)
            left = left[gap > step]
    return found


def closed(line: Array, step: float = STEP) -> bool:
    """Whether a curve comes back to where it began, up to whole turns."""
    return bool(np.abs(wrap(line[-1] - line[0])).max() < step / 2)


def _line(system: System, base: Array, joints: list[int], seed: Array, step: float) -> Array:
    def linear(x: Array) -> tuple[Array, Array]:
        q = np.repeat(base[None], len(x), axis=0)
        q[:, joints] = x
        f, slope = system.linear(q)
        return f, slope[..., joints]

    ahead, back_again = trace(linear, seed, step, zero=SOLVED, most=_MOST)
    if back_again:
        return ahead
    behind, _ = trace(linear, seed, step, zero=SOLVED, most=_MOST, sign=-1.0)
    return np.concatenate([behind[:0:-1], ahead])


CUBE_NODES = 23
"""Grid nodes along each side of the cube in which a surface is sought."""
SEEDS = 400
"""Random starts from which curves are walked."""
_SIDE = np.pi


@dataclass(frozen=True, eq=False)
class Solid:
    """One family in the cube of three joints.

    Attributes:
        family: its id.
        joints: numbers (from 1) of the three joints.
        q: (n,) values at which the others are held [rad, m].
        curves: (k, 3) polylines, not wrapped [rad]; empty where the family is a surface.
        closed: how many of them come back to where they began.
        vertices: (V, 3) of the surface [rad].
        triangles: (T, 3) indices of its vertices.
    """

    family: str
    joints: tuple[int, int, int]
    q: Array
    curves: tuple[Array, ...]
    closed: int
    vertices: Array
    triangles: NDArray[np.int64]


def solids(robot: Robot, task: Task, families: Sequence[Family], *, most: int = 3, seed: int = 0) -> tuple[Solid, ...]:
    """The families of corank 1 that tie three or more turning joints together, in the cube of the first three.

    A family with one equation in these joints is a surface there, with two of them a set of curves.

    Args:
        robot, task: the arm.
        families: of all coranks.
        most: solids at most.
        seed: of the values of the other joints and of all starts.

    Returns:
        One record per family that leaves something in its cube.
    """
    found: list[Solid] = []
    for family in families:
        turning = tuple(number for number in family.coupled if robot.periodic[number - 1])
        if family.corank == 1 and family.named and len(turning) >= 3 and len(found) < most:
            one = solid(robot, task, family, turning[:3], seed=seed)
            if one.curves or len(one.triangles):
                found.append(one)
    return tuple(found)


def solid(
    robot: Robot,
    task: Task,
    family: Family,
    joints: tuple[int, ...],
    *,
    seed: int = 0,
    nodes: int = CUBE_NODES,
) -> Solid:
    """One family in the cube of three turning joints; every vertex drawn is singular (σ ≤ `singular`).

    Args:
        robot, task: the arm.
        family: with equations.
        joints: three numbers from 1.
        seed: of the values of the other joints and of all starts.
        nodes: along each side.
    """
    problem = Problem(robot, task, family.corank)
    moving = [number - 1 for number in joints]
    q = general_member(robot, task, family, moving, seed)
    starts = np.repeat(q[None], SEEDS, axis=0)
    starts[:, moving] = problem.sample(SEEDS, seed)[:, moving]
    held = _held(family, starts, moving)
    basis = np.eye(robot.n)[:, moving]
    three = (joints[0], joints[1], joints[2])
    nothing = Solid(family.id, three, q, (), 0, np.empty((0, 3)), np.empty((0, 3), dtype=np.int64))
    if held is None:
        return nothing
    seeds, solved = held.solve(starts, along=basis)
    seeds = seeds[solved]
    seeds = seeds[problem.singular(seeds)]
    if not len(seeds):
        return nothing
    rank = int(np.median(np.linalg.matrix_rank(held.jacobian(seeds)[..., moving], tol=1e-5)))
    if rank == 2:
        lines = walk(held, q, moving, seeds[:, moving]) or []
        lines = [line for line in lines if problem.singular(_lifted(q, moving, line)).all()]
        return Solid(family.id, three, q, tuple(lines), sum(map(closed, lines)), nothing.vertices, nothing.triangles)
    if rank == 1 and len(held.equations) == 1:
        vertices, triangles = _sheet(problem, held, q, moving, nodes)
        return Solid(family.id, three, q, (), 0, vertices, triangles)
    return nothing


def _held(family: Family, q: Array, moving: list[int]) -> System | None:
    """The equations that say something where the other joints are held; None where one of them cannot hold."""
    kept = []
    for equation in family.equations:
        if {number - 1 for number in equation.joints} & set(moving):
            kept.append(equation)
        elif np.abs(equation(q[0])) > 1e-9:
            return None
    return System(tuple(kept))


def _lifted(q: Array, moving: list[int], points: Array) -> Array:
    full = np.repeat(q[None], len(points), axis=0)
    full[:, moving] = points
    return full


def _sheet(
    problem: Problem, held: System, q: Array, moving: list[int], nodes: int
) -> tuple[Array, NDArray[np.int64]]:
    """The surface, its vertices polished; triangles with a vertex that is not singular are left out."""
    axis = np.linspace(-_SIDE, _SIDE, nodes)
    grid = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    values = held.equations[0](_lifted(q, moving, grid)).reshape(nodes, nodes, nodes)
    vertices, triangles = surface(values, (axis, axis, axis))
    if not len(triangles):
        return vertices, triangles
    ends, _ = held.solve(_lifted(q, moving, vertices), along=np.eye(problem.n)[:, moving], iterations=8)
    good = problem.singular(ends)
    good &= np.linalg.norm(ends[:, moving] - vertices, axis=1) < 2 * (axis[1] - axis[0])
    triangles = triangles[good[triangles].all(axis=1)]
    used, triangles = np.unique(triangles, return_inverse=True)
    return ends[used][:, moving], triangles.reshape(-1, 3)
