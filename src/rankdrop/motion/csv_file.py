"""Tables of numbers in text (CSV), and a joint trajectory from one."""

from __future__ import annotations

import csv
import io
import re
import warnings
from collections.abc import Callable, Hashable, Sequence
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
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.quantities import quantity

_TIME = re.compile(r"(time|t|stamp|timestamp|seconds?)\s*([\[(_]?\s*(s|sec|seconds)\s*[\])]?)?", re.IGNORECASE)
_WITH_UNIT = re.compile(r"(?P<name>.*?)\s*[\[(]\s*(?P<unit>rad|deg|°|m|mm)\s*[\])]", re.IGNORECASE)
_JOINT = re.compile(r"(?:q|θ|theta|joint|j)_?(\d+)", re.IGNORECASE)
UNITS = {"angle": {"rad": 1.0, "deg": radians(1.0), "°": radians(1.0)}, "length": {"m": 1.0, "mm": 1e-3}, "number": {}}
Known = Callable[[str], tuple[Hashable, str] | None]
"""Name of a column -> what it is, and its measure (angle, length or number); None for a column that is not used."""


@dataclass(eq=False)
class Table:
    """Rows of words below their names.

    Attributes:
        name: of the file.
        head: names of the columns; numbers where the file has no names.
        line: of the names.
        lines: (T,) of the rows.
        rows: their words; None where all of them are plain numbers.
        values: (T, columns) these.
    """

    name: str
    head: list[str]
    line: int
    lines: Sequence[int]
    rows: list[list[str]] | None
    values: Array | None

    @property
    def where(self) -> str:
        """The line of the names, for errors."""
        return f"{self.name}, line {self.line}"

    def places(self) -> list[str]:
        """Where each row is, for errors."""
        return [f"{self.name}, line {line}" for line in self.lines]

    def block(self, columns: Sequence[int]) -> Array:
        """(T, k) numbers of some columns; arithmetic with pi is understood as on the command line.

        Raises:
            TrajectoryError: a row is too short or too long, or a word is no finite number.
        """
        if self.values is not None:
            return self.values[:, columns]
        assert self.rows is not None
        for line, row in zip(self.lines, self.rows, strict=True):
            if any(row[len(self.head) :]):
                raise TrajectoryError("the row is too long", where=f"{self.name}, line {line}",
                                      got=f"{len(row)} columns", allowed=len(self.head))  # fmt: skip
        return np.array([[self._number(row, column, line) for column in columns]
                         for line, row in zip(self.lines, self.rows, strict=True)])  # fmt: skip

    def _number(self, row: list[str], column: int, line: int) -> float:
        where = f"{self.name}, line {line}, column {column + 1} ({self.head[column]})"
        if column >= len(row):
            raise TrajectoryError("the row is too short", where=where, got=f"{len(row)} columns",
                                  allowed=len(self.head))  # fmt: skip
        try:
            value = float(row[column]) if is_number(row[column]) else quantity(row[column], "number", where=where)
        except RankdropError:
            raise TrajectoryError("this is no number", where=where, got=repr(row[column])) from None
        if not isfinite(value):
            raise TrajectoryError("the value is not finite", where=where, got=row[column])
        return value

    def times(self, column: int | None) -> Array | None:
        """(T,) increasing times [s]; None without a column of them."""
        if column is None:
            return None
        return checked_times(self.block([column])[:, 0],
                             [f"{place}, column {self.head[column]!r}" for place in self.places()])  # fmt: skip


def read_table(text: str, name: str) -> Table:
    """A table from text: columns separated by commas, semicolons or tabs; lines that begin with # are comments.

    Raises:
        TrajectoryError: this is not CSV, or there is no row, no row below the names, or too many.
    """
    table = _plain_table(text, name) or _word_table(text, name)
    if not table.head:
        raise TrajectoryError("there is no row", where=name, mend="a line of names, then a row for each moment")
    if not len(table.lines):
        raise TrajectoryError("there is no row below the names", where=table.where)
    if len(table.lines) > MOST_ROWS:
        raise TrajectoryError("there are too many rows", where=name, got=len(table.lines),
                              allowed=f"at most {MOST_ROWS}")  # fmt: skip
    return table


def _plain_table(text: str, name: str) -> Table | None:
    """A file of names or none, and plain numbers alone, read by NumPy; None: there is anything else in it."""
    first, _, body = text.partition("\n")
    if '"' in text or "#" in text or not first.strip():
        return None
    head = [word.strip() for word in first.split(_delimiter(first))]
    numbers = all(map(is_number, head))
    body = text if numbers else body
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # an empty file
            values = np.loadtxt(io.StringIO(body), delimiter=_delimiter(first), comments=None, ndmin=2)
    except (ValueError, UserWarning):
        return None
    whole = len(values) == body.rstrip("\n").count("\n") + 1  # no empty line
    if not whole or values.shape[1] != len(head) or not np.isfinite(values).all():
        return None
    start = 1 if numbers else 2
    return Table(name, head, 1, range(start, start + len(values)), None, values)


def _word_table(text: str, name: str) -> Table:
    """Word by word, so that errors name the line."""
    reader = csv.reader(io.StringIO(text), delimiter=_delimiter(_first_line(text)), skipinitialspace=True)
    lines, rows = [], []
    try:
        for words in reader:
            if any(word.strip() for word in words) and not words[0].lstrip().startswith("#"):
                lines.append(reader.line_num)
                rows.append([word.strip() for word in words])
    except csv.Error as error:
        raise TrajectoryError(f"this is not CSV: {error}", where=f"{name}, line {reader.line_num}") from None
    head, line = (rows[0], lines[0]) if rows else ([], 1)
    named = not all(map(is_number, head))
    return Table(name, head, line, lines[named:], rows[named:], None)


