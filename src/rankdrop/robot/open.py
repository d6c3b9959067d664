"""A robot by its name in the catalogue or by its file."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable
from os import PathLike
from pathlib import Path

from rankdrop.errors import RobotError, UnknownRobotError
from rankdrop.robot.files import read_text
from rankdrop.robot.model import Robot
from rankdrop.robot.toml_file import robot_from_toml
from rankdrop.robot.urdf import from_urdf
from rankdrop.robot.xacro import from_xacro, is_xacro

_SUFFIXES = (".toml", ".urdf", ".xacro", ".xml")


@dataclass(frozen=True, slots=True)
class CatalogEntry:
    """One arm of the catalogue: name, one line about it, number of variables, task, and where its numbers are from."""

    name: str
    about: str
    n: int
    task: str
    source: str


def open_robot(
    name_or_path: str | PathLike[str],
    *,
    tip: str | None = None,
    base: str | None = None,
    packages: Mapping[str, str | PathLike[str]] | None = None,
    as_written: bool = False,
) -> Robot:
    """A robot from its name in the catalogue, or from a file: DH or screw TOML, URDF, xacro.

    Numbers that are rounded decimals of multiples of 15°, and structure that holds to 2e-5 rad and 2 µm (axes parallel,
    at right angles, meeting), are taken as exact; a note of the robot says how many and by how much.

    A catalogue name wins over a file of the same name; write "./pa10" for the file.

    Args:
        name_or_path: "pa10", or a path.
        tip, base: names of links, for URDF and xacro only; by default they are chosen, and `Robot.notes` says how.
        packages: package name -> folder, for xacro files with $(find …) or package://.
        as_written: keep the numbers of the file as they are.

    Raises:
        UnknownRobotError: neither a name of the catalogue nor a file; suggests names that are close.
        RobotError: the file cannot be read or used.
        MissingExtraError: a xacro file without the extra "xacro".

    Example:
        >>> open_robot("pa10").n
        7
    """
    name = str(name_or_path)
    if isinstance(name_or_path, str) and name in _catalog_files():
        _refuse_links(name, tip, base)
        return _from_catalog(name)
    path = Path(name_or_path)
    if not name or not _exists(path):
        raise _unknown(name)
    return _from_file(path, tip, base, packages or {}, as_written)


def robot_names() -> tuple[str, ...]:
    """The names of the catalogue, sorted."""
    return tuple(sorted(_catalog_files()))


def catalog_entries() -> tuple[CatalogEntry, ...]:
    """What the catalogue holds, by name."""
    robots = [_from_catalog(name) for name in robot_names()]
    return tuple(CatalogEntry(arm.name, arm.about, arm.n, arm.task, arm.source.reference) for arm in robots)


@cache
def _catalog_files() -> dict[str, Traversable]:
    folder = resources.files("rankdrop.robot") / "catalog"
    return {item.name.removesuffix(".toml"): item for item in folder.iterdir() if item.name.endswith(".toml")}


@cache
def _from_catalog(name: str) -> Robot:
    text = _catalog_files()[name].read_text(encoding="utf-8")
    return robot_from_toml(text, file=f"catalogue {name}.toml", default_name=name, kind="catalogue")


def _from_file(
    path: Path, tip: str | None, base: str | None, packages: Mapping[str, str | PathLike[str]], as_written: bool
) -> Robot:
    text = read_text(path)
    if not text.strip("\ufeff \t\r\n"):
        raise RobotError("the file is empty", where=str(path), allowed="DH or screw TOML, URDF or xacro")
    if path.suffix.lower() == ".toml" or not text.lstrip("\ufeff \t\r\n").startswith("<"):
        if path.suffix.lower() != ".toml" and not _is_toml(text):
            raise RobotError(
                "the file is neither TOML nor XML", where=str(path), allowed=", ".join(_SUFFIXES),
                mend="give a DH or screw TOML file, a URDF or a xacro file",
            )
        _refuse_links(str(path), tip, base)
        return robot_from_toml(text, file=str(path), default_name=path.stem, as_written=as_written)
    if is_xacro(path, text):
        return from_xacro(path, base=base, tip=tip, packages=packages, as_written=as_written)
    return from_urdf(text, base=base, tip=tip, file=str(path), as_written=as_written)


def _is_toml(text: str) -> bool:
    try:
        tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError):
        return False
    return True


def _refuse_links(name: str, tip: str | None, base: str | None) -> None:
    for label, link in (("tip", tip), ("base", base)):
        if link is not None:
            raise RobotError(
                f"this robot has no links to name as its {label}", where=name, got=repr(link),
                allowed=f"{label} with a URDF or xacro file",
            )


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # a name too long for the file system, or with a zero byte
        return False


def _unknown(name: str) -> UnknownRobotError:
    shown = name if len(name) <= 500 else name[:499] + "…"
    same = [known for known in robot_names() if known.lower() == name.lower()]
    close = same or difflib.get_close_matches(name.lower()[:80], robot_names(), n=3, cutoff=0.5)
    is_path = "/" in name or "\\" in name or name.lower().endswith(_SUFFIXES)
    what = "there is no such file" if is_path else "there is no such robot in the catalogue and no such file"
    allowed = None if is_path else ", ".join(robot_names())
    mend = f"did you mean {' or '.join(close)}?" if close and not is_path else None
    return UnknownRobotError(what, got=repr(shown), allowed=allowed, mend=mend)
