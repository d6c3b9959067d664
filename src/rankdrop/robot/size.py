"""A note on arms whose numbers are of an unlikely size: a file in millimetres is read as metres."""

from __future__ import annotations

from dataclasses import replace

from rankdrop.reach import link_lengths
from rankdrop.robot.model import Robot

_LARGEST = 30.0  # [m]; Canadarm2, the longest arm flown, reaches 17.6 m, and arms of 30 mm become 30 m
_SMALLEST = 0.03  # [m]; the smallest arms sold reach some 0.2 m
_NOTHING = 1e-9  # [m]; a bare wrist has no length at all, and none is missing


def with_size_note(robot: Robot) -> Robot:
    """The same robot, with a note where its reach (see `rankdrop.reach`) is above 30 m or below 3 cm."""
    length = float(link_lengths(robot).sum())
    if not (length > _LARGEST or _NOTHING < length < _SMALLEST):
        return robot
    note = f"the arm's reach is {length:.3g} m: are these numbers millimetres? Lengths are read as metres"
    return replace(robot, notes=(*robot.notes, note))
