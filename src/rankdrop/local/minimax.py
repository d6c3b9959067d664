"""Descent of a value that is the largest of several, where it has creases: singular values that tie, worst cases.

    F(q) = max over j of λ_max(A_j(q)),      A_j(q + Δ) ≈ diag(a_j) + Σ_k T_jk Δ_k

a_j are singular values, with a sign where the smallest is to be raised, and T_j = u_aᵀ ∂J/∂q_k v_b couples those that
may tie (AM eqs 7 and 12). F is smooth where one value is the largest, and has a crease where several are. The step
minimises the model with all of them in it,

    Δ = argmin  max_j λ_max(diag(a_j) + T_j·Δ) + ‖Δ‖²/2τ  = −τ G(Λ),      G(Λ)_k = Σ_j tr(Λ_j T_jk),

where Λ ⪰ 0, of traces that sum to 1, maximises Σ_j tr(Λ_j diag(a_j)) − τ/2 ‖G(Λ)‖²: the shortest of all mixtures of
gradients. It is zero exactly where F cannot fall to first order, on a crease or off it. AM's rotation (eq. 12) with
γ (eq. 13) looks among some of the mixtures; this takes the best of all of them.

AM's treatment of ties stands here in numbers: gradients of tied singular values, and what turning their vectors does to
them. Their searches themselves (eq. 11, with and without the treatment) are `rankdrop.families.searching.refine` with
the methods "gradient" and "almarkhi", in the core. One singular value is brought down where it may tie with the smaller
ones by the tensor of σ[rank] and all smaller ones, so that a crease is told from a local minimum: on a crease some
mixture of gradients leads down, at a minimum none does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from rankdrop import _core
from rankdrop.local.block import block, decompose
from rankdrop.problem import Mask, Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.transform import unit
from rankdrop.task import Task

Model = tuple[Array, Array]
"""(B, N, k) values a, and (B, N, k, k, n) their tensors T, of B configurations."""
Evaluate = Callable[[Array], Model]
_ROUNDS = 25  # of the accelerated projection on mixtures before it begins anew
EFFORT = 20
"""How often it may begin anew."""
_EXACT = 1e-15  # difference of two bounds that is rounding [1]
_LONGEST = 4.0  # τ: a step is at most so many times the shortest gradient [rad²]
_SHORTEST = 1e-12  # τ below which a step is lost in rounding
_ENOUGH = 1e-4  # share of the fall that the model promises which has to come true

Promise = tuple[Array, Array, Array, Array]
"""A step of the model: (B, n) Δ; (B,) fall of the model's F along it; (B,) what no step's fall less ‖Δ‖²/2τ can exceed,
near 0 where F cannot fall, however well Δ was found; (B, N, k, k) Λ."""

FLAT = 1e-8
"""Fall of σ that a step of about the length of its slope has to promise, for a place to be no local minimum [1]. A line
search that ends for want of a fall of 1e-12 leaves promises of about that size at smooth minima."""


@dataclass(frozen=True, eq=False)
class Lowest:
    """Where descents ended.

    Attributes:
        q: (B, n) configurations, in the unit of `joints` times rad.
        value: (B,) F there.
        slope: (B,) length of the shortest mixture of gradients: 0 where F cannot fall to first order.
    """

    q: Array
    value: Array
    slope: Array


def largest(values: Array) -> Array:
    """(B,) F."""
    return np.asarray(values.max(axis=(1, 2)))


def promised_step(
    values: Array, tensor: Array, tau: Array, mixed: Array | None = None, effort: int = EFFORT
) -> Promise:
    """The step from each of B configurations, and what it promises.

    Λ comes by accelerated projected gradient, begun anew every few rounds, until the step from it reaches nine tenths
    of what the best one can promise, which Λ itself bounds.

    Args:
        values: (B, N, k) a.
        tensor: (B, N, k, k, n) T, symmetric in the tied values.
        tau: (B,) τ.
        mixed: (B, N, k, k) Λ to begin from; None for all values alike.
        effort: how often the projection may begin anew.
    """
    count, pieces, k = values.shape
    if mixed is None:
        mixed = np.broadcast_to(np.eye(k) / (k * pieces), (count, pieces, k, k))
    arrays = [np.ascontiguousarray(array, dtype=np.float64) for array in (values, tensor, tau, mixed)]
    return _core.promised(*arrays, rounds=_ROUNDS, effort=effort, exact=_EXACT)


def descend(
    evaluate: Evaluate, q: Array, box: tuple[Array, Array] | None = None, *, iterations: int = 200,
    enough: float = 1e-12, effort: int = EFFORT,
) -> Lowest:  # fmt: skip
    """Bring F down from many configurations at once; F never rises.

    Args:
        evaluate: values and tensors at (B, n) configurations, per unit of q.
        q: (B, n) starts.
        box: lower and upper corner (n,) that no step leaves.
        iterations: most steps tried.
        enough: a start ends where no step can promise a greater fall than this.
        effort: most rounds of 25 spent on each step.
    """
    q = np.array(q, dtype=np.float64)
    values, tensor = evaluate(q)
    tau, slope, live = np.ones(len(q)), np.full(len(q), np.inf), np.ones(len(q), dtype=np.bool_)
    mixed = np.broadcast_to(np.eye(values.shape[2]) / values[0].size, tensor.shape[:4]).copy()
    for _ in range(iterations):
        rows = np.flatnonzero(live)
        if not len(rows):
            break
        model = (values[rows], tensor[rows], tau[rows], mixed[rows])
        step, fall, most, mixed[rows] = _promised_within(q[rows], *model, box, effort)
        slope[rows] = np.linalg.norm(step, axis=1) / tau[rows]
        if box is None:
            ahead = q[rows] + step
        else:
            ahead = np.clip(q[rows] + step, *box)
        there, turned = evaluate(ahead)
        before = largest(values[rows])
        better = before - largest(there) > np.maximum(_ENOUGH * fall, 0.0)
        q[rows[better]], values[rows[better]], tensor[rows[better]] = ahead[better], there[better], turned[better]
        tau[rows] = np.where(better, np.minimum(2.0 * tau[rows], _LONGEST), tau[rows] / 4.0)
        live[rows] = (tau[rows] > _SHORTEST) & (most > enough)
    return Lowest(q, largest(values), slope)


def _promised_within(
    q: Array, values: Array, tensor: Array, tau: Array, mixed: Array, box: tuple[Array, Array] | None, effort: int
) -> Promise:
    """`promised_step`, with joints that stand at the edge of the box held where the step would leave it."""
    promised = promised_step(values, tensor, tau, mixed, effort)
    if box is None:
        return promised
    held = np.zeros(q.shape, dtype=np.bool_)
    for _ in range(q.shape[1]):
        out = ((q <= box[0]) & (promised[0] < 0.0)) | ((q >= box[1]) & (promised[0] > 0.0))
        if not (out & ~held).any():
            break
        held |= out
        free = np.where(held[:, None, None, None, :], 0.0, tensor)
        promised = promised_step(values, free, tau, promised[3], effort)
    return promised


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
    directions = unit(gradients)
    angles = np.arccos(np.clip(directions @ directions.T, -1.0, 1.0))
    return float(np.triu(np.where(directions.any(axis=1), angles, 0.0), 1).sum())


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
    return np.asarray(promised_step(values, tensor, np.ones(len(q)))[2] <= FLAT)


def brought_down(problem: Problem, q: Array, *, iterations: int = 200, effort: int = EFFORT) -> Lowest:
    """σ[rank] descended from (B, n) configurations to where it is least nearby; `q` of the result in rad and m."""
    scale = problem.scale
    descent = descend(tied_model(problem), q / scale, _box(problem), iterations=iterations, effort=effort)
    return replace(descent, q=descent.q * scale)


def _box(problem: Problem) -> tuple[Array, Array] | None:
    """Where the scaled joints may go; None where no limits are asked for."""
    if problem.walls is None:
        return None
    low, high = problem.walls
    return low / problem.scale, high / problem.scale
