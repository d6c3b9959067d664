"""Moves and skipped lines of a program by line, and rotations about axes of the base."""

from __future__ import annotations

import numpy as np

from rankdrop.path.read.program_record import Move, Program


def about(axis: str, degrees: float) -> np.ndarray:
    """Rotation about an axis of the base, from the images of the unit vectors."""
    c, s = np.cos(np.pi * degrees / 180), np.sin(np.pi * degrees / 180)
    rows = {"x": [[1, 0, 0], [0, c, -s], [0, s, c]], "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
            "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]]}  # fmt: skip
    return np.array(rows[axis])


def moves(program: Program) -> dict[int, Move]:
    return {one.line: one for one in program.moves}


def skipped(program: Program) -> dict[int, str]:
    return {one.line: str(one.reason) for one in program.skipped}
