"""Trajectory files: every kind comes out the same, and every mistake is named by file and row."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rankdrop.path.read.csv_file import names_of, parse_trajectory
from rankdrop.path.read.files import read_trajectory
from rankdrop.path.read.poses import holds_poses, read_poses
from rankdrop.path.read.trajectory import TrajectoryError, unit_hint
from rankdrop.path.read.written_poses import poses_bytes
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


@pytest.mark.parametrize("head", ["Zeit;A1;A2;A3;A4\n", "time;Achse1;Achse2;Achse3;Achse4\n", ""])
@pytest.mark.parametrize("separator", [";", "\t"])
def test_decimal_commas_are_read_where_no_comma_separates_columns(tmp_path: Path, head: str, separator: str) -> None:
    lines = [";".join(f"{value:.3f}".replace(".", ",") for value in (T[k], *Q[k])) for k in range(3)]
    file = tmp_path / "german.csv"
    file.write_text((head + "\n".join(lines)).replace(";", separator))
    found = read_trajectory(file, ARM)
    np.testing.assert_array_equal(found.q, Q)
    np.testing.assert_array_equal(found.times, T)
    assert found.notes == ("decimals have commas: 0,5 is read as 0.5",)


@pytest.mark.parametrize("cell", ["1.234,5", "1,234.5", "1,2,3"])
def test_a_cell_with_commas_and_points_is_refused(tmp_path: Path, cell: str) -> None:
    file = tmp_path / "both.csv"
    file.write_text(f"A1;A2;A3;A4\n{cell};0,1;0,2;0,3\n0,1;0,1;0,2;0,3\n")
    with pytest.raises(TrajectoryError, match=r"line 2, column 1 \(A1\): this is no number"):
        read_trajectory(file, ARM)


def test_points_beside_decimal_commas_are_refused(tmp_path: Path) -> None:
    """Either may separate thousands: 0.500 and 0,500 in one file are told apart by nobody."""
    file = tmp_path / "mixed.csv"
    file.write_text("A1;A2;A3;A4\n0.1;0,2;0,3;0,4\n0,1;0,1;0,2;0,3\n")
    with pytest.raises(TrajectoryError, match=r"line 2, column 2 \(A2\): this is no number"):
        read_trajectory(file, ARM)


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


def test_angles_that_look_like_the_other_unit_are_warned_of() -> None:
    assert unit_hint(Q, ARM) is None
    assert "look like degrees" in unit_hint(Q * 100, ARM)
    assert unit_hint(np.array([[0.0, 0.0, 90.0, 0.0]]), ARM) is None  # a slide
    assert "look like radians" in unit_hint(np.radians(Q), ARM, deg=True)
    assert unit_hint(np.radians(Q * 100), ARM, deg=True) is None
    assert unit_hint(np.zeros((3, 4)), ARM, deg=True) is None


def test_a_name_longer_than_the_reader_takes_makes_no_file_of_poses(tmp_path: Path) -> None:
    """Asked for before the file is read, Python's own error came out."""
    file = tmp_path / "long.csv"
    file.write_text("x" * 200_000 + ",y\n1,2\n")
    assert not holds_poses(file, open_robot("planar2r"))
    with pytest.raises(TrajectoryError, match="this is not CSV"):
        names_of(file.read_text(), str(file))


@pytest.mark.filterwarnings("error")
def test_a_signalling_nan_is_refused_before_it_is_multiplied(tmp_path: Path) -> None:
    """Half-precision files can hold one: NumPy warns where it is multiplied."""
    rows = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], dtype=np.float16)
    rows.view(np.uint16)[1, 2] = 0x7D00
    np.save(tmp_path / "a.npy", rows)
    with pytest.raises(TrajectoryError, match="is not finite"):
        read_trajectory(tmp_path / "a.npy", open_robot("planar2r"), deg=True)


HEADS = {
    "time_ms": ("time_ms,Joint 1 [deg],joint_2_deg,J3 (mm),A4_rad", (1e3, 180 / np.pi, 180 / np.pi, 1e3, 1.0)),
    "timestamp_ns": ("timestamp_ns,q1_deg,q2,q3_mm,q4", (1e9, 180 / np.pi, 1.0, 1e3, 1.0)),
    "seconds first": ("time,time_ms,q1,q2,q3,q4", (1.0, 7.0, 1.0, 1.0, 1.0, 1.0)),
    "a plain column first": ("t [µs],q1_deg,q1,q2,q3,q4", (1e6, 7.0, 1.0, 1.0, 1.0, 1.0)),
}


@pytest.mark.parametrize("case", HEADS)
def test_units_in_names_of_columns_are_those_of_the_values(tmp_path: Path, case: str) -> None:
    head, factors = HEADS[case]
    columns = np.c_[T, Q] if len(factors) == 5 else np.c_[T, T, Q]
    if case == "a plain column first":
        columns = np.c_[T, Q[:, 0], Q]
    file = tmp_path / "log.csv"
    file.write_text("\n".join([head, *(",".join(map(repr, row)) for row in (columns * factors).tolist())]))
    read = read_trajectory(file, ARM)
    np.testing.assert_allclose(read.q, Q, rtol=1e-14)
    np.testing.assert_allclose(read.times, T, rtol=1e-14)
    assert read.unused == {"seconds first": ("time_ms",), "a plain column first": ("q1_deg",)}.get(case, ())


