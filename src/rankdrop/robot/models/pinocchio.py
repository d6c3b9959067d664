"""Robots from and to Pinocchio models (package pin, extra "cross")."""

from __future__ import annotations

from math import inf
from typing import Any

import numpy as np

from rankdrop.errors import MissingExtraError, RobotError, visible
from rankdrop.robot.files import RANGE, Element
from rankdrop.robot.meant import as_meant
from rankdrop.robot.model import Array, Joint, JointKind, Robot, Source, check_joints
from rankdrop.robot.models.placed import placed
from rankdrop.robot.quantities import Angles
from rankdrop.robot.urdf_tree import Tree, TreeJoint, choose_ends, connected

_NOWHERE = Element("joint", {}, 0)  # a model keeps no lines


def from_pinocchio(model: Any, *, base: str | None = None, tip: str | None = None, as_written: bool = False) -> Robot:
    """A robot from a `pinocchio.Model`: the chain of joints between two of its frames.

    Each joint's screw is its motion subspace S (linear part first, as in rankdrop), seen from the base at the neutral
    configuration; joint values count as Pinocchio's do, an unbounded joint's being the angle of its point on the
    circle. Links are the model's frames of bodies and its operational frames.

    Args:
        model: with joints of one freedom on the chain; `pinocchio.buildModelFromUrdf` makes such ones.
        base, tip: names of frames; chosen where not given, as in `from_urdf`, and `Robot.notes` says how.
        as_written: take every number literally; else structure that holds but for noise is exact, with a note.

    Raises:
        MissingExtraError: Pinocchio is not installed.
        RobotError: a name that is not there, a joint with several freedoms, or one that follows another.
    """
    pin = _package("a Pinocchio model")
    name = visible(str(model.name)) or "robot"
    places: dict[str, tuple[int, Array]] = {}  # link -> joint that carries it, pose in its frame
    nodes = ["universe", *(f"after {joint}" for joint in list(model.names)[1:])]
    for frame in model.frames:
        if frame.type not in (pin.FrameType.BODY, pin.FrameType.OP_FRAME):
            continue
        pose = frame.placement.homogeneous
        carrier = frame.parentJoint if hasattr(frame, "parentJoint") else frame.parent
        unnamed = nodes[carrier] == ("universe" if carrier == 0 else f"after {model.names[carrier]}")
        if unnamed and (pose == np.eye(4)).all():
            nodes[carrier] = frame.name
        places.setdefault(frame.name, (carrier, pose))
    links = dict.fromkeys([*nodes, *places], 0)
    joints = {}
    for i in range(1, model.njoints):
        own = str(model.names[i])
        joints[own] = TreeJoint(own, str(i), nodes[model.parents[i]], nodes[i], _NOWHERE)
    for link, (carrier, _) in places.items():
        if link != nodes[carrier]:
            joints[f"{link} (fixed)"] = TreeJoint(f"{link} (fixed)", "fixed", nodes[carrier], link, _NOWHERE)
    tree = connected(Tree(name, f"Pinocchio model {name!r}", links, joints))
    for named, label in ((base, "base"), (tip, "tip")):
        if named is not None:
            tree.check_link(named, label)
    start = nodes[places[base][0]] if base in places else base  # what is fixed to a link may be the base
    ends = choose_ends(tree, start, tip)
    moving = [int(step.kind) for step in ends.path if step.moves]
    check_joints(len(moving), tree.file, steps=len(ends.path))
    pose = np.linalg.inv(places[base][1]) if base in places else np.eye(4)
    chain = []
    for i in moving:
        pose = pose @ model.jointPlacements[i].homogeneous
        chain.append(_joint(pin, model, i, pose, tree.file))
    if ends.tip in places:
        pose = pose @ places[ends.tip][1]
    first = base or ends.base
    found = Robot(name, tuple(chain), pose, source=Source("pinocchio", tree.file), base=first, tip=ends.tip,
                  notes=tuple(ends.notes), about=f"{first} to {ends.tip}")  # fmt: skip
    return as_meant(found, Angles(as_written))


def to_pinocchio(robot: Robot) -> Any:
    """A `pinocchio.Model` of the arm: its joints in order, and a frame with the name of `Robot.tip`.

    Configurations are those of the arm. Joint frames have the axes of the base at q = 0; there are no masses.
    `pinocchio.computeFrameJacobian(model, data, q, model.getFrameId(robot.tip), pinocchio.LOCAL_WORLD_ALIGNED)` is
    `rankdrop.jacobian(robot, q)`.

    Raises:
        MissingExtraError: Pinocchio is not installed.
        RobotError: a joint that follows another.
    """
    pin = _package("a Pinocchio model")
    joints, tip = placed(robot, "Pinocchio", helical=True)
    model = pin.Model()
    model.name = robot.name
    parent, link = 0, 0
    for item in joints:
        x, y, z = (float(part) for part in item.axis)
        if item.joint.kind is JointKind.PRISMATIC:
            kind = pin.JointModelPrismaticUnaligned(x, y, z)
        elif item.joint.kind is JointKind.HELICAL:
            kind = pin.JointModelHelicalUnaligned(x, y, z, item.pitch)
        else:
            kind = pin.JointModelRevoluteUnaligned(x, y, z)
        limits = [np.array([value]) for value in (inf, item.joint.velocity, item.joint.lower, item.joint.upper)]
        parent = model.addJoint(parent, kind, pin.SE3(np.eye(3), item.step), item.joint.name, *limits)
        link = model.addFrame(pin.Frame(item.link, parent, link, pin.SE3.Identity(), pin.FrameType.BODY))
    model.addFrame(pin.Frame(robot.tip, parent, link, pin.SE3(tip), pin.FrameType.OP_FRAME))
    return model


def _package(purpose: str) -> Any:
    try:
        import pinocchio
    except ImportError:
        raise MissingExtraError("pin", "cross", purpose) from None
    return pinocchio


def _joint(pin: Any, model: Any, i: int, pose: Array, file: str) -> Joint:
    """Joint i of the model, whose frame stands at `pose` (4, 4) at the neutral configuration."""
    own, where = model.joints[i], f"{file}, joint {model.names[i]!r}"
    if own.nv != 1 or "Mimic" in own.shortname():
        raise RobotError("a joint of the chain is not of one freedom of its own", where=where, got=own.shortname(),
                         allowed="revolute, prismatic, helical", mend="name a base below it")  # fmt: skip
    data = own.createData()
    own.calc(data, pin.neutral(model))
    local = np.asarray(data.S).reshape(6)
    v, omega = pose[:3, :3] @ local[:3], pose[:3, :3] @ local[3:]
    screw = np.concatenate([v + np.cross(pose[:3, 3], omega), omega]) + 0.0  # + 0.0 turns −0 into 0
    turning = JointKind.HELICAL if local[:3].any() else JointKind.REVOLUTE
    kind = turning if omega.any() else JointKind.PRISMATIC
    lower, upper = -inf, inf
    if own.nq == 1:  # else it turns for ever, and the limits are those of a cosine and a sine
        most = RANGE["length" if kind is JointKind.PRISMATIC else "angle"]
        lower, upper = (float(limit[own.idx_q]) for limit in (model.lowerPositionLimit, model.upperPositionLimit))
        lower, upper = (lower if lower >= -most else -inf), (upper if upper <= most else inf)
    velocity = float(model.velocityLimit[own.idx_v]) if len(model.velocityLimit) else inf
    rate = velocity if 0.0 < velocity <= RANGE["angle"] else inf  # 0 and huge numbers: not known
    return Joint(str(model.names[i]), kind, screw, lower, upper, rate, pose)
