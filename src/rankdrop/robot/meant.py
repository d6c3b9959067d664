"""The last step of every reader: the arm that a file means, and one note that says what was taken so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rankdrop.robot.changes import Change
from rankdrop.robot.digits import Angles
from rankdrop.robot.model import Robot
from rankdrop.robot.structure import squared
from rankdrop.tolerances import NOTHING


def as_meant(robot: Robot, angles: Angles) -> Robot:
    """The arm with exact structure where its file's numbers hold it but for noise, and a note on what was changed.

    Args:
        robot: read with `angles`.
        angles: what the reader took decimals for; with `as_written` the robot is returned as it is.
    """
    if angles.as_written:
        return robot
    found, changes = squared(robot)
    note = _note([abs(x) for x in angles.changes if abs(x) > NOTHING], changes)
    return replace(found, notes=(*found.notes, note)) if note else found


def _note(angles: Sequence[float], changes: Sequence[Change]) -> str:
    """One line, empty where no number was changed by more than a nanometre or a billionth of a radian."""
    parts = []
    if angles:
        means = "the multiple of 15° it rounds" if len(angles) == 1 else "the multiples of 15° they round"
        parts.append(f"{count(len(angles), 'angle')} taken as {means}, at most {max(angles):.2g} rad")
    turned = [change.by for change in changes if change.turns]
    moved = [change.by for change in changes if not change.turns]
    if changes:
        what = [count(len(x), name) for x, name in ((turned, "axis"), (moved, "length")) if x]
        most = [f"{max(turned):.2g} rad"] if turned else []
        most += [f"{max(moved) * 1e6:.2g} µm"] if moved else []
        parts.append(f"{' and '.join(what)} squared, at most {', '.join(most)}")
    return "; ".join([*parts, "--as-written keeps the file's numbers"]) if parts else ""


def count(number: int, one: str) -> str:
    """ "1 axis", "3 axes", "2 lengths"."""
    if number == 1:
        return f"1 {one}"
    return f"{number} {one[:-2]}es" if one.endswith("is") else f"{number} {one}s"
