"""A joint trajectory from a ROS bag: ROS 1 (.bag), ROS 2 (.db3, .mcap, or the folder of a recording).

Two types of message hold joint values by name: sensor_msgs/JointState, one row each, and
trajectory_msgs/JointTrajectory, a plan each. Times are of the header, of the recording where a header has none, and
count from the first row.
"""

from __future__ import annotations

import errno
import io
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from rankdrop.errors import MissingExtraError, RankdropError
from rankdrop.jobs.limited import CPU, MEMORY, run_limited
from rankdrop.path.read.trajectory import Trajectory, TrajectoryError, check_times, trajectory_from_arrays
from rankdrop.robot.files import MOST_ROWS
from rankdrop.robot.model import Array, Robot
from rankdrop.text.path_files import BAG_MEND, BAG_NOTES, DAMAGES

_STATE, _PLAN = "sensor_msgs/msg/JointState", "trajectory_msgs/msg/JointTrajectory"
_KINDS = {_STATE: "JointState", _PLAN: "JointTrajectory"}
_LISTED = 12  # topics that an error names
_SECONDS = 1.0  # of the processor for each MB of a bag, besides those that every file has
_SCRATCH = 64 * 2**20  # bytes that a recording whose files are compressed may have unpacked,
_RATIO = 100  # and as many for each byte of it
_PAGE = 65536  # bytes that a reader may ask for beyond the end of a file

Row = tuple[Array, Array | None, Array | None, int, int, int, str]
"""q, qd, qdd; times of header, of recording and from the start of the plan [ns]; where it stands in the bag."""


def read_bag(path: Path, robot: Robot, *, topic: str | None = None, deg: bool = False) -> Trajectory:
    """A trajectory from one topic of a bag.

    Messages of other publishers, with none of the arm's joints, are ignored, with a note. Several plans follow each
    other as a controller takes them: one that begins before the plan before it has ended takes its place from there.

    Args:
        path: .bag, .db3, .mcap, or a folder with metadata.yaml.
        robot: whose joints they are, by name.
        topic: which; None where one topic alone has joint values.
        deg: angles are in degrees; ROS means radians.

    Raises:
        TrajectoryError: with file, topic and number of the message.
        MissingExtraError: rosbags is not installed.
    """
    name = str(path)
    if not path.exists():
        raise TrajectoryError("the file cannot be read: there is no such file", where=name)
    try:
        import rosbags
    except ImportError as error:
        raise MissingExtraError("rosbags", "bags", "a ROS bag") from error
    del rosbags
    if path.is_dir():
        files = list(path.iterdir())
    else:
        files = [path]
    size = sum(file.stat().st_size for file in files)
    packed = sum(file.suffix.lower() == ".zstd" for file in files)
    if packed:
        scratch = (_SCRATCH + _RATIO * size) // packed
    else:
        scratch = 0
    names = [joint.name for joint in robot.variables]
    content = run_limited(bag_rows, name, names, topic, file=path, parser="the reader of ROS bags",
                          memory=MEMORY, cpu=CPU + int(_SECONDS * size / 1e6), scratch=scratch,
                          error=TrajectoryError)  # fmt: skip
    parts = np.load(io.BytesIO(content))
    about = json.loads(str(parts["about"]))
    trajectory = trajectory_from_arrays(about["where"], robot, parts, deg=deg)
    notes = tuple(BAG_NOTES[kind].format(*values) for kind, *values in about["notes"])
    return replace(trajectory, name=path.name, notes=notes, unused=tuple(about["unused"]))


