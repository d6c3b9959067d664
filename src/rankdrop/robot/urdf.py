"""Robots from URDF: the chain from a base link to a tip link, fixed joints folded, numbers finite.

Mimic joints: who leads, who follows, and what becomes of a leader outside the chain.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Mapping
from math import inf, isfinite
from pathlib import Path

import numpy as np

from rankdrop.errors import RobotError
from rankdrop.robot.files import LONGEST_TEXT, RANGE, read_text, read_xml
from rankdrop.robot.model import Array, JointKind, Mimic, Robot
from rankdrop.robot.note import NoteOn, RobotNote
from rankdrop.robot.quantities import Angles, in_range
from rankdrop.robot.transform import from_xyz_rpy, norm
from rankdrop.robot.tree import Motion, Tree, TreeJoint, chain_robot, choose_ends, read_tree

_NUMBER = re.compile(r"[+-]?(\d++\.?\d*+|\.\d++)([eE][+-]?\d++)?", re.ASCII)

_KINDS = {"revolute": JointKind.REVOLUTE, "continuous": JointKind.REVOLUTE, "prismatic": JointKind.PRISMATIC}
_NOT_READ = frozenset({"visual", "collision", "inertial", "material", "transmission", "gazebo", "sensor"})


def number(text: str, where: str, key: str, measure: str = "number") -> float:
    """One finite number in the range of its measure.

    Args:
        text: of the attribute.
        where: file, line, element.
        key: name of the attribute.
        measure: "angle" [rad], "length" [m] or "number".

    Raises:
        RobotError: not a number, not finite, or too large.
    """
    return in_range(finite(text, where, key), measure, where=f"{where}, {key}", got=text.strip())


def finite(text: str, where: str, key: str) -> float:
    """One finite number of any size.

    Raises:
        RobotError: not a number, or not finite.
    """
    word = text.strip()
    if len(word) <= LONGEST_TEXT and _NUMBER.fullmatch(word):
        value = float(word)
    else:
        value = None
    if value is None or not isfinite(value):
        limits = key in {"lower", "upper", "velocity"}
        raise RobotError(
            f"{key} is not a finite number", where=where, got=repr(text[:60]), allowed="a finite number",
            mend="leave the attribute out where there is no limit" if limits else "write the number out",
        )
    return value


def three(text: str, where: str, key: str, measure: str = "number") -> list[float]:
    """Three finite numbers in the range of their measure.

    Raises:
        RobotError: another count, or one of them is not a finite number, or too large.
    """
    words = text.split(None, 3)
    if len(words) != 3:
        raise RobotError(f"{key} is three numbers", where=where, got=repr(text[:60]), allowed=f'{key}="0 0 0"')
    return [number(word, where, key, measure) for word in words]


def resolve_mimics(tree: Tree, chain: list[TreeJoint]) -> tuple[dict[str, Mimic], list[RobotNote]]:
    """How the followers among the moving joints of the chain depend on its variables.

    A follower of a follower is traced to the first leader. Where that leader is outside the chain, the first follower
    becomes a variable and leads the others: with q_j = m_j L + o_j, q_j = (m_j/m_1) q_1 + o_j − (m_j/m_1) o_1.

    Returns:
        follower's name -> Mimic with a leader in the chain, and notes.

    Raises:
        RobotError: a leader that is not in the file or fixed, a circle of leaders, a multiplier of zero.
    """
    inside = {joint.name for joint in chain}
    mimics: dict[str, Mimic] = {}
    outside: dict[str, tuple[str, Mimic]] = {}  # leader outside -> its first follower and how that one follows
    notes: list[RobotNote] = []
    known: dict[str, Mimic] = {}
    for joint in chain:
        if joint.element.first("mimic") is None:
            continue
        traced = _trace(tree, joint, known)
        leader = traced.leader
        if leader in inside:
            mimics[joint.name] = traced
            notes.append(RobotNote(NoteOn.FOLLOWS, joint.name, leader))
        elif leader not in outside:
            outside[leader] = (joint.name, traced)
            notes.append(RobotNote(NoteOn.FOLLOWS_OUTSIDE, joint.name, leader))
        else:
            first, lead = outside[leader]
            ratio = traced.multiplier / lead.multiplier
            mimics[joint.name] = Mimic(first, ratio, traced.offset - ratio * lead.offset)
            notes.append(RobotNote(NoteOn.FOLLOWS_TOGETHER, joint.name, leader, instead=first))
    return mimics, notes


def _trace(tree: Tree, joint: TreeJoint, known: dict[str, Mimic]) -> Mimic:
    """How a follower depends on the joint at the end of its leaders.

    Args:
        tree: with all leaders.
        joint: the follower.
        known: what was traced before, by the follower's name; what is traced now is added, so that a long row of
            followers is walked once.
    """
    steps: list[tuple[str, float, float]] = []  # follower, multiplier, offset
    passed = {joint.name: None}
    current = joint
    while current.name not in known and (element := current.element.first("mimic")) is not None:
        where = tree.place_of(current, "mimic")
        name = element.attributes.get("joint", "")
        if name not in tree.joints:
            raise RobotError("the mimic joint follows a joint that is not in the file", where=where, got=repr(name))
        if name in passed:
            circle = " -> ".join([*passed, name])
            raise RobotError("mimic joints follow one another in a circle", where=where, got=circle)
        factor = number(element.attributes.get("multiplier", "1"), where, "multiplier")
        if current.kind == "prismatic":
            measure = "length"
        else:
            measure = "angle"
        shift = number(element.attributes.get("offset", "0"), where, "offset", measure)
        if factor == 0.0:
            raise RobotError(
                "the multiplier of a mimic joint is zero", where=where, got=0, allowed="a number other than 0",
                mend='a joint that never moves has type "fixed"',
            )
        steps.append((current.name, factor, shift))
        current = tree.joints[name]
        passed[name] = None
        if not current.moves:
            raise RobotError("the mimic joint follows a fixed joint", where=where, got=repr(name))
    last = known.get(current.name) or Mimic(current.name, 1.0, 0.0)
    for name, factor, shift in reversed(steps):
        last = Mimic(last.leader, factor * last.multiplier, factor * last.offset + shift)
        known[name] = last
    return last


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
    masses and joints outside the chain are ignored. Missing limits are ±inf, with a note. Angles that are rounded
    decimals of multiples of 15°, and structure that holds but for noise, are exact, with a note (see `as_intended`).

    Args:
        source: path, or the text itself (anything that starts with "<").
        base, tip: names of links; chosen where not given, and `Robot.notes` says how (see `tree.choose_ends`).
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
    return from_tree(tree, "urdf", base=base, tip=tip, as_written=as_written)


def from_tree(
    tree: Tree,
    kind: str,
    *,
    base: str | None,
    tip: str | None,
    as_written: bool,
    origins: Mapping[str, Array] | None = None,
) -> Robot:
    """The chain from `base` to `tip` of a tree of links and joints.

    Args:
        tree: with the elements of a URDF.
        kind: of the source (`Source.kind`).
        base, tip: names of links; None: chosen.
        as_written: take every number literally.
        origins: (4, 4) pose of each joint in the frame of its parent link, by joint (where none is told, they
            coincide); None reads the elements.

    Raises:
        RobotError: names file, line, element, joint, value and mend.
    """
    ends = choose_ends(tree, base, tip)
    mimics, notes = resolve_mimics(tree, [joint for joint in ends.path if joint.moves])
    angles = Angles(as_written)

    def motion(joint: TreeJoint) -> Motion:
        if origins is None:
            origin = joint_origin(tree, joint, angles)
        else:
            origin = origins.get(joint.name, np.eye(4))
        if not joint.moves:
            return Motion(origin)
        kind, axis = _kind(tree, joint), _axis(tree, joint, notes)
        lower, upper, velocity = _limits(tree, joint, notes)
        return Motion(origin, kind, axis, lower=lower, upper=upper, velocity=velocity, mimic=mimics.get(joint.name))

    return chain_robot(tree, ends, kind, motion, angles, notes)


def _kind(tree: Tree, joint: TreeJoint) -> JointKind:
    if joint.kind not in _KINDS:
        several = joint.kind in {"floating", "planar"}
        if several:
            what = "a joint of the chain has several freedoms"
        else:
            what = "the joint type is not known"
        plain = joint.kind.strip().lower()
        if plain in {*_KINDS, "fixed"}:
            raise RobotError(what, where=tree.place_of(joint), got=f"type {joint.kind!r}", mend=f"write {plain!r}")
        raise RobotError(
            what, where=tree.place_of(joint), got=f"type {joint.kind!r}", allowed=", ".join([*_KINDS, "fixed"]),
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
    where = tree.place_of(joint, "origin")
    for unread in ("quat_xyzw", "wxyz"):  # used by some tools instead of rpy: ignoring it would turn the axis
        if unread in element.attributes and "rpy" not in element.attributes:
            raise RobotError("the rotation is not given as rpy", where=where, got=unread, allowed="xyz, rpy")
    xyz = three(element.attributes.get("xyz", "0 0 0"), where, "xyz", "length")
    rpy = element.attributes.get("rpy", "0 0 0")
    three(rpy, where, "rpy", "angle")
    return from_xyz_rpy(xyz, [angles.take(word) for word in rpy.split()])


def _axis(tree: Tree, joint: TreeJoint, notes: list[RobotNote]) -> Array:
    element = joint.element.first("axis")
    if element is None:
        notes.append(RobotNote(NoteOn.NO_AXIS, joint.name))
        return np.array([1.0, 0.0, 0.0])  # the default of the URDF specification
    where = tree.place_of(joint, "axis")
    text = element.attributes.get("xyz", "1 0 0")
    axis = np.array(three(text, where, "xyz"))
    length = norm(axis)
    if length < 1e-9:
        raise RobotError(
            "the axis has no length", where=where, got=repr(text), allowed="a non-zero axis", mend='xyz="0 0 1"'
        )
    return axis / length


def _limits(tree: Tree, joint: TreeJoint, notes: list[RobotNote]) -> tuple[float, float, float]:
    """Lower and upper limit and the largest rate of a joint; inf: none is given."""
    element = joint.element.first("limit")
    if element is None:
        given = {}
    else:
        given = element.attributes
    where = tree.place_of(joint, "limit")
    if "velocity" in given:
        velocity = _largest_rate(_limit(joint, given, "velocity", where, notes), joint, where, notes)
    else:
        velocity = inf
    if joint.kind == "continuous":
        return -inf, inf, velocity
    if "lower" not in given and "upper" not in given:
        notes.append(RobotNote(NoteOn.NO_LIMITS, joint.name))
        return -inf, inf, velocity
    for key in ("lower", "upper"):
        if key not in given:
            notes.append(RobotNote(NoteOn.ONE_LIMIT, joint.name, end=key))
    lower, upper = (_limit(joint, given, key, where, notes) for key in ("lower", "upper"))
    if lower > upper or lower == inf or upper == -inf:
        raise RobotError(
            "lower limit above upper limit", where=where, got=f"lower {lower}, upper {upper}", allowed="lower ≤ upper",
            mend="exchange or correct the two limits",
        )
    return lower, upper, velocity


def _limit(joint: TreeJoint, given: Mapping[str, str], key: str, where: str, notes: list[RobotNote]) -> float:
    """A number of a limit; beyond the range it is how exporters write that there is no limit."""
    value = finite(given.get(key, "0"), where, key)
    if abs(value) <= RANGE["length" if joint.kind == "prismatic" else "angle"]:
        return value
    notes.append(RobotNote(NoteOn.NO_LIMIT, joint.name, end=key, value=value))
    return inf if value > 0 else -inf


def _largest_rate(velocity: float, joint: TreeJoint, where: str, notes: list[RobotNote]) -> float:
    """The largest rate of a joint; 0 and −1, written by exporters that do not know it, are read as not known.

    −1 is the default of SDF, for no limit.

    Raises:
        RobotError: another negative number.
    """
    if velocity < 0.0 and velocity != -1.0:
        raise RobotError("the largest velocity is negative", where=where, got=velocity, allowed="a rate ≥ 0")
    if velocity in (0.0, -1.0):
        notes.append(RobotNote(NoteOn.NO_RATE, joint.name, value=velocity))
        return inf
    return velocity
