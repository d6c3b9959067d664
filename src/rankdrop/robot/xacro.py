"""Robots from xacro, expanded by the package xacro in a child process with limits, and then read as URDF.

A xacro file is a program: it includes other files, reads environment variables and YAML files by name, and evaluates
expressions, which can run any command: expand only files that you trust. This is why a file is expanded by its ending
.xacro or on request, never by what it holds.

ROS packages that a file names are given, near the file, or in the environment; nothing is installed.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterator, Mapping
from dataclasses import replace
from importlib.util import find_spec
from os import PathLike
from pathlib import Path
from xml.sax.saxutils import quoteattr

from rankdrop.errors import MissingExtraError, RobotError
from rankdrop.jobs.limited import run_limited
from rankdrop.lists import flat_map
from rankdrop.robot.files import Element, name_of_file, read_text, read_xml
from rankdrop.robot.model import Robot
from rankdrop.robot.note import NoteOn, RobotNote
from rankdrop.robot.urdf import from_urdf

PLACES = "above or next to the file, or in ROS_PACKAGE_PATH or AMENT_PREFIX_PATH"
"""Where `find_package` looks besides the folders that are given, for errors."""
_NAME = re.compile(r"[A-Za-z][\w-]*")
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_TAG = re.compile(r"<name>\s*([^<\s]+)\s*</name>")
_UP = 8  # folders above the file; the deepest file of 12 vendors' checkouts lies 5 below its workspace
_DOWN = 3  # workspace / src / repository / package
_MOST_FOLDERS = 20_000  # looked into for one package: a second or so
_LARGEST = 2**20  # bytes of a package.xml that are read; real ones have a few thousand
_NEVER = frozenset({"node_modules", "meshes", "build", "log"})

_NOWHERE = "/package-that-is-not-found/"  # stands for a package's folder: meshes may be named with it, nothing is read
_SHOWN = 12  # arguments in one line of an error; the longest of the vendors' files take some forty
_LONGEST = 30  # characters of a default that is shown: longer ones are paths made of other arguments
_NO_ARGUMENT = re.compile(r"Undefined substitution argument (\S+)")
_ARGUMENT = re.compile(r"\$\(arg\s+([^\s)]+)\)")
EXPANDED = " (expanded)"
"""Stands after the name of a file that was expanded, in the source of a robot."""


def find_package(name: str, file: Path, given: Mapping[str, str | os.PathLike[str]]) -> Path | None:
    """The folder of a package, or None.

    First the folders that are given; then, folder by folder upwards from the file, the folder itself and what lies up
    to three levels below it, nearest first, then by name; then ROS_PACKAGE_PATH (each entry and three levels below)
    and share/NAME in each entry of AMENT_PREFIX_PATH. A folder is the package if its package.xml says so, or if it has
    this name and a manifest.xml; at last a folder of this name above or next to the file is taken without either. The
    way up ends after eight folders and after the home folder, of which only the direct subfolders are looked at;
    folders where everybody may leave files (/tmp) are not looked into at all.

    Args:
        name: of the package.
        file: that names it.
        given: package name -> folder; not looked into.
    """
    if name in given:
        return Path(given[name])
    if not _NAME.fullmatch(name):  # "..", or a path: not a name that could be looked for
        return None
    left = [_MOST_FOLDERS]
    listed = [(Path(entry), _DOWN) for entry in _entries("ROS_PACKAGE_PATH")]
    for folder, down in [*_above(file.resolve().parent), *listed]:
        for place in _below(folder, down, left):
            if _is_package(place, name):
                return place
    shares = [Path(entry) / "share" / name for entry in _entries("AMENT_PREFIX_PATH")]
    beside = [place for folder, _ in _above(file.resolve().parent) for place in (folder, folder / name)]
    return next((place for place in [*shares, *beside] if place.name == name and place.is_dir()), None)


def _entries(variable: str) -> list[str]:
    return [entry for entry in os.environ.get(variable, "").split(os.pathsep) if entry]


def _above(folder: Path) -> Iterator[tuple[Path, int]]:
    """The folders on the way up, each with the number of levels below it to look at."""
    home = Path.home()
    for place in [folder, *folder.parents][: _UP + 1]:
        if place == place.parent or _is_open_to_all(place):
            return
        yield place, 1 if place == home else _DOWN
        if place == home:
            return


def _is_open_to_all(folder: Path) -> bool:
    """/tmp and the like (world-writable and sticky): what lies there may be anybody's, and xacro would run it."""
    try:
        mode = folder.stat().st_mode
    except OSError:
        return True
    return bool(mode & stat.S_ISVTX and mode & stat.S_IWOTH)


