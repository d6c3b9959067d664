"""An arm from a Denavit–Hartenberg table as it stands in code, in a paper or in a question.

`dh_rows` finds the rows. Here the convention and the units are settled: as the text states them, else as its numbers
show them beyond doubt; else the text is refused with the line to add. Entries are arithmetic of numbers and of names
that the text gives a value.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from math import inf

import numpy as np

from rankdrop.errors import RobotError
from rankdrop.robot.dh import CONVENTIONS, DHRow, from_dh
from rankdrop.robot.dh_rows import table_in
from rankdrop.robot.dh_units import LENGTHS, Unit, angle_unit, length_unit, unit_named
from rankdrop.robot.dh_written import WrittenRow, WrittenTable
from rankdrop.robot.joint_text import with_plain_constants
from rankdrop.robot.model import Array, JointKind, Robot, Source, check_joints
from rankdrop.robot.note import NoteOn, RobotNote
from rankdrop.robot.quantities import Angles, quantity
from rankdrop.robot.square_up import as_intended
from rankdrop.robot.transform import rotation, times, translation

_STANDARD = re.compile(r"\b(?:standard|std[_ ]?dh|sdh|classic(?:al)?|distal)\b|\bRevoluteDH\b", re.IGNORECASE)
_MODIFIED = re.compile(r"\b(?:modified|mod[_ ]?dh|mdh|craig|proximal|khalil)\b|\bm_?dh|\bRevoluteMDH\b", re.IGNORECASE)
_PLACED = re.compile(r"\b(?:tool|base)\b[^\n]{0,12}(?:=|SE3|transl|\bt =)|['\"](?:tool|base)['\"]", re.IGNORECASE)
_NAME = re.compile(r"(?<![\w.])[A-Za-z_]\w*(?!\w)")
_CELL_UNIT = re.compile(r"(?<=[\d.)i])\s*(?P<unit>mm|cm|m|deg|°|rad)$")
_BEHIND = re.compile(r"(?<=[\d.)])\s*(?:deg\b|°)")
_TIMES_PI = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)pi\b")
_PI = re.compile(r"\bpi\b|(?<=\d)pi\b|\bM_PI")
_COMMAND = re.compile(r"\\[A-Za-z]+")
_ONE_DEGREE = dict.fromkeys(("deg", "deg2rad", "d2r", "dtr", "degree"), "pi/180")  # where the text does not say it
_DEEPEST = 20  # names in the values of names
_ALLOWED_UNITS = {"length": "m, cm, mm", "angle": "deg, rad"}
_DIGITS = re.compile(r"\d+")
_BASE = re.compile(r"^0\b|\b(?:base|world|fixed)\b", re.IGNORECASE)
_FUNCTIONS = frozenset(("sqrt", "pi"))
_NAMED = ("none is named", "both are named")


def from_dh_text(text: str, *, file: str, name: str, as_written: bool = False) -> Robot:
    """The arm of the table in a text.

    Args:
        text: code, or a table with a heading (`dh_rows`).
        file: its name, for errors and for `Robot.source`.
        name: of the arm.
        as_written: take every number literally.

    Raises:
        RobotError: no table, two arms, a convention or a unit that is in doubt, an entry that is no number.
    """
    table = table_in(text, file)
    if table is None:
        raise RobotError("there is no Denavit-Hartenberg table in the file", where=file,
                         allowed="a heading that names a, alpha, d and theta above the rows, or calls such as "
                         "Link('d', 0.1, 'a', 0, 'alpha', pi/2)")  # fmt: skip
    check_joints(len(table.rows), file)
    angles = Angles(as_written)
    convention = table.convention or _convention(text, file)
    read = _Reader(table, text, file, angles)
    rows, base, tool = read.rows(convention)
    described = {"name": name, "source": Source("dh", file), "notes": read.notes(convention)}
    robot = from_dh(rows, convention=convention, base=base, tool=tool, **described)  # type: ignore[arg-type]
    return as_intended(robot, angles)


def _convention(text: str, file: str) -> str:
    """The convention that a text names.

    Raises:
        RobotError: it names none, or both.
    """
    named = [bool(pattern.search(text)) for pattern in (_STANDARD, _MODIFIED)]
    if named[0] == named[1]:
        raise RobotError("the convention of the table is in doubt", where=file, got=_NAMED[named[0]],
                         allowed="standard (frame i at the far end of link i) or modified (frame i on joint i)",
                         mend="write the word standard, or modified (Craig), in a line of its own")  # fmt: skip
    return CONVENTIONS[named[1]]


class _Reader:
    """Makes numbers of the entries of one table: its units are settled first."""

    def __init__(self, table: WrittenTable, text: str, file: str, angles: Angles) -> None:
        self.table, self.text, self.file, self.angles = table, text, file, angles
        self.values: dict[tuple[str, Unit | None], float] = {}
        self.length = length_unit(table, text, file, self._sizes(("a", "d")))
        self.angle = angle_unit(table, text, file, self._sizes(("alpha", "theta")))

    def rows(self, convention: str) -> tuple[list[DHRow], Array, Array]:
        """Rows in m and rad; the base and the tool that fixed rows in front of the joints and behind them are.

        Raises:
            RobotError: a fixed row between joints, or one that may be a joint.
        """
        rows = [self._row(written, number) for number, written in enumerate(self.table.rows, 1)]
        moving = [place for place, written in enumerate(self.table.rows) if written.varies is not False]
        if not any(written.varies for written in self.table.rows):
            return rows, np.eye(4), np.eye(4)
        first, last = moving[0], moving[-1]
        self._refuse_fixed_rows(first, last)
        base, tool = (_links(fixed, convention) for fixed in (rows[:first], rows[last + 1 :]))
        joints = [replace(row, name=f"joint{number}") for number, row in enumerate(rows[first : last + 1], 1)]
        return joints, base, tool

    def _refuse_fixed_rows(self, first: int, last: int) -> None:
        """Refuse fixed rows between the first and the last joint, and in front of them where one may be a joint."""
        start, end = 0, last
        if self._is_base(first):
            start = first
        if all(row.assumed for row in self.table.rows if row.varies):
            start, end = 0, len(self.table.rows)  # where no row has a variable beyond doubt, no row is fixed beyond it
        for place, written in enumerate(self.table.rows[start:end], start):
            if written.varies is False:
                raise RobotError("the row has no joint variable", where=f"{self.file}, line {written.line}",
                                 allowed="fixed rows behind the last joint; with the number 0 in front of the first",
                                 mend=f"name the variable, in theta or for a slide in d: q{place + 1}")  # fmt: skip

    def _is_base(self, first: int) -> bool:
        """Whether the rows before the first joint are fixed beyond doubt, by its number or by their names."""
        number = _DIGITS.search(self.table.rows[first].variable)
        if number is not None:
            return int(number[0]) <= 1
        return all(_BASE.search(row.label) for row in self.table.rows[:first])

    def notes(self, convention: str) -> tuple[RobotNote, ...]:
        """How the table is read; which joints slide; whether the text sets a tool or a base, which are not read."""
        read = [RobotNote(NoteOn.DH_TEXT, convention, other=self.length, instead=self.angle)]
        joints = (row for row in self.table.rows if row.varies is not False)
        read += [RobotNote(NoteOn.SLIDES, f"joint{number}", other=row.variable)
                 for number, row in enumerate(joints, 1) if row.assumed]  # fmt: skip
        if _PLACED.search(self.text) is not None:
            read.append(RobotNote(NoteOn.NOT_PLACED))
        return tuple(read)

    def _row(self, written: WrittenRow, number: int) -> DHRow:
        kind, varied = JointKind.REVOLUTE, "theta"
        if written.slides:
            kind, varied = JointKind.PRISMATIC, "d"
        measures = {"a": "length", "alpha": "angle", "d": "length", "theta": "angle", "offset": kind.measure}
        where = f"{self.file}, line {written.line}, row {number}"
        found = {key: self._quantity(written.entries.get(key, "0"), key, measure, where)
                 for key, measure in measures.items()}  # fmt: skip
        offset = found.pop("offset")
        found[varied] += offset
        limits = {key: self._limit(written.entries.get(key), key, kind.measure, where) for key in ("lower", "upper")}
        if limits["lower"] > limits["upper"]:
            raise RobotError("lower limit above upper limit", where=where, got=f"{limits['lower']}, {limits['upper']}")
        return DHRow(**found, kind=kind, name=f"joint{number}", **limits)

    def _limit(self, text: str | None, key: str, measure: str, where: str) -> float:
        if text is None or not text.strip(" -"):
            return {"lower": -inf, "upper": inf}[key]
        return self._quantity(text, key, measure, where)

    def _quantity(self, text: str, key: str, measure: str, where: str) -> float:
        """One entry in m or rad."""
        body, place = text.strip(), f"{where}, {key}"
        unit = _CELL_UNIT.search(body)
        stated = self.table.units.get(key, "")
        if unit is not None:
            body, stated = body[: unit.start()], unit["unit"]
        if measure == "length":
            known = _unit_of(stated, self.length)
            return self._number(body, place, known) * known.size
        if stated == "deg" and _in_radians(body):
            raise RobotError("the unit of the angle is in doubt", where=place, got=f"{body} in degrees",
                             mend="write degrees, 90, or the unit behind it: pi/2rad")  # fmt: skip
        if (stated.replace("°", "deg") or self.angle) == "deg" and not _in_radians(body):
            return quantity(f"{self._number(body, place, unit_named('deg')):.17g} deg", "angle", where=place)
        return self._radians(body, place)

    def _radians(self, body: str, where: str) -> float:
        try:
            return self.angles.quantity(body, where=where)  # a decimal by the rule of digits
        except RobotError:
            return self._number(body, where, unit_named("rad"))

    def _number(self, text: str, where: str, unit: Unit | None, depth: int = 0) -> float:
        """The value of an expression, with the values of the names in it.

        Args:
            text: the expression.
            where: for errors.
            unit: that the value is wanted in; None while it is not settled: values with a unit count as 0.
            depth: of names in the values of names.

        Raises:
            RobotError: a name without a value or with two, or no arithmetic.
        """
        degree = "*pi/180"
        if unit is not None:
            degree = f"*{unit_named('deg').size / unit.size:.17g}"
        plain = _TIMES_PI.sub(r"\1*pi", _BEHIND.sub(degree, with_plain_constants(text or "0")))
        command = _COMMAND.search(plain)
        if command is not None:
            raise RobotError("this command of LaTeX is not read", where=where, got=command[0],
                             mend="write the number, or plain signs: (pi/2), 90°, sqrt(2)")  # fmt: skip

        def value(name: re.Match[str]) -> str:
            if name[0] in _FUNCTIONS:
                return name[0]
            return f"({self._constant(name[0], where, unit, depth):.17g})"

        return quantity(_NAME.sub(value, plain), "number", where=where)

    def _constant(self, name: str, where: str, unit: Unit | None, depth: int) -> float:
        if (name, unit) in self.values:
            return self.values[name, unit]
        written = self.table.constants.get(name, _ONE_DEGREE.get(name))
        if written is None or depth >= _DEEPEST:
            raise _without_number(name, where)
        if " | " in written:
            raise RobotError("the text gives this name two values", where=where, got=f"{name} = {written}",
                             mend="keep one of them")  # fmt: skip
        self.values[name, unit] = self._written_value(written, f"{where}, {name}", unit, depth + 1)
        return self.values[name, unit]

    def _written_value(self, written: str, where: str, unit: Unit | None, depth: int) -> float:
        """The number that a text gives a name: in the unit behind it, and multiples of π in radians.

        Raises:
            RobotError: an angle where a length is wanted, or a length where an angle is.
        """
        found = _CELL_UNIT.search(written)
        if found is not None:
            body, stated = written[: found.start()], unit_named(found["unit"])
        elif unit is not None and unit.measure == "angle" and _in_radians(written):
            body, stated = written, unit_named("rad")
        else:
            return self._number(written, where, unit, depth)
        value = self._number(body, where, stated, depth)
        if unit is None:
            return 0.0
        if unit.measure != stated.measure:
            raise RobotError("the unit does not fit", where=where, got=written, allowed=_ALLOWED_UNITS[unit.measure])
        return value * stated.size / unit.size

    def _sizes(self, keys: tuple[str, ...]) -> list[float]:
        """Sizes of the entries without a unit of their own; 0 where there are none."""
        sizes = [0.0]
        for row in self.table.rows:
            for key in keys:
                entry = row.entries.get(key, "0").strip()
                if _CELL_UNIT.search(entry) is None:
                    sizes.append(abs(self._number(entry, f"{self.file}, line {row.line}, {key}", None)))
        return sizes


def _unit_of(stated: str, other: str) -> Unit:
    """The unit of a length that is stated, else the other one."""
    if stated in LENGTHS:
        return unit_named(stated)
    return unit_named(other)


def _in_radians(entry: str) -> bool:
    """Whether an angle is a multiple of π, and not one that is converted to degrees."""
    return _PI.search(entry) is not None and "180" not in entry


def _without_number(name: str, where: str) -> RobotError:
    return RobotError("the text gives this name no number", where=where, got=name,
                      mend=f"write the number, or a line of its own: {name} = 0.1")  # fmt: skip


def _links(rows: Sequence[DHRow], convention: str) -> Array:
    """The pose of fixed rows."""
    return reduce(times, (_link(row, convention) for row in rows), np.eye(4))


def _link(row: DHRow, convention: str) -> Array:
    """The pose of a fixed row."""
    turn = times(rotation("z", row.theta), translation(0.0, 0.0, row.d))
    twist = times(translation(row.a, 0.0, 0.0), rotation("x", row.alpha))
    if convention == "modified":
        return times(twist, turn)
    return times(turn, twist)
