"""Files of paths: joint trajectories and poses of the tip, of every kind read; and one written, to the last bit.

NumPy's files hold one array of samples, or an archive with times, velocities and names. JSON and YAML hold a
trajectory_msgs/JointTrajectory as ROS writes it (`ros2 topic echo`, MoveIt), or poses, what a Cartesian program says.
"""

from __future__ import annotations

import io
import json
import reprlib
import warnings
import zlib
from collections import Counter
from collections.abc import Callable, Container, Hashable, Mapping
from dataclasses import dataclass, replace
from math import isfinite, prod
from pathlib import Path
from tokenize import TokenError
from typing import Any, BinaryIO
from zipfile import ZIP_DEFLATED, ZIP_STORED, BadZipFile, ZipFile, ZipInfo, is_zipfile

import numpy as np
from numpy.lib.format import (
    MAGIC_PREFIX,
    read_array,
    read_array_header_1_0,
    read_array_header_2_0,
    read_magic,
)
from numpy.typing import NDArray

from rankdrop.disk import is_endless
from rankdrop.errors import MissingExtraError, OptionError, RankdropError
from rankdrop.path.read.program_record import PROGRAMS, is_program
from rankdrop.path.read.trajectory import (
    BAGS,
    UNITS,
    Table,
    Trajectory,
    TrajectoryError,
    arranged,
    checked_times,
    csv_text,
    find_columns,
    increasing,
    is_bag,
    is_number,
    name_and_unit,
    names_of,
    parse_trajectory,
    read_table,
)
from rankdrop.robot.files import (
    DEEPEST,
    LARGEST_ARRAY,
    LARGEST_YAML,
    LONGEST_HEAD,
    MOST_MEMBERS,
    MOST_ROWS,
    MOST_STEPS,
    RANGE,
    allowed_range,
    read_text,
)
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.transform import from_xyz_rpy
from rankdrop.text.path_files import MILLIMETRES

ENDINGS = (".csv", ".tsv", ".txt", ".npy", ".npz", ".json", ".yaml", ".yml", *BAGS, *PROGRAMS)
"""Files that are taken for paths in a folder; a single file of another ending is read as CSV."""
WRITTEN = (".csv", ".npz", ".json")
"""Endings of files that are written."""
ARRAYS = (
    ("q", "positions", "position"), ("t", "time", "times"), ("qd", "velocities", "velocity"),
    ("qdd", "accelerations", "acceleration"), ("joint_names", "names", "joints"),
)  # fmt: skip
"""Names that each array may have in an archive."""
_DAMAGED = (ValueError, TypeError, EOFError, BadZipFile, NotImplementedError, MemoryError, OverflowError, SyntaxError,
            RecursionError, RuntimeError, TokenError, zlib.error)  # fmt: skip
