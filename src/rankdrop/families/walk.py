"""Ways along the singular set: along one family, and all of it in a slice.

Along a family a step is made in its tangent space, then back onto it. The tangent space at a point of the family is the
kernel of the derivatives of its equations; for a family without equations it is ker D of the block of its corank. Both
are taken in scaled joint coordinates. A slice of joint space: some joints vary, the others stand where they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import OptionError
from rankdrop.families.points import MOST_STARTS, Cloud, move_to_singularity, set_joints
from rankdrop.families.record import Family
from rankdrop.formula.equation import REACHED
from rankdrop.kinematics import one_configuration
from rankdrop.problem import Problem, wrap
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances

_INDEPENDENT = 1e-6  # singular values of the scaled derivatives below this share of the largest are zero
_STANDS = 1e-6  # a joint whose tangent motion is shorter does not move along the family


@dataclass(frozen=True)
class Walk:
    """The way along one family.

    Attributes:
        robot, task, family: where it goes.
        tolerances: `singular` decides whether a point is singular.
    """

    robot: Robot
    task: Task
    family: Family
    tolerances: Tolerances = DEFAULT

    @cached_property
    def problem(self) -> Problem:
        """The arm, asked for the corank of the family."""
        return Problem(self.robot, self.task, self.family.corank, self.tolerances)

    def tangent(self, q: ArrayLike) -> Array:
        """Orthonormal basis of the tangent space at a point of the family.

        Args:
            q: (n,) [rad, m].

        Returns:
            (n, d) columns in scaled joint coordinates: a motion is `joint_scale` times a column.

        Raises:
            ConfigurationError: q is not one configuration of this arm.
        """
        at = one_configuration(self.robot, q)
        scale = self.problem.scale
        if self.family.equations:
            slopes = self.family.system.jacobian(at[None])[0] * scale
        else:
            slopes = self.problem.block(at).d.reshape(-1, self.robot.n) * scale
        _, sigma, vt = np.linalg.svd(slopes)
        kept = int((sigma > _INDEPENDENT * max(1.0, sigma[0])).sum())
        return np.asarray(vt[kept:].T)

    def movable(self, q: ArrayLike) -> tuple[int, ...]:
        """Joints (from 1) that move along the family at q."""
        basis = self.tangent(q)
        return tuple(j + 1 for j in range(self.robot.n) if np.linalg.norm(basis[j]) > _STANDS)

    def step(self, q: ArrayLike, joint: int, length: float) -> Array | None:
        """The point of the family reached by moving one joint as straight as the family allows.

        The direction is the projection of the joint's own on the tangent space, made unit; the point is then brought
        back onto the family by shortest steps.

        Args:
            q: (n,) a point of the family [rad, m].
            joint: number from 1; see `movable`.
            length: signed, of the step in scaled joint coordinates [rad; slides in length scales].

        Returns:
            (n,) [rad, m]; None where the joint stands still along the family, or no point of it was reached.

        Raises:
            ConfigurationError: q is not one configuration of this arm.
        """
        at = one_configuration(self.robot, q)
        basis = self.tangent(at)
        direction = basis @ basis[joint - 1]
        size = float(np.linalg.norm(direction))
        if size <= _STANDS:
            return None
        return self.project_onto_family(at + self.problem.scale * direction * (length / size))

    def project_onto_family(self, q: Array) -> Array | None:
        """A point of the family next to q (n,), or None where none was reached."""
        if self.family.equations:
            system = self.family.system
            end, _ = system.solve(q[None], step=0.1)
            good = np.abs(system.values(end)).max() <= REACHED
            good &= bool(self.problem.singular(end)[0])
            return end[0] if good else None
        ends, arrived = move_to_singularity(self.problem, q[None], np.eye(self.robot.n))
        return ends[0] if arrived[0] else None


def in_slice(
    robot: Robot,
    task: Task,
    q: ArrayLike,
    joints: Sequence[int],
    *,
    starts: int = 2000,
    limits: bool = False,
    seed: int = 0,
) -> Cloud:
    """Points of the singular set in the slice through q along some joints.

    Uniform starts in the slice are driven onto corank 1 by Gauss–Newton on the block, moving the chosen joints only
    (`move_to_singularity`). A slice of two joints shows curves where the set has codimension 1 and points where it has
    2; where q itself is singular whatever the chosen joints do, the whole slice is. Nothing found is not a proof of
    absence.

    Args:
        robot: the arm.
        task: from `resolve_task`.
        q: (n,) the other joints stand here [rad, m].
        joints: numbers from 1 of the joints that vary.
        starts: how many.
        limits: only points within the joint limits.
        seed: of the starts.

    Returns:
        Cloud; turning joints that vary are in (−π, π] unless limits were asked for. Starts that did not arrive are left
        out.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        OptionError: joints that do not exist or are named twice, or a number of starts outside what is allowed.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("scara")
        >>> found = in_slice(arm, resolve_task(None, arm), [0.0] * 4, (1, 2), starts=50)
        >>> bool(abs(np.sin(found.q[:, 1])).max() < 1e-9)  # sin θ2 = 0
        True
    """
    centre = one_configuration(robot, q)
    chosen = [joint - 1 for joint in joints]
    if not chosen or len(set(chosen)) != len(chosen) or not all(0 <= j < robot.n for j in chosen):
        raise OptionError("these joints span no slice", got=list(joints), allowed=f"different numbers, 1 … {robot.n}")
    if not 1 <= starts <= MOST_STARTS:
        raise OptionError("starts is outside the range", got=starts, allowed=f"1 … {MOST_STARTS}")
    problem = Problem(robot, task, 1, limits=limits)
    low, high = problem.box
    drawn = np.random.default_rng(seed).uniform(low[chosen], high[chosen], (starts, len(chosen)))
    rows = set_joints(centre, chosen, drawn)
    full = problem.generic_rank
    if full == 0:
        return Cloud(robot, task, rows[:0], np.zeros(0, dtype=np.int64))
    ends, arrived = move_to_singularity(problem, rows, np.eye(robot.n)[:, chosen])
    ends = ends[arrived]
    if not limits:
        turning = robot.periodic & np.isin(np.arange(robot.n), chosen)
        ends = np.where(turning, wrap(ends), ends)
    slack = problem.tolerances.value
    inside = ((ends[:, chosen] >= low[chosen] - slack) & (ends[:, chosen] <= high[chosen] + slack)).all(axis=1)
    ends = ends[inside]
    rank = np.minimum((problem.sigma(ends) > problem.tolerances.singular).sum(axis=1), full)
    return Cloud(robot, task, ends, np.asarray(full - rank, dtype=np.int64))
