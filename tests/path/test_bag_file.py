"""ROS bags: every storage gives the same samples, and every mistake is named with file, topic and message."""

from __future__ import annotations

import builtins
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rankdrop.cli import main
from rankdrop.errors import MissingExtraError, OptionError
from rankdrop.path.read.bag_file import bag_rows
from rankdrop.path.read.files import read_trajectory, trajectories_in
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.robot.open import open_robot

pytest.importorskip("rosbags", reason="bags are written with rosbags: pip install \".[bags]\"")

from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

ARM = open_robot("planar3r")
NAMES = [joint.name for joint in ARM.variables]
Q = np.array([[0.1, 0.5, 0.3], [0.2, 0.6, 0.2], [0.3, 0.8, 0.1]])
T = np.array([0.0, 0.25, 1.0])
START = 1_700_000_000 * 10**9
ROS1, ROS2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.LATEST)
STATE, PLAN = "sensor_msgs/msg/JointState", "trajectory_msgs/msg/JointTrajectory"
Message = tuple[str, str, int, Any]  # topic, type, recorded, message


def stamped(store: Any, nanoseconds: int) -> Any:
    types = store.types
    time = types["builtin_interfaces/msg/Time"](sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)
    more = {"seq": 0} if store is ROS1 else {}
    return types["std_msgs/msg/Header"](stamp=time, frame_id="", **more)


def state(store: Any, names: list[str], q: Any, at: int, speed: Any = ()) -> Any:
    return store.types[STATE](
        header=stamped(store, at), name=list(names), position=np.array(q, dtype=float),
        velocity=np.array(speed, dtype=float), effort=np.zeros(0),
    )  # fmt: skip


def plan(store: Any, names: list[str], q: Any, t: Any, at: int = 0) -> Any:
    point, lasts = store.types["trajectory_msgs/msg/JointTrajectoryPoint"], "builtin_interfaces/msg/Duration"
    points = [
        point(
            positions=np.array(row, dtype=float), velocities=np.array(row, dtype=float) / 2,
            accelerations=np.zeros(0), effort=np.zeros(0),
            time_from_start=store.types[lasts](sec=int(s), nanosec=round((s % 1) * 1e9)),
        )
        for row, s in zip(q, t, strict=True)
    ]  # fmt: skip
    return store.types[PLAN](header=stamped(store, at), joint_names=list(names), points=points)


def states(store: Any, q: Any = Q, t: Any = T, topic: str = "/joint_states", **more: Any) -> list[Message]:
    """One message a row, joints backwards, a finger beside them."""
    names = ["finger", *NAMES[::-1]]
    return [
        (topic, STATE, START + k, state(store, names, [0.5, *row[::-1]], START + round(s * 1e9), **more))
        for k, (row, s) in enumerate(zip(q, t, strict=True))
    ]


def write(path: Path, kind: str, make: Callable[[Any], list[Message]], packed: str | None = None) -> Path:
    """A bag of these messages, packed in a way of rosbags."""
    if kind == "bag":
        store, path = ROS1, path.with_suffix(".bag")
        writer: Any = Writer1(path)
    else:
        store = ROS2
        writer = Writer2(path, version=9, storage_plugin=StoragePlugin[kind.upper()])
    if packed is not None and kind == "bag":
        writer.set_compression(Writer1.CompressionFormat[packed])
    elif packed is not None:
        writer.set_compression(CompressionMode[packed], CompressionFormat.ZSTD)
    with writer as bag:
        lines: dict[str, Any] = {}
        for topic, sort, recorded, message in make(store):
            if topic not in lines:
                lines[topic] = bag.add_connection(topic, sort, typestore=store)
            packed = store.serialize_ros1(message, sort) if kind == "bag" else store.serialize_cdr(message, sort)
            bag.write(lines[topic], recorded, packed)
    return path


KINDS = ("bag", "sqlite3", "mcap")


