"""A tree of links and joints, whatever it was read from; the chain from a base to a tip, and the arm it makes.

Every reader of a foreign format hands over a `Tree`, and a function that gives the `Motion` of a joint on the chain.
Where the user names neither end, what was chosen is noted, and nothing is guessed where several would do.
"""

from __future__ import annotations

import difflib
import re
import shlex
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from typing import NoReturn

import numpy as np

from rankdrop.errors import RobotError
from rankdrop.robot.dh import turn_notes
from rankdrop.robot.files import Element, name_of_file
from rankdrop.robot.model import Array, Joint, JointKind, Mimic, Robot, Source, check_joints, screw_of
from rankdrop.robot.note import NoteOn, RobotNote
from rankdrop.robot.quantities import Angles, count
from rankdrop.robot.square_up import as_intended
from rankdrop.robot.transform import about_axis, times, translation

NOWHERE = Element("joint", {}, 0)
"""The element of a joint from a source that keeps no lines."""

_TIP_NAMES = tuple(
    re.compile(pattern, re.IGNORECASE)
    for pattern in (
        r"tool_?0$",
        r"(^|_)tcp(_link|_frame)?$|(^|_)tool(_link|_frame|_center_point)?$",
        r"(^|_)(ee|eef|end_?effector)(_link|_frame)?$",
        r"grasp|pinch|gripper_frame",
        r"flange|attachment",
        r"(hand|gripper|palm)(_link|_base|_base_link)?$",
    )
)
"""Names that say "this is the tip", best first."""
_JAW = re.compile(r"grip|finger|jaw|claw", re.IGNORECASE)
_WRIST = re.compile(r"wrist|roll|rot|yaw|pitch|flex", re.IGNORECASE)

_HANDS = re.compile(r"hand|arm|grip|palm|wrist|tool|tcp|flange|ee_|eef|effector", re.IGNORECASE)
_MOST_LIMBS = 12
"""So many limbs are listed."""


@dataclass(frozen=True, slots=True)
class TreeJoint:
    """A joint between two links; `element` holds its numbers."""

    name: str
    kind: str  # as written in the file
    parent: str
    child: str
    element: Element = NOWHERE

    @property
    def moves(self) -> bool:
        """Everything that is not said to be fixed moves."""
        return self.kind != "fixed"


@dataclass(frozen=True)
class Tree:
    """Links and joints, checked: names unique, one parent per link, no cycle.

    A joint that names a link which is not in the file stands in `broken`, with the end that is missing.
    """

    name: str
    file: str
    links: dict[str, int]  # name -> line
    joints: dict[str, TreeJoint]
    above: dict[str, TreeJoint] = field(default_factory=dict)  # link -> the joint that carries it
    below: dict[str, list[TreeJoint]] = field(default_factory=dict)  # link -> the joints on it
    broken: list[tuple[TreeJoint, str]] = field(default_factory=list)  # joint, "parent" or "child"

    def place_of(self, joint: TreeJoint, part: str = "") -> str:
        """Place of a joint, or of one of its elements, for errors: file, line, element, joint."""
        element = (joint.element.first(part) if part else None) or joint.element
        if element is joint.element:
            tag = ""
        else:
            tag = f"<{element.tag}> of "
        if element.line:
            line = f"line {element.line}, "
        else:
            line = ""
        return f"{self.file}, {line}{tag}joint {joint.name!r}"

    def below_and(self, link: str) -> list[str]:
        """A link and all links below it, nearest first."""
        order = [link]
        for above in order:  # grows while it is walked
            order.extend(joint.child for joint in self.below.get(above, ()))
        return order

    def root_of(self, link: str) -> str:
        """The link at the top of the tree that holds `link`."""
        while link in self.above:
            link = self.above[link].parent
        return link

    def path(self, base: str, tip: str) -> list[TreeJoint]:
        """Joints from `base` down to `tip`.

        Raises:
            RobotError: `tip` is not below `base`.
        """
        path: list[TreeJoint] = []
        link = tip
        while link != base:
            if link not in self.above:
                above = ", ".join(joint.parent for joint in path)
                if above:
                    allowed = f"a base among: {above}"
                else:
                    allowed = f"another tip: {tip!r} is a root, no joint carries it"
                raise RobotError(
                    f"the tip {tip!r} is not below the base {base!r}", where=self.file, allowed=allowed,
                    mend="exchange base and tip" if tip in self._carriers(base) else None,
                )
            path.append(self.above[link])
            link = self.above[link].parent
        return path[::-1]

    def _carriers(self, link: str) -> list[str]:
        carriers = []
        while link in self.above:
            link = self.above[link].parent
            carriers.append(link)
        return carriers

    def check_link(self, link: str, label: str) -> None:
        """Refuse a link that is not in the file.

        Raises:
            RobotError: with names that are close, or all of them where there are few.
        """
        if link not in self.links:
            hint = _hint(link, self.links)
            raise RobotError(f"there is no link for the {label}", where=self.file, got=repr(link), **hint)


