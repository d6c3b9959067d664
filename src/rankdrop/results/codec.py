"""Robots, tasks and families as plain dictionaries for JSON, and back without loss.

Infinities (limits that the source does not give) are written as null; joints are numbered from 1.
"""

from __future__ import annotations

import json
import re
from dataclasses import MISSING, asdict, fields, is_dataclass
from math import inf, isfinite
from pathlib import Path
from typing import Any

import numpy as np

from rankdrop.disk import replace_file
from rankdrop.errors import RankdropError, ResultFileError
from rankdrop.families.share import Near, NearShare
from rankdrop.family.equation import Equation
from rankdrop.family.record import CorankSummary, Family, Pinned, Share, Soundness, Unseen
from rankdrop.frames import Frame
from rankdrop.robot.files import read_text
from rankdrop.robot.ideal import near_ideal
from rankdrop.robot.model import Joint, JointKind, Mimic, Robot, Source
from rankdrop.task import Task

Record = dict[str, Any]
_STEERING = re.compile("[\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff]")  # JSON itself escapes the others


def known(kind: type[Any], record: Record) -> Record:
    """The entries of `record` that the dataclass `kind` has: a later version may write more, an earlier one less of
    what has a default.
    """
    return {
        field.name: record[field.name]
        for field in fields(kind)
        if field.name in record or (field.default is MISSING and field.default_factory is MISSING)
    }


def json_text(record: Any) -> str:
    """JSON for people too: indented, a row of numbers on one line; NaN and infinities are refused."""
    text = json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False)
    text = _STEERING.sub(lambda letter: f"\\u{ord(letter[0]):04x}", text)  # the same text to a reader of JSON
    # strings hold no raw line break, so only arrays of numbers match
    return re.sub(r"\[\n[\s\d.,eE+-]+\]", lambda row: f"[{' '.join(row[0][1:-1].split())}]", text) + "\n"


def save_record(record: Record, path: str | Path) -> None:
    """Write a record to a JSON file.

    Raises:
        ResultFileError: the file cannot be written; an old one of this name is as it was.
    """
    try:
        replace_file(path, json_text(record).encode())
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise ResultFileError(f"the file cannot be written: {reason}", where=str(path)) from error


def read_record(path: str | Path) -> Any:
    """The data in a JSON file.

    Raises:
        ResultFileError: the file cannot be read, is too large, or is not JSON; NaN and infinities are none.
    """

    def refused(word: str) -> None:
        raise ValueError(f"{word} is no number of JSON")

    try:
        Path(path).stat()
        return json.loads(read_text(Path(path)), parse_constant=refused)
    except OSError as error:
        raise ResultFileError(f"the file cannot be read: {error.strerror or error}", where=str(path)) from error
    except RankdropError as error:
        raise ResultFileError(error.what, where=error.where, got=error.got, allowed=error.allowed) from error
    except RecursionError:
        what = "the file cannot be read as JSON: its lists and objects are nested too deeply"
        raise ResultFileError(what, where=str(path)) from None
    except ValueError as error:
        raise ResultFileError("the file cannot be read as JSON", where=str(path), got=str(error)[:200]) from error


def number_or_null(value: float) -> float | None:
    """A number, or None where it is infinite."""
    return value if isfinite(value) else None


def plain(value: Any) -> Any:
    """A record as plain data for JSON: dataclasses become objects, arrays lists, numbers that are not finite null."""
    if isinstance(value, Equation):
        return value.text()
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value) if field.name[0] != "_"}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    if isinstance(value, dict):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, float):
        return number_or_null(value)
    return value


def robot_to_dict(robot: Robot, task: Task, generic_rank: int) -> Record:
    """The arm as analysed: what a reader wants first, then `chain`, from which the robot is built again."""
    return {
        "name": robot.name,
        "n": robot.n,
        "task": task.name,
        "generic_rank": generic_rank,
        "joints": [
            {
                "name": joint.name,
                "number": number,
                "kind": str(joint.kind),
                "lower": number_or_null(joint.lower),
                "upper": number_or_null(joint.upper),
            }
            for number, joint in enumerate(robot.variables, start=1)
        ],
        "base": robot.base,
        "tip": robot.tip,
        "about": robot.about,
        "notes": list(robot.notes),
        **({"lengths": dict(robot.lengths)} if robot.lengths else {}),
        **_near_to_dict(robot),
        "source": asdict(robot.source),
        "made_for": robot.task,
        "frame": {"axes": task.frame.axes, "origin": task.frame.origin, "point": list(task.frame.point)},
        "rows": list(task.rows),
        "home": robot.home.tolist(),
        "chain": [_joint_to_dict(joint) for joint in robot.joints],
    }


def _near_to_dict(robot: Robot) -> Record:
    """The ideal arm that is near, and what `--ideal` takes to find it; no entry where none is."""
    found = near_ideal(robot)
    if found is None:
        return {}
    return {
        "near": {"text": found.text, "length": found.length, "angle": found.angle, "ideal": found.tolerance.text}
    }


