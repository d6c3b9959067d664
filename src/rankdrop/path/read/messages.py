"""Trajectories in JSON and YAML: a trajectory_msgs/JointTrajectory as ROS writes it (`ros2 topic echo`, MoveIt)."""

from __future__ import annotations

import json
import reprlib
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from rankdrop.errors import MissingExtraError
from rankdrop.path.read.joint_columns import names_of_arm
from rankdrop.path.read.trajectory import Trajectory, TrajectoryError, trajectory_from_arrays
from rankdrop.robot.files import DEEPEST, LARGEST_YAML
from rankdrop.robot.model import Array, Robot
from rankdrop.text.path_files import POINTS_WITHOUT_NAMES

_INSIDE = ("trajectory", "joint_trajectory", "goal")
_SECONDS, _NANOSECONDS = ("sec", "secs"), ("nanosec", "nsecs")
ENTRIES = {"q": "positions", "qd": "velocities", "qdd": "accelerations"}


OBJECTS = (".json", ".yaml", ".yml")


def parse_message(text: str, name: str, robot: Robot, *, yaml: bool, deg: bool = False) -> Trajectory:
    """A trajectory from the text of a JSON or YAML file.

    Looked for is an object with `joint_names` and `points`, each with `positions`, `time_from_start` (seconds, or an
    object of seconds and nanoseconds), and where given `velocities` and `accelerations`; at the top, or under
    `trajectory`, `joint_trajectory` or `goal`. Points without names, and a list of such points or of lists of numbers,
    have the joints in the arm's order, and a note says so.

    Args:
        text: of the file.
        name: of the file, for errors.
        robot: whose joints they are.
        yaml: YAML; else JSON.
        deg: angles are in degrees.

    Raises:
        TrajectoryError: with file and row.
        MissingExtraError: YAML is asked for and PyYAML is not installed.
    """
    names, points = _names_and_points(text, name, yaml=yaml)
    if names is None:
        joints = robot.n, "the joints"
    else:
        joints = len(names), "joint_names"
    columns = {key: _column(points, word, joints, name) for key, word in ENTRIES.items()}
    if columns["q"] is None:
        raise TrajectoryError("the point has no positions", where=f"{name}, row 1")
    times = [_time(point, f"{name}, row {row}") for row, point in enumerate(points, start=1)]
    columns["t"] = all_or_none(times, "point", "time_from_start", lambda row: f"{name}, row {row + 1}")
    if names is None:
        notes: tuple[str, ...] = (POINTS_WITHOUT_NAMES,)
    else:
        names, notes = names_of_arm(names, [joint.name for joint in robot.variables], name)
    found = trajectory_from_arrays(name, robot, columns, names, deg=deg)
    return replace(found, notes=(*found.notes, *notes))


def _names_and_points(text: str, name: str, *, yaml: bool) -> tuple[list[str] | None, list[Any]]:
    """The names of the joints, None where there are none, and the points of the message in a JSON or YAML text.

    Raises:
        TrajectoryError: there is no message in it, or one without points.
    """
    message = next(filter(None, map(_message, documents(text, name, yaml=yaml))), None)
    if message is None:
        raise TrajectoryError("there is no JointTrajectory in it", where=name,
                              allowed="an object with joint_names and points, or a list of points")  # fmt: skip
    names, points = message.get("joint_names"), message["points"]
    if names == []:  # as ROS writes a message without names
        names = None
    if names is not None:
        _check_names(names, name)
    if not isinstance(points, list) or not points:
        raise TrajectoryError("the trajectory has no points", where=name)
    return names, points


def _check_names(names: Any, where: str) -> None:
    """Refuse names that are no list of texts."""
    if not isinstance(names, list):
        raise TrajectoryError("joint_names is no list", where=where)
    if not all(isinstance(joint, str) for joint in names):
        raise TrajectoryError("joint_names is no list of texts", where=where, got=reprlib.repr(names))


def all_or_none(times: list[float | None], row: str, key: str, place: Callable[[int], str]) -> Array | None:
    """(T,) times, None where no row has one.

    Raises:
        TrajectoryError: some rows have none.
    """
    if None not in times:
        return np.array(times, dtype=np.float64)
    if any(time is not None for time in times):
        raise TrajectoryError(f"the {row} has no {key}", where=place(times.index(None)))
    return None


def documents(text: str, name: str, *, yaml: bool) -> list[Any]:
    """What the text of a JSON or YAML file holds: YAML may have several documents.

    Raises:
        TrajectoryError: it is neither, or beyond what is accepted (docs/limits.md).
        MissingExtraError: YAML is asked for and PyYAML is not installed.
    """
    if yaml:
        return _yaml(text, name)
    return [_json(text, name)]


