"""Descent of a value that is the largest of several, where it has creases: singular values that tie, worst cases.

    F(q) = max over j of λ_max(A_j(q)),      A_j(q + Δ) ≈ diag(a_j) + Σ_k T_jk Δ_k

a_j are singular values, with a sign where the smallest is to be raised, and T_j = u_aᵀ ∂J/∂q_k v_b couples those that
may tie (AM eqs 7 and 12). F is smooth where one value is the largest, and has a crease where several are. The step
minimises the model with all of them in it,

    Δ = argmin  max_j λ_max(diag(a_j) + T_j·Δ) + ‖Δ‖²/2τ  = −τ G(Λ),      G(Λ)_k = Σ_j tr(Λ_j T_jk),

where Λ ⪰ 0, of traces that sum to 1, maximises Σ_j tr(Λ_j diag(a_j)) − τ/2 ‖G(Λ)‖²: the shortest of all mixtures of
gradients. It is zero exactly where F cannot fall to first order, on a crease or off it. AM's rotation (eq. 12) with
γ (eq. 13) looks among some of the mixtures; this takes the best of all of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.robot.model import Array

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


@dataclass(frozen=True, eq=False)
class Lowest:
    """Where descents ended.

    Attributes:
        q: (B, n) configurations, in the unit of `joints` times rad.
        value: (B,) F there.
        slope: (B,) length of the shortest mixture of gradients: 0 where F cannot fall to first order.
        iterations: (B,) steps tried.
    """

    q: Array
    value: Array
    slope: Array
    iterations: NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Promise:
    """A step of the model.

    Attributes:
        step: (B, n) Δ.
        fall: (B,) of the model's F along it.
        most: (B,) what no step's fall less ‖Δ‖²/2τ can exceed: near 0 where F cannot fall, however well Δ was found.
        mixed: (B, N, k, k) Λ.
    """

    step: Array
    fall: Array
    most: Array
    mixed: Array


def largest(values: Array) -> Array:
    """(B,) F."""
    return np.asarray(values.max(axis=(1, 2)))


def promised(values: Array, tensor: Array, tau: Array, mixed: Array | None = None, effort: int = EFFORT) -> Promise:
    """The step from each of B configurations, and what it promises.

    Λ comes by accelerated projected gradient, begun anew every few rounds, until the step from it reaches nine tenths of
    what the best one can promise, which Λ itself bounds.

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
    return Promise(*_core.promised(*arrays, rounds=_ROUNDS, effort=effort, exact=_EXACT))


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
    tau, tried = np.ones(len(q)), np.zeros(len(q), dtype=np.intp)
    slope, live = np.full(len(q), np.inf), np.ones(len(q), dtype=np.bool_)
    mixed = np.broadcast_to(np.eye(values.shape[2]) / values[0].size, tensor.shape[:4]).copy()
    for _ in range(iterations):
        rows = np.flatnonzero(live)
        if not len(rows):
            break
        found = _inside(q[rows], values[rows], tensor[rows], tau[rows], mixed[rows], box, effort)
        slope[rows] = np.linalg.norm(found.step, axis=1) / tau[rows]
        mixed[rows] = found.mixed
        tried[rows] += 1
        ahead = q[rows] + found.step if box is None else np.clip(q[rows] + found.step, *box)
        there, turned = evaluate(ahead)
        before = largest(values[rows])
        better = before - largest(there) > np.maximum(_ENOUGH * found.fall, 0.0)
        q[rows[better]], values[rows[better]], tensor[rows[better]] = ahead[better], there[better], turned[better]
        tau[rows] = np.where(better, np.minimum(2.0 * tau[rows], _LONGEST), tau[rows] / 4.0)
        live[rows] = (tau[rows] > _SHORTEST) & (found.most > enough)
    return Lowest(q, largest(values), slope, tried)


def _inside(
    q: Array, values: Array, tensor: Array, tau: Array, mixed: Array, box: tuple[Array, Array] | None, effort: int
) -> Promise:
    """`promised`, with joints that stand at the edge of the box held where the step would leave it."""
    found = promised(values, tensor, tau, mixed, effort)
    if box is None:
        return found
    held = np.zeros(q.shape, dtype=np.bool_)
    for _ in range(q.shape[1]):
        out = ((q <= box[0]) & (found.step < 0.0)) | ((q >= box[1]) & (found.step > 0.0))
        if not (out & ~held).any():
            break
        held |= out
        free = np.where(held[:, None, None, None, :], 0.0, tensor)
        found = promised(values, free, tau, found.mixed, effort)
    return found
