"""Trajectory files: of every kind read, and one written that is read back to the last bit.

NumPy's files hold one array of samples, or an archive with times, velocities and names. JSON and YAML hold a
trajectory_msgs/JointTrajectory as ROS writes it: `ros2 topic echo`, MoveIt.
"""

from __future__ import annotations

import io
import json
import reprlib
import warnings
import zlib
from collections.abc import Mapping
from pathlib import Path
from tokenize import TokenError
from typing import Any
from zipfile import BadZipFile, ZipFile, is_zipfile

import numpy as np
from numpy.lib.format import MAGIC_PREFIX

from rankdrop.errors import MissingExtraError, OptionError, RankdropError
from rankdrop.motion.bag_file import BAGS, is_bag, read_bag
from rankdrop.motion.csv_file import parse_trajectory
from rankdrop.motion.trajectory import Trajectory, TrajectoryError, arranged, csv_text
from rankdrop.robot.files import DEEPEST, LARGEST_ARRAY, LARGEST_YAML, read_text
from rankdrop.robot.model import Array, Robot

ENDINGS = (".csv", ".tsv", ".txt", ".npy", ".npz", ".json", ".yaml", ".yml", *BAGS)
"""Files that are taken for trajectories in a folder; a single file of another ending is read as CSV."""
WRITTEN = (".csv", ".npz", ".json")
"""Endings of files that are written."""
POSITIONS, TIMES, VELOCITIES, ACCELERATIONS, NAMES = (
    ("q", "positions", "position"), ("t", "time", "times"), ("qd", "velocities", "velocity"),
    ("qdd", "accelerations", "acceleration"), ("joint_names", "names", "joints"),
)  # fmt: skip
"""Names that an array may have in an archive."""
_DAMAGED = (ValueError, TypeError, EOFError, BadZipFile, NotImplementedError, MemoryError, OverflowError, SyntaxError,
            RecursionError, RuntimeError, TokenError, zlib.error)  # fmt: skip
"""What NumPy raises over a file that is none: its headers are parsed as Python's literals."""
_MOST = f"at most {LARGEST_ARRAY // 2**20} MB"
_INSIDE = ("trajectory", "joint_trajectory", "goal")
_SECONDS, _NANOSECONDS = ("sec", "secs"), ("nanosec", "nsecs")


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


def read_arrays(path: Path, robot: Robot, *, deg: bool = False) -> Trajectory:
    """A trajectory from a .npy file (T, n), or (T, n + 1) with a rising time in front; or from an .npz archive.

    Args:
        path: the file.
        robot: whose joints they are; in the order of the arm unless the archive has `joint_names`.
        deg: angles are in degrees.

    Raises:
        TrajectoryError: with file and row.
    """
    where = str(path)
    loaded = _load(path)
    if isinstance(loaded, np.ndarray):
        q = _as_numbers(loaded, where)
        if q.ndim == 2 and q.shape[1] == robot.n + 1 and len(q) > 1 and bool((q[1:, 0] > q[:-1, 0]).all()):
            return arranged(where, robot, {"q": q[:, 1:], "t": q[:, 0]}, deg=deg)
        return arranged(where, robot, {"q": q}, deg=deg)
    parts = {kind[0]: _part(loaded, kind, where) for kind in (POSITIONS, TIMES, VELOCITIES, ACCELERATIONS)}
    names = _member(loaded, NAMES)
    if parts["q"] is None:
        raise TrajectoryError("the archive has no positions", where=where, got=", ".join(loaded) or "nothing",
                              allowed=" or ".join(POSITIONS))  # fmt: skip
    listed = None if names is None else [str(name) for name in np.asarray(names).reshape(-1)]
    return arranged(where, robot, parts, listed, deg=deg)


