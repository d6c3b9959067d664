"""Files from outside: limits on what is read, text with errors in plain words, and XML that is hardened.

Text is UTF-8 or declared Latin-1. XML has no document types, no entities, no external files, and limits on depth, count
and size. It is read by expat directly, for three reasons: every element keeps its line number, prefixes that are bound
to no namespace (`drake:` in real URDF files) are read as they stand, and all that could reach another file is refused.

The limits are sizes, counts, depth and ranges; the page docs/limits.md shows them. A file beyond one of them is refused
with its name before the work that the limit is there to spare.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from rankdrop.errors import RobotError, visible

LARGEST_FILE = 50 * 2**20
"""Bytes of an XML file, a trajectory or a result; the largest robot descriptions in use are below 1 MB."""
LARGEST_TABLE = 2**20
"""Bytes of a TOML file or a list of screws; the largest table of the catalogue has 6 kB."""
DEEPEST = 100
"""Elements of XML, or lists and objects of YAML, inside one another."""
MOST_ELEMENTS = 200_000
"""Of an XML file; a humanoid with its meshes has some 2,000."""
MOST_BODIES = 20_000
"""Elements of an MJCF file: MuJoCo compiles all of it, whatever the chain."""
MOST_JOINTS = 200
"""Moving joints of a chain; no arm is longer."""
MOST_STEPS = 5_000
"""Joints of a chain, those that do not move included."""
DOTS = 4_000_000
"""Sum over the lines of a TOML file of (dots in the line)²: what its keys with dots can cost the parser."""
MOST_ROWS = 1_000_000
"""Rows of a trajectory."""
LARGEST_YAML = 2 * 2**20
"""Bytes of a trajectory in YAML, which is read a hundred times more slowly than JSON."""
LARGEST_ARRAY = 500 * 2**20
"""Bytes of an array in NumPy's files; a million rows of twenty joints have a third of it."""
MOST_MEMBERS = 1_000
"""Arrays of an archive of NumPy's; at most five of them are read."""
LONGEST_HEAD = 200
"""Characters of the name of a column."""
LONGEST_NAME = 200
"""Bytes of the name of a robot, a joint or a link: files are named after arms."""
LONGEST_TEXT = 200
"""Characters of a number as text: arithmetic with its unit."""

LARGEST_LENGTH = 1e12
"""[m]; no arm is longer, one given in µm has no larger number, and squares beyond the doubles are far away."""
LARGEST_ANGLE = 1e6
"""[rad]; beyond it neighbouring doubles are more than 1e-10 rad apart."""
LARGEST_TIME = 1e12
"""[s] of a trajectory; clocks that count from 1970 are at 2e9."""
LARGEST_NUMBER = 1e100
"""Of an entry of an axis or a screw: its square is still a double."""
RANGE = {"angle": LARGEST_ANGLE, "length": LARGEST_LENGTH, "number": LARGEST_NUMBER}
_UNIT = {"angle": " rad", "length": " m", "number": ""}

_DECLARED = re.compile(rb"""<\?xml[^>]*encoding\s*=\s*["'](iso-8859-1|latin-?1|windows-1252)["']""", re.IGNORECASE)

_MISPLACED = expat.errors.codes[expat.errors.XML_ERROR_MISPLACED_XML_PI]


def allowed_range(measure: str, *, rate: bool = False) -> str:
    """The range of an angle, a length or a number, in words.

    Example:
        >>> allowed_range("angle"), allowed_range("length", rate=True)
        ('-1e+06 … 1e+06 rad', '-1e+12 … 1e+12 m/s')
    """
    most = RANGE[measure]
    return f"-{most:g} … {most:g}{_UNIT[measure]}{'/s' if rate else ''}"


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
    if not path.exists():
        raise RobotError("there is no such file", where=where)
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


def name_of_file(path: Path) -> str:
    """The name of an arm whose file gives none."""
    return visible(path.stem)[: LONGEST_NAME // 4]


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
    most = MOST_ELEMENTS if most is None else most
    parser = expat.ParserCreate("utf-8")
    document = Element("", {}, 0)
    open_elements: list[Element | None] = [document]  # None: left out, and so is all that it holds
    count = 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        line = parser.CurrentLineNumber
        if len(open_elements) > DEEPEST:
            raise RobotError("the elements are nested too deeply", where=f"{file}, line {line}",
                             allowed=f"depth {DEEPEST}")  # fmt: skip
        if count > most:
            raise RobotError("there are too many elements", where=f"{file}, line {line}", allowed=f"at most {most}")
        above, element = open_elements[-1], Element(tag, attributes, line)
        kept = above is not None and tag not in skip
        if above is not None and kept:
            above.children.append(element)
        open_elements.append(element if kept else None)

    def end(_: str) -> None:
        open_elements.pop()

    def refuse(*_: object) -> int:
        raise RobotError("document types and entities are refused", where=f"{file}, line {parser.CurrentLineNumber}",
                         mend="take out <!DOCTYPE …> and &entities;")  # fmt: skip

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.StartDoctypeDeclHandler = parser.EntityDeclHandler = parser.ExternalEntityRefHandler = refuse
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        reason = expat.ErrorString(error.code)
        before = text.find("<?xml") > 0 and error.code == _MISPLACED
        raise RobotError(
            f"this is not well-formed XML: {reason}", where=f"{file}, line {error.lineno}",
            mend="take out what stands before <?xml …?>, blank lines too" if before else None,
        ) from None
    if not document.children:  # the root itself is one of those left out
        raise RobotError("there is no element to read", where=file)
    return document.children[0]
