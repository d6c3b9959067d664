"""Poses as makers of robots write them: read by their conventions, written again, or refused where in doubt."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rankdrop.kinematics import pose
from rankdrop.path.read.makers import shoulder_height
from rankdrop.path.read.poses import holds_poses, read_poses
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.path.read.written_poses import poses_bytes
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot

ARM = open_robot("ur5e")
Q = np.array([[0, -1.2, 1.4, -0.5, 0.8, 0.1], [0.1, -1.1, 1.3, -0.4, 0.8, 0.1], [0.2, -1.1, 1.3, -0.4, 0.7, 0.2]])
POSES = pose(ARM, Q)
P = POSES[:, :3, 3]


def about(axis: int, degrees: float) -> Array:
    """Turn about x, y or z, entry by entry."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    made = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    made[i, i], made[j, j], made[i, j], made[j, i] = c, c, -s, s
    return made


def z_y_x(turn: Array) -> list[float]:
    """Degrees about z, y, x of R = Rz Ry Rx."""
    y = -np.arcsin(turn[2, 0])
    found = [np.arctan2(turn[1, 0], turn[0, 0]), y, np.arctan2(turn[2, 1], turn[2, 2])]
    made = [float(np.degrees(x)) for x in found]
    np.testing.assert_allclose(about(2, made[0]) @ about(1, made[1]) @ about(0, made[2]), turn, atol=1e-12)
    return made


def vector(turn: Array) -> Array:
    """Rotation vector: the eigenvector of the eigenvalue 1, and the angle of the trace."""
    angle = np.arccos((np.trace(turn) - 1) / 2)
    return angle / (2 * np.sin(angle)) * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0],
                                                   turn[1, 0] - turn[0, 1]])  # fmt: skip


def real_first(turn: Array) -> Array:
    """Quaternion w, x, y, z."""
    r = vector(turn)
    angle = np.linalg.norm(r)
    return np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * r / angle])


TURNS = POSES[:, :3, :3]
ABC = np.array([z_y_x(turn) for turn in TURNS])
VECTORS, REAL_FIRST = np.array([*map(vector, TURNS)]), np.array([*map(real_first, TURNS)])
FORMS = {
    "ur": ("x,y,z,rx,ry,rz", np.c_[P, VECTORS], "Universal Robots writes them: x, y, z [m], rotation vector [rad]"),
    "rtde": (",".join(f"actual_TCP_pose_{k}" for k in range(6)), np.c_[P, VECTORS], "rotation vector [rad]"),
    "ur mm": ("X [mm],Y [mm],Z [mm],RX,RY,RZ", np.c_[1e3 * P, VECTORS], "x, y, z [mm], rotation vector [rad]"),
    "kuka": ("X,Y,Z,A,B,C", np.c_[1e3 * P, ABC], "KUKA writes them: x, y, z [mm], R = Rz(A)·Ry(B)·Rx(C) [deg]"),
    "kuka rad": ("X [m],Y [m],Z [m],A [rad],B [rad],C [rad]", np.c_[P, np.radians(ABC)], "Rx(C) [rad]"),
    "fanuc": ("X,Y,Z,W,P,R", np.c_[1e3 * P, ABC[:, ::-1]], "FANUC writes them: x, y, z [mm], R = Rz(R)·Ry(P)·Rx(W)"),
    "abb": ("x,y,z,q1,q2,q3,q4", np.c_[1e3 * P, REAL_FIRST], "ABB writes them: x, y, z [mm], quaternion with its real"),
}  # fmt: skip


def table(head: str, rows: Array) -> str:
    return "\n".join([head, *(",".join(map(repr, row)) for row in rows.tolist())]) + "\n"


@pytest.mark.parametrize("form", FORMS)
def test_makers_poses_are_read_and_written_again(form: str, tmp_path: Path) -> None:
    head, rows, said = FORMS[form]
    file = tmp_path / "a.csv"
    file.write_text(table(head, rows))
    assert holds_poses(file, ARM)
    read = read_poses(file)
    np.testing.assert_allclose(read.matrices, POSES, atol=1e-12)
    assert read.unused == ()
    assert read.turned
    assert said in read.notes[0]
    given = np.array([0, -1, 2])
    moved = POSES.copy()
    moved[1] = pose(ARM, np.array([Q[1] + 0.01]))[0]
    file.write_bytes(poses_bytes(file, moved, None, given))
    np.testing.assert_allclose(read_poses(file).matrices, moved, atol=1e-12)
    assert file.read_text().splitlines()[1] == table(head, rows).splitlines()[1]


