"""A mended file of poses is a file of poses: other rows stay byte for byte, and it is proven free when read back."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from path.written_text import text_of_poses
from rankdrop.cli import main
from rankdrop.kinematics import pose
from rankdrop.path.check.tool_path import check_poses
from rankdrop.path.mend.as_poses import NoPoses, mended_poses
from rankdrop.path.mend.mend import mend_path
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot

HEAD = "time,x [mm],y [mm],z [mm],roll [deg],pitch [deg],yaw [deg],process"
ARM = "planar3r"


def led_beyond() -> tuple[Array, Array, Array]:
    """Poses 0.3 mm beyond the reach of the first two of three links in the middle, times, and the first configuration.
    """
    arm, t = open_robot(ARM), np.linspace(0.0, 2.4, 60)
    q = np.stack([0.2 + 0.1 * t, 0.5 * np.cos(np.pi * t / 2.4), 0.4 + 0.1 * t], axis=1)
    poses = pose(arm, q)
    out = poses[30, :3, 3] / np.linalg.norm(poses[30, :3, 3])
    poses[:, :3, 3] += 3e-4 * np.exp(-(((t - 1.2) / 0.1) ** 2))[:, None] * out
    return poses, t, q[0]


def csv_of(poses: Array, t: Array) -> str:
    """As text with Windows line ends, a comment, and a column of the process."""
    yaw = np.degrees(np.arctan2(poses[:, 1, 0], poses[:, 0, 0]))
    rows = [f"{when:.3f},{1e3 * p[0, 3]:.9f},{1e3 * p[1, 3]:.9f},0,0,0,{turn:.9f},weld"
            for when, p, turn in zip(t, poses, yaw, strict=True)]  # fmt: skip
    return "\r\n".join([HEAD, rows[0], "# the first pose is above", *rows[1:], ""])


def start_of(q: Array) -> str:
    return "--start=" + ",".join(f"{x:.9g}" for x in q)


def read_text(file: Path) -> list[str]:
    return file.read_bytes().decode().split("\r\n")


@pytest.mark.slow
def test_poses_led_around_are_written_as_poses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    poses, t, q = led_beyond()
    file, out = tmp_path / "poses.csv", tmp_path / "fixed.csv"
    file.write_bytes(csv_of(poses, t).encode())
    command = ["path", ARM, str(file), start_of(q), "--quiet", "--remedy", "detour", "--fixed", str(out)]
    assert main.run(command) == 3
    said = capsys.readouterr().err
    assert "mended by detour, " in said
    assert f"rankdrop path {ARM} {out} --start " in said.replace("\n", " ")
    before, after = read_text(file), read_text(out)
    assert after[:3] == before[:3]
    new = [line for line in after if line not in before]
    assert 10 < len(new) < 400
    assert all(line.endswith(",weld") for line in new)
    gone = [line for line in before if line not in after]
    assert 0 < len(gone) < 40
    assert main.run(["path", ARM, str(out), start_of(q), "--quiet"]) == 0
    rows = [[float(cell) for cell in row[:-1]] for row in csv.reader(new)]
    off = [min(np.hypot(row[1] - 1e3 * p[0, 3], row[2] - 1e3 * p[1, 3]) for p in poses) for row in rows]
    assert max(off) < 30.0  # millimetres, as in the file
    assert main.run([*command, "--fixed-as", "joints"]) == 3
    assert "[rad]" in out.read_text(encoding="utf-8").splitlines()[0]


@pytest.mark.slow
def test_poses_that_are_too_fast_get_more_time() -> None:
    """Near the wrist of a UR5e, where joints 4 and 6 are too fast: the poses stay, their times are later."""
    arm, t = open_robot("ur5e"), np.linspace(0.0, 2.0, 100)
    q = np.radians(np.array([0.0, -80.0, 80.0, -60.0, 0.0, 0.0]) + np.outer(t, [2.0, 3.0, 4.0, 5.0, 0.0, 6.0]))
    q[:, 4] = np.radians(20.0) * np.cos(np.pi * t / 2.0)
    poses = pose(arm, q)
    side = np.exp(-(((t - 1.0) / 0.2) ** 2))
    poses[:, :3, :3] = _turned(0.004 * side) @ poses[:, :3, :3]
    check = check_poses(arm, poses, t, start=q[0], branches=False)
    assert check.verdict == "too fast"
    (remedy,) = mend_path(check, kinds=("slow-down",)).remedies
    made = mended_poses(check, remedy)
    assert not isinstance(made, NoPoses)
    assert made.times is not None
    kept = made.given >= 0
    assert np.array_equal(made.given[kept], np.arange(100))
    assert np.array_equal(made.matrices[kept], poses)
    early = made.times[kept] == t
    assert 10 < early.sum() < 90
    again = check_poses(arm, made.matrices, made.times, start=q[0], branches=False)
    assert again.verdict == "free"
    assert made.times[-1] > 2.0


def test_a_redundant_arm_keeps_its_limits_from_a_start_of_nine_digits() -> None:
    """Near the wrist of an iiwa 14: its joints go a little elsewhere from there, and the times leave room for that."""
    arm, t = open_robot("iiwa14"), np.linspace(0.0, 2.0, 60)
    first, rates = np.array([0.0, 40.0, 10.0, -80.0, 10.0, 0.0, 0.0]), np.array([2.0, 3.0, 2.0, 5.0, 3.0, 0.0, 6.0])
    q = np.radians(first + np.outer(t, rates))
    q[:, 5] = np.radians(20.0) * np.cos(np.pi * t / 2.0)
    poses = pose(arm, q)
    side = np.exp(-(((t - 1.0) / 0.2) ** 2))
    poses[:, :3, :3] = _turned(0.004 * side) @ poses[:, :3, :3]
    check = check_poses(arm, poses, t / 10.0, start=q[0], branches=False)
    assert check.verdict == "too fast"
    remedy = mend_path(check, kinds=("slow-down",)).best
    assert remedy is not None
    made = mended_poses(check, remedy)
    assert not isinstance(made, NoPoses)
    assert made.times is not None
    faster = check_poses(arm, made.matrices, made.times * (1.0 - 5e-5), start=q[0], branches=False)
    assert faster.verdict == "free"


def _turned(angle: Array) -> Array:
    """(N, 3, 3) turns about X."""
    out = np.tile(np.eye(3), (len(angle), 1, 1))
    out[:, 1, 1] = out[:, 2, 2] = np.cos(angle)
    out[:, 2, 1] = np.sin(angle)
    out[:, 1, 2] = -np.sin(angle)
    return out


def test_a_target_of_another_form_is_refused_before_the_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "poses.csv"
    poses = pose(open_robot("ur5e"), np.array([[0.1, -1.0, 1.2, 0.3, 0.8, 0.2]] * 2))
    file.write_text(text_of_poses(poses, "quaternion"), encoding="utf-8")
    assert main.run(["path", "ur5e", str(file), "--fixed", str(tmp_path / "out.npz")]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "poses are written in the form in which they were read" in said
    assert "--fixed-as joints writes joint values" in said


@pytest.mark.slow
def test_poses_that_break_a_limit_are_not_given() -> None:
    poses, t, q = led_beyond()
    check = check_poses(open_robot(ARM), poses, t, start=q, branches=False)
    remedy = mend_path(check, kinds=("detour",)).best
    assert remedy is not None
    assert not isinstance(mended_poses(check, remedy), NoPoses)
    assert mended_poses(check, remedy, acceleration=1e-3) is NoPoses.UNPROVEN