"""What NumPy raises over a file that is none: its headers are parsed as Python's literals."""
_MOST = f"at most {LARGEST_ARRAY // 2**20} MB"
_HEADER = 10_240  # bytes: NumPy itself accepts headers of 10,000
_ZIP_END = 22  # bytes of the record at the end of an archive
_ENTRY = 1024  # bytes of a member in the list of an archive
_INSIDE = ("trajectory", "joint_trajectory", "goal")
_SECONDS, _NANOSECONDS = ("sec", "secs"), ("nanosec", "nsecs")
_ENTRIES = {"q": "positions", "qd": "velocities", "qdd": "accelerations"}
QUATERNION, ANGLES = ("qx", "qy", "qz", "qw"), ("roll", "pitch", "yaw")
_LENGTHS = {"x", "y", "z"}
_OTHER = {
    **{f"{long}{letter}": f"q{letter}" for long in ("q_", "quat_", "orientation_", "orientation.")
       for letter in "xyzw"},
    **{f"{long}{letter}": letter for long in ("p", "p_", "pos_", "position_", "position.", "t") for letter in "xyz"},
}  # fmt: skip
"""Other names of columns."""
_TURNS = {"orientation": QUATERNION, "rpy": ANGLES}
_AXES = {"orientation": tuple("xyzw")}  # names of the numbers in an object
_UNIT_LENGTH = 1e-3  # a quaternion's length may be off by this: digits of a file
_FAR = 20.0  # reaches: positions beyond it look like millimetres
OBJECTS = (".json", ".yaml", ".yml")


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses of the tip, in order.

    Attributes:
        name: of the file.
        matrices: (P, 4, 4) in the base frame [m].
        times: (P,) increasing [s]; None where the file has none.
        turned: the file gives orientations; else only positions are meant.
        unused: columns that were passed over.
        notes: what a reader should know of how the file was read.
    """

    name: str
    matrices: Array
    times: Array | None
    turned: bool
    unused: tuple[str, ...]
    notes: tuple[str, ...] = ()


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
    text = _text_of(file)
    if ending in OBJECTS:
        return parse_message(text, name, robot, yaml=ending != ".json", deg=deg)
    return parse_trajectory(text, name, robot, deg=deg)


def _text_of(file: Path) -> str:
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
    words = [(_ENTRIES | {"t": "time_from_start"})[key] for key in columns]
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    points = [dict(zip(words, row, strict=True)) for row in rows]
    return (json.dumps({"joint_names": names, "points": points}, indent=1) + "\n").encode()


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
        q = _doubles(loaded)
        timed = q.ndim == 2 and q.shape[1] == robot.n + 1 and len(q) > 1 and increasing(q[:, 0])
        return arranged(where, robot, {"q": q[:, 1:], "t": q[:, 0]} if timed else {"q": q}, deg=deg)
    names = loaded.pop("joint_names", None)
    listed = None if names is None else _texts(names)
    parts = {key: _doubles(part) for key, part in loaded.items()}
    return arranged(where, robot, parts, listed, deg=deg)


def _doubles(numbers: NDArray[Any]) -> Array:
    with np.errstate(over="ignore"):  # longer floats beyond the doubles become infinite, which is refused with its row
        return numbers.astype(np.float64)


def _texts(names: NDArray[Any]) -> list[str]:
    """Names as Python's texts; an array of bytes is UTF-8."""
    listed = names.reshape(-1).tolist()
    return [name.decode("utf-8", "replace") if isinstance(name, bytes) else name for name in listed]


def _load(path: Path) -> Array | dict[str, Array]:
    """The array, or those of the archive that are read. Headers are judged before any array is unpacked."""
    try:
        if is_endless(path):
            raise TrajectoryError("this is not a file", where=str(path), got="a pipe or a device")
        if path.stat().st_size > LARGEST_ARRAY:
            raise TrajectoryError("the file is too large", where=str(path), allowed=_MOST)
        with path.open("rb") as file, warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # a header of Python 2 is read as any other
            begin = file.read(_HEADER)
            if begin.startswith(MAGIC_PREFIX):  # an array may hold the bytes of an archive, too
                _judge(begin, "q", str(path))
                file.seek(0)
                return np.asarray(read_array(file, allow_pickle=False))
            if not is_zipfile(file):
                raise TrajectoryError("this is not a file of NumPy's", where=str(path),
                                      got=repr(begin[: len(MAGIC_PREFIX)]))  # fmt: skip
            _check_directory(file, str(path))
            with ZipFile(file) as archive:
                return _members(archive, str(path))
    except OSError as error:
        raise TrajectoryError(f"the file cannot be read: {error.strerror or error}", where=str(path)) from None
    except _DAMAGED as error:
        raise TrajectoryError("this is not a file of NumPy's", where=str(path), got=str(error)[:80]) from None


def _check_directory(file: BinaryIO, where: str) -> None:
    """Refuse an archive whose list of members is long, before `ZipFile` reads that list.

    The list's size is in the record at the end of the archive (APPNOTE 4.3.16), which is found as `zipfile` finds it.
    An archive within the limits of size needs no record of 64 bits (4.3.15), so that such an archive is refused.

    Raises:
        TrajectoryError: the list is longer than `MOST_MEMBERS` allow.
    """
    file.seek(0, io.SEEK_END)
    file.seek(max(0, file.tell() - _ZIP_END - 2**16))
    tail = file.read()
    last = len(tail) - _ZIP_END
    bare = tail.startswith(b"PK\5\6", last) and tail.endswith(b"\0\0")
    end = last if bare else tail.rfind(b"PK\5\6")
    size = int.from_bytes(tail[end + 12 : end + 16], "little")
    wide = tail[max(0, end - 20) : end].startswith(b"PK\6\7")
    if wide or size > MOST_MEMBERS * _ENTRY:
        raise TrajectoryError("the archive has too many arrays", where=where, allowed=f"at most {MOST_MEMBERS:,}")


