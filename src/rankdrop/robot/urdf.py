"""Robots from URDF: the chain from a base link to a tip link, fixed joints folded."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from math import inf
from pathlib import Path

import numpy as np

from rankdrop.errors import RobotError, visible
from rankdrop.robot.budgets import RANGE
from rankdrop.robot.digits import Angles
from rankdrop.robot.files import read_text
from rankdrop.robot.meant import as_meant
from rankdrop.robot.model import Array, Joint, JointKind, Robot, Source, check_joints
from rankdrop.robot.transform import from_xyz_rpy
from rankdrop.robot.urdf_ends import choose_ends
from rankdrop.robot.urdf_mimic import resolve_mimics
from rankdrop.robot.urdf_numbers import finite, three
from rankdrop.robot.urdf_tree import Tree, TreeJoint, read_tree
from rankdrop.robot.xml_file import read_xml

_KINDS = {"revolute": JointKind.REVOLUTE, "continuous": JointKind.REVOLUTE, "prismatic": JointKind.PRISMATIC}
_NOT_READ = frozenset({"visual", "collision", "inertial", "material", "transmission", "gazebo", "sensor"})


def from_urdf(
    source: str | Path,
    *,
    base: str | None = None,
    tip: str | None = None,
    file: str | None = None,
    as_written: bool = False,
    edit: Callable[[Tree], None] | None = None,
) -> Robot:
    """A robot from a URDF file or its text.

    Only the kinematics of the chain from `base` to `tip` is read: joint types, origins, axes, limits and mimic. Meshes,
    masses and joints outside the chain are not looked at. Missing limits are ±inf, with a note. Angles that are rounded
    decimals of multiples of 15°, and structure that holds but for noise, are taken as exact, with a note (`as_meant`).

    Args:
        source: path, or the text itself (anything that starts with "<").
        base, tip: names of links; chosen where not given, and `Robot.notes` says how (see `urdf_ends.choose_ends`).
        file: name of the text in errors and in `Robot.source`.
        as_written: take every number literally.
        edit: called with the tree before anything is computed of it; may change attributes of its elements.

    Raises:
        RobotError: names file, line, element, joint, value and mend.

    Example:
        >>> robot = from_urdf('''<robot name="r"> <link name="a"/> <link name="b"/> <joint name="j" type="continuous">
        ...     <parent link="a"/> <child link="b"/> <axis xyz="0 0 1"/> </joint> </robot>''')
        >>> robot.joints[0].screw
        array([0., 0., 0., 0., 0., 1.])
    """
    if isinstance(source, str) and source.lstrip("\ufeff \t\r\n").startswith("<"):
        text, place = source.lstrip("\ufeff \t"), file or "URDF text"
    else:
        text, place = read_text(Path(source)), file or str(source)
    tree = read_tree(read_xml(text, place, _NOT_READ), place)
    if edit is not None:
        edit(tree)
    ends = choose_ends(tree, base, tip)
    moving = [joint for joint in ends.path if joint.moves]
    check_joints(len(moving), place, steps=len(ends.path))
    mimics, notes = resolve_mimics(tree, moving)
    pose = np.eye(4)
    angles = Angles(as_written)
    joints = []
    for joint in ends.path:
        pose = pose @ joint_origin(tree, joint, angles)
        if joint.moves:
            kind = _kind(tree, joint)
            lower, upper, velocity = _limits(tree, joint, notes)
            screw = _screw(kind, _axis(tree, joint), pose)
            joints.append(Joint(joint.name, kind, screw, lower, upper, velocity, pose, mimics.get(joint.name)))
    found = Robot(
        tree.name or visible(Path(place).stem), tuple(joints), pose, source=Source("urdf", place),
        base=ends.base, tip=ends.tip, notes=(*ends.notes, *notes), about=f"{ends.base} to {ends.tip}",
    )
    return as_meant(found, angles)


def _kind(tree: Tree, joint: TreeJoint) -> JointKind:
    if joint.kind not in _KINDS:
        several = joint.kind in {"floating", "planar"}
        what = "a joint of the chain has several freedoms" if several else "the joint type is not known"
        raise RobotError(
            what, where=tree.where(joint), got=f"type {joint.kind!r}", allowed=", ".join([*_KINDS, "fixed"]),
            mend=f"name a base below it, base={joint.child!r}, or a tip above it, or describe it by simple joints",
            typed=f"name a base below it, --base {shlex.quote(joint.child)}, or a --tip above it",
        )
    return _KINDS[joint.kind]


def joint_origin(tree: Tree, joint: TreeJoint, angles: Angles) -> Array:
    """(4, 4) pose of a joint in the frame of its parent link, its rpy as `angles` reads it.

    Raises:
        RobotError: not three finite numbers, or a rotation that is not given as rpy.
    """
    element = joint.element.first("origin")
    if element is None:
        return np.eye(4)
    where = tree.where(joint, "origin")
    for unread in ("quat_xyzw", "wxyz"):  # used by some tools instead of rpy: ignoring it would turn the axis
        if unread in element.attributes and "rpy" not in element.attributes:
            raise RobotError("the rotation is not given as rpy", where=where, got=unread, allowed="xyz, rpy")
    xyz = three(element.attributes.get("xyz", "0 0 0"), where, "xyz", "length")
    rpy = element.attributes.get("rpy", "0 0 0")
    three(rpy, where, "rpy", "angle")
    return from_xyz_rpy(xyz, [angles.take(word) for word in rpy.split()])


def _axis(tree: Tree, joint: TreeJoint) -> Array:
    element = joint.element.first("axis")
    if element is None:
        return np.array([1.0, 0.0, 0.0])  # the default of the URDF specification
    where = tree.where(joint, "axis")
    text = element.attributes.get("xyz", "1 0 0")
    axis = np.array(three(text, where, "xyz"))
    length = float(np.linalg.norm(axis))
    if length < 1e-9:
        raise RobotError(
            "the axis has no length", where=where, got=repr(text), allowed="a non-zero axis", mend='xyz="0 0 1"'
        )
    return axis / length


def _screw(kind: JointKind, axis: Array, pose: Array) -> Array:
    direction = pose[:3, :3] @ axis
    if kind is JointKind.PRISMATIC:
        return np.concatenate([direction, np.zeros(3)])
    return np.concatenate([np.cross(pose[:3, 3], direction), direction]) + 0.0  # + 0.0 turns −0 into 0


def _limits(tree: Tree, joint: TreeJoint, notes: list[str]) -> tuple[float, float, float]:
    element = joint.element.first("limit")
    given = {} if element is None else element.attributes
    where = tree.where(joint, "limit")
    most = RANGE["length" if joint.kind == "prismatic" else "angle"]

    def read(key: str) -> float:
        """The number; beyond the range it is how exporters write that there is no limit."""
        value = finite(given.get(key, "0"), where, key)
        if abs(value) <= most:
            return value
        notes.append(f"joint {joint.name!r}: {key} {value:g} is taken as no limit")
        return inf if value > 0 else -inf

    velocity = read("velocity") if "velocity" in given else inf
    if velocity < 0.0:
        raise RobotError("the largest velocity is negative", where=where, got=velocity, allowed="a rate ≥ 0")
    if velocity == 0.0:  # written by exporters that do not know it
        velocity = inf
        notes.append(f"joint {joint.name!r}: velocity 0 is taken as not known")
    if joint.kind == "continuous":
        return -inf, inf, velocity
    if "lower" not in given and "upper" not in given:
        notes.append(f"joint {joint.name!r} has no limits: it is taken as unlimited")
        return -inf, inf, velocity
    for key in ("lower", "upper"):
        if key not in given:
            notes.append(f"joint {joint.name!r} has no {key} limit: it is 0, the default of URDF")
    lower, upper = read("lower"), read("upper")
    if lower > upper or lower == inf or upper == -inf:
        raise RobotError(
            "lower limit above upper limit", where=where, got=f"lower {lower}, upper {upper}", allowed="lower ≤ upper",
            mend="exchange or correct the two limits",
        )
    return lower, upper, velocity
