"""Tables of numbers as text (CSV): their columns with units, and the trajectory that a table holds."""

from __future__ import annotations

import csv
import io
import re
import warnings
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from math import isfinite, radians
from pathlib import Path

import numpy as np

from rankdrop import _core
from rankdrop.errors import RankdropError
from rankdrop.path.read.joint_columns import OtherNames, notes_on, other_names
from rankdrop.path.read.program_signs import refuse_program_text
from rankdrop.path.read.trajectory import (
    Trajectory,
    TrajectoryError,
    check_times,
    check_values,
    increasing,
    joint_names,
    regular_times,
)
from rankdrop.robot.files import LONGEST_HEAD, MOST_ROWS
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.quantities import quantity
from rankdrop.text.path_files import DECIMAL_COMMAS, MATRIX_HEAD, QUATERNION_HEAD, SAVED_WITH_COMMAS

_TIME = re.compile(r"(time|zeit|t|stamp|timestamp|seconds?)\s*+([\[(_]?\s*+(s|sec|seconds)\s*+[\])]?)?", re.IGNORECASE)
_FINE_TIME = re.compile(
    r"(?:time|zeit|t|stamp|timestamp)(?:_(?P<plain>ms|us|ns)|\s*[\[(]\s*(?P<unit>ms|us|µs|μs|ns)\s*[\])])",
    re.IGNORECASE,
)
_WITH_UNIT = re.compile(r"(?P<name>.*)[\[(]\s*+(?P<unit>rad|deg|°|rev|m|mm|cm|µm|um|in|inch)\s*+[\])]", re.IGNORECASE)
_UNIT_AFTER_UNDERSCORE = re.compile(r"(?P<name>.+)_(?P<unit>rad|deg|mm)", re.IGNORECASE)
_JOINT = re.compile(r"(?:q|θ|theta|joint|j|axis|achse|a)[_ ]?(\d+)", re.IGNORECASE)
_SEPARATORS = re.compile(r"[,;\t\"]")
_COMMA = re.compile(r"(\d),(\d)")
UNITS = {"angle": {"rad": 1.0, "deg": radians(1.0), "°": radians(1.0)}, "length": {"m": 1.0, "mm": 1e-3}, "number": {}}
PER_SECOND = {"ms": 1e3, "us": 1e6, "µs": 1e6, "μs": 1e6, "ns": 1e9}
Known = Callable[[str], tuple[Hashable, str] | None]
"""Name of a column -> what it is, and its measure (angle, length or number); None for a column that is not used."""

TABLES = (".csv", ".tsv", ".txt", ".dat", "")
"""Endings of files of plain numbers."""


