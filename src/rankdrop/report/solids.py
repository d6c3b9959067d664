"""What drawings of arms are made of, for matplotlib: joints as cylinders and boxes, axes, arrows with heads."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from rankdrop.local import Drawn, arrow_of, ring_about
from rankdrop.robot import Array

LINK, BODY, AXIS, MARKED = "#7C8B9B", "#4F6073", "#A9B4C0", "#E07B00"
_RADIUS, _HALF, _APART = 0.035, 0.045, 0.11
"""Of a joint's body, and how far joints of one place are drawn from it along their axes; lengths per size."""
_HEAD, _WIDTH, _SIDES = 0.075, 0.026, 16
"""Of an arrow head, per size."""


def draw_arm(axes: Any, drawn: Drawn, size: float, marked: Sequence[int] = (), long: float = 0.09) -> None:
    """An arm on axes in space: its links, a body for each joint, its axis as a line with its number.

    Joints whose axes meet in one point are drawn apart on their axes.

    Args:
        axes: of matplotlib, with projection="3d".
        drawn: the arm.
        size: length that everything is drawn in proportion to, such as the reach [m].
        marked: numbers of joints that are drawn in another colour, with longer axes.
        long: how far axes stand out of their joints, per size.
    """
    axes.set_autoscale_on(False)  # whoever draws sets the limits
    axes.plot(*drawn.links.T, color=LINK, lw=4, solid_capstyle="round", solid_joinstyle="round")
    places = spread_out(drawn, _APART * size)
    for place, middle, axis, slides, number in zip(
        places, drawn.middles, drawn.axes, drawn.slides, drawn.numbers, strict=True
    ):
        tone = MARKED if number in marked else BODY
        if np.any(place != middle):
            axes.plot(*np.stack([middle, place]).T, color=LINK, lw=2.5)
        _add(axes, prism(place, axis, _RADIUS * size, _HALF * size, 4 if slides else _SIDES), tone)
        reached = (_HALF + (0.28 if number in marked else long)) * size
        line = np.stack([place - reached * axis, place + reached * axis])
        axes.plot(*line.T, color=MARKED if number in marked else AXIS, lw=1.1, ls="-.")
        axes.text(*(place + (reached + 0.03 * size) * axis), str(number), fontsize=7, zorder=1000,
                  color=MARKED if number in marked else "black")  # fmt: skip


def draw_arrow(axes: Any, start: Array, vector: Array, colour: str, size: float, *, dotted: bool = False,
               label: str | None = None) -> None:  # fmt: skip
    """An arrow in space: its shaft solid or dotted, its head a cone of a size that does not depend on its length."""
    start, end = np.asarray(start, dtype=np.float64), np.asarray(start + vector, dtype=np.float64)
    along = vector / np.linalg.norm(vector)
    axes.plot(*np.stack([start, end - 0.9 * _HEAD * size * along]).T, color=colour, lw=2.0, ls=":" if dotted else "-",
              label=label)  # fmt: skip
    _add(axes, cone(end, along, _WIDTH * size, _HEAD * size), colour)


def draw_lost(axes: Any, at: Array, direction: Array, colour: str, size: float, long: float) -> Array:
    """One lost freedom as one arrow with its ring, as `rankdrop.local.arrow_of` makes it; (3,) where it ends.

    Args:
        axes: of matplotlib, with projection="3d".
        at: (3,) the reference point [m].
        direction: (6,) (v; ω) in the base frame.
        colour, size: as for `draw_arrow`.
        long: of an arrow of length one [m].
    """
    arrow, axis, turns = arrow_of(direction)
    if axis.any():
        axes.plot(*(at + long * ring_about(axis)).T, color=colour, lw=1.3, zorder=900)
    draw_arrow(axes, at, long * arrow, colour, size, dotted=turns)
    return np.asarray(at + long * arrow)


def spread_out(drawn: Drawn, apart: float) -> Array:
    """(N, 3) where joints are drawn: those that share a point go apart on their axes, the first back, the last on."""
    places = drawn.middles.copy()
    first = 0
    while first < len(places):
        last = first
        while last + 1 < len(places) and np.linalg.norm(places[last + 1] - drawn.middles[first]) < 0.5 * apart:
            last += 1
        if last > first:
            places[first] -= apart * drawn.axes[first]
        if last > first + 1:
            places[last] += apart * drawn.axes[last]
            if np.linalg.norm(places[last] - places[first]) < 0.5 * apart:  # axes that point against each other
                places[last] += apart * drawn.axes[last]
        first = last + 1
    return places


def prism(middle: Array, axis: Array, radius: float, half: float, sides: int) -> Array:
    """(F, 4, 3) faces of a prism of so many sides along an axis; many sides are a cylinder."""
    ring = _ring(axis, radius, sides)
    low, high = middle - half * axis, middle + half * axis
    below, above = low + ring, high + ring
    sheath = np.array([[below[k - 1], below[k], above[k], above[k - 1]] for k in range(sides)])
    return np.concatenate([sheath, _fan(low, below), _fan(high, above)])


def cone(tip: Array, axis: Array, radius: float, long: float) -> Array:
    """(F, 4, 3) faces of a cone that points along an axis."""
    foot = tip - long * axis
    ring = foot + _ring(axis, radius, _SIDES)
    return np.concatenate([_fan(tip, ring), _fan(foot, ring)])


def _fan(point: Array, ring: Array) -> Array:
    """(F, 4, 3) triangles from a point to the sides of a ring, the last corner twice: all faces have four."""
    return np.array([[point, ring[k - 1], ring[k], ring[k]] for k in range(len(ring))])


def _ring(axis: Array, radius: float, sides: int) -> Array:
    """(sides, 3) points of a circle about the origin, square to an axis."""
    across = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    across /= np.linalg.norm(across)
    turn = 2 * np.pi * (np.arange(sides) + 0.5)[:, None] / sides
    return np.asarray(radius * (np.cos(turn) * across + np.sin(turn) * np.cross(axis, across)))


def _add(axes: Any, faces: Array, colour: str) -> None:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    axes.add_collection3d(Poly3DCollection(faces, facecolors=colour, shade=True))