def read_tree(root: Element, file: str) -> Tree:
    """The tree of the links and joints under <robot>.

    Raises:
        RobotError: not a URDF, names missing or used twice, two parents, a cycle.
    """
    if root.tag != "robot":
        raise RobotError(
            "this is not a URDF", where=f"{file}, line {root.line}", got=f"<{root.tag}>", allowed="<robot> as root"
        )
    links: dict[str, int] = {}
    joints: dict[str, TreeJoint] = {}
    for element in root.children:
        tag = element.tag.rpartition(":")[2]  # <drake:joint> is a joint, of a type that is not known here
        if tag not in {"link", "joint"}:
            continue
        name = element.attributes.get("name", "")
        place = f"{file}, line {element.line}, <{element.tag}>"
        if not name:
            raise RobotError(f"a {tag} has no name", where=place, mend='add name="…"')
        if name in (links if tag == "link" else joints):
            if tag == "link":
                first = links[name]
            else:
                first = joints[name].element.line
            raise RobotError(
                f"two {tag}s have the name {name!r}", where=place, got=f"the first on line {first}", mend="rename one"
            )
        if tag == "link":
            links[name] = element.line
        else:
            joints[name] = _joint(name, element, file)
    return connect_links(Tree(root.attributes.get("name", ""), file, links, joints))


def connect_links(tree: Tree) -> Tree:
    """The tree with its joints hung on its links; those that name a link which is not there are in `broken`.

    Raises:
        RobotError: two parents, a cycle.
    """
    for joint in tree.joints.values():
        missing = [end for end, link in (("parent", joint.parent), ("child", joint.child)) if link not in tree.links]
        if missing:
            tree.broken.append((joint, missing[0]))
            continue
        if joint.child in tree.above:
            raise RobotError(
                f"the link {joint.child!r} has two parents", where=tree.place_of(joint, "child"),
                got=f"joints {tree.above[joint.child].name!r} and {joint.name!r}", allowed="a tree",
                mend="take out one of the two joints",
            )
        tree.above[joint.child] = joint
        tree.below.setdefault(joint.parent, []).append(joint)
    _refuse_cycles(tree)
    return tree


def _joint(name: str, element: Element, file: str) -> TreeJoint:
    ends = []
    for end in ("parent", "child"):
        part = element.first(end)
        if part is None:
            link = ""
        else:
            link = part.attributes.get("link", "")
        if not link:
            if part is None:
                line = element.line
            else:
                line = part.line
            raise RobotError(
                f"the joint names no {end} link", where=f"{file}, line {line}, joint {name!r}",
                mend=f'add <{end} link="…"/>',
            )
        ends.append(link)
    return TreeJoint(name, element.attributes.get("type", ""), ends[0], ends[1], element)


def _refuse_cycles(tree: Tree) -> None:
    sound: set[str] = set()
    for start in tree.links:
        walked: dict[str, None] = {}
        link = start
        while link in tree.above and link not in sound:
            if link in walked:
                order = list(walked)
                ring = [tree.above[name] for name in order[order.index(link) :]]
                first = min(ring, key=lambda joint: joint.element.line)
                raise RobotError(
                    "the links form a cycle", where=tree.place_of(first), got=", ".join(joint.name for joint in ring),
                    allowed="a tree", mend="cut the loop at one joint",
                )
            walked[link] = None
            link = tree.above[link].parent
        sound.update(walked)


