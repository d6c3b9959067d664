"""Steepest descent of one singular value with a step rule of its own: what AM's Figures 1 to 3 show.

    θ ← θ − α_k ∇σ/‖∇σ‖                                                      (AM eq. 11,
    the gradient brought to length 1)

AM do not print their rule for α_k. With an exact line search, which `search(method="gradient")` has, the gradients of
two successive iterations are at right angles where σ is smooth, so that the angles of 120° to 180° in AM's figures come
from steps that go beyond the minimum. The rule here knows the value that is sought, zero:

    α = f σ/‖∇σ‖       a share f of the step at whose end σ would be zero, were it linear

With f = 1 (Polyak's step) the angles average about 120° on the PA-10; so do steps 1.5 times those of a line search, and
whether AM did either is not known. With a small f, σ falls by the same share at every step until two singular values
tie; then steps cross from one side of the crease to the other.

`rotate=True` adds AM's treatment of ties: the singular vectors of the tied values are turned plane by plane until the
gradients are as nearly parallel as they get (eqs 12 and 14), and the best mixture of them is followed (eq. 13).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.local.block import block, decompose, generic_rank, singular_values
from rankdrop.local.verdict import one_configuration
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task

TIE = 1e-2
"""Relative gap below which two singular values count as tied."""
_PLANE_ANGLES = np.pi * np.arange(72) / 72  # tried for the rotation of a plane: AM do not say how they search
_MIXTURES = np.linspace(0.0, 1.0, 11)  # γ of eq. 13
_GRID = np.geomspace(1e-7, 1.5, 24)  # lengths tried to tell which mixture leads lowest [rad]
_FLAT = 1e-6  # a gradient shorter than this points nowhere: the step stays finite


@dataclass(frozen=True, eq=False)
class Descent:
    """One run.

    Attributes:
        q: (n,) where it ended [rad, m].
        sigma: (K + 1, min(m, n)) singular values before each iteration and at the end.
        angles: (K,) between the gradients followed in successive iterations [rad]; the first has none: NaN.
        lengths: (K,) of the steps [rad].
        rank: the singular value driven is σ[rank], counted from 0.
        converged: σ[rank] came down to the threshold.
    """

    q: Array
    sigma: Array
    angles: Array
    lengths: Array
    rank: int
    converged: bool

    @property
    def iterations(self) -> int:
        """Steps made."""
        return len(self.lengths)

    def first_tie(self, values: int = 2, gap: float = TIE) -> int | None:
        """First iteration at which σ[rank] and the next ones, `values` in all, are nearly equal; None if never."""
        near = self.sigma[:, self.rank] - self.sigma[:, self.rank + values - 1] < gap * self.sigma[:, self.rank]
        return int(np.flatnonzero(near)[0]) if near.any() else None


def descend(
    robot: Robot,
    q: ArrayLike,
    corank: int,
    *,
    share: float = 1.0,
    rotate: bool = False,
    task: Task | str | None = None,
    iterations: int = 3000,
    threshold: float = 1e-6,
) -> Descent:
    """Drive σ[generic rank − corank] towards zero from one configuration.

    Args:
        robot: revolute joints (a slide would need its unit weighed against the radian).
        q: (n,) start [rad].
        corank: number of task freedoms to lose.
        share: f, of the step at whose end σ would be zero, were it linear.
        rotate: AM's treatment of ties.
        task: name, `Task`, or None for the task the arm is made for.
        iterations: at most so many steps.
        threshold: AM's ε.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        TaskError: there is no such task.
        OptionError: no such corank.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = descend(open_robot("pa10"), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7], 1)
        >>> found.converged, bool(found.sigma[-1, 5] <= 1e-6)
        (True, True)
    """
    resolved = resolve_task(task, robot)
    here = one_configuration(robot, q).copy()
    rank = generic_rank(robot, resolved) - corank
    sigmas: list[Array] = []
    angles: list[float] = []
    lengths: list[float] = []
    before: Array | None = None
    while True:
        sigma, tensor = gradient_tensor(robot, here, resolved, rank)
        sigmas.append(sigma)
        if sigma[rank] <= threshold or len(lengths) == iterations:
            break
        tied = _tied(sigma, rank) if rotate else 1
        gradient = _along_tie(robot, resolved, rank, here, tensor[:tied, :tied]) if tied > 1 else tensor[0, 0]
        angles.append(np.nan if before is None else _angle(before, gradient))
        size = max(float(np.linalg.norm(gradient)), _FLAT)
        lengths.append(share * float(sigma[rank]) / size)
        here, before = here - lengths[-1] * gradient / size, gradient
    return Descent(
        here, np.array(sigmas), np.array(angles), np.array(lengths), rank, bool(sigmas[-1][rank] <= threshold)
    )


def gradient_tensor(robot: Robot, q: ArrayLike, task: Task, rank: int) -> tuple[Array, Array]:
    """(min(m, n),) singular values, and (m − rank, m − rank, n) u_aᵀ ∂J/∂θ v_b of those from σ[rank] on.

    The diagonal holds the gradients ∇σ_a (AM eq. 7), the rest what rotations of tied singular vectors need (eq. 12).
    """
    at, parts = block(robot, q, task, rank), decompose(robot, q, task)
    turned = at.v2.T @ parts.v[:, rank : len(parts.sigma)]  # a block's V₂ spans the space, in a basis of its own
    return at.sigma, np.einsum("asn,sb->abn", at.d, turned)


def _tied(sigma: Array, rank: int) -> int:
    """How many singular values from the driven one on are nearly equal."""
    return int(np.argmin(np.append(sigma[rank] - sigma[rank:] < TIE * sigma[rank], False)))


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


def _along_tie(robot: Robot, task: Task, rank: int, q: Array, tensor: Array) -> Array:
    """AM's direction at a tie: eqs 12 and 14 plane by plane, then eq. 13 value by value."""
    tied = len(tensor)
    rotation = np.eye(tied)
    for _ in range(1 if tied == 2 else 3):
        for a in range(tied):
            for b in range(a + 1, tied):
                turned = [rotation @ plane_rotation(tied, a, b, phi) for phi in _PLANE_ANGLES]
                rotation = min(turned, key=lambda one: spread(tied_gradients(tensor, one)))
    gradients = tied_gradients(tensor, rotation)
    followed = gradients[0]
    for other in gradients[1:]:
        mixed = _MIXTURES[:, None] * followed + (1.0 - _MIXTURES[:, None]) * other
        size = np.maximum(np.linalg.norm(mixed, axis=1), _FLAT)
        tried = q - _GRID[:, None, None] * (mixed / size[:, None])
        lowest = singular_values(robot, tried, task)[..., rank].min(axis=0)
        followed = mixed[int(np.argmin(lowest))]
    return np.asarray(followed)


def _angle(one: Array, other: Array) -> float:
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    return float(np.arccos(np.clip(one @ other / size, -1.0, 1.0))) if size > 0.0 else 0.0
