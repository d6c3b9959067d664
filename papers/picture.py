"""What a figure is made of, before anybody draws it: arrays that tests can check and that go to a file as they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.local import Drawn, drawn_at
from rankdrop.robot import Array, Robot, reach

BLUE, RED, GREEN, BLACK, GREY, ORANGE = "#0072B2", "#D55E00", "#009E73", "#222222", "#777777", "#E69F00"
"""Okabe and Ito's colours, which stay apart for colour-blind eyes and in print; AM's blue, red and green."""


@dataclass(frozen=True, eq=False)
class Line:
    """One line of a plot, or in space.

    Attributes:
        label: for the legend; empty for none.
        points: (N, 2) or (N, 3); NaN breaks the line.
        colour, dashes: how it looks; dashes as matplotlib has them ("-", ":", "--").
        marks: draw its points as well.
    """

    label: str
    points: Array
    colour: str = BLUE
    dashes: str = "-"
    marks: bool = False


@dataclass(frozen=True, eq=False)
class Arrow:
    """A direction in space: solid for a translation, dotted for a rotation, as AM draw them.

    Attributes:
        label: "u6", …
        start, vector: (3,) [m; unit vectors are drawn at the length of the panel].
        rotation: dotted.
        colour: of the arrow.
    """

    label: str
    start: Array
    vector: Array
    rotation: bool
    colour: str


@dataclass(frozen=True, eq=False)
class Arm:
    """A robot at a configuration, drawn with its links, joints and axes.

    Attributes:
        robot: its name.
        q: (n,) configuration [rad, m].
        drawn: where its links and joints are.
        size: its reach, to which everything is drawn in proportion [m].
        marked: numbers of joints in another colour.
    """

    robot: str
    q: Array
    drawn: Drawn
    size: float
    marked: tuple[int, ...] = ()

    def to_dict(self) -> dict[str, object]:
        """Plain data."""
        rows = zip(self.drawn.numbers, self.drawn.slides, self.drawn.middles, self.drawn.axes, strict=True)
        return {
            "robot": self.robot, "q": plain(self.q), "links": plain(self.drawn.links),
            "joints": [
                {"number": number, "kind": "prismatic" if slides else "revolute", "point": plain(at),
                 "axis": plain(axis), "marked": number in self.marked}
                for number, slides, at, axis in rows
            ],
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class Panel:
    """One subplot, in the plane or in space.

    Attributes:
        title, x, y, z: labels; z is empty in the plane.
        lines, arrows: what is in it.
        log: logarithmic axes, out of "x", "y".
        level: a horizontal line.
        span: ends of the vertical axis, in the plane; None for those of what is drawn.
        tall: same scale along all axes.
        arms: robots in it.
        view: elevation and azimuth of the eye [deg].
    """

    title: str
    lines: tuple[Line, ...]
    arrows: tuple[Arrow, ...] = ()
    x: str = "x [m]"
    y: str = "y [m]"
    z: str = ""
    log: str = ""
    level: float | None = None
    span: tuple[float, float] | None = None
    tall: bool = False
    arms: tuple[Arm, ...] = ()
    view: tuple[float, float] = (24.0, -60.0)

    def to_dict(self) -> dict[str, object]:
        """Plain data, NaN as null."""
        return {
            "title": self.title,
            "axes": [name for name in (self.x, self.y, self.z) if name],
            "level": self.level,
            "arms": [arm.to_dict() for arm in self.arms],
            "lines": [{"label": line.label, "points": plain(line.points)} for line in self.lines],
            "arrows": [
                {"label": a.label, "start": plain(a.start), "vector": plain(a.vector), "rotation": a.rotation}
                for a in self.arrows
            ],
        }


@dataclass(frozen=True, eq=False)
class Picture:
    """One figure.

    Attributes:
        document: short name.
        name: "Figure 5", …
        caption: what it shows, and what is ours in it.
        panels: subplots.
        numbers: further data that belong to it, by name.
    """

    document: str
    name: str
    caption: str
    panels: tuple[Panel, ...]
    numbers: dict[str, object] = field(default_factory=dict)

    @property
    def file(self) -> str:
        """Name of its files without ending: "AM-figure-5"."""
        return f"{self.document}-{self.name.lower().replace(' ', '-')}"

    def to_dict(self) -> dict[str, object]:
        """Plain data."""
        return {
            "document": self.document, "figure": self.name, "caption": self.caption,
            "panels": [panel.to_dict() for panel in self.panels], **self.numbers,
        }  # fmt: skip


def arm_at(robot: Robot, q: ArrayLike, marked: Sequence[int] = ()) -> Arm:
    """A robot to be drawn at q."""
    place = np.asarray(q, dtype=np.float64)
    return Arm(robot.name, place, drawn_at(robot, place), reach(robot), tuple(marked))


def plain(values: ArrayLike) -> object:
    """An array as lists, NaN as None, nine digits."""
    array = np.asarray(values, dtype=np.float64)
    if array.ndim > 1:
        return [plain(row) for row in array]
    return [None if np.isnan(x) else float(f"{x:.9g}") for x in np.atleast_1d(array)]


def against(x: ArrayLike, y: ArrayLike) -> Array:
    """(N, 2) points."""
    return np.column_stack([np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)])


def arrows(tip: Array, directions: Sequence[Array], names: Sequence[str], colours: Sequence[str]) -> tuple[Arrow, ...]:
    """Arrows of lost directions (v; ω) at a point: a solid one for v, a dotted one for ω, where they are not zero."""
    made = []
    for direction, name, colour in zip(directions, names, colours, strict=True):
        for part, rotation in ((direction[:3], False), (direction[3:], True)):
            if np.linalg.norm(part) > 1e-6:
                made.append(Arrow(name, tip, part, rotation, colour))
    return tuple(made)
