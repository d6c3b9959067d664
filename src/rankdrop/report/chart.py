"""Charts of a report: one record, as SVG on pages and drawn by matplotlib for papers.

A chart has a map, curves and dots in the colours of the families. On pages the colours come from the style.
"""

from __future__ import annotations

import struct
import zlib
from base64 import b64encode
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from math import ceil, degrees, floor, pi, radians
from textwrap import fill
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rankdrop.distance import Workspace
from rankdrop.families import Slice, Solid, Sweep
from rankdrop.problem import wrap
from rankdrop.robot import Array, Robot
from rankdrop.text import joint_symbol

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#B07D00", "#56B4E9", "#6B6B6B", "#7A4FB5")
"""Of the families, after Okabe and Ito; on pages --f1 … --f8."""
LOOKS = {
    "s0": (COLOURS[1], 1.7), "s1": (COLOURS[0], 1.0), "pass": (COLOURS[1], 1.0), "wall": ("black", 1.0),
    **{f"f{k}": (tone, 1.8) for k, tone in enumerate(COLOURS, start=1)},
}  # fmt: skip
"""Look of a mark: class on a page -> colour and width of line for papers; f1 … f8 are those of the families."""
Ticks = Sequence[tuple[float, str]]
Mark = tuple[Sequence[Array], str, float, str]
"""Lines (N, 2), one of `LOOKS`, radius of dots at their points (0: a curve), label."""
_STRAIGHT = 0.15  # a vertex this near the line between its neighbours is left out [pixel]
_SMALL = 130.0  # width of a chart of σ
_MANY = 500  # dots from which on a paper's file holds them as an image

_DOT = 5.0  # smallest marker of a legend [point]
_WIDE = 26  # characters of a line of a legend


def look_of(index: int) -> str:
    """The look of a family, by the number of its colour."""
    return f"f{1 + index % len(COLOURS)}"


