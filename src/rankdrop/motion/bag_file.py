"""A joint trajectory from a ROS bag: ROS 1 (.bag), ROS 2 (.db3, .mcap, or the folder of a recording).

Two types of message hold joint values by name: sensor_msgs/JointState, one row each, and
trajectory_msgs/JointTrajectory, a plan each. Times are of the header, of the recording where a header has none, and
count from the first row.
"""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from rankdrop.errors import MissingExtraError, RankdropError
from rankdrop.jobs.limited import CPU, MEMORY, run_limited
from rankdrop.motion.trajectory import Trajectory, TrajectoryError, arranged, checked_times
from rankdrop.robot.files import MOST_ROWS
from rankdrop.robot.model import Array, Robot

BAGS = (".bag", ".db3", ".mcap")
_STATE, _PLAN = "sensor_msgs/msg/JointState", "trajectory_msgs/msg/JointTrajectory"
_KINDS = {_STATE: "JointState", _PLAN: "JointTrajectory"}
_MEND = "mend the bag first: rosbag reindex, ros2 bag reindex, or mcap recover"
_LISTED = 12  # topics that an error names
_SECONDS = 1.0  # of the processor for each MB of a bag, besides those that every file has
_MEANT: dict[type[Exception], str] = {
    OverflowError: "a record that is longer than any file",
    AssertionError: "records that contradict each other",
    **dict.fromkeys((KeyError, IndexError), "a record about one that is not there"),
    UnicodeDecodeError: "a name that is no text",
}
"""What the errors of Python mean that a damaged file raises; readers say the others themselves."""


def is_bag(path: Path) -> bool:
    """Whether it is a bag: a file by its ending, or the folder of a ROS 2 recording."""
    if path.is_dir():
        return (path / "metadata.yaml").is_file()
    return path.suffix.lower() in BAGS


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
    size = sum(one.stat().st_size for one in (path.iterdir() if path.is_dir() else [path]))
    names = [joint.name for joint in robot.variables]
    content = run_limited(bag_rows, name, names, topic, file=path, parser="the reader of ROS bags",
                          memory=MEMORY, cpu=CPU + int(_SECONDS * size / 1e6), error=TrajectoryError)  # fmt: skip
    parts = np.load(io.BytesIO(content))
    about = json.loads(str(parts["about"]))
    found = arranged(about["where"], robot, parts, deg=deg)
    return replace(found, name=path.name, notes=tuple(about["notes"]), unused=tuple(about["unused"]))


def bag_rows(name: str, joints: list[str], topic: str | None) -> bytes:
    """Rows of a bag as NumPy's archive of `q`, `t`, `qd`, `qdd`, and `about` in JSON; runs in a child process.

    Raises:
        TrajectoryError: as `read_bag`.
    """
    store, reader, digest = _opened(Path(name))
    with _reading(name), reader as bag:
        chosen = _topic(list(bag.connections), name, topic)
        where = f"{name}, topic {chosen[0].topic}"
        for one in chosen:
            if one.digest and one.digest != digest(one.msgtype):
                raise TrajectoryError("this is another version of the type", where=where, got=one.msgtype,
                                      allowed="the fields of ROS's own message")  # fmt: skip
        promised = sum(one.msgcount for one in chosen)
        with _reading(where):
            rows = _Rows(where, joints)
            take = rows.state if chosen[0].msgtype == _STATE else rows.plan
            for connection, stamp, data in bag.messages(connections=chosen):
                rows.number += 1
                with _reading(f"{where}, message {rows.number}"):
                    message = store(data, connection.msgtype)
                take(message, stamp)
                if len(rows.q) > MOST_ROWS:
                    raise TrajectoryError("there are too many rows", where=where, allowed=f"at most {MOST_ROWS}")
            if rows.number < promised:
                raise TrajectoryError("the bag is cut off", where=where, mend=_MEND,
                                      got=f"{rows.number} of {promised} messages")  # fmt: skip
    return rows.packed()


