"""The singular set in two or three joints, the others held (AM Figure 5): curves and points of a plane, curves and
surfaces of a cube.

Zero sets of functions given on a grid: curves in a plane (marching squares), surfaces in space (tetrahedra). Curves in
space are walked step by step along their tangent (`rankdrop.solve.trace`), in the coordinates of the slice. Where so
many joints are held that nothing larger than curves is left, these are traced whatever family they are of: at a
singular configuration of corank k the block F = U₂ᵀJV₂ vanishes, and a joint motion Δ keeps it zero to first order
where D(Δ) = 0. Along a line of joint space, one joint swept, singular values are given.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import permutations
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.errors import OptionError
from rankdrop.families.points import general_member, set_joints
from rankdrop.families.record import Family
from rankdrop.families.rescaling import family_in_metres
from rankdrop.families.searching import search
from rankdrop.formula.equation import SOLVED, System
from rankdrop.kinematics import one_configuration
from rankdrop.local.block import generic_rank, sampling_box, singular_values
from rankdrop.problem import Mask, Problem, wrap_joints
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.solve import curves_through, newton
from rankdrop.task import Task, resolve_task
from rankdrop.units import in_metres, into_metres, out_of_metres, task_in_metres

Ints = NDArray[np.int64]

NODES = 161
"""Grid nodes along each side of a slice."""
BEYOND = 0.035
"""A slice shows this share of a turn beyond ±π, so that what lies at π is inside the frame."""
_SEEDS = 18  # along each side, where points are solved for
_NOTHING = 1e-9  # an equation below this on the whole slice says nothing there
_MOST_POINTS = 400

STEP = 0.07
"""Between neighbours on a curve [rad]."""
_MOST = 600  # steps of one curve: seven turns; one that is longer does not come to an end

CUBE_NODES = 23
"""Grid nodes along each side of the cube in which a surface is sought."""
SEEDS = 400
"""Random starts from which curves are walked."""
_SIDE = np.pi

_ON = 1e-11  # |F| at a point of the set [1]
_LONGEST = 200.0  # of a curve that does not come to an end [rad]
_CORRECTIONS = 12


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
    cells = []
    count = above.sum(axis=1)
    for single, lone in ((1, True), (3, False)):
        rows = nodes[count == single]
        order = np.argsort(above[count == single] != lone, axis=1, kind="stable")
        rows = np.take_along_axis(rows, order, axis=1)
        cells.append(np.stack([np.stack([rows[:, 0], rows[:, k]], axis=1) for k in (1, 2, 3)], axis=1))
    rows = nodes[count == 2]
    rows = np.take_along_axis(rows, np.argsort(~above[count == 2], axis=1, kind="stable"), axis=1)
    p = [np.stack([rows[:, i], rows[:, k]], axis=1) for i, k in ((0, 2), (0, 3), (1, 3), (1, 2))]
    cells.append(np.stack([p[0], p[1], p[2]], axis=1))
    cells.append(np.stack([p[0], p[2], p[3]], axis=1))
    return np.concatenate(cells)


@dataclass(frozen=True, eq=False)
class SliceTrace:
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
    traces: tuple[SliceTrace, ...]
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
    cuts: list[Slice] = []
    if robot.n < 2:
        return ()
    for family in families:
        if family.corank != 1 or not family.named or len(cuts) == most:
            continue
        joints = telling_joints(robot, family)
        shown = {trace.family for cut in cuts if set(cut.joints) == set(joints) for trace in cut.traces}
        if family.id in shown:
            continue
        q = general_member(robot, task, family, [number - 1 for number in joints], seed, families)
        cuts.append(slice_through(robot, task, families, q, joints, family=family.id))
    return tuple(cuts)


def telling_joints(robot: Robot, family: Family) -> tuple[int, int]:
    """Two joints (from 1) in whose plane a family shows: tied together, else pinned, else pinned and a neighbour."""
    pinned = [pin.number for pin in family.pinned]
    if len(family.coupled) > 1:
        order = [*family.coupled, *pinned]
    else:
        order = [*pinned, *family.coupled]
    inner = [number for number in range(2, robot.n) if number not in order]
    outer = [number for number in (1, robot.n) if number not in order]
    if order:
        order += sorted(inner, key=lambda number: abs(number - order[0])) + outer
    else:
        order += [*inner, *outer]
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
    problem = Problem(in_metres(robot), task_in_metres(task, robot))
    here, moving = into_metres(robot, q), (joints[0] - 1, joints[1] - 1)
    x, y = (_values(problem, j, here[j], nodes) for j in moving)
    plane = _SlicePlane(problem, here, moving, x, y)
    units = out_of_metres(robot, np.ones(robot.n))[list(moving)]
    traces, filled = [], []
    for shown in families:
        if shown.named and shown.equations:
            trace = plane.trace(family_in_metres(shown, robot))
            if trace is None:
                filled.append(shown.id)
            elif trace.curves or len(trace.points):
                lines = tuple(curve * units for curve in trace.curves)
                traces.append(replace(trace, curves=lines, points=trace.points * units))
    return Slice(
        joints, np.array(q), family, x * units[0], y * units[1], plane.sigma(), tuple(traces), tuple(filled)
    )


def _values(problem: Problem, j: int, at: float, nodes: int) -> Array:
    """A whole turn, or the travel and what q needs beyond it, with some room on either side."""
    low, high = (end[j] for end in problem.box)
    if problem.robot.periodic[j]:
        low, high = (-np.pi, np.pi)
    else:
        low, high = (min(low, at), max(high, at))
    room = BEYOND * (high - low)
    return np.linspace(low - room, high + room, nodes)


@dataclass(frozen=True, eq=False)
class _SlicePlane:
    problem: Problem
    q: Array
    moving: tuple[int, int]
    x: Array
    y: Array

    def nodes(self) -> Array:
        """(a·b, n)."""
        grid = np.stack(np.meshgrid(self.x, self.y, indexing="ij"), axis=-1)
        return set_joints(self.q, self.moving, grid.reshape(-1, 2))

    def sigma(self) -> Array:
        smallest = self.problem.sigma(self.nodes())[:, self.problem.generic_rank - 1]
        return np.asarray(smallest.reshape(len(self.x), len(self.y)))

    def trace(self, family: Family) -> SliceTrace | None:
        """What the family leaves in the plane; None where it contains all of it."""
        nodes, telling = self.nodes(), []
        for equation in family.equations:
            values = equation(nodes)
            if np.abs(values).max() <= _NOTHING:
                continue
            if values.min() > 0 or values.max() < 0:
                return SliceTrace(family.id, (), np.empty((0, 2)))
            telling.append((equation, values.reshape(len(self.x), len(self.y))))
        if not telling:
            return None
        system = System(tuple(equation for equation, _ in telling))
        if len(telling) > 1:
            return SliceTrace(family.id, (), self._isolated_points(system, family))
        lines: list[Array] = []
        for line in curves(telling[0][1], self.x, self.y):
            lines += self._project_line(line, system, family)
        return SliceTrace(family.id, tuple(lines), np.empty((0, 2)))

    def _project_line(self, line: Array, system: System, family: Family) -> list[Array]:
        """The line brought onto the zero set, and cut where a vertex is not singular."""
        ends, _ = system.solve(set_joints(self.q, self.moving, line), along=self._basis(), iterations=8)
        points = ends[:, list(self.moving)]
        cell = 1.5 * np.array([self.x[1] - self.x[0], self.y[1] - self.y[0]])
        good = (np.abs(points - line) <= cell).all(axis=1)
        good &= self.problem.at(family.corank).singular(ends)
        parts = np.split(points, np.flatnonzero(~good))
        kept = [part if good[start] else part[1:] for part, start in
                zip(parts, [0, *np.flatnonzero(~good)], strict=True)]  # fmt: skip
        return [part for part in kept if len(part) > 1]

    def _isolated_points(self, system: System, family: Family) -> Array:
        """Isolated points, from a grid of starts."""
        starts = np.stack(np.meshgrid(*(np.linspace(v[0], v[-1], _SEEDS) for v in (self.x, self.y))), axis=-1)
        ends, solved = system.solve(set_joints(self.q, self.moving, starts.reshape(-1, 2)), along=self._basis())
        ends = wrap_joints(self.problem.robot, ends[solved])
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
        if len(points):
            return points[np.unique(np.round(points, 5), axis=0, return_index=True)[1]]
        return points

    def _basis(self) -> Array:
        return np.eye(self.problem.n)[:, list(self.moving)]


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
    solids: list[Solid] = []
    for family in families:
        turning = tuple(number for number in family.coupled if robot.periodic[number - 1])
        if family.corank == 1 and family.named and len(turning) >= 3 and len(solids) < most:
            cut = solid(robot, task, family, turning[:3], seed=seed)
            if cut.curves or len(cut.triangles):
                solids.append(cut)
    return tuple(solids)


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
    starts = set_joints(q, moving, problem.sample(SEEDS, seed)[:, moving])
    held = _equations_in_plane(family, starts, moving)
    basis = np.eye(robot.n)[:, moving]
    nowhere = np.empty((0, 3))
    nothing = Solid(family.id, (joints[0], joints[1], joints[2]), q, (), 0, nowhere, nowhere.astype(np.int64))
    if held is None:
        return nothing
    seeds, solved = held.solve(starts, along=basis)
    seeds = seeds[solved]
    seeds = seeds[problem.singular(seeds)]
    if not len(seeds):
        return nothing
    rank = int(np.median(np.linalg.matrix_rank(held.jacobian(seeds)[..., moving], tol=1e-5)))
    if rank == 2:
        lines = _curves(problem, held, q, moving, seeds)
        return replace(nothing, curves=tuple(line for line, _ in lines), closed=sum(closed for _, closed in lines))
    if rank == 1 and len(held.equations) == 1:
        vertices, triangles = _sheet(problem, held, q, moving, nodes)
        return replace(nothing, vertices=vertices, triangles=triangles)
    return nothing


def _equations_in_plane(family: Family, q: Array, moving: list[int]) -> System | None:
    """The equations that say something where the other joints are held; None where one of them cannot hold."""
    kept = []
    for equation in family.equations:
        if {number - 1 for number in equation.joints} & set(moving):
            kept.append(equation)
        elif np.abs(equation(q[0])) > 1e-9:
            return None
    return System(tuple(kept))


def _curves(
    problem: Problem, held: System, q: Array, moving: list[int], seeds: Array
) -> list[tuple[Array, bool]]:
    """The curves through seeds (N, n) that are singular throughout, and whether they close.

    None where the equations are nearly solved on more than a curve (Sawyer).
    """

    def linear(x: Array) -> tuple[Array, Array]:
        f, slope = held.linear(set_joints(q, moving, x))
        return f, slope[..., moving]

    lines = curves_through(linear, seeds[:, moving], STEP, zero=SOLVED, most=_MOST)
    if any(len(line) > _MOST for line, _ in lines):
        return []
    return [line for line in lines if len(line[0]) > 2 and problem.singular(set_joints(q, moving, line[0])).all()]


def _sheet(
    problem: Problem, held: System, q: Array, moving: list[int], nodes: int
) -> tuple[Array, NDArray[np.int64]]:
    """The surface, its vertices polished; triangles with a vertex that is not singular are left out."""
    axis = np.linspace(-_SIDE, _SIDE, nodes)
    grid = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    values = held.equations[0](set_joints(q, moving, grid)).reshape(nodes, nodes, nodes)
    vertices, triangles = surface(values, (axis, axis, axis))
    if not len(triangles):
        return vertices, triangles
    ends, _ = held.solve(set_joints(q, moving, vertices), along=np.eye(problem.n)[:, moving], iterations=8)
    good = problem.singular(ends)
    good &= np.linalg.norm(ends[:, moving] - vertices, axis=1) < 2 * (axis[1] - axis[0])
    triangles = triangles[good[triangles].all(axis=1)]
    used, triangles = np.unique(triangles, return_inverse=True)
    return ends[used][:, moving], triangles.reshape(-1, 3)


@dataclass(frozen=True, eq=False)
class Sweep:
    """One joint swept through a configuration.

    Attributes:
        number: the joint, from 1.
        unit: "rad" or "m".
        at: its value in the configuration.
        values: (N,) its values, increasing; `at` is one of them.
        sigma: (N, r) singular values σ_1 … σ_r there, descending, r the generic rank.
    """

    number: int
    unit: str
    at: float
    values: Array
    sigma: Array


def sweeps(robot: Robot, q: ArrayLike, task: Task, count: int = 121) -> tuple[Sweep, ...]:
    """Singular values with each joint swept in turn: a whole turn about q, or the travel of a slide.

    Args:
        robot, task: the arm.
        q: (n,) [rad, m].
        count: values of each joint, one more where the configuration's own is not among them.

    Returns:
        One `Sweep` per joint.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
    """
    centre = one_configuration(robot, q)
    low, high = sampling_box(robot, task, limits=False)
    rank = generic_rank(robot, task)
    sweeps = []
    for j, joint in enumerate(robot.variables):
        if robot.periodic[j]:
            begin, end = (-np.pi, np.pi)
        else:
            begin, end = (min(low[j], centre[j]), max(high[j], centre[j]))
        values = np.union1d(np.linspace(begin, end, count), [centre[j]])
        line = np.repeat(centre[None], len(values), axis=0)
        line[:, j] = values
        sigma = singular_values(robot, line, task)[:, :rank]
        sweeps.append(Sweep(j + 1, joint.unit, float(centre[j]), values, sigma))
    return tuple(sweeps)


@dataclass(frozen=True, eq=False)
class SingularCurve:
    """One traced piece of the singular set.

    Attributes:
        q: (N, n) configurations in order; angles run on, they are not wrapped [rad].
        closed: it came back to its start (angles modulo 2π).
        length: in joint space [rad].
        windings: (n,) turns that each joint makes on the way round; zero where not closed.
    """

    q: Array
    closed: bool
    length: float
    windings: tuple[int, ...]


def singular_curves(
    robot: Robot, joints: Sequence[int], *, held: ArrayLike | None = None, corank: int = 1,
    task: Task | str | None = None, starts: int = 200, step: float = 0.05,
) -> tuple[SingularCurve, ...]:  # fmt: skip
    """Every curve of singular configurations that random starts meet, longest first.

    Args:
        robot: an arm of revolute joints.
        joints: numbers (from 1) of those that move; the others stay where `held` has them.
        held: (n,) configuration [rad]; zeros if None.
        corank: task freedoms lost.
        task: name, `Task`, or None for the task the arm is made for.
        starts: of the search that gives the first points.
        step: between two points of a curve [rad].

    Raises:
        OptionError: a joint that does not turn, or that there is not.
        ConfigurationError: `held` is not one configuration of this arm.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> [(curve.closed, curve.windings) for curve in singular_curves(open_robot("almarkhi4"), (2, 3, 4))][0]
        (True, (0, 1, 0, 0))
    """
    moving = [number - 1 for number in joints]
    if not moving or not set(moving) <= set(range(robot.n)):
        raise OptionError("there is no such joint", got=list(joints), allowed=f"1 … {robot.n}")
    if any(robot.variables[j].kind is not JointKind.REVOLUTE for j in range(robot.n)):
        raise OptionError("curves are traced of revolute joints only", where=f"robot {robot.name!r}")
    resolved = resolve_task(task, robot)
    base = one_configuration(robot, np.zeros(robot.n) if held is None else held)
    problem = Problem(robot, resolved, corank)

    def linear(x: Array) -> tuple[Array, Array]:
        """F as a vector, and its derivative by the joints that move."""
        at = problem.block(set_joints(base, moving, x))
        return at.f.reshape(len(x), -1), at.d[..., moving].reshape(len(x), -1, len(moving))

    def slice_residual(x: Array) -> tuple[Mask, Array, Array]:
        f, slope = linear(x)
        return np.abs(f).max(axis=1) > _ON, f, slope

    if len(moving) == 1:
        return ()
    seeds = search(robot, corank, task=resolved, starts=starts).converged[:, moving]
    seeds = newton(slice_residual, seeds, iterations=_CORRECTIONS)
    seeds = seeds[np.abs(linear(seeds)[0]).max(axis=1) <= _ON]
    most = int(_LONGEST / step)
    lines = curves_through(linear, seeds, step, zero=_ON, most=most)
    curves = [_curve(set_joints(base, moving, line), closed) for line, closed in lines if closed or len(line) > most]
    return tuple(sorted(curves, key=lambda curve: -curve.length))


def _curve(q: Array, closed: bool) -> SingularCurve:
    """A curve with its turns, the first of them forwards."""
    turns = np.round((q[-1] - q[0]) / (2 * np.pi)).astype(int) * closed
    if turns.any() and turns[np.flatnonzero(turns)[0]] < 0:
        q, turns = q[::-1].copy(), -turns
    q.flags.writeable = False
    length = float(np.linalg.norm(np.diff(q, axis=0), axis=1).sum())
    return SingularCurve(q, closed, length, tuple(int(turn) for turn in turns))
