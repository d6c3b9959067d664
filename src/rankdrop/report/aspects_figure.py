"""A picture of the aspects of an arm: one row of maps for each group of factors, the legend at the right."""

from __future__ import annotations

from math import degrees, pi
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from rankdrop.aspects import AspectMap, Postures, aspect_maps, count_of_arm
from rankdrop.report.chart import COLOURS, joint_axes
from rankdrop.report.figures import new_figure
from rankdrop.robot import Robot
from rankdrop.text import aspects_number, joint_symbol, region_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SLICED = "Slices of a region: pieces of one colour are joined through the joints that are held."
_SIDE, _STRIP = 1.9, 0.9  # height of a row of maps, and of one that is a line [inch]
_PANEL = 1.75  # width of a map [inch]
_WIDE, _TITLE = 30, 84  # characters of a line of the legend, and of the title
_PALE = 0.75  # opacity of colours
_MANY = 12  # regions of a group that the legend lists


def aspects_figure(postures: Postures) -> Figure:
    """The regions of regular configurations in the joints that separate them, coloured.

    Args:
        found: from `rankdrop.aspects.aspects_of`.

    Raises:
        OptionError: there is nothing to draw, or the aspects were not counted.
        MissingExtraError: matplotlib is not installed.
    """
    maps = aspect_maps(*count_of_arm(postures.robot, postures.task))
    columns = max(len(chart.slices) or 1 for chart in maps)
    heights = [_STRIP if chart.cells.ndim == 1 else _SIDE for chart in maps]
    drawn = new_figure((_PANEL * max(columns, 2) + 0.6, sum(heights) + 0.35 * len(maps)), "a figure of aspects")
    rows: Any = drawn.subfigures(len(maps), 1, height_ratios=heights, squeeze=False)[:, 0]
    first = 0
    for chart, row in zip(maps, rows, strict=True):
        axes = row.subplots(1, columns, squeeze=False)[0]
        row.subplots_adjust(left=0.11, right=0.99, bottom=0.24, top=0.85, wspace=0.12)
        tones = [COLOURS[(first + k) % len(COLOURS)] for k in range(len(chart.regions))]
        for k, panel in enumerate(axes):
            if k < max(len(chart.slices), 1):
                _draw_map(panel, postures.robot, chart, k, tones)
            else:
                panel.set_axis_off()
        _legend(axes[max(len(chart.slices), 1) - 1], postures, chart, tones)
        first += len(chart.regions)
    if any(chart.slices for chart in maps):
        drawn.text(0.02, 0.0, _SLICED, fontsize=6.5, va="top")
    drawn.suptitle(fill(aspects_number(postures), _TITLE), fontsize=9, x=0.02, y=1.0, ha="left", va="bottom")
    return drawn


def _draw_map(axes: Any, robot: Robot, shown: AspectMap, k: int, tones: list[str]) -> None:
    """One map; `k`: which slice."""
    from matplotlib.colors import ListedColormap

    if shown.slices:
        cells = shown.cells[k]
    else:
        cells = shown.cells
    across = shown.joints[:2]
    names, ticks = joint_axes(robot, across, [(-pi, pi)] * len(across))
    axes.imshow(
        np.atleast_2d(cells.T), origin="lower", extent=(-pi, pi, -pi, pi), aspect="auto", interpolation="nearest",
        cmap=ListedColormap(tones), vmin=-0.5, vmax=len(tones) - 0.5, alpha=_PALE,
    )  # fmt: skip
    axes.set_xlabel(names[0], fontsize=8, labelpad=1)
    axes.set_xticks(*_inner(ticks[0]))
    if len(across) == 2 and k == 0:
        axes.set_ylabel(names[1], fontsize=8, labelpad=1)
        axes.set_yticks(*_inner(ticks[1]))
    else:
        axes.set_yticks([])
    axes.tick_params(labelsize=6)
    values = [*zip(shown.joints[2:], shown.slices[k : k + 1], strict=False), *shown.held]
    kinds = {number: str(robot.variables[number - 1].kind) for number, _ in values}
    title = ", ".join(f"{joint_symbol(number, kinds[number])} = {degrees(value):.4g}°" for number, value in values)
    axes.set_title(title.replace("-", "−"), fontsize=7, pad=3)


def _inner(ticks: Any) -> tuple[list[float], list[str]]:
    """The ticks between the ends, where those of two maps would touch."""
    return [value for value, _ in ticks[1:-1]], [word for _, word in ticks[1:-1]]


def _legend(axes: Any, postures: Postures, shown: AspectMap, tones: list[str]) -> None:
    """Colours of regions, at the right of the last map."""
    from matplotlib.patches import Patch

    handles = [
        Patch(color=tone, alpha=_PALE, lw=0, label=fill(region_words(postures.count, shown.factors, region), _WIDE))
        for tone, region in zip(tones, shown.regions, strict=True)
    ][:_MANY]
    if len(shown.regions) > _MANY:
        handles.append(Patch(alpha=0.0, label=f"and {len(shown.regions) - _MANY} more"))
    axes.legend(handles=handles, fontsize=7, loc="upper left", bbox_to_anchor=(1.04, 1.0), borderaxespad=0.0,
                frameon=False)  # fmt: skip
