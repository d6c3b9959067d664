"""Robots from and to yourdfpy objects (package yourdfpy, extra "cross")."""

from __future__ import annotations

from math import inf
from typing import Any

import numpy as np

from rankdrop.errors import MissingExtraError, visible
from rankdrop.robot.files import RANGE, Element
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.models.placed import placed
from rankdrop.robot.transform import rigid
from rankdrop.robot.urdf import from_tree
from rankdrop.robot.urdf_tree import Tree, TreeJoint, connected


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
    record = model.robot if hasattr(model, "robot") else model
    name = visible(str(record.name or "robot"))
    links = {str(link.name): 0 for link in record.links}
    origins: dict[str, Array] = {}
    joints = {}
    for joint in record.joints:
        key = str(joint.name)
        if joint.origin is not None:
            origins[key] = rigid(joint.origin, f"yourdfpy model {name!r}, joint {key!r}, origin")
        joints[key] = TreeJoint(key, str(joint.type), str(joint.parent), str(joint.child), _element(joint))
    tree = connected(Tree(name, f"yourdfpy model {name!r}", links, joints))
    return from_tree(tree, "yourdfpy", base=base, tip=tip, as_written=as_written, origins=origins)


def to_yourdfpy(robot: Robot) -> Any:
    """A `yourdfpy.URDF` of the arm, from a link named as its base to one named as its tip, joints that follow included.

    Its `cfg` is the arm's configuration. Links have no shapes; their frames have the axes of the base at q = 0.

    Raises:
        MissingExtraError: yourdfpy is not installed.
        RobotError: a helical joint.
    """
    try:
        import yourdfpy
    except ImportError:
        raise MissingExtraError("yourdfpy", "cross", "a yourdfpy model") from None
    items, tip = placed(robot, "URDF", mimics=True)
    links, joints = [yourdfpy.Link(robot.base)], []
    for item in items:
        joint, origin = item.joint, np.eye(4)
        origin[:3, 3] = item.step
        slides = joint.kind is JointKind.PRISMATIC
        free = joint.lower == -inf and joint.upper == inf
        most = 2.0 * RANGE["length" if slides else "angle"]  # what is beyond the range reads as no limit
        lower, upper = max(joint.lower, -most), min(joint.upper, most)
        rate = None if joint.velocity == inf else joint.velocity
        limit = yourdfpy.urdf.Limit(effort=0.0, velocity=rate, lower=lower, upper=upper)
        follows = None
        if joint.mimic is not None:
            follows = yourdfpy.urdf.Mimic(joint.mimic.leader, joint.mimic.multiplier, joint.mimic.offset)
        kind = "prismatic" if slides else "continuous" if free else "revolute"
        if kind == "continuous":
            limit = None if rate is None else yourdfpy.urdf.Limit(effort=0.0, velocity=rate)
        joints.append(yourdfpy.Joint(joint.name, kind, links[-1].name, item.link, origin, item.axis.copy(),
                                     limit=limit, mimic=follows))  # fmt: skip
        links.append(yourdfpy.Link(item.link))
    names = {joint.name for joint in robot.joints}
    last = f"{robot.tip} (fixed)"
    while last in names:
        last += "_"
    joints.append(yourdfpy.Joint(last, "fixed", links[-1].name, robot.tip, tip))
    links.append(yourdfpy.Link(robot.tip))
    record = yourdfpy.Robot(robot.name, links, joints)
    return yourdfpy.URDF(robot=record, load_meshes=False, load_collision_meshes=False)


def _element(joint: Any) -> Element:
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