def _first_line(text: str) -> str:
    return next((line for line in io.StringIO(text) if line.strip() and not line.lstrip().startswith("#")), "")


def names_of(text: str) -> list[str]:
    """Words of the first row."""
    line = _first_line(text)
    return [word.strip() for word in next(csv.reader([line], delimiter=_delimiter(line), skipinitialspace=True), [])]


def _delimiter(line: str) -> str:
    return max(",;\t", key=line.count)


def is_number(word: str) -> bool:
    """Whether a word is a plain number, nan and inf among them."""
    try:
        float(word)
    except ValueError:
        return False
    return True


def name_and_unit(word: str) -> tuple[str, str | None]:
    """The name of a column, and the unit behind it: "q2 [deg]"."""
    match = _WITH_UNIT.fullmatch(word)
    return (match["name"].strip(), match["unit"].lower()) if match else (word, None)


def find_columns(
    head: list[str], where: str, known: Known, *, deg: bool
) -> tuple[dict[Hashable, tuple[int, float]], int | None, tuple[str, ...]]:
    """Place and factor (to rad and m) of each column that is known, the column of the time, and names of the others.

    Raises:
        TrajectoryError: a column is there twice, its name too long, or its unit does not fit.
    """
    found: dict[Hashable, tuple[int, float]] = {}
    time, unused = None, []
    for place, word in enumerate(head):
        here = f"{where}, column {place + 1}"
        if len(word) > LONGEST_HEAD:
            raise TrajectoryError("the name of the column is too long", where=here, got=f"{len(word)} characters",
                                  allowed=f"at most {LONGEST_HEAD}")  # fmt: skip
        name, unit = name_and_unit(word)
        column = known(name)
        if column is None:
            if time is None and _TIME.fullmatch(word):
                time = place
            else:
                unused.append(word)
            continue
        key, measure = column
        if key in found:
            raise TrajectoryError("the column is there twice", where=here, got=repr(word))
        fits = UNITS[measure]
        if unit is not None and unit not in fits:
            raise TrajectoryError("the unit does not fit the column", where=here, got=word,
                                  allowed=", ".join(fits) or "none")  # fmt: skip
        plain = radians(1.0) if deg and measure == "angle" else 1.0
        found[key] = place, plain if unit is None else fits[unit]
    return found, time, tuple(unused)


def parse_trajectory(text: str, name: str, robot: Robot, *, deg: bool = False) -> Trajectory:
    """A trajectory from the text of a CSV file.

    The first line names the columns: joints by name or as q1 … qn, one optional time column (time, t, stamp) [s];
    other columns are ignored. A unit may follow a name: "q2 [deg]", "slide [mm]". A file of numbers alone needs one
    column for each joint; one column more, in front and increasing, is the time.

    Args:
        text: of the file.
        name: of the file, for errors.
        robot: whose joints they are.
        deg: angles without a unit are in degrees.

    Raises:
        TrajectoryError: with file, line and column.
    """
    table = read_table(text, name)
    if all(map(is_number, table.head)):
        table.head = _names_of_numbers(table, robot)
    numbers = {joint.name: i for i, joint in enumerate(robot.variables)}

    def known(word: str) -> tuple[int, str] | None:
        short = _JOINT.fullmatch(word)
        index = numbers.get(word, int(short[1]) - 1 if short else None)
        if index is not None and not 0 <= index < robot.n:
            place = [name_and_unit(one)[0] for one in table.head].index(word)
            raise TrajectoryError("there is no such joint", where=f"{table.where}, column {place + 1}", got=repr(word),
                                  allowed=joint_names(robot))  # fmt: skip
        return None if index is None else (index, "angle" if robot.variables[index].unit == "rad" else "length")

    columns, time, unused = find_columns(table.head, table.where, known, deg=deg)
    missing = [joint.name for i, joint in enumerate(robot.variables) if i not in columns]
    if missing:
        raise TrajectoryError("joints have no column", where=table.where, got=", ".join(table.head),
                              allowed=joint_names(robot), mend=f"add {', '.join(missing)}")  # fmt: skip
    places, factors = zip(*(columns[i] for i in range(robot.n)), strict=True)
    written = table.block(places)
    q = written * np.array(factors)
    for row, joint in too_large(q, robot)[:1]:
        place = places[joint]
        raise TrajectoryError(
            "the value is too large", got=f"{written[row, joint]:g}", allowed=joint_range(robot.variables[joint]),
            where=f"{table.places()[row]}, column {place + 1} ({table.head[place]})",
        )  # fmt: skip
    times = table.times(time)
    regular: Array = np.arange(len(q), dtype=np.float64) * ROW_SECONDS
    return Trajectory(Path(name).name, regular if times is None else times, q, times is not None, unused)


def _names_of_numbers(table: Table, robot: Robot) -> list[str]:
    """Names for columns that have none: the joints in order, a rising time in front of them if there is one more."""
    names = [joint.name for joint in robot.variables]
    if len(table.head) == robot.n + 1 and len(table.lines) > 1 and (np.diff(table.block([0])[:, 0]) > 0).all():
        return ["time", *names]
    if len(table.head) != robot.n:
        raise TrajectoryError(
            "the columns have no names", where=table.where, got=f"{len(table.head)} numbers",
            allowed=f"{robot.n} numbers, one for each joint, a rising time in front of them, or a first line of names: "
            f"{joint_names(robot)}",
        )  # fmt: skip
    return names