@pytest.mark.by_hand
@pytest.mark.by_hand_at("states-sqlite3", "plan-mcap")
@pytest.mark.slow_at("states-sqlite3", "states-mcap", "plan-mcap", "plan-sqlite3")
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("what", ["states", "plan"])
def test_every_storage_gives_the_same_samples(tmp_path: Path, kind: str, what: str) -> None:
    def make(store: Any) -> list[Message]:
        if what == "states":
            return states(store)
        return [("/plan", PLAN, START, plan(store, NAMES[::-1], Q[:, ::-1], T))]

    path = write(tmp_path / "one", kind, make)
    for file in [path, *(one for one in path.glob("*") if one.suffix != ".yaml")]:
        read = read_trajectory(file, ARM)
        np.testing.assert_array_equal(read.q, Q)
        np.testing.assert_allclose(read.times, T, atol=1e-12)
        assert read.timed
        assert read.unused == (("finger",) if what == "states" else ())
        assert (read.velocities is None) == (what == "states")
        if read.velocities is not None:
            np.testing.assert_array_equal(read.velocities, Q / 2)


PACKED = [("bag", "BZ2"), ("bag", "LZ4"), ("sqlite3", "FILE"), ("sqlite3", "MESSAGE"), ("mcap", "FILE"),
          ("mcap", "MESSAGE"), ("mcap", "STORAGE")]  # fmt: skip


