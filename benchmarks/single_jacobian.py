"""One Jacobian at a time from Python: rankdrop against Pinocchio on the same arms."""

from __future__ import annotations

import measure  # first: sets the number of threads
import numpy as np
import pinocchio as pin
from reference import arms

from rankdrop.kinematics import jacobian
from rankdrop.robot.model import Robot


def in_pinocchio(robot: Robot) -> tuple[pin.Model, int]:
    """The same arm as a Pinocchio model of joints about z, its quickest kind, and the number of its tip."""
    model, parent, placed = pin.Model(), 0, pin.SE3.Identity()
    for joint in robot.joints:
        axis = joint.screw[3:]
        turn = np.linalg.svd(axis[None])[2][[1, 2, 0]].T  # columns: two normals, then ± the axis
        turn[:, 2] = axis
        turn[:, 0] *= np.sign(np.linalg.det(turn))
        here = pin.SE3(turn, np.cross(axis, joint.screw[:3]))
        parent = model.addJoint(parent, pin.JointModelRZ(), placed.inverse() * here, joint.name)
        placed = here
    tip = placed.inverse() * pin.SE3(robot.home)
    return model, model.addFrame(pin.Frame("tip", parent, tip, pin.FrameType.OP_FRAME))


def main() -> None:
    """Reference point at the tip, axes of the base, a new configuration at every call."""
    calls = 2_000 if measure.quick() else 50_000
    rows = []
    for robot in (arms.pa10(), arms.puma()):
        model, tip = in_pinocchio(robot)
        data, frame = model.createData(), pin.LOCAL_WORLD_ALIGNED
        sample = list(np.random.default_rng(0).uniform(-np.pi, np.pi, (calls, robot.n)))
        same = np.abs(jacobian(robot, sample[0]) - pin.computeFrameJacobian(model, data, sample[0], tip, frame)).max()
        if same > 1e-12:
            raise SystemExit(f"the two Jacobians differ by {same}")

        def ours(robot: Robot = robot, sample: list[np.ndarray] = sample) -> None:
            for q in sample:
                jacobian(robot, q)

        def theirs(model=model, data=data, tip=tip, frame=frame, sample=sample) -> None:  # type: ignore[no-untyped-def]  # Pinocchio has no types
            for q in sample:
                pin.computeFrameJacobian(model, data, q, tip, frame)

        mine, other = measure.best_of(5, ours) / calls, measure.best_of(5, theirs) / calls
        rows.append({"arm": robot.name, "rankdrop us": 1e6 * mine, "Pinocchio us": 1e6 * other, "ratio": mine / other})
    measure.report(
        f"one Jacobian from Python, {calls} calls, time per call: under 3 times Pinocchio's computeFrameJacobian",
        rows, ratio="ratio", target=3.0, at_most=True,
    )  # fmt: skip


if __name__ == "__main__":
    main()