def _load(path: Path) -> Array | Mapping[str, Any]:
    """The array, or those of the archive that are read; an archive tells how large each of them is before it is."""
    try:
        if path.stat().st_size > LARGEST_ARRAY:
            raise TrajectoryError("the file is too large", where=str(path), allowed=_MOST)
        with path.open("rb") as file:
            begin = file.read(len(MAGIC_PREFIX))
        if begin == MAGIC_PREFIX:  # an array may hold the bytes of an archive, too
            with warnings.catch_warnings():  # a header of Python 2 is read as any other
                warnings.simplefilter("ignore", UserWarning)
                return np.asarray(np.load(path, allow_pickle=False))
        if not is_zipfile(path):
            raise TrajectoryError("this is not a file of NumPy's", where=str(path), got=repr(begin))
        wanted = {name for kind in (POSITIONS, TIMES, VELOCITIES, ACCELERATIONS, NAMES) for name in kind}
        with ZipFile(path) as archive:
            members = [(one.filename.removesuffix(".npy"), one.file_size) for one in archive.infolist()]
        names = [name for name, _ in members]
        for name in [name for name in names if names.count(name) > 1][:1]:  # NumPy would read the other one
            raise TrajectoryError("two arrays of the archive have the same name", where=f"{path}, {name}",
                                  mend="name each array once")  # fmt: skip
        if sum(size for name, size in members if name in wanted) > LARGEST_ARRAY:
            largest, _ = max(((name, size) for name, size in members if name in wanted), key=lambda one: one[1])
            raise TrajectoryError("the array is too large", where=f"{path}, {largest}", allowed=_MOST)
        with np.load(path, allow_pickle=False) as loaded:
            return {name: loaded[name] if name in wanted else None for name in loaded}
    except OSError as error:
        raise TrajectoryError(f"the file cannot be read: {error.strerror or error}", where=str(path)) from None
    except _DAMAGED as error:
        raise TrajectoryError("this is not a file of NumPy's", where=str(path), got=str(error)[:80]) from None


def _member(archive: Mapping[str, Any], names: tuple[str, ...]) -> Any:
    return next((archive[name] for name in names if name in archive), None)


def _part(archive: Mapping[str, Any], names: tuple[str, ...], where: str) -> Array | None:
    value = _member(archive, names)
    return None if value is None else _as_numbers(value, f"{where}, {names[0]}")


def _as_numbers(value: Any, where: str) -> Array:
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        kind = np.asarray(value).dtype
        raise TrajectoryError("these are no numbers", where=where, got=f"an array of {kind}") from None