def bag_rows(name: str, joints: list[str], topic: str | None) -> bytes:
    """Rows of a bag as NumPy's archive of `q`, `t`, `qd`, `qdd`, and `about` in JSON; runs in a child process.

    Raises:
        TrajectoryError: as `read_bag`.
    """
    store, reader, digest = _open_bag(Path(name))
    with _reading(name), reader as bag:
        chosen = _topic(list(bag.connections), name, topic)
        where = f"{name}, topic {chosen[0].topic}"
        for connection in chosen:
            if connection.digest and connection.digest != digest(connection.msgtype):
                raise TrajectoryError("this is another version of the type", where=where, got=connection.msgtype,
                                      allowed="the fields of ROS's own message")  # fmt: skip
        promised, number, rows = sum(connection.msgcount for connection in chosen), 0, _BagRows(where, joints)
        with _reading(where):
            for connection, stamp, data in bag.messages(connections=chosen):
                number += 1
                at = f"{where}, message {number}"
                with _reading(at):
                    message = store(data, connection.msgtype)
                rows.take(message, stamp, at)
                if len(rows.rows) > MOST_ROWS:
                    raise TrajectoryError("there are too many rows", where=where, allowed=f"at most {MOST_ROWS}")
            if number < promised:
                raise TrajectoryError("the bag is cut off", where=where, mend=BAG_MEND,
                                      got=f"{number} of {promised} messages")  # fmt: skip
    return rows.pack(number)


def _open_bag(path: Path) -> tuple[Callable[[bytes, str], Any], Any, Callable[[str], str]]:
    """How to read a message, the reader, and the digest that a type of ROS's own has."""
    from rosbags.rosbag1 import Reader as Reader1
    from rosbags.rosbag2 import Reader as Reader2
    from rosbags.typesys import Stores, get_typestore

    with _reading(str(path)):
        if path.suffix.lower() == ".bag":
            store = get_typestore(Stores.ROS1_NOETIC)
            reader = Reader1(_MeasuredPath(path))
            return store.deserialize_ros1, reader, lambda kind: str(store.generate_msgdef(kind)[1])
        for file in [path] if path.is_file() else sorted(path.glob("*.db3")):
            _check_database(file)
        store = get_typestore(Stores.LATEST)
        return store.deserialize_cdr, Reader2(_MeasuredPath(path)), lambda kind: str(store.hash_rihs01(kind))


class _MeasuredPath(type(Path())):  # type: ignore[misc]  # the class of paths of this system
    """A path that opens files which refuse to read far beyond their end."""

    def open(self, mode: str = "r", *_: Any, **__: Any) -> Any:
        if mode == "rb":
            return _Measured(io.FileIO(self, "rb"))
        return super().open(mode)


class _Measured(io.BufferedReader):
    """A file in which a damaged length costs no memory: nothing is longer than what is left of the file."""

    def __init__(self, raw: io.FileIO) -> None:
        super().__init__(raw)
        self._size = os.fstat(raw.fileno()).st_size

    def read(self, size: int | None = -1, /) -> bytes:
        if size is not None and size > self._size - self.tell() + _PAGE:
            raise OverflowError
        return super().read(size)


def _check_database(file: Path) -> None:
    """Whether an SQLite file is as long as its head says (sqlite.org, file format, 1.3: bytes 16 and 28): newer
    versions of SQLite read what is there of one that was cut.

    Raises:
        TrajectoryError: it is shorter.
    """
    with file.open("rb") as stream:
        head = stream.read(100)
    if not head.startswith(b"SQLite format 3\0") or len(head) < 100 or head[24:28] != head[92:96]:
        return  # another kind of file, or one whose head does not say: the reader says what it is
    page = int.from_bytes(head[16:18])
    page = 65536 if page == 1 else page
    promised, there = page * int.from_bytes(head[28:32]), file.stat().st_size
    if there < promised:
        raise TrajectoryError("the bag is cut off", where=str(file), got=f"{there:,} of {promised:,} bytes",
                              mend=BAG_MEND)  # fmt: skip


@contextmanager
def _reading(where: str) -> Iterator[None]:
    """Whatever a reader meets in a damaged file (zlib, SQLite, struct, its own errors) as one error of ours."""
    try:
        yield
    except (RankdropError, MemoryError):  # the process that reads a bag has a limit on its memory
        raise
    except Exception as error:
        if isinstance(error, OSError) and error.errno == errno.EFBIG:
            raise TrajectoryError("the files of the recording unpack to too much", where=where,
                                  allowed=f"{_SCRATCH // 2**20} MB and {_RATIO} times their size together",
                                  mend="unpack them by zstd -d") from error  # fmt: skip
        got = DAMAGES.get(type(error)) or " ".join(f"{type(error).__name__}: {error}".split())[:160]
        raise TrajectoryError("the bag cannot be read, it is damaged or cut off", where=where, got=got,
                              mend=BAG_MEND) from error  # fmt: skip


