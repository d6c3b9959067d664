"""Records as plain data for JSON, and back without loss: by the fields of the records, once for all.

`plain` goes there, `restored` comes back; what JSON says beside the fields (the joints as a reader wants them, the
terms of an equation, shares with their intervals) is added below.

Infinities (limits that the source does not give) are written as null; joints are numbered from 1.
"""

from __future__ import annotations

from math import isfinite
from pathlib import Path
from typing import Any, get_type_hints

import msgspec
import numpy as np

from rankdrop.codec import Record as Record
from rankdrop.codec import encode, table_of
from rankdrop.codec import json_text as json_text
from rankdrop.codec import plain as plain
from rankdrop.codec import save_record as save_record
from rankdrop.errors import RankdropError, ResultFileError
from rankdrop.family.equation import Equation
from rankdrop.family.record import CorankSummary, Family, Sampled
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
    earlier one and have their defaults.

    Args:
        kind: a dataclass, or what a field is annotated with.
        data: plain data.

    Raises:
        ValueError: an entry without a default is missing, or is something else.
    """
    try:
        return msgspec.convert(data, kind, dec_hook=lambda _, numbers: np.array(numbers))
    except msgspec.ValidationError as error:
        raise ValueError(str(error)) from error


def robot_to_dict(robot: Robot, task: Task, generic_rank: int) -> Record:
    """The arm as analysed: what a reader wants first, then `chain`, from which the robot is built again."""
    return encode(table_of("robot"), (robot, task, generic_rank))


def robot_from_dict(record: Record) -> Robot:
    """The robot of a record made by `robot_to_dict`."""
    lengths = list(record.get("lengths", {}).items())
    chain = [{key: value for key, value in joint.items() if value is not None} for joint in record["chain"]]
    robot: Robot = restored(Robot, record | {"joints": chain, "task": record["made_for"], "lengths": lengths})
    return robot


def task_from_dict(record: Record, length_scale: float) -> Task:
    """The task of a record made by `robot_to_dict`; its length scale [m] stands among the settings."""
    task: Task = restored(Task, {**record, "name": record["task"], "length_scale": length_scale})
    return task


def _check(record: Record, agree: str) -> Record:
    return {"tested": record["tested"], "agree": record[agree]}


def corank_from_dict(record: Record) -> CorankSummary:
    """The summary of a record made by `SUMMARY`."""
    completeness = _check(record["completeness"], "explained")
    summary: CorankSummary = restored(CorankSummary, record | {"completeness": completeness})
    return summary


def family_from_dict(record: Record) -> Family:
    """The family of a record made by `FAMILY`.

    Raises:
        ResultFileError: an equation whose text and terms say different things.
    """
    evidence = {"how": record["evidence"], "soundness": _check(record["soundness"], "singular"),
                "explained": _check(record["explained"], "explained")}  # fmt: skip
    kinds, own = get_type_hints(Family), record.keys() - {"evidence", "equations"}
    given = {name: restored(kind, record[name]) for name, kind in kinds.items() if name in own}
    equations = tuple(Equation.from_dict({"terms": terms}) for terms in record["terms"])
    family = Family(**given, equations=equations, evidence=restored(Sampled, evidence))
    if plain(family.equations) != record["equations"]:
        raise ResultFileError("equations and terms of a family disagree", where=f"family {record['id']}")
    return family