def _below(folder: Path, down: int, left: list[int]) -> Iterator[Path]:
    """The folder and its subfolders, nearest first, then by name; packages hold no packages."""
    level = [folder]
    for depth in range(down + 1):
        yield from level
        if depth < down:
            parents = [place for place in level if depth == 0 or not (place / "package.xml").is_file()]
            level = flat_map(lambda place: _subfolders(place, left), parents)


def _subfolders(folder: Path, left: list[int]) -> list[Path]:
    left[0] -= 1
    if left[0] < 0:
        return []
    try:
        with os.scandir(folder) as entries:
            names = [
                entry.name for entry in entries
                if not entry.name.startswith(".") and entry.name not in _NEVER and entry.is_dir()
            ]  # fmt: skip
    except OSError:
        return []
    return [folder / name for name in sorted(names)]


def _is_package(folder: Path, name: str) -> bool:
    try:
        with (folder / "package.xml").open("rb") as stream:
            text = stream.read(_LARGEST).decode("utf-8", "replace")
    except OSError:
        return folder.name == name and (folder / "manifest.xml").is_file()
    match = _TAG.search(_COMMENT.sub("", text))
    return match is not None and match[1] == name


def uses_xacro(element: Element) -> bool:
    """Whether there is an element of xacro, so that the file has to be expanded before it is a URDF."""
    return element.tag.startswith("xacro:") or any(uses_xacro(child) for child in element.children)


def from_xacro(
    path: str | PathLike[str],
    *,
    base: str | None = None,
    tip: str | None = None,
    packages: Mapping[str, str | PathLike[str]] | None = None,
    args: Mapping[str, object] | None = None,
    as_written: bool = False,
) -> Robot:
    """A robot from a xacro file. Expanding it can run any command: see the note at the top of this module.

    Args:
        path: the file.
        base, tip, as_written: as in `from_urdf`.
        packages: package name -> folder, for $(find name). Others are looked for (see `find_package`). A package that
            is not found and only names meshes brings a note.
        args: values of <xacro:arg …>: text, numbers, true and false.

    Raises:
        MissingExtraError: xacro is not installed.
        RobotError: the file cannot be expanded (in the words of xacro) or needs too much for it, an argument is missing
            or is none of the file, or what comes out cannot be used.
    """
    file = Path(path)
    text, name, notes = expand_file(file, packages or {}, args or {})
    robot = from_urdf(text, base=base, tip=tip, file=f"{file}{EXPANDED}", as_written=as_written)
    return replace(robot, name=name if name and "$" not in name else robot.name, notes=(*robot.notes, *notes))


def expand_file(
    file: Path, packages: Mapping[str, str | PathLike[str]], args: Mapping[str, object]
) -> tuple[str, str, list[RobotNote]]:
    """The URDF that a xacro file expands to, the name that the file gives to the robot, and notes on packages.

    The arguments are those of `from_xacro`, and so are the errors.
    """
    for package, folder in packages.items():
        if not Path(folder).is_dir():
            raise RobotError("the folder of a package is not there", where=f"package {package!r}", got=str(folder))
    read_xml(read_text(file), str(file))  # limits on size and depth, no document types
    if find_spec("xacro") is None:
        raise MissingExtraError("xacro", None, "a xacro file")
    folders = {package: str(Path(folder).resolve()) for package, folder in packages.items()}
    values = {key: str(value).lower() if isinstance(value, bool) else str(value) for key, value in args.items()}
    text, name, found_packages, missing = run_limited(expand, str(file), folders, values, file=file, parser="xacro")
    notes = [RobotNote(NoteOn.PACKAGE, package, folder) for package, folder in found_packages.items()]
    notes += [RobotNote(NoteOn.NO_PACKAGE, package) for package in missing]
    return text, name, notes


class _Arguments(dict[str, str]):
    """The arguments that xacro works with: it adds defaults; which ones it asks for is kept, in order."""

    def __init__(self, given: dict[str, str], root: Element) -> None:
        declared = {child.attributes.get("name", ""): child.attributes.get("default") for child in root.children
                    if child.tag == "xacro:arg"}  # fmt: skip
        self.given = tuple(given)
        self.needed = tuple(name for name, default in declared.items() if default is None and name not in given)
        # xacro reads the attributes of the root before the defaults: <robot name="$(arg name)"> has no value without
        named = _ARGUMENT.findall(" ".join(root.attributes.values()))
        early = {name: declared[name] or "" for name in named if "$" not in (declared.get(name) or "$")}
        super().__init__(early | given)
        self.asked: dict[str, None] = {}

    def __contains__(self, name: object) -> bool:
        self.asked[str(name)] = None
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.asked[name] = None
        return super().__getitem__(name)

    def with_defaults(self, reason: str) -> str:
        """The arguments that were asked for and not given, with their defaults; first those named in the reason."""
        asked = [(name, default) for name in self.asked
                 if name not in self.given and (default := self.get(name)) is not None]  # fmt: skip
        words = {word for word in re.split(r"[^\w-]+", reason) if not word.isdigit()}
        asked.sort(key=lambda pair: bool(pair[1]) and pair[1] not in words)  # an empty default asks for a value
        shown = [f"{name}={default!r}" for name, default in asked if len(default) <= _LONGEST]
        more = len(asked) - len(shown[:_SHOWN])
        return ", ".join(shown[:_SHOWN]) + (f" and {more} more" if more else "")


