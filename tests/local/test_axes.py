"""Axes of joints at one configuration."""

from __future__ import annotations

import numpy as np
from reference import arms

from rankdrop.local.axes import Scene
from rankdrop.robot.open import open_robot


def test_a_scene_of_one_configuration_is_kept_and_a_mimic_joint_is_asked_for() -> None:
    """Relations, circuits and special places of an explanation are about the same axes."""
    arm, mimicking = open_robot("pa10"), arms.random_chain(np.random.default_rng(0), "rrmr")
    q = np.array([0.1, 0.2, 0.0, 0.4, 0.0, 0.6, 0.7])
    assert Scene.at(arm, q) is Scene.at(arm, q.copy(), every_joint=True)
    np.testing.assert_array_equal(Scene.at(arm, q).parallel, Scene(arm, q[None]).parallel)
    place = np.zeros(mimicking.n)
    assert len(Scene.at(mimicking, place).z) == mimicking.n < len(mimicking.joints)
    assert len(Scene.at(mimicking, place, every_joint=True).z) == len(mimicking.joints)