def _members(archive: ZipFile, where: str) -> dict[str, Array]:
    """The arrays of an archive by the first name of their kind; all other members are None.

    Raises:
        TrajectoryError: too many members, two of a name, a header that is refused, or too many numbers.
    """
    infos = _infos(archive, where)
    wanted = _arrays_wanted(infos)
    if "q" not in wanted:
        raise TrajectoryError("the archive has no positions", where=where, got=", ".join(infos) or "nothing",
                              allowed=" or ".join(ARRAYS[0]))  # fmt: skip
    total = 0
    for key, name in wanted.items():
        place = f"{where}, {name}"
        if infos[name].compress_type not in (ZIP_STORED, ZIP_DEFLATED):  # others may ask for gigabytes to start
            raise TrajectoryError("the array is packed in another way than NumPy packs", where=place,
                                  mend="write it by numpy.savez or numpy.savez_compressed")  # fmt: skip
        with archive.open(infos[name]) as stream:
            total += _judge(stream.read(_HEADER), key, place)
        if total > LARGEST_ARRAY:
            raise TrajectoryError("the arrays are too large", where=where, allowed=f"{_MOST} together")
    found: dict[str, Array] = {}
    for key, name in wanted.items():
        with archive.open(infos[name]) as stream:
            found[key] = np.asarray(read_array(stream, allow_pickle=False))
    return found


def _infos(archive: ZipFile, where: str) -> dict[str, ZipInfo]:
    """The members of an archive by the names of their arrays.

    Raises:
        TrajectoryError: too many members, or two of a name.
    """
    listed = archive.infolist()
    if len(listed) > MOST_MEMBERS:
        raise TrajectoryError("the archive has too many arrays", where=where, got=len(listed),
                              allowed=f"at most {MOST_MEMBERS:,}")  # fmt: skip
    infos = {member.filename.removesuffix(".npy"): member for member in listed}
    if len(infos) < len(listed):
        counts = Counter(member.filename.removesuffix(".npy") for member in listed)
        raise TrajectoryError("two arrays of the archive have the same name",
                              where=f"{where}, {counts.most_common(1)[0][0]}", mend="name each array once")  # fmt: skip
    return infos


def _arrays_wanted(names: Container[str]) -> dict[str, str]:
    """Of each kind of array that is there the first of its names, by the kind."""
    wanted = {}
    for kind in ARRAYS:
        there = [name for name in kind if name in names]
        if there:
            wanted[kind[0]] = there[0]
    return wanted


def _judge(begin: bytes, key: str, where: str) -> int:
    """Bytes that the array takes as it is read and as doubles, by its header: shape and type.

    Args:
        begin: of the file or member; a longer header than `_HEADER` is damage.
        key: which array it is, of `ARRAYS`.
        where: for errors.

    Raises:
        TrajectoryError: the type is none of numbers (of texts, for names), or the array is too large.
        ValueError: it is no header.
    """
    stream = io.BytesIO(begin)
    if read_magic(stream) == (1, 0):
        read_header = read_array_header_1_0
    else:
        read_header = read_array_header_2_0
    shape, _, dtype = read_header(stream)
    texts = key == "joint_names"
    if dtype.kind not in ("US" if texts else "fiu"):
        raise TrajectoryError("these are no names" if texts else "these are no numbers", where=where,
                              got=f"an array of {dtype}")  # fmt: skip
    if min(shape, default=1) < 0:
        raise TrajectoryError("the array has a negative size", where=where, got=f"shape {shape}")
    if texts and not _fits_names(shape, dtype):
        raise TrajectoryError("the names of the joints are too many or too long", where=where,
                              got=f"shape {shape} of {dtype}",
                              allowed=f"at most {MOST_STEPS:,} of {LONGEST_HEAD} characters")  # fmt: skip
    size = prod(shape) * max(8, dtype.itemsize)  # a byte of the file becomes eight
    if size > LARGEST_ARRAY:
        raise TrajectoryError("the array is too large", where=where, got=f"{prod(shape)} numbers", allowed=_MOST)
    if shape and shape[0] > MOST_ROWS:
        raise TrajectoryError("there are too many rows", where=where, got=shape[0], allowed=f"at most {MOST_ROWS}")
    return size