def _opened(path: Path) -> tuple[Callable[[bytes, str], Any], Any, Callable[[str], str]]:
    """How to read a message, the reader, and the digest that a type of ROS's own has."""
    from rosbags.rosbag1 import Reader as Reader1
    from rosbags.rosbag2 import Reader as Reader2
    from rosbags.typesys import Stores, get_typestore

    with _reading(str(path)):
        if path.suffix.lower() == ".bag":
            store = get_typestore(Stores.ROS1_NOETIC)
            return store.deserialize_ros1, Reader1(path), lambda kind: str(store.generate_msgdef(kind)[1])
        for file in [path] if path.is_file() else sorted(path.glob("*.db3")):
            _check_database(file)
        store = get_typestore(Stores.LATEST)
        return store.deserialize_cdr, Reader2(path), lambda kind: str(store.hash_rihs01(kind))


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
                              mend=_MEND)  # fmt: skip


@contextmanager
def _reading(where: str) -> Iterator[None]:
    """Whatever a reader meets in a damaged file (zlib, SQLite, struct, its own errors) as one error of ours."""
    try:
        yield
    except (RankdropError, MemoryError):  # the process that reads a bag has a limit on its memory
        raise
    except Exception as error:
        got = _MEANT.get(type(error)) or " ".join(f"{type(error).__name__}: {error}".split())[:160]
        raise TrajectoryError("the bag cannot be read, it is damaged or cut off", where=where, got=got,
                              mend=_MEND) from error  # fmt: skip


def _topic(connections: list[Any], name: str, topic: str | None) -> list[Any]:
    """The connections of the topic that is read.

    Raises:
        TrajectoryError: none, or several, can be meant.
    """
    found: dict[str, list[Any]] = {}
    for one in connections:
        found.setdefault(one.topic, []).append(one)
    listed = [f"{key} ({_KINDS.get(found[key][0].msgtype, found[key][0].msgtype)})" for key in sorted(found)]
    every = ", ".join(listed[:_LISTED]) + (f" and {len(listed) - _LISTED} more" if len(listed) > _LISTED else "")
    if topic is not None:
        asked = found.get(topic) or found.get(f"/{topic}")
        if asked is None:
            raise TrajectoryError("there is no such topic", where=name, got=topic, allowed=every or "none is in it")
        kinds = {one.msgtype for one in asked}
        if len(kinds) > 1 or not kinds <= set(_KINDS):
            raise TrajectoryError("the topic has no joint values that are understood", where=f"{name}, topic {topic}",
                                  got=", ".join(sorted(kinds)), allowed=" or ".join(_KINDS))  # fmt: skip
        return asked
    fitting = [key for key in sorted(found) if {one.msgtype for one in found[key]} <= set(_KINDS)]
    if not fitting:
        raise TrajectoryError("no topic has joint values", where=name, got=every or "an empty bag",
                              allowed=" or ".join(_KINDS))  # fmt: skip
    if len(fitting) > 1:
        raise TrajectoryError("several topics have joint values", where=name, got=every,
                              mend=f"topic={fitting[0]!r}", typed=f"--topic {fitting[0]}")  # fmt: skip
    return found[fitting[0]]


