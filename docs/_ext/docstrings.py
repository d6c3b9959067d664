"""House docstrings for autodoc: `code` in single back-quotes, indented equations, and * _ | that mean themselves."""

from __future__ import annotations

import re
from typing import Any

from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

_SECTION = re.compile(r"^(Args|Attributes|Returns|Raises|Example|Examples|Yields|Note|Source):\s*$")
_NAMES = re.compile(r"^\s+\w+(?:, \w+)+(?=:\s)")
_CODE = re.compile(r"(`[^`]+`)")
_SPECIAL = re.compile(r"([\\*|]|(?<=\w)_(?!\w))")


def plain(line: str) -> str:
    """A line of text: code becomes literal, whatever stands beside it; everything else stands for itself."""
    pieces = _CODE.split(line)
    return "".join(
        f"\\ ``{piece.strip('`')}``\\ " if i % 2 else _SPECIAL.sub(r"\\\1", piece) for i, piece in enumerate(pieces)
    )


def converted(lines: list[str]) -> list[str]:
    """A docstring as reStructuredText, sections left for napoleon."""
    found: list[str] = []
    in_section = literal = doctest = False
    for line in lines:
        text = line.strip()
        if _SECTION.match(line):
            in_section = True
        elif text and not line.startswith(" "):
            in_section = False
        doctest = text.startswith(">>>") or (doctest and bool(text))
        starts = text and line.startswith("    ") and not in_section and not doctest
        if starts and not literal and (not found or not found[-1].strip()):
            found += ["::", ""]  # an equation set off by indentation
            literal = True
        elif text and not starts:
            if literal and found[-1].strip():
                found.append("")
            literal = False
        if in_section:  # "robot, task: …" is one entry of two names, not the name task of type robot
            line = _NAMES.sub(lambda names: names[0].replace(", ", ",\u200b"), line)
        found.append(line if literal or doctest else plain(line))
    return found


def convert(app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """The event handler; napoleon comes after it."""
    lines[:] = converted(lines)


def named(
    app: Sphinx, what: str, name: str, obj: Any, options: Any, signature: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    """Aliases of types under their names, in unions as well: ArrayLike, not what it stands for."""
    first, last = (
        re.sub(r"TypeAliasForwardRef\('(\w+)'\)", r"\1", text or "") or None for text in (signature, returned)
    )
    return first, last


def setup(app: Sphinx) -> ExtensionMetadata:
    """Come before napoleon."""
    app.connect("autodoc-process-docstring", convert, priority=100)
    app.connect("autodoc-process-signature", named)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
