"""A trajectory as a file that `read_trajectory` reads back to the last bit."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np

from rankdrop.errors import OptionError
from rankdrop.motion.trajectory import Trajectory
from rankdrop.robot.model import Array, Robot

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
    if ending == ".npz":
        parts: dict[str, Array] = {"q": made.q}
        if made.timed:
            parts["t"] = made.times
        if made.velocities is not None:
            parts["qd"] = made.velocities
        if made.accelerations is not None:
            parts["qdd"] = made.accelerations
        buffer = io.BytesIO()
        np.savez(buffer, joint_names=np.array(names), **parts)  # type: ignore[arg-type]  # allow_pickle is no array
        return buffer.getvalue()
    if ending == ".json":
        return (json.dumps({"joint_names": names, "points": _points(made)}, indent=1) + "\n").encode()
    raise OptionError("the ending names no format", where=target, allowed=", ".join(WRITTEN))


def _points(made: Trajectory) -> list[dict[str, object]]:
    points: list[dict[str, object]] = [{"positions": row} for row in made.q.tolist()]
    for key, values in (("velocities", made.velocities), ("accelerations", made.accelerations)):
        for point, row in zip(points, [] if values is None else values.tolist(), strict=False):
            point[key] = row
    for point, time in zip(points, made.times.tolist() if made.timed else [], strict=False):
        point["time_from_start"] = time
    return points
