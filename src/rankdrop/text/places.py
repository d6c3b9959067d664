"""Places of a path, joint values and how far joints turn, in words."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees
from typing import Any

from rankdrop.robot.model import Array, Robot
from rankdrop.text.words import minus, short

_AT_ROW = 1e-6  # share of the way between two rows that is reported as the row


def when(place: Any) -> str:
    """A place of a path by its time, else by its row: "at 1.2 s", "between rows 3 and 4"."""
    if place.time is not None:
        return f"at {place.time:.4g} s"
    near = min(place.share, 1.0 - place.share) < _AT_ROW
    if near:
        return f"at row {round(place.position)}"
    return f"between rows {place.row} and {place.row + 1}"


def row_words(place: Any) -> str:
    """A row, with two digits of the share of the way to the next."""
    return f"{round(place.position, 2):.12g}"


def interval_words(start: Any, end: Any) -> str:
    """Two places of a path: "between 1.2 and 1.8 s"."""
    if start.time is not None and end.time is not None:
        return f"between {start.time:.5g} and {end.time:.5g} s"
    return f"between rows {row_words(start)} and {row_words(end)}"


def turn_far_words(turn: Any) -> str:
    """A joint that turns far: "joint 4 turns 173° between 1.2 and 1.8 s"."""
    return f"joint {turn.joint} turns {short(abs(degrees(turn.angle)), 3)}° {interval_words(turn.start, turn.end)}"


def joint_heads(robot: Robot, *, deg: bool) -> tuple[str, ...]:
    """Headings of columns of joint values."""
    return tuple(f"{joint.name} [{'°' if deg and joint.unit == 'rad' else joint.unit}]" for joint in robot.variables)


def joint_cells(robot: Robot, q: Array, *, deg: bool) -> Iterator[str]:
    """Joint values (n,) as cells of a table."""
    for joint, value in zip(robot.variables, q.tolist(), strict=True):
        yield minus(f"{degrees(value):.2f}" if deg and joint.unit == "rad" else f"{value:.4f}")