def _hint(name: str, known: Iterable[str]) -> dict[str, str]:
    names = sorted(known)
    same = [known for known in names if known.lower() == name.lower()]
    close = same or difflib.get_close_matches(name, names, n=3)
    hint = {"allowed": ", ".join(names) if len(names) <= 40 else f"{len(names)} links, such as {', '.join(names[:10])}"}
    if close:
        hint["mend"] = f"did you mean {' or '.join(close)}?"
    return hint


@dataclass(frozen=True, slots=True)
class Ends:
    """Base and tip, the joints between them, and what was chosen for the user."""

    base: str
    tip: str
    path: list[TreeJoint]
    notes: list[RobotNote]


def choose_ends(tree: Tree, base: str | None, tip: str | None) -> Ends:
    """Base and tip of the chain.

    Base: the root of the tree (of `tip` if given). Tip: the end that most moving joints lead to. Where several branches
    are equally long, or three and more meet, and all are shorter than the chain that carries them, they are fingers and
    the arm ends there; so it does before a single last joint that is named as a jaw. Several arms of equal length are
    an error that lists their tips. Among the links fixed together at the end of an arm, a usual name (tool0, tcp,
    ee_link, flange, hand …) decides, then the only last one, then the link of the last joint itself.

    Raises:
        RobotError: a link that is not there, several roots or branches to choose from, a tip not below the base.
    """
    notes: list[RobotNote] = []
    if tip is not None:
        tree.check_link(tip, "tip")
    notes.extend(_leave_out_broken(tree, base, tip))
    if base is None:
        if tip is None:
            base = _root(tree)
        else:
            base = tree.root_of(tip)
        notes.append(RobotNote(NoteOn.BASE, base))
    else:
        tree.check_link(base, "base")
    if tip is None:
        tip, note = _default_tip(tree, base)
        notes.append(note)
    path = tree.path(base, tip)
    if not any(joint.moves for joint in path):
        raise RobotError(
            f"there is no moving joint between {base!r} and {tip!r}", where=tree.file, mend="name another base or tip",
            typed="name another --base or --tip",
        )
    return Ends(base, tip, path, notes)


def _leave_out_broken(tree: Tree, base: str | None, tip: str | None) -> list[RobotNote]:
    """Notes on joints that name a link which is not in the file, where the chain does not need them.

    A joint without a parent link is at the root of what it carries: a chain that starts at a link below it does not
    need it.

    Raises:
        RobotError: neither tip nor base tell that such a joint is no part of the arm; or it carries the chain.
    """
    notes = []
    for joint, end in tree.broken:
        carries = tip is not None and base is None and tree.root_of(tip) == joint.child
        starts_below = base is not None and end == "parent" and tree.root_of(base) == joint.child
        if carries or (tip is None and not starts_below):
            _refuse_broken(tree, joint, end)
        notes.append(RobotNote(NoteOn.LEFT_OUT, joint.name, getattr(joint, end), end=end))
    return notes


def _refuse_broken(tree: Tree, joint: TreeJoint, end: str) -> NoReturn:
    """Refuse a joint that names a link which is not in the file.

    Raises:
        RobotError: always; where the parent link is missing, it names the base to start at.
    """
    link = getattr(joint, end)
    place, got, hint = tree.place_of(joint, end), repr(link), _hint(link, tree.links)
    if "mend" in hint or end == "child" or joint.child not in tree.links:
        raise RobotError(
            f"the {end} link is not in the file", where=place, got=got, allowed=hint["allowed"],
            mend=hint.get("mend", "declare it, or name a tip"),
        )  # fmt: skip
    raise RobotError(
        f"the {end} link is not in the file", where=place, got=got, allowed=hint["allowed"],
        mend=f"declare it, or start at the link below: base={joint.child!r}",
        typed=f"declare it, or start at the link below: --base {shlex.quote(joint.child)}",
    )


