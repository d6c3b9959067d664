"""Ordered screw sets: order, pitch, kinds, compound joints."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference.kinematics import exponential, pose

from rankdrop.errors import RobotError
from rankdrop.robot.model import Array, JointKind
from rankdrop.robot.screws import cylindrical, from_screws, helical, prismatic, revolute, spherical
from rankdrop.robot.transform import from_xyz_rpy

vectors = st.lists(st.floats(-3, 3), min_size=3, max_size=3).map(np.array)
axes = vectors.filter(lambda v: np.linalg.norm(v) > 0.1)


@given(axis=axes, point=vectors, length=st.floats(0.01, 100))
def test_revolute_screw_of_any_length_leaves_its_axis_at_rest(axis: Array, point: Array, length: float) -> None:
    joint = from_screws([length * revolute(axis, point)], order="linear-first").joints[0]
    assert joint.kind is JointKind.REVOLUTE
    assert np.linalg.norm(joint.screw[3:]) == pytest.approx(1.0, abs=1e-15)
    moved = exponential(joint.screw, 1.3) @ np.append(point, 1.0)
    assert moved[:3] == pytest.approx(point, abs=1e-12)


@given(axis=axes, point=vectors, pitch=st.floats(-2, 2).filter(lambda h: abs(h) > 0.01), length=st.floats(0.1, 10))
def test_helical_screw_carries_its_axis_by_the_pitch(axis: Array, point: Array, pitch: float, length: float) -> None:
    joint = from_screws([length * helical(axis, point, pitch)], order="linear-first").joints[0]
    assert joint.kind is JointKind.HELICAL
    assert joint.screw[:3] @ joint.screw[3:] == pytest.approx(pitch)
    moved = exponential(joint.screw, 0.7) @ np.append(point, 1.0)
    assert moved[:3] - point == pytest.approx(0.7 * pitch * axis / np.linalg.norm(axis), abs=1e-12)


@given(axis=axes)
def test_prismatic_screw_is_a_unit_direction(axis: Array) -> None:
    joint = from_screws([5.0 * prismatic(axis)], order="linear-first").joints[0]
    assert joint.kind is JointKind.PRISMATIC
    assert joint.screw == pytest.approx(np.append(axis / np.linalg.norm(axis), np.zeros(3)), abs=1e-15)


def test_the_orders_are_swapped_halves(rng: np.random.Generator) -> None:
    screws = np.stack([revolute(*rng.normal(size=(2, 3))) for _ in range(4)])
    linear = from_screws(screws, order="linear-first")
    angular = from_screws(np.roll(screws, 3, axis=1), order="angular-first")
    for one, other in zip(linear.joints, angular.joints, strict=True):
        assert np.array_equal(one.screw, other.screw)


def test_home_is_the_pose_at_zero_and_its_absence_is_noted(rng: np.random.Generator) -> None:
    home = from_xyz_rpy([1, 2, 3], [0.1, 0.2, 0.3])
    robot = from_screws([revolute([0, 0, 1], [1, 0, 0])], order="linear-first", home=home)
    assert pose(robot, [0.0]) == pytest.approx(home)
    assert robot.notes == ()
    assert "home pose not given" in str(from_screws([prismatic([1, 0, 0])], order="linear-first").notes[0])


def test_cylindrical_joint_turns_and_slides_on_one_axis(rng: np.random.Generator) -> None:
    axis, point = np.array([0.0, 0.6, 0.8]), rng.normal(size=3)
    robot = from_screws(cylindrical(axis, point), order="linear-first")
    assert [joint.kind for joint in robot.joints] == ["prismatic", "revolute"]
    slide, turn = (joint.screw for joint in robot.joints)
    one = exponential(slide, 0.3) @ exponential(turn, 0.9)
    assert one == pytest.approx(exponential(turn, 0.9) @ exponential(slide, 0.3), abs=1e-14)
    assert (one @ np.append(point, 1.0))[:3] == pytest.approx(point + 0.3 * axis, abs=1e-13)


def test_spherical_joint_is_three_turns_about_its_centre(rng: np.random.Generator) -> None:
    centre = rng.normal(size=3)
    robot = from_screws(spherical(centre), order="linear-first")
    assert [joint.kind for joint in robot.joints] == ["revolute"] * 3
    assert (pose(robot, rng.uniform(-3, 3, 3)) @ np.append(centre, 1.0))[:3] == pytest.approx(centre, abs=1e-13)
    assert np.linalg.matrix_rank(np.stack([joint.screw for joint in robot.joints])) == 3
    with pytest.raises(RobotError, match="three independent axes"):
        spherical(centre, [[1, 0, 0], [0, 1, 0], [1, 1, 0]])


def test_frame_lies_on_the_axis(rng: np.random.Generator) -> None:
    axis, point = rng.normal(size=3), rng.normal(size=3)
    frame = from_screws([revolute(axis, point)], order="linear-first").joints[0].frame
    assert np.cross(frame[:3, 2], axis) == pytest.approx(np.zeros(3), abs=1e-12)
    assert np.cross(frame[:3, 3] - point, axis) == pytest.approx(np.zeros(3), abs=1e-12)
    assert frame[:3, :3] @ frame[:3, :3].T == pytest.approx(np.eye(3), abs=1e-14)
    assert np.linalg.det(frame[:3, :3]) == pytest.approx(1.0)


def test_printed_digits_are_forgiven_where_the_kind_is_given() -> None:
    screw = [0, 0.7071, 0.7071, 0.00001, 0.70, -0.70002]
    with pytest.raises(RobotError, match="too small to tell from rounding"):
        from_screws([screw], order="angular-first")
    joint = from_screws([screw], order="angular-first", kinds="R").joints[0]
    assert joint.screw[:3] @ joint.screw[3:] == pytest.approx(0.0, abs=1e-16)


@pytest.mark.parametrize(
    ("screws", "options", "words"),
    [
        ([[0, 0, 1, 0, 0, 0]], {"order": "twist"}, "order of the screws must be named"),
        ([[0, 0, 1]], {}, "wrong shape"),
        ([[0, 0, 1, 0, 0, float("inf")]], {}, "screw 1: the screw has values that are not finite"),
        ([["a"] * 6], {}, "not numbers"),
        ([[0] * 6], {}, "no length"),
        ([[0, 0, 1, 0, 0, 1]], {"kinds": ["revolute"]}, "revolute screw has no pitch"),
        ([[0, 0, 1, 0, 0, 1]], {"kinds": ["prismatic"]}, "is not prismatic"),
        ([[0, 0, 1, 0, 0, 0]], {"kinds": ["helical"]}, "is not helical"),
        ([[0, 0, 1, 0, 0, 0]], {"kinds": "X"}, "no such kind"),
        ([[0, 0, 1, 0, 0, 0]], {"names": ["a", "b"]}, "names has one entry per screw"),
        ([[0, 0, 1, 0, 0, 0]] * 2, {"names": ["a", "a"]}, "same name"),
        ([[0, 0, 1, 0, 0, 0]], {"home": np.zeros((4, 4))}, "not a rigid transform"),
        ([[0, 0, 1, 0, 0, 0]], {"lower": [2.0], "upper": [1.0]}, "lower limit above upper"),
        ([], {}, "wrong shape"),
    ],
)
def test_what_cannot_be_used_is_said_in_one_line(screws: Any, options: dict[str, Any], words: str) -> None:
    with pytest.raises(RobotError, match=words) as caught:
        from_screws(screws, **{"order": "linear-first", **options})
    assert "\n" not in str(caught.value)