def _fits_names(shape: tuple[int, ...], dtype: np.dtype[Any]) -> bool:
    """Whether an array of this shape and type can hold the names of the joints: a list, not too many nor too long."""
    return len(shape) <= 1 and prod(shape) <= MOST_STEPS and 0 < dtype.itemsize <= 4 * LONGEST_HEAD


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
    names, points = _names_and_points(text, name, yaml=yaml)
    columns = {key: _column(points, word, names, name) for key, word in _ENTRIES.items()}
    if columns["q"] is None:
        raise TrajectoryError("the point has no positions", where=f"{name}, row 1")
    times = [_time(point, f"{name}, row {row}") for row, point in enumerate(points, start=1)]
    columns["t"] = _all_or_none(times, "point", "time_from_start", lambda row: f"{name}, row {row + 1}")
    return arranged(name, robot, columns, names, deg=deg)


def _names_and_points(text: str, name: str, *, yaml: bool) -> tuple[list[str], list[Any]]:
    """The names of the joints and the points of the message in a JSON or YAML text.

    Raises:
        TrajectoryError: there is no message in it, or one without names or points.
    """
    message = next(filter(None, map(_message, documents(text, name, yaml=yaml))), None)
    if message is None:
        raise TrajectoryError("there is no JointTrajectory in it", where=name,
                              allowed="an object with joint_names and points")  # fmt: skip
    names, points = message["joint_names"], message["points"]
    if not isinstance(names, list):
        raise TrajectoryError("joint_names is no list", where=name)
    if not isinstance(points, list) or not points:
        raise TrajectoryError("the trajectory has no points", where=name)
    if not all(isinstance(joint, str) for joint in names):
        raise TrajectoryError("joint_names is no list of texts", where=name, got=reprlib.repr(names))
    return names, points


def _all_or_none(times: list[float | None], row: str, key: str, place: Callable[[int], str]) -> Array | None:
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
            if isinstance(values, list):
                got = f"{len(values)} numbers"
            else:
                got = reprlib.repr(values)
            raise TrajectoryError(f"{key} has another length than joint_names", where=f"{name}, row {row}", got=got,
                                  allowed=f"{len(names)} numbers")  # fmt: skip
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


def holds_poses(path: Path, robot: Robot) -> bool:
    """Whether a file holds poses: columns x, y, z and not every joint, or an object with `poses`.

    A file that cannot be read holds none; whoever reads it then says why.
    """
    ending = path.suffix.lower()
    if not path.is_file() or ending in (".npy", ".npz", *BAGS):
        return False
    try:
        text = read_text(path)
        if ending in OBJECTS:
            return list_in(loaded_poses(text, str(path), yaml=ending != ".json")) is not None
        words = names_of(text, str(path))
    except RankdropError:
        return False
    joints = {joint.name for joint in robot.variables}
    return {_column_name(word) for word in words} >= _LENGTHS and not joints <= set(words)


def read_poses(path: str | Path, *, deg: bool = False) -> Poses:
    """Poses from a file.

    CSV: a line of names, x, y, z, and either qx, qy, qz, qw or roll, pitch, yaw (R = Rz·Ry·Rx, as in URDF); a time
    column if there is one; units behind a name ("x [mm]", "roll [deg]"), else metres and radians. JSON or YAML: a list,
    or an object with `poses` (a PoseArray, a Path), of objects with `position` ([x, y, z], or by name), `orientation`
    (the quaternion [x, y, z, w], or by name) or `rpy`, and `time`; `length`: "mm" and `angle`: "deg" beside `poses`.

    Args:
        path: the file.
        deg: angles without a unit are in degrees.

    Raises:
        TrajectoryError: with file, row or line, and column.
        MissingExtraError: YAML, and PyYAML is not installed.
    """
    file, name = Path(path), str(path)
    text, ending = _text_of(file), file.suffix.lower()
    if ending in OBJECTS:
        return _poses_of_objects(loaded_poses(text, name, yaml=ending != ".json"), name, deg=deg)
    return _poses_of_rows(text, name, deg=deg)


