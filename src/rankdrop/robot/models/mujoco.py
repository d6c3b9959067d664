"""Robots from and to compiled MuJoCo models (package mujoco, extra "mujoco")."""

from __future__ import annotations

from typing import Any

import numpy as np

from rankdrop.errors import MissingExtraError, visible
from rankdrop.robot.mjcf import robot_of
from rankdrop.robot.model import JointKind, Robot
from rankdrop.robot.models.placed import placed


def from_mujoco(model: Any, *, base: str | None = None, tip: str | None = None, as_written: bool = False) -> Robot:
    """A robot from a compiled `mujoco.MjModel`: the chain of bodies between two bodies or sites.

    As `from_mjcf`, but of a model in memory: bodies without joints that the compiler joined to others are gone, and
    angles are known as quaternions only. Joint values are those of MuJoCo (qpos).

    Args:
        model: of hinges and slides on the chain.
        base, tip: names of bodies or sites; chosen where not given, and `Robot.notes` says how.
        as_written: take every number literally; else structure that holds but for noise is exact, with a note.

    Raises:
        MissingExtraError: mujoco is not installed.
        RobotError: a ball or free joint in the chain, names that are not there.
    """
    mujoco = _package("a MuJoCo model")
    name = visible(bytes(model.names).split(b"\0", 1)[0].decode("utf-8", "replace")) or "robot"
    equal = mujoco.mjtEq.mjEQ_JOINT
    couplings = [(model.joint(int(one)).name, model.joint(int(two)).name) for kind, one, two
                 in zip(model.eq_type, model.eq_obj1id, model.eq_obj2id, strict=True)
                 if kind == equal and two >= 0]  # fmt: skip
    return robot_of(mujoco, model, name, f"MuJoCo model {name!r}", couplings, {}, base, tip, as_written=as_written)


def to_mujoco(robot: Robot) -> Any:
    """A compiled `mujoco.MjModel` of the arm: one body for each joint, and a site with the name of `Robot.tip`.

    qpos is the arm's configuration; bodies have the axes of the base at q = 0 and masses of 1 kg that mean nothing.
    The rows of `mujoco.mj_jacSite`, translation first, are `rankdrop.jacobian(robot, q)`.

    Raises:
        MissingExtraError: mujoco is not installed.
        RobotError: a helical joint, or one that follows another.
    """
    mujoco = _package("a MuJoCo model")
    joints, tip = placed(robot, "MuJoCo")
    spec = mujoco.MjSpec()
    spec.modelname = robot.name
    spec.compiler.degree = False
    body = spec.worldbody
    kinds = {JointKind.REVOLUTE: mujoco.mjtJoint.mjJNT_HINGE, JointKind.PRISMATIC: mujoco.mjtJoint.mjJNT_SLIDE}
    for item in joints:
        body = body.add_body(name=item.link, pos=item.step, mass=1.0, inertia=[1.0, 1.0, 1.0], explicitinertial=True)
        lower, upper = item.joint.lower, item.joint.upper
        limited = bool(np.isfinite([lower, upper]).all()) and lower < upper  # MuJoCo knows both limits or none
        body.add_joint(name=item.joint.name, type=kinds[item.joint.kind], axis=item.axis, pos=[0.0, 0.0, 0.0],
                       limited=limited, range=[lower, upper] if limited else [0.0, 0.0])  # fmt: skip
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(tip[:3, :3]).reshape(9))
    body.add_site(name=robot.tip, pos=tip[:3, 3], quat=quaternion)
    return spec.compile()


def _package(purpose: str) -> Any:
    try:
        import mujoco
    except ImportError:
        raise MissingExtraError("mujoco", "mujoco", purpose) from None
    return mujoco
