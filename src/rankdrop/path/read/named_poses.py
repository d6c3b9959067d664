"""Poses of JSON and YAML as objects with one number for each name, as CSV has columns: {"x": 100, …, "a": 0, "b": 90}.

They are read as the table that they are: the names, units and conventions are those of columns.
"""

from __future__ import annotations

import re
from math import isfinite
from typing import Any

from rankdrop.path.read.makers import ANGLES, FANUC, KUKA, ROTATION_VECTOR
from rankdrop.path.read.messages import is_double
from rankdrop.path.read.trajectory import TrajectoryError

_NAME = re.compile(r"[A-Za-z_][\w./ \[\]°-]{0,60}")
_LENGTHS = ("x", "y", "z")
_ANGLES = frozenset((*ANGLES, *KUKA, *FANUC, *ROTATION_VECTOR))


def named_rows(value: Any) -> list[dict[str, Any]] | None:
    """Objects with x, y and z as numbers, of a list or of `poses`, or the `pose` of each; None where there are none."""
    rows = value
    if isinstance(value, dict):
        rows = value.get("poses")
    if not isinstance(rows, list) or not rows:
        return None
    inner = [_inner(entry) for entry in rows]
    first = inner[0]
    if first is None or not {_plain(key) for key in first} >= set(_LENGTHS):
        return None
    return [entry or {} for entry in inner]


def _inner(entry: Any) -> dict[str, Any] | None:
    """The object with the numbers: the entry, or its pose with the time of the entry."""
    if not isinstance(entry, dict):
        return None
    pose = entry.get("pose")
    if isinstance(pose, dict):
        return {key: entry[key] for key in ("time", "t") if key in entry} | pose
    return entry


def _plain(key: object) -> str:
    """The name of a number without its unit, in small letters."""
    return str(key).partition("[")[0].strip().lower()


def table_of(value: Any, rows: list[dict[str, Any]], name: str) -> str:
    """The table of the objects, as the text of a CSV file.

    Args:
        value: the document; its `length` and `angle` are the units of names without one.
        rows: of `named_rows`.
        name: for errors.

    Raises:
        TrajectoryError: a pose has other names than the first, or a value is no number.
    """
    keys = [key for key in rows[0] if isinstance(key, str) and _NAME.fullmatch(key) and is_double(rows[0][key])]
    lines = [",".join(_with_unit(key, value) for key in keys)]
    lines += [_line_of(row, keys, f"{name}, pose {number}") for number, row in enumerate(rows, start=1)]
    return "\n".join(lines) + "\n"


def _line_of(row: dict[str, Any], keys: list[str], where: str) -> str:
    """The numbers of a pose as a line; errors as of `table_of`."""
    missing = [key for key in keys if key not in row]
    if missing:
        raise TrajectoryError("the pose has other names than the first", where=where, mend=f"add {', '.join(missing)}")
    wrong = [key for key in keys if not is_double(row[key]) or not isfinite(row[key])]
    if wrong:
        raise TrajectoryError("a value is no finite number", where=where, got=", ".join(wrong))
    return ",".join(repr(float(row[key])) for key in keys)


def _with_unit(key: str, value: Any) -> str:
    """A name with the unit that the document states for its kind; as it is where none is stated."""
    kind = {True: "angle"}.get(key.lower() in _ANGLES, "")
    if key.lower() in _LENGTHS:
        kind = "length"
    unit = value.get(kind) if isinstance(value, dict) else None
    if not isinstance(unit, str):
        return key
    return f"{key} [{unit}]"