def length_hint(poses: Poses, reach: float) -> str | None:
    """A line of warning where positions look like millimetres; None where they do not."""
    most = float(np.abs(poses.matrices[:, :3, 3]).max())
    if most <= _FAR * reach:
        return None
    return MILLIMETRES.format(most)


def turned_by(quaternion: Array, where: Callable[[int], str]) -> NDArray[np.float64]:
    """(N, 3, 3) rotations of quaternions (N, 4) x, y, z, w.

    Raises:
        TrajectoryError: one is not of length one, to 1e-3.
    """
    size = np.linalg.norm(quaternion, axis=1)
    for i in np.flatnonzero(np.abs(size - 1.0) > _UNIT_LENGTH)[:1].tolist():
        raise TrajectoryError("the quaternion is not of length one", where=where(i), got=f"length {size[i]:.6g}",
                              allowed="x, y, z, w of length 1")  # fmt: skip
    x, y, z, w = (quaternion / size[:, None]).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.asarray(np.moveaxis(np.array(rows), 2, 0))


def _column_name(word: str) -> str:
    """A column's name, without its unit, as it is known here."""
    plain = name_and_unit(word.strip())[0].lower()
    return _OTHER.get(plain, plain)


def _measure(name: str) -> tuple[str, str] | None:
    """A column of a pose, and what it measures."""
    key = _column_name(name)
    kinds = {**dict.fromkeys(_LENGTHS, "length"), **dict.fromkeys(ANGLES, "angle"),
             **dict.fromkeys(QUATERNION, "number")}  # fmt: skip
    if key in kinds:
        return (key, kinds[key])
    return None


def pose_table(
    text: str, name: str, *, deg: bool
) -> tuple[Table, dict[Hashable, tuple[int, float]], int | None, tuple[str, ...]]:
    """A table of poses; place and factor (to rad and m) of each of its columns; that of the time; those that turn.

    Raises:
        TrajectoryError: these are no columns of poses.
    """
    table = read_table(text, name)
    if all(map(is_number, table.head)):
        raise TrajectoryError("the columns have no names", where=table.where,
                              allowed="x, y, z and qx, qy, qz, qw or roll, pitch, yaw")  # fmt: skip
    columns, time, _ = find_columns(table.head, table.where, _measure, deg=deg)
    turn = next((keys for keys in (QUATERNION, ANGLES) if columns.keys() >= set(keys)), ())
    if columns.keys() != {*_LENGTHS, *turn}:
        raise TrajectoryError(
            "poses need other columns", where=table.where, got=", ".join(table.head),
            allowed="x, y, z with qx, qy, qz, qw, with roll, pitch, yaw, or alone",
        )  # fmt: skip
    return table, columns, time, turn


def _poses_of_rows(text: str, name: str, *, deg: bool) -> Poses:
    table, columns, time, turn = pose_table(text, name, deg=deg)
    places, factors = zip(*(columns[key] for key in ("x", "y", "z", *turn)), strict=True)
    values = table.block(places) * np.array(factors)
    matrices = _matrices(values, turn, table.place)
    used = {place for place, _ in columns.values()} | {time}
    unused = tuple(word for place, word in enumerate(table.head) if place not in used)
    return Poses(Path(name).name, matrices, table.times(time), bool(turn), unused, table.notes)


def _matrices(values: Array, turn: tuple[str, ...], place: Callable[[int], str]) -> Array:
    """(N, 4, 4) from rows of x, y, z and what turns.

    Raises:
        TrajectoryError: a length or an angle is beyond the range of all readers, a quaternion is not of length one.
    """
    measures = ["length"] * 3 + ["angle" if turn == ANGLES else "number"] * len(turn)
    beyond = np.abs(values) > [RANGE[measure] for measure in measures]
    for i, column in np.argwhere(beyond)[:1].tolist():
        raise TrajectoryError("the value is too large", where=place(i), got=f"{values[i, column]:g}",
                              allowed=allowed_range(measures[column]))  # fmt: skip
    made = np.tile(np.eye(4), (len(values), 1, 1))
    if turn == QUATERNION:
        made[:, :3, :3] = turned_by(values[:, 3:], place)
    elif turn:
        made = np.array([from_xyz_rpy((0.0, 0.0, 0.0), row[3:].tolist()) for row in values])
    made[:, :3, 3] = values[:, :3]
    return made