@pytest.mark.parametrize("head", ["times_ms,", "stamp_nsec,", "tms,", "t [min],"])
def test_names_that_are_no_unit_of_time_are_reported_as_unused(tmp_path: Path, head: str) -> None:
    file = tmp_path / "log.csv"
    file.write_text(head + "q1,q2,q3,q4\n5,0,0,0,0\n9,0,0,0,0\n")
    read = read_trajectory(file, ARM)
    assert not read.timed
    assert read.unused == (head.rstrip(","),)


def test_a_unit_after_an_underscore_has_to_fit_and_is_given_once(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    for head, said in (("q1_mm,q2,q3,q4", "the unit does not fit the column"),
                       ("q1_deg,q1_rad,q2,q3,q4", "the column is given twice")):  # fmt: skip
        file.write_text(head + "\n" + ",".join("0" * len(head.split(","))) + "\n")
        with pytest.raises(TrajectoryError, match=said):
            read_trajectory(file, ARM)


def test_positions_in_millimetres_are_poses_unless_every_joint_has_a_column(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    file.write_text("time_ms,X_mm,Y_mm,Z_mm\n0,400,100,300\n250,400,200,300\n")
    assert holds_poses(file, ARM)
    read = read_poses(file)
    np.testing.assert_allclose(read.matrices[:, :3, 3], [[0.4, 0.1, 0.3], [0.4, 0.2, 0.3]], rtol=1e-14)
    np.testing.assert_array_equal(read.times, [0.0, 0.25])
    moved = poses_bytes(file, read.matrices[[0, 1, 1]], np.array([0.0, 0.5, 1.0]), np.array([0, 1, -1])).decode()
    assert [line.split(",")[0] for line in moved.splitlines()] == ["time_ms", "0", "500.0", "1000.0"]
    file.write_text("X_mm,Y_mm,Z_mm,q1_deg,q2,q3,Joint 4\n0,0,0,90,0,0,0\n")
    assert not holds_poses(file, ARM)
    assert read_trajectory(file, ARM).q[0, 0] == np.pi / 2


def test_a_joint_whose_name_ends_like_a_unit_states_none(tmp_path: Path) -> None:
    first, *others = ARM.variables
    arm = replace(ARM, joints=tuple(replace(joint, name="tilt_deg") if joint == first else joint
                                    for joint in ARM.joints))  # fmt: skip
    file = tmp_path / "log.csv"
    file.write_text(",".join(["tilt_deg", *(joint.name for joint in others)]) + "\n0.5,0,0,0\n")
    read = read_trajectory(file, arm)
    assert read.bare
    assert read.q[0, 0] == 0.5


def test_a_program_without_a_reader_is_refused_with_how_to_write_its_targets() -> None:
    """Python of a maker's library: it was refused as a table without columns (xArm-Python-SDK#153)."""
    text = "from xarm.wrapper import XArmAPI\narm.set_servo_angle(angle=[0, -45, 0, 0, -45, 0])\n"
    for name in ("a.py", "a.drl"):
        with pytest.raises(TrajectoryError, match=r"no program in a language .*fix: write its targets"):
            parse_trajectory(text, name, open_robot("ur5"))
    with pytest.raises(TrajectoryError, match="joints have no column"):
        parse_trajectory(text, "a.csv", open_robot("ur5"))


def test_numbers_that_spaces_separate_are_columns(tmp_path: Path) -> None:
    """As numpy.savetxt writes them: exactly the doubles that were saved."""
    np.savetxt(tmp_path / "a.txt", np.column_stack([T, Q]), header="q1, q2, saved by hand")
    found = read_trajectory(tmp_path / "a.txt", ARM)
    np.testing.assert_array_equal(found.q, Q)
    np.testing.assert_array_equal(found.times, T)


@pytest.mark.parametrize("text", [
    "0 0 0 1\n0,5 0 0\n", "0 0 0 1\n0 0 0\n", "0 0 0 1\n0 0 0 x\n", "q1 q2 q3 q4\n0 0 0 1\n",
])  # fmt: skip
def test_rows_of_spaces_that_do_not_fit_are_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.txt").write_text(text)
    with pytest.raises(TrajectoryError, match=r"a\.txt, line [12]"):
        read_trajectory(tmp_path / "a.txt", ARM)


@pytest.mark.parametrize("text", [
    '{"points": [{"positions": [1, 2, 3, 4]}, {"positions": [2, 3, 4, 5]}]}',
    '{"joint_names": [], "points": [{"positions": [1, 2, 3, 4]}, {"positions": [2, 3, 4, 5]}]}',
    '[{"positions": [1, 2, 3, 4]}, {"positions": [2, 3, 4, 5]}]',
    "[[1, 2, 3, 4], [2, 3, 4, 5]]",
    '{"trajectory": [[1, 2, 3, 4], [2, 3, 4, 5]]}',
])  # fmt: skip
def test_points_without_names_are_in_the_order_of_the_joints(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.json").write_text(text)
    found = read_trajectory(tmp_path / "a.json", ARM)
    np.testing.assert_array_equal(found.q, [[1, 2, 3, 4], [2, 3, 4, 5]])
    assert any("in the order of the arm's joints" in note for note in found.notes)


def test_points_without_names_have_one_value_for_each_joint(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text("[[1, 2, 3, 4], [2, 3, 4]]")
    with pytest.raises(TrajectoryError, match="row 2: positions has another length than the joints; got 3 num"):
        read_trajectory(tmp_path / "a.json", ARM)