def _root(tree: Tree) -> str:
    roots = [link for link in tree.links if link not in tree.above]
    moving = [link for link in roots if _most_moving(tree, link)[link]]
    if len(moving) == 1:
        return moving[0]
    if not moving:
        raise RobotError("there is no moving joint in the file", where=tree.file, allowed="at least one")
    raise RobotError("there are several root links", where=tree.file, got=", ".join(moving),
                     mend=f"name the base: base={moving[0]!r}",
                     typed=f"name the base: --base {shlex.quote(moving[0])}")  # fmt: skip


def _most_moving(tree: Tree, base: str) -> dict[str, int]:
    """For each link at or below `base`, the largest number of moving joints on a way down from it."""
    most: dict[str, int] = {}
    for link in reversed(tree.below_and(base)):
        most[link] = max((joint.moves + most[joint.child] for joint in tree.below.get(link, ())), default=0)
    return most


@dataclass(frozen=True, slots=True)
class _Limb:
    """Where a chain ends by itself.

    Attributes:
        link: the last one.
        body: it and what is fixed to it, with the number of fixed joints between.
        passed: moving joints on the way from the base.
        gripper: joints of fingers after it, which are left out.
    """

    link: str
    body: dict[str, int]
    passed: int
    gripper: list[TreeJoint]


def _default_tip(tree: Tree, base: str) -> tuple[str, RobotNote]:
    limbs = _limbs(tree, base)
    longest = max(limb.passed for limb in limbs)
    ends = [limb for limb in limbs if limb.passed == longest]
    if len(ends) > 1:
        raise _several_limbs(tree, base, limbs)
    tip, fixed = _name_of_tip(tree, ends[0].link, ends[0].body)
    gripper = tuple(joint.name for joint in ends[0].gripper)
    return tip, RobotNote(NoteOn.TIP, tip, number=longest, fixed=fixed, gripper=gripper)


def _several_limbs(tree: Tree, base: str, limbs: list[_Limb]) -> RobotError:
    """The error that lists every limb with its number of joints: hands before feet, then the longest first."""
    named = [(_name_of_tip(tree, limb.link, limb.body)[0], limb.passed) for limb in limbs if limb.passed > 0]
    named.sort(key=lambda limb: (_HANDS.search(limb[0]) is None, -limb[1]))
    listed = [f"{tip} ({count(passed, 'joint')})" for tip, passed in named[:_MOST_LIMBS]]
    if len(named) > _MOST_LIMBS:
        more = [f"and {len(named) - _MOST_LIMBS} more"]
    else:
        more = []
    first = named[0][0]
    return RobotError(
        f"several limbs start at {base!r}", where=tree.file, got=f"tips {', '.join(listed + more)}",
        mend=f"name the tip: tip={first!r}", typed=f"name the tip: --tip {shlex.quote(first)}",
    )


def _limbs(tree: Tree, base: str) -> list[_Limb]:
    """Every end below `base`, grippers not counted, in the order of the file."""
    most = _most_moving(tree, base)
    limbs = []
    waiting = [(base, 0)]
    while waiting:
        link, passed = waiting.pop()
        body = _fixed_together(tree, link)
        branches = [joint for part in body for joint in tree.below.get(part, ()) if joint.moves]
        if not branches or _is_gripper(branches, most, passed):
            limbs.append(_Limb(link, body, passed, branches))
        else:
            waiting.extend((joint.child, passed + 1) for joint in reversed(branches))
    return limbs


def _is_gripper(branches: list[TreeJoint], most: dict[str, int], passed: int) -> bool:
    """Are these, after `passed` moving joints, fingers or a jaw?"""
    depths = [1 + most[joint.child] for joint in branches]
    depth = max(depths, default=0)
    hand = 0 < depth < passed and (depths.count(depth) > 1 or len(branches) > 2)
    if len(branches) == 1:
        names = f"{branches[0].name} {branches[0].child}"
    else:
        names = ""
    jaw = _JAW.search(names) is not None and _WRIST.search(names) is None
    return hand or (depth == 1 and passed >= 4 and jaw)


