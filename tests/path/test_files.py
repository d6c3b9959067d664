"""Trajectory files: every kind comes out the same, and every mistake is named by file and row."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from rankdrop.path.read.files import read_trajectory
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.robot.open import open_robot

ARM = open_robot("scara")
NAMES = [joint.name for joint in ARM.variables]
Q = np.array([[0.1, 0.2, 0.05, 0.4], [0.2, 0.3, 0.06, 0.5], [0.3, 0.1, 0.07, 0.6]])
V = Q / 2
T = np.array([0.0, 0.25, 1.0])


def message(names=NAMES, q=Q, v=V, t=T) -> dict:
    return {
        "joint_names": list(names),
        "points": [
            {"positions": list(map(float, q[k])), "velocities": list(map(float, v[k])),
             "time_from_start": {"sec": int(t[k]), "nanosec": int(t[k] % 1 * 1e9)}}
            for k in range(len(q))
        ],
    }  # fmt: skip


def write(folder: Path, kind: str) -> Path:
    file = folder / f"path.{kind}"
    if kind == "csv":
        order = [2, 0, 3, 1]
        lines = [",".join(["time", *(NAMES[i] for i in order)])]
        lines += [",".join([repr(float(T[k])), *(repr(float(Q[k, i])) for i in order)]) for k in range(3)]
        file.write_text("\n".join(lines))
    elif kind == "txt":  # no header: a time that rises in front
        file.write_text("\n".join(";".join(map(repr, [float(T[k]), *map(float, Q[k])])) for k in range(3)))
    elif kind == "npy":
        np.save(file, np.c_[T, Q])
    elif kind == "npz":
        order = [3, 1, 0, 2]
        np.savez(file, q=Q[:, order], qd=V[:, order], t=T, joint_names=np.array([NAMES[i] for i in order]))
    elif kind == "json":
        order = [1, 3, 2, 0]
        file.write_text(json.dumps({"trajectory": {"joint_trajectory": message(
            [NAMES[i] for i in order], Q[:, order], V[:, order])}}))  # fmt: skip
    else:
        yaml = pytest.importorskip("yaml")
        file.write_text(yaml.safe_dump({"header": 1}) + "---\n" + yaml.safe_dump(message()))
    return file


@pytest.mark.parametrize("kind", ["csv", "txt", "npy", "npz", "json", "yaml", "yml"])
def test_every_kind_gives_the_same_samples(tmp_path: Path, kind: str) -> None:
    read = read_trajectory(write(tmp_path, kind), ARM)
    np.testing.assert_allclose(read.q, Q, atol=1e-15)
    np.testing.assert_allclose(read.times, T, atol=1e-15)
    assert read.timed
    assert read.name == f"path.{kind}"
    assert (read.velocities is None) == (kind in ("csv", "txt", "npy"))
    if read.velocities is not None:
        np.testing.assert_allclose(read.velocities, V, atol=1e-15)


def test_degrees_turn_angles_only_their_rates_too(tmp_path: Path) -> None:
    for kind in ("csv", "json", "npy"):
        read = read_trajectory(write(tmp_path, kind), ARM, deg=True)
        np.testing.assert_allclose(read.q, Q * np.where([True, True, False, True], np.pi / 180, 1.0))
        if read.velocities is not None:
            np.testing.assert_allclose(read.velocities[:, 0], V[:, 0] * np.pi / 180)


def test_numbers_alone_without_a_time(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", Q)
    read = read_trajectory(tmp_path / "a.npy", ARM)
    assert not read.timed
    np.testing.assert_array_equal(read.q, Q)


def change(record: dict, row: int, key: str, value: object) -> dict:
    record["points"][row][key] = value
    return record


BROKEN = {
    "a.csv|q1,q2,q3,q4\n0,0,0,0\n0,nan,0,0\n": r"a\.csv, line 3, column 2 \(q2\): the value is not finite",
    "a.csv|q1,q2,q3,q4\n0,0,0,0\n0,x,0,0\n": r"a\.csv, line 3, column 2 \(q2\): this is no number; got 'x'",
    "a.csv|q1,q2,q3,q4\n0,0,0\n": r"a\.csv, line 2, column 4 \(q4\): the row is too short; got 3 columns",
    "a.csv|q1,q2,q3,q4\n0,0,0,0,5\n": r"a\.csv, line 2: the row is too long; got 5 columns; allowed: 4",
    "a.csv|q1,q2,q3\n0,0,0\n": r"a\.csv, line 1: joints have no column",
    "a.csv|t,q1,q2,q3,q4\n1,0,0,0,0\n1,0,0,0,0\n": r"a\.csv, line 3, column 't': time does not go on; got 1 after 1",
    "a.csv|0,0,0,0,0\n0,0,0,0,0\n": r"a\.csv, line 1: the columns have no names; got 5 numbers",
    "a.json|{": r"a\.json, line 1: this is not JSON",
    "a.json|{}": r"a\.json: there is no JointTrajectory in it",
    "a.json|" + json.dumps(message(["a", *NAMES[1:]])): rf"a\.json: joints are missing; .* add {NAMES[0]}",
    "a.json|" + json.dumps(message([NAMES[1], *NAMES[1:]])): r"a\.json: a joint is named twice",
    "a.json|" + json.dumps(change(message(), 1, "positions", [1.0])):
        r"a\.json, row 2: positions has another length than joint_names; got 1 numbers; allowed: 4",
    "a.json|" + json.dumps(change(message(), 2, "positions", [1.0, float("nan"), 0.0, 0.0])):
        r"a\.json, row 3, joint '.*': the position is not finite",
    "a.json|" + json.dumps(change(message(), 1, "positions", ["1", 0.0, 0.0, 0.0])):
        r"a\.json, row 2: positions has a value that is no number",
    "a.json|" + json.dumps(change(message(), 2, "time_from_start", 0.1)):
        r"a\.json, row 3: time does not go on; got 0.1 after 0.25",
    "a.json|" + json.dumps(change(message(), 1, "time_from_start", None)): r"a\.json, row 2: the point has no time",
    "a.json|" + json.dumps(change(message(), 1, "time_from_start", {"s": 1})): r"a\.json, row 2: this is no time",
    "a.json|" + json.dumps(change(message(), 1, "velocities", None)):
        r"a\.json, row 2: velocities has another length than joint_names",
    "a.npy|no": r"a\.npy: this is not a file of NumPy's",
    "a.npz|no": r"a\.npz: this is not a file of NumPy's",
    "missing.npy|": r"missing\.npy: the file cannot be read",
    "missing.csv|": r"missing\.csv",
}  # fmt: skip


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_file_is_named_with_its_row(tmp_path: Path, case: str) -> None:
    name, _, text = case.partition("|")
    if not name.startswith("missing"):
        (tmp_path / name).write_text(text)
    with pytest.raises(TrajectoryError, match=BROKEN[case]):
        read_trajectory(tmp_path / name, ARM)


def test_broken_arrays_are_named_with_their_row(tmp_path: Path) -> None:
    bad = Q.copy()
    bad[1, 2] = np.inf
    arrays = {
        "q": (bad, r"a\.npy, row 2, joint .* is not finite"),
        "wide": (np.zeros((3, 6)), r"a\.npy: the positions have another shape than the arm; got shape \(3, 6\)"),
        "flat": (np.zeros(4), r"a\.npy: the positions have another shape"),
        "empty": (np.zeros((0, 4)), r"a\.npy: the positions have another shape"),
        "words": (np.array([["a"] * 4]), r"a\.npy: these are no numbers"),
    }
    for value, said in arrays.values():
        np.save(tmp_path / "a.npy", value)
        with pytest.raises(TrajectoryError, match=said):
            read_trajectory(tmp_path / "a.npy", ARM)
    for parts, said in (
        ({"x": Q}, r"a\.npz: the archive has no positions; got x"),
        ({"q": Q, "t": T[:2]}, r"a\.npz: there is one time for each row"),
        ({"q": Q, "t": T[::-1]}, r"a\.npz, row 2: time does not go on"),
        ({"q": Q, "qd": V[:2]}, r"a\.npz: the velocity has another shape"),
        ({"q": Q, "qd": bad}, r"a\.npz, row 2, joint .*: the velocity is not finite"),
    ):
        np.savez(tmp_path / "a.npz", **parts)
        with pytest.raises(TrajectoryError, match=said):
            read_trajectory(tmp_path / "a.npz", ARM)
