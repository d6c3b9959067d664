"""Where a ROS package is that a robot file names: given, near the file, or in the environment; nothing is installed."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterator, Mapping
from pathlib import Path

PLACES = "above or beside the file, or in ROS_PACKAGE_PATH or AMENT_PREFIX_PATH"
"""Where `find_package` looks besides the folders that are given, for errors."""
_NAME = re.compile(r"[A-Za-z][\w-]*")
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_TAG = re.compile(r"<name>\s*([^<\s]+)\s*</name>")
_UP = 8  # folders above the file; the deepest file of 12 vendors' checkouts lies 5 below its workspace
_DOWN = 3  # workspace / src / repository / package
_MOST_FOLDERS = 20_000  # looked into for one package: a second or so
_LARGEST = 2**20  # bytes of a package.xml that are read; real ones have a few thousand
_NEVER = frozenset({"node_modules", "meshes", "build", "log"})


def find_package(name: str, file: Path, given: Mapping[str, str | os.PathLike[str]]) -> Path | None:
    """The folder of a package, or None.

    First the folders that are given; then, folder by folder upwards from the file, the folder itself and what lies up
    to three levels below it, nearest first, then by name; then ROS_PACKAGE_PATH (each entry and three levels below)
    and share/NAME in each entry of AMENT_PREFIX_PATH. A folder is the package if its package.xml says so, or if it has
    this name and a manifest.xml; at last a folder of this name above or beside the file is taken without either. The
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
            parents = [place for place in level if depth == 0 or not _has_package(place)]
            level = [child for place in parents for child in _inside(place, left)]


def _inside(folder: Path, left: list[int]) -> list[Path]:
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


def _has_package(folder: Path) -> bool:
    return (folder / "package.xml").is_file()


def _is_package(folder: Path, name: str) -> bool:
    try:
        with (folder / "package.xml").open("rb") as stream:
            text = stream.read(_LARGEST).decode("utf-8", "replace")
    except OSError:
        return folder.name == name and (folder / "manifest.xml").is_file()
    found = _TAG.search(_COMMENT.sub("", text))
    return found is not None and found[1] == name