def _json(text: str, name: str) -> Any:
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        raise TrajectoryError(f"this is not JSON: {error.msg}", where=f"{name}, line {error.lineno}") from None
    except RecursionError:
        raise TrajectoryError("the objects are nested too deeply", where=name) from None
    except ValueError:  # a whole number of thousands of digits
        raise TrajectoryError("a number has too many digits", where=name) from None


def _yaml(text: str, name: str) -> list[Any]:
    try:
        import yaml
    except ImportError as error:
        raise MissingExtraError("pyyaml", None, "a path in YAML") from error
    if len(text) > LARGEST_YAML:
        raise TrajectoryError("the file is too large", where=name, mend="write it as JSON or CSV",
                              allowed=f"at most {LARGEST_YAML // 2**20} MB of YAML")  # fmt: skip
    if "<<" in text:  # a merge may double what it merges, thirty times over
        raise TrajectoryError("merge keys are not read", where=name, got="<<", mend="write the points out")
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        _check_depth(yaml, text, loader, name)
        return list(yaml.load_all(text, loader))
    except (RecursionError, ValueError, TypeError) as error:  # too deep; a date that is none; a key that is a list
        if isinstance(error, RecursionError):
            what = "nested too deeply"
        else:
            what = str(error)
        raise TrajectoryError(f"this is not YAML that can be read: {what[:80]}", where=name) from None
    except yaml.YAMLError as error:
        mark, problem = getattr(error, "problem_mark", None), str(getattr(error, "problem", error))
        if mark is None:
            where = name
        else:
            where = f"{name}, line {mark.line + 1}"
        if "nesting" in problem:  # from 6.0.4 on PyYAML has a limit of its own, and may meet it first
            raise _too_deep(where) from None
        raise TrajectoryError(f"this is not YAML: {problem}", where=where) from None


def _check_depth(yaml: Any, text: str, loader: Any, name: str) -> None:
    """Refuse what is nested deeply: the compiled loader would go down with the stack, and the process with it."""
    depth = 0
    for event in yaml.parse(text, loader):
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST:
            raise _too_deep(f"{name}, line {event.start_mark.line + 1}")


def _too_deep(where: str) -> TrajectoryError:
    return TrajectoryError("the objects are nested too deeply", where=where, allowed=f"depth {DEEPEST}")


def _message(value: Any, below: int = 2) -> dict[str, Any] | None:
    """The object with joint_names and points, at the top or one or two levels below; one of a list of points."""
    if isinstance(value, list):
        return _points_of(value)
    if not isinstance(value, dict) or below < 0:
        return None
    if "points" in value:
        return value
    return next((inner for key in _INSIDE if (inner := _message(value.get(key), below - 1)) is not None), None)


def _points_of(rows: list[Any]) -> dict[str, Any] | None:
    """A message of points, or of lists of numbers; None where the rows are neither."""
    if rows and all(isinstance(row, dict) and "positions" in row for row in rows):
        return {"points": rows}
    if rows and all(map(_is_row, rows)):
        return {"points": [{"positions": row} for row in rows]}
    return None


def _is_row(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(map(is_double, value))


def _column(points: list[Any], key: str, joints: tuple[int, str], name: str) -> Array | None:
    """(T, joints) of one entry of every point; None where no point has it. `joints`: how many, and what says so."""
    count, counted_by = joints
    rows = [point.get(key) if isinstance(point, dict) else None for point in points]
    if not any(rows):
        return None
    for row, values in enumerate(rows, start=1):
        if not isinstance(values, list) or len(values) != count:
            if isinstance(values, list):
                got = f"{len(values)} numbers"
            else:
                got = reprlib.repr(values)
            raise TrajectoryError(f"{key} has another length than {counted_by}", where=f"{name}, row {row}", got=got,
                                  allowed=f"{count} numbers")  # fmt: skip
        if not all(map(is_double, values)):
            raise TrajectoryError(f"{key} has a value that is no number", where=f"{name}, row {row}",
                                  got=reprlib.repr(values))  # fmt: skip
    return np.array(rows, dtype=np.float64)


def is_double(value: Any) -> bool:
    """A double, or a whole number that has one."""
    return isinstance(value, float) or (isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**1000)


def _time(point: Any, where: str) -> float | None:
    if isinstance(point, dict):
        value = point.get("time_from_start")
    else:
        value = None
    if value is None:
        return None
    if isinstance(value, dict):
        parts = [next((value[key] for key in keys if key in value), 0) for keys in (_SECONDS, _NANOSECONDS)]
        known = any(key in value for key in _SECONDS + _NANOSECONDS)
    else:
        parts, known = [value, 0], True
    if known and all(map(is_double, parts)):
        return float(parts[0]) + 1e-9 * float(parts[1])
    raise TrajectoryError("this is no time", where=where, got=reprlib.repr(value),
                          allowed="seconds, or sec and nanosec")  # fmt: skip
