"""A judged path for papers and reports: distance, σ and joint rates along it, its stretches coloured."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rankdrop.errors import MissingExtraError
from rankdrop.motion import CROSSING, FREE, TOUCHING, UNDECIDED, PathCheck, Place
from rankdrop.robot import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TONES = {FREE: "#009E73", CROSSING: "#D55E00", TOUCHING: "#CC79A7", UNDECIDED: "#B07D00"}
"""Of the stretches, after Okabe and Ito; meetings carry a mark as well, so that no colour has to be told apart."""
_MARKS = {CROSSING: "X", TOUCHING: "v", UNDECIDED: "s"}


def path_figure(check: PathCheck) -> Figure:
    """Distance to the nearest known family, σ_r, and the share of the velocity limits, over time or rows.

    Args:
        check: from `check_path`.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtraError("matplotlib", None, "a figure of a path") from error
    profile = check.profile
    x = profile.position if profile.time is None else profile.time
    panels: list[tuple[str, Array]] = [("distance [rad]", profile.distance), ("σ", profile.sigma)]
    if np.isfinite(profile.rates).any():
        panels.append(("rate / limit", profile.rates))
    panels = [(name, values) for name, values in panels if np.isfinite(values).any()]
    drawn = Figure(figsize=(6.4, 0.6 + 1.3 * len(panels)))
    for k, (name, values) in enumerate(panels):
        axes = drawn.add_subplot(len(panels), 1, k + 1)
        _colour(axes, check, legend=k == 0)
        axes.plot(x, values, color="black", lw=1.0)
        if name == "distance [rad]" and check.options.min_distance > 0.0:
            axes.axhline(check.options.min_distance, color="black", lw=0.7, ls=":")
        if name == "rate / limit":
            axes.axhline(1.0, color="black", lw=0.7, ls=":")
        axes.set_ylabel(name, fontsize=8)
        axes.set_ylim(bottom=0)
        axes.set_xlim(x[0], x[-1] if x[-1] > x[0] else x[0] + 1)
        axes.tick_params(labelsize=7)
        if k < len(panels) - 1:
            axes.set_xticklabels([])
    if panels:
        axes.set_xlabel("row" if profile.time is None else "time [s]", fontsize=8)
    drawn.suptitle(f"{check.robot.name}: {check.verdict}", fontsize=9)
    drawn.tight_layout()
    return drawn


def _colour(axes: Any, check: PathCheck, *, legend: bool) -> None:
    """Bands of the stretches; marks on the axis where one is too short to be seen."""
    named: set[str] = set()
    for one in check.stretches:
        low, high = _at(one.start), _at(one.end)
        axes.axvspan(low, high, color=TONES[one.verdict], alpha=0.18, lw=0)
        mark = _MARKS.get(one.verdict)
        if mark is not None:
            label = None if one.verdict in named else one.verdict
            tone = TONES[one.verdict]
            axes.plot([(low + high) / 2], [0.0], mark, color=tone, ms=6, clip_on=False, zorder=5, label=label)
            named.add(one.verdict)
    if legend and named:
        axes.legend(fontsize=7, loc="upper right")


def _at(place: Place) -> float:
    return place.row + place.share if place.time is None else place.time
