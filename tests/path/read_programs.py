"""Programs written and checked, their moves and skipped lines by line, and rotations about axes of the base."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rankdrop.path.check.path_file import PathQuestion
from rankdrop.path.check.program import ProgramCheck, check_any_file
from rankdrop.path.read.program_record import Move, Program
from rankdrop.questions import PathOptions
from rankdrop.robot.model import Array, Robot


def written(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def checked(
    robot: Robot, path: Path, *, at_tool_point: bool = False, task: str | None = None, start: Array | None = None
) -> ProgramCheck:
    question = PathQuestion(task, None, PathOptions(), at_tool_point=at_tool_point, start=start)
    found = check_any_file(robot, path, question)
    assert isinstance(found, ProgramCheck)
    return found


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
