"""What the failure of one joint leaves: the joint stands still, and its column is gone from the task Jacobian.

    J₋j = J without column j,       σ_r(J₋j) ≤ σ_r(J)                                  (a joint fewer never helps)
    ρ_j² = det(J₋j J₋jᵀ)/det(JJᵀ) = 1 − (J⁺J)_jj,       Σ_j ρ_j² = n − r                (J of full rank r)

ρ_j is the length of the part of joint j in the null space. Since the n numbers ρ_j² share n − r, the least of them is
at most (n − r)/n, and σ_r(J₋j) ≤ ρ_j σ_1(J) gives a bound on the worst case at every configuration of full rank,

    min_j σ_r(J₋j) ≤ √((n − r)/n) σ_1(J),

with equality where all singular values are equal and all ρ_j are: the optimum that AM's 4R arm was made for (its source
is Ben-Gharbia, Maciejewski and Roberts 2013). r is the generic rank of the whole arm: m, unless the arm is deficient.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.configuration import Configuration, configuration_at
from rankdrop.kinematics import task_jacobian, task_jacobian_derivative
from rankdrop.local.block import generic_rank, joint_scale, sigma_of, svd
from rankdrop.local.directions import FramedDirections, lost_without
from rankdrop.local.minimax import Evaluate, Model
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances

_TIED = 2  # smallest singular values of each reduced Jacobian that may tie on the way
_LARGEST = 3  # and largest ones of the whole one
_SMALLEST = 1e-300  # keeps a division by a Jacobian of zeros finite


@dataclass(frozen=True, eq=False)
class Failure:
    """One joint that stands still for good.

    Attributes:
        number, joint: which, from 1, and its name.
        sigma: (min(m, n − 1),) singular values of the task Jacobian without its column, descending [1].
        sigma_min: σ_r of them, r the generic rank of the whole arm; 0.0 where there are fewer.
        rank: number of them above the tolerance, at most r.
        share: ρ_j, what is left of √det(JJᵀ), from 0 to 1; 0.0 where the whole arm is singular.
        framed: the task motions that the other joints cannot make, as `lost_directions`, and the frame in which they
            are sparsest; None where the others can make all.
    """

    number: int
    joint: str
    sigma: Array
    sigma_min: float
    rank: int
    share: float
    framed: FramedDirections | None

    @property
    def lost(self) -> Array:
        """(r − rank, 6) task motions that the other joints cannot make, in the frame in which they are sparsest."""
        if self.framed is None:
            return np.zeros((0, 6))
        return self.framed.directions

    @property
    def lost_words(self) -> tuple[str, ...]:
        """The same in words."""
        if self.framed is None:
            return ()
        return self.framed.sentences()


@dataclass(frozen=True, eq=False)
class Failures:
    """Every single failure at one configuration.

    Attributes:
        single: one per joint, in order.
        generic_rank: r of the whole arm.
        sigma_min: σ_r of the whole arm here.
        bound: √((n − r)/n) σ_1: no worst case is above it here; None where the whole arm is singular.
    """

    single: tuple[Failure, ...]
    generic_rank: int
    sigma_min: float
    bound: float | None

    @property
    def worst(self) -> Failure:
        """The failure that leaves the smallest σ_r, the first of equals."""
        return min(self.single, key=lambda one: one.sigma_min)

    @property
    def worst_numbers(self) -> tuple[int, ...]:
        """Numbers of the joints whose failures are as bad as the worst, to a millionth."""
        least = self.worst.sigma_min
        return tuple(failure.number for failure in self.single if failure.sigma_min <= least * (1.0 + 1e-6))


def failures_at(
    robot: Robot | Configuration, q: ArrayLike | None = None, task: Task | str | None = None, *,
    tolerances: Tolerances = DEFAULT,
) -> Failures:  # fmt: skip
    """What each joint's failure leaves at one configuration.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].
        task: name, `Task`, or None for the task the arm is made for.
        tolerances: σ ≤ `singular` is zero.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        TaskError: there is no such task.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("almarkhi4")
        >>> q = [0.0, np.pi, np.pi, np.pi - np.arctan(1 / np.sqrt(2))]
        >>> found = failures_at(arm, q, resolve_task("position", arm, length_scale=1.0))
        >>> [round(one.sigma_min, 6) for one in found.single], round(found.bound, 6)
        ([0.5, 0.5, 0.5, 0.5], 0.5)
    """
    here = configuration_at(robot, q, task, tolerances)
    robot, full, zero = here.robot, here.generic, here.tolerances.singular
    whole = here.metric.jacobian * here.metric.scale
    sigma = sigma_of(whole)
    regular = float(sigma[full - 1]) > zero
    shares = np.linalg.norm(np.linalg.svd(whole)[2][full:], axis=0) * regular
    if robot.n > 1:
        remaining = sigma_of(_without_each(whole[None])[0])
    else:
        remaining = np.zeros((robot.n, 0))
    ranks = [min(full, int((left > zero).sum())) for left in remaining]
    lost = lost_without(robot, here.q, here.task, {j: full - rank for j, rank in enumerate(ranks) if rank < full})
    single = []
    for j, joint in enumerate(robot.variables):
        left, rank = remaining[j], ranks[j]
        if rank == full:
            least = float(left[full - 1])
        else:
            least = 0.0
        single.append(Failure(j + 1, joint.name, left, least, rank, float(shares[j]), lost.get(j)))
    if regular:
        bound = float(np.sqrt((robot.n - full) / robot.n) * sigma[0])
    else:
        bound = None
    return Failures(tuple(single), full, float(sigma[full - 1]) if regular else 0.0, bound)


def worst_case(robot: Robot, q: ArrayLike, task: Task, *, relative: bool = False) -> Array:
    """(...) the least σ_r over all single failures at (..., n) configurations; `relative`: divided by the whole σ_1.

    Zero where the arm has no joint to spare.
    """
    rows, full = np.asarray(q, dtype=np.float64), generic_rank(robot, task)
    if robot.n <= full:
        return np.zeros(rows.shape[:-1])
    jacobian = task_jacobian(robot, rows.reshape(-1, robot.n), task) * joint_scale(robot, task)
    worst = sigma_of(_without_each(jacobian))[..., full - 1].min(axis=1)
    if relative:
        worst = worst / np.maximum(sigma_of(jacobian)[:, 0], _SMALLEST)
    return np.asarray(worst.reshape(rows.shape[:-1]))


def _without_each(jacobian: Array) -> Array:
    """(B, n, m, n − 1) the Jacobians (B, m, n) without each of their columns."""
    return np.stack([np.delete(jacobian, j, axis=2) for j in range(jacobian.shape[2])], axis=1)


def failure_model(robot: Robot, task: Task, *, relative: bool = False) -> Evaluate:
    """The worst case with its sign changed, per scaled joint motion, for `minimax`; n > r.

    A piece per joint: the smallest values of J₋j that count, and, where they are `relative`, the largest of J, each
    with each, because both may tie.
    """
    scale, full, n = joint_scale(robot, task), generic_rank(robot, task), robot.n
    tied = 1 if relative else min(_TIED, full)
    others = np.array([[i for i in range(n) if i != j] for j in range(n)])

    def absolute(jacobian: Array, derivative: Array) -> Model:
        u, sigma, v = svd(_without_each(jacobian))
        kept, right = slice(full - tied, full), np.zeros((len(jacobian), n, n, tied))
        right[:, np.arange(n)[:, None], others] = v[..., kept]
        left = np.einsum("bjia,bilk->bjalk", u[..., kept], derivative)
        return sigma[..., kept], np.einsum("bjalk,bjlc->bjack", left, right)

    def whole(jacobian: Array, derivative: Array) -> Model:
        u, sigma, v = svd(jacobian)
        top = min(_LARGEST, full)
        seen = np.einsum("bia,bilk->balk", u[:, :, :top], derivative)
        return sigma[:, None, :top], np.einsum("balk,blc->back", seen, v[:, :, :top])[:, None]

    def evaluate(scaled: Array) -> Model:
        q = scaled * scale
        jacobian = task_jacobian(robot, q, task) * scale
        derivative = task_jacobian_derivative(robot, q, task) * scale[:, None] * scale
        small, tensor = absolute(jacobian, derivative)
        if not relative:
            return -small, -(tensor + tensor.swapaxes(2, 3)) / 2
        large, turned = whole(jacobian, derivative)
        greatest = np.maximum(large[:, :, :1], _SMALLEST)
        share = small / greatest**2  # d(σ/σ_1) = dσ/σ_1 − σ dσ_1/σ_1²
        values = -small / greatest + share * (large - greatest)
        both = share[..., None, None] * (turned + turned.swapaxes(2, 3)) / 2
        return values, both - np.eye(large.shape[2])[:, :, None] * (tensor / greatest[..., None, None])

    return evaluate
