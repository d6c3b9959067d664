"""Coverings without their account, for tests of the boxes alone."""

from __future__ import annotations

from typing import Any

from rankdrop.cover.covering import Covering
from rankdrop.robot.model import Robot
from rankdrop.verbs import cover


def covering(robot: Robot, width: float, **how: Any) -> Covering:
    """The boxes that `cover` makes."""
    return cover(robot, width=width, explain=False, **how).covering
