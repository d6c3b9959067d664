"""Reading files from outside: text of limited size with errors in plain words, and XML that is hardened.

Text is UTF-8 or declared Latin-1. XML has no document types, no entities, no external files, and limits on depth, count
and size. It is read by expat directly, for three reasons: every element keeps its line number, prefixes that are bound
to no namespace (`drake:` in real URDF files) are read as they stand, and all that could reach another file is refused.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from rankdrop.errors import RobotError
from rankdrop.robot.budgets import DEEPEST, LARGEST_FILE, MOST_ELEMENTS

_DECLARED = re.compile(rb"""<\?xml[^>]*encoding\s*=\s*["'](iso-8859-1|latin-?1|windows-1252)["']""", re.IGNORECASE)


def read_text(path: Path, *, largest: int | None = None) -> str:
    """The text of a file.

    Args:
        path: of the file.
        largest: bytes that it may have; None for `LARGEST_FILE`.

    Raises:
        RobotError: a folder, not readable, too large, or not text.
    """
    where, largest = str(path), LARGEST_FILE if largest is None else largest
    if path.is_dir():
        raise RobotError("this is a folder", where=where, mend="name the file in it")
    if not path.is_file():  # a device or a pipe could be read for ever
        raise RobotError("this is not a file", where=where)
    try:
        with path.open("rb") as stream:
            data = stream.read(largest + 1)
    except OSError as error:
        raise RobotError(f"the file cannot be read: {error.strerror}", where=where) from None
    if len(data) > largest:
        raise RobotError("the file is too large", where=where, allowed=f"at most {largest / 2**20:g} MB")
    if b"\0" in data:
        raise RobotError("this is not a text file", where=where, allowed="TOML, URDF or xacro in UTF-8")
    declared = _DECLARED.match(data)
    if declared is not None:
        return data.decode("latin-1")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise RobotError(
            "this is not text in UTF-8", where=f"{where}, line {line}", got=f"byte 0x{data[error.start]:02x}",
            mend="save the file as UTF-8",
        ) from None


@dataclass(frozen=True, slots=True)
class Element:
    """An element with its line in the file; prefixes are part of the names."""

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list)

    def first(self, tag: str) -> Element | None:
        """The first child with this tag."""
        return next((child for child in self.children if child.tag == tag), None)


def read_xml(text: str, file: str, skip: frozenset[str] = frozenset(), *, most: int | None = None) -> Element:
    """The root element of an XML text; elements named in `skip` are left out with all they hold.

    Args:
        text: of the file.
        file: its name, for errors.
        skip: tags.
        most: elements that it may have; None for `MOST_ELEMENTS`.

    Raises:
        RobotError: not well-formed, a document type or an entity, too deep, too many elements, too large.
    """
    data = text.encode("utf-8", "surrogatepass")
    if len(data) > LARGEST_FILE:
        raise RobotError("the text is too large", where=file, allowed=f"at most {LARGEST_FILE // 2**20} MB")
    builder = _Builder(file, skip, MOST_ELEMENTS if most is None else most)
    try:
        builder.parser.Parse(data, True)
    except expat.ExpatError as error:
        reason = expat.ErrorString(error.code)
        raise RobotError(f"this is not well-formed XML: {reason}", where=f"{file}, line {error.lineno}") from None
    if builder.root is None:  # the root itself is one of those left out
        raise RobotError("there is no element to read", where=file)
    return builder.root


class _Builder:
    def __init__(self, file: str, skip: frozenset[str], most: int) -> None:
        self.file, self.skip, self.most = file, skip, most
        self.root: Element | None = None
        self.open: list[Element] = []
        self.depth = self.count = 0
        self.skipping = 0  # depth of the element that is left out, 0 if none
        self.parser = expat.ParserCreate("utf-8")
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = self.end
        self.parser.StartDoctypeDeclHandler = self.refuse
        self.parser.EntityDeclHandler = self.refuse
        self.parser.ExternalEntityRefHandler = self.refuse

    def where(self) -> str:
        return f"{self.file}, line {self.parser.CurrentLineNumber}"

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        self.depth += 1
        self.count += 1
        if self.depth > DEEPEST:
            raise RobotError("the elements are nested too deeply", where=self.where(), allowed=f"depth {DEEPEST}")
        if self.count > self.most:
            raise RobotError("there are too many elements", where=self.where(), allowed=f"at most {self.most}")
        if self.skipping or tag in self.skip:
            self.skipping = self.skipping or self.depth
            return
        element = Element(tag, attributes, self.parser.CurrentLineNumber)
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)

    def end(self, _tag: str) -> None:
        if not self.skipping:
            self.open.pop()
        elif self.skipping == self.depth:
            self.skipping = 0
        self.depth -= 1

    def refuse(self, *_: object) -> int:
        raise RobotError(
            "document types and entities are refused", where=self.where(), mend="take out <!DOCTYPE …> and &entities;"
        )
