"""Files of poses written again: rows that stay are byte for byte as they were, new ones have the form of the file."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from path.written_text import text_of_poses
from rankdrop.kinematics import pose
from rankdrop.path.read.poses import read_poses
from rankdrop.path.read.written_poses import poses_bytes
from rankdrop.robot.open import open_robot


@pytest.mark.parametrize("turn", ["quaternion", "rpy", "commas", "json"])
def test_a_new_row_has_the_form_of_the_file(turn: str, tmp_path: Path) -> None:
    """Written and read back: the poses to rounding, the rows of the file as they were."""
    arm = open_robot("ur5e")
    poses = pose(arm, np.array([[0.1, -1.0, 1.2, 0.3, 0.8, 0.2], [0.2, -1.1, 1.2, 0.3, 0.9, 0.2]]))
    middle = pose(arm, np.array([[0.15, -1.05, 1.2, 0.3, 0.85, 0.2]]))
    file = tmp_path / ("poses.json" if turn == "json" else "poses.csv")
    file.write_text(text_of_poses(poses, turn), encoding="utf-8")
    read = read_poses(file)
    every = np.stack([read.matrices[0], middle[0], read.matrices[1]])
    given = np.array([0, -1, 1])
    made = poses_bytes(file, every, np.array([0.0, 0.5, 1.0]), given)
    out = tmp_path / f"out{file.suffix}"
    out.write_bytes(made)
    again = read_poses(out)
    assert np.abs(again.matrices - every).max() < 1e-12
    assert again.times is not None
    assert again.times.tolist() == [0.0, 0.5, 1.0]
    if turn == "json":
        was, now = (json.loads(one.read_text(encoding="utf-8")) for one in (file, out))
        assert now["poses"][::2] == was["poses"]
        assert (now["length"], now["frame"]) == ("mm", "table")
    else:
        lines = out.read_text(encoding="utf-8").splitlines()
        assert [*lines[:2], lines[3]] == file.read_text(encoding="utf-8").splitlines()
    later = poses_bytes(file, every, np.array([0.0, 0.5, 1.25]), given)
    (tmp_path / f"later{file.suffix}").write_bytes(later)
    last = read_poses(tmp_path / f"later{file.suffix}")
    assert last.times is not None
    assert last.times.tolist() == [0.0, 0.5, 1.25]
    assert np.array_equal(last.matrices[2], read.matrices[1])
