"""A joint trajectory from a CSV file."""

from __future__ import annotations

import csv
import io
import re
from dataclasses import dataclass
from math import isfinite, radians
from pathlib import Path

import numpy as np

from rankdrop.errors import RankdropError
from rankdrop.motion.trajectory import (
    ROW_SECONDS,
    Trajectory,
    TrajectoryError,
    checked_times,
    joint_names,
    joint_range,
    too_large,
)
from rankdrop.robot.files import LONGEST_HEAD, MOST_ROWS
from rankdrop.robot.model import Array, Joint, Robot
from rankdrop.robot.quantities import quantity

TIME = re.compile(r"(time|t|stamp|timestamp|seconds?)\s*([\[(_]?\s*(s|sec|seconds)\s*[\])]?)?", re.IGNORECASE)
UNIT = re.compile(r"(?P<name>.*?)\s*[\[(]\s*(?P<unit>rad|deg|°|m|mm)\s*[\])]", re.IGNORECASE)
FACTORS = {"rad": 1.0, "deg": radians(1.0), "°": radians(1.0), "m": 1.0, "mm": 1e-3}
ANGLES = {"rad", "deg", "°"}


@dataclass(frozen=True, slots=True)
class _Column:
    """Where a joint's values stand, and what they are multiplied by."""

    place: int
    factor: float
    joint: Joint


def parse_trajectory(text: str, name: str, robot: Robot, *, deg: bool = False) -> Trajectory:
    """A trajectory from the text of a CSV file.

    The first line names the columns: joints by name or as q1 … qn, one optional time column (time, t, stamp) [s];
    other columns are passed over. A unit may follow a name: "q2 [deg]", "slide [mm]". A file of numbers alone needs
    one column for each joint; one column more, in front and increasing, is the time. Columns are separated by commas,
    semicolons or tabs; lines that begin with # are comments.

    Args:
        text: of the file.
        name: of the file, for errors.
        robot: whose joints they are.
        deg: angles without a unit are in degrees.

    Raises:
        TrajectoryError: with file, line and column.
    """
    rows = rows_of(text, name)
    if not rows:
        raise TrajectoryError("there is no row", where=name, mend="a line of names, then a row for each moment")
    line, head = rows[0]
    if all(is_number(word) for word in head):
        names = [joint.name for joint in robot.variables]
        if len(head) == robot.n + 1 and _rises(rows):
            names = ["time", *names]
        if len(head) != len(names):
            raise TrajectoryError(
                "the columns have no names", where=f"{name}, line {line}", got=f"{len(head)} numbers",
                allowed=f"{robot.n} numbers, one for each joint, a rising time in front of them, or a first line of "
                f"names: {joint_names(robot)}",
            )  # fmt: skip
        head = names
    else:
        rows = rows[1:]
    columns, time, unused = _columns(head, robot, f"{name}, line {line}", deg)
    if not rows:
        raise TrajectoryError("there is no row below the names", where=f"{name}, line {line}")
    if len(rows) > MOST_ROWS:
        raise TrajectoryError("there are too many rows", where=name, got=len(rows), allowed=f"at most {MOST_ROWS}")
    _check_lengths(rows, name, len(head))
    q = _block(rows, [column.place for column in columns], name, head, [column.joint.unit for column in columns])
    made = q * np.array([column.factor for column in columns])
    for row, joint in too_large(made, robot)[:1]:
        place = columns[joint].place
        raise TrajectoryError(
            "the value is too large", where=f"{name}, line {rows[row][0]}, column {place + 1} ({head[place]})",
            got=rows[row][1][place], allowed=joint_range(robot.variables[joint]),
        )  # fmt: skip
    times: Array = np.arange(len(rows), dtype=np.float64) * ROW_SECONDS
    if time is not None:
        times = _block(rows, [time], name, head, [""])[:, 0]
        checked_times(times, [f"{name}, line {number}, column {head[time]!r}" for number, _ in rows])
    return Trajectory(Path(name).name, times, made, time is not None, unused)


def _rises(rows: list[tuple[int, list[str]]]) -> bool:
    """Whether the first column grows from row to row."""
    try:
        first = np.array([float(row[0]) for _, row in rows])
    except (ValueError, IndexError):
        return False
    return len(first) > 1 and bool((np.diff(first) > 0).all())


def _check_lengths(rows: list[tuple[int, list[str]]], name: str, columns: int) -> None:
    for number, row in rows:
        if len(row) > columns and any(row[columns:]):
            raise TrajectoryError("the row is too long", where=f"{name}, line {number}", got=f"{len(row)} columns",
                                  allowed=columns)  # fmt: skip


