"""An arm, its task and its families as a header that C and C++ read: what `rankdrop/monitor.h` declares."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from math import isinf
from typing import TYPE_CHECKING

from rankdrop.certify.ball import settings_of
from rankdrop.certify.setting import Setting
from rankdrop.errors import OptionError
from rankdrop.robot.model import JointKind
from rankdrop.task import link_index

if TYPE_CHECKING:
    from rankdrop.families.monitor import Monitor

Value = int | float | str | list[int] | list[float] | list[str]

FORMAT = 2
"""`RANKDROP_ARM_FORMAT` of `src/core/monitor.h`."""
_LONG = 110  # characters of a line


def arm_header(monitor: Monitor, *, mark: str | None = None) -> str:
    """The text of a header with one constant, `rankdrop_MARK_arm`, of type `rankdrop_arm`.

    It holds every number to the last digit, so that C++ sees what Python sees. Families without conditions are left
    out; the others stand in the order in which they are preferred.

    Args:
        monitor: its arm, task, families, tolerances, thresholds and rates.
        mark: part of the constant's name; else made of the robot's.
    """
    mark = _mark(monitor.robot.name if mark is None else mark)
    fields: dict[str, Value] = _chain(monitor)
    arrays: dict[str, str] = {}
    for part in (_task(monitor), _families(monitor), _settings(monitor), _bounds(monitor)):
        fields |= part
    lines = [
        f"/* {_plain(monitor.robot.name)} and its families of singular configurations, written by rankdrop. */",
        f"#ifndef RANKDROP_ARM_{mark.upper()}_H", f"#define RANKDROP_ARM_{mark.upper()}_H", "",
        "#include <math.h>", "#include <rankdrop/monitor.h>", "",
    ]  # fmt: skip
    for name, value in fields.items():
        if isinstance(value, list):
            arrays[name] = f"rankdrop_{mark}_{name}"
            lines += _array(arrays[name], value, _TYPES.get(name, "double"))
    lines += ["", f"static const rankdrop_arm rankdrop_{mark}_arm = {{"]
    lines += [f"    {arrays.get(name) or _one(value)}, /* {name} */" for name, value in fields.items()]
    return "\n".join([*lines, "};", "", "#endif", ""])


_WORDS = "const char* const"
_TYPES = {
    **dict.fromkeys(("variable_names", "ids", "names"), _WORDS),
    **dict.fromkeys(
        ("turns", "variable", "row", "corank", "first_turn", "turning", "angle", "powers", "first_term", "coupled",
         "first_equation", "first_pin", "pinned", "first_value", "periodic", "bound_row", "bound_link"), "int",
    ),
}  # fmt: skip


def _chain(monitor: Monitor) -> dict[str, Value]:
    robot = monitor.robot
    index = {joint.name: i for i, joint in enumerate(robot.variables)}
    frames = [[[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]]
    frames += [joint.frame[:3].tolist() for joint in robot.joints] + [robot.home[:3].tolist()]
    mimics = [joint.mimic for joint in robot.joints]
    return {
        "format": FORMAT, "name": robot.name, "joints": len(robot.joints), "variables": robot.n,
        "screws": [float(x) for joint in robot.joints for x in joint.screw],
        "turns": [int(joint.kind is not JointKind.PRISMATIC) for joint in robot.joints],
        "frames": [x for t in frames for x in (*(x for row in t for x in row[:3]), *(row[3] for row in t))],
        "variable": [index[joint.mimic.leader if joint.mimic else joint.name] for joint in robot.joints],
        "multiplier": [mimic.multiplier if mimic else 1.0 for mimic in mimics],
        "offset": [mimic.offset if mimic else 0.0 for mimic in mimics],
        "variable_names": [joint.name for joint in robot.variables],
    }  # fmt: skip


def _task(monitor: Monitor) -> dict[str, Value]:
    task, joints = monitor.task, len(monitor.robot.joints)
    length = task.scale(monitor.robot)
    return {
        "rows": task.m, "axes": link_index(task.frame.axes, joints, "axes"),
        "origin": link_index(task.frame.origin, joints, "origin"), "point": list(task.frame.point),
        "row": list(task.rows), "factor": [1.0 / length if row < 3 else 1.0 for row in task.rows],
    }  # fmt: skip


def _families(monitor: Monitor) -> dict[str, Value]:
    families, table = monitor.watched, monitor.tables
    return {
        "families": len(families), "angles": len(table["shift"]), "terms": len(table["angle"]),
        "equations": len(table["coupled"]), "ids": [one.id for one in families],
        "names": [one.name for one in families],
        "corank": table["corank"], "shift": table["shift"], "first_turn": table["turns"], "turning": table["turning"],
        "m": table["m"], "angle": table["angle"], "cosine": table["a"], "sine": table["b"], "powers": table["powers"],
        "first_term": table["terms"], "coupled": table["coupled"], "first_equation": table["equations"],
        "first_pin": table["pins"], "pinned": table["pinned"], "first_value": table["at"], "values": table["values"],
        "scale": table["scale"], "periodic": table["periodic"],
    }  # fmt: skip


def _settings(monitor: Monitor) -> dict[str, Value]:
    set_to = monitor.settings
    return {
        "generic_rank": monitor.generic_rank, "singular": set_to["singular"], "on": set_to["on"],
        "loose": set_to["loose"], "start": monitor.start, "stop": monitor.stop, "beyond": int(monitor.beyond),
        "rates": monitor.rates.tolist(),
    }  # fmt: skip


def _bounds(monitor: Monitor) -> dict[str, Value]:
    """What enclosures are made from, the same as `certify.ball` takes; none for a task that cannot be certified."""
    made: Sequence[Setting] = ()
    with suppress(OptionError):
        made = settings_of(monitor.robot, monitor.task)
    return {
        "bounds": len(made), "bound_rows": len(made[0].rows) if made else 0,
        "bound_row": list(made[0].rows) if made else [], "bound_link": [one.link for one in made],
        "bound_point": [x for one in made for x in one.point], "bound_length": [one.length for one in made],
        "bound_reach": [x for one in made for x in one.arm.tolist()],
        "bound_repeats": made[0].repeats if made else 1.0,
    }  # fmt: skip


def _array(name: str, values: Sequence[int | float | str], kind: str) -> list[str]:
    """A constant array; C has none without entries."""
    if not values:
        values = [""] if kind == _WORDS else [0]
    lines = [f"static {'' if kind == _WORDS else 'const '}{kind} {name}[] = {{"]
    return [*lines, *_wrapped(_one(value) for value in values), "};"]


def _wrapped(words: Iterable[str]) -> list[str]:
    lines = ["   "]
    for word in words:
        if len(lines[-1]) + len(word) > _LONG:
            lines.append("   ")
        lines[-1] += f" {word},"
    return lines


def _one(value: Value) -> str:
    if isinstance(value, str):
        return '"' + "".join(_LETTERS.get(letter, letter) for letter in value) + '"'
    if isinstance(value, float) and isinf(value):
        return "HUGE_VAL" if value > 0 else "-HUGE_VAL"
    return repr(value)


_LETTERS = {'"': r"\"", "\\": r"\\", "\n": " ", "\r": " ", "?": r"\?"}


def _plain(text: str) -> str:
    return " ".join(text.replace("*/", "* /").replace("/*", "/ *").replace("\\", "/").split())


def _mark(text: str) -> str:
    """Text as part of an identifier."""
    return re.sub(r"[^A-Za-z0-9]+", "_", text).strip("_").lower() or "arm"
