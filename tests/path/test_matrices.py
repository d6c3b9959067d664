"""Poses as matrices, from NumPy's files and from columns m00 … m33: read as written, or refused with the mistake."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from rankdrop.cli import main
from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.kinematics import pose
from rankdrop.path.check.tool_path import check_poses
from rankdrop.path.read.arrays import read_pose_array
from rankdrop.path.read.files import read_trajectory
from rankdrop.path.read.matrices import ORTHONORMAL, REPORTED, deviation, nearest_rotations
from rankdrop.path.read.poses import holds_poses, length_hint, read_poses
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.path.read.written_poses import check_pose_target, poses_bytes
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot

ARM = open_robot("ur5e")
Q = np.array([[0, -1.2, 1.4, -0.5, 0.8, 0.1], [0.1, -1.1, 1.3, -0.4, 0.8, 0.1], [0.2, -1.1, 1.3, -0.4, 0.7, 0.2]])
POSES = pose(ARM, Q)
T = np.array([0.0, 1.0, 2.5])


def table(head: str, rows: Array) -> str:
    return "\n".join([head, *(",".join(map(repr, row)) for row in rows.tolist())])


def names(rows: int, first: int = 0) -> str:
    return ",".join(f"m{i + first}{j + first}" for i in range(rows) for j in range(4))


def test_every_way_of_writing_matrices_gives_the_same(tmp_path: Path) -> None:
    flat, upper = POSES.reshape(3, 16), POSES[:, :3].reshape(3, 12)
    millimetres = upper.copy()
    millimetres[:, 3::4] *= 1e3
    np.save(tmp_path / "whole.npy", POSES)
    np.save(tmp_path / "upper.npy", POSES[:, :3])
    np.savez(tmp_path / "times.npz", poses=POSES, t=T)
    np.savez_compressed(tmp_path / "plain.npz", POSES)
    texts = {
        "whole.csv": table(names(4), flat),
        "upper.csv": table(names(3), upper),
        "from_one.csv": table(names(4, 1), flat),
        "upper_from_one.csv": table(names(3, 1).upper(), upper),
        "times.csv": table("time," + names(3), np.c_[T, upper]),
        "mm.csv": table(names(3).replace("m03", "m03 [mm]").replace("m13", "m13_mm").replace("m23", "m23 [mm]"),
                        millimetres),
    }  # fmt: skip
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    for file in sorted(tmp_path.iterdir()):
        assert holds_poses(file, ARM), file.name
        read = read_poses(file)
        np.testing.assert_allclose(read.matrices, POSES, atol=1e-12, err_msg=file.name)
        assert (read.turned, read.unused, read.notes) == (True, (), ()), file.name
        assert (read.times is not None) == file.name.startswith("times"), file.name
    np.save(tmp_path / "one.npy", POSES[0])
    np.testing.assert_array_equal(read_poses(tmp_path / "one.npy").matrices, POSES[:1])


def test_joint_values_stay_joint_values(tmp_path: Path) -> None:
    np.save(tmp_path / "q.npy", Q)
    np.savez(tmp_path / "q.npz", q=Q, poses=POSES)
    (tmp_path / "q.csv").write_text(table("q1,q2,q3,q4,q5,q6," + names(3), np.c_[Q, POSES[:, :3].reshape(3, 12)]))
    for name in ("q.npy", "q.npz", "q.csv"):
        assert not holds_poses(tmp_path / name, ARM), name
        np.testing.assert_array_equal(read_trajectory(tmp_path / name, ARM).q, Q)
    scara = open_robot("scara")
    np.save(tmp_path / "four.npy", np.eye(4))
    assert not holds_poses(tmp_path / "four.npy", scara)
    assert read_trajectory(tmp_path / "four.npy", scara).q.shape == (4, 4)


def changed(change: Callable[[Array], object]) -> Array:
    made = POSES.copy()
    change(made)
    return made


def put(index: tuple[int, ...], value: float) -> Array:
    made = POSES.copy()
    made[index] = value
    return made


REFUSED: dict[str, tuple[Array, str]] = {
    "nan": (put((2, 1, 1), np.nan), r"pose 3: the matrix has a value that is not finite; got nan in row 2, column 2"),
    "last row": (put((1, 3, 3), 0.0), r"pose 2: the last row of the matrix is not 0 0 0 1; got 0 0 0 0"),
    "transposed": (POSES.transpose(0, 2, 1), r"pose 1: the matrix is transposed: its translation is in the last row"),
    "mirrored": (changed(lambda made: np.negative(made[1, :, 0], out=made[1, :, 0])),
                 r"pose 2: the matrix is mirrored: its axes are left-handed; got determinant −1"),
    "scaled": (changed(lambda made: np.multiply(made[1, :3, :3], 2, out=made[1, :3, :3])),
               r"pose 2: the first three rows and columns of the matrix are no rotation; got RᵀR differs from 1 by 3, "
               r"columns of length 2, 2, 2; allowed: columns of length 1 at right angles, to 0\.001; fix: write R"),
    "huge": (put((0, 0, 0), 1e200), r"pose 1: the first three rows and columns of the matrix are no rotation"),
    "far": (put((0, 1, 3), 1e13), r"pose 1: the value is too large; got 1e\+13; allowed: -1e\+12 … 1e\+12 m"),
    "last axis": (np.moveaxis(POSES, 0, -1), r"got shape \(4, 4, 3\); .*fix: the poses are along the last axis: write"),
    "transposed upper part": (np.tile(POSES[:, :3], (2, 1, 1)).transpose(0, 2, 1),
                              r"got shape \(6, 4, 3\); .*the matrices are transposed"),
    "rotations": (POSES[:, :3, :3], r"got shape \(3, 3, 3\); .*these are rotations alone: add the translation"),
    "none": (POSES[:0], r"got shape \(0, 4, 4\); allowed: shape \(N, 4, 4\) or \(N, 3, 4\)"),
}  # fmt: skip


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("case", REFUSED)
def test_a_wrong_matrix_is_refused_with_its_number_and_the_mistake(case: str, tmp_path: Path) -> None:
    values, said = REFUSED[case]
    np.save(tmp_path / "a.npy", values)
    np.savez(tmp_path / "a.npz", poses=values)
    for name in ("a.npy", "a.npz"):
        assert holds_poses(tmp_path / name, ARM)
        with np.errstate(over="ignore", invalid="ignore"), pytest.raises(TrajectoryError, match=said) as caught:
            read_poses(tmp_path / name)
        assert name in str(caught.value)


@pytest.mark.parametrize(("head", "said"), [
    (names(3).replace("m23", "n23"), r"line 1: entries of the matrices have no column; .*fix: add m23"),
    (names(3).replace("m02", "m02 [mm]"), r"line 1, column 3: the unit does not fit the column; got m02 \[mm\]"),
    (names(3).replace("m23", "m22"), r"line 1, column 12: the column is given twice"),
])  # fmt: skip
def test_wrong_columns_are_named(head: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(table(head, POSES[:, :3].reshape(3, 12)))
    assert holds_poses(tmp_path / "a.csv", ARM)
    with pytest.raises(TrajectoryError, match=said):
        read_poses(tmp_path / "a.csv")


def test_a_wrong_row_of_a_table_is_named_by_its_line(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(table(names(4), put((1, 3, 0), 0.5).reshape(3, 16)))
    with pytest.raises(TrajectoryError, match=r"a\.csv, line 3: the last row of the matrix is not 0 0 0 1; got 0\.5 0"):
        read_poses(tmp_path / "a.csv")


def test_flat_matrices_are_told_their_shape(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", POSES.reshape(3, 16))
    with pytest.raises(TrajectoryError, match=r"fix: matrices of the tip have the shape \(N, 4, 4\)"):
        read_trajectory(tmp_path / "a.npy", ARM)
    (tmp_path / "a.csv").write_text(table("", POSES.reshape(3, 16))[1:])
    with pytest.raises(TrajectoryError, match="fix: a first line m00,m01, … m33 makes them matrices of the tip"):
        read_trajectory(tmp_path / "a.csv", ARM)


def test_rows_of_a_position_and_a_quaternion_are_told_their_names(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.ones((3, 7)))
    with pytest.raises(TrajectoryError, match="fix: poses with quaternions are read from CSV: a first line x,y,z,q"):
        read_trajectory(tmp_path / "a.npy", ARM)
    (tmp_path / "a.csv").write_text("0,0,1,0,0,0,1\n")
    with pytest.raises(TrajectoryError, match="fix: a first line x,y,z,qx,qy,qz,qw makes them poses of the tip"):
        read_trajectory(tmp_path / "a.csv", ARM)


@pytest.mark.parametrize(("digits", "noted"), [(9, False), (6, False), (4, True), (3, True)])
def test_rounded_rotations_become_the_nearest_ones(digits: int, noted: bool, tmp_path: Path) -> None:
    rounded = np.round(POSES, digits)
    off = deviation(rounded[:, :3, :3])
    assert (off.max() > REPORTED) == noted
    assert off.max() <= ORTHONORMAL
    np.save(tmp_path / "a.npy", rounded)
    read = read_poses(tmp_path / "a.npy")
    assert deviation(read.matrices[:, :3, :3]).max() < 1e-14
    np.testing.assert_allclose(read.matrices, POSES, atol=10.0**-digits)
    assert len(read.notes) == noted
    if noted:
        assert read.notes[0].startswith("rotations of 3 poses are replaced by the nearest ones: RᵀR differs from 1 by")
    turns = nearest_rotations(rounded[:, :3, :3])
    np.testing.assert_allclose(np.linalg.det(turns), 1.0)


def test_poses_of_six_digits_are_taken_from_an_array_too() -> None:
    assert check_poses(ARM, np.round(POSES, 6), start=Q[0], branches=False).verdict == "free"
    with pytest.raises(ConfigurationError, match=r"poses, pose 1: .* are no rotation; .*at right angles, to 1e-05"):
        check_poses(ARM, np.round(POSES, 3), start=Q[0])


def test_millimetres_are_warned_of_with_what_to_do(tmp_path: Path) -> None:
    far = POSES.copy()
    far[:, :3, 3] *= 1e3
    np.save(tmp_path / "a.npy", far)
    (tmp_path / "a.csv").write_text(table(names(4), far.reshape(3, 16)))
    hints = [length_hint(read_poses(tmp_path / name), 0.95) or "" for name in ("a.npy", "a.csv")]
    assert hints[0].endswith("look like millimetres and are read as metres; divide poses[:, :3, 3] by 1000")
    assert hints[1].endswith("look like millimetres and are read as metres; write m03 [mm], m13 [mm], m23 [mm]")


def test_a_file_of_matrices_is_written_as_one_again(tmp_path: Path) -> None:
    given, times = np.array([0, -1, 2]), np.array([0.0, 0.5, 1.0])
    np.savez(tmp_path / "a.npz", poses=POSES[:, :3], t=T)
    (tmp_path / "out.npz").write_bytes(poses_bytes(tmp_path / "a.npz", POSES, times, given))
    values, when, _ = read_pose_array(tmp_path / "out.npz")
    np.testing.assert_array_equal(values, POSES[:, :3])
    np.testing.assert_array_equal(when, times)
    check_pose_target(tmp_path / "a.npy", "out.npz")
    with pytest.raises(OptionError, match=r"allowed: \.npz"):
        check_pose_target(tmp_path / "a.npz", "out.csv")
    (tmp_path / "a.csv").write_text(table(names(3), POSES[:, :3].reshape(3, 12)) + "\n")
    (tmp_path / "out.csv").write_bytes(poses_bytes(tmp_path / "a.csv", POSES, None, given))
    assert (tmp_path / "out.csv").read_bytes() == (tmp_path / "a.csv").read_bytes()


def test_times_of_an_archive_are_one_for_each_pose(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", poses=POSES, t=T[:2])
    with pytest.raises(TrajectoryError, match=r"there is one time for each pose; got shape \(2,\); allowed: shape"):
        read_poses(tmp_path / "a.npz")
    np.savez(tmp_path / "a.npz", poses=POSES, t=T[::-1])
    with pytest.raises(TrajectoryError, match=r"a\.npz, poses, pose 2: time does not go on"):
        read_poses(tmp_path / "a.npz")
    np.savez(tmp_path / "b.npz", first=POSES, second=POSES)
    assert not holds_poses(tmp_path / "b.npz", ARM)
    with pytest.raises(TrajectoryError, match="the archive has no poses; got first, second; allowed: poses or"):
        read_poses(tmp_path / "b.npz")
    with pytest.raises(TrajectoryError, match=r"the archive has no positions; .* or poses for matrices of the tip"):
        read_trajectory(tmp_path / "b.npz", ARM)


@pytest.mark.slow
def test_the_command_checks_an_array_of_poses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.save(tmp_path / "a.npy", np.round(POSES, 6))
    assert main.run(["path", "ur5e", str(tmp_path / "a.npy"), "--quiet"]) == 0
    assert capsys.readouterr().out.startswith("Free: proven for every point of the path.")
