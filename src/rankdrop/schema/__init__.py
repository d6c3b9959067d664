"""The entries of every kind of file, as tables: they encode, decode strictly, and are the published JSON Schemas."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module
from pathlib import Path
from typing import Any, ClassVar

from msgspec import Struct

from rankdrop.codec import decode, encode, json_schema, save_record
from rankdrop.errors import OptionError, ResultFileError
from rankdrop.sections import Section, html, text

_ROOM = {
    "analysis": "families", "find": "families", "explanation": "explanation", "escape": "explanation",
    "nearest": "explanation", "tolerant": "explanation", "conditions": "families", "jacobian": "design",
    "path": "motion", "paths": "motion", "aspects": "motion", "through": "motion", "path-rows": "motion",
    "cover": "proof", "certificate": "proof", "verified": "proof", "sweep": "design", "side-by-side": "design",
}  # fmt: skip
_PARTS = {"robot": "arm", "family": "families", "inside": "families"}
NAMES = tuple(_ROOM)
"""Kinds of result files: each is what the command of that name writes with --json, `explain` the explanation,
`compare` the side-by-side."""


def table_of(kind: str) -> type[Struct]:
    """The table of a kind of file, or "robot", "family", "inside"; imported when it is first used.

    Raises:
        OptionError: there is no such kind.
    """
    if kind in _PARTS:
        part: type[Struct] = getattr(import_module(f"rankdrop.schema.{_PARTS[kind]}"), kind.upper())
        return part
    if kind not in _ROOM:
        raise OptionError("there is no such schema", got=repr(kind), allowed=", ".join(NAMES))
    name = f"{kind.upper().replace('-', '_')}_FILE"
    made: type[Struct] = getattr(import_module(f"rankdrop.schema.{_ROOM[kind]}"), name)
    return made


def load_schema(name: str) -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of a kind of file, generated from its table.

    Args:
        name: "analysis" (`rankdrop analyze --json`), "find", "explanation" (`rankdrop explain --json`), "escape",
            "nearest", "tolerant", "conditions", "jacobian", "path", "paths" (`rankdrop path --json` with several
            files), "aspects", "through", "path-rows" (`rankdrop path --rows OUT.json`), "cover", "certificate"
            (--certificate), "verified" (`rankdrop verify --json`), "sweep" or "side-by-side" (`rankdrop compare`).

    Raises:
        OptionError: there is no such schema.

    Example:
        >>> load_schema("analysis")["properties"]["schema"]["const"]
        'rankdrop/analysis/1'
    """
    schema = json_schema(table_of(name))
    entry = schema["properties"]["schema"]
    entry["const"] = entry.pop("enum")[0]
    number = entry["const"].rpartition("/")[2]
    return schema | {"$id": f"urn:rankdrop:{name}:{number}", "title": f"rankdrop {name}, version {number}"}


def check_record(kind: str, record: Any) -> None:
    """Compare plain data with the table of a kind of file.

    Raises:
        ResultFileError: with the path of the first element that is not as it should be.
    """
    try:
        decode(table_of(kind), record)
    except ResultFileError as error:
        what = f"the {kind} is damaged: {error.what}"
        raise ResultFileError(what, where=error.where, got=error.got, mend="make the file again") from None


def record_of(kind: str, result: Any) -> dict[str, Any]:
    """A result as the plain data of its file."""
    return encode(table_of(kind), result)


class Result:
    """What a verb returns: plain data, a JSON file, text, a table in a notebook. `FILE` is its kind of file."""

    FILE: ClassVar[str]

    def sections(self) -> Iterable[Section]:
        """As sections of text."""
        raise NotImplementedError

    def to_dict(self) -> dict[str, Any]:
        """The record of its JSON file: docs/json.md."""
        return record_of(self.FILE, self)

    def save(self, path: str | Path) -> None:
        """Write it to a JSON file.

        Raises:
            ResultFileError: the file cannot be written; an old one of this name is as it was.
        """
        save_record(self.to_dict(), path)

    def __str__(self) -> str:
        return text(self.sections())

    def _repr_html_(self) -> str:
        """For notebooks."""
        return html(self.sections())
