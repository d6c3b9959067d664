"""Which joints lead out of a singular configuration by the matrix of cofactors (Hunt), and what a finite motion says.

A square Jacobian of corank 1 has the cofactors c_ij = ∂ det J/∂J_ij, so that ∂ det J/∂q_j says how fast σ grows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.configuration import Configuration, configuration_at
from rankdrop.errors import RobotError
from rankdrop.kinematics import task_jacobian_derivative
from rankdrop.local.ordered import OrderedScrewSet
from rankdrop.local.ordered_report import FINITE_MOTIONS
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, DEPENDENT, Tolerances

# σ grows at first order where it is faster than this [1/rad]: derivatives of Jacobians of unit size are good to 1e-14,
# and null vectors of an angle that is right to 1e-9 to as much
_FIRST_ORDER = 1e-7


@dataclass(frozen=True, slots=True)
class HuntJoint:
    """One column of the matrix.

    Attributes:
        number: of the joint, from 1.
        share: length of its column over that of the longest: 0 for a joint that is not in the dependency.
        named: whether the column is not zero: Hunt's responsible screws.
        actuator: GR's procedure names it, on a minimal singular run.
        rate: ∂ det J/∂q_j over the product of the other singular values: how fast σ grows [1/rad; slides: 1/length
            scale].
        tells: whether that is not zero: the matrix says that the joint leads out.
        escapes: the rank is restored after a finite motion of the joint alone.
    """

    number: int
    share: float
    named: bool
    actuator: bool
    rate: float
    tells: bool
    escapes: bool


@dataclass(frozen=True, slots=True)
class Hunt:
    """What the matrix of cofactors tells of one configuration.

    Attributes:
        applies: a square Jacobian of corank 1.
        shape: rows and columns of the Jacobian.
        lost: freedoms lost.
        matrix: (m, n) cofactors, largest entry 1, rows of the task with lengths in length scales; empty where it does
            not apply.
        joints: one per joint; empty likewise.
    """

    applies: bool
    shape: tuple[int, int]
    lost: int
    matrix: tuple[tuple[float, ...], ...] = ()
    joints: tuple[HuntJoint, ...] = ()


def hunt(
    robot: Robot | Configuration, q: ArrayLike | None = None, task: Task | str | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Hunt:  # fmt: skip
    """Hunt's matrix of cofactors (Robotica 4, 1986) at a singular configuration, judged by finite motion.

    At corank 1 of a square Jacobian, with J λ = 0 and uᵀ J = 0 (u, λ of unit length),

        cof J = ± (σ₁ … σ_{m−1}) u λᵀ

    so that column j is zero where joint j is not in the dependency, and every other column is the wrench u that no
    joint works against. By Jacobi's formula, ∂ det J/∂q_j = Σ (cof J) ∘ ∂J/∂q_j = ± (σ₁ … σ_{m−1}) uᵀ (∂J/∂q_j) λ, the
    matrix shows which joint leaves the singularity at first order. At corank 2 and more the matrix is zero, and for
    arms with more joints than rows there is none: GR's procedures are meant to remove these limits.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].
        task: resolved.
        tolerances: `singular` decides what is lost, and whether a finite motion restores it.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("puma560")
        >>> found = hunt(arm, np.array([0.3, 0.5, 0.4, 0.2, 0.0, 0.6]), resolve_task(None, arm))
        >>> [one.number for one in found.joints if one.named], [one.number for one in found.joints if one.tells]
        ([4, 6], [5])
    """
    here = configuration_at(robot, q, task, tolerances)
    m, n = here.jacobian.shape
    left, sigma, right = np.linalg.svd(here.jacobian)
    least = here.tolerances.singular
    lost = int((sigma <= least).sum())
    if n != m or lost != 1:
        return Hunt(False, (m, n), lost)
    u, null = left[:, -1], right[-1]
    cofactors = np.linalg.det(left) * np.linalg.det(right) * np.outer(u, null)
    shares = np.abs(null) / np.abs(null).max()
    shares[shares <= DEPENDENT] = 0.0
    rates = np.einsum("i,ikj,k->j", u, task_jacobian_derivative(here.robot, here.q, here.task), null) * here.scale
    tells = np.abs(rates) > _FIRST_ORDER * max(1.0, sigma[0])
    reached = here.singular_values(here.q + np.multiply.outer(FINITE_MOTIONS, np.diag(here.scale)))[..., -1].max(axis=0)
    escapes = reached > max(least, 10 * sigma[-1])
    actuators = _actuators(here.robot, here.q)
    columns = zip(shares.tolist(), rates.tolist(), tells.tolist(), escapes.tolist(), strict=True)
    joints = tuple(
        HuntJoint(number, share, share > 0.0, number in actuators, rate, leads, out)
        for number, (share, rate, leads, out) in enumerate(columns, 1)
    )
    largest = np.abs(cofactors).max()
    entries = np.where(np.abs(cofactors) > DEPENDENT * largest, cofactors / largest, 0.0)
    return Hunt(True, (m, n), lost, tuple(map(tuple, entries.tolist())), joints)


def _actuators(robot: Robot, q: Array) -> set[int]:
    """Joints that GR's procedure names on some minimal singular run."""
    try:
        screws = OrderedScrewSet.of(robot, q)
    except RobotError:  # mimic joints: GR's procedures do not know them
        return set()
    runs = [run for run in screws.subsets() if run.minimal and run.last > run.first]
    return {j for run in runs for j in screws.subspace(run.first, run.last).actuators}
