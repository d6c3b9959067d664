"""Walking along a family: a step in its tangent space, then back onto it.

The tangent space at a point of the family is the kernel of the derivatives of its equations; for a family without
equations it is ker D of the block of its corank. Both are taken in scaled joint coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.families.onto import onto
from rankdrop.family.record import Family
from rankdrop.family.system import REACHED, System
from rankdrop.local.block import block, generic_rank, joint_scale, singular_values
from rankdrop.local.verdict import one_configuration
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances

_INDEPENDENT = 1e-6  # singular values of the scaled derivatives below this share of the largest are zero
_STANDS = 1e-6  # a joint whose tangent motion is shorter does not move along the family


@dataclass(frozen=True, slots=True)
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
        scale = joint_scale(self.robot, self.task)
        if self.family.equations:
            slopes = System(self.family.equations).jacobian(at[None])[0] * scale
        else:
            slopes = block(self.robot, at, self.task, self._rank).d.reshape(-1, self.robot.n) * scale
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
        return self.back(at + joint_scale(self.robot, self.task) * direction * (length / size))

    def back(self, q: Array) -> Array | None:
        """A point of the family next to q (n,), or None where none was reached."""
        if self.family.equations:
            system = System(self.family.equations)
            end, _ = system.solve(q[None], step=0.1)
            good = np.abs(system.values(end)).max() <= REACHED
            sigma = singular_values(self.robot, end[0], self.task)[self._rank]
            good &= bool(sigma <= self.tolerances.singular)
            return end[0] if good else None
        ends, arrived = onto(self.robot, self.task, q[None], self._rank, np.eye(self.robot.n))
        return ends[0] if arrived[0] else None

    @property
    def _rank(self) -> int:
        return generic_rank(self.robot, self.task) - self.family.corank
