"""The tree of a URDF or MJCF: which joint joins which links. Structure only, no numbers."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass, field

from rankdrop.errors import RobotError
from rankdrop.robot.xml_file import Element


@dataclass(frozen=True, slots=True)
class TreeJoint:
    """A joint between two links; `element` holds its numbers."""

    name: str
    kind: str  # as written in the file
    parent: str
    child: str
    element: Element  # of line 0 where the source keeps no lines

    @property
    def moves(self) -> bool:
        """Everything that is not said to be fixed moves."""
        return self.kind != "fixed"


@dataclass(frozen=True)
class Tree:
    """Links and joints, checked: names unique, every link known, one parent per link, no cycle."""

    name: str
    file: str
    links: dict[str, int]  # name -> line
    joints: dict[str, TreeJoint]
    above: dict[str, TreeJoint] = field(default_factory=dict)  # link -> the joint that carries it
    below: dict[str, list[TreeJoint]] = field(default_factory=dict)  # link -> the joints on it

    def where(self, joint: TreeJoint, part: str = "") -> str:
        """Place of a joint, or of one of its elements, for errors: file, line, element, joint."""
        element = (joint.element.first(part) if part else None) or joint.element
        tag = "" if element is joint.element else f"<{element.tag}> of "
        line = f"line {element.line}, " if element.line else ""
        return f"{self.file}, {line}{tag}joint {joint.name!r}"

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
                allowed = f"a base among: {above}" if above else f"another tip: {tip!r} is a root, no joint carries it"
                raise RobotError(
                    f"the tip {tip!r} is not below the base {base!r}", where=self.file, allowed=allowed,
                    mend="exchange base and tip" if tip in self._carriers(base) else None,
                )
            path.append(self.above[link])
            link = self.above[link].parent
        return path[::-1]

    def _carriers(self, link: str) -> list[str]:
        """The links between `link` and its root, the root included."""
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
        RobotError: not a URDF, names missing or used twice, links missing, two parents, a cycle.
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
            first = links[name] if tag == "link" else joints[name].element.line
            raise RobotError(
                f"two {tag}s have the name {name!r}", where=place, got=f"the first on line {first}", mend="rename one"
            )
        if tag == "link":
            links[name] = element.line
        else:
            joints[name] = _joint(name, element, file)
    return connected(Tree(root.attributes.get("name", ""), file, links, joints))


def connected(tree: Tree) -> Tree:
    """The tree with its joints hung on its links.

    Raises:
        RobotError: links missing, two parents, a cycle.
    """
    _connect(tree)
    _refuse_cycles(tree)
    return tree


def _joint(name: str, element: Element, file: str) -> TreeJoint:
    ends = []
    for end in ("parent", "child"):
        part = element.first(end)
        link = "" if part is None else part.attributes.get("link", "")
        if not link:
            line = element.line if part is None else part.line
            raise RobotError(
                f"the joint names no {end} link", where=f"{file}, line {line}, joint {name!r}",
                mend=f'add <{end} link="…"/>',
            )
        ends.append(link)
    return TreeJoint(name, element.attributes.get("type", ""), ends[0], ends[1], element)


def _connect(tree: Tree) -> None:
    for joint in tree.joints.values():
        for end, link in (("parent", joint.parent), ("child", joint.child)):
            if link not in tree.links:
                raise RobotError(
                    f"the {end} link is not in the file", where=tree.where(joint, end), got=repr(link),
                    **_hint(link, tree.links),
                )
        if joint.child in tree.above:
            raise RobotError(
                f"the link {joint.child!r} has two parents", where=tree.where(joint, "child"),
                got=f"joints {tree.above[joint.child].name!r} and {joint.name!r}", allowed="a tree",
                mend="take out one of the two joints",
            )
        tree.above[joint.child] = joint
        tree.below.setdefault(joint.parent, []).append(joint)


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
                    "the links form a cycle", where=tree.where(first), got=", ".join(joint.name for joint in ring),
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
