"""Trajectory files: of every kind read, and one written that is read back to the last bit."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np

from rankdrop.errors import OptionError, RankdropError
from rankdrop.motion.array_file import read_arrays
from rankdrop.motion.bag_file import BAGS, is_bag, read_bag
from rankdrop.motion.csv_file import parse_trajectory
from rankdrop.motion.message_file import parse_message
from rankdrop.motion.trajectory import Trajectory, TrajectoryError
from rankdrop.robot.files import read_text
from rankdrop.robot.model import Robot

ENDINGS = (".csv", ".tsv", ".txt", ".npy", ".npz", ".json", ".yaml", ".yml", *BAGS)
"""Files that are taken for trajectories in a folder; a single file of another ending is read as CSV."""


def trajectories_in(folder: Path) -> list[Path]:
    """Files of these endings, and folders of ROS 2 recordings, sorted."""
    inside = (one for one in folder.iterdir() if is_bag(one) or (one.suffix.lower() in ENDINGS and one.is_file()))
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
    ending = file.suffix.lower()
    if is_bag(file):
        return read_bag(file, robot, topic=topic, deg=deg)
    if topic is not None:
        raise OptionError("only a bag has topics", where=name, got=topic, allowed=", ".join(BAGS))
    if ending in (".npy", ".npz"):
        return read_arrays(file, robot, deg=deg)
    try:
        text = read_text(file)
    except RankdropError as error:
        raise TrajectoryError(error.what, where=error.where or name, got=error.got) from error
    if ending in (".json", ".yaml", ".yml"):
        return parse_message(text, name, robot, yaml=ending != ".json", deg=deg)
    return parse_trajectory(text, name, robot, deg=deg)


WRITTEN = (".csv", ".npz", ".json")
"""Endings of files that are written."""


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
    names = [joint.name for joint in robot.variables]
    if ending == ".csv":
        if made.velocities is not None:
            raise OptionError("a CSV file holds no velocities", where=target, got="cubics or quintics between rows",
                              allowed=".npz, .json")  # fmt: skip
        head = [*(["time"] if made.timed else []), *(f"{joint.name} [{joint.unit}]" for joint in robot.variables)]
        rows = np.column_stack([made.times, made.q]) if made.timed else made.q
        lines = [",".join(head), *(",".join(map(repr, row)) for row in rows.tolist())]
        return ("\n".join(lines) + "\n").encode()
    times = made.times if made.timed else None
    columns = {"q": ("positions", made.q), "qd": ("velocities", made.velocities),
               "qdd": ("accelerations", made.accelerations), "t": ("time_from_start", times)}
    given = {key: (word, values) for key, (word, values) in columns.items() if values is not None}
    if ending == ".npz":
        buffer = io.BytesIO()
        arrays = {key: values for key, (_, values) in given.items()}
        np.savez(buffer, joint_names=np.array(names), **arrays)  # type: ignore[arg-type]  # allow_pickle is no array
        return buffer.getvalue()
    if ending == ".json":
        every = zip(*(values.tolist() for _, values in given.values()), strict=True)
        points = [dict(zip((word for word, _ in given.values()), row, strict=True)) for row in every]
        return (json.dumps({"joint_names": names, "points": points}, indent=1) + "\n").encode()
    raise OptionError("the ending names no format", where=target, allowed=", ".join(WRITTEN))