def _topic(connections: list[Any], name: str, topic: str | None) -> list[Any]:
    """The connections of the topic that is read.

    Raises:
        TrajectoryError: none, or several, can be meant.
    """
    by_topic: dict[str, list[Any]] = {}
    types: dict[str, set[str]] = {}
    for connection in sorted(connections, key=attrgetter("topic")):
        by_topic.setdefault(connection.topic, []).append(connection)
        types.setdefault(connection.topic, set()).add(connection.msgtype)
    listed = [f"{key} ({_KINDS.get(some[0].msgtype, some[0].msgtype)})" for key, some in by_topic.items()]
    every = ", ".join(listed[:_LISTED]) + (f" and {len(listed) - _LISTED} more" if len(listed) > _LISTED else "")
    if topic is None:
        return by_topic[_only_topic(types, name, every)]
    return by_topic[_topic_asked(types, name, every, topic)]


def _topic_asked(types: Mapping[str, set[str]], name: str, every: str, topic: str) -> str:
    """The topic that is asked for, with its slash.

    Raises:
        TrajectoryError: it is not there, or has no joint values.
    """
    key = topic if topic in types else f"/{topic}"
    if key not in types:
        raise TrajectoryError("there is no such topic", where=name, got=topic, allowed=every or "none is in it")
    if len(types[key]) > 1 or not types[key] <= set(_KINDS):
        raise TrajectoryError("the topic has no joint values that are understood", where=f"{name}, topic {topic}",
                              got=", ".join(sorted(types[key])), allowed=" or ".join(_KINDS))  # fmt: skip
    return key


def _only_topic(types: Mapping[str, set[str]], name: str, every: str) -> str:
    """The one topic that has joint values.

    Raises:
        TrajectoryError: there is none, or several.
    """
    fitting = [key for key, kinds in types.items() if kinds <= set(_KINDS)]
    if not fitting:
        raise TrajectoryError("no topic has joint values", where=name, got=every or "an empty bag",
                              allowed=" or ".join(_KINDS))  # fmt: skip
    if len(fitting) > 1:
        raise TrajectoryError("several topics have joint values", where=name, got=every,
                              mend=f"topic={fitting[0]!r}", typed=f"--topic {fitting[0]}")  # fmt: skip
    return fitting[0]


