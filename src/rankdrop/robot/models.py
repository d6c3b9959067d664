"""Robots from and to the models of MuJoCo, Pinocchio, the Robotics Toolbox and yourdfpy.

Each package is imported where it is needed. From a model: its links and joints become a `Tree`, and the chain of the
arm is read off it. To a model: the joints of the arm one after the other, each with a frame on its axis.
"""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from itertools import pairwise
from math import inf
from typing import Any

import numpy as np

from rankdrop.errors import MissingExtraError, RobotError, visible
from rankdrop.robot.arm_reach import nearest
from rankdrop.robot.files import RANGE, Element
from rankdrop.robot.mjcf import plain_model, robot_of
from rankdrop.robot.model import Array, Joint, JointKind, Robot, Source, check_joints, screw_of
from rankdrop.robot.quantities import Angles
from rankdrop.robot.square_up import as_intended
from rankdrop.robot.transform import frame_on_axis, inverse, rigid
from rankdrop.robot.tree import Motion, Tree, TreeJoint, chain_robot, choose_ends, connect_links
from rankdrop.robot.urdf import from_tree

AxisFrame = tuple[Joint, Array, Array, str]
"""A joint with a frame on its axis, parallel to the base at q = 0: the joint; (3,) the step from the frame of the joint
before it, or the base origin [m]; (3,) its axis, unit, in the base frame; a name for the link that it carries, which
differs from all others, `Robot.base` and `Robot.tip`."""


def _package(module: str, package: str, extra: str) -> Any:
    try:
        return import_module(module)
    except ImportError:
        raise MissingExtraError(package, extra, f"a model of {package}") from None


def axis_frames(
    robot: Robot, package: str, *, mimics: bool = False, helical: bool = False
) -> tuple[list[AxisFrame], Array]:
    """The joints of an arm for another package, and the (4, 4) pose of the tip in the frame of the last one at q = 0.

    Args:
        robot: the arm.
        package: its name, for errors.
        mimics, helical: whether it knows joints that follow others, and helical ones.

    Raises:
        RobotError: a joint of a kind that the package does not know.
    """
    taken = {robot.base, robot.tip}
    at = np.zeros(3)
    frames = []
    for joint in robot.joints:
        where = f"robot {robot.name!r}, joint {joint.name!r}"
        if joint.mimic is not None and not mimics:
            raise RobotError(f"{package} has no joints that follow others", where=where,
                             got=f"it follows {joint.mimic.leader!r}", allowed="joints that are variables")  # fmt: skip
        if joint.kind is JointKind.HELICAL and not helical:
            raise RobotError(f"{package} has no helical joints", where=where, allowed="revolute, prismatic")
        point, origin = joint.foot, joint.frame[:3, 3]
        off = np.abs(origin - nearest((joint.axis, point), origin)).max()
        if off <= 1e-15 * (1.0 + np.abs(origin).max()):  # the frame stands on the axis
            point = origin
        link = f"{joint.name}_link"
        while link in taken:
            link += "_"
        taken.add(link)
        frames.append((joint, point - at, joint.axis, link))
        at = point
    tip = robot.home.copy()
    tip[:3, 3] -= at
    return frames, tip


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
    mujoco = _package("mujoco", "mujoco", "mujoco")
    name = visible(bytes(model.names).split(b"\0", 1)[0].decode("utf-8", "replace")) or "robot"
    equal = mujoco.mjtEq.mjEQ_JOINT
    couplings = [(model.joint(int(first)).name, model.joint(int(second)).name) for kind, first, second
                 in zip(model.eq_type, model.eq_obj1id, model.eq_obj2id, strict=True)
                 if kind == equal and second >= 0]  # fmt: skip
    plain = plain_model(mujoco, model, couplings, {})
    return robot_of(plain, name, f"MuJoCo model {name!r}", base, tip, as_written=as_written)


