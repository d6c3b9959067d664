"""A robot's description in which some numbers are open: the same arm with another length, angle, offset, base or tool.

A *place* says where a number stands:

    shoulder_lift_joint.a, 2.a    of a DH file: a, alpha, d, theta, pitch of a joint, by its name or number
    elbow_joint.z, 3.roll         of a URDF: x, y, z, roll, pitch, yaw of the joint's origin
    3.lower, 3.upper              of both: the limits of the joint's variable
    tool.x, base.yaw              of every robot: x, y, z, roll, pitch, yaw of a further tool after the tip, or of a
                                  frame that the base stands in; zero where not said

Numbers put in are taken literally. What is read beside them is read as it is meant (`as_intended`), and structure that
holds to 2e-5 rad and 2 µm counts as exact in a variant too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from rankdrop.errors import RobotError
from rankdrop.robot.dh import DH_KEYS
from rankdrop.robot.files import Element
from rankdrop.robot.model import Array, Joint, JointKind, Robot
from rankdrop.robot.open import open_robot, source_text
from rankdrop.robot.toml_file import parsed_toml, robot_from_toml
from rankdrop.robot.transform import from_xyz_rpy, times
from rankdrop.robot.tree import Tree
from rankdrop.robot.urdf import from_urdf

FRAME = ("x", "y", "z", "roll", "pitch", "yaw")
"""Parts of a pose."""
ENDS = ("tool", "base")
_LIMITS = ("lower", "upper")
_DH = tuple(key for key in DH_KEYS if key not in ("kind", "name", "velocity", *_LIMITS))
_ANGLES = ("alpha", "theta", "roll", "pitch", "yaw")
_DIGITS = 25  # places at which no number is a rounded multiple of 15° by chance


@dataclass(frozen=True, slots=True)
class NumberPlace:
    """Where a number stands: a joint by its name, "tool" or "base", and the key; `sign` is what it is multiplied by."""

    part: str
    key: str
    sign: float

    def __str__(self) -> str:
        return f"{'-' if self.sign < 0 else ''}{self.part}.{self.key}"


@dataclass(frozen=True)
class Drawing:
    """A robot's description.

    Attributes:
        name: in the catalogue, or file.
        tip, base, as_written: as for `open_robot`.
        text, file: what the name stands for and where it is from, so that no other machine has to have the file; ""
            for what only `open_robot` reads (xacro, MJCF, screws): of such a robot tool and base can be set.
    """

    name: str
    tip: str | None = None
    base: str | None = None
    as_written: bool = False
    text: str = ""
    file: str = ""

    @classmethod
    def of(cls, name: str, tip: str | None = None, base: str | None = None, *, as_written: bool = False) -> Drawing:
        """The description that a name or a file stands for.

        Raises:
            RobotError: as `open_robot`.
        """
        drawing = cls(name, tip, base, as_written)
        kind = drawing.nominal.source.kind
        text, file = source_text(name) or ("", "")
        is_table = kind in ("dh", "catalogue") and "convention" in parsed_toml(text, file)
        is_urdf = kind == "urdf" and text != ""
        if is_table or is_urdf:
            return replace(drawing, text=text, file=file)
        return drawing

    @cached_property
    def nominal(self) -> Robot:
        """The arm as it is described.

        Raises:
            RobotError: as `open_robot`.
        """
        if self.text:
            return self._read_with_values({})
        return open_robot(self.name, tip=self.tip, base=self.base, as_written=self.as_written)

    @cached_property
    def _rows(self) -> list[dict[str, Any]] | None:
        is_table = self.text != "" and not self.text.lstrip("\ufeff \t\r\n").startswith("<")
        if is_table:
            return list(parsed_toml(self.text, self.file)["joints"])
        return None

    @cached_property
    def _keys(self) -> tuple[str, ...]:
        if self._rows is not None:
            return (*_DH, *_LIMITS)
        if self.text:
            return (*FRAME, *_LIMITS)
        return ()

    def place(self, text: str, where: str) -> NumberPlace:
        """A place from its text, "elbow_joint.a", "-3.a" or "tool.z"; the sign is put before the number.

        Args:
            text: of the place.
            where: for the error: file, line, key.

        Raises:
            RobotError: no such joint or key in this robot.
        """
        sign = -1.0 if text.startswith("-") else 1.0
        part, _, key = text.removeprefix("-").strip().rpartition(".")
        if part in ENDS:
            if key not in FRAME:
                raise RobotError("there is no such number", where=where, got=repr(text),
                                 allowed=", ".join(f"{part}.{element}" for element in FRAME))  # fmt: skip
            return NumberPlace(part, key, sign)
        name = self._joint_named(part)
        if name in self._joints and key in self._keys:
            return NumberPlace(name, key, sign)
        ends = f"tool or base with {', '.join(FRAME)}"
        if not self._keys:
            raise RobotError("of this robot only tool and base can be set", where=where, got=repr(text), allowed=ends)
        joints = f"JOINT.KEY with JOINT one of {', '.join(self._joints)} and KEY one of {', '.join(self._keys)}"
        raise RobotError("there is no such number", where=where, got=repr(text), allowed=f"{joints}; {ends}")

    def _joint_named(self, part: str) -> str:
        """The name of a joint that is given by its number, from 1; else what was given."""
        names = self._joints
        if part.isdecimal() and len(part) <= len(str(len(names))) and 1 <= int(part) <= len(names):
            return names[int(part) - 1]
        return part

    @cached_property
    def _joints(self) -> tuple[str, ...]:
        if self._rows is not None:
            return tuple(str(row.get("name", f"joint{number}")) for number, row in enumerate(self._rows, 1))
        return tuple(joint.name for joint in self.nominal.joints)

    def measure(self, place: NumberPlace) -> str:
        """ "length" or "angle": which units the number has."""
        if place.key in _LIMITS:
            kinds = {joint.name: joint.kind for joint in self.nominal.joints}
            return kinds.get(place.part, JointKind.REVOLUTE).measure
        if place.key == "pitch" and self._rows is not None and place.part not in ENDS:  # of a helical joint
            return "length"
        if place.key in _ANGLES:
            return "angle"
        return "length"

    def robot(self, values: Mapping[NumberPlace, float], name: str | None = None) -> Robot:
        """The arm with other numbers at some places.

        Args:
            values: [m, rad], before the sign.
            name: of the variant.

        Raises:
            RobotError: the numbers make no arm (a limit above the other, a length beyond the range).
        """
        inner = {place: place.sign * x for place, x in values.items() if place.part not in ENDS}
        ends = {place: place.sign * x for place, x in values.items() if place.part in ENDS}
        if inner:
            robot = self._read_with_values(inner)
        else:
            robot = self.nominal
        for end in ENDS:
            given = {place.key: x for place, x in ends.items() if place.part == end}
            numbers = [given.get(key, 0.0) for key in FRAME]
            if given:
                robot = _transform_end(robot, end, from_xyz_rpy(numbers[:3], numbers[3:]))
            else:
                robot = robot
        if name is None:
            return robot
        return replace(robot, name=name)

    def _read_with_values(self, values: Mapping[NumberPlace, float]) -> Robot:
        if self._rows is not None:
            if self.file.startswith("catalogue "):
                kind = "catalogue"
            else:
                kind = None
            return robot_from_toml(
                self.text, file=self.file, default_name=Path(self.file).stem, kind=kind, as_written=self.as_written,
                edit=_table_edit(self._joints, values),
            )  # fmt: skip
        return from_urdf(self.text, base=self.base, tip=self.tip, file=self.file, as_written=self.as_written,
                         edit=_tree_edit(values))  # fmt: skip


def _table_edit(names: tuple[str, ...], values: Mapping[NumberPlace, float]) -> Callable[[dict[str, Any]], None]:
    def edit(document: dict[str, Any]) -> None:
        for place, value in values.items():
            document["joints"][names.index(place.part)][place.key] = float(value)

    return edit


def _tree_edit(values: Mapping[NumberPlace, float]) -> Callable[[Tree], None]:
    def edit(tree: Tree) -> None:
        for place, value in values.items():
            joint = tree.joints[place.part].element
            if place.key in _LIMITS:
                _child(joint, "limit").attributes[place.key] = f"{value:.{_DIGITS}f}"
                continue
            if place.key in FRAME[:3]:
                attribute = "xyz"
            else:
                attribute = "rpy"
            origin = _child(joint, "origin").attributes
            words = origin.get(attribute, "0 0 0").split()
            words[FRAME.index(place.key) % 3] = f"{value:.{_DIGITS}f}"
            origin[attribute] = " ".join(words)

    return edit


def _child(element: Element, tag: str) -> Element:
    child = element.first(tag)
    if child is None:
        child = Element(tag, {}, element.line)
        element.children.append(child)
    return child


def _transform_end(robot: Robot, end: str, pose: Array) -> Robot:
    if end == "tool":
        return replace(robot, home=times(robot.home, pose))
    joints = tuple(_move_joint(joint, pose) for joint in robot.joints)
    return replace(robot, joints=joints, home=times(pose, robot.home))


def _move_joint(joint: Joint, pose: Array) -> Joint:
    turned_v, turned_w = times(pose[:3, :3], joint.screw[:3]), times(pose[:3, :3], joint.screw[3:])
    screw = np.concatenate([turned_v + np.cross(pose[:3, 3], turned_w), turned_w])
    return replace(joint, screw=screw, frame=times(pose, joint.frame))
