"""The arm at a witness for papers: links, axes, and the lost directions as AM draw them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rankdrop.errors import MissingExtraError
from rankdrop.family import Family
from rankdrop.local import drawn_at
from rankdrop.reach import reach
from rankdrop.report.content import arrows
from rankdrop.report.solids import draw_arm, draw_arrow
from rankdrop.results import Analysis
from rankdrop.robot import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ARROWS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
"""Of the lost directions: blue, red, green as in AM, in tones that all eyes tell apart."""
_ARROW = 0.32  # length per reach


def arm_figure(analysis: Analysis, family: Family, blamed: Sequence[int] = ()) -> Figure:
    """The arm at the witness of a family; solid arrows: translation lost, dotted: rotation.

    Args:
        analysis: of the arm.
        family: one of its families.
        blamed: numbers (from 1) of the joints whose axes are marked.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtraError("matplotlib", None, "a figure for papers") from error
    robot = analysis.robot
    drawn = Figure(figsize=(3.8, 3.8))
    axes: Any = drawn.add_subplot(projection="3d")
    arm = drawn_at(robot, np.array(family.witness))
    size = reach(robot)
    draw_arm(axes, arm, size, blamed)
    at, twists = arrows(analysis, family)
    for twist, tone in zip(twists, ARROWS * len(twists), strict=False):
        for vector, dotted in ((twist[:3], False), (twist[3:], True)):
            if np.linalg.norm(vector) > 0.02:
                draw_arrow(axes, at, _ARROW * size * vector, tone, size, dotted=dotted)
    _framed(axes, np.vstack([arm.links, at[None]]), size)
    drawn.suptitle(f"{family.id}: {family.name}", fontsize=8, y=0.96)
    return drawn


def _framed(axes: Any, points: Array, size: float) -> None:
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    half = max(float(np.ptp(points, axis=0).max()) / 2, 0.2 * size) + 0.12 * size
    axes.set(
        xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half),
        zlim=(middle[2] - half, middle[2] + half),
    )  # fmt: skip
    axes.set_box_aspect((1, 1, 1), zoom=1.1)
    axes.tick_params(labelsize=6)
    for name, set_name in (("x", axes.set_xlabel), ("y", axes.set_ylabel), ("z", axes.set_zlabel)):
        set_name(f"{name} [m]", fontsize=7)
