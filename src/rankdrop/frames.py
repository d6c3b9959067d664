"""Frames of the chain: whose axes a twist is written in, and at which point its linear part is taken."""

from __future__ import annotations

from dataclasses import dataclass

from rankdrop.errors import TaskError

BASE = 0
TIP = -1


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


def link_index(link: int, joints: int, what: str) -> int:
    """Link number in 0 … joints + 1 (the last is the tip), from a number or TIP.

    Raises:
        TaskError: there is no such link.
    """
    if link == TIP:
        return joints + 1
    if 0 <= link <= joints:
        return link
    raise TaskError(f"there is no such link for the {what} of a frame", got=link, allowed=f"0 … {joints}, or TIP")