@dataclass
class _Rows:
    """What was read so far.

    Attributes:
        where: file and topic.
        wanted: names of the arm's joints, in order.
        number: of the last message, from 1.
        times: by header and by recording [ns]; those of a plan's points count from the start of the plan.
    """

    where: str
    wanted: list[str]
    number: int = 0
    q: list[Array] = field(default_factory=list)
    qd: list[Array | None] = field(default_factory=list)
    qdd: list[Array | None] = field(default_factory=list)
    stamps: list[tuple[int, int]] = field(default_factory=list)
    after: list[int] = field(default_factory=list)
    places: list[str] = field(default_factory=list)
    others: set[str] = field(default_factory=set)
    passed: int = 0
    plans: int = 0

    def state(self, message: Any, recorded: int) -> None:
        """A JointState: one row."""
        at = f"{self.where}, message {self.number}"
        places = self._places(message.name, at)
        if places is None:
            return
        self.q.append(self._values(message.position, places, len(message.name), at, "position"))
        speed = np.asarray(message.velocity, dtype=np.float64)
        good = len(speed) == len(message.name) and bool(np.isfinite(speed[places]).all())
        self.qd.append(speed[places] if good else None)  # drivers send empty ones, or NaN: nothing that is needed
        self.qdd.append(None)
        self.stamps.append((_nanoseconds(message.header.stamp), recorded))
        self.after.append(0)
        self.places.append(at)

    def plan(self, message: Any, recorded: int) -> None:
        """A JointTrajectory: a row for each point."""
        at = f"{self.where}, message {self.number}"
        places = self._places(message.joint_names, at)
        if places is None:
            return
        self.plans += 1
        width = len(message.joint_names)
        stamp = (_nanoseconds(message.header.stamp), recorded)
        for row, point in enumerate(message.points, start=1):
            here = f"{at}, point {row}"
            self.q.append(self._values(point.positions, places, width, here, "position"))
            for kept, values, what in (
                (self.qd, point.velocities, "velocity"), (self.qdd, point.accelerations, "acceleration")
            ):
                kept.append(self._values(values, places, width, here, what) if len(values) else None)
            self.stamps.append(stamp)
            self.after.append(_nanoseconds(point.time_from_start))
            self.places.append(here)

    def _places(self, names: list[str], at: str) -> list[int] | None:
        """Where the arm's joints stand in a message; None where it has none of them."""
        self.others.update(set(names) - set(self.wanted))
        missing = [one for one in self.wanted if one not in names]
        if len(missing) == len(self.wanted):
            self.passed += 1
            return None
        twice = sorted({one for one in self.wanted if names.count(one) > 1})
        if missing or twice:
            raise TrajectoryError(
                f"the message lacks joints: {', '.join(missing)}" if missing else "a joint is named twice", where=at,
                got=", ".join(names), allowed=", ".join(self.wanted),
            )  # fmt: skip
        return [names.index(one) for one in self.wanted]

    def _values(self, values: Any, places: list[int], width: int, at: str, what: str) -> Array:
        given = np.asarray(values, dtype=np.float64)
        if len(given) != width:
            raise TrajectoryError(f"there is not one {what} for each name", where=at, got=len(given), allowed=width)
        for joint, value in zip(self.wanted, given[places], strict=True):
            if not np.isfinite(value):
                raise TrajectoryError(f"the {what} is not finite", where=f"{at}, joint {joint!r}", got=value)
        return np.asarray(given[places])

    def packed(self) -> bytes:
        """Everything that was read, in the order of time, as NumPy's archive."""
        if not self.q:
            got = f"{self.number} messages" + (f" of {', '.join(sorted(self.others))}" if self.others else "")
            raise TrajectoryError("no message has this arm's joints", where=self.where, got=got,
                                  allowed=", ".join(self.wanted))  # fmt: skip
        notes = []
        if self.passed:
            notes.append(f"{self.passed} of {self.number} messages have none of this arm's joints and are passed over")
        stamped = all(stamp for stamp, _ in self.stamps)
        if not stamped:
            notes.append("headers have no times: those of the recording are taken")
        starts = [stamp if stamped else recorded for stamp, recorded in self.stamps]
        when = [start + after for start, after in zip(starts, self.after, strict=True)]
        kept = self._in_force(starts, when) if self.plans > 1 else list(range(len(when)))
        if self.plans > 1:
            notes.append(f"{self.plans} plans follow each other; {len(when) - len(kept)} points were replaced")
        again = [k for i, k in pairwise(kept) if when[i] == when[k] and (self.q[i] == self.q[k]).all()]
        if again:
            notes.append(f"{len(again)} rows are repeated word for word and count once")
            kept = [k for k in kept if k not in set(again)]
        times = np.array([when[k] - when[kept[0]] for k in kept], dtype=np.float64) * 1e-9
        checked_times(times, [self.places[k] for k in kept])
        parts = {"t": times, "q": np.array([self.q[k] for k in kept])}
        for key, values in (("qd", self.qd), ("qdd", self.qdd)):
            if all(values[k] is not None for k in kept):  # every row has them
                parts[key] = np.array([values[k] for k in kept])
        about = json.dumps({"where": self.where, "notes": notes, "unused": sorted(self.others)})
        buffer = io.BytesIO()
        np.savez(buffer, about=np.array(about), **parts)  # type: ignore[arg-type]  # allow_pickle is no array
        return buffer.getvalue()

    def _in_force(self, starts: list[int], when: list[int]) -> list[int]:
        """Rows of plans, without those that a later plan has replaced."""
        kept: list[int] = []
        for k, start in enumerate(starts):
            if k == 0 or self.places[k].rpartition(",")[0] != self.places[k - 1].rpartition(",")[0]:  # a plan begins
                kept = [one for one in kept if when[one] < start]
            kept.append(k)
        return kept



def _nanoseconds(time: Any) -> int:
    return int(time.sec) * 10**9 + int(time.nanosec)