def to_mujoco(robot: Robot) -> Any:
    """A compiled `mujoco.MjModel` of the arm: one body for each joint, and a site with the name of `Robot.tip`.

    qpos is the arm's configuration; bodies have the axes of the base at q = 0 and masses of 1 kg that mean nothing.
    The rows of `mujoco.mj_jacSite`, translation first, are `rankdrop.jacobian(robot, q)`.

    Raises:
        MissingExtraError: mujoco is not installed.
        RobotError: a helical joint, or one that follows another.
    """
    mujoco = _package("mujoco", "mujoco", "mujoco")
    joints, tip = axis_frames(robot, "MuJoCo")
    spec = mujoco.MjSpec()
    spec.modelname = robot.name
    spec.compiler.degree = False
    body = spec.worldbody
    kinds = {JointKind.REVOLUTE: mujoco.mjtJoint.mjJNT_HINGE, JointKind.PRISMATIC: mujoco.mjtJoint.mjJNT_SLIDE}
    for joint, step, axis, link in joints:
        body = body.add_body(name=link, pos=step, mass=1.0, inertia=[1.0, 1.0, 1.0], explicitinertial=True)
        lower, upper = joint.lower, joint.upper
        limited = bool(np.isfinite([lower, upper]).all()) and lower < upper  # MuJoCo knows both limits or none
        body.add_joint(name=joint.name, type=kinds[joint.kind], axis=axis, pos=[0.0, 0.0, 0.0],
                       limited=limited, range=[lower, upper] if limited else [0.0, 0.0])  # fmt: skip
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(tip[:3, :3]).reshape(9))
    body.add_site(name=robot.tip, pos=tip[:3, 3], quat=quaternion)
    return spec.compile()


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
    pin = _package("pinocchio", "pin", "cross")
    name = visible(str(model.name)) or "robot"
    nodes, places = _pinocchio_links(pin, model)
    links = dict.fromkeys([*nodes, *places], 0)
    joints = {}
    for i in range(1, model.njoints):
        joint_name = str(model.names[i])
        joints[joint_name] = TreeJoint(joint_name, str(i), nodes[model.parents[i]], nodes[i])
    for link, (carrier, _) in places.items():
        if link != nodes[carrier]:
            joints[f"{link} (fixed)"] = TreeJoint(f"{link} (fixed)", "fixed", nodes[carrier], link)
    tree = connect_links(Tree(name, f"Pinocchio model {name!r}", links, joints))
    for named, label in ((base, "base"), (tip, "tip")):
        if named is not None:
            tree.check_link(named, label)
    ends = choose_ends(tree, nodes[places[base][0]] if base in places else base, tip)  # a fixed frame may be the base
    if base in places:
        start = inverse(places[base][1])
    else:
        start = np.eye(4)
    if ends.tip in places:
        last = places[ends.tip][1]
    else:
        last = np.eye(4)
    ends = replace(ends, base=base or ends.base)
    return chain_robot(tree, ends, "pinocchio", lambda joint: _pinocchio_motion(pin, model, joint, tree),
                       Angles(as_written), [], (start, last))  # fmt: skip


def _pinocchio_links(pin: Any, model: Any) -> tuple[list[str], dict[str, tuple[int, Array]]]:
    """The link that each joint carries: the first frame at its place, else named after it; and the place of each frame.

    Returns:
        Names of links, one for each joint and the universe first; link -> (number of the joint that carries it, its
        pose (4, 4) in the frame of that joint).
    """
    places: dict[str, tuple[int, Array]] = {}
    nodes = ["universe", *(f"after {joint}" for joint in list(model.names)[1:])]
    for frame in model.frames:
        if frame.type not in (pin.FrameType.BODY, pin.FrameType.OP_FRAME):
            continue
        pose = frame.placement.homogeneous
        if hasattr(frame, "parentJoint"):
            carrier = frame.parentJoint
        else:
            carrier = frame.parent
        unnamed = nodes[carrier] == ("universe" if carrier == 0 else f"after {model.names[carrier]}")
        if unnamed and (pose == np.eye(4)).all():
            nodes[carrier] = frame.name
        places.setdefault(frame.name, (carrier, pose))
    return nodes, places


def to_pinocchio(robot: Robot) -> Any:
    """A `pinocchio.Model` of the arm: its joints in order, and a frame with the name of `Robot.tip`.

    Configurations are those of the arm. Joint frames have the axes of the base at q = 0; there are no masses.
    `pinocchio.computeFrameJacobian(model, data, q, model.getFrameId(robot.tip), pinocchio.LOCAL_WORLD_ALIGNED)` is
    `rankdrop.jacobian(robot, q)`.

    Raises:
        MissingExtraError: Pinocchio is not installed.
        RobotError: a joint that follows another.
    """
    pin = _package("pinocchio", "pin", "cross")
    joints, tip = axis_frames(robot, "Pinocchio", helical=True)
    model = pin.Model()
    model.name = robot.name
    parent, link = 0, 0
    for joint, step, axis, name in joints:
        x, y, z = (float(part) for part in axis)
        if joint.slides:
            kind = pin.JointModelPrismaticUnaligned(x, y, z)
        elif joint.kind is JointKind.HELICAL:
            kind = pin.JointModelHelicalUnaligned(x, y, z, joint.pitch)
        else:
            kind = pin.JointModelRevoluteUnaligned(x, y, z)
        limits = [np.array([value]) for value in (inf, joint.velocity, joint.lower, joint.upper)]
        parent = model.addJoint(parent, kind, pin.SE3(np.eye(3), step), joint.name, *limits)
        link = model.addFrame(pin.Frame(name, parent, link, pin.SE3.Identity(), pin.FrameType.BODY))
    model.addFrame(pin.Frame(robot.tip, parent, link, pin.SE3(tip), pin.FrameType.OP_FRAME))
    return model


