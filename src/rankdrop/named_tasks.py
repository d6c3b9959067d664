"""Frames, and the tasks that have a name: without NumPy, for the help of the command line."""

from __future__ import annotations

from dataclasses import dataclass

BASE = 0
TIP = -1

ROWS = ("vx", "vy", "vz", "wx", "wy", "wz")


@dataclass(frozen=True, slots=True)
class Frame:
    """Axes of one link, reference point fixed in one link.

    Attributes:
        axes: link whose axes are used: 0 the base, i the link after joint i (`Joint.frame`), TIP the tip.
        origin: link that carries the reference point.
        point: (3,) the reference point in that link's frame [m].
    """

    axes: int = BASE
    origin: int = TIP
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)


SPACE = Frame(BASE, BASE)
"""Base axes, reference point at the base origin: the columns are the joint screws themselves."""
BODY = Frame(TIP, TIP)
"""Axes and origin of the tip."""
WORLD_ALIGNED = Frame(BASE, TIP)
"""Base axes, reference point at the tip: the default."""


NAMED: dict[str, tuple[tuple[int, ...], Frame]] = {
    "pose": ((0, 1, 2, 3, 4, 5), WORLD_ALIGNED),
    "position": ((0, 1, 2), WORLD_ALIGNED),
    "orientation": ((3, 4, 5), WORLD_ALIGNED),
    "planar": ((0, 1, 5), WORLD_ALIGNED),
    "planar-position": ((0, 1), WORLD_ALIGNED),
    "scara": ((0, 1, 2, 5), WORLD_ALIGNED),
    "tool-axis-free": ((0, 1, 2, 3, 4), BODY),
    "across-tool-axis": ((0, 1), BODY),
}
"""Name -> its rows, and the frame they are taken in. A line here is all that a new task takes (and docs/choose.md)."""


def task_names() -> tuple[str, ...]:
    """The tasks that have a name."""
    return tuple(NAMED)
