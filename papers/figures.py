"""The figures as files: svg and png by matplotlib, and json with the numbers in them."""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from textwrap import fill
from typing import Any

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from papers.picture import Panel, Picture
from papers.run import Progress
from rankdrop.disk import replace_file
from rankdrop.errors import OptionError
from rankdrop.report.figures import draw_arm, draw_arrow
from rankdrop.results import json_text

_DPI = 150
_ARROW = 0.34  # length of a unit vector, per reach of the arm that is drawn
_STYLE: Any = {  # matplotlib types its keys by literals
    "svg.hashsalt": "rankdrop", "svg.fonttype": "path", "font.size": 9, "axes.titlesize": 10, "axes.spines.top": False,
    "axes.spines.right": False,
}  # fmt: skip


def pictures(document: str) -> tuple[Picture, ...]:
    """The figures of one document as data.

    Args:
        document: "AM", "ML", "GR", "KG" or "JL".
    """
    from papers import am_pictures, other_pictures

    made: dict[str, Callable[[], tuple[Picture, ...]]] = {
        "AM": am_pictures.pictures,
        "ML": lambda: (other_pictures.planar_arm(), other_pictures.joint_rates(), *other_pictures.pictures("ML")),
        "GR": lambda: (other_pictures.typical_arm(), other_pictures.screw_axes()),
        "KG": lambda: (other_pictures.canadarm2(),),
        "JL": lambda: (*other_pictures.pictures("JL"), other_pictures.mapping()),
    }
    return made[document]()


def check_folder(folder: str) -> None:
    """Find out before a long run whether figures can be drawn and written there; the folder itself may be new.

    Raises:
        OptionError: a file, no parent folder, or no permission.
    """
    path = Path(folder)
    if path.exists() and not path.is_dir():
        raise OptionError("it is a file, not a folder", where="--figures", got=folder)
    if not path.exists() and not path.resolve().parent.is_dir():
        raise OptionError("there is no such folder", where="--figures", got=str(path.resolve().parent))
    if not os.access(path if path.exists() else path.resolve().parent, os.W_OK):
        raise OptionError("no permission to write there", where="--figures", got=folder)


def save_figures(documents: Sequence[str], folder: str, *, progress: Progress | None = None) -> tuple[Path, ...]:
    """Write every figure of some documents, AM-figure-5.svg and so on.

    Args:
        documents: short names.
        folder: made if it is not there.
        progress: called before each figure and at the end.

    Returns:
        The files written.

    Raises:
        OptionError: a file cannot be written.
    """
    check_folder(folder)
    made = [picture for document in documents for picture in pictures(document)]
    written: list[Path] = []
    try:
        Path(folder).mkdir(exist_ok=True)
        for done, picture in enumerate(made):
            if progress is not None:
                progress("figures", done, len(made))
            written += _save(picture, Path(folder) / picture.file)
    except OSError as error:
        raise OptionError(f"cannot write: {error.strerror}", where=folder) from error
    if progress is not None:
        progress("figures", len(made), len(made))
    return tuple(written)


def _save(picture: Picture, path: Path) -> list[Path]:
    figure = draw(picture)
    files = [path.with_suffix(ending) for ending in (".svg", ".png", ".json")]
    svg, png = io.BytesIO(), io.BytesIO()
    with matplotlib.rc_context(_STYLE):
        figure.savefig(svg, format="svg", metadata={"Date": None, "Creator": "rankdrop"})
        figure.savefig(png, format="png", dpi=_DPI, metadata={"Software": "rankdrop"})
    contents = (svg.getvalue(), png.getvalue(), json_text(picture.to_dict()).encode())
    for file, content in zip(files, contents, strict=True):
        replace_file(file, content)
    return files


def draw(picture: Picture) -> Figure:
    """One figure, drawn without a display.
    """
    count = len(picture.panels)
    columns = count if count < 4 else 2
    rows = -(-count // columns)
    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(4.0 * columns + 0.4, 3.7 * rows + 0.6), layout="constrained")
        FigureCanvasAgg(figure)
        for number, panel in enumerate(picture.panels, start=1):
            axes: Any = figure.add_subplot(rows, columns, number, projection="3d" if panel.z else None)
            (_draw_in_space if panel.z else _draw_flat)(axes, panel)
        figure.suptitle(f"{picture.document}, {picture.name}", fontsize=10, fontweight="bold")
        figure.supxlabel(fill(picture.caption, 62 * columns), fontsize=7.5)
    return figure


def _draw_flat(axes: Any, panel: Panel) -> None:
    for line in panel.lines:
        axes.plot(*line.points.T, color=line.colour, linestyle=line.dashes, linewidth=1.2, label=line.label or None,
                  marker="." if line.marks else None, markersize=4)  # fmt: skip
    if panel.level is not None:
        axes.axhline(panel.level, color="#CC0000", linewidth=0.8)
    if "x" in panel.log:
        axes.set_xscale("log")
    if "y" in panel.log:
        axes.set_yscale("log")
    if panel.span is not None:
        axes.set_ylim(*panel.span)
    axes.set(title=panel.title, xlabel=panel.x, ylabel=panel.y)
    axes.grid(alpha=0.25, linewidth=0.5)
    if any(line.label for line in panel.lines):
        axes.legend(frameon=False, fontsize=8)


def _draw_in_space(axes: Any, panel: Panel) -> None:
    for line in panel.lines:
        axes.plot(*line.points.T, color=line.colour, linestyle=line.dashes, linewidth=1.6, label=line.label or None,
                  marker="o" if line.marks else None, markersize=3)  # fmt: skip
    points = np.concatenate([*(arm.drawn.links for arm in panel.arms), *(line.points for line in panel.lines)])
    low, high = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
    size = max((arm.size for arm in panel.arms), default=float((high - low).max()))
    for arm in panel.arms:
        draw_arm(axes, arm.drawn, size, arm.marked)
    length = _ARROW * size
    labelled: set[str] = set()
    for arrow in panel.arrows:
        label = None if arrow.label in labelled else arrow.label
        labelled.add(arrow.label)
        draw_arrow(axes, arrow.start, length * arrow.vector, arrow.colour, size, dotted=arrow.rotation, label=label)
    if panel.tall:
        ends = [arrow.start + length * arrow.vector for arrow in panel.arrows]
        every = np.array([low, high, *ends])
        middle, half = (every.min(0) + every.max(0)) / 2, float(np.ptp(every, axis=0).max()) / 2 + 0.04 * size
        for name, centre in zip("xyz", middle, strict=True):
            getattr(axes, f"set_{name}lim")(centre - half, centre + half)
    axes.view_init(*panel.view)
    axes.set_box_aspect((1, 1, 1), zoom=0.82)  # leaves room for the labels, which the layout does not know of
    axes.set(title=panel.title, xlabel=panel.x, ylabel=panel.y, zlabel=panel.z)
    axes.tick_params(labelsize=6)
    axes.locator_params(nbins=4)
    if any(line.label for line in panel.lines) or panel.arrows:
        axes.legend(frameon=False, fontsize=7, loc="upper left")