def _joint_to_dict(joint: Joint) -> Record:
    return {
        "name": joint.name,
        "kind": str(joint.kind),
        "screw": joint.screw.tolist(),
        "lower": number_or_null(joint.lower),
        "upper": number_or_null(joint.upper),
        "velocity": number_or_null(joint.velocity),
        "frame": joint.frame.tolist(),
        "mimic": asdict(joint.mimic) if joint.mimic else None,
        **({"link": joint.link} if joint.link else {}),
    }


def robot_from_dict(record: Record) -> Robot:
    """The robot of a record made by `robot_to_dict`."""
    return Robot(
        name=record["name"],
        joints=tuple(_joint_from_dict(joint) for joint in record["chain"]),
        home=np.array(record["home"]),
        task=record["made_for"],
        source=Source(**known(Source, record["source"])),
        base=record["base"],
        tip=record["tip"],
        notes=tuple(record["notes"]),
        about=record["about"],
        lengths=tuple(record.get("lengths", {}).items()),
    )


def _joint_from_dict(record: Record) -> Joint:
    lower, upper, velocity = record["lower"], record["upper"], record["velocity"]
    return Joint(
        name=record["name"],
        kind=JointKind(record["kind"]),
        screw=np.array(record["screw"]),
        lower=-inf if lower is None else lower,
        upper=inf if upper is None else upper,
        velocity=inf if velocity is None else velocity,
        frame=np.array(record["frame"]),
        mimic=Mimic(**known(Mimic, record["mimic"])) if record["mimic"] else None,
        link=record.get("link", ""),
    )


def task_from_dict(record: Record, length_scale: float) -> Task:
    """The task of a record made by `robot_to_dict`; its length scale [m] stands among the settings."""
    frame = record["frame"]
    x, y, z = frame["point"]
    return Task(record["task"], tuple(record["rows"]), Frame(frame["axes"], frame["origin"], (x, y, z)), length_scale)


def summary_to_dict(summary: CorankSummary) -> Record:
    """What one corank's search met."""
    return asdict(summary)


def summary_from_dict(record: Record) -> CorankSummary:
    """The summary of a record made by `summary_to_dict`."""
    completeness = Share(**known(Share, record["completeness"]))
    unseen = Unseen(**known(Unseen, record["unseen"]))
    return CorankSummary(**{**known(CorankSummary, record), "completeness": completeness, "unseen": unseen})


def family_to_dict(family: Family) -> Record:
    """One row of a table; `equations` are for reading and for eval, `terms` say the same as data."""
    return {
        "id": family.id,
        "name": family.name,
        "named": family.named,
        "corank": family.corank,
        "dimension": family.dimension,
        "pinned": [
            {"joint": pinned.joint, "number": pinned.number, "values": list(pinned.values)} for pinned in family.pinned
        ],
        "free": list(family.free),
        "coupled": list(family.coupled),
        "equations": [equation.text() for equation in family.equations],
        "terms": [equation.to_dict()["terms"] for equation in family.equations],
        "witness": list(family.witness),
        "lost_directions": family.lost_directions.tolist(),
        "lost_words": list(family.lost_words),
        "soundness": asdict(family.soundness),
        "explained": asdict(family.explained),
        "evidence": family.evidence,
    }


def family_from_dict(record: Record) -> Family:
    """The family of a record made by `family_to_dict`.

    Raises:
        ResultFileError: an equation whose text and terms say different things.
    """
    equations = tuple(Equation.from_dict({"terms": terms}) for terms in record["terms"])
    if [equation.text() for equation in equations] != record["equations"]:
        raise ResultFileError("equations and terms of a family disagree", where=f"family {record['id']}")
    return Family(
        id=record["id"],
        name=record["name"],
        corank=record["corank"],
        dimension=record["dimension"],
        pinned=tuple(Pinned(one["joint"], one["number"], tuple(one["values"])) for one in record["pinned"]),
        free=tuple(record["free"]),
        coupled=tuple(record["coupled"]),
        equations=equations,
        witness=tuple(record["witness"]),
        lost_directions=np.array(record["lost_directions"]),
        lost_words=tuple(record["lost_words"]),
        soundness=Soundness(**known(Soundness, record["soundness"])),
        explained=Share(**known(Share, record["explained"])),
        evidence=record["evidence"],
        named=record["named"],
    )


def near_to_dict(near: Near) -> Record:
    """Shares of the joint space near families, with standard errors and 95 % intervals."""
    return {
        "within": near.within,
        "samples": near.samples,
        "seed": near.seed,
        "limits": near.limits,
        "families": [_near_row(one) for one in near.families],
        "any": _near_row(near.any),
    }


def _near_row(one: NearShare) -> Record:
    low, high = one.interval
    return {
        "id": one.id, "near": one.near, "samples": one.samples, "bound": one.bound, "share": one.share,
        "error": one.error, "low": low, "high": high,
    }  # fmt: skip


def near_from_dict(record: Record) -> Near:
    """The shares of a record made by `near_to_dict`."""
    rows = tuple(NearShare(**known(NearShare, row)) for row in record["families"])
    every = NearShare(**known(NearShare, record["any"]))
    return Near(record["within"], record["samples"], record["seed"], record["limits"], rows, every)
