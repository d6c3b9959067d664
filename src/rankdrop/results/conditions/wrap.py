"""Long lines on several: sentences between words, formulas where a reader breaks them."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator

_BREAKS = tuple(re.compile(text) for text in (r"(?<=[,;]) ", r" (?=[+−=≠] (?!0$))", r" (?=\()", r" (?== 0$)"))
"""Places for a break, the better kinds first."""
_HANG = 4
_WORD = re.compile(r"\b[a-z]{4,}\b")
_WORDS = 4  # so many words make a sentence


def either(line: str, width: int | None) -> list[str]:
    """A line of which is not known whether it is a sentence or a formula."""
    return sentence(line, width, _HANG) if len(_WORD.findall(line)) >= _WORDS else formula(line, width)


def formula(line: str, width: int | None) -> list[str]:
    """A formula in pieces of at most `width` characters, where its words allow that.

    It is broken before a sign or a bracket, outside of as many brackets as can be had; the rest is indented.

    Args:
        line: blanks before it are an indent.
        width: characters in a line; None for as many as there are.

    Example:
        >>> formula("a2 c2 + a3 (c23 + s23) = 0", 24)
        ['a2 c2', '    + a3 (c23 + s23) = 0']
    """
    if width is None or len(line) <= width:
        return [line]
    indent = len(line) - len(line.lstrip(" "))
    found, rest, inset = [], line.strip(), indent
    while len(rest) > max(width - inset, 20):
        place = _place(rest, max(width - inset, 20))
        found.append(" " * inset + rest[:place].rstrip())
        rest, inset = rest[place:].lstrip(), indent + _HANG
    return [*found, " " * inset + rest]


def sentence(line: str, width: int | None, hang: int = 0) -> list[str]:
    """A line of words in pieces of at most `width` characters; all but the first are indented by `hang` more."""
    indent = len(line) - len(line.lstrip(" "))
    if width is None or len(line) <= width:
        return [line]
    return textwrap.wrap(
        line.strip(), max(width, indent + hang + 20), initial_indent=" " * indent,
        subsequent_indent=" " * (indent + hang), break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip


def _place(text: str, room: int) -> int:
    """Where to break: at the shallowest place that is not right at the beginning, else at a blank, else at the end."""
    depths = list(_depths(text))
    places = [(m.start(), kind) for kind, one in enumerate(_BREAKS) for m in one.finditer(text) if m.start() <= room]
    late = [(place, kind) for place, kind in places if place > room // 5] or places
    if late:
        return min(late, key=lambda found: (depths[found[0]], found[1], -found[0]))[0]
    blanks = [i for i, letter in enumerate(text) if letter == " " and 0 < i <= room]
    return blanks[-1] if blanks else next((i for i, letter in enumerate(text) if letter == " "), len(text))


def _depths(text: str) -> Iterator[int]:
    """How many brackets are open before each character."""
    depth = 0
    for letter in text:
        yield depth
        depth += (letter == "(") - (letter == ")")
