"""Joints under other names: a prefix in the file or in the arm, logs of a controller; what fits twice is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rankdrop.path.read.files import read_trajectory
from rankdrop.path.read.joint_columns import other_names
from rankdrop.path.read.poses import holds_poses
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot

UR = open_robot("ur5e")
NAMES = [joint.name for joint in UR.joints]
Q = np.array([[0.0, -1.57, 1.57, 0.25, 1.5, -0.5], [0.125, -1.4, 1.57, 0.0, -0.3, 0.0]])


def prefixed(prefix: str) -> Robot:
    return replace(UR, joints=tuple(replace(joint, name=prefix + joint.name) for joint in UR.joints))


def table(folder: Path, heads: list[str], rows: Array, separator: str = ",") -> Path:
    path = folder / "log.csv"
    lines = [heads, *(list(map(repr, row)) for row in rows.tolist())]
    path.write_text("\n".join(map(separator.join, lines)), encoding="utf-8")
    return path


@pytest.mark.parametrize("prefix", ["left_", "robot1_", "/ur5/", "arm.", "cell2:"])
def test_a_prefix_of_all_names_changes_no_value(prefix: str, tmp_path: Path) -> None:
    """In the file: as a driver of a cell with two robots logs them; in the arm: its URDF has the prefix."""
    order = [5, 2, 0, 1, 3, 4]
    heads = [prefix + NAMES[i] for i in order]
    found = read_trajectory(table(tmp_path, [*heads, "finger_joint"], np.c_[Q[:, order], Q[:, 0]]), UR)
    assert np.array_equal(found.q, Q)
    assert found.unused == ("finger_joint",)
    assert any(repr(prefix) in note for note in found.notes)
    other = read_trajectory(table(tmp_path, [NAMES[i] for i in order], Q[:, order]), prefixed(prefix))
    assert np.array_equal(other.q, Q)
    assert any(repr(prefix) in note for note in other.notes)


def test_messages_and_archives_are_read_with_a_prefix_too(tmp_path: Path) -> None:
    heads = [f"robot1_{name}" for name in NAMES]
    message = {"joint_names": heads, "points": [{"positions": row} for row in Q.tolist()]}
    (tmp_path / "a.json").write_text(json.dumps(message), encoding="utf-8")
    np.savez(tmp_path / "a.npz", q=Q, joint_names=np.array(heads))
    for name in ("a.json", "a.npz"):
        found = read_trajectory(tmp_path / name, UR)
        assert np.array_equal(found.q, Q)
        assert any("'robot1_'" in note for note in found.notes)


@pytest.mark.parametrize("separator", [",", " ", ";"])
@pytest.mark.parametrize("word", ["actual_q", "target_q"])
def test_logs_of_rtde_are_joints_in_their_order(word: str, separator: str, tmp_path: Path) -> None:
    heads = ["timestamp", *(f"{word}_{i}" for i in range(6))]
    found = read_trajectory(table(tmp_path, heads, np.c_[[0.0, 0.5], Q], separator), UR)
    assert np.array_equal(found.q, Q)
    assert np.array_equal(found.times, [0.0, 0.5])
    assert any(f"{word}_0 … {word}_5" in note for note in found.notes)


def test_of_actual_and_target_values_the_actual_ones_are_read(tmp_path: Path) -> None:
    heads = [f"{word}_{i}" for word in ("target_q", "actual_q", "actual_TCP_pose") for i in range(6)]
    path = table(tmp_path, heads, np.c_[Q + 0.5, Q, Q])
    assert not holds_poses(path, UR)  # joint values say the posture as well
    found = read_trajectory(path, UR)
    assert np.array_equal(found.q, Q)
    assert "target_q_0" in found.unused


def test_columns_of_two_arms_are_refused(tmp_path: Path) -> None:
    heads = [side + name for side in ("left_", "right_") for name in NAMES]
    with pytest.raises(TrajectoryError, match=r"several arms fit; got left_…, right_…; .*fix: keep the columns of one"):
        read_trajectory(table(tmp_path, heads, np.c_[Q, Q]), UR)
    assert np.array_equal(read_trajectory(table(tmp_path, heads[:6], Q), UR).q, Q)


@pytest.mark.parametrize(
    "heads",
    [["vel_" + name for name in NAMES], ["effort." + name for name in NAMES], ["right_" + name for name in NAMES[:5]],
     ["left_" + NAMES[0], *("right_" + name for name in NAMES[1:])], [f"actual_qd_{i}" for i in range(6)],
     [f"actual_q_{i}" for i in range(7)], [f"actual_q_{i}" for i in range(1, 7)]],
)  # fmt: skip
def test_columns_that_are_not_all_joints_are_not_taken_for_them(heads: list[str], tmp_path: Path) -> None:
    with pytest.raises(TrajectoryError, match="joints have no column"):
        read_trajectory(table(tmp_path, heads, np.zeros((2, len(heads)))), UR)


def test_the_other_arm_of_two_is_not_this_one(tmp_path: Path) -> None:
    with pytest.raises(TrajectoryError, match="joints have no column"):
        read_trajectory(table(tmp_path, ["right_" + name for name in NAMES], Q), prefixed("left_"))


def test_velocities_next_to_positions_do_not_make_them_ambiguous() -> None:
    given = [f"{what}/{name}" for what in ("position", "velocity", "effort") for name in NAMES]
    found = other_names(given, NAMES, "a.csv")
    assert found is not None
    assert set(found.joints) == {f"position/{name}" for name in NAMES}


def test_names_that_are_the_arms_own_stay() -> None:
    assert other_names([*NAMES, *("left_" + name for name in NAMES)], NAMES, "a.csv") is None


def test_numbers_alone_are_no_names_of_joints() -> None:
    assert other_names(["1", "2"], ["joint_1", "joint_2"], "a.json") is None
