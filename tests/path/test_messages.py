"""Trajectory messages as JSON: points without names of joints."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rankdrop.path.read.files import read_trajectory
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.robot.open import open_robot

ARM = open_robot("scara")


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
