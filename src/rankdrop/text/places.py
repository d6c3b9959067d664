"""Places of a path, joint values, how far joints turn and how fast, in words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import degrees, isfinite
from typing import Any

from rankdrop.robot.model import Array, Robot
from rankdrop.text.joint_values import fixed_point
from rankdrop.text.words import short

_NAMED = 3  # joints above their rate limits that are described
_LARGE = 999.5  # an amount that is printed with commas, from here on
_AT_ROW = 1e-6  # share of the way between two rows that is reported as the row


def seconds(time: float, digits: int = 4) -> str:
    """A time of a path, rounded to nanoseconds."""
    return f"{round(time, 9) + 0.0:.{digits}g}"


def when(place: Any) -> str:
    """A place of a path by its time, else by its pose or row: "at 1.2 s", "at pose 1.5", "between rows 3 and 4"."""
    if place.time is not None:
        return f"at {seconds(place.time)} s"
    if place.pose is not None:
        return f"at pose {place.pose:.5g}"
    near = min(place.share, 1.0 - place.share) < _AT_ROW
    if near:
        return f"at row {round(place.position)}"
    return f"between rows {place.row} and {place.row + 1}"


def row_words(place: Any) -> str:
    """A row, with two digits of the share of the way to the next; of a tool path a pose, with four."""
    if place.pose is not None:
        return f"{round(place.pose, 4):.12g}"
    return f"{round(place.position, 2):.12g}"


def row_noun(place: Any) -> str:
    """What `row_words` numbers: "row" or "pose"."""
    if place.pose is not None:
        return "pose"
    return "row"


def place_text(place: Any) -> str:
    """A place by its time, else by its pose or row: "1.25 s", "pose 3.5", "row 4.5"."""
    if place.time is not None:
        return f"{seconds(place.time)} s"
    return f"{row_noun(place)} {row_words(place)}"


def interval_words(start: Any, end: Any) -> str:
    """Two places of a path: "between 1.2 and 1.8 s"."""
    if start.time is not None and end.time is not None:
        return f"between {seconds(start.time, 5)} and {seconds(end.time, 5)} s"
    if row_words(start) == row_words(end):
        return f"at {row_noun(start)} {row_words(start)}"
    return f"between {row_noun(start)}s {row_words(start)} and {row_words(end)}"


def turn_far_words(turn: Any) -> str:
    """A joint that turns far: "joint 4 turns 173° between 1.2 and 1.8 s"."""
    return f"joint {turn.joint} turns {short(abs(degrees(turn.angle)), 3)}° {interval_words(turn.start, turn.end)}"


def joints_words(robot: Robot, q: Array, *, deg: bool) -> str:
    """Joint values by name, with units."""
    parts = []
    for joint, value in zip(robot.variables, q, strict=True):
        turns = joint.unit == "rad"
        if deg and turns:
            shown = degrees(float(value))
        else:
            shown = float(value)
        unit = ("°" if deg else " rad") if turns else " m"
        parts.append(f"{joint.name} {short(round(shown, 4 if not turns or not deg else 3) + 0.0, 6)}{unit}")
    return ", ".join(parts)


def joint_heads(robot: Robot, *, deg: bool) -> tuple[str, ...]:
    """Headings of columns of joint values."""
    return tuple(f"{joint.name} [{'°' if deg and joint.unit == 'rad' else joint.unit}]" for joint in robot.variables)


def joint_cells(robot: Robot, q: Array, *, deg: bool) -> Iterator[str]:
    """Joint values (n,) as cells of a table."""
    for joint, value in zip(robot.variables, q.tolist(), strict=True):
        if deg and joint.unit == "rad":
            yield fixed_point(degrees(value), 2)
        else:
            yield fixed_point(value)


def overrun_words(overruns: Sequence[Any], robot: Robot, *, where: bool = True) -> str:
    """Joints above their rate limits: "joint 4 needs up to 5,250°/s (limit 381°/s): above it for 0.079 s …".

    Args:
        overruns: of a path or of a move, the worst first.
        robot: the arm.
        where: name the times between which a joint is above its limit.
    """
    words = [_one_overrun(overrun, robot, where=where) for overrun in overruns[:_NAMED]]
    if len(overruns) > _NAMED:
        words.append(f"and {len(overruns) - _NAMED} more joints")
    return "; ".join(words)


def _one_overrun(overrun: Any, robot: Robot, *, where: bool) -> str:
    """One joint above its limit: its rate, how long it is above it, and how far it moves meanwhile."""
    unit = robot.variables[overrun.joint - 1].unit
    between = ""
    if where:
        between = f", {interval_words(overrun.start, overrun.end)}"
    return (
        f"joint {overrun.joint} needs up to {_rate(overrun.rate, unit)} (limit {_rate(overrun.limit, unit)}): above it "
        f"for {short(overrun.seconds, 2)} s{between}, while it {_moves(unit)} {_amount(overrun.travel, unit)}"
    )


def fastest_words(fastest: Any, robot: Robot) -> str:
    """The joint that comes nearest to its rate limit: "joint 4 turns at up to 66°/s, 37 % of its limit, at 1 s"."""
    unit = robot.variables[fastest.joint - 1].unit
    if isfinite(fastest.limit):
        limit = f"{short(100.0 * fastest.rate / fastest.limit, 2)} % of its limit"
    else:
        limit = "no limit is known"
    return f"joint {fastest.joint} {_moves(unit)} at up to {_rate(fastest.rate, unit)}, {limit}, {when(fastest.place)}"


def _rate(rate: float, unit: str) -> str:
    """A rate: "360°/s", "0.25 m/s"."""
    return f"{_amount(rate, unit)}/s"


def _moves(unit: str) -> str:
    """The verb of a joint: it turns, or moves along its axis."""
    if unit == "rad":
        return "turns"
    return "moves"


def _amount(value: float, unit: str) -> str:
    """An angle in degrees, or a length."""
    size, sign = value, f" {unit}"
    if unit == "rad":
        size, sign = degrees(value), "°"
    if size >= _LARGE:
        return f"{float(f'{size:.3g}'):,.0f}{sign}"
    return f"{short(size, 3)}{sign}"