def expand(path: str, folders: dict[str, str], args: dict[str, str]) -> tuple[str, str, dict[str, str], list[str]]:
    """The URDF that a xacro file expands to, and the name in the file; runs in a child process.

    Returns:
        URDF, name, packages found elsewhere with their folders, packages not found.

    Raises:
        RobotError: as `from_xacro`.
    """
    import xacro
    from xacro import substitution_args

    file = Path(path)
    root = read_xml(read_text(file), path)
    arguments = _Arguments(args, root)
    missing: dict[str, None] = {}
    far: dict[str, Path] = {}  # not given, and not the package that the file lies in

    def folder_of(package: str) -> str:
        """The folder of a package as text; a place that does not exist where it is not found."""
        folder = find_package(package, file, folders)
        if folder is None:
            missing[package] = None
            return _NOWHERE + package
        folder = folder.resolve()
        if package not in folders and folder not in file.resolve().parents:
            far[package] = folder
        return folder.as_posix()

    substitution_args._eval_find = substitution_args._eval_dict["find"] = folder_of
    name = root.attributes.get("name", "")
    if name and "$" not in name:
        plain = name
    else:
        plain = name_of_file(Path(file.name.partition(".")[0]))
    # An include, not the text: xacro then resolves the file's own includes relative to it.
    whole = (
        f'<robot name={quoteattr(plain)} xmlns:xacro="http://www.ros.org/wiki/xacro">'
        f"<xacro:include filename={quoteattr(str(file.resolve()))}/></robot>"
    )
    try:
        document = xacro.parse(whole)
        xacro.process_doc(document, mappings=arguments)
        text = str(document.toprettyxml(indent="  "))
    except MemoryError:
        raise
    except Exception as error:  # xacro raises whatever its expressions raise
        raise _expansion_error(" ".join(f"{type(error).__name__}: {error}".split()), path, missing, arguments) from None
    _check_arguments(arguments, path)
    if "<link" not in text:
        raise RobotError("nothing comes out of the xacro file: it has no links and may only define macros",
                         where=path, mend="open the file that uses them, often a .urdf.xacro near it")  # fmt: skip
    packages = {package: str(folder) for package, folder in far.items()}
    return text, _ARGUMENT.sub(lambda match: arguments.get(match[1], match[0]), name), packages, list(missing)


def _check_arguments(arguments: _Arguments, path: str) -> None:
    """Refuse an argument that the file did not ask for.

    Raises:
        RobotError: with the arguments that it takes.
    """
    for argument in arguments.given:
        if argument not in arguments.asked:
            takes = ", ".join(arguments.asked) or "none: the file takes no arguments"
            raise RobotError("the file has no such argument", where=path, got=repr(argument), allowed=takes)


def _expansion_error(reason: str, path: str, packages: dict[str, None], arguments: _Arguments) -> RobotError:
    for package in packages:
        if _NOWHERE + package in reason:
            return RobotError(
                "a package is not found", where=path, got=repr(package),
                allowed=f"a folder with a package.xml of this name, {PLACES}",
                mend=f"give its folder: packages={{{package!r}: …}}",
                typed=f"give its folder: --package {package}=FOLDER",
            )
    defaults = arguments.with_defaults(reason)
    if defaults:
        others = f"arguments with defaults: {defaults}"
    else:
        others = None
    missing = _NO_ARGUMENT.search(reason)
    if missing is not None:
        needed = list(dict.fromkeys([missing[1], *arguments.needed]))
        return RobotError(
            "arguments of the xacro file are not given", where=path, got=f"no value of {', '.join(needed)}",
            allowed=others, mend=f"args={{{', '.join(f'{name!r}: …' for name in needed)}}}",
            typed=" ".join(f"--arg {name}:=VALUE" for name in needed),
        )
    return RobotError(
        f"xacro cannot expand the file: {reason[:200]}", where=path, allowed=others,
        mend="it may need another value: args={name: value}" if defaults else None,
        typed="it may need another value: --arg NAME:=VALUE" if defaults else None,
    )