def parse_message(text: str, name: str, robot: Robot, *, yaml: bool, deg: bool = False) -> Trajectory:
    """A trajectory from the text of a JSON or YAML file.

    Looked for is an object with `joint_names` and `points`, each with `positions`, `time_from_start` (seconds, or an
    object of seconds and nanoseconds), and where given `velocities` and `accelerations`; at the top, or under
    `trajectory`, `joint_trajectory` or `goal`.

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
    message = next(filter(None, map(_message, documents(text, name, yaml=yaml))), None)
    if message is None:
        raise TrajectoryError("there is no JointTrajectory in it", where=name,
                              allowed="an object with joint_names and points")  # fmt: skip
    names, points = message["joint_names"], message["points"]
    if not isinstance(names, list) or not isinstance(points, list) or not points:
        raise TrajectoryError("the trajectory has no points" if isinstance(names, list) else "joint_names is no list",
                              where=name)  # fmt: skip
    if not all(isinstance(one, str) for one in names):
        raise TrajectoryError("joint_names is no list of texts", where=name, got=reprlib.repr(names))
    q = _column(points, "positions", names, name)
    if q is None:
        raise TrajectoryError("the point has no positions", where=f"{name}, row 1")
    timed = [_has_time(point) for point in points]
    times = np.array([_time(point, f"{name}, row {row}") for row, point in enumerate(points, start=1)])
    if any(timed) and not all(timed):
        raise TrajectoryError("the point has no time_from_start", where=f"{name}, row {timed.index(False) + 1}")
    return arranged(
        name, robot, {
            "q": q, "t": times if all(timed) else None, "qd": _column(points, "velocities", names, name),
            "qdd": _column(points, "accelerations", names, name),
        }, names, deg=deg,
    )  # fmt: skip


def documents(text: str, name: str, *, yaml: bool) -> list[Any]:
    """What the text of a JSON or YAML file holds: YAML may have several documents.

    Raises:
        TrajectoryError: it is neither, or beyond what is accepted (docs/limits.md).
        MissingExtraError: YAML is asked for and PyYAML is not installed.
    """
    return _yaml(text, name) if yaml else [_json(text, name)]


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
        most = f"at most {LARGEST_YAML // 2**20} MB of YAML"
        raise TrajectoryError("the file is too large", where=name, allowed=most, mend="write it as JSON or CSV")
    if "<<" in text:  # a merge may double what it merges, thirty times over
        raise TrajectoryError("merge keys are not read", where=name, got="<<", mend="write the points out")
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        _check_depth(yaml, text, loader, name)
        return list(yaml.load_all(text, loader))
    except (RecursionError, ValueError, TypeError) as error:  # too deep; a date that is none; a key that is a list
        what = "nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise TrajectoryError(f"this is not YAML that can be read: {what[:80]}", where=name) from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = "" if mark is None else f", line {mark.line + 1}"
        raise TrajectoryError(f"this is not YAML: {getattr(error, 'problem', error)}", where=f"{name}{line}") from None


def _check_depth(yaml: Any, text: str, loader: Any, name: str) -> None:
    """Refuse what is nested deeply: the compiled loader would go down with the stack, and the process with it."""
    depth = 0
    for event in yaml.parse(text, loader):
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST:
            where = f"{name}, line {event.start_mark.line + 1}"
            raise TrajectoryError("the objects are nested too deeply", where=where, allowed=f"depth {DEEPEST}")


def _message(found: Any, below: int = 2) -> dict[str, Any] | None:
    """The object with joint_names and points, at the top or one or two levels below."""
    if not isinstance(found, dict) or below < 0:
        return None
    if "joint_names" in found and "points" in found:
        return found
    return next((inner for key in _INSIDE if (inner := _message(found.get(key), below - 1)) is not None), None)


def _column(points: list[Any], key: str, names: list[Any], name: str) -> Array | None:
    """(T, joints) of one entry of every point; None where no point has it."""
    rows = [point.get(key) if isinstance(point, dict) else None for point in points]
    if not any(rows):
        return None
    for row, values in enumerate(rows, start=1):
        if not isinstance(values, list) or len(values) != len(names):
            got = f"{len(values)} numbers" if isinstance(values, list) else reprlib.repr(values)
            raise TrajectoryError(f"{key} has another length than joint_names", where=f"{name}, row {row}", got=got,
                                  allowed=f"{len(names)} numbers")  # fmt: skip
        if not all(map(is_double, values)):
            raise TrajectoryError(f"{key} has a value that is no number", where=f"{name}, row {row}",
                                  got=reprlib.repr(values))  # fmt: skip
    return np.array(rows, dtype=np.float64)


def is_double(value: Any) -> bool:
    """A double, or a whole number that has one."""
    return isinstance(value, float) or (isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**1000)


def _has_time(point: Any) -> bool:
    return isinstance(point, dict) and point.get("time_from_start") is not None


def _time(point: Any, where: str) -> float:
    value = point.get("time_from_start") if isinstance(point, dict) else None
    if value is None:
        return 0.0
    if isinstance(value, dict):
        parts = [next((value[key] for key in keys if key in value), 0) for keys in (_SECONDS, _NANOSECONDS)]
        known = any(key in value for key in _SECONDS + _NANOSECONDS)
        if known and all(map(is_double, parts)):
            return float(parts[0]) + 1e-9 * float(parts[1])
    elif is_double(value):
        return float(value)
    got = reprlib.repr(value)
    raise TrajectoryError("this is no time", where=where, got=got, allowed="seconds, or sec and nanosec")
