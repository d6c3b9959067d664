"""A bent arm."""

from __future__ import annotations

from rankdrop.robot.dh import DHRow, from_dh
from rankdrop.robot.model import Robot


def bent() -> Robot:
    """A planar arm whose second joint stands at −0.4 where the arm is stretched."""
    table = [DHRow(a=0.3), DHRow(a=0.2, theta=0.4), DHRow(a=0.1)]
    return from_dh(table, convention="standard", name="bent")