def test_a_fanuc_z_counts_from_axis_2(tmp_path: Path) -> None:
    arm = open_robot("lrmate200id")
    height = shoulder_height(arm)
    assert height > 0.1
    file = tmp_path / "a.csv"
    head, rows, _ = FORMS["fanuc"]
    file.write_text(table(head, rows))
    read = read_poses(file, robot=arm)
    np.testing.assert_allclose(read.matrices[:, :3, 3], P + np.array([0, 0, height]), atol=1e-12)
    assert f"{1e3 * height:.6g} mm above the base" in read.notes[1]
    file.write_bytes(poses_bytes(file, read.matrices, None, np.array([0, -1, 2]), robot=arm))
    np.testing.assert_allclose(read_poses(file).matrices, POSES, atol=1e-12)


DOUBTFUL = {
    "kuka in m": ("X,Y,Z,A,B,C", [0.4, 0, 0.5, 0, 90, 0], r"m or mm is in doubt.*got 0\.5 in X, Y, Z; "
                  r"allowed: KUKA: mm and degrees; fix: name the columns x \[mm\]"),
    "kuka in rad": ("X,Y,Z,A,B,C", [400, 0, 500, 0, 1.57, 0], r"radians or degrees is in doubt.*got 1\.57 in "
                    r"A, B, C; .*fix: name the columns A \[deg\], B \[deg\], C \[deg\] or A \[rad\]"),
    "ur in mm": ("x,y,z,rx,ry,rz", [400, 0, 500, 0, 3.14, 0], r"m or mm is in doubt.*got 500 in x, y, z"),
    "angles": ("x,y,z,rx,ry,rz", [0.4, 0, 0.5, 180, 0, 0], r"radians or degrees is in doubt.*got 180 in "
               r"rx, ry, rz; .*\"roll \[deg\]\", \"pitch \[deg\]\""),
    "degrees": ("x,y,z,rx [deg],ry [deg],rz [deg]", [0.4, 0, 0.5, 180, 0, 0], r"rotation vector or angles about three"),
    "half": ("X [mm],Y,Z [mm],A,B,C", [400, 0, 500, 0, 90, 0], r"m or mm is in doubt"),
    "abb": ("x,y,z,q1,q2,q3,q4", [400, 0, 500, 0, 1, 1, 0], r"the quaternion is not of length one"),
}  # fmt: skip


@pytest.mark.parametrize("case", DOUBTFUL)
def test_poses_in_doubt_are_refused_with_how_to_write_them(case: str, tmp_path: Path) -> None:
    head, row, said = DOUBTFUL[case]
    file = tmp_path / "a.csv"
    file.write_text(table(head, np.array([row], dtype=np.float64)))
    with pytest.raises(TrajectoryError, match=said):
        read_poses(file)


def test_angles_of_nought_and_degrees_by_option_are_in_no_doubt(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_text("X,Y,Z,A,B,C\n400,0,500,0,0,0\n")
    np.testing.assert_array_equal(read_poses(file).matrices[0, :3, :3], np.eye(3))
    file.write_text("X,Y,Z,A,B,C\n400,0,500,2,0,0\n")
    np.testing.assert_allclose(read_poses(file, deg=True).matrices[0, :3, :3], about(2, 2.0), atol=1e-15)


def test_joint_values_beside_positions_are_no_quaternions(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_text("x,y,z,q1,q2,q3,q4\n0.3,0,0.1,0.1,0.2,0.05,0\n")
    assert not holds_poses(file, open_robot("scara"))
    file.write_text("x,y,z,q1,q2,q3,q4,q5,q6\n0.3,0,0.1,1,0,0,0,0,0\n")
    assert not read_poses(file).turned