def loaded_poses(text: str, name: str, *, yaml: bool) -> Any:
    """The first document with poses; None where there is none."""
    return next((document for document in documents(text, name, yaml=yaml) if list_in(document) is not None), None)


def list_in(found: Any) -> list[Any] | None:
    """The list of poses of an object, or the list itself; None where there is none."""
    if isinstance(found, dict):
        rows = found.get("poses")
    else:
        rows = found
    if isinstance(rows, list) and rows and pose_in(rows[0]) is not None:
        return rows
    return None


def pose_in(row: Any) -> dict[str, Any] | None:
    """The object with the position: the entry itself, or its `pose` (PoseStamped); None where it is no pose."""
    if isinstance(row, dict) and "position" not in row:
        inner = row.get("pose", row)
    else:
        inner = row
    if isinstance(inner, dict) and "position" in inner:
        return inner
    return None


def _poses_of_objects(found: Any, name: str, *, deg: bool) -> Poses:
    rows = list_in(found)
    if rows is None:
        raise TrajectoryError("there are no poses in it", where=name, allowed="a list of objects with a position")
    if len(rows) > MOST_ROWS:
        raise TrajectoryError("there are too many poses", where=name, got=len(rows), allowed=f"at most {MOST_ROWS}")
    about = found if isinstance(found, dict) else {}
    units = {
        "position": unit_of(about, "length", "m", ("m", "mm"), name), "orientation": 1.0,
        "rpy": unit_of(about, "angle", "deg" if deg else "rad", tuple(UNITS["angle"]), name),
    }  # fmt: skip

    def place(row: int) -> str:
        return f"{name}, pose {row + 1}"

    first = pose_in(rows[0]) or {}
    turn = next((key for key in _TURNS if key in first), "")
    values = np.array([_numbers_of_pose(entry, turn, units, place(row)) for row, entry in enumerate(rows)])
    listed = [_numbers([entry["time"]], "t", place(row), "time")[0] if "time" in entry else None
              for row, entry in enumerate(rows)]  # fmt: skip
    times = _all_or_none(listed, "pose", "time", place)
    if times is None:
        when = None
    else:
        when = checked_times(times, place)
    keys = _TURNS.get(turn, ())
    return Poses(Path(name).name, _matrices(values, keys, place), when, bool(turn), ())


def _numbers_of_pose(entry: Any, turn: str, units: dict[str, float], where: str) -> list[float]:
    """x, y, z [m] and what turns, of one pose."""
    inner = pose_in(entry)
    if inner is None:
        raise TrajectoryError("there is no position", where=where, got=reprlib.repr(entry))
    own = next((key for key in _TURNS if key in inner), "")
    if own != turn:
        raise TrajectoryError("the pose has another form than the first", where=where, got=own or "none",
                              allowed=turn or "a position alone")  # fmt: skip
    keys = {"position": tuple("xyz"), **({turn: _AXES.get(turn, ANGLES)} if turn else {})}
    return [number * units[key] for key, axes in keys.items() for number in _numbers(inner[key], axes, where, key)]


def unit_of(about: dict[str, Any], key: str, default: str, allowed: tuple[str, ...], name: str) -> float:
    """Metres or radians in the unit of length or angle that an object of poses states, or in its default."""
    unit = about.get(key, default)
    if unit not in allowed:
        raise TrajectoryError(f"there is no such unit of {key}", where=name, got=unit, allowed=", ".join(allowed))
    return next(fits[unit] for fits in UNITS.values() if unit in fits)


def _numbers(value: Any, keys: Any, where: str, what: str) -> list[float]:
    """Numbers from a list, or from an object by name."""
    if isinstance(value, dict):
        listed = [value.get(key) for key in keys]
    else:
        listed = value
    if not isinstance(listed, list) or len(listed) != len(keys):
        raise TrajectoryError(f"the {what} has not {len(keys)} numbers", where=where, got=reprlib.repr(value),
                              allowed=", ".join(keys))  # fmt: skip
    for value in listed:
        if not is_double(value) or not isfinite(value):
            raise TrajectoryError(f"the {what} has a value that is no finite number", where=where,
                                  got=reprlib.repr(value))  # fmt: skip
    return [float(value) for value in listed]
