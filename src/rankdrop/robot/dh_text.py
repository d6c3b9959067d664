"""An arm from a Denavit–Hartenberg table as it stands in code, in a paper or in a question.

`dh_rows` finds the rows. Here the convention and the units are settled: as the text states them, else as its numbers
show them beyond doubt; else the text is refused with the line to add. Entries are arithmetic of numbers and of names
that the text gives a value.
"""

from __future__ import annotations

import re
from functools import reduce
from math import inf, pi

import numpy as np

from rankdrop.errors import RobotError
from rankdrop.robot.dh import CONVENTIONS, DHRow, from_dh
from rankdrop.robot.dh_rows import WrittenRow, WrittenTable, table_in
from rankdrop.robot.joint_text import with_plain_constants
from rankdrop.robot.model import Array, JointKind, Robot, Source, check_joints
from rankdrop.robot.note import NoteOn, RobotNote
from rankdrop.robot.quantities import Angles, quantity
from rankdrop.robot.square_up import as_intended
from rankdrop.robot.transform import rotation, times, translation

_STANDARD = re.compile(r"\b(?:standard|std[_ ]?dh|sdh|classic(?:al)?|distal)\b|\bRevoluteDH\b", re.IGNORECASE)
_MODIFIED = re.compile(r"\b(?:modified|mod[_ ]?dh|mdh|craig|proximal|khalil)\b|\bm_?dh|\bRevoluteMDH\b", re.IGNORECASE)
_LENGTH_UNIT = re.compile(r"\b(?:lengths?|units?|dimensions)\b[^\n]{0,20}?\b(mm|cm|m)\b", re.IGNORECASE)
_DEGREES = re.compile(r"\b(?:degrees?|deg)\b", re.IGNORECASE)
_PLACED = re.compile(r"\b(?:tool|base)\b[^\n]{0,12}(?:=|SE3|transl|\bt =)|['\"](?:tool|base)['\"]", re.IGNORECASE)
_NAME = re.compile(r"(?<![\w.])[A-Za-z_]\w*(?!\w)")
_CELL_UNIT = re.compile(r"(?<=[\d.)i])\s*(?P<unit>mm|cm|m|deg|°|rad)$")
_BEHIND = re.compile(r"(?<=[\d.)])\s*(?:deg\b|°)")
_TIMES_PI = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)pi\b")
_PI = re.compile(r"\bpi\b|(?<=\d)pi\b|\bM_PI")
_COMMAND = re.compile(r"\\[A-Za-z]+")
_ONE_DEGREE = dict.fromkeys(("deg", "deg2rad", "d2r", "dtr", "degree"), "pi/180")  # where the text does not say it
_LARGEST_ARM = 10.0  # [m]: an arm of larger numbers is in mm, or in cm
_LEAST_MILLIMETRES = 50.0  # the longest link of an arm is longer; a table in cm has smaller numbers
_MOST_RADIANS = 2 * pi + 0.01
_DEEPEST = 20  # names in the values of names
_LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
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
    rows, tool = read.rows(convention)
    described = {"name": name, "source": Source("dh", file), "notes": read.notes(convention)}
    robot = from_dh(rows, convention=convention, tool=tool, **described)  # type: ignore[arg-type]
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
        self.values: dict[str, float] = {}
        self.length, self.angle = self._length_unit(), self._angle_unit()

    def rows(self, convention: str) -> tuple[list[DHRow], Array]:
        """Rows in m and rad; the tool that fixed rows at the end are.

        Raises:
            RobotError: a fixed row before a joint.
        """
        rows: list[DHRow] = []
        fixed: list[Array] = []
        mixed = any(row.varies for row in self.table.rows)
        for number, written in enumerate(self.table.rows, 1):
            row = self._row(written, number)
            if mixed and written.varies is False:
                fixed.append(_link(row, convention))
            elif fixed:
                raise RobotError("a row before this one has no joint variable", mend="name it there: q1",
                                 where=f"{self.file}, line {written.line}",
                                 allowed="rows without a variable behind the last joint")  # fmt: skip
            else:
                rows.append(row)
        return rows, reduce(times, fixed, np.eye(4))

    def notes(self, convention: str) -> tuple[RobotNote, ...]:
        """How the table is read; whether the text sets a tool or a base, which are not read."""
        read = RobotNote(NoteOn.DH_TEXT, convention, other=self.length, instead=self.angle)
        if _PLACED.search(self.text) is None:
            return (read,)
        return read, RobotNote(NoteOn.NOT_PLACED)

    def _row(self, written: WrittenRow, number: int) -> DHRow:
        kind, varied = JointKind.REVOLUTE, "theta"
        if written.slides:
            kind, varied = JointKind.PRISMATIC, "d"
        measures = {"a": "length", "alpha": "angle", "d": "length", "theta": "angle", "offset": kind.measure}
        where = f"{self.file}, line {written.line}, joint {number}"
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
        body = text.strip()
        unit = _CELL_UNIT.search(body)
        stated = self.table.units.get(key, "")
        if unit is not None:
            body, stated = body[: unit.start()], unit["unit"].replace("°", "deg")
        if measure == "length":
            return self._number(body, f"{where}, {key}") * _LENGTHS.get(stated, _LENGTHS[self.length])
        if stated == "deg" and _in_radians(body):
            raise RobotError("the unit of the angle is in doubt", where=f"{where}, {key}", got=f"{body} in degrees",
                             mend="write degrees, 90, or the unit behind it: pi/2rad")  # fmt: skip
        if (stated or self.angle) == "deg" and not _in_radians(body):
            return quantity(f"{self._number(body, f'{where}, {key}'):.17g} deg", "angle", where=f"{where}, {key}")
        return self._radians(body, f"{where}, {key}")

    def _radians(self, body: str, where: str) -> float:
        try:
            return self.angles.quantity(body, where=where)  # a decimal by the rule of digits
        except RobotError:
            return self._number(body, where)

    def _number(self, text: str, where: str, depth: int = 0) -> float:
        """The value of an expression, with the values of the names in it.

        Raises:
            RobotError: a name without a value or with two, or no arithmetic.
        """
        plain = _TIMES_PI.sub(r"\1*pi", _BEHIND.sub("*pi/180", with_plain_constants(text or "0")))
        command = _COMMAND.search(plain)
        if command is not None:
            raise RobotError("this command of LaTeX is not read", where=where, got=command[0],
                             mend="write the number, or plain signs: (pi/2), 90°, sqrt(2)")  # fmt: skip

        def value(name: re.Match[str]) -> str:
            if name[0] in _FUNCTIONS:
                return name[0]
            return f"({self._constant(name[0], where, depth):.17g})"

        return quantity(_NAME.sub(value, plain), "number", where=where)

    def _constant(self, name: str, where: str, depth: int) -> float:
        if name in self.values:
            return self.values[name]
        written = self.table.constants.get(name, _ONE_DEGREE.get(name))
        if written is None or depth >= _DEEPEST:
            raise _without_number(name, where)
        if " | " in written:
            raise RobotError("the text gives this name two values", where=where, got=f"{name} = {written}",
                             mend="keep one of them")  # fmt: skip
        self.values[name] = self._number(written, where, depth + 1)
        return self.values[name]

    def _largest(self, keys: tuple[str, ...]) -> float:
        """The largest of the entries without a unit of their own; 0 where there are none."""
        sizes = [0.0]
        for row in self.table.rows:
            for key in keys:
                entry = row.entries.get(key, "0").strip()
                if _CELL_UNIT.search(entry) is None:
                    sizes.append(abs(self._number(entry, f"{self.file}, line {row.line}, {key}")))
        return max(sizes)

    def _length_unit(self) -> str:
        """The unit of lengths without one.

        Raises:
            RobotError: it is in doubt.
        """
        stated = {unit for key, unit in self.table.units.items() if unit in _LENGTHS}
        named = _LENGTH_UNIT.search(self.text)
        if len(stated) == 1:
            return stated.pop()
        if named is not None:
            return named[1].lower()
        largest = self._largest(("a", "d"))
        if largest <= _LARGEST_ARM:
            return "m"
        if largest < _LEAST_MILLIMETRES:
            raise RobotError("the unit of the lengths is in doubt", where=self.file, got=f"{largest:g} at most",
                             allowed="mm, cm or m", mend="name the unit in the heading: a [cm]")  # fmt: skip
        return "mm"

    def _angle_unit(self) -> str:
        """The unit of angles without one.

        Raises:
            RobotError: it is in doubt.
        """
        largest = self._largest(("alpha", "theta"))
        if self.table.radians:
            if largest > 2 * _MOST_RADIANS:
                raise RobotError("an angle of many turns in radians", where=self.file, got=f"{largest:g}",
                                 mend="write pi/2 or deg2rad(90)")  # fmt: skip
            return "rad"
        if "deg" in self.table.units.values() or (largest > _MOST_RADIANS and largest >= 15.0):
            return "deg"
        if largest > _MOST_RADIANS or (0 < largest <= pi and _DEGREES.search(self.text) and _whole(largest)):
            raise RobotError("the unit of the angles is in doubt", where=self.file, got=f"{largest:g}",
                             allowed="rad or deg", mend="name the unit in the heading: alpha [deg]")  # fmt: skip
        return "rad"


def _in_radians(entry: str) -> bool:
    """Whether an angle is a multiple of π, and not one that is converted to degrees."""
    return _PI.search(entry) is not None and "180" not in entry


def _without_number(name: str, where: str) -> RobotError:
    return RobotError("the text gives this name no number", where=where, got=name,
                      mend=f"write the number, or a line of its own: {name} = 0.1")  # fmt: skip


def _whole(number: float) -> bool:
    return number == round(number)


def _link(row: DHRow, convention: str) -> Array:
    """The pose of a fixed row."""
    turn = times(rotation("z", row.theta), translation(0.0, 0.0, row.d))
    twist = times(translation(row.a, 0.0, 0.0), rotation("x", row.alpha))
    if convention == "modified":
        return times(twist, turn)
    return times(turn, twist)