def _pinocchio_motion(pin: Any, model: Any, joint: TreeJoint, tree: Tree) -> Motion:
    if not joint.moves:
        return Motion(np.eye(4))
    i = int(joint.kind)
    joint_model = model.joints[i]
    if joint_model.nv != 1 or "Mimic" in joint_model.shortname():
        raise RobotError("a joint of the chain is not of one freedom of its own", where=tree.place_of(joint),
                         got=joint_model.shortname(), allowed="revolute, prismatic, helical",
                         mend="name a base below it")  # fmt: skip
    data = joint_model.createData()
    joint_model.calc(data, pin.neutral(model))
    kind, axis, pitch = _kind_of_motion(np.asarray(data.S).reshape(6))
    lower, upper = -inf, inf
    if joint_model.nq == 1:  # else it turns for ever, and the limits are those of a cosine and a sine
        most = RANGE[kind.measure]
        limits = model.lowerPositionLimit, model.upperPositionLimit
        lower, upper = (float(limit[joint_model.idx_q]) for limit in limits)
        lower, upper = (lower if lower >= -most else -inf), (upper if upper <= most else inf)
    if len(model.velocityLimit):
        velocity = float(model.velocityLimit[joint_model.idx_v])
    else:
        velocity = inf
    rate = velocity if 0.0 < velocity <= RANGE["angle"] else inf  # 0 and huge numbers: not known
    return Motion(model.jointPlacements[i].homogeneous, kind, axis, pitch=pitch, lower=lower, upper=upper,
                  velocity=rate)  # fmt: skip


def _kind_of_motion(screw: Array) -> tuple[JointKind, Array, float]:
    """What a joint with the screw (v; ω), (6,), is: its kind, its axis (3,), and its pitch vᵀω [m/rad]."""
    v, omega = np.split(screw, 2)
    if not omega.any():
        return JointKind.PRISMATIC, v, 0.0
    if v.any():
        kind = JointKind.HELICAL
    else:
        kind = JointKind.REVOLUTE
    return kind, omega, float(v @ omega)


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
    if not hasattr(model, "ets"):
        transforms = model
    elif end is None:
        transforms = model.ets()
    else:
        transforms = model.ets(end=end)
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
        if item.isjoint:
            joints.append(_toolbox_joint(item, f"joint{len(joints) + 1}", pose))
        else:
            pose = pose @ rigid(item.A(), place)
    robot = Robot(name, tuple(joints), pose, source=Source("toolbox", place))
    return as_intended(robot, Angles(as_written))


def _toolbox_joint(item: Any, name: str, pose: Array) -> Joint:
    """The joint of an elementary transform that moves, at the pose (4, 4) that the ones before it give."""
    letters = str(item.kind if hasattr(item, "kind") else item.axis)  # version 1.4 renamed it
    direction = pose[:3, "xyz".index(letters[-1])] * (-1.0 if item.isflip else 1.0)
    if letters[0] == "t":
        kind = JointKind.PRISMATIC
    else:
        kind = JointKind.REVOLUTE
    screw = screw_of(kind, direction, pose[:3, 3])
    if item.qlim is None:
        lower, upper = (-inf, inf)
    else:
        lower, upper = (float(x) for x in np.ravel(item.qlim)[:2])
    return Joint(name, kind, screw, lower, upper, inf, pose)


def to_toolbox(robot: Robot) -> Any:
    """A `roboticstoolbox.Robot` of the arm: elementary transforms, each joint about or along its own z axis.

    Its configurations are those of the arm, `jacob0(q)` is `rankdrop.jacobian(robot, q)`.

    Raises:
        MissingExtraError: the toolbox is not installed.
        RobotError: a helical joint, or one that follows another.
    """
    toolbox = _package("roboticstoolbox", "roboticstoolbox-python", "cross")
    transform = toolbox.ET
    joints, tip = axis_frames(robot, "the Robotics Toolbox")
    at, sequence = np.eye(4), []
    point = np.zeros(3)
    for joint, step, axis, _ in joints:
        point = point + step
        frame = frame_on_axis(axis, point)
        sequence.append(transform.SE3(inverse(at) @ frame))
        if joint.slides:
            make = transform.tz
        else:
            make = transform.Rz
        limits = [joint.lower, joint.upper]
        sequence.append(make(qlim=limits) if np.isfinite(limits).all() else make())
        at = frame
    end = tip.copy()
    end[:3, 3] += point
    sequence.append(transform.SE3(inverse(at) @ end))
    return toolbox.Robot(toolbox.ETS(sequence), name=robot.name)


