"""The singular set in three joints: curves and surfaces, the other joints held (AM Figure 5).

Curves are walked step by step along their tangent (`rankdrop.solve.trace`), in the coordinates of the slice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.slices import surface
from rankdrop.families.walk import general_member
from rankdrop.family.equation import SOLVED, System
from rankdrop.family.record import Family
from rankdrop.problem import Problem, wrap
from rankdrop.robot.model import Array, Robot
from rankdrop.solve import trace
from rankdrop.task import Task

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


NODES = 23
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
    nodes: int = NODES,
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
