"""Formats of robot files: which one a file has, and who reads it.

A new format is a module that reads it, and an entry of `FORMATS`; errors and help take its name and endings from there.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from rankdrop.errors import RobotError
from rankdrop.lists import flat_map
from rankdrop.robot.files import LARGEST_TABLE, name_of_file, read_xml

if TYPE_CHECKING:
    from rankdrop.robot.model import Robot

_TAG = re.compile(r"<([A-Za-z_][\w.:-]*)")
BLANK = "\ufeff \t\r\n"
_POINTER = "version https://git-lfs.github.com/"
_FROM_SDF = "convert it to MJCF with sdf2mjcf (PyPI: sdformat-mjcf), or give the URDF or xacro that it was made from"


@dataclass(frozen=True, slots=True)
class RobotFile:
    """A file that describes a robot, and what the caller of `open_robot` asks for."""

    path: Path
    text: str
    base: str | None = None
    tip: str | None = None
    as_written: bool = False
    packages: Mapping[str, str | PathLike[str]] = field(default_factory=dict)
    args: Mapping[str, object] = field(default_factory=dict)
    xacro: bool = False

    @property
    def suffix(self) -> str:
        """Of the path, in small letters: ".urdf"."""
        return self.path.suffix.lower()

    @property
    def root(self) -> str:
        """The tag of the first element; "" for what is no XML."""
        is_xml = self.suffix != ".toml" and self.text.lstrip(BLANK).startswith("<")
        if is_xml:
            return _root_tag(self.text) or "?"
        return ""


@dataclass(frozen=True, slots=True)
class Format:
    """A format of robot files.

    Attributes:
        name: as errors and help write it.
        endings: of its files, in help; a file of another ending is known by its text.
        holds: whether a file has this format, by a look at its name and its text.
        read: the robot of a file; imports the reader, since an arm of the catalogue needs none.
        links, arguments: whether its files have links to name as base and tip; arguments.
    """

    name: str
    endings: tuple[str, ...]
    holds: Callable[[RobotFile], bool]
    read: Callable[[RobotFile], Robot]
    links: bool = True
    arguments: bool = False


def _reader(name: str, *given: str) -> Callable[[RobotFile], Robot]:
    """The reader "module.function" of a file: it takes a path, `as_written`, and what else of the file is `given`."""

    def read(file: RobotFile) -> Robot:
        module, _, function = name.partition(".")
        reader = getattr(import_module(f"rankdrop.robot.{module}"), function)
        robot: Robot = reader(file.path, as_written=file.as_written, **{key: getattr(file, key) for key in given})
        return robot

    return read


def _read_toml(file: RobotFile) -> Robot:
    from rankdrop.robot.toml_file import robot_from_toml

    return robot_from_toml(file.text, file=str(file.path), default_name=name_of_file(file.path),
                           as_written=file.as_written)  # fmt: skip


def _holds_screws(file: RobotFile) -> bool:
    from rankdrop.robot.screws import is_screw_list

    return not file.root and file.suffix != ".toml" and is_screw_list(file.text)


def _holds_dh_text(file: RobotFile) -> bool:
    from rankdrop.robot.dh_rows import is_table

    return not file.root and file.suffix != ".toml" and len(file.text) <= LARGEST_TABLE and is_table(file.text)


def _read_dh_text(file: RobotFile) -> Robot:
    from rankdrop.robot.dh_text import from_dh_text

    return from_dh_text(file.text, file=str(file.path), name=name_of_file(file.path), as_written=file.as_written)


def _read_urdf(file: RobotFile) -> Robot:
    from rankdrop.robot.urdf import from_urdf
    from rankdrop.robot.xacro import uses_xacro

    if "<xacro:" in file.text and uses_xacro(read_xml(file.text, str(file.path))):  # a comment may name xacro too
        raise RobotError(
            "the file has xacro elements and does not end in .xacro; expanding it can run any command",
            where=str(file.path), mend="if you trust it: xacro=True", typed="if you trust it: --xacro",
        )  # fmt: skip
    return from_urdf(file.text, base=file.base, tip=file.tip, file=str(file.path), as_written=file.as_written)


FORMATS = (
    Format("xacro", (".xacro",), lambda file: file.xacro or file.suffix == ".xacro",
           _reader("xacro.from_xacro", "base", "tip", "packages", "args"), arguments=True),
    Format("MJCF", (".xml", ".mjcf"), lambda file: file.root == "mujoco", _reader("mjcf.from_mjcf", "base", "tip")),
    Format("URDF", (".urdf", ".xml"), lambda file: file.root != "", _read_urdf),
    Format("plain screws (six numbers a line)", (".txt",), _holds_screws, _reader("screws.from_screw_list"),
           links=False),
    Format("DH tables", (".txt", ".csv", ".m", ".py"), _holds_dh_text, _read_dh_text, links=False),
    Format("TOML (DH, screws)", (".toml",), lambda file: file.suffix == ".toml" or _is_toml(file.text), _read_toml,
           links=False),
)  # fmt: skip
"""The first that holds a file reads it."""


def format_of(file: RobotFile) -> Format:
    """The format that a file has.

    Raises:
        RobotError: none of `FORMATS`.
    """
    if file.root == "sdf":  # it would be taken for URDF
        raise RobotError("SDF is not read", where=str(file.path), got="<sdf>", allowed=format_names(), mend=_FROM_SDF)
    for form in FORMATS:
        if form.holds(file):
            return form
    if file.text.startswith(_POINTER):
        raise RobotError("the file is a pointer of Git LFS, not the file itself", where=str(file.path),
                         mend="fetch it: git lfs pull")  # fmt: skip
    raise RobotError("the file is neither TOML nor XML", where=str(file.path), allowed=", ".join(format_endings()),
                     mend=f"give a file in {format_names()}; a table has a heading: a, alpha, d, theta")  # fmt: skip


def format_names() -> str:
    """The formats, for people: "xacro, MJCF, URDF, … or TOML (DH, screws)"."""
    *first, last = (form.name for form in FORMATS)
    return f"{', '.join(first)}, or {last}"


def format_endings() -> tuple[str, ...]:
    """Endings of robot files, each once."""
    return tuple(dict.fromkeys(flat_map(lambda form: form.endings, FORMATS)))


def _root_tag(text: str) -> str:
    """The tag of the first element, by a look: whether the text is sound is for its reader to say."""
    at = 0
    while (at := text.find("<", at)) >= 0:
        if text.startswith("<!--", at):
            at = text.find("-->", at + 4)
            if at < 0:
                break
        elif match := _TAG.match(text, at):
            return match[1]
        else:
            at += 1
    return ""


def _is_toml(text: str) -> bool:
    from rankdrop.robot.toml_file import NotTomlError, parsed_toml

    try:
        parsed_toml(text, "")
    except NotTomlError:
        return False
    except RobotError:
        return True  # too much of it: its reader says so
    return True
