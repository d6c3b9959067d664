"""Robots from and to the Robotics Toolbox for Python (package roboticstoolbox-python, extra "cross")."""

from __future__ import annotations

from itertools import pairwise
from math import inf
from typing import Any

import numpy as np

from rankdrop.errors import MissingExtraError, RobotError, visible
from rankdrop.robot.meant import as_meant
from rankdrop.robot.model import Array, Joint, JointKind, Robot, Source, check_joints
from rankdrop.robot.models.placed import placed
from rankdrop.robot.quantities import Angles
from rankdrop.robot.transform import frame_on_axis, rigid


def from_toolbox(model: Any, *, end: str | None = None, as_written: bool = False) -> Robot:
    """A robot from a Robotics Toolbox robot (`DHRobot`, `Robot`, …), or from its elementary transforms (`ETS`).

    Its sequence of elementary transforms is walked: Rx, Ry, Rz turn, tx, ty, tz slide, and a joint that is flipped
    counts the other way. Base and tool of a `DHRobot`, and offsets of joints, are part of the sequence. Joint values
    are those of `fkine` and `jacob0`.

    Args:
        model: of which the transforms are taken.
        end: name of the last link, for robots with several.
        as_written: take every number literally; else structure that holds but for noise is exact, with a note.

    Raises:
        RobotError: two transforms that share a variable, variables that are not numbered along the chain, or a
            model without joints.
    """
    transforms = model if not hasattr(model, "ets") else model.ets() if end is None else model.ets(end=end)
    name = visible(str(getattr(model, "name", "") or "robot"))
    place = f"Robotics Toolbox model {name!r}"
    moving = [item for item in transforms if item.isjoint]
    check_joints(len(moving), place, steps=len(transforms))
    numbers = [item.jindex for item in moving]
    if None not in numbers and any(a >= b for a, b in pairwise(numbers)):
        raise RobotError("the variables are not numbered along the chain", where=place, got=numbers,
                         allowed="each once, from base to tip", mend="number the joints anew (jindex)")  # fmt: skip
    pose = np.eye(4)
    joints: list[Joint] = []
    for item in transforms:
        if not item.isjoint:
            pose = pose @ rigid(item.A(), place)
            continue
        letters = str(item.kind if hasattr(item, "kind") else item.axis)  # version 1.4 renamed it
        direction = pose[:3, "xyz".index(letters[-1])] * (-1.0 if item.isflip else 1.0)
        slides = letters[0] == "t"
        kind = JointKind.PRISMATIC if slides else JointKind.REVOLUTE
        screw = np.concatenate([direction, np.zeros(3)] if slides else [np.cross(pose[:3, 3], direction), direction])
        lower, upper = (-inf, inf) if item.qlim is None else (float(x) for x in np.ravel(item.qlim)[:2])
        joints.append(Joint(f"joint{len(joints) + 1}", kind, screw + 0.0, lower, upper, inf, pose))
    found = Robot(name, tuple(joints), pose, source=Source("toolbox", place))
    return as_meant(found, Angles(as_written))


def to_toolbox(robot: Robot) -> Any:
    """A `roboticstoolbox.Robot` of the arm: elementary transforms, each joint about or along its own z axis.

    Its configurations are those of the arm, `jacob0(q)` is `rankdrop.jacobian(robot, q)`.

    Raises:
        MissingExtraError: the toolbox is not installed.
        RobotError: a helical joint, or one that follows another.
    """
    try:
        from roboticstoolbox import ET, ETS
        from roboticstoolbox import Robot as Model
    except ImportError:
        raise MissingExtraError("roboticstoolbox-python", "cross", "a Robotics Toolbox model") from None
    joints, tip = placed(robot, "the Robotics Toolbox")
    at, sequence = np.eye(4), []
    point = np.zeros(3)
    for item in joints:
        point = point + item.step
        frame = frame_on_axis(item.axis, point)
        sequence.append(ET.SE3(_between(at, frame)))
        make = ET.tz if item.joint.kind is JointKind.PRISMATIC else ET.Rz
        limits = [item.joint.lower, item.joint.upper]
        sequence.append(make(qlim=limits) if np.isfinite(limits).all() else make())
        at = frame
    end = tip.copy()
    end[:3, 3] += point
    sequence.append(ET.SE3(_between(at, end)))
    return Model(ETS(sequence), name=robot.name)


def _between(one: Array, two: Array) -> Array:
    """(4, 4) the frame `two` seen from `one`, the inverse taken in closed form: R1ᵀ R2, R1ᵀ (p2 − p1)."""
    found = np.eye(4)
    found[:3, :3] = one[:3, :3].T @ two[:3, :3]
    found[:3, 3] = one[:3, :3].T @ (two[:3, 3] - one[:3, 3])
    return found