def _block(rows: list[tuple[int, list[str]]], places: list[int], name: str, head: list[str], units: list[str]) -> Array:
    """(T, len(places)) numbers: all at once where every word is a plain one, else word by word."""
    try:
        values = np.array([[row[place] for place in places] for _, row in rows]).astype(np.float64)
    except (ValueError, IndexError):
        values = np.full((1, 1), np.nan)
    if np.isfinite(values).all():
        return values
    both = list(zip(places, units, strict=True))
    return np.array([[number_at(row, place, name, number, head, unit) for place, unit in both] for number, row in rows])


def rows_of(text: str, name: str) -> list[tuple[int, list[str]]]:
    """Line number and words of every row that is not empty or a comment."""
    first = next((line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")), "")
    delimiter = max(",;\t", key=first.count)
    reader = csv.reader(io.StringIO(text), delimiter=delimiter, skipinitialspace=True)
    rows = []
    try:
        for words in reader:
            if any(word.strip() for word in words) and not words[0].lstrip().startswith("#"):
                rows.append((reader.line_num, [word.strip() for word in words]))
    except csv.Error as error:
        raise TrajectoryError(f"this is not CSV: {error}", where=f"{name}, line {reader.line_num}") from None
    return rows


def _columns(head: list[str], robot: Robot, where: str, deg: bool) -> tuple[list[_Column], int | None, tuple[str, ...]]:
    """Columns of the joints in their order, the column of the time, and the names of the others."""
    numbers = {joint.name: i for i, joint in enumerate(robot.variables)}
    found: dict[int, _Column] = {}
    time, unused = None, []
    for place, word in enumerate(head):
        if len(word) > LONGEST_HEAD:
            raise TrajectoryError("the name of the column is too long", where=f"{where}, column {place + 1}",
                                  got=f"{len(word)} characters", allowed=f"at most {LONGEST_HEAD}")  # fmt: skip
        match = UNIT.fullmatch(word)
        name, unit = (match["name"], match["unit"].lower()) if match else (word, None)
        short = re.fullmatch(r"(?:q|θ|theta|joint|j)_?(\d+)", name, re.IGNORECASE)
        index = numbers.get(name, int(short[1]) - 1 if short else None)
        if index is not None and not 0 <= index < robot.n:
            raise TrajectoryError("there is no such joint", where=f"{where}, column {place + 1}", got=repr(word),
                                  allowed=joint_names(robot))  # fmt: skip
        if index is None:
            if time is None and TIME.fullmatch(word):
                time = place
            else:
                unused.append(word)
            continue
        if index in found:
            raise TrajectoryError("the joint has two columns", where=f"{where}, column {place + 1}", got=repr(word),
                                  allowed="one column for each joint")  # fmt: skip
        found[index] = _Column(place, _factor(unit, robot.variables[index], f"{where}, column {place + 1}", deg),
                               robot.variables[index])  # fmt: skip
    missing = [joint.name for i, joint in enumerate(robot.variables) if i not in found]
    if missing:
        raise TrajectoryError("joints have no column", where=where, got=", ".join(head),
                              allowed=joint_names(robot), mend=f"add {', '.join(missing)}")  # fmt: skip
    return [found[i] for i in range(robot.n)], time, tuple(unused)


def _factor(unit: str | None, joint: Joint, where: str, deg: bool) -> float:
    if unit is None:
        return radians(1.0) if deg and joint.unit == "rad" else 1.0
    if (unit in ANGLES) != (joint.unit == "rad"):
        raise TrajectoryError("the unit does not fit the joint", where=f"{where}, joint {joint.name!r}", got=unit,
                              allowed="rad, deg" if joint.unit == "rad" else "m, mm")  # fmt: skip
    return FACTORS[unit]


def number_at(row: list[str], place: int, name: str, line: int, head: list[str], unit: str = "") -> float:
    """One number of a row; arithmetic with pi as on the command line is understood where it is none.

    Raises:
        TrajectoryError: the row is too short, it is no number, or not finite.
    """
    label = f" ({head[place]})" if place < len(head) else ""
    where = f"{name}, line {line}, column {place + 1}{label}"
    if place >= len(row):
        raise TrajectoryError("the row is too short", where=where, got=f"{len(row)} columns", allowed=len(head))
    try:
        value = float(row[place])
    except ValueError:
        try:
            value = quantity(row[place], "number", where=where)
        except RankdropError:
            raise TrajectoryError(
                "this is no number", where=where, got=repr(row[place]), allowed=unit or None
            ) from None
    if not isfinite(value):
        raise TrajectoryError("the value is not finite", where=where, got=row[place])
    return value


def is_number(word: str) -> bool:
    """Whether a word is a plain number, nan and inf among them."""
    try:
        float(word)
    except ValueError:
        return False
    return True
