"""A joint trajectory from a CSV file, and what the monitor sees along it."""

from __future__ import annotations

import csv
import io
import re
from dataclasses import dataclass
from math import isfinite, radians
from pathlib import Path

import numpy as np

from rankdrop.errors import ConfigurationError, RankdropError
from rankdrop.families import Monitor
from rankdrop.robot import Array, Joint, Robot, quantity, read_text

MOST_ROWS = 1_000_000
ROW_SECONDS = 0.1  # between rows of a file without times
_TIME = re.compile(r"(time|t|stamp|timestamp|seconds?)\s*([\[(_]?\s*(s|sec|seconds)\s*[\])]?)?", re.IGNORECASE)
_UNIT = re.compile(r"(?P<name>.*?)\s*[\[(]\s*(?P<unit>rad|deg|°|m|mm)\s*[\])]", re.IGNORECASE)
_FACTORS = {"rad": 1.0, "deg": radians(1.0), "°": radians(1.0), "m": 1.0, "mm": 1e-3}
_ANGLES = {"rad", "deg", "°"}


class TrajectoryError(ConfigurationError):
    """A trajectory file that cannot be read: names file, line and column."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Joint values over time.

    Attributes:
        name: of the file.
        times: (T,) increasing [s]; 0.1 s apart where the file has none (`timed` is False).
        q: (T, n) [rad, m].
        timed: whether the file gives times.
        unused: columns of the file that name no joint.
    """

    name: str
    times: Array
    q: Array
    timed: bool
    unused: tuple[str, ...]

    def at(self, time: float) -> Array:
        """(n,) joint values at a time [s], straight between rows, held before the first and after the last."""
        return np.array([np.interp(time, self.times, column) for column in self.q.T])


@dataclass(frozen=True, eq=False)
class Track:
    """What the monitor sees along a trajectory.

    Attributes:
        times: (T,) [s].
        sigma: (T,) σ_r [1].
        distance: (T,) first-order distance to the singular set [rad].
        worst: index of the row with the smallest σ_r.
        singular: number of rows that are singular.
    """

    times: Array
    sigma: Array
    distance: Array
    worst: int
    singular: int


@dataclass(frozen=True, slots=True)
class _Column:
    """Where a joint's values stand, and what they are multiplied by."""

    place: int
    factor: float
    joint: Joint


def track_of(trajectory: Trajectory, monitor: Monitor) -> Track:
    """σ and distance at every row."""
    seen = monitor.look(trajectory.q)
    r = monitor.generic_rank
    sigma = seen.sigma[:, r - 1] if r else np.zeros(len(trajectory.q))
    return Track(trajectory.times, sigma, seen.distance, int(sigma.argmin()), int((seen.corank > 0).sum()))


def read_trajectory(path: str | Path, robot: Robot, *, deg: bool = False) -> Trajectory:
    """A trajectory from a CSV file.

    The first line names the columns: joints by name or as q1 … qn, one optional time column (time, t, stamp) [s];
    other columns are passed over. A unit may follow a name: "q2 [deg]", "slide [mm]". A file of numbers alone needs
    exactly one column for each joint. Columns are separated by commas, semicolons or tabs; lines that begin with #
    are comments.

    Args:
        path: the file.
        robot: whose joints they are.
        deg: angles without a unit are in degrees.

    Raises:
        TrajectoryError: with file, line and column.
    """
    name = str(path)
    try:
        text = read_text(Path(path))
    except RankdropError as error:
        raise TrajectoryError(error.what, where=error.where or name, got=error.got) from error
    return parse_trajectory(text, name, robot, deg=deg)


def parse_trajectory(text: str, name: str, robot: Robot, *, deg: bool = False) -> Trajectory:
    """As `read_trajectory`, from the text of a file; `name` stands in errors."""
    rows = _rows(text, name)
    if not rows:
        raise TrajectoryError("there is no row", where=name, mend="a line of names, then a row for each moment")
    line, head = rows[0]
    if all(_is_number(word) for word in head):
        if len(head) != robot.n:
            raise TrajectoryError(
                "the columns have no names", where=f"{name}, line {line}", got=f"{len(head)} numbers",
                allowed=f"{robot.n} numbers, one for each joint, or a first line of names: {_names(robot)}",
            )  # fmt: skip
        head = [joint.name for joint in robot.variables]
    else:
        rows = rows[1:]
    columns, time, unused = _columns(head, robot, f"{name}, line {line}", deg)
    if not rows:
        raise TrajectoryError("there is no row below the names", where=f"{name}, line {line}")
    if len(rows) > MOST_ROWS:
        raise TrajectoryError("there are too many rows", where=name, got=len(rows), allowed=f"at most {MOST_ROWS}")
    q: Array = np.array([[_value(row, column, name, number, head) for column in columns] for number, row in rows])
    times: Array = np.arange(len(rows), dtype=np.float64) * ROW_SECONDS
    if time is not None:
        times = np.array([_float(row, time, name, number, head) for number, row in rows])
        _check_times(times, [number for number, _ in rows], name, head[time])
    return Trajectory(Path(name).name, times, q, time is not None, unused)


def _rows(text: str, name: str) -> list[tuple[int, list[str]]]:
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
        match = _UNIT.fullmatch(word)
        name, unit = (match["name"], match["unit"].lower()) if match else (word, None)
        short = re.fullmatch(r"(?:q|θ|theta|joint|j)_?(\d+)", name, re.IGNORECASE)
        index = numbers.get(name, int(short[1]) - 1 if short else None)
        if index is not None and not 0 <= index < robot.n:
            raise TrajectoryError("there is no such joint", where=f"{where}, column {place + 1}", got=repr(word),
                                  allowed=_names(robot))  # fmt: skip
        if index is None:
            if time is None and _TIME.fullmatch(word):
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
                              allowed=_names(robot), mend=f"add {', '.join(missing)}")  # fmt: skip
    return [found[i] for i in range(robot.n)], time, tuple(unused)


def _factor(unit: str | None, joint: Joint, where: str, deg: bool) -> float:
    if unit is None:
        return radians(1.0) if deg and joint.unit == "rad" else 1.0
    if (unit in _ANGLES) != (joint.unit == "rad"):
        raise TrajectoryError("the unit does not fit the joint", where=f"{where}, joint {joint.name!r}", got=unit,
                              allowed="rad, deg" if joint.unit == "rad" else "m, mm")  # fmt: skip
    return _FACTORS[unit]


def _value(row: list[str], column: _Column, name: str, line: int, head: list[str]) -> float:
    return _float(row, column.place, name, line, head, column.joint.unit) * column.factor


def _float(row: list[str], place: int, name: str, line: int, head: list[str], unit: str = "") -> float:
    """One number; arithmetic with pi as on the command line is understood where it is none."""
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


def _check_times(times: Array, lines: list[int], name: str, column: str) -> None:
    back = np.flatnonzero(np.diff(times) <= 0)
    if len(back):
        i = int(back[0]) + 1
        raise TrajectoryError("time does not go on", where=f"{name}, line {lines[i]}, column {column!r}",
                              got=f"{times[i]:g} after {times[i - 1]:g}", allowed="times that increase")  # fmt: skip


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _names(robot: Robot) -> str:
    return ", ".join(joint.name for joint in robot.variables) + f" (or q1 … q{robot.n})"
