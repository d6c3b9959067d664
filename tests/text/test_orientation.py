"""How singularities of orientation coordinates are worded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import pose
from rankdrop.local.orientation import (
    analytical_jacobian,
    representation_at,
)
from rankdrop.robot.open import open_robot


def test_only_the_coordinates_only_the_arm_both_and_neither() -> None:
    robot = open_robot("pa10")
    regular = [0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]
    neither = representation_at(robot, regular)
    assert (neither.arm.corank, neither.zyz.singular, neither.rpy.singular) == (0, False, False)
    only_arm = representation_at(robot, [0.3, 0.4, 0.5, 0.0, 0.7, 0.8, 0.9])
    assert only_arm.arm.corank == 1
    assert not any(one.singular for one in only_arm.every)
    both = representation_at(robot, [0.0] * 7)
    assert both.arm.corank == 3
    assert both.zyz.singular
    # the tip of a regular arm, seen from a base that is turned so that its z axes agree
    turn = np.eye(4)
    turn[:3, :3] = pose(robot, regular)[:3, :3].T
    turned = replace(robot, home=robot.home @ turn)
    only_coordinates = representation_at(turned, regular)
    assert only_coordinates.arm.corank == 0
    assert only_coordinates.zyz.singular
    assert "only the coordinates zyz" in only_coordinates.words
    assert np.linalg.matrix_rank(analytical_jacobian(turned, regular, "rpy")) == 6
    assert np.linalg.matrix_rank(analytical_jacobian(turned, regular, "quaternion")) == 6
    with pytest.raises(ConfigurationError, match="zyz coordinates are singular"):
        analytical_jacobian(turned, regular, "zyz")