def csv_text(names: Sequence[str], q: Array, times: Array | None = None) -> str:
    """Rows of joint values as CSV, to the last bit, with a column of times in front where there are any."""
    if times is None:
        head, rows = tuple(names), q
    else:
        head, rows = ("time", *names), np.column_stack([times, q])
    return "\n".join([",".join(head), *(",".join(map(repr, row)) for row in rows.tolist())]) + "\n"


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
        notes: what a reader should know of how the file was read.
    """

    name: str
    head: list[str]
    line: int
    lines: Sequence[int]
    rows: list[list[str]] | None
    values: Array | None
    notes: tuple[str, ...] = ()

    @property
    def head_place(self) -> str:
        """The line of the names, for errors."""
        return f"{self.name}, line {self.line}"

    def place(self, row: int) -> str:
        """Where a row is, counted from 0, for errors."""
        return f"{self.name}, line {self.lines[row]}"

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
            if is_number(row[column]):
                value = float(row[column])
            else:
                value = quantity(row[column], "number", where=where)
        except RankdropError:
            raise TrajectoryError("this is no number", where=where, got=repr(row[column])) from None
        if not isfinite(value):
            raise TrajectoryError("the value is not finite", where=where, got=row[column])
        return value

    def times(self, column: int | None) -> Array | None:
        """(T,) increasing times [s], of a column in the unit of its name; None without a column of them."""
        if column is None:
            return None
        seconds = self.block([column])[:, 0] / per_second(self.head[column])
        return check_times(seconds, lambda row: f"{self.place(row)}, column {self.head[column]!r}")


def read_table(text: str, name: str) -> Table:
    """A table from text: columns separated by commas, semicolons or tabs; lines that begin with # are comments.

    Raises:
        TrajectoryError: this is not CSV, or there is no row, no row below the names, or too many.
    """
    given = with_line_feeds(text)
    text = _with_decimal_points(given)
    table = _plain_table(text, name) or _word_table(text, name)
    if text is not given:
        table.notes = (DECIMAL_COMMAS,)
    _refuse_spaces(table)
    if not table.head:
        raise TrajectoryError("there is no row", where=name, mend="a line of names, then a row for each moment")
    if not len(table.lines):
        raise TrajectoryError("there is no row below the names", where=table.head_place)
    if len(table.lines) > MOST_ROWS:
        raise TrajectoryError("there are too many rows", where=name, got=len(table.lines),
                              allowed=f"at most {MOST_ROWS}")  # fmt: skip
    return table


def _refuse_spaces(table: Table) -> None:
    """Refuse numbers that spaces separate, as NumPy writes them by default.

    Raises:
        TrajectoryError: with the line.
    """
    first = [table.head, *(table.rows or [])[:1]]
    for line, words in zip((table.line, *table.lines[:1]), first, strict=False):
        numbers = "".join(words).split()
        if len(words) == 1 and len(numbers) > 1 and all(map(is_number, numbers)):
            raise TrajectoryError("the columns are separated by spaces", where=f"{table.name}, line {line}",
                                  got=f"{len(numbers)} numbers", allowed="commas, semicolons or tabs",
                                  mend=SAVED_WITH_COMMAS)  # fmt: skip


def _plain_table(text: str, name: str) -> Table | None:
    """A file of names or none, and plain numbers alone, read by NumPy; None: there is anything else in it."""
    first, _, body = text.partition("\n")
    if '"' in text or "#" in text or not first.strip():
        return None
    delimiter = delimiter_of(first)
    head = [word.strip() for word in first.split(delimiter)]
    named = not all(map(is_number, head))
    body = body if named else text
    values = _core.rows_of_text(body, delimiter, len(head))
    try:
        if values is None:
            with warnings.catch_warnings():
                warnings.simplefilter("error")  # an empty file
                values = np.loadtxt(io.StringIO(body), delimiter=delimiter, comments=None, ndmin=2)
    except (ValueError, UserWarning):
        return None
    lines = body.rstrip("\n").count("\n") + 1  # as many as rows where none is empty
    if values.shape != (lines, len(head)) or not np.isfinite(values).all():
        return None
    return Table(name, head, 1, range(1 + named, 1 + named + lines), None, values)


def _word_table(text: str, name: str) -> Table:
    """Word by word, so that errors name the line."""
    reader = csv.reader(io.StringIO(text), delimiter=delimiter_of(_first_line(text)), skipinitialspace=True)
    lines, rows = [], []
    try:
        for words in reader:
            if any(word.strip() for word in words) and not words[0].lstrip().startswith("#"):
                lines.append(reader.line_num)
                rows.append([word.strip() for word in words])
    except csv.Error as error:
        raise TrajectoryError(f"this is not CSV: {error}", where=f"{name}, line {reader.line_num}") from None
    if rows:
        head, line = (rows[0], lines[0])
    else:
        head, line = ([], 1)
    named = not all(map(is_number, head))
    return Table(name, head, line, lines[named:], rows[named:], None)


def _first_line(text: str) -> str:
    """The first line that is not empty and no comment; the rest of the text is not copied."""
    start = 0
    while start < len(text):
        end = text.find("\n", start)
        line = text[start : end if end >= 0 else None]
        if line.strip() and not line.lstrip().startswith("#"):
            return line
        start += len(line) + 1
    return ""


def with_line_feeds(text: str) -> str:
    """A text whose lines end as they do here: a carriage return ends a line too, as old spreadsheets write it."""
    if "\r" in text:
        return text.replace("\r\n", "\n").replace("\r", "\n")
    return text


def names_of(text: str, where: str) -> list[str]:
    """Words of the first row.

    Args:
        text: of the file.
        where: the file, for an error.

    Raises:
        TrajectoryError: the row is not CSV.
    """
    line = _first_line(with_line_feeds(text))
    try:
        words = next(csv.reader([line], delimiter=delimiter_of(line), skipinitialspace=True), [])
    except csv.Error as error:
        raise TrajectoryError(f"this is not CSV: {error}", where=f"{where}, the first line") from None
    return [word.strip() for word in words]


def delimiter_of(line: str) -> str:
    """What separates columns. Beside semicolons or tabs a cell may have one comma, that of its decimals."""
    for mark in ";\t":
        if mark in line and line.count(",") <= line.count(mark) + 1:
            return mark
    return max(",;\t", key=line.count)


def _with_decimal_points(text: str) -> str:
    """A text whose decimals are written with points, where they have commas and semicolons or tabs separate columns.

    It stays as it is where a point is in a row, too: 1.234,5 and 1,234.5 are then told apart by nobody.
    """
    first = _first_line(text)
    delimiter = delimiter_of(first)
    if delimiter == ",":
        return text
    words = [_COMMA.sub(r"\1.\2", word.strip()) for word in first.split(delimiter)]
    start = text.index(first) + (0 if all(map(is_number, words)) else len(first))
    rows = text[start:]
    if "," not in rows or "." in rows:
        return text
    return text[:start] + _COMMA.sub(r"\1.\2", rows)


def is_number(word: str) -> bool:
    """Whether a word is a plain number, nan and inf among them."""
    try:
        float(word)
    except ValueError:
        return False
    return True


def per_second(word: str) -> float:
    """How many units of a column of times are one second, by its name: 1000 of "time_ms", 1 without a unit.

    Example:
        >>> per_second("timestamp_ns"), per_second("t [ms]"), per_second("time")
        (1000000000.0, 1000.0, 1.0)
    """
    match = _FINE_TIME.fullmatch(word)
    if match is None:
        return 1.0
    unit = match["plain"] or match["unit"]
    return PER_SECOND[unit.lower()]


def name_and_unit(word: str) -> tuple[str, str | None]:
    """The name of a column, and the unit behind it: "q2 [deg]", "q2_deg"."""
    match = _WITH_UNIT.fullmatch(word) or _UNIT_AFTER_UNDERSCORE.fullmatch(word)
    if match:
        return (match["name"].strip(), match["unit"].lower())
    return (word, None)


def has_underscored_unit(word: str) -> bool:
    """Whether the name of a column ends with an underscore and a unit: "x_mm"."""
    return _UNIT_AFTER_UNDERSCORE.fullmatch(word) is not None


def gives_every_joint(head: list[str], robot: Robot) -> bool:
    """Whether every joint of an arm has a column, by its name or its number."""
    given = bare_names(head)
    if other_names(given, [joint.name for joint in robot.variables], "") is not None:
        return True
    numbers = {int(match[1]) for match in map(_JOINT.fullmatch, given) if match}
    return all(joint.name in given or i + 1 in numbers for i, joint in enumerate(robot.variables))


def bare_names(head: Iterable[str]) -> set[str]:
    """Names of columns, with their units and without."""
    return {name_and_unit(word)[0] for word in head} | set(head)


def find_columns(
    head: list[str], where: str, known: Known, *, deg: bool
) -> tuple[dict[Hashable, tuple[int, float]], int | None, tuple[str, ...]]:
    """Place and factor (to rad and m) of each column that is known, the column of the time, and names of the others.

    Raises:
        TrajectoryError: a column is given twice, its name too long, or its unit does not fit.
    """
    _refuse_long_names(head, where)
    named = [_named_column(word, known) for word in head]
    plain = {column.key for column in named if column is not None and not column.underscored}
    columns: dict[Hashable, tuple[int, float]] = {}
    others: list[int] = []
    for place, (word, column) in enumerate(zip(head, named, strict=True)):
        if column is None or (column.underscored and column.key in plain):
            others.append(place)
            continue
        column_place = f"{where}, column {place + 1}"
        if column.key in columns:
            raise TrajectoryError("the column is given twice", where=column_place, got=repr(word))
        columns[column.key] = place, _factor(word, column, column_place, deg=deg)
    time = _time_column(head, others)
    unused = [head[place] for place in others if place != time]
    return columns, time, tuple(filter(None, unused))  # a comma at the end of each line begins a column without name


def _refuse_long_names(head: list[str], where: str) -> None:
    """Refuse a name of a column that is longer than the reader takes.

    Raises:
        TrajectoryError: with the column.
    """
    for place, word in enumerate(head):
        if len(word) > LONGEST_HEAD:
            raise TrajectoryError("the name of the column is too long", where=f"{where}, column {place + 1}",
                                  got=f"{len(word)} characters", allowed=f"at most {LONGEST_HEAD}")  # fmt: skip


@dataclass(frozen=True)
class _NamedColumn:
    """What a column is, its measure, and the unit in its name; whether an underscore precedes that unit."""

    key: Hashable
    measure: str
    unit: str | None
    underscored: bool


def _named_column(word: str, known: Known) -> _NamedColumn | None:
    """What a column is by its whole name, or by its name without the unit; None where it is not known."""
    if _WITH_UNIT.fullmatch(word):
        name, unit = name_and_unit(word)
        column, underscored = known(name), False
    else:
        unit = None
        column, underscored = known(word), False
        if column is None:
            name, unit = name_and_unit(word)
            column, underscored = known(name), True
    if column is None:
        return None
    key, measure = column
    return _NamedColumn(key, measure, unit, underscored)


def _time_column(head: list[str], others: list[int]) -> int | None:
    """The first of these columns that holds seconds, else the first in a part of a second; None without one."""
    for form in (_TIME, _FINE_TIME):
        for place in others:
            if form.fullmatch(head[place]):
                return place
    return None


def _factor(word: str, column: _NamedColumn, where: str, *, deg: bool) -> float:
    """The factor of a column to rad or m, by the unit in its head; without one rad, or with `deg` degrees, and m.

    Raises:
        TrajectoryError: the unit does not fit.
    """
    unit = column.unit
    fits = UNITS[column.measure]
    if unit is None:
        return radians(1.0) if deg and column.measure == "angle" else 1.0
    if unit not in fits:
        raise TrajectoryError("the unit does not fit the column", where=where, got=word,
                              allowed=", ".join(fits) or "none")  # fmt: skip
    return fits[unit]


def parse_trajectory(text: str, name: str, robot: Robot, *, deg: bool = False) -> Trajectory:
    """A trajectory from the text of a CSV file.

    The first line names the columns: joints by name or as q1 … qn, one optional time column (time, t, stamp) [s];
    other columns are ignored. A unit may follow a name: "q2 [deg]", "slide_mm", "time_ms". A file of numbers alone
    needs one column for each joint; one column more, in front and increasing, is the time. Spaces may separate the
    columns, as numpy.savetxt writes them.

    Args:
        text: of the file.
        name: of the file, for errors.
        robot: whose joints they are.
        deg: angles without a unit are in degrees.

    Raises:
        TrajectoryError: with file, line and column.
    """
    refuse_program_text(text, name)
    table = read_table(with_commas(text), name)
    if all(map(is_number, table.head)):
        table.head = _names_of_numbers(table, robot)
    others = other_names(bare_names(table.head), [joint.name for joint in robot.variables], table.head_place)
    known = _joint_columns(table, robot, others)
    columns, time, unused = find_columns(table.head, table.head_place, known, deg=deg)
    missing = [joint.name for i, joint in enumerate(robot.variables) if i not in columns]
    if missing:
        _refuse_program(name, table)
        raise TrajectoryError("joints have no column", where=table.head_place, got=", ".join(table.head),
                              allowed=joint_names(robot), mend=f"add {', '.join(missing)}")  # fmt: skip
    places, factors = zip(*(columns[i] for i in range(robot.n)), strict=True)
    q = check_values(
        table.block(places), robot, factors=np.array(factors),
        place=lambda row, joint: f"{table.place(row)}, column {places[joint] + 1} ({table.head[places[joint]]})",
    )  # fmt: skip
    names = {joint.name for joint in robot.variables}
    stated = any(table.head[place] not in names and name_and_unit(table.head[place])[1] for place in places)
    times = table.times(time)
    return Trajectory(
        Path(name).name, regular_times(len(q)) if times is None else times, q, times is not None, unused,
        notes=(*table.notes, *notes_on(others)), bare=not stated,
    )  # fmt: skip


def with_commas(text: str) -> str:
    """A text with commas between its columns, where spaces separate numbers, or names without spaces above them."""
    given = with_line_feeds(text)
    first = _first_line(given)
    words = first.split()
    if len(words) < 2 or _SEPARATORS.search(first) is not None:
        return text
    if not all(map(is_number, words)) and not _numbers_below(given, first, len(words)):
        return text
    lines = ["" if line.lstrip().startswith("#") else line for line in given.split("\n")]
    if any(map(_SEPARATORS.search, lines)):
        return text
    return "\n".join(",".join(line.split()) for line in lines)


def _numbers_below(text: str, head: str, count: int) -> bool:
    """Whether the row below a line has as many numbers as that line has words."""
    row = _first_line(text[text.index(head) + len(head) :]).split()
    return len(row) == count and all(map(is_number, row))


def _refuse_program(name: str, table: Table) -> None:
    """Refuse a file that is no table by its ending, such as a program in a language without a reader.

    Raises:
        TrajectoryError: with the forms that its targets can be written in.
    """
    if Path(name).suffix.lower() in TABLES:
        return
    raise TrajectoryError(
        "this file is no table of joint values, and no program in a language that is read", where=table.head_place,
        got=", ".join(table.head), allowed="programs: .src, .mod, .modx, .script, .ls, .jbi; tables: .csv",
        mend="write its targets to a CSV file: columns q1, q2 … for joint values; x, y, z, roll, pitch, yaw for poses",
    )  # fmt: skip


def _joint_columns(table: Table, robot: Robot, others: OtherNames | None) -> Known:
    """A function that knows the columns of joints: by name or q1 … qn the joint, from 0, and what it measures."""
    numbers = {joint.name: i for i, joint in enumerate(robot.variables)}
    if others is not None:
        numbers |= {name: numbers[joint] for name, joint in others.joints.items()}

    def joint_of_name(word: str) -> tuple[int, str] | None:
        short = _JOINT.fullmatch(word)
        index = numbers.get(word, int(short[1]) - 1 if short else None)
        if index is None:
            return None
        if not 0 <= index < robot.n:
            place = [name_and_unit(head)[0] for head in table.head].index(word)
            where = f"{table.head_place}, column {place + 1}"
            raise TrajectoryError("there is no such joint", where=where, got=repr(word),
                                  allowed=joint_names(robot))  # fmt: skip
        return index, "angle" if robot.variables[index].unit == "rad" else "length"

    return joint_of_name


def _names_of_numbers(table: Table, robot: Robot) -> list[str]:
    """Names for columns that have none: the joints in order, a rising time in front of them if there is one more."""
    names = [joint.name for joint in robot.variables]
    if len(table.head) == robot.n + 1 and len(table.lines) > 1 and increasing(table.block([0])[:, 0]):
        return ["time", *names]
    if len(table.head) != robot.n:
        raise TrajectoryError(
            "the columns have no names", where=table.head_place, got=f"{len(table.head)} numbers",
            allowed=f"{robot.n} numbers, one for each joint, a rising time in front of them, or a first line of names: "
            f"{joint_names(robot)}", mend=_pose_head(len(table.head)),
        )  # fmt: skip
    return names


def _pose_head(columns: int) -> str:
    """What names columns of poses, where there are as many as matrices, or positions and quaternions, have."""
    if columns == 7:
        return QUATERNION_HEAD
    if columns in (12, 16):
        return MATRIX_HEAD.format(columns // 4 - 1)
    return ""
