"""Hunt's matrix of cofactors (Robotica 4, 1986), which GR set out from: it names the screws of a singularity.

At corank 1 of a square Jacobian, with J λ = 0 and uᵀ J = 0 (u, λ of unit length),

    cof J = ± (σ₁ … σ_{m−1}) u λᵀ

so that column j is zero where joint j is not in the dependency, and every other column is the wrench u that no joint
works against. Jacobi's formula, ∂ det J/∂q_j = Σ (cof J) ∘ ∂J/∂q_j = ± (σ₁ … σ_{m−1}) uᵀ (∂J/∂q_j) λ, then tells which
joint leaves the singularity at first order. At corank 2 and more the matrix is zero, and for arms with more joints than
rows there is none: its limits, which GR's procedures are meant to do away with.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.configuration import Configuration, at
from rankdrop.errors import RobotError
from rankdrop.kinematics import task_jacobian_derivative
from rankdrop.local.block import singular_values
from rankdrop.local.ordered import OrderedScrewSet
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, DEPENDENT, Tolerances

AMOUNTS = (0.37, -0.23, 0.1)
"""Finite motions that judge [rad; slides in length scales]: no simple fractions of π."""
FIRST_ORDER = 1e-7
"""Slower than that σ does not grow at first order [1/rad]: derivatives of Jacobians of unit size are good to 1e-14, and
null vectors of an angle that is right to 1e-9 to as much."""


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
        words: why not; else whom it names, and whether finite motion agrees.
        matrix: (m, n) cofactors, largest entry 1, rows of the task with lengths in length scales; empty where it does
            not apply.
        joints: one per joint; empty likewise.
    """

    applies: bool
    words: str
    matrix: tuple[tuple[float, ...], ...] = ()
    joints: tuple[HuntJoint, ...] = ()

    @property
    def agrees(self) -> bool:
        """Whether every joint that it says leads out does, and no other does."""
        return all(one.tells == one.escapes for one in self.joints)


def hunt(
    robot: Robot | Configuration, q: ArrayLike | None = None, task: Task | str | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Hunt:  # fmt: skip
    """Hunt's matrix at a singular configuration, what it tells, and what finite motion says of that.

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
    here = at(robot, q, task, tolerances)
    robot, q, task, matrix, tolerances = here.robot, here.q, here.task, here.jacobian, here.tolerances
    m, n = matrix.shape
    if n != m:
        return Hunt(False, f"Hunt's matrix of cofactors is of a square Jacobian; this one has {m} rows, {n} joints")
    left, sigma, right = np.linalg.svd(matrix)
    lost = int((sigma <= tolerances.singular).sum())
    if lost != 1:
        what = f"is zero where {lost} freedoms are lost" if lost else "tells nothing at a regular configuration"
        return Hunt(False, f"Hunt's matrix of cofactors {what}: it names no screw")
    u, null = left[:, -1], right[-1]
    sign = np.linalg.det(left) * np.linalg.det(right)
    cofactors = sign * np.outer(u, null)
    shares = np.abs(null) / np.abs(null).max()
    derivative = task_jacobian_derivative(robot, q, task)
    rates = np.einsum("i,ikj,k->j", u, derivative, null)
    actuators = _actuators(robot, q)
    scale = np.where([joint.unit == "rad" for joint in robot.variables], 1.0, task.scale(robot))
    motions = np.array([q + amount * scale * np.eye(n)[j] for j in range(n) for amount in AMOUNTS])
    reached = singular_values(robot, motions, task)[:, -1].reshape(n, len(AMOUNTS)).max(axis=1)
    joints = tuple(
        HuntJoint(
            number=j + 1,
            share=float(shares[j]) if shares[j] > DEPENDENT else 0.0,
            named=bool(shares[j] > DEPENDENT),
            actuator=j + 1 in actuators,
            rate=float(rates[j] * scale[j]),
            tells=bool(abs(rates[j] * scale[j]) > FIRST_ORDER * max(1.0, float(sigma[0]))),
            escapes=bool(reached[j] > max(tolerances.singular, float(sigma[-1]) * 10)),
        )
        for j in range(n)
    )
    largest = np.abs(cofactors).max()
    entries = np.where(np.abs(cofactors) > DEPENDENT * largest, cofactors / largest, 0.0)
    return Hunt(True, _words(joints), tuple(tuple(float(x) for x in row) for row in entries), joints)


def _actuators(robot: Robot, q: Array) -> set[int]:
    """Joints that GR's procedure names on some minimal singular run."""
    try:
        screws = OrderedScrewSet.of(robot, q)
    except RobotError:  # mimic joints: GR's procedures do not know them
        return set()
    runs = [run for run in screws.subsets() if run.minimal and run.last > run.first]
    return {j for run in runs for j in screws.subspace(run.first, run.last).actuators}


def _words(joints: tuple[HuntJoint, ...]) -> str:
    named = ", ".join(str(one.number) for one in joints if one.named)
    told = [one.number for one in joints if one.tells]
    missed = [one.number for one in joints if one.escapes and not one.tells]
    wrong = [one.number for one in joints if one.tells and not one.escapes]
    text = f"Hunt's cofactors name the screws {named}; they tell that "
    text += f"joint {_listed(told)} leads out at first order" if told else "no joint leads out at first order"
    if missed:
        return f"{text}; finite motion shows that joint {_listed(missed)} leads out too, at a higher order"
    if wrong:
        return f"{text}; finite motion does not confirm it of joint {_listed(wrong)}"
    return f"{text}, and finite motion agrees"


def _listed(numbers: list[int]) -> str:
    return ", ".join(map(str, numbers))
