"""Points that a search calls singular, followed down with 50 digits: is the rank really lost there?

A search counts σ ≤ 1e-9 as zero. An arm a few micrometres away from a special structure has whole surfaces with a
smaller σ, and these are no singularities. Points on no family are therefore followed down with 50 digits. For a kept
rank r, with U and V from the point in double precision,

    S(q) = A₂₂ − A₂₁ A₁₁⁻¹ A₁₂,  A = Uᵀ J(q) V,

vanishes exactly where rank J ≤ r. S is worked out with 50 digits and its derivative D in double precision, so that
Newton's steps −D⁺S gain about 15 digits each where D has full rank, and halve y where D vanishes with y, S being y². At
a minimum S is orthogonal to the range of D, and the steps end there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.searching import refine
from rankdrop.problem import Mask, Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, link_index

POLISHED = 1e-15  # σ of a polished point [1]
ROUNDING = 1e-15  # σ below this is zero to the precision of the arm's own numbers
DIGITS = 50
FURTHER = 1e-2  # a singular configuration farther away says nothing about a point [rad]
FOLLOWED = 48
"""Points on no family, of one corank, that are followed with `DIGITS` digits: 0.05 s each."""
_STEPS = 60
_LONGEST = 0.05  # of a step [rad; slides divided by the length scale]
_RESTING = 1e-9  # a shorter step that makes σ no smaller ends on a minimum
_ZERO = 1e-25  # σ at which a descent ends [1]
_CUTS = (1e-8, 1e-13)  # singular values of D below this share of the largest are left out: tried one after the other
Numbers = NDArray[Any]
"""An array of `flint.arb`."""


def verify_points(problem: Problem, q: Array, iterations: int = 8) -> Array:
    """Singular points driven on to σ ≤ 1e-15: signatures of arms that are nearly special need it."""
    if not len(q):
        return q
    finer = replace(problem.tolerances, target=POLISHED)
    solved = refine(
        problem.robot, q, problem.corank, task=problem.task, limits=problem.limits, iterations=iterations,
        tolerances=finer,
    )  # fmt: skip
    better = solved.sigma[:, problem.rank] <= problem.tolerances.singular
    return np.where(better[:, None], solved.q, q)


def not_singular(problem: Problem, q: Array, on_family: Callable[[Array], Mask]) -> tuple[Mask, float]:
    """Points on no family that are not singular, and how small σ is next to them.

    Args:
        problem: the arm, and the corank.
        q: (N, n) points with σ[rank] ≤ `singular` that no family explains.
        on_family: (N,) which of configurations (N, n) lie on a family.

    Returns:
        (N,) the points next to which there is no singular configuration, or only one on a family. All of them, where
        none of `FOLLOWED` is singular; else those alone that were followed. The smallest minimum of σ that is not zero;
        inf without one.
    """
    wrong = np.zeros(len(q), dtype=np.bool_)
    if not len(q):
        return wrong, np.inf
    order = np.argsort(problem.sigma(q)[:, problem.rank], kind="stable")
    chosen = order[np.unique(np.linspace(0, len(q) - 1, FOLLOWED).round().astype(int))]
    ends = [descents(problem, point) for point in q[chosen]]
    at = np.array([[end for end, _ in both] for both in ends])  # (chosen, descents, n)
    sigma = np.array([[least for _, least in both] for both in ends])
    near = (sigma <= ROUNDING) & (problem.length(at - q[chosen][:, None]) <= FURTHER)
    known = np.zeros_like(near)
    known[near] = on_family(at[near])
    new = near.any(axis=1) & ~known.any(axis=1)
    wrong[chosen[~new] if new.any() else slice(None)] = True
    lowest = sigma.min(axis=1)
    return wrong, float(lowest[lowest > ROUNDING].min(initial=np.inf))


def descents(problem: Problem, q: Array) -> list[tuple[Array, float]]:
    """Where Newton's method with 50 digits ends from q (n,), and σ[rank] there, for each of `_CUTS`.

    With the larger one it stays near where D has small singular values, with the smaller one it follows them. Without
    python-flint: q itself, and σ in double precision.
    """
    try:
        import flint
    except ImportError:
        return [(q, float(problem.sigma(q)[problem.rank]))]
    before = flint.ctx.dps
    flint.ctx.dps = DIGITS
    try:
        return [_descend_with_digits(problem, q, cut, flint) for cut in _CUTS]
    finally:
        flint.ctx.dps = before


def _descend_with_digits(problem: Problem, q: Array, cut: float, flint: Any) -> tuple[Array, float]:
    """`descents` with one of `_CUTS`, the number of digits set."""
    at = _exact(q, flint)
    best = (q, np.inf)
    for _ in range(_STEPS):
        near = _midpoints(at)
        local = problem.block(near)
        s = _complement(problem, at, local.u2, local.v2, flint)
        size = float(np.linalg.norm(s, 2))
        step = -np.linalg.pinv(np.asarray(local.d).reshape(-1, problem.n), rcond=cut) @ s.reshape(-1)
        length = float(problem.length(step))
        if size <= _ZERO or (length < _RESTING and size > best[1] * (1 - 1e-3)):
            if size < best[1]:
                return (near, size)
            return best
        best = (near, size) if size < best[1] else best
        at = np.array([x.mid() for x in at + _exact(step * min(1.0, _LONGEST / max(length, 1e-300)), flint)])
    return best


def _complement(problem: Problem, at: Numbers, u2: Array, v2: Array, flint: Any) -> Array:
    """S at a configuration (n,), rounded: its size is that of σ beyond the kept rank, as long as that is small."""
    u1, v1 = _other_directions(u2), _other_directions(v2)
    j = task_jacobian_exactly(problem.robot, problem.task, at, flint)
    a = _exact(np.hstack([u1, u2]).T, flint) @ j @ _exact(np.hstack([v1, v2]), flint)
    r = problem.rank
    if not r:
        return _midpoints(a)
    middle = flint.arb_mat(r, r, a[:r, :r].ravel().tolist()).solve(
        flint.arb_mat(r, a.shape[1] - r, a[:r, r:].ravel().tolist())
    )
    solved = np.array(middle.tolist(), dtype=object)
    return _midpoints(a[r:, r:] - a[r:, :r] @ solved)


def _other_directions(basis: Array) -> Array:
    """(m, m − k) orthonormal directions beside those of a basis (m, k)."""
    return np.asarray(np.linalg.svd(basis)[0][:, basis.shape[1] :])


def _exact(values: Array, flint: Any) -> Numbers:
    return np.asarray(np.vectorize(flint.arb, otypes=[object])(np.asarray(values, dtype=np.float64)))


def _midpoints(values: Numbers) -> Array:
    return np.asarray(np.vectorize(lambda x: float(x.mid()), otypes=[np.float64])(values), dtype=np.float64)


def task_jacobian_exactly(robot: Robot, task: Task, q: Numbers, flint: Any) -> Numbers:
    """(m, n) `kinematics.task_jacobian` at q (n,) in numbers of as many digits as `flint.ctx` has."""
    number = {joint.name: i for i, joint in enumerate(robot.variables)}
    pose = _exact(np.eye(4), flint)
    poses = [pose]
    columns: list[tuple[int, float, Numbers, Numbers]] = []
    for joint in robot.joints:
        index = number[joint.mimic.leader if joint.mimic else joint.name]
        if joint.mimic:
            factor, offset = (joint.mimic.multiplier, joint.mimic.offset)
        else:
            factor, offset = (1.0, 0.0)
        linear, axis = (pose[:3, :3] @ _exact(part, flint) for part in (joint.screw[:3], joint.screw[3:]))
        columns.append((index, factor, linear + np.cross(pose[:3, 3], axis), axis))
        pose = pose @ _exponential(joint.screw, q[index] * factor + offset, flint)
        poses.append(pose)
    poses.append(pose)
    last = len(robot.joints)
    homes = [np.eye(4), *(joint.frame for joint in robot.joints), robot.home]
    axes, origin = (link_index(link, last, "frame") for link in (task.frame.axes, task.frame.origin))
    point = poses[origin] @ _exact(homes[origin] @ np.append(task.frame.point, 1.0), flint)
    into = (poses[axes][:3, :3] @ _exact(homes[axes][:3, :3], flint)).T
    whole = np.full((6, robot.n), flint.arb(0), dtype=object)
    for index, factor, linear, axis in columns:
        whole[:3, index] += into @ (linear + np.cross(axis, point[:3])) * (factor / task.scale(robot))
        whole[3:, index] += into @ axis * factor
    return whole[list(task.rows)]


def _exponential(screw: Array, angle: Any, flint: Any) -> Numbers:
    """(4, 4) the motion exp(S·angle)."""
    twist = np.zeros((4, 4))
    twist[:3, :3], twist[:3, 3] = np.cross(screw[3:], np.eye(3)).T, screw[:3]
    moved = flint.arb_mat(4, 4, (_exact(twist, flint) * angle).ravel().tolist()).exp()
    return np.array(moved.tolist(), dtype=object)
