"""A real arm in Pinocchio, put into the terms of rankdrop: a base link, a tip link, the n joints between them."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from reference.arms import adjoint

from rankdrop.robot.model import Array, Robot


class PinocchioArm:
    """The chain base → tip of `robot` in a Pinocchio model of the whole file; every other joint stays at neutral."""

    def __init__(self, model: pin.Model, robot: Robot) -> None:
        self.model, self.data = model, model.createData()
        self.joints = [model.joints[model.getJointId(joint.name)] for joint in robot.joints]
        self.velocity = [joint.idx_v for joint in self.joints]
        self.tip = self._frame(robot.tip)
        self._place(np.zeros(robot.n))
        self.base = self.data.oMf[self._frame(robot.base)].copy()

    def pose(self, q: Array) -> Array:
        """(4, 4) pose of the tip in the base."""
        self._place(q)
        return (self.base.inverse() * self.data.oMf[self.tip]).homogeneous

    def jacobian(self, q: Array, reference: pin.ReferenceFrame) -> Array:
        """(6, n) Jacobian of the tip: LOCAL is BODY, LOCAL_WORLD_ALIGNED is WORLD_ALIGNED, WORLD is SPACE."""
        self._place(q)
        columns = pin.getFrameJacobian(self.model, self.data, self.tip, reference)[:, self.velocity]
        return self._in_base(reference) @ columns

    def jacobian_rate(self, q: Array, rate: Array, reference: pin.ReferenceFrame) -> Array:
        """(6, n) time derivative of `jacobian` at joint rates `rate`."""
        v = np.zeros(self.model.nv)
        v[self.velocity] = rate
        pin.computeJointJacobiansTimeVariation(self.model, self.data, self._configuration(q), v)
        pin.updateFramePlacements(self.model, self.data)
        columns = pin.getFrameJacobianTimeVariation(self.model, self.data, self.tip, reference)[:, self.velocity]
        return self._in_base(reference) @ columns

    def joint_jacobian(self, q: Array, count: int) -> Array:
        """(6, count) columns of the first `count` joints, seen in the frame of the link after the last of them."""
        self._place(q)
        index = self.model.getJointId(self.model.names[self.joints[count - 1].id])
        return pin.getJointJacobian(self.model, self.data, index, pin.LOCAL)[:, self.velocity[:count]]

    def _frame(self, link: str) -> int:
        if not self.model.existFrame(link, pin.FrameType.BODY):
            raise ValueError(f"Pinocchio knows no link {link!r}")
        return self.model.getFrameId(link, pin.FrameType.BODY)

    def _configuration(self, q: Array) -> Array:
        full = pin.neutral(self.model)
        for joint, value in zip(self.joints, q, strict=True):
            # a continuous joint is a point of the unit circle
            full[joint.idx_q : joint.idx_q + joint.nq] = value if joint.nq == 1 else (np.cos(value), np.sin(value))
        return full

    def _place(self, q: Array) -> None:
        pin.computeJointJacobians(self.model, self.data, self._configuration(q))
        pin.updateFramePlacements(self.model, self.data)

    def _in_base(self, reference: pin.ReferenceFrame) -> Array:
        if reference == pin.LOCAL:
            return np.eye(6)
        inverse = self.base.inverse().homogeneous
        if reference == pin.LOCAL_WORLD_ALIGNED:
            inverse[:3, 3] = 0.0
        return adjoint(inverse)
