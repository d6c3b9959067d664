"""The reach of an arm: a length that no pose, base, frame or direction of a joint changes, and no tip exceeds."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from reference.arms import remade
from reference.kinematics import exponential, pose

from rankdrop.robot.arm_reach import FAR_SLIDE, anchors, astray, extent, link_lengths, reach, travel_limits
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot

ARMS = ("planar3r", "puma560", "ur5e", "iiwa14", "canadarm2", "irb140")
MOTION = exponential(np.array([0.3, -0.2, 0.5, 0.6, 0.0, 0.8]), 1.9)


def on_a_rail(travel: tuple[float, float]) -> Robot:
    """Two links of 0.4 m and 0.3 m behind a slide."""
    rows = [(0, pi / 2, 0, 0), (0.4, 0, 0, 0), (0.3, 0, 0, 0)]
    arm = from_dh(rows, kinds="PRR", convention="standard")
    slide = replace(arm.joints[0], lower=travel[0], upper=travel[1])
    return replace(arm, joints=(slide, *arm.joints[1:]))


def test_the_reach_of_a_planar_arm_is_the_sum_of_its_links() -> None:
    arm = from_dh([(0.5, 0, 0, 0), (0.25, 0, 0, 0.7), (0.125, 0, 0, -2.0)], convention="standard")
    assert link_lengths(arm) == pytest.approx([0.5, 0.25, 0.125])
    assert reach(arm) == pytest.approx(0.875)


@pytest.mark.parametrize("name", ARMS)
def test_no_tip_is_farther_from_the_first_axis_than_the_reach(name: str, rng: np.random.Generator) -> None:
    arm = open_robot(name)
    first = arm.joints[0]
    tips = pose(arm, rng.uniform(-pi, pi, (400, arm.n)))[:, :3, 3]
    far = np.linalg.norm(np.cross(tips - first.foot, first.axis), axis=1)
    assert far.max() <= reach(arm) * (1 + 1e-12)
    assert far.max() > 0.3 * reach(arm)


@pytest.mark.parametrize("name", ARMS)
def test_the_reach_is_the_same_for_another_base_and_reversed_joints(name: str) -> None:
    arm = open_robot(name)
    assert reach(remade(arm, motion=MOTION, sign=-1.0)) == pytest.approx(reach(arm))
    assert reach(remade(arm, length=1000.0)) == pytest.approx(1000.0 * reach(arm))


def test_the_reach_does_not_depend_on_frames_of_links() -> None:
    arm = open_robot("puma560")
    joints = tuple(replace(joint, frame=MOTION @ joint.frame) for joint in arm.joints)
    assert link_lengths(replace(arm, joints=joints)) == pytest.approx(link_lengths(arm))


@pytest.mark.parametrize("name", ARMS)
def test_anchors_stand_on_their_axes_and_are_the_links_apart(name: str) -> None:
    arm = open_robot(name)
    points = anchors(arm)
    for joint, point in zip(arm.joints, points, strict=True):
        assert np.cross(point - joint.foot, joint.axis) == pytest.approx(np.zeros(3), abs=1e-12)
    between = np.linalg.norm(np.diff([*points, arm.home[:3, 3]], axis=0), axis=1)
    assert between == pytest.approx(link_lengths(arm))
    assert extent(arm) == pytest.approx(between.sum())


def test_a_bare_wrist_has_reach_one() -> None:
    arm = from_dh([(0, pi / 2, 0, 0), (0, -pi / 2, 0, 0), (0, 0, 0, 0)], convention="standard")
    assert link_lengths(arm).tolist() == [0.0, 0.0, 0.0]
    assert reach(arm) == 1.0


def test_a_slide_adds_its_longest_travel_unless_that_says_nothing_of_the_arm() -> None:
    links = 0.7
    assert reach(on_a_rail((-1.5, 0.5))) == pytest.approx(links + 1.5)
    long = on_a_rail((-0.5, (FAR_SLIDE + 1) * links))
    assert travel_limits(long, long.joints[0]) == (-0.5, np.inf)
    assert reach(long) == pytest.approx(links)


def test_a_frame_far_from_the_arm_is_astray() -> None:
    arm = open_robot("puma560")
    assert astray(arm) == [False] * 6
    away = arm.joints[2].frame.copy()
    away[:3, 3] += 100.0
    joints = [replace(joint, frame=away) if k == 2 else joint for k, joint in enumerate(arm.joints)]
    assert astray(replace(arm, joints=tuple(joints))) == [False, False, True, False, False, False]
