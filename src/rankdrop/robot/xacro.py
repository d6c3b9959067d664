"""Robots from xacro, expanded by the package xacrodoc (extra "xacro") and then read as URDF.

A xacro file is a program: it includes other files, reads environment variables and YAML files by name, and evaluates
expressions. rankdrop adds nothing to what xacro itself does and takes nothing away: expand only files that you trust.
"""

from __future__ import annotations

import contextlib
import io
import re
from collections.abc import Iterator, Mapping
from os import PathLike
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

from rankdrop.errors import MissingExtraError, RobotError
from rankdrop.robot.files import read_text
from rankdrop.robot.model import Robot
from rankdrop.robot.urdf import from_urdf
from rankdrop.robot.xml_file import Element, read_xml

_NO_PACKAGE = re.compile(r"PackageNotFoundError.*?Package not found: (\S+)")


def is_xacro(path: Path, text: str) -> bool:
    """Does this XML have to be expanded first? By the suffix, or by xacro elements outside comments."""
    if path.suffix.lower() == ".xacro":
        return True
    return "<xacro:" in text and _uses_xacro(read_xml(text, str(path)))


def _uses_xacro(element: Element) -> bool:
    return element.tag.startswith("xacro:") or any(_uses_xacro(child) for child in element.children)


def from_xacro(
    path: str | PathLike[str],
    *,
    base: str | None = None,
    tip: str | None = None,
    packages: Mapping[str, str | PathLike[str]] | None = None,
    arguments: Mapping[str, str] | None = None,
    as_written: bool = False,
) -> Robot:
    """A robot from a xacro file.

    Args:
        path: the file.
        base, tip, as_written: as in `from_urdf`.
        packages: package name -> folder, for $(find name). Packages are also looked for upwards from the file (by
            package.xml) and in the ROS installation, where there is one.
        arguments: values of <xacro:arg …>.

    Raises:
        MissingExtraError: xacrodoc is not installed.
        RobotError: the file cannot be expanded (in the words of xacro), or what comes out cannot be used.
    """
    file = Path(path)
    root = read_xml(read_text(file), str(file))
    text = _expand(file, root.attributes.get("name", file.stem), packages or {}, arguments or {})
    return from_urdf(text, base=base, tip=tip, file=f"{file} (expanded)", as_written=as_written)


def _expand(file: Path, name: str, packages: Mapping[str, Any], arguments: Mapping[str, str]) -> str:
    for package, folder in packages.items():
        if not Path(folder).is_dir():
            raise RobotError("the folder of a package is not there", where=f"package {package!r}", got=str(folder))
    try:
        import xacrodoc
    except ImportError:
        raise MissingExtraError("xacrodoc", "xacro", "a xacro file") from None
    # An include, not the text: xacro then resolves the file's own includes relative to it.
    whole = (
        f'<robot name={quoteattr(name)} xmlns:xacro="http://www.ros.org/wiki/xacro">'
        f"<xacro:include filename={quoteattr(str(file.resolve()))}/></robot>"
    )
    said = io.StringIO()
    try:
        with _own_packages(xacrodoc.packages, file, packages), contextlib.redirect_stderr(said):
            document = xacrodoc.XacroDoc.from_string(whole, subargs=dict(arguments), resolve_packages=False)
            return str(document.to_urdf_string())
    except Exception as error:  # xacro raises whatever its expressions raise
        reason = " ".join(f"{type(error).__name__}: {error} {said.getvalue()}".split())
        missing = _NO_PACKAGE.search(reason)
        if missing is not None:
            raise RobotError(
                "a package is not found", where=str(file), got=repr(missing[1]),
                mend=f"give its folder: packages={{{missing[1]!r}: …}}",
            ) from None
        raise RobotError(f"xacro cannot expand the file: {reason[:300]}", where=str(file)) from None


@contextlib.contextmanager
def _own_packages(module: Any, file: Path, packages: Mapping[str, Any]) -> Iterator[None]:
    """xacrodoc keeps one list of packages per process; use a fresh one, so that a call leaves nothing behind."""
    before = module._finder
    module._finder = module.PackageFinder()
    try:
        module.walk_up_from(file)
        module.update_package_cache(dict(packages))
        yield
    finally:
        module._finder = before
