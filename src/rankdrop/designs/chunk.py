"""What a worker makes of a chunk: the records of some variants, one after the other, as one line of JSON each."""

from __future__ import annotations

import json
from functools import lru_cache
from typing import Any

from rankdrop.designs.measure import measured, nominal_conditions
from rankdrop.errors import RankdropError
from rankdrop.results.conditions import Conditions
from rankdrop.results.known import known_analysis
from rankdrop.robot.drawing import Drawing, Place
from rankdrop.task import Task

Plan = dict[str, Any]


def variants(plan: Plan, chunk: int) -> bytes:
    """The records of the variants of one chunk of a sweep.

    The families of the nominal arm are derived once in each process.
    """
    drawing, task = Drawing(**plan["drawing"]), task_of(plan["task"])
    places = [[Place(*one) for one in parameter] for parameter in plan["places"]]
    searched = any(plan["asks"][ask] is not None for ask in ("families", "near", "paths"))
    nominal = _nominal(json.dumps([plan["drawing"], plan["task"]])) if searched else None
    size = plan["size"]
    lines = []
    for number, values in plan["variants"][chunk * size : (chunk + 1) * size]:
        given = {place: x for group, x in zip(places, values, strict=True) for place in group}
        try:
            robot = drawing.robot(given, f"{drawing.nominal.name} {number + 1}")
            record = measured(robot, task, plan["asks"], nominal, limits=plan["limits"], seed=plan["seed"])
        except RankdropError as error:  # the numbers make no arm
            record = {"measures": {}, "error": str(error)}
        lines.append(line_of({"number": number, "values": values, **record}))
    return b"".join(lines)


def arms(plan: Plan, chunk: int) -> bytes:
    """The record of one arm of a comparison; an arm of the catalogue has the families that it has there."""
    entry = plan["arms"][chunk]
    robot, task = Drawing(**entry["drawing"]).nominal, task_of(entry["task"])
    known = None if plan["limits"] else known_analysis(robot, task)  # what `analyze` says of it
    record = measured(robot, task, plan["asks"], None, limits=plan["limits"], seed=plan["seed"], known=known)
    return line_of({"number": chunk, "values": [], **record})


def line_of(record: Plan) -> bytes:
    """One line of JSON."""
    return json.dumps(record, ensure_ascii=False, allow_nan=False, sort_keys=True).encode() + b"\n"


def task_to_dict(task: Task) -> Plan:
    """A task as plain data, its length scale resolved."""
    return {"name": task.name, "rows": list(task.rows), "length_scale": task.length_scale}


def task_of(record: Plan) -> Task:
    """The task of a record made by `task_to_dict`."""
    return Task(record["name"], tuple(record["rows"]), length_scale=record["length_scale"])


@lru_cache(maxsize=1)
def _nominal(key: str) -> Conditions | None:
    """The derivation of the nominal arm: the same in every worker."""
    drawing, task = json.loads(key)
    return nominal_conditions(Drawing(**drawing).nominal, task_of(task))
