"""Records as plain data for JSON, and back without loss: by the fields of the records, once for all.

`plain` goes there, `restored` comes back; what JSON says beside the fields (the joints as a reader wants them, the
terms of an equation, shares with their intervals) is added below.

Infinities (limits that the source does not give) are written as null; joints are numbered from 1.
"""

from __future__ import annotations

from dataclasses import MISSING, fields, is_dataclass
from enum import Enum
from functools import cache
from itertools import repeat
from math import isfinite
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, get_args, get_origin, get_type_hints

import msgspec
import numpy as np

from rankdrop.codec import Record as Record
from rankdrop.codec import encode, table_of
from rankdrop.codec import json_text as json_text
from rankdrop.codec import plain as plain
from rankdrop.codec import save_record as save_record
from rankdrop.errors import RankdropError, ResultFileError
from rankdrop.family.equation import Equation
from rankdrop.family.record import Check, CorankSummary, Family, Sampled
from rankdrop.robot.files import read_text
from rankdrop.robot.model import Robot
from rankdrop.task import Task


def read_record(path: str | Path) -> Any:
    """The data in a JSON file.

    Raises:
        ResultFileError: the file cannot be read, is too large, or is not JSON; NaN and infinities are none.
    """

    try:
        Path(path).stat()
        return msgspec.json.decode(read_text(Path(path)))
    except OSError as error:
        raise ResultFileError(f"the file cannot be read: {error.strerror or error}", where=str(path)) from error
    except RankdropError as error:
        raise ResultFileError(error.what, where=error.where, got=error.got, allowed=error.allowed) from error
    except RecursionError:
        what = "the file cannot be read as JSON: its lists and objects are nested too deeply"
        raise ResultFileError(what, where=str(path)) from None
    except (ValueError, msgspec.MsgspecError) as error:
        raise ResultFileError("the file cannot be read as JSON", where=str(path), got=str(error)[:200]) from error


def number_or_null(value: float) -> float | None:
    """A number, or None where it is infinite."""
    return value if isfinite(value) else None


def restored(kind: Any, data: Any) -> Any:
    """What `plain` made data of, by the types of the fields: `restored(type(x), plain(x))` is equal to x.

    Entries that a record does not have are a later version's and left out; those that are missing were not known to an
    earlier one and have their defaults. Null stands for the default where the field is no "or None": an infinity.

    Args:
        kind: a dataclass, or what a field is annotated with.
        data: plain data.

    Raises:
        KeyError, TypeError, ValueError: an entry without a default is missing, or is something else.
    """
    if kind is Equation:
        return Equation.from_dict({"terms": data})
    if isinstance(kind, type) and is_dataclass(kind):
        types, given = _types(kind), {}
        for field in fields(kind):
            kept = field.default is not MISSING or field.default_factory is not MISSING
            if kept and (field.name not in data or (data[field.name] is None and types[field.name] is float)):
                continue
            given[field.name] = restored(types[field.name], data[field.name])
        return kind(**given)
    inner = get_args(kind)
    if isinstance(kind, UnionType):
        others = [one for one in inner if one is not NoneType]
        return data if data is None or len(others) > 1 else restored(others[0], data)
    origin = get_origin(kind)
    if origin is tuple:
        kinds = repeat(inner[0]) if inner[-1] is Ellipsis else inner
        return tuple(restored(one, part) for one, part in zip(kinds, data, strict=inner[-1] is not Ellipsis))
    if origin is np.ndarray:
        return np.array(data)
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind(data)
    return dict(data) if isinstance(data, dict) else data


@cache
def _types(kind: type[Any]) -> dict[str, Any]:
    return get_type_hints(kind)


def robot_to_dict(robot: Robot, task: Task, generic_rank: int) -> Record:
    """The arm as analysed: what a reader wants first, then `chain`, from which the robot is built again."""
    return encode(table_of("robot"), (robot, task, generic_rank))


def robot_from_dict(record: Record) -> Robot:
    """The robot of a record made by `robot_to_dict`."""
    lengths = record.get("lengths", {}).items()
    robot: Robot = restored(
        Robot, record | {"joints": record["chain"], "task": record["made_for"], "lengths": lengths}
    )
    return robot


def task_from_dict(record: Record, length_scale: float) -> Task:
    """The task of a record made by `robot_to_dict`; its length scale [m] stands among the settings."""
    task: Task = restored(Task, {**record, "name": record["task"], "length_scale": length_scale})
    return task


def _check(record: Record, agree: str) -> Check:
    return Check(record["tested"], record[agree])


def corank_from_dict(record: Record) -> CorankSummary:
    """The summary of a record made by `SUMMARY`."""
    completeness = plain(_check(record["completeness"], "explained"))
    summary: CorankSummary = restored(CorankSummary, record | {"completeness": completeness})
    return summary


def family_from_dict(record: Record) -> Family:
    """The family of a record made by `FAMILY`.

    Raises:
        ResultFileError: an equation whose text and terms say different things.
    """
    evidence = Sampled(
        record["evidence"], _check(record["soundness"], "singular"), _check(record["explained"], "explained")
    )
    family: Family = restored(Family, record | {"equations": record["terms"], "evidence": evidence})
    if plain(family.equations) != record["equations"]:
        raise ResultFileError("equations and terms of a family disagree", where=f"family {record['id']}")
    return family