@dataclass(frozen=True, eq=False)
class Chart:
    """Two axes and what is drawn between them.

    Attributes:
        x, y: ranges of the data.
        marks: curves and dots.
        names: at the axes.
        ticks: along the axes, (value, word).
        image: (a, b) map of darkness from 0 to 1, x along the first index, over the whole plot.
        at: place of a vertical line.
        title: above.
        size: width and height of the plot on a page, in pixels.
        margins: left, bottom, top, right.
    """

    x: tuple[float, float]
    y: tuple[float, float]
    marks: Sequence[Mark] = ()
    names: tuple[str, str] = ("", "")
    ticks: tuple[Ticks, Ticks] = ((), ())
    image: Array | None = None
    at: float | None = None
    title: str = ""
    size: tuple[float, float] = (320, 320)
    margins: tuple[float, float, float, float] = (44, 40, 8, 10)

    def place(self, points: Array) -> Array:
        """(N, 2) data to user units of the SVG."""
        (width, height), (left, _, top, _) = self.size, self.margins
        x = left + (points[:, 0] - self.x[0]) / (self.x[1] - self.x[0]) * width
        y = top + (self.y[1] - points[:, 1]) / (self.y[1] - self.y[0]) * height
        return np.stack([x, y], axis=1)

    def svg(self, seen: str, more: Iterable[str] = ()) -> str:
        """The chart as SVG.

        Args:
            seen: what it shows, for readers who do not see it.
            more: elements drawn above all others.
        """
        (width, height), (left, bottom, top, right) = self.size, self.margins
        box = f'x="{left}" y="{top}" width="{width:g}" height="{height:g}"'
        if self.image is None:
            parts = []
        else:
            parts = [_image(self.image, box)]
        parts += [f'<rect class="frame" {box}/>', *self._ticks()]
        middles = (f'x="{left + width / 2:g}" y="{top + height + 34:g}"',
                   f'transform="translate(12 {top + height / 2:g}) rotate(-90)"')  # fmt: skip
        words = [*zip(self.names, middles, strict=True), (self.title, f'x="{left + width / 2:g}" y="11"')]
        parts += [f'<text class="name" text-anchor="middle" {where}>{escape(word)}</text>'
                  for word, where in words if word]  # fmt: skip
        parts += [self._mark(*mark[:3]) for mark in self.marks]
        if self.at is not None:
            parts.append(f'<path class="here" d="{_moves(self.place(np.array([[self.at, y] for y in self.y])))}"/>')
        wide, high = left + width + right, top + height + bottom
        return (
            f'<svg viewBox="0 0 {wide:g} {high:g}" style="max-width:{1.15 * wide:.0f}px" role="img" '
            f'aria-label="{escape(seen)}">{"".join(parts)}{"".join(more)}</svg>'
        )

    def _ticks(self) -> Iterable[str]:
        (width, height), (left, _, top, _) = self.size, self.margins
        low, right = top + height, left + width
        for value, word in self.ticks[0]:
            x = _n(self.place(np.array([[value, self.y[0]]]))[0, 0])
            yield (f'<line class="tick" x1="{x}" x2="{x}" y1="{top}" y2="{low + 4}"/>'
                   f'<text x="{x}" y="{low + 16}" text-anchor="middle">{escape(word)}</text>')  # fmt: skip
        for value, word in self.ticks[1]:
            y = self.place(np.array([[self.x[0], value]]))[0, 1]
            yield (f'<line class="tick" x1="{left - 4}" x2="{right}" y1="{_n(y)}" y2="{_n(y)}"/>'
                   f'<text x="{left - 7}" y="{_n(y + 4)}" text-anchor="end">{escape(word)}</text>')  # fmt: skip

    def _mark(self, lines: Sequence[Array], look: str, radius: float) -> str:
        if look.startswith("f"):
            style = f' style="stroke:var(--{look})"'
        else:
            style = ""
        css = "" if style else look
        places = [self.place(line) for line in lines if len(line)]
        if radius:
            text = "".join(f"M{_n(x)} {_n(y)}h0" for points in places for x, y in points)
            if text:
                return f'<path class="dots {css}" stroke-width="{2 * radius:g}"{style} d="{text}"/>'
            return ""
        text = "".join(_moves(_thin_vertices(points)) for points in places)
        if text:
            return f'<path class="{css or "curve"}"{style} d="{text}"/>'
        return ""

    def draw(self, axes: Any) -> None:
        """Draw the chart on axes of matplotlib, its legend at the right of them."""
        if self.image is not None:
            axes.imshow(self.image.T, origin="lower", extent=(*self.x, *self.y), cmap="Greys", vmin=0, vmax=1,
                        aspect="auto")  # fmt: skip
        for mark in self.marks:
            _draw_mark(axes, *mark)
        if self.at is not None:
            axes.axvline(self.at, color="black", lw=0.7, ls=":")
        axes.set(xlim=self.x, ylim=self.y, xlabel=self.names[0], ylabel=self.names[1])
        axes.set_title(self.title, fontsize=8, pad=2)
        for ticks, set_ticks in zip(self.ticks, (axes.set_xticks, axes.set_yticks), strict=True):
            set_ticks([value for value, _ in ticks], [word for _, word in ticks])
        if any(label for *_, label in self.marks):
            legend_outside(axes)


def legend_outside(axes: Any) -> None:
    """A legend at the right of axes of matplotlib, where it covers no data, its dots as large as those of curves."""
    legend = axes.legend(fontsize=7, loc="upper left", bbox_to_anchor=(1.02, 1.0), borderaxespad=0.0, frameon=False)
    for handle in legend.legend_handles:
        handle.set_markersize(max(handle.get_markersize(), _DOT))


def _draw_mark(axes: Any, lines: Sequence[Array], look: str, radius: float, label: str) -> None:
    colour, width = LOOKS[look]
    if radius:
        style = {"ls": "", "marker": "o", "mew": 0, "ms": 1.6 * radius}
    else:
        style = {"lw": width}
    for line in lines:
        axes.plot(*line.T, color=colour, rasterized=len(line) > _MANY, **style)
    if label and lines:
        axes.lines[-1].set_label(fill(label, _WIDE))