def _fixed_together(tree: Tree, link: str) -> dict[str, int]:
    """`link` and what is fixed to it below, with the number of fixed joints from `link`."""
    body = {link: 0}
    for part in (order := [link]):
        for joint in tree.below.get(part, ()):
            if not joint.moves:
                body[joint.child] = body[part] + 1
                order.append(joint.child)
    return body


def _name_of_tip(tree: Tree, link: str, body: dict[str, int]) -> tuple[str, tuple[str, ...]]:
    """The tip among the links fixed together at the end of an arm, and the other ones."""
    last = [part for part in body if all(joint.moves for joint in tree.below.get(part, ()))]
    tip = last[0] if len(last) == 1 else link
    for pattern in _TIP_NAMES:
        named = [part for part in body if pattern.search(part)]
        if named:
            tip = max(named, key=lambda part: body[part])  # the first of the farthest ones
            break
    others = [part for part in body if part != tip]
    return tip, tuple(others)


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """How a link moves in the link before it.

    Attributes:
        origin: (4, 4) pose in which the file shows the link, up to its joint.
        kind: of the joint; None where nothing moves.
        axis: (3,) of length 1, in the frame at `origin`.
        anchor: (3,) a point of the axis in that frame [m].
        pitch: of a helical joint [m/rad].
        ref: value of the joint in the pose of the file [rad, m].
        lower, upper, velocity, mimic: as in `Joint`.
    """

    origin: Array
    kind: JointKind | None = None
    axis: Array = field(default_factory=lambda: np.zeros(3))
    anchor: Array = field(default_factory=lambda: np.zeros(3))
    pitch: float = 0.0
    ref: float = 0.0
    lower: float = -inf
    upper: float = inf
    velocity: float = inf
    mimic: Mimic | None = None

    def to_zero(self, pose: Array) -> Array:
        """(4, 4) pose of the link at q = 0, which the file shows at `pose` with q = `ref`."""
        if self.ref == 0.0:
            return pose
        if self.kind is JointKind.PRISMATIC:
            return times(pose, translation(*(-self.ref * self.axis)))
        turn = about_axis(self.axis, -self.ref)
        return times(pose, translation(*self.anchor), turn, translation(*-self.anchor))


def chain_robot(
    tree: Tree, ends: Ends, source: str, motion_of: Callable[[TreeJoint], Motion], angles: Angles,
    notes: list[RobotNote],
    frames: tuple[Array, Array] = (np.eye(4), np.eye(4)),
) -> Robot:
    """The arm that a chain of a tree makes, its structure made exact where it holds but for noise.

    Args:
        tree, ends: where the chain lies.
        source: kind of the source (`Source.kind`).
        motion_of: called with each joint of the chain, in order.
        angles: what decimals were taken for.
        notes: of the reader, which may add some while motions are read.
        frames: pose of the first link in the base, and of the tip in the last link.

    Raises:
        RobotError: as `motion_of`; too many joints; a number that is not finite.
    """
    check_joints(sum(step.moves for step in ends.path), tree.file, steps=len(ends.path))
    pose, joints = frames[0], []
    for step in ends.path:
        motion = motion_of(step)
        if not all(np.isfinite(part).all() for part in (motion.origin, motion.axis, motion.anchor, motion.ref)):
            raise RobotError("the place of a joint is not finite", where=tree.place_of(step), allowed="finite numbers")
        pose = times(pose, motion.origin)
        if motion.kind is not None:
            point = pose[:3, 3] + times(pose[:3, :3], motion.anchor)
            screw = screw_of(motion.kind, times(pose[:3, :3], motion.axis), point, motion.pitch)
            pose = motion.to_zero(pose)
            joints.append(Joint(step.name, motion.kind, screw, motion.lower, motion.upper, motion.velocity, pose,
                                motion.mimic, step.child))  # fmt: skip
    name = tree.name or name_of_file(Path(tree.file))
    notes = [*ends.notes, *notes, *turn_notes(joints, units=False)]
    robot = Robot(name, tuple(joints), times(pose, frames[1]), source=Source(source, tree.file), base=ends.base,
                  tip=ends.tip, notes=tuple(notes), about=f"{ends.base} to {ends.tip}")  # fmt: skip
    return as_intended(robot, angles)
