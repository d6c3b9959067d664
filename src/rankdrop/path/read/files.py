"""Joint trajectories from files of every kind read, by their endings; and one written, to the last bit."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from rankdrop.disk import is_endless
from rankdrop.errors import OptionError, RankdropError
from rankdrop.path.read.arrays import read_arrays
from rankdrop.path.read.csv_file import csv_text, parse_trajectory
from rankdrop.path.read.messages import ENTRIES, OBJECTS, parse_message
from rankdrop.path.read.program_record import PROGRAMS, SYSTEM_PROGRAMS, is_program
from rankdrop.path.read.trajectory import BAGS, Trajectory, TrajectoryError, is_bag
from rankdrop.robot.files import read_text
from rankdrop.robot.model import Array, Robot

ENDINGS = (".csv", ".tsv", ".txt", ".npy", ".npz", ".json", ".yaml", ".yml", *BAGS,
           *(ending for ending in PROGRAMS if ending not in SYSTEM_PROGRAMS))  # fmt: skip
"""Files that are taken for paths in a folder; a single file of another ending is read as CSV."""
WRITTEN = (".csv", ".npz", ".json")
"""Endings of files that are written."""


def trajectories_in(folder: Path) -> list[Path]:
    """Files of these endings, and folders of ROS 2 recordings, sorted."""
    inside = (path for path in folder.iterdir() if is_bag(path) or (path.suffix.lower() in ENDINGS and path.is_file()))
    return sorted(inside)


def read_trajectory(
    path: str | Path, robot: Robot, *, deg: bool = False, topic: str | None = None
) -> Trajectory:
    """A trajectory from a file, by its ending: .npy and .npz, .json, .yaml and .yml, bags, everything else is CSV.

    Args:
        path: the file, or the folder of a ROS 2 recording.
        robot: whose joints they are, by name; see the module of each kind.
        deg: angles without a unit are in degrees.
        topic: of a bag; None where one topic alone has joint values.

    Raises:
        TrajectoryError: with file, row or line, and column.
        OptionError: a topic of a file that is no bag.
        MissingExtraError: YAML, or a bag, and PyYAML or rosbags is not installed.
    """
    file, name = Path(path), str(path)
    if is_endless(file):
        raise TrajectoryError("this is not a file", where=name, got="a pipe or a device")
    if is_bag(file):
        from rankdrop.path.read.bag_file import read_bag

        return read_bag(file, robot, topic=topic, deg=deg)
    if topic is not None and file.exists():  # a file that is missing is reported first
        raise OptionError("only a bag has topics", where=name, got=topic, allowed=", ".join(BAGS))
    if is_program(file) and file.exists():
        raise TrajectoryError("this is a robot program, and `rankdrop path` alone reads programs", where=name,
                              allowed="a file of joint values")  # fmt: skip
    ending = file.suffix.lower()
    if ending in (".npy", ".npz"):
        return replace(read_arrays(file, robot, deg=deg), bare=True)
    text = text_of_file(file)
    if ending in OBJECTS:
        return parse_message(text, name, robot, yaml=ending != ".json", deg=deg)
    return parse_trajectory(text, name, robot, deg=deg)


def text_of_file(file: Path) -> str:
    """The text of a file, with its errors as those of a trajectory."""
    try:
        return read_text(file)
    except RankdropError as error:
        raise TrajectoryError(error.what, where=error.where or str(file), got=error.got) from error


def trajectory_bytes(made: Trajectory, robot: Robot, target: str) -> bytes:
    """The content of a file, by its ending: CSV with joints by name and unit, NumPy's archive, JSON of a message.

    Args:
        made: the trajectory.
        robot: whose joints they are.
        target: the file's name.

    Raises:
        OptionError: no such ending, or CSV for a trajectory with velocities.
    """
    ending = Path(target).suffix.lower()
    names, times = [joint.name for joint in robot.variables], made.times if made.timed else None
    if ending == ".csv":
        if made.velocities is not None:
            raise OptionError("a CSV file holds no velocities", where=target, got="cubics or quintics between rows",
                              allowed=".npz, .json")  # fmt: skip
        heads = [f"{joint.name} [{joint.unit}]" for joint in robot.variables]
        return csv_text(heads, made.q, times).encode()
    columns = {"q": made.q, "qd": made.velocities, "qdd": made.accelerations, "t": times}
    given = {key: values for key, values in columns.items() if values is not None}
    if ending == ".npz":
        buffer = io.BytesIO()
        np.savez(buffer, joint_names=np.array(names), **given)  # type: ignore[arg-type]  # allow_pickle is no array
        return buffer.getvalue()
    if ending == ".json":
        return _message_bytes(names, given)
    raise OptionError("the ending names no format", where=target, allowed=", ".join(WRITTEN))


def _message_bytes(names: list[str], columns: Mapping[str, Array]) -> bytes:
    """A JointTrajectory message as JSON, from its columns q, qd, qdd and t."""
    words = [(ENTRIES | {"t": "time_from_start"})[key] for key in columns]
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    points = [dict(zip(words, row, strict=True)) for row in rows]
    return (json.dumps({"joint_names": names, "points": points}, indent=1) + "\n").encode()
