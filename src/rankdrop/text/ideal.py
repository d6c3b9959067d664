"""The ideal arm near an arm, in words: what was moved, and what the arm itself does where the ideal one is singular."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple

import numpy as np

from rankdrop.results.ideal_vs_actual import Here, Idealised, Nearby
from rankdrop.robot.square_up import ExactChange
from rankdrop.sections import Section
from rankdrop.tolerances import DEFAULT


def moved_sentence(arm: Idealised) -> str:
    """How much was moved, at most by how much."""
    if not arm.changes:
        return f"nothing is moved within {arm.tolerance.text}: the arm is as exact as it can be"
    return str(arm.ideal.notes[-1])


def here_section(arm: Idealised, here: Here) -> Section:
    """The arm itself at a configuration, and where the ideal arm is singular next to it."""
    name = f"σ{here.number}"
    lines = [f"{name} of the arm itself here: {_short(here.sigma)}"]
    if here.distance is None or here.there is None:
        lines.insert(0, "no singular configuration of the ideal arm was found from here")
    elif here.distance == 0.0:
        lines = [f"the ideal arm is singular here; this arm's {name} here is {_short(here.there)}"]
    else:
        away = f"{np.degrees(here.distance):.2g}° from here"
        lines.insert(0, f"the ideal arm is singular {away}; this arm's {name} there is {_short(here.there)}")
    if arm.changes:
        summary = ""
    else:
        summary = moved_sentence(arm)
    return Section("Ideal arm", summary, tuple(lines))


def moved_section(arm: Idealised) -> Section:
    """What was moved, and by how much."""
    title = "What was moved"
    rows = tuple((change.name, ", ".join(map(str, change.joints)), *_change_cells(change)) for change in arm.changes)
    if not rows:
        return Section(title, moved_sentence(arm), texts=(0, 1))
    columns, notes = ("number", "joints", "from", "to", "by"), ("numbers not listed are unchanged",)
    return Section(title, columns=columns, rows=rows, texts=(0, 1), notes=notes)


def there_section(nearby: Sequence[Nearby]) -> Section:
    """σ of the arm itself on each family of the ideal one, and how far its own nearest singular configuration is."""
    rows = tuple(
        (f"{near.id}  {near.name}", f"σ{near.number}", *map(_short, astuple(near.sigma)), *_nearby_cells(near))
        for near in nearby
    )
    columns = ("family of the ideal arm", "", "least", "median", "largest", "nearest", "median")
    points = max(near.points for near in nearby)
    searched = max(near.searched for near in nearby)
    notes = (
        f"σ: of the arm itself at up to {points} random points of each family, the largest that vanishes for the ideal "
        "arm.",
        f"nearest, median: from {searched} of them, the ways to the nearest configurations found at which the arm "
        "itself is singular.",
    )
    return Section("The arm itself there", "", columns=columns, rows=rows, notes=notes)


def _change_cells(change: ExactChange) -> tuple[str, str, str]:
    if change.kind in ("base", "tip"):
        return "", "", f"{np.degrees(change.by):.2g}°"
    before, after = change.ends
    if change.turns:
        return before, after, f"{np.degrees(change.by):.3g}°"
    return before, after, f"{change.by * 1e3:.3g} mm"


def _nearby_cells(nearby: Nearby) -> tuple[str, str]:
    if nearby.distance is None:
        return "none found", ""
    return f"{_degrees(nearby.distance.least)}", f"{_degrees(nearby.distance.median)}"


def _degrees(distance: float) -> str:
    if distance > DEFAULT.singular:
        return f"{np.degrees(distance):.2g}°".replace("-", "−")
    return "0°"


def _short(value: float) -> str:
    if value <= DEFAULT.singular:
        return "0"
    return f"{value:.2g}".replace("-", "−")