@dataclass
class _BagRows:
    """What was read so far.

    Attributes:
        where: file and topic.
        wanted: names of the arm's joints, in order.
        rows: a JointState is one row, a JointTrajectory one for each of its points.
        starts: first row of each plan.
        others: joints that the arm does not have.
        passed: messages without any of its joints.
    """

    where: str
    wanted: list[str]
    rows: list[Row] = field(default_factory=list)
    starts: list[int] = field(default_factory=list)
    others: set[str] = field(default_factory=set)
    passed: int = 0

    def take(self, message: Any, recorded: int, at: str) -> None:
        """The rows of a message."""
        plan = getattr(message, "points", None) is not None
        if plan:
            names = message.joint_names
        else:
            names = message.name
        self.others.update(set(names) - set(self.wanted))
        missing = [joint for joint in self.wanted if joint not in names]
        if len(missing) == len(self.wanted):
            self.passed += 1
            return
        if missing or any(names.count(joint) > 1 for joint in self.wanted):
            raise TrajectoryError(
                f"the message lacks joints: {', '.join(missing)}" if missing else "a joint is named twice", where=at,
                got=", ".join(names), allowed=", ".join(self.wanted),
            )  # fmt: skip
        if plan:
            self._take_plan(message, names, recorded, at)
        else:
            self._take_state(message, names, recorded, at)

    def _take_state(self, message: Any, names: Sequence[str], recorded: int, at: str) -> None:
        """The row of a JointState."""
        places, header = [names.index(joint) for joint in self.wanted], _nanoseconds(message.header.stamp)
        q = self._values(places, len(names), message.position, at, "position")
        speed = np.asarray(message.velocity, dtype=np.float64)
        if len(speed) == len(names) and bool(np.isfinite(speed[places]).all()):
            qd = speed[places]
        else:
            qd = None  # drivers send empty ones, or NaN: nothing that is needed
        self.rows.append((q, qd, None, header, recorded, 0, at))

    def _take_plan(self, message: Any, names: Sequence[str], recorded: int, at: str) -> None:
        """The rows of a JointTrajectory, one for each of its points."""
        places, header = [names.index(joint) for joint in self.wanted], _nanoseconds(message.header.stamp)
        values = partial(self._values, places, len(names))
        self.starts.append(len(self.rows))
        for number, point in enumerate(message.points, start=1):
            here = f"{at}, point {number}"
            rates = ((point.velocities, "velocity"), (point.accelerations, "acceleration"))
            qd, qdd = (values(some, here, what) if len(some) else None for some, what in rates)
            q, after = values(point.positions, here, "position"), _nanoseconds(point.time_from_start)
            self.rows.append((q, qd, qdd, header, recorded, after, here))

    def _values(self, places: list[int], width: int, values: Any, at: str, what: str) -> Array:
        given = np.asarray(values, dtype=np.float64)
        if len(given) != width:
            raise TrajectoryError(f"there is not one {what} for each name", where=at, got=len(given), allowed=width)
        for joint, value in zip(self.wanted, given[places], strict=True):
            if not np.isfinite(value):
                raise TrajectoryError(f"the {what} is not finite", where=f"{at}, joint {joint!r}", got=value)
        return np.asarray(given[places])

    def pack(self, count: int) -> bytes:
        """Everything that was read of so many messages, in the order of time, as NumPy's archive."""
        if not self.rows:
            got = f"{count} messages" + (f" of {', '.join(sorted(self.others))}" if self.others else "")
            raise TrajectoryError("no message has this arm's joints", where=self.where, got=got,
                                  allowed=", ".join(self.wanted))  # fmt: skip
        q, qd, qdd, header, recorded, after, places = zip(*self.rows, strict=True)
        stamped = all(header)
        starts = header if stamped else recorded
        when = [start + later for start, later in zip(starts, after, strict=True)]
        in_force = self._in_force(starts, when)
        again = {k for i, k in pairwise(in_force) if when[i] == when[k] and (q[i] == q[k]).all()}
        kept = [k for k in in_force if k not in again]
        times = np.array([when[k] - when[kept[0]] for k in kept], dtype=np.float64) * 1e-9
        check_times(times, lambda row: places[kept[row]])
        parts = {}
        for key, column in {"q": q, "qd": qd, "qdd": qdd}.items():
            values = [column[k] for k in kept]
            if all(value is not None for value in values):
                parts[key] = np.array(values)
        notes = [*self._notes(count, stamped=stamped, dropped=len(when) - len(in_force), repeated=len(again))]
        about = {"where": self.where, "notes": notes, "unused": sorted(self.others)}
        buffer = io.BytesIO()
        np.savez(buffer, about=np.array(json.dumps(about)), t=times, **parts)  # type: ignore[arg-type]  # allow_pickle
        return buffer.getvalue()

    def _notes(self, count: int, *, stamped: bool, dropped: int, repeated: int) -> Iterator[tuple[Any, ...]]:
        """Notes on the messages, as facts.

        Args:
            count: of messages.
            stamped: every message has a time of its own.
            dropped: points of plans that a later plan replaced.
            repeated: rows that are the same as the one before.
        """
        if self.passed:
            yield "others", self.passed, count
        if not stamped:
            yield ("recording",)
        if len(self.starts) > 1:
            yield "plans", len(self.starts), dropped
        if repeated:
            yield "repeated", repeated

    def _in_force(self, starts: Sequence[int], when: list[int]) -> list[int]:
        """Rows without those that a later plan has replaced, from its start on."""
        kept: list[int] = []
        begins = set(self.starts)
        for k, start in enumerate(starts):
            if k in begins:
                kept = [row for row in kept if when[row] < start]
            kept.append(k)
        return kept


def _nanoseconds(time: Any) -> int:
    return int(time.sec) * 10**9 + int(time.nanosec)
