"""Names of families of small arms."""

from __future__ import annotations

from math import pi

from rankdrop.families.naming import name_family
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Array, Robot
from rankdrop.task import resolve_task

H = pi / 2


def ur() -> Robot:
    rows = [(0, H, 0.09, 0), (-0.425, 0, 0, 0), (-0.392, 0, 0, 0), (0, H, 0.11, 0), (0, -H, 0.095, 0), (0, 0, 0.08, 0)]
    return from_dh(rows, convention="standard", name="c")


def name(robot: Robot, q: Array, task: str | None = None) -> str:
    return str(name_family(robot, resolve_task(task, robot), q))
