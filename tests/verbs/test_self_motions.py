"""Fault tolerance over self-motions: closed forms of a planar arm, joint limits, seeds, and what is refused."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from rankdrop.codec import json_text, record_of
from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.kinematics import pose
from rankdrop.local.failures import worst_case
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema
from rankdrop.sections import text
from rankdrop.task import Task, resolve_task
from rankdrop.text.words import tolerant_lines, tolerant_sections
from rankdrop.verbs.self_motions import self_motions, union_of_ranges
from rankdrop.verbs.tolerant import most_tolerant

Q = np.array([0.3, 0.8, 0.9])


@pytest.fixture(scope="module")
def planar() -> tuple[Robot, Task]:
    robot = open_robot("planar3r")
    return robot, resolve_task("planar-position", robot)


def links(robot: Robot) -> list[float]:
    places = [pose(robot, [0.0] * 3)[0, 3]]
    for j in (1, 2):  # the tip as joint j is turned over: link lengths follow
        places.append(float(pose(robot, [0.0] * j + [np.pi] + [0.0] * (2 - j))[0, 3]))
    whole, second, third = places
    beyond_third = (whole - third) / 2
    return [whole - (whole - second) / 2, (whole - second) / 2 - beyond_third, beyond_third]


def solutions(robot: Robot, tip: np.ndarray, first: np.ndarray) -> np.ndarray:
    """(N, 2, 3) configurations with joint 1 at `first` and the tip at a place; NaN where it is out of reach."""
    a, b, c = links(robot)
    x, y = tip[0] - a * np.cos(first), tip[1] - a * np.sin(first)
    with np.errstate(invalid="ignore"):
        third = np.arccos((x**2 + y**2 - b**2 - c**2) / (2 * b * c))
    found = []
    for elbow in (third, -third):
        second = np.arctan2(y, x) - np.arctan2(c * np.sin(elbow), b + c * np.cos(elbow)) - first
        found.append(np.stack([first, (second + np.pi) % (2 * np.pi) - np.pi, elbow], axis=-1))
    return np.stack(found, axis=1)


def test_the_values_of_a_planar_arm_are_those_of_its_closed_form(planar) -> None:
    robot, task = planar
    first = np.linspace(-np.pi, np.pi, 100_001)
    every = solutions(robot, pose(robot, Q)[:2, 3], first)
    reached = np.isfinite(every[:, 0, 2])
    found = self_motions(robot, Q, task)
    assert found.complete
    assert found.curves == 1
    assert found.joints[0].share == pytest.approx(reached.mean(), abs=2e-3)
    for j in (1, 2):
        values = every[reached][:, :, j]
        assert found.joints[j].ranges[0] == pytest.approx((values.min(), values.max()), abs=5e-3)
    assert found.weakest.number == 1
    values = worst_case(robot, every[reached].reshape(-1, 3), task)
    assert found.best_value == pytest.approx(values.max(), rel=1e-3)
    assert worst_case(robot, found.best, task) == pytest.approx(found.best_value)
    assert pose(robot, found.best)[:2, 3] == pytest.approx(found.tool_pose[:2, 3], abs=1e-9)
    assert found.value == pytest.approx(float(worst_case(robot, Q, task)))


def test_only_configurations_inside_the_limits_count(planar) -> None:
    robot, task = planar
    low, high = np.radians([-180.0, -45.0, -120.0]), np.radians([180.0, 60.0, 90.0])
    joints = tuple(replace(one, lower=a, upper=b) for one, a, b in zip(robot.joints, low, high, strict=True))
    bounded = replace(robot, joints=joints)
    first = np.linspace(-np.pi, np.pi, 100_001)
    every = solutions(robot, pose(robot, Q)[:2, 3], first)
    inside = ((every >= low) & (every <= high)).all(axis=2)
    found = self_motions(bounded, Q, task, limits=True)
    assert found.usable == 1
    assert found.joints[0].share == pytest.approx(inside.any(axis=1).mean(), abs=3e-3)
    for j in (1, 2):
        counts = np.histogram(every[..., j][inside], bins=500, range=(low[j], high[j]))[0]
        assert found.joints[j].share == pytest.approx((counts > 0).mean(), abs=0.02)
    assert (found.best >= low).all()
    assert (found.best <= high).all()
    assert self_motions(bounded, Q, task).joints[0].share > found.joints[0].share


@pytest.mark.slow
def test_another_seed_finds_the_same_values_of_seven_joints() -> None:
    robot = open_robot("panda")
    task = resolve_task(None, robot)
    q = np.array([0.0, -0.7, 0.3, -2.4, -0.2, 1.6, 0.0])
    one, other = (self_motions(robot, q, task, limits=True, seed=seed) for seed in (0, 1))
    assert (one.curves, one.usable) == (other.curves, other.usable) == (8, 2)
    assert [a.share for a in one.joints] == pytest.approx([b.share for b in other.joints], abs=5e-3)
    assert one.weakest.number == 4


def test_ranges_are_joined_where_they_overlap() -> None:
    assert union_of_ranges([(2.0, 3.0), (0.0, 1.0), (0.5, 1.5), (0.6, 0.7)]) == ((0.0, 1.5), (2.0, 3.0))


@pytest.mark.slow
def test_the_record_and_the_words_have_the_pose_that_was_asked_about(planar) -> None:
    robot, task = planar
    found = most_tolerant(robot, task, starts=10, show=1, self_motion=True, q=Q.tolist())
    motion = found.self_motion
    assert motion is not None
    record = json.loads(json_text(record_of("tolerant", found)))
    Draft202012Validator(load_schema("tolerant")).validate(record)
    assert record["self_motion"]["joints"][0]["share"] == motion.joints[0].share
    assert record["self_motion"]["q"] == Q.tolist()
    share = f"{100 * motion.joints[0].share:.3g} %"
    assert tolerant_lines(found)[1].startswith(f"With joint 1 locked the tool still reaches the pose at {share}")
    words = " ".join(text(tolerant_sections(found)).split())
    assert f"at (17.19°, 45.84°, 51.57°), at best {motion.best_value:.4g}" in words
    own = most_tolerant(robot, task, starts=10, show=1, self_motion=True)
    assert own.self_motion is not None
    assert own.self_motion.q == pytest.approx(own.places[0].q)
    assert own.self_motion.best_value >= own.places[0].value * (1 - 1e-9)
    assert most_tolerant(robot, task, starts=10, show=1).self_motion is None


def test_what_has_no_self_motion_curve_is_refused(planar) -> None:
    robot, task = planar
    with pytest.raises(OptionError, match="ask for self_motion"):
        most_tolerant(robot, task, q=Q.tolist())
    with pytest.raises(OptionError, match=r"one joint to spare.*6 joints, rank 6"):
        most_tolerant(open_robot("ur5e"), self_motion=True)
    with pytest.raises(OptionError, match="7 joints, rank 3"):
        most_tolerant(open_robot("panda"), "position", self_motion=True)
    with pytest.raises(ConfigurationError, match="change joints 4, 6"):
        most_tolerant(open_robot("panda"), self_motion=True, limits=True, q=(0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0))
    with pytest.raises(ConfigurationError, match="no self-motion was found"):
        self_motions(robot, np.zeros(3), task)  # stretched: the only configuration of its tip
