"""Circuits: inclusion-minimal dependent sets of joints, and what their axes look like."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from rankdrop.atlas.scene import Scene
from rankdrop.kinematics import task_jacobian
from rankdrop.robot.model import Array
from rankdrop.task import Task

_ZERO = 1e-7  # σ of unit columns below this: dependent. Points are polished to 1e-12; other sets stay far above


def circuits(columns: Array, generic: Array) -> Iterator[tuple[int, ...]]:
    """Circuits that the columns of all points share and that generic configurations do not have, small ones first.

    A set is a circuit when it is dependent and none of its subsets is: its smallest singular value is zero (columns
    scaled to unit length) at every point, and no circuit found before lies inside it.

    Args:
        columns: (N, m, n) task Jacobians at the points of a family.
        generic: (M, m, n) task Jacobians at random configurations.

    Returns:
        Tuples of indices from 0.
    """
    rows, n = columns.shape[1:]
    here, usual = _unit(columns), _unit(generic)
    found: list[frozenset[int]] = []
    for size in range(1, min(rows, n) + 1):
        for chosen in combinations(range(n), size):
            if any(circuit <= set(chosen) for circuit in found) or not _dependent(here[..., chosen]):
                continue
            found.append(frozenset(chosen))
            if not _dependent(usual[..., chosen]):
                yield chosen


def to_blame(scene: Scene, task: Task, generic: Array, corank: int) -> list[tuple[int, ...]]:
    """The smallest circuits that bring as many independent dependencies as rank is lost; fewer if there are no more."""
    columns = task_jacobian(scene.robot, scene.q, task)
    chosen: list[tuple[int, ...]] = []
    vectors: list[Array] = []
    for circuit in circuits(columns, generic):
        vector = np.zeros(columns.shape[2])
        vector[list(circuit)] = np.linalg.svd(columns[0][:, circuit])[2][-1]
        if np.linalg.matrix_rank(np.array([*vectors, vector]), tol=1e-6) > len(vectors):
            chosen.append(circuit)
            vectors.append(vector)
        if len(chosen) == corank:
            break
    return chosen


def describe(scene: Scene, circuit: tuple[int, ...], task: Task) -> str:
    """A circuit in words: what its axes have in common, where they are axes and the task takes all six rows.

    Two dependent axes are one line; three lie in one plane and meet in one point or are parallel; four that all meet,
    are all parallel or lie in one plane span a system of rank 3.
    """
    names = _numbers(circuit)
    if len(circuit) == 1:
        return f"joint {names} moves nothing"
    if task.m < 6 or not set(circuit) <= set(scene.axes):
        return f"{'screws' if task.m == 6 else 'joints'} {names} dependent"
    if len(circuit) == 2:
        return f"axes {names} aligned"
    parallel = all(scene.parallel(circuit[0], i).all() for i in circuit[1:])
    concurrent = bool(scene.common_point(circuit)[1].all())
    coplanar = bool(scene.coplanar(circuit).all())
    if len(circuit) == 3 and coplanar and (parallel or concurrent):
        return f"axes {names} {'parallel' if parallel else 'concurrent'} and coplanar"
    for told, word in ((parallel, "parallel"), (concurrent, "concurrent"), (coplanar, "coplanar")):
        if told:
            return f"axes {names} {word}"
    return f"screws {names} dependent"


def line_meets_all(scene: Scene, task: Task) -> bool:
    """Is there a line that meets every axis (or is parallel to it) at every point of the scene?

    The blocked wrench (f; τ) of a corank-1 point, f·v_i + τ·ω_i = 0 for every joint, is a pure force along that line
    when its pitch f·τ/|f|² is zero: a force does no work on a rotation about an axis it meets. In a task without
    rotation the wrench is always a force, through the tip.
    """
    jacobians = task_jacobian(scene.robot, scene.q, task)
    if len(scene.axes) < scene.robot.n:
        return False
    left = np.linalg.svd(jacobians)[0][..., -1]  # (N, m)
    wrench = np.zeros((len(left), 6))
    wrench[:, list(task.rows)] = left
    force, moment = wrench[:, :3], wrench[:, 3:]  # both without unit: moment per length scale
    pitch = np.abs(np.einsum("ni,ni->n", force, moment))
    return bool((pitch < 1e-6).all() and (np.linalg.norm(force, axis=1) > 1e-6).all())


def _unit(columns: Array) -> Array:
    """Columns of length 1; those shorter than rounding are left as they are."""
    length = np.linalg.norm(columns, axis=-2, keepdims=True)
    return columns / np.where(length > _ZERO, length, 1.0)


def _dependent(columns: Array) -> bool:
    return bool((np.linalg.svd(columns, compute_uv=False)[..., -1] < _ZERO).all())


def _numbers(circuit: tuple[int, ...]) -> str:
    """ "2–6" for a run of three or more, "1, 3, 4" otherwise, numbers from 1."""
    if len(circuit) > 3 and circuit[-1] - circuit[0] == len(circuit) - 1:
        return f"{circuit[0] + 1}–{circuit[-1] + 1}"
    return ", ".join(str(i + 1) for i in circuit)
