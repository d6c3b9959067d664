"""Charts as SVG: axes, curves, dots, and grey maps as images. Colours come from the page's style."""

from __future__ import annotations

import struct
import zlib
from base64 import b64encode
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from math import ceil, degrees, floor, pi, radians

import numpy as np
from numpy.typing import NDArray

from rankdrop.robot import Array

_STRAIGHT = 0.15  # a vertex this near the line between its neighbours is left out [pixel]


@dataclass(frozen=True, slots=True)
class Chart:
    """A rectangle of the page with two axes.

    Attributes:
        x, y: ranges of the data.
        width, height: of the plot in user units.
        left, bottom, top, right: margins.
    """

    x: tuple[float, float]
    y: tuple[float, float]
    width: float = 320
    height: float = 320
    left: float = 44
    bottom: float = 40
    top: float = 8
    right: float = 10

    def place(self, points: Array) -> Array:
        """(N, 2) data to user units."""
        x = self.left + (points[:, 0] - self.x[0]) / (self.x[1] - self.x[0]) * self.width
        y = self.top + (self.y[1] - points[:, 1]) / (self.y[1] - self.y[0]) * self.height
        return np.stack([x, y], axis=1)

    def path(self, lines: Iterable[Array], css: str, style: str = "") -> str:
        """Polylines as one path."""
        text = "".join(_moves(_thinned(self.place(line))) for line in lines)
        return f'<path class="{css}"{_style(style)} d="{text}"/>' if text else ""

    def dots(self, points: Array, css: str, radius: float, style: str = "") -> str:
        """Points as round dots of one path."""
        if not len(points):
            return ""
        text = "".join(f"M{_n(x)} {_n(y)}h0" for x, y in self.place(points))
        return f'<path class="dots {css}" stroke-width="{2 * radius:g}"{_style(style)} d="{text}"/>'

    def upright(self, x: float, css: str) -> str:
        """A vertical line."""
        at = self.place(np.array([[x, self.y[0]]]))[0, 0]
        return f'<line class="{css}" x1="{_n(at)}" x2="{_n(at)}" y1="{self.top}" y2="{self.top + self.height}"/>'

    def image(self, alpha: Array) -> str:
        """A map (a, b) of darkness from 0 to 1, x along the first index, over the whole plot."""
        data = b64encode(_png(alpha)).decode()
        return (
            f'<image x="{self.left}" y="{self.top}" width="{self.width}" height="{self.height}" '
            f'preserveAspectRatio="none" href="data:image/png;base64,{data}"/>'
        )

    def axes(
        self, names: tuple[str, str], ticks: tuple[Sequence[tuple[float, str]], Sequence[tuple[float, str]]]
    ) -> str:
        """Frame, ticks with grid lines, names."""
        bottom, right = self.top + self.height, self.left + self.width
        parts = [f'<rect class="frame" x="{self.left}" y="{self.top}" width="{self.width}" height="{self.height}"/>']
        for value, word in ticks[0]:
            at = _n(self.place(np.array([[value, self.y[0]]]))[0, 0])
            parts.append(f'<line class="tick" x1="{at}" x2="{at}" y1="{self.top}" y2="{bottom + 4}"/>'
                         f'<text x="{at}" y="{bottom + 16}" text-anchor="middle">{escape(word)}</text>')  # fmt: skip
        for value, word in ticks[1]:
            y = self.place(np.array([[self.x[0], value]]))[0, 1]
            parts.append(
                f'<line class="tick" x1="{self.left - 4}" x2="{right}" y1="{_n(y)}" y2="{_n(y)}"/>'
                f'<text x="{self.left - 7}" y="{_n(y + 4)}" text-anchor="end">{escape(word)}</text>'
            )
        return (
            f"{''.join(parts)}"
            f'<text class="name" x="{self.left + self.width / 2}" y="{bottom + 34}" text-anchor="middle">'
            f'{escape(names[0])}</text><text class="name" text-anchor="middle" '
            f'transform="translate(12 {self.top + self.height / 2}) rotate(-90)">{escape(names[1])}</text>'
        )

    def svg(self, parts: Iterable[str], label: str) -> str:
        """The whole picture."""
        width, height = self.left + self.width + self.right, self.top + self.height + self.bottom
        return (
            f'<svg viewBox="0 0 {width:g} {height:g}" style="max-width:{1.15 * width:.0f}px" role="img" '
            f'aria-label="{escape(label)}">{"".join(parts)}</svg>'
        )


def angle_ticks(low: float, high: float) -> list[tuple[float, str]]:
    """Angles inside a range [rad], in degrees: multiples of 90° where it is wide, else round numbers."""
    if high - low < pi:
        return [(radians(value), f"{word}°") for value, word in plain_ticks(degrees(low), degrees(high))]
    quarters = range(ceil(low / (pi / 2) - 1e-9), floor(high / (pi / 2) + 1e-9) + 1)
    return [(k * pi / 2, f"{90 * k}°".replace("-", "−")) for k in quarters]


def axis_name(symbol: str, unit: str) -> str:
    """What stands at an axis: angles have their unit at the ticks."""
    return symbol if unit == "rad" else f"{symbol} [{unit}]"


def plain_ticks(low: float, high: float, about: int = 5) -> list[tuple[float, str]]:
    """Round numbers inside a range."""
    raw = (high - low) / about
    power = 10.0 ** np.floor(np.log10(raw))
    step = power * min((1, 2, 5, 10), key=lambda m: abs(m * power - raw))
    values = np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step
    return [(float(value), f"{value:.6g}".replace("-", "−")) for value in values + 0.0]


def _moves(points: Array) -> str:
    return "M" + "L".join(f"{_n(x)} {_n(y)}" for x, y in points) if len(points) > 1 else ""


def _thinned(points: Array) -> Array:
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


def _style(style: str) -> str:
    return f' style="{style}"' if style else ""


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
