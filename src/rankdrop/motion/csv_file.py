"""A joint trajectory from a CSV file."""

from __future__ import annotations

import csv
import io
import re
import warnings
from contextlib import suppress
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
    table = plain_table(text)
    if table is not None:
        with suppress(TrajectoryError):  # the careful reader says in which line
            return _trajectory(name, robot, [*table[0]], [], table[1], deg=deg)
    rows = rows_of(text, name)
    return _trajectory(name, robot, rows[0][1] if rows else [], rows, None, deg=deg)


def plain_table(text: str) -> tuple[list[str], Array] | None:
    """Words of the first row and all numbers of a file that has names, then plain numbers in every row, or these alone.

    None: there is anything else in it, and it is read row by row.
    """
    head, _, body = text.partition("\n")
    delimiter = _delimiter(head)
    if '"' in text or "#" in text or not head.strip():
        return None
    words = [word.strip() for word in head.split(delimiter)]
    numbers = all(map(is_number, words))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # an empty file
            values = np.loadtxt(io.StringIO(text if numbers else body), delimiter=delimiter, comments=None, ndmin=2)
    except (ValueError, UserWarning):
        return None
    return (words, values) if values.shape[1] == len(words) and np.isfinite(values).all() else None


def _trajectory(
    name: str, robot: Robot, head: list[str], rows: list[tuple[int, list[str]]], values: Array | None, *, deg: bool
) -> Trajectory:
    """From the first row, and either all rows or, where they are plain, all values."""
    if not head:
        raise TrajectoryError("there is no row", where=name, mend="a line of names, then a row for each moment")
    line = rows[0][0] if rows else 1
    if all(is_number(word) for word in head):
        names = [joint.name for joint in robot.variables]
        first = _column(rows, 0) if values is None else values[:, 0]
        if len(head) == robot.n + 1 and len(first) > 1 and bool((np.diff(first) > 0).all()):
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
    count = len(rows) if values is None else len(values)
    if not count:
        raise TrajectoryError("there is no row below the names", where=f"{name}, line {line}")
    if count > MOST_ROWS:
        raise TrajectoryError("there are too many rows", where=name, got=count, allowed=f"at most {MOST_ROWS}")
    _check_lengths(rows, name, len(head))
    places = [place for place, _ in columns]
    units = [joint.unit for joint in robot.variables]
    q = _block(rows, places, name, head, units) if values is None else values[:, places]
    made = q * np.array([factor for _, factor in columns])
    for row, joint in too_large(made, robot)[:1]:
        place, words = places[joint], rows[row] if rows else (0, [])
        raise TrajectoryError(
            "the value is too large", where=f"{name}, line {words[0]}, column {place + 1} ({head[place]})",
            got=words[1][place] if rows else None, allowed=joint_range(robot.variables[joint]),
        )  # fmt: skip
    times: Array = np.arange(count, dtype=np.float64) * ROW_SECONDS
    if time is not None:
        times = (_block(rows, [time], name, head, [""]) if values is None else values[:, [time]])[:, 0]
        where = [f"{name}, line {number}, column {head[time]!r}" for number, _ in rows]
        checked_times(times, where or [name] * count)
    return Trajectory(Path(name).name, times, made, time is not None, unused)


def _column(rows: list[tuple[int, list[str]]], place: int) -> Array:
    """(T,) numbers of a column; nan where a word is none."""
    return np.array([float(row[place]) if is_number(row[place]) else np.nan for _, row in rows])


def _check_lengths(rows: list[tuple[int, list[str]]], name: str, columns: int) -> None:
    for number, row in rows:
        if len(row) > columns and any(row[columns:]):
            raise TrajectoryError("the row is too long", where=f"{name}, line {number}", got=f"{len(row)} columns",
                                  allowed=columns)  # fmt: skip


def _block(rows: list[tuple[int, list[str]]], places: list[int], name: str, head: list[str], units: list[str]) -> Array:
    """(T, len(places)) numbers, word by word."""
    both = list(zip(places, units, strict=True))
    return np.array([[number_at(row, place, name, number, head, unit) for place, unit in both] for number, row in rows])


def first_row(text: str, name: str) -> list[str]:
    """Words of the first row that is neither empty nor a comment; empty where there is none."""
    first = next((line for line in io.StringIO(text) if line.strip() and not line.lstrip().startswith("#")), "")
    rows = rows_of(first, name)
    return rows[0][1] if rows else []


def _delimiter(line: str) -> str:
    return max(",;\t", key=line.count)


def rows_of(text: str, name: str) -> list[tuple[int, list[str]]]:
    """Line number and words of every row that is not empty or a comment."""
    first = next((line for line in io.StringIO(text) if line.strip() and not line.lstrip().startswith("#")), "")
    reader = csv.reader(io.StringIO(text), delimiter=_delimiter(first), skipinitialspace=True)
    rows = []
    try:
        for words in reader:
            if any(word.strip() for word in words) and not words[0].lstrip().startswith("#"):
                rows.append((reader.line_num, [word.strip() for word in words]))
    except csv.Error as error:
        raise TrajectoryError(f"this is not CSV: {error}", where=f"{name}, line {reader.line_num}") from None
    return rows


def _columns(head: list[str], robot: Robot, where: str, deg: bool) -> tuple[
    list[tuple[int, float]], int | None, tuple[str, ...]
]:
    """Places and factors of the joints in their order, the column of the time, and the names of the others."""
    numbers = {joint.name: i for i, joint in enumerate(robot.variables)}
    found: dict[int, tuple[int, float]] = {}
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
        found[index] = place, _factor(unit, robot.variables[index], f"{where}, column {place + 1}", deg)
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
