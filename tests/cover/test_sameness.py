"""What must not change a certified radius: base, tool, the sense of a joint, units; and what moves nothing."""

from __future__ import annotations

import numpy as np
import pytest
from reference import arms, region

from rankdrop.cover.ball import certified_radius
from rankdrop.cover.setting import settings_for
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

BUDGET = 600


def radii(robot, q, task=None):
    """One enclosure, and with branch and bound."""
    found = certified_radius(robot, q, task, evaluations=BUDGET)
    return np.array([found.single, found.radius])


@pytest.mark.parametrize("name", ["puma560", "ur5", "pa10", "panda", "planar3r"])
def test_base_tool_sense_and_units_do_not_matter(name):
    robot, rng = open_robot(name), np.random.default_rng(1)
    q = rng.uniform(-2, 2, robot.n)
    want = radii(robot, q)
    assert want[0] > 0.0
    flips = [0, 2]
    sense = np.where(np.isin(np.arange(robot.n), flips), -1.0, 1.0)
    motion = arms.rigid(rng)
    tool = Robot("tool", robot.joints, robot.home @ arms.rigid(rng), robot.task)
    cases = [
        (region.moved_base(robot, motion), q), (region.flipped(robot, flips), q * sense),
        (region.scaled(robot, 1000.0), q), (region.scaled(robot, 1e-3), q),
    ]  # fmt: skip
    if robot.task == "pose":
        cases.append((tool, q))
    else:  # rows of the base's axes: only motions of the plane leave the task what it is
        cases[0] = (region.moved_base(robot, np.diag([-1.0, -1, 1, 1])), q)
    for other, row in cases:
        np.testing.assert_allclose(radii(other, row), want, rtol=1e-6)


def test_first_and_last_joint_do_not_matter_for_the_pose():
    robot, rng = open_robot("pa10"), np.random.default_rng(2)
    q = rng.uniform(-2, 2, 7)
    moved = q + np.array([1.3, 0, 0, 0, 0, 0, -2.2])
    np.testing.assert_allclose(radii(robot, moved), radii(robot, q), rtol=1e-9)


def test_a_point_far_from_the_last_axis_counts_for_the_position():
    robot = open_robot("almarkhi4")
    q = [0.2, 0.8, -0.7, 0.5]
    longer = region.moved_base(robot, np.eye(4))
    home = longer.home.copy()
    home[:3, 3] += [0.3, 0.1, 0.4]
    longer = Robot("longer", robot.joints, home, "position")
    assert abs(radii(longer, q)[0] - radii(robot, q)[0]) > 1e-3


@pytest.mark.parametrize(
    ("words", "task"),
    [("r r r r r r", "pose"), ("r p r r p r", "pose"), ("r r0:2 r p r0:-1 r r", "pose"), ("r r r r", "position"),
     ("r r r r r", "orientation"), ("h r r h r r", "pose"), ("r r", "pose"), ("p r p0:1 r r r", "pose")],
)  # fmt: skip
def test_every_variable_that_changes_a_column_matters(words, task):
    robot = region.coupled(np.random.default_rng(3), words)
    q = np.random.default_rng(4).uniform(-1, 1, robot.n)
    for setting in settings_for(robot, resolve_task(task, robot)):
        step = 0.1 * np.eye(robot.n)
        here = region.jacobian(robot, q, setting)
        moved = np.abs(region.jacobian(robot, q + step, setting) - here).max(axis=(1, 2)) > 1e-9
        assert (setting.matters | ~moved).all()  # a slide may matter to nothing, and count all the same
        count = [sum(joint.mimic is not None and joint.mimic.leader == one.name for joint in robot.joints) + 1
                 for one in robot.variables]  # fmt: skip
        assert setting.repeats == pytest.approx(np.sqrt(max(count)))


@pytest.mark.slow
def test_reaches_are_the_longest_there_are():
    # each axis of a stretched arm is as far from the point as its reach says, and never farther
    robot = open_robot("panda")
    for setting in settings_for(robot, resolve_task(None, robot)):
        q = np.random.default_rng(5).uniform(-np.pi, np.pi, (3000, 7))
        columns = region.columns(robot, q, setting)
        far = np.linalg.norm(columns[..., :3], axis=-1).max(axis=0) * setting.length
        assert (far <= setting.arm * (1 + 1e-9)).all()
        assert (far >= 0.8 * setting.arm)[setting.arm > 1e-9].all()


def test_units_of_slides():
    # columns of slides are per metre, so that the singular basis, and with it the radius, depend on the unit a little
    robot = open_robot("stanford")
    q = np.array([0.3, 0.9, 0.4, 0.2, 0.8, 0.1])
    slides = np.array([joint.unit == "m" for joint in robot.variables])
    for factor in (1e3, 1e-3):
        other = radii(region.scaled(robot, factor), np.where(slides, factor * q, q))
        assert (np.abs(np.log(other / radii(robot, q))) < np.log(2)).all()
