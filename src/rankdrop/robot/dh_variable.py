"""The joint variable of a row: which cell names it, whether the joint slides, and the constant part."""

from __future__ import annotations

import re
from collections.abc import Mapping

from rankdrop.robot.dh_written import KEYS, WrittenRow

LABEL = "label"  # the key of a first column that is none of `KEYS`
_VARIABLE = re.compile(
    r"(?:\b(?:q|theta|th|t)_?\{?\d{0,2}\}?(?:\[\d{1,2}\]?)?(?:\(t\))?\*?|\bd_?\{?\d{0,2}\}?\*|\*)(?!\w)",
    re.IGNORECASE,
)
_SLIDE = re.compile(r"^q_?\{?\d{0,2}\}?\*?$|\*$|^d_?\{?\d{0,2}\}?\*$")
_DISTANCE = re.compile(r"(?:^|.*\+)\s*(?P<name>[dD]_?\d{1,2})\s*(?:[-+].*)?")
_NO_JOINT = re.compile(r"\b(?:tool|tcp|ee|end|tip|flange|gripper|hand|interface|fixed)\b", re.IGNORECASE)


def row_of_cells(cells: Mapping[str, str], line: int, constants: Mapping[str, str]) -> WrittenRow:
    """The row of cells by `KEYS` and `LABEL`.

    Its joint slides where d is a variable: q2, d2*, or d2 next to a constant theta where the text gives d2 no number.

    Example:
        >>> row = row_of_cells({"a": "0", "alpha": "90", "d": "0.1", "theta": "q2 - 90"}, 4, {})
        >>> row.variable, row.entries["theta"], row.slides
        ('q2', '- 90', False)
    """
    entries = {key: cell for key, cell in cells.items() if key in KEYS}
    label = cells.get(LABEL, "")
    distance = entries.get("d", "")
    variable = _VARIABLE.search(entries.get("theta", "q"))
    slides = _SLIDE.search(distance.lower()) is not None
    if slides:
        variable = _VARIABLE.search(distance)
    for key in ("theta", "d"):
        if key in entries:
            entries[key] = constant_part(entries[key])
    if variable is not None:
        return WrittenRow(entries, line, slides, varies=True, variable=variable[0], label=label)
    name = _name_of_slide(distance, constants, label)
    if not name:
        return WrittenRow(entries, line, varies=False, label=label)
    entries["d"] = distance.replace(name, "0", 1)
    return WrittenRow(entries, line, slides=True, varies=True, variable=name, label=label, assumed=True)


def names_variable(cell: str) -> bool:
    """Whether a cell names a joint variable: q2, theta_1, q[0], d3*."""
    return _VARIABLE.search(cell) is not None


def constant_part(cell: str) -> str:
    """The part of a cell that is added to the joint variable; all of a cell without a variable.

    Example:
        >>> constant_part("q2 - 90°"), constant_part("q2"), constant_part("0.1")
        ('- 90°', '0', '0.1')
    """
    rest = _VARIABLE.sub("", cell, count=1).strip().rstrip("+").strip()
    return rest or "0"


def _name_of_slide(distance: str, constants: Mapping[str, str], label: str) -> str:
    """The name in the column d of a row with a constant theta that no number is given for: its joint slides.

    "" where there is none, and in the row of a tool.
    """
    found = _DISTANCE.fullmatch(distance.strip())
    if found is None or found["name"] in constants or _NO_JOINT.search(label):
        return ""
    return found["name"]
