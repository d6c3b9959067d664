"""An ordered screw set as a plain list of numbers: one screw a line."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from rankdrop.errors import RobotError
from rankdrop.robot.budgets import LARGEST_TABLE
from rankdrop.robot.digits import Angles
from rankdrop.robot.files import read_text
from rankdrop.robot.meant import as_meant
from rankdrop.robot.model import Array, Robot, check_joints
from rankdrop.robot.quantities import quantity
from rankdrop.robot.screws import from_screws

_ENTRY = re.compile(r"[^\s,;\[\]]+")
_NOTE = "six numbers a line: screws (direction; moment about the base origin) at q = 0, in order"


def read_screw_list(path: Path) -> Array:
    """(n, 6) the numbers of a text file, six a line, in the order of the file.

    Numbers are parted by blanks, commas or semicolons, square brackets do not count, # begins a comment, empty lines
    are skipped. A number may be arithmetic without blanks: 1/sqrt(2).

    Raises:
        RobotError: no screws, a line without six numbers, something that is not a number (line and column are told).
    """
    return _read(path)[0]


def _read(path: Path) -> tuple[Array, list[int]]:
    """The numbers, and the line each screw stands in."""
    rows, lines = [], []
    for number, line in enumerate(read_text(path, largest=LARGEST_TABLE).splitlines(), 1):
        text = line.split("#", 1)[0]
        entries = list(_ENTRY.finditer(text))
        if not entries:
            continue
        where = f"{path}, line {number}"
        values = [
            quantity(_number(entry[0]), "number", where=f"{where}, column {entry.start() + 1}") for entry in entries[:7]
        ]
        if len(values) != 6:
            column = entries[6].start() + 1 if len(values) > 6 else len(text.rstrip()) + 1
            raise RobotError(
                "a screw has six numbers (direction; moment)", where=f"{where}, column {column}", got=len(entries)
            )
        rows.append(values)
        lines.append(number)
        check_joints(len(rows), where)
    if not rows:
        raise RobotError("there are no screws in the file", where=str(path), allowed="six numbers a line")
    return np.array(rows), lines


def is_screw_list(text: str) -> bool:
    """Whether a text begins, after comments, as such a file does: with a number."""
    for line in text.splitlines():
        entries = _ENTRY.findall(line.split("#", 1)[0])
        if entries:
            try:
                quantity(_number(entries[0]), "number", where="")
            except RobotError:
                return False
            return "=" not in line and not line.lstrip().startswith("[[")
    return False


def from_screw_list(path: Path, *, name: str, as_written: bool = False) -> Robot:
    """The arm whose screws a plain file lists, base to tip, at the configuration they were written down at: q = 0.

    Args:
        path: six numbers a line, direction first: (s; s_o), s_o = p × s for a line through p, about the base origin.
        name: of the arm.
        as_written: keep noise of 2e-5 rad and 2 µm.

    Raises:
        RobotError: as `read_screw_list`; a screw that is no joint's (the line is told).
    """
    rows, lines = _read(path)
    for screw, line in zip(rows, lines, strict=True):
        try:
            from_screws(screw[None], order="angular-first")
        except RobotError as error:
            raise RobotError(error.what, where=f"{path}, line {line}", got=error.got, allowed=error.allowed,
                             mend=error.mend) from error  # fmt: skip
    robot = from_screws(rows, order="angular-first", name=name, notes=(_NOTE,))
    return as_meant(robot, Angles(as_written=as_written))


def _number(text: str) -> float | str:
    try:
        return float(text)  # also 1e-3 with a sign, which arithmetic would not take
    except ValueError:
        return text
