"""AM's treatment of ties in numbers: gradients of tied singular values, and what turning their vectors does to them.

The searches themselves (AM eq. 11, with and without the treatment) are `rankdrop.families.searching.refine` with the
methods "gradient" and "almarkhi", in the core.

One singular value brought down where it may tie with the smaller ones: what `minimax` is told of it.

The values are σ[rank] and all smaller ones, the tensor is that of their singular vectors (AM eqs 7 and 12), so that a
crease is told from a local minimum: on a crease some mixture of gradients leads down, at a minimum none does.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.local.block import block, decompose
from rankdrop.local.minimax import EFFORT, Evaluate, Lowest, Model, descend, promised
from rankdrop.problem import Mask, Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task


def gradient_tensor(robot: Robot, q: ArrayLike, task: Task, rank: int) -> tuple[Array, Array]:
    """(..., min(m, n)) singular values, and (..., k, k, n) u_aᵀ ∂J/∂θ v_b of the k = min(m, n) − rank from σ[rank] on.

    The diagonal holds the gradients ∇σ_a (AM eq. 7), the rest what rotations of tied singular vectors need (eq. 12).

    Args:
        robot: the arm.
        q: (..., n) configurations [rad or m].
        task: from `resolve_task`.
        rank: of the first singular value, counted from 0.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
        OptionError: there is no such singular value.
    """
    at, parts = block(robot, q, task, rank), decompose(robot, q, task)
    count = at.sigma.shape[-1]
    turned = np.swapaxes(at.v2, -1, -2) @ parts.v[..., rank:count]  # a block's V₂ has a basis of its own
    return at.sigma, np.einsum("...asn,...sb->...abn", at.d[..., : count - rank, :, :], turned)


def tied_gradients(tensor: Array, rotation: Array) -> Array:
    """(k, n) gradients of k tied singular values in turned singular vectors: g_p = Σ_ab R_ap R_bp u_aᵀ dJ v_b (eq. 12).

    Args:
        tensor: (k, k, n) the tied part of `gradient_tensor`.
        rotation: (k, k) orthogonal, new vectors as columns.
    """
    return np.asarray(np.einsum("ap,bp,abn->pn", rotation, rotation, tensor))


def plane_rotation(count: int, a: int, b: int, phi: float) -> Array:
    """(count, count) AM's eq. 12 in the plane of vectors a and b."""
    turned = np.eye(count)
    turned[a, a] = turned[b, b] = np.cos(phi)
    turned[b, a], turned[a, b] = np.sin(phi), -np.sin(phi)
    return turned


def spread(gradients: Array) -> float:
    """H, the sum of the angles between all pairs of gradients [rad] (AM eq. 14)."""
    count = len(gradients)
    return sum(_angle(gradients[i], gradients[j]) for i in range(count) for j in range(i + 1, count))


def _angle(one: Array, other: Array) -> float:
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    return float(np.arccos(np.clip(one @ other / size, -1.0, 1.0))) if size > 0.0 else 0.0


FLAT = 1e-8
"""Fall of σ that a step of about the length of its slope has to promise, for a place to be no local minimum [1]. A line
search that ends for want of a fall of 1e-12 leaves promises of about that size at smooth minima."""


def tied_model(problem: Problem) -> Evaluate:
    """σ[rank], σ[rank + 1], … as one block, per scaled joint motion q / `Problem.scale`."""
    robot, task, rank, scale = problem.robot, problem.task, problem.rank, problem.scale

    def evaluate(scaled: Array) -> Model:
        sigma, tensor = gradient_tensor(robot, scaled * scale, task, rank)
        both = (tensor + tensor.swapaxes(1, 2)) / 2 * scale
        return sigma[:, None, rank:], both[:, None]

    return evaluate


def stays_up(problem: Problem, q: Array) -> Mask:
    """(B,) whether no mixture of gradients leads down from (B, n) configurations: local minima, to first order."""
    if not len(q):
        return np.zeros(0, dtype=np.bool_)
    scale, box = problem.scale, _box(problem)
    values, tensor = tied_model(problem)(q / scale)
    if box is not None:  # joints at a limit that σ pushes outward do not count
        gradient = np.einsum("baan->bn", tensor[:, 0][:, :1, :1])
        at = ((q / scale <= box[0]) & (gradient > 0.0)) | ((q / scale >= box[1]) & (gradient < 0.0))
        tensor = np.where(at[:, None, None, None, :], 0.0, tensor)
    return np.asarray(promised(values, tensor, np.ones(len(q))).most <= FLAT)


def brought_down(problem: Problem, q: Array, *, iterations: int = 200, effort: int = EFFORT) -> Lowest:
    """σ[rank] descended from (B, n) configurations to where it is least nearby; `q` of the result in rad and m."""
    scale = problem.scale
    found = descend(tied_model(problem), q / scale, _box(problem), iterations=iterations, effort=effort)
    return Lowest(found.q * scale, found.value, found.slope, found.iterations)


def _box(problem: Problem) -> tuple[Array, Array] | None:
    """Where the scaled joints may go; None where no limits are asked for."""
    if problem.walls is None:
        return None
    low, high = problem.walls
    return low / problem.scale, high / problem.scale