def joint_axes(robot: Robot, joints: Sequence[int], ends: Sequence[tuple[float, float]]) -> tuple[Any, Any]:
    """Names and ticks of axes along which joints (numbers from 1) move between some ends."""
    chosen = [robot.variables[number - 1] for number in joints]
    names = tuple(axis_name(joint_symbol(number, str(joint.kind)), joint.unit)
                  for number, joint in zip(joints, chosen, strict=True))  # fmt: skip
    ticks = tuple((angle_ticks if joint.unit == "rad" else plain_ticks)(*end)
                  for joint, end in zip(chosen, ends, strict=True))  # fmt: skip
    return names, ticks


def slice_chart(robot: Robot, plane: Slice, colours: dict[str, int], labels: dict[str, str]) -> Chart:
    """σ_r as a grey map (dark: small), the families as curves and dots, with their id and label."""
    ends = ((plane.x[0], plane.x[-1]), (plane.y[0], plane.y[-1]))
    names, ticks = joint_axes(robot, plane.joints, ends)
    marks: list[Mark] = []
    for trace in plane.traces:
        look, label = look_of(colours[trace.family]), f"{trace.family} {labels[trace.family]}"
        marks.append((trace.curves, look, 0.0, label if trace.curves else ""))
        if len(trace.points):
            marks.append(([trace.points], look, 4.0, "" if trace.curves else label))
    dark = 0.75 * (1 - plane.sigma[::2, ::2] / max(float(plane.sigma.max()), 1e-12)) ** 3
    return Chart(*ends, marks, names, ticks, dark)


def projections(robot: Robot, solid: Solid, index: int) -> list[Chart]:
    """Curves in the cube of three joints seen along each axis (AM Figure 5a)."""
    ends = (-pi * 1.04, pi * 1.04)
    charts = []
    for a, b in ((0, 1), (1, 2), (0, 2)):
        names, ticks = joint_axes(robot, [solid.joints[a], solid.joints[b]], [ends, ends])
        lines = [piece[:, [a, b]] for line in solid.curves for piece in pieces(line)]
        charts.append(Chart(ends, ends, [(lines, look_of(index), 0.0, "")], names, ticks, size=(250, 250)))
    return charts


def pieces(line: Array) -> list[Array]:
    """A curve that runs on past ±π, cut and brought back into the cube."""
    inside = wrap(line)
    jumps = np.flatnonzero((np.abs(np.diff(inside, axis=0)) > pi).any(axis=1)) + 1
    return [piece for piece in np.split(inside, jumps) if len(piece) > 1]


def workspace_chart(section: Workspace, size: float, family: str = "", index: int = 0, label: str = "") -> Chart:
    """Where the tip can be (grey), with the walls as dots, or the image of one family with its id and label."""
    x, y = ((float(edges[0]), float(edges[-1])) for edges in (section.x, section.y))
    wide, high = size * np.array([x[1] - x[0], y[1] - y[0]]) / max(x[1] - x[0], y[1] - y[0])
    few = [max(2, round(side / 70)) for side in (wide, high)]
    most = max(float(np.quantile(section.tips[section.tips > 0], 0.95)) if (section.tips > 0).any() else 1.0, 1.0)
    dark = np.where(section.tips > 0, 0.12 + 0.33 * np.minimum(section.tips / most, 1.0) ** 0.5, 0.0)
    passed, barred = section.walls[~section.one_sided], section.walls[section.one_sided]
    marks: list[Mark] = [([passed], "pass", 0.9, "passed in another posture"), ([barred], "wall", 1.1, "not crossed")]
    if family:
        marks = [([dict(section.images)[family]], look_of(index), 1.0, f"{family} {label}".strip())]
    ticks = (plain_ticks(*x, few[0]), plain_ticks(*y, few[1]))
    return Chart(x, y, marks, section.section.labels, ticks, dark, size=(float(wide), float(high)))


