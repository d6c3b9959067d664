"""Trajectory files of every kind."""

from __future__ import annotations

from pathlib import Path

from rankdrop.errors import RankdropError
from rankdrop.motion.array_file import read_arrays
from rankdrop.motion.csv_file import parse_trajectory
from rankdrop.motion.message_file import parse_message
from rankdrop.motion.trajectory import Trajectory, TrajectoryError
from rankdrop.robot.files import read_text
from rankdrop.robot.model import Robot

ENDINGS = (".csv", ".tsv", ".txt", ".npy", ".npz", ".json", ".yaml", ".yml")
"""Files that are taken for trajectories in a folder; a single file of another ending is read as CSV."""


def read_trajectory(path: str | Path, robot: Robot, *, deg: bool = False) -> Trajectory:
    """A trajectory from a file, by its ending: .npy and .npz, .json, .yaml and .yml, everything else is CSV.

    Args:
        path: the file.
        robot: whose joints they are, by name; see the module of each kind.
        deg: angles without a unit are in degrees.

    Raises:
        TrajectoryError: with file, row or line, and column.
        MissingExtraError: YAML, and PyYAML is not installed.
    """
    file, name = Path(path), str(path)
    ending = file.suffix.lower()
    if ending in (".npy", ".npz"):
        return read_arrays(file, robot, deg=deg)
    try:
        text = read_text(file)
    except RankdropError as error:
        raise TrajectoryError(error.what, where=error.where or name, got=error.got) from error
    if ending in (".json", ".yaml", ".yml"):
        return parse_message(text, name, robot, yaml=ending != ".json", deg=deg)
    return parse_trajectory(text, name, robot, deg=deg)