def from_yourdfpy(model: Any, *, base: str | None = None, tip: str | None = None, as_written: bool = False) -> Robot:
    """A robot from a `yourdfpy.URDF` or its `robot`: the chain of joints between two links, as `from_urdf` reads it.

    Origins are taken as the matrices that yourdfpy holds: digits of angles are not known any more.

    Args:
        model: URDF, or the record of its links and joints.
        base, tip: names of links; chosen where not given, and `Robot.notes` says how.
        as_written: take every number literally; else structure that holds but for noise is exact, with a note.

    Raises:
        RobotError: as `from_urdf`.
    """
    if hasattr(model, "robot"):
        record = model.robot
    else:
        record = model
    name = visible(str(record.name or "robot"))
    links = {str(link.name): 0 for link in record.links}
    origins: dict[str, Array] = {}
    joints = {}
    for joint in record.joints:
        key = str(joint.name)
        if joint.origin is not None:
            origins[key] = rigid(joint.origin, f"yourdfpy model {name!r}, joint {key!r}, origin")
        joints[key] = TreeJoint(key, str(joint.type), str(joint.parent), str(joint.child), _urdf_element(joint))
    tree = connect_links(Tree(name, f"yourdfpy model {name!r}", links, joints))
    return from_tree(tree, "yourdfpy", base=base, tip=tip, as_written=as_written, origins=origins)


def to_yourdfpy(robot: Robot) -> Any:
    """A `yourdfpy.URDF` of the arm, from a link named as its base to one named as its tip, joints that follow included.

    Its `cfg` is the arm's configuration. Links have no shapes; their frames have the axes of the base at q = 0.

    Raises:
        MissingExtraError: yourdfpy is not installed.
        RobotError: a helical joint.
    """
    yourdfpy = _package("yourdfpy", "yourdfpy", "cross")
    items, tip = axis_frames(robot, "URDF", mimics=True)
    links, joints = [yourdfpy.Link(robot.base)], []
    for joint, step, axis, link in items:
        origin = np.eye(4)
        origin[:3, 3] = step
        kind, limit = _yourdfpy_limit(yourdfpy, joint)
        follows = None
        if joint.mimic is not None:
            follows = yourdfpy.urdf.Mimic(joint.mimic.leader, joint.mimic.multiplier, joint.mimic.offset)
        joints.append(yourdfpy.Joint(joint.name, kind, links[-1].name, link, origin, axis.copy(),
                                     limit=limit, mimic=follows))  # fmt: skip
        links.append(yourdfpy.Link(link))
    names = {joint.name for joint in robot.joints}
    last = f"{robot.tip} (fixed)"
    while last in names:
        last += "_"
    joints.append(yourdfpy.Joint(last, "fixed", links[-1].name, robot.tip, tip))
    links.append(yourdfpy.Link(robot.tip))
    record = yourdfpy.Robot(robot.name, links, joints)
    return yourdfpy.URDF(robot=record, load_meshes=False, load_collision_meshes=False)


def _yourdfpy_limit(yourdfpy: Any, joint: Joint) -> tuple[str, Any]:
    """The type of a joint in URDF and its limit; None where a joint that turns for ever has no largest rate."""
    most = 2.0 * RANGE[joint.kind.measure]  # what is beyond the range reads as no limit
    lower, upper = max(joint.lower, -most), min(joint.upper, most)
    rate = None
    if joint.velocity != inf:
        rate = joint.velocity
    if joint.slides:
        return "prismatic", yourdfpy.urdf.Limit(effort=0.0, velocity=rate, lower=lower, upper=upper)
    if joint.lower != -inf or joint.upper != inf:
        return "revolute", yourdfpy.urdf.Limit(effort=0.0, velocity=rate, lower=lower, upper=upper)
    if rate is None:
        return "continuous", None
    return "continuous", yourdfpy.urdf.Limit(effort=0.0, velocity=rate)


def _urdf_element(joint: Any) -> Element:
    """The elements of a URDF joint that `from_tree` reads text of: axis, limit, mimic; numbers keep their bits."""
    children = []

    def add(tag: str, **given: Any) -> None:
        written = {key: value if isinstance(value, str) else repr(float(value))
                   for key, value in given.items() if value is not None}  # fmt: skip
        children.append(Element(tag, written, 0))

    if joint.axis is not None:
        add("axis", xyz=" ".join(repr(float(part)) for part in joint.axis))
    if joint.limit is not None:
        add("limit", lower=joint.limit.lower, upper=joint.limit.upper, velocity=joint.limit.velocity)
    if joint.mimic is not None:
        follows = joint.mimic
        add("mimic", joint=str(follows.joint), multiplier=follows.multiplier, offset=follows.offset)
    return Element("joint", {}, 0, children)
