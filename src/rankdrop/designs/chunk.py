"""What a worker makes of a chunk: the records of some variants, one after the other, as one line of JSON each."""

from __future__ import annotations

import json
from functools import lru_cache
from typing import Any

from rankdrop.designs.measure import FRESH, STARTS, Effort, families_of, measured
from rankdrop.errors import RankdropError
from rankdrop.families.residual import Memory
from rankdrop.results.known import known_analysis
from rankdrop.robot.drawing import Drawing, Place
from rankdrop.task import Task

Plan = dict[str, Any]


def variants(plan: Plan, chunk: int) -> bytes:
    """The records of the variants of one chunk of a sweep.

    The memory of forms begins with the nominal arm's, and goes from variant to variant within the chunk.
    """
    drawing, task = Drawing(**plan["drawing"]), task_of(plan["task"])
    places = [[Place(*one) for one in parameter] for parameter in plan["places"]]
    searched = any(plan["asks"][ask] is not None for ask in ("families", "near", "paths"))
    key = json.dumps([plan["drawing"], plan["task"], plan["asks"]["families"], plan["limits"], plan["seed"]])
    memory = _memory(key) if searched else Memory()
    size = plan["size"]
    lines = []
    for number, values in plan["variants"][chunk * size : (chunk + 1) * size]:
        given = {place: x for group, x in zip(places, values, strict=True) for place in group}
        try:
            robot = drawing.robot(given, f"{drawing.nominal.name} {number + 1}")
            record = measured(robot, task, plan["asks"], memory, limits=plan["limits"], seed=plan["seed"])
        except RankdropError as error:  # the numbers make no arm
            record = {"measures": {}, "error": str(error)}
        lines.append(line_of({"number": number, "values": values, **record}))
    return b"".join(lines)


def arms(plan: Plan, chunk: int) -> bytes:
    """The record of one arm of a comparison; an arm of the catalogue has the families that it has there."""
    entry = plan["arms"][chunk]
    robot, task = Drawing(**entry["drawing"]).nominal, task_of(entry["task"])
    known = None if plan["limits"] else known_analysis(robot, task)  # what `analyze` says of it
    record = measured(robot, task, plan["asks"], Memory(), limits=plan["limits"], seed=plan["seed"], known=known)
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
def _nominal(key: str) -> Memory:
    """What is remembered of the nominal arm: the same in every worker."""
    drawing, task, asked, limits, seed = json.loads(key)
    memory = Memory()
    effort = Effort(asked["starts"] if asked else STARTS, asked["fresh"] if asked else FRESH, limits, seed)
    families_of(Drawing(**drawing).nominal, task_of(task), effort, memory)
    return memory


def _memory(key: str) -> Memory:
    """A copy of the nominal arm's, for one chunk."""
    nominal = _nominal(key)
    return Memory({signature: dict(forms) for signature, forms in nominal.forms.items()}, dict(nominal.names))