@pytest.mark.spread(4)
@pytest.mark.by_hand_at("sqlite3-MESSAGE")
@pytest.mark.slow
@pytest.mark.parametrize(("kind", "packed"), PACKED)
def test_every_compression_gives_the_same_samples(
    kind: str, packed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`ros2 bag record --compression-mode file` needs a temporary folder: nothing is left in it."""
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(scratch))
    path = write(tmp_path / "one", kind, states, packed)
    np.testing.assert_array_equal(read_trajectory(path, ARM).q, Q)
    assert list(scratch.iterdir()) == []


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="no such limit")
def test_a_recording_that_unpacks_to_too_much_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(scratch))
    path = write(tmp_path / "one", "sqlite3", states, "FILE")
    monkeypatch.setattr("rankdrop.path.read.bag_file._SCRATCH", 4096)
    monkeypatch.setattr("rankdrop.path.read.bag_file._RATIO", 0)
    with pytest.raises(TrajectoryError, match=r"one: the files of the recording unpack to too much; allowed: "):
        read_trajectory(path, ARM)
    assert list(scratch.iterdir()) == []


@pytest.mark.parametrize("kind", ["bag", "mcap"])
@pytest.mark.parametrize("length", [2**31, 2**40, 2**62])
def test_a_damaged_length_is_damage(kind: str, length: int, tmp_path: Path) -> None:
    """It was said to need more than 1 GB of memory."""
    path = write(tmp_path / "b", kind, states)
    file = path if kind == "bag" else next(one for one in path.iterdir() if one.suffix != ".yaml")
    whole = file.read_bytes()
    place, width = (13, 4) if kind == "bag" else (9, 8)  # of the first length of the file
    value = min(length, 2 ** (8 * width) - 1).to_bytes(width, "little")
    file.write_bytes(whole[:place] + value + whole[place + width :])
    for one in {path, file}:
        with pytest.raises(TrajectoryError, match=r"b.*damaged or cut off"):
            bag_rows(str(one), NAMES, None)


@pytest.mark.parametrize("path", [Path("x"), Path("/x") / "y"])
def test_no_reader_is_asked_for_more_than_a_file_has(path: Path, tmp_path: Path) -> None:
    from rankdrop.path.read.bag_file import _MeasuredPath

    file = _MeasuredPath(tmp_path) / path.name
    file.write_bytes(bytes(100))
    with file.open("rb") as stream:
        assert len(stream.read(200)) == 100
        with pytest.raises(OverflowError):
            stream.read(2**30)
        assert stream.read() == b""


@pytest.mark.by_hand
def test_of_several_topics_one_is_chosen(tmp_path: Path) -> None:
    path = write(tmp_path / "two", "mcap", lambda s: states(s) + states(s, Q + 1, topic="/other"))
    with pytest.raises(TrajectoryError, match=r"two: several topics have joint values; got /joint_states \(JointState"):
        read_trajectory(path, ARM)
    np.testing.assert_allclose(read_trajectory(path, ARM, topic="/other").q, Q + 1)
    np.testing.assert_allclose(read_trajectory(path, ARM, topic="other").q, Q + 1)
    with pytest.raises(TrajectoryError, match=r"two: there is no such topic; got /third; allowed: /joint_states"):
        read_trajectory(path, ARM, topic="/third")
    csv = tmp_path / "a.csv"
    csv.write_text("q1,q2,q3\n0,1,1\n")
    with pytest.raises(OptionError, match=r"a\.csv: only a bag has topics"):
        read_trajectory(csv, ARM, topic="/other")


@pytest.mark.slow
def test_messages_of_other_joints_are_passed_over_and_told(tmp_path: Path) -> None:
    def make(store: Any) -> list[Message]:
        other = ("/joint_states", STATE, START + 1, state(store, ["finger"], [0.0], START))
        return [states(store)[0], other, *states(store)[1:]]

    read = read_trajectory(write(tmp_path / "b", "sqlite3", make), ARM)
    np.testing.assert_array_equal(read.q, Q)
    assert read.notes == ("1 of 4 messages have none of this arm's joints and are passed over",)


@pytest.mark.slow
def test_headers_without_times_and_repeated_rows(tmp_path: Path) -> None:
    def make(store: Any) -> list[Message]:
        rows = [("/s", STATE, START + round(s * 1e9), state(store, NAMES, q, 0)) for q, s in zip(Q, T, strict=True)]
        return [rows[0], rows[1], rows[1], rows[2]]

    read = read_trajectory(write(tmp_path / "b", "bag", make), ARM)
    np.testing.assert_allclose(read.times, T)
    assert "headers have no times: those of the recording are taken" in read.notes
    assert "1 rows are repeated word for word and count once" in read.notes


@pytest.mark.slow
def test_a_plan_takes_the_place_of_the_one_before(tmp_path: Path) -> None:
    def make(store: Any) -> list[Message]:
        return [("/plan", PLAN, START + round(at * 1e9), plan(store, NAMES, q, T, START + round(at * 1e9)))
                for q, at in ((Q, 0.0), (Q + 1, 0.5))]  # fmt: skip

    read = read_trajectory(write(tmp_path / "b", "mcap", make), ARM)
    np.testing.assert_allclose(read.times, [0.0, 0.25, 0.5, 0.75, 1.5])
    np.testing.assert_allclose(read.q, np.concatenate([Q[:2], Q + 1]))
    assert read.notes == ("2 plans follow each other; 1 points were replaced",)


@pytest.mark.by_hand
def test_velocities_that_are_no_numbers_are_left_out(tmp_path: Path) -> None:
    good = write(tmp_path / "a", "mcap", lambda s: states(s, speed=[1.0, 0.1, 0.2, 0.3]))
    np.testing.assert_array_equal(read_trajectory(good, ARM).velocities, [[0.3, 0.2, 0.1]] * 3)
    bad = write(tmp_path / "b", "mcap", lambda s: states(s, speed=[0, np.nan, 0, 0]))
    assert read_trajectory(bad, ARM).velocities is None


def changed(row: int, joint: int, value: float) -> np.ndarray:
    q = Q.copy()
    q[row, joint] = value
    return q


BROKEN: dict[str, Callable[[Any], list[Message]]] = {
    r"b, topic /joint_states, message 2, joint 'joint2': the position is not finite; got nan":
        lambda s: states(s, changed(1, 1, np.nan)),
    r"b, topic /joint_states, message 3: time does not go on": lambda s: states(s, t=[0.0, 0.5, 0.25]),
    r"b, topic /s, message 1: the message lacks joints: joint3; got joint1, joint2":
        lambda s: [("/s", STATE, START, state(s, NAMES[:2], [0, 1], START))],
    r"b, topic /s, message 1: there is not one position for each name; got 2; allowed: 3":
        lambda s: [("/s", STATE, START, state(s, NAMES, [0, 1], START))],
    r"b, topic /s, message 1: a joint is named twice":
        lambda s: [("/s", STATE, START, state(s, [*NAMES, NAMES[0]], [0, 1, 2, 3], START))],
    r"b, topic /s: no message has this arm's joints; got 1 messages of a; allowed: joint1, joint2, joint3":
        lambda s: [("/s", STATE, START, state(s, ["a"], [0], START))],
    r"b, topic /p, message 1, point 3: time does not go on":
        lambda s: [("/p", PLAN, START, plan(s, NAMES, Q, [0, 1, 1]))],
    r"b: no topic has joint values; got /clock \(std_msgs/msg/Header\); allowed: sensor_msgs/msg/JointState or ":
        lambda s: [("/clock", "std_msgs/msg/Header", START, stamped(s, START))],
    r"b: no topic has joint values; got an empty bag": lambda s: [],
}  # fmt: skip


@pytest.mark.spread(1)
@pytest.mark.slow
@pytest.mark.parametrize("said", BROKEN)
def test_what_is_wrong_is_named_with_topic_and_message(tmp_path: Path, said: str) -> None:
    path = write(tmp_path / "b", "mcap", BROKEN[said])
    with pytest.raises(TrajectoryError, match=said):
        read_trajectory(path, ARM)


@pytest.mark.by_hand
def test_a_topic_of_another_type_is_named(tmp_path: Path) -> None:
    path = write(tmp_path / "b", "sqlite3", lambda s: [("/c", "std_msgs/msg/Header", START, stamped(s, 1)), *states(s)])
    np.testing.assert_array_equal(read_trajectory(path, ARM).q, Q)
    with pytest.raises(TrajectoryError, match=r"topic /c: the topic has no joint values that are understood; got std_"):
        read_trajectory(path, ARM, topic="/c")


@pytest.mark.slow_at("sqlite3")
@pytest.mark.parametrize("kind", KINDS)
def test_a_truncated_bag_is_never_read_in_part(tmp_path: Path, kind: str) -> None:
    rng, count = np.random.default_rng(3), 400
    q, t = rng.uniform(-1, 1, (count, 3)), np.arange(count) * 0.01
    path = write(tmp_path / "long", kind, lambda s: states(s, q, t))
    file = path if kind == "bag" else next(one for one in path.iterdir() if one.suffix != ".yaml")
    whole = file.read_bytes()
    for share in (0.0, 0.01, 0.3, 0.7, 0.97, 0.999):
        file.write_bytes(whole[: int(share * len(whole))])
        for one in {path, file}:
            with pytest.raises(TrajectoryError, match=r"long.*(damaged or cut off|is cut off)"):
                bag_rows(str(one), NAMES, None)
    if kind == "sqlite3":  # said of the file itself: newer versions of SQLite read what is there
        with pytest.raises(TrajectoryError, match=r"is cut off; got [\d,]+ of [\d,]+ bytes"):
            read_trajectory(path, ARM)


@pytest.mark.by_hand
@pytest.mark.slow_at("sqlite3", "bag", "mcap")
@pytest.mark.parametrize("kind", KINDS)
def test_a_bag_cut_or_changed_anywhere_is_read_or_refused_in_one_sentence(tmp_path: Path, kind: str) -> None:
    path = write(tmp_path / "b", kind, states)
    file = path if kind == "bag" else next(one for one in path.iterdir() if one.suffix != ".yaml")
    whole, rng = file.read_bytes(), np.random.default_rng(4)
    step = len(whole) // 70
    cases = [whole[:at] for at in range(0, len(whole), step)]
    cases += [whole[:at] + rng.bytes(8) + whole[at + 8 :] for at in range(0, len(whole), step)]
    cases += [whole[:at] + b"\xff" * 7 + b"\x00" + whole[at + 8 :] for at in range(0, len(whole), step)]
    cuts = range(len(whole[::step]))
    for number, content in enumerate(cases):
        file.write_bytes(content)
        try:
            bag_rows(str(file), NAMES, None)
            assert number not in cuts
        except TrajectoryError as error:
            said = str(error)
            assert said.startswith(str(file))
            assert not re.search(r"; got \w+:(;|$)", said), said


def test_what_a_damaged_file_raises_in_python_is_said_in_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(tmp_path / "b", "mcap", states)
    for kind, words in ((OverflowError, "a record that is longer than any file"), (AssertionError, "contradict")):

        def fails(*_: Any, kind: type[Exception] = kind, **__: Any) -> None:
            raise kind

        monkeypatch.setattr("rosbags.rosbag2.Reader.open", fails)
        with pytest.raises(TrajectoryError, match=rf"b: the bag cannot be read.*got .*{words}.*; fix: mend the bag"):
            bag_rows(str(path), NAMES, None)


@pytest.mark.slow
def test_another_version_of_the_type_is_refused(tmp_path: Path) -> None:
    other = get_typestore(Stores.EMPTY)
    other.register({"sensor_msgs/msg/JointState": ([], [("name", (1, ("string", 0)))])})
    with Writer1(tmp_path / "b.bag") as bag:
        line = bag.add_connection("/s", STATE, typestore=other)
        bag.write(line, START, other.serialize_ros1(other.types[STATE](name="x"), STATE))
    with pytest.raises(TrajectoryError, match=r"b\.bag, topic /s: this is another version of the type; got sens"):
        read_trajectory(tmp_path / "b.bag", ARM)


def test_without_rosbags_the_command_that_helps_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.bag").write_bytes(b"")
    real = builtins.__import__

    def without(name: str, *rest: Any, **more: Any) -> Any:
        if name.startswith("rosbags"):
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(MissingExtraError, match=r'needs the package rosbags; .*pip install "\.\[bags\]"'):
        read_trajectory(tmp_path / "a.bag", ARM)


@pytest.mark.by_hand
def test_the_command_reads_bags_and_folders_of_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    write(tmp_path / "run1", "mcap", states)
    write(tmp_path / "run2", "sqlite3", lambda s: states(s) + states(s, topic="/other"))
    write(tmp_path / "old", "bag", states)
    assert [one.name for one in trajectories_in(tmp_path)] == ["old.bag", "run1", "run2"]
    assert main.run(["path", "planar3r", str(tmp_path / "run1"), "--quiet"]) == 0
    told = capsys.readouterr()
    assert told.out.startswith("Free: proven")
    assert "run1: not used: finger" in told.err
    assert main.run(["path", "planar3r", str(tmp_path / "run2"), "--quiet"]) == 2
    assert "fix: --topic /joint_states" in capsys.readouterr().err
    assert main.run(["path", "planar3r", str(tmp_path / "run2"), "--topic", "/other", "--quiet"]) == 0
    assert main.run(["path", "planar3r", str(tmp_path), "--quiet"]) == 2
    assert "2 of 3 paths proven free" in capsys.readouterr().out


@pytest.mark.by_hand
@pytest.mark.slow_at("bag", "mcap")
@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_a_bag_that_unpacks_to_more_than_its_limit_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    """Compressed zeros: before there was a limit a bag of 6 kB took 3.15 GB. Here both are smaller."""
    if kind == "bag":
        path, store = tmp_path / "bomb.bag", ROS1
        writer: Any = Writer1(path)
        writer.set_compression(Writer1.CompressionFormat.BZ2)
    else:
        path, store = tmp_path / "bomb", ROS2
        writer = Writer2(path, version=9, storage_plugin=StoragePlugin.MCAP)
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    message = state(store, NAMES, Q[0], START)
    message.effort = np.zeros(10_000_000)
    with writer as bag:
        line = bag.add_connection("/joint_states", STATE, typestore=store)
        bag.write(line, START, (store.serialize_ros1 if kind == "bag" else store.serialize_cdr)(message, STATE))
    assert sum(one.stat().st_size for one in tmp_path.rglob("*") if one.is_file()) < 100_000
    assert read_trajectory(path, ARM).q.shape == (1, 3)
    monkeypatch.setattr("rankdrop.path.read.bag_file.MEMORY", 200 * 2**20)
    with pytest.raises(TrajectoryError, match=r"bomb.*: the reader of ROS bags needs more than 0\.195312 GB of memory"):
        read_trajectory(path, ARM)
