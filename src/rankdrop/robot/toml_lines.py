"""On which line of a TOML text a key stands: `tomllib` does not say."""

from __future__ import annotations

import re

_HEADER = re.compile(r"\s*(\[\[?)\s*([\w.-]+)\s*\]\]?\s*(?:#.*)?")
_KEY = re.compile(r"""\s*(?:"([^"]*)"|'([^']*)'|([\w-]+))\s*[.=]""")


class TomlLines:
    """First lines of the tables and keys of a TOML text, found by reading it line by line.

    Example:
        >>> TomlLines('name = "x"\\n[[joints]]\\na = 1\\n[[joints]]\\na = 2').find("joints", 1, "a")
        5
    """

    def __init__(self, text: str) -> None:
        self._lines: dict[tuple[str, int | None, str], int] = {}
        table: tuple[str, int | None] = ("", None)
        counts: dict[str, int] = {}
        closing = ""
        for number, line in enumerate(text.splitlines(), 1):
            if closing:  # inside a text of several lines
                closing = "" if closing in line else closing
                continue
            header = _HEADER.fullmatch(line)
            if header is not None:
                name = header[2]
                if header[1] == "[[":
                    counts[name] = counts.get(name, -1) + 1
                table = (name, counts.get(name))
                self._lines.setdefault((*table, ""), number)
                continue
            key = _KEY.match(line)
            if key is not None:
                self._lines.setdefault((*table, key[1] or key[2] or key[3]), number)
            closing = next((mark for mark in ('"""', "'''") if line.count(mark) % 2), "")

    def exact(self, table: str, index: int | None, key: str) -> int | None:
        """Line, from 1, of just this key (of the table for ""); None where it has none of its own."""
        return self._lines.get((table, index, key))

    def find(self, table: str, index: int | None, key: str) -> int:
        """Line, from 1, of `key` in the table (`index` counts [[tables]] from 0); else of the table; else 1."""
        places = ((table, index, key), (table, index, ""), ("", None, table))
        return next((self._lines[place] for place in places if place in self._lines), 1)
