"""Tables of joint values: separators, decimal commas, units in names of columns, cells that are no number."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rankdrop.path.read.csv_file import names_of, parse_trajectory
from rankdrop.path.read.files import read_trajectory
from rankdrop.path.read.poses import holds_poses, read_poses
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.path.read.written_poses import poses_bytes
from rankdrop.robot.open import open_robot

ARM = open_robot("scara")
Q = np.array([[0.1, 0.2, 0.05, 0.4], [0.2, 0.3, 0.06, 0.5], [0.3, 0.1, 0.07, 0.6]])
T = np.array([0.0, 0.25, 1.0])


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


def test_a_name_longer_than_the_reader_takes_makes_no_file_of_poses(tmp_path: Path) -> None:
    """Asked for before the file is read, Python's own error came out."""
    file = tmp_path / "long.csv"
    file.write_text("x" * 200_000 + ",y\n1,2\n")
    assert not holds_poses(file, open_robot("planar2r"))
    with pytest.raises(TrajectoryError, match="this is not CSV"):
        names_of(file.read_text(), str(file))


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


def test_names_without_spaces_above_such_numbers_are_read(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "a.txt", np.column_stack([T, Q]), header="time q1 q2 q3 q4", comments="")
    found = read_trajectory(tmp_path / "a.txt", ARM)
    np.testing.assert_array_equal(found.q, Q)
    np.testing.assert_array_equal(found.times, T)


@pytest.mark.parametrize("text", [
    "0 0 0 1\n0,5 0 0\n", "0 0 0 1\n0 0 0\n", "0 0 0 1\n0 0 0 x\n", "q1 q2 q3 q4 [m]\n0 0 0 1\n",
])  # fmt: skip
def test_rows_of_spaces_that_do_not_fit_are_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.txt").write_text(text)
    with pytest.raises(TrajectoryError, match=r"a\.txt, line [12]"):
        read_trajectory(tmp_path / "a.txt", ARM)
