"""Curves of a path as the checker makes them of its file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rankdrop.kinematics import pose
from rankdrop.path import check_path, path_certificate
from rankdrop.path.check.tool_line import poses_at
from rankdrop.path.curve import curve
from rankdrop.proof.curves import AskedPath, ToolPath, control_points
from rankdrop.proof.record import Unproven, claim_of
from rankdrop.robot.model import Joint, JointKind, Robot


@pytest.mark.parametrize("degree", [1, 3, 5])
def test_the_curve_of_rows_is_the_one_that_is_checked(degree):
    """The checker's own formula against that of `rankdrop path`."""
    rng = np.random.default_rng(degree)
    rows, rates, bends = rng.uniform(-2, 2, (3, 5, 4))
    times = np.cumsum(rng.uniform(0.1, 2.0, 5))
    control = curve(rows, times, rates, bends, {1: "linear", 3: "cubic", 5: "quintic"}[degree]).control
    made = control_points(AskedPath("", "", rows, times, rates, bends), degree)
    assert made is not None
    np.testing.assert_allclose(made[:-1].reshape(control[:, :-1].shape), control[:, :-1], rtol=0, atol=1e-14)
    np.testing.assert_array_equal(made[-1], rows[-1])


def mixed() -> Robot:
    """A turn, a slide, a screw with a pitch and a turn, axes askew."""
    joints = (
        Joint("a", JointKind.REVOLUTE, np.array([0, 0, 0, 0, 0, 1.0])),
        Joint("b", JointKind.PRISMATIC, np.array([0.6, 0, 0.8, 0, 0, 0])),
        Joint("c", JointKind.HELICAL, np.array([0.0, 0.1, 0.3, 1.0, 0, 0])),
        Joint("d", JointKind.REVOLUTE, np.array([0, -0.2, 0.7, 0, 0.8, 0.6]) * [1, 1, 1, 1, 1, 1]
              - np.array([0, *(np.array([0.8, 0.6]) * (-0.2 * 0.8 + 0.7 * 0.6)), 0, 0, 0])),
    )  # fmt: skip
    home = np.eye(4)
    home[:3, 3] = (0.4, 0.2, 0.9)
    return Robot("mixed", joints, home, task="position")


@pytest.mark.parametrize("seed", range(3))
def test_the_distance_of_the_tip_bounds_that_of_many_samples(seed):
    """Slides and screws: the distance that is proven is never below one that is evaluated, and not far above it."""
    robot, rng = mixed(), np.random.default_rng(seed)
    q = rng.uniform(-1.0, 1.0, (2, 4))
    q[1] = q[0] + rng.uniform(-0.2, 0.2, 4)
    matrices = pose(robot, q)
    share = np.linspace(0.0, 1.0, 401)
    way = pose(robot, q[0] + share[:, None] * (q[1] - q[0]))
    lines = poses_at(matrices, share)
    true = float(np.linalg.norm(way[:, :3, 3] - lines[:, :3, 3], axis=1).max())
    record = path_certificate(check_path(robot, q))
    claim = claim_of(record, Path())

    def proven(near: float) -> bool:
        try:
            ToolPath(claim, AskedPath("", "", poses=matrices, turned=False, tip=near)).compare()
        except Unproven:
            return False
        return True

    assert not proven(0.999 * true)
    assert proven(1.02 * true)
