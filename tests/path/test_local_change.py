"""Changes of a few rows of a path."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from path.dipping import mended
from rankdrop.path.mend.local_change import largest_off, poses_off, size_of_off, step
from rankdrop.poses.inverse import Aim
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.text.remedies import tool_off_words


@pytest.mark.slow
def test_a_bump_has_two_continuous_derivatives() -> None:
    share = np.linspace(-0.2, 1.2, 1401)
    value, slope, bend = step(share)
    np.testing.assert_allclose(np.gradient(value, share), slope, atol=1e-4)
    np.testing.assert_allclose(np.gradient(slope, share)[5:-5], bend[5:-5], atol=0.1)
    assert np.abs(np.diff(bend)).max() < 0.02 * np.abs(bend).max()
    q, found = mended("irb120")
    assert found.best is not None
    moved = (found.best.trajectory.q - q)[:, 4]
    second = np.gradient(np.gradient(moved, 0.01), 0.01)
    assert np.abs(np.diff(second)).max() < 0.4 * np.abs(second).max()  # at a jump: as large as the values themselves


def poses_about(axis: Array, angles: Array, places: Array) -> Array:
    """(N, 4, 4) poses turned about an axis, by SciPy."""
    poses = np.tile(np.eye(4), (len(angles), 1, 1))
    poses[:, :3, :3] = Rotation.from_rotvec(angles[:, None] * axis).as_matrix()
    poses[:, :3, 3] = places
    return poses


def test_a_deviation_counts_what_the_task_holds() -> None:
    robot = open_robot("irb120")
    old = poses_about(np.array([0.6, 0.0, 0.8]), np.array([0.3, 1.0]), np.zeros((2, 3)))
    spun = old @ poses_about(np.array([0.0, 0.0, 1.0]), np.array([3.0, 1.0]), np.zeros((2, 3)))
    tilted = spun @ poses_about(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.02]), np.zeros((2, 3)))
    tilted[:, :3, 3] = [0.003, 0.0, 0.004], [0.0, 0.0, 0.0]
    assert poses_off(old, spun) == pytest.approx((0.0, 3.0))
    expected = {"pose": (0.005, 3.0), "tool-axis-free": (0.005, 0.02), "position": (0.005, np.nan),
                "orientation": (np.nan, 3.0)}  # fmt: skip
    for name, off in expected.items():
        found = poses_off(old, tilted, Aim(robot, resolve_task(name, robot)))
        assert found == pytest.approx(off, nan_ok=True), name


def test_the_size_of_a_deviation_is_a_number() -> None:
    offs = [(0.01, np.nan), (0.03, np.nan)]
    assert largest_off(offs) == pytest.approx((0.03, np.nan), nan_ok=True)
    assert size_of_off(largest_off(offs), 0.5) == pytest.approx(0.06)
    assert size_of_off((np.nan, 0.2), 0.5) == pytest.approx(0.2)


def test_what_the_task_leaves_free_is_not_printed() -> None:
    robot = open_robot("irb120")
    assert tool_off_words((0.0061, np.radians(0.2)), robot) == "6.1 mm and 0.2°"
    assert tool_off_words((0.0061, np.nan), robot) == "6.1 mm"
    assert tool_off_words((np.nan, np.radians(0.2)), robot) == "0.2°"