def sweep_chart(robot: Robot, sweep: Sweep, corank: int) -> Chart:
    """σ_r (bold) and the next ones as one joint moves; the dashed line is the witness."""
    shown = sweep.sigma[:, ::-1][:, : corank + 1 if corank > 1 else 2]
    high, x = max(float(shown.max()) * 1.05, 1e-9), (float(sweep.values[0]), float(sweep.values[-1]))
    words = ("−180°", "180°") if robot.periodic[sweep.number - 1] else tuple(f"{value:.2g}" for value in x)
    marks: list[Mark] = [
        ([np.stack([sweep.values, shown[:, k]], axis=1)], "s0" if k < corank else "s1", 0.0, "")
        for k in range(shown.shape[1] - 1, -1, -1)
    ]
    return Chart(
        x, (0.0, high), marks, ticks=(tuple(zip(x, words, strict=True)), ((high, f"{high:.2g}"),)), at=sweep.at,
        title=joint_symbol(sweep.number, str(robot.variables[sweep.number - 1].kind)),
        size=(_SMALL, 0.62 * _SMALL), margins=(36, 20, 16, 16),
    )  # fmt: skip


def angle_ticks(low: float, high: float) -> list[tuple[float, str]]:
    """Angles inside a range [rad], in degrees: multiples of 90° where it is wide, else round numbers."""
    if high - low < pi:
        return [(radians(value), f"{word}°") for value, word in plain_ticks(degrees(low), degrees(high))]
    quarters = range(ceil(low / (pi / 2) - 1e-9), floor(high / (pi / 2) + 1e-9) + 1)
    return [(k * pi / 2, f"{90 * k}°".replace("-", "−")) for k in quarters]


def axis_name(symbol: str, unit: str) -> str:
    """What stands at an axis: angles have their unit at the ticks."""
    if unit == "rad":
        return symbol
    return f"{symbol} [{unit}]"


def plain_ticks(low: float, high: float, about: int = 5) -> list[tuple[float, str]]:
    """Round numbers inside a range."""
    raw = (high - low) / about
    power = 10.0 ** np.floor(np.log10(raw))
    step = power * min((1, 2, 5, 10), key=lambda m: abs(m * power - raw))
    values = np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step
    return [(float(value), f"{value:.6g}".replace("-", "−")) for value in values + 0.0]


def _moves(points: Array) -> str:
    if len(points) > 1:
        return "M" + "L".join(f"{_n(x)} {_n(y)}" for x, y in points)
    return ""


def _thin_vertices(points: Array) -> Array:
    """Vertices that the eye does not miss are left out: those on the line between their neighbours."""
    while len(points) > 2:
        a, b, c = points[:-2], points[1:-1], points[2:]
        way = c - a
        area = np.abs(way[:, 0] * (b - a)[:, 1] - way[:, 1] * (b - a)[:, 0])
        straight = area <= _STRAIGHT * np.maximum(np.linalg.norm(way, axis=1), 1e-9)
        straight[1::2] = False
        if not straight.any():
            break
        points = points[np.concatenate([[True], ~straight, [True]])]
    return points


def _n(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0")


def _image(alpha: Array, box: str) -> str:
    data = b64encode(_png(alpha)).decode()
    return f'<image {box} preserveAspectRatio="none" href="data:image/png;base64,{data}"/>'


def _png(alpha: Array) -> bytes:
    """A grey-blue image whose opacity is the map, as PNG: grey with alpha, eight bits."""
    opacity: NDArray[np.uint8] = np.clip(np.round(255 * alpha.T[::-1]), 0, 255).astype(np.uint8)
    rows = np.zeros((opacity.shape[0], 1 + 2 * opacity.shape[1]), dtype=np.uint8)
    rows[:, 1::2] = 125
    rows[:, 2::2] = opacity
    header = struct.pack(">IIBBBBB", opacity.shape[1], opacity.shape[0], 8, 4, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 9)), (b"IEND", b""))
    body = b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks
    )
    return b"\x89PNG\r\n\x1a\n" + body
