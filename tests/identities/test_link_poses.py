"""Poses of the links: the pose of the arm cut off after each joint, mimic joints included."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference import arms

from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import link_poses, pose
from rankdrop.robot.model import Array, Robot


def cut_off(robot: Robot, q: Array) -> Array:
    """The same from `pose` alone, one configuration."""
    values = dict(zip((joint.name for joint in robot.variables), q, strict=True))
    for joint in robot.joints:
        if joint.mimic is not None:
            values[joint.name] = joint.mimic.multiplier * values[joint.mimic.leader] + joint.mimic.offset
    free = [replace(joint, mimic=None) for joint in robot.joints]
    every = np.array([values[joint.name] for joint in free])
    poses = [np.eye(4)]
    for i, joint in enumerate(free, start=1):
        poses.append(pose(replace(robot, joints=tuple(free[:i]), home=joint.frame), every[:i]))
    return np.stack([*poses, pose(robot, q)])


@pytest.mark.parametrize("kinds", ["rrrrrrr", "mrrhpmr", "p", "rpr"])
def test_a_link_stands_where_the_arm_cut_off_there_ends(kinds: str, rng: np.random.Generator) -> None:
    robot = arms.random_chain(rng, kinds)
    q = rng.uniform(-4.0, 4.0, (11, robot.n))
    q[0] = 0.0
    want = np.stack([cut_off(robot, row) for row in q])
    assert np.abs(link_poses(robot, q) - want).max() < 1e-13
    np.testing.assert_array_equal(link_poses(robot, q)[:, -1], pose(robot, q))


def test_batch_axes_are_kept_and_broken_input_is_refused(rng: np.random.Generator) -> None:
    robot = arms.pa10()
    assert link_poses(robot, np.zeros((2, 0, 7))).shape == (2, 0, 9, 4, 4)
    assert link_poses(robot, np.zeros(7)).shape == (9, 4, 4)
    with pytest.raises(ConfigurationError):
        link_poses(robot, np.full(7, np.nan))
