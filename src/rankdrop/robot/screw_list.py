"""An ordered screw set as a plain list of numbers: one screw a line."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from rankdrop.errors import RobotError
from rankdrop.robot.files import read_text
from rankdrop.robot.model import Array
from rankdrop.robot.quantities import quantity

_ENTRY = re.compile(r"[^\s,;\[\]]+")
_MOST = 200  # screws; no chain is longer


def read_screw_list(path: Path) -> Array:
    """(n, 6) the numbers of a text file, six a line, in the order of the file.

    Numbers are parted by blanks, commas or semicolons, square brackets do not count, # begins a comment, empty lines
    are skipped. A number may be arithmetic without blanks: 1/sqrt(2).

    Raises:
        RobotError: no screws, a line without six numbers, something that is not a number (line and column are told).
    """
    rows = []
    for number, line in enumerate(read_text(path).splitlines(), 1):
        text = line.split("#", 1)[0]
        entries = list(_ENTRY.finditer(text))
        if not entries:
            continue
        where = f"{path}, line {number}"
        values = [
            quantity(_number(entry[0]), "number", where=f"{where}, column {entry.start() + 1}") for entry in entries
        ]
        if len(values) != 6:
            column = entries[6].start() + 1 if len(values) > 6 else len(text.rstrip()) + 1
            raise RobotError(
                "a screw has six numbers (direction; moment)", where=f"{where}, column {column}", got=len(values)
            )
        rows.append(values)
        if len(rows) > _MOST:
            raise RobotError("there are too many screws", where=where, allowed=f"at most {_MOST}")
    if not rows:
        raise RobotError("there are no screws in the file", where=str(path), allowed="six numbers a line")
    return np.array(rows)


def _number(text: str) -> float | str:
    try:
        return float(text)  # also 1e-3 with a sign, which arithmetic would not take
    except ValueError:
        return text
