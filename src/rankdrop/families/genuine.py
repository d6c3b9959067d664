"""Singular points and near misses: which points with a small σ are singular, decided with 50 digits.

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
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.task import Task, link_index

POLISHED = 1e-15  # σ of a polished point [1]
ROUNDING = 1e-15  # σ below this is zero to the precision of the arm's own numbers
DIGITS = 50
FURTHER = 1e-2  # a singular configuration farther away says nothing about a point [rad]
_DECIDED = 48  # points that are followed with so many digits
_STEPS = 60
_LONGEST = 0.05  # of a step [rad; slides divided by the length scale]
_RESTING = 1e-9  # a shorter step that makes σ no smaller ends on a minimum
_ZERO = 1e-25  # σ at which a descent ends [1]
_CUTS = (1e-8, 1e-13)  # singular values of D below this share of the largest are left out: tried one after the other
Numbers = NDArray[Any]
"""An array of `flint.arb`."""


def polished(problem: Problem, q: Array, iterations: int = 8) -> Array:
    """Singular points driven on to σ ≤ 1e-15: signatures of arms that are nearly special need it."""
    if not len(q):
        return q
    finer = replace(problem.tolerances, target=POLISHED)
    found = refine(
        problem.robot, q, problem.corank, task=problem.task, limits=problem.limits, iterations=iterations,
        tolerances=finer,
    )  # fmt: skip
    better = found.sigma[:, problem.rank] <= problem.tolerances.singular
    return np.where(better[:, None], found.q, q)


def not_singular(problem: Problem, q: Array, on_family: Callable[[Array], Mask]) -> tuple[Mask, float]:
    """Points on no family that are not singular, and how small σ is next to them.

    Args:
        problem: the arm, and the corank.
        q: (N, n) points with σ[rank] ≤ `singular` that no family explains.
        on_family: (N,) which of configurations (N, n) lie on a family.

    Returns:
        (N,) the points next to which there is no singular configuration, or only one on a family. All of them, where
        none of `_DECIDED` is singular; else those alone that were followed. The smallest minimum of σ that is not zero;
        inf without one.
    """
    wrong = np.zeros(len(q), dtype=np.bool_)
    if not len(q):
        return wrong, np.inf
    order = np.argsort(problem.sigma(q)[:, problem.rank], kind="stable")
    chosen = order[np.unique(np.linspace(0, len(q) - 1, _DECIDED).round().astype(int))]
    ends = [descents(problem, one) for one in q[chosen]]
    at = np.array([[end for end, _ in both] for both in ends])  # (chosen, descents, n)
    sigma = np.array([[one for _, one in both] for both in ends])
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
        return [_descended(problem, q, cut, flint) for cut in _CUTS]
    finally:
        flint.ctx.dps = before


def _descended(problem: Problem, q: Array, cut: float, flint: Any) -> tuple[Array, float]:
    """`descents` with one of `_CUTS`, the number of digits set."""
    at = _exact(q, flint)
    best = (q, np.inf)
    for _ in range(_STEPS):
        near = _rounded(at)
        local = problem.block(near)
        s = _complement(problem, at, local.u2, local.v2, flint)
        size = float(np.linalg.norm(s, 2))
        step = -np.linalg.pinv(np.asarray(local.d).reshape(-1, problem.n), rcond=cut) @ s.reshape(-1)
        length = float(problem.length(step))
        if size <= _ZERO or (length < _RESTING and size > best[1] * (1 - 1e-3)):
            return (near, size) if size < best[1] else best
        best = (near, size) if size < best[1] else best
        at = np.array([x.mid() for x in at + _exact(step * min(1.0, _LONGEST / max(length, 1e-300)), flint)])
    return best


def _complement(problem: Problem, at: Numbers, u2: Array, v2: Array, flint: Any) -> Array:
    """S at a configuration (n,), rounded: its size is that of σ beyond the kept rank, as long as that is small."""
    u1, v1 = _others(u2), _others(v2)
    j = task_jacobian_exactly(problem.robot, problem.task, at, flint)
    a = _exact(np.hstack([u1, u2]).T, flint) @ j @ _exact(np.hstack([v1, v2]), flint)
    r = problem.rank
    if not r:
        return _rounded(a)
    middle = flint.arb_mat(r, r, a[:r, :r].ravel().tolist()).solve(
        flint.arb_mat(r, a.shape[1] - r, a[:r, r:].ravel().tolist())
    )
    solved = np.array(middle.tolist(), dtype=object)
    return _rounded(a[r:, r:] - a[r:, :r] @ solved)


def _others(basis: Array) -> Array:
    """(m, m − k) orthonormal directions beside those of a basis (m, k)."""
    return np.asarray(np.linalg.svd(basis)[0][:, basis.shape[1] :])


def _exact(values: Array, flint: Any) -> Numbers:
    return np.asarray(np.vectorize(flint.arb, otypes=[object])(np.asarray(values, dtype=np.float64)))


def _rounded(values: Numbers) -> Array:
    return np.asarray(np.vectorize(lambda x: float(x.mid()), otypes=[np.float64])(values), dtype=np.float64)


def task_jacobian_exactly(robot: Robot, task: Task, q: Numbers, flint: Any) -> Numbers:
    """(m, n) `kinematics.task_jacobian` at q (n,) in numbers of as many digits as `flint.ctx` has."""
    zero = flint.arb(0)
    turn, place = _exact(np.eye(3), flint), _exact(np.zeros(3), flint)
    number = {joint.name: i for i, joint in enumerate(robot.variables)}
    poses = [(turn, place)]
    columns: list[tuple[int, float, Numbers, Numbers]] = []
    for joint in robot.joints:
        index = number[joint.mimic.leader if joint.mimic else joint.name]
        factor, offset = (joint.mimic.multiplier, joint.mimic.offset) if joint.mimic else (1.0, 0.0)
        v, w = _exact(joint.screw[:3], flint), _exact(joint.screw[3:], flint)
        axis = turn @ w
        columns.append((index, factor, turn @ v + np.cross(place, axis), axis))
        moved, shift = _exponential(v, w, q[index] * factor + offset, joint.kind, flint)
        turn, place = turn @ moved, turn @ shift + place
        poses.append((turn, place))
    poses.append((turn, place))
    homes = [np.eye(4), *(joint.frame for joint in robot.joints), robot.home]
    last = len(robot.joints)
    axes, origin = (link_index(one, last, "frame") for one in (task.frame.axes, task.frame.origin))
    point = poses[origin][0] @ _exact(homes[origin][:3, :3] @ task.frame.point + homes[origin][:3, 3], flint)
    point = point + poses[origin][1]
    into = (poses[axes][0] @ _exact(homes[axes][:3, :3], flint)).T
    whole = np.full((6, robot.n), zero, dtype=object)
    for index, factor, linear, axis in columns:
        whole[:3, index] += into @ (linear + np.cross(axis, point)) * (factor / task.scale(robot))
        whole[3:, index] += into @ axis * factor
    return whole[list(task.rows)]


def _exponential(v: Numbers, w: Numbers, angle: Any, kind: JointKind, flint: Any) -> tuple[Numbers, Numbers]:
    """Rotation (3, 3) and translation (3,) of exp(S·angle), |w| = 1 unless the joint slides."""
    one = _exact(np.eye(3), flint)
    if kind is JointKind.PRISMATIC:
        return one, v * angle
    across = np.cross(w, one).T  # across @ x = w × x
    turn = one + across * flint.arb(angle).sin() + across @ across * (1 - flint.arb(angle).cos())
    return turn, (one - turn) @ np.cross(w, v) + w * (w @ v) * angle
