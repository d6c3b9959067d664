"""Models of other packages as plain records: the frames that they are given, and the arms that are read from them.

Against the packages themselves: `tests/cross/test_models.py`.
"""

from __future__ import annotations

from math import inf
from types import SimpleNamespace

import numpy as np
import pytest

from rankdrop.errors import RobotError
from rankdrop.kinematics import pose
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.models import axis_frames, from_toolbox, from_yourdfpy
from rankdrop.robot.open import open_robot
from rankdrop.robot.screws import from_screws, helical
from rankdrop.robot.transform import about_axis, translation

ARMS = ("puma560", "stanford", "panda", "scara", "planar3r")


def chained(robot: Robot, q: Array) -> Array:
    """(4, 4) pose of the tip by the frames alone: a step, and a motion about or along the axis."""
    frames, tip = axis_frames(robot, "another package")
    at = np.eye(4)
    for (joint, step, axis, _), value in zip(frames, q, strict=True):
        at = at @ translation(*step)
        at = at @ (translation(*(axis * value)) if joint.kind is JointKind.PRISMATIC else about_axis(axis, value))
    return at @ tip


@pytest.mark.parametrize("name", ARMS)
def test_the_frames_of_an_arm_have_its_kinematics(name: str, rng: np.random.Generator) -> None:
    robot = open_robot(name)
    for q in rng.uniform(-2.0, 2.0, (5, robot.n)):
        np.testing.assert_allclose(chained(robot, q), pose(robot, q), atol=1e-12)


def test_no_link_has_the_name_of_another() -> None:
    robot = open_robot("planar3r")
    renamed = Robot(robot.name, robot.joints, robot.home, base="joint1_link", tip="joint1_link_")
    links = [link for *_, link in axis_frames(renamed, "another package")[0]]
    assert len({*links, renamed.base, renamed.tip}) == robot.n + 2


def test_a_joint_that_the_package_does_not_know_is_named() -> None:
    arm = from_screws([helical([0, 0, 1], [0, 0, 0], 0.01)], order="linear-first")
    assert len(axis_frames(arm, "another package", helical=True)[0]) == 1
    with pytest.raises(RobotError, match="another package has no helical joints"):
        axis_frames(arm, "another package")


def transform(letters: str, value: float = 0.0, **more: object) -> SimpleNamespace:
    """An elementary transform, as the Robotics Toolbox has them: fixed by a value, or moving."""
    axis = np.eye(3)["xyz".index(letters[-1])]
    matrix = translation(*(value * axis)) if letters[0] == "t" else about_axis(axis, value)
    return SimpleNamespace(axis=letters, isjoint=False, A=lambda: matrix, **more)


def moving(letters: str, number: int | None, *, flip: bool = False, limits: object = None) -> SimpleNamespace:
    return SimpleNamespace(axis=letters, isjoint=True, isflip=flip, jindex=number, qlim=limits)


def test_elementary_transforms_are_walked_and_flipped_joints_count_the_other_way() -> None:
    walk = [transform("tz", 0.4), moving("Rz", 0, limits=(-1.0, 2.0)), transform("Rx", 0.3), moving("Ry", 1, flip=True),
            transform("tx", 0.5), moving("tz", 2)]  # fmt: skip
    robot = from_toolbox(walk)
    x, y, z = np.eye(3)
    q = np.array([0.3, -0.7, 0.2])
    wanted = (translation(0, 0, 0.4) @ about_axis(z, 0.3) @ about_axis(x, 0.3) @ about_axis(y, 0.7)
              @ translation(0.5, 0, 0) @ translation(0, 0, 0.2))  # fmt: skip
    np.testing.assert_allclose(pose(robot, q), wanted, atol=1e-12)
    assert [joint.kind for joint in robot.joints] == [JointKind.REVOLUTE, JointKind.REVOLUTE, JointKind.PRISMATIC]
    assert [(joint.lower, joint.upper) for joint in robot.joints] == [(-1.0, 2.0), (-inf, inf), (-inf, inf)]


@pytest.mark.parametrize("numbers", [(1, 0), (0, 0)])
def test_variables_that_are_not_numbered_along_the_chain_are_refused(numbers: tuple[int, int]) -> None:
    with pytest.raises(RobotError, match="not numbered along the chain"):
        from_toolbox([moving("Rz", numbers[0]), transform("tx", 1.0), moving("Rz", numbers[1])])


def urdf_joint(name: str, kind: str, parent: str, child: str, **given: object) -> SimpleNamespace:
    unset = {"origin": None, "axis": None, "limit": None, "mimic": None}
    return SimpleNamespace(name=name, type=kind, parent=parent, child=child, **(unset | given))


def test_a_urdf_record_is_read_to_the_last_bit() -> None:
    limit = SimpleNamespace(lower=-0.1, upper=1 / 3, velocity=2.5)
    joints = [
        urdf_joint("slide", "prismatic", "base", "carriage", origin=translation(0, 0, 0.1), limit=limit,
                   axis=np.array([0.0, 1.0, 0.0])),
        urdf_joint("turn", "continuous", "carriage", "arm", origin=translation(0.2, 0, 0), axis=np.array([0.0, 0, 1])),
        urdf_joint("flange", "fixed", "arm", "tool", origin=translation(1 / 7, 0, 0)),
    ]  # fmt: skip
    links = [SimpleNamespace(name=name) for name in ("base", "carriage", "arm", "tool")]
    record = SimpleNamespace(name="two", links=links, joints=joints)
    for model in (record, SimpleNamespace(robot=record)):
        robot = from_yourdfpy(model, base="base", tip="tool")
        slide, turn = robot.joints
        assert (slide.lower, slide.upper, slide.velocity) == (-0.1, 1 / 3, 2.5)
        assert (turn.lower, turn.upper) == (-inf, inf)
        wanted = translation(0.2, 0.3, 0.1) @ about_axis(np.array([0.0, 0, 1]), 0.5) @ translation(1 / 7, 0, 0)
        np.testing.assert_allclose(pose(robot, np.array([0.3, 0.5])), wanted, atol=1e-15)


def test_a_joint_that_follows_another_keeps_its_factor() -> None:
    mimic = SimpleNamespace(joint="first", multiplier=-0.5, offset=0.25)
    z = np.array([0.0, 0.0, 1.0])
    first = urdf_joint("first", "continuous", "base", "upper", axis=z)
    second = urdf_joint("second", "continuous", "upper", "tool", axis=z, origin=translation(0.4, 0, 0), mimic=mimic)
    links = [SimpleNamespace(name=name) for name in ("base", "upper", "tool")]
    robot = from_yourdfpy(SimpleNamespace(name="pair", links=links, joints=[first, second]), base="base", tip="tool")
    assert robot.n == 1
    wanted = about_axis(z, 0.6) @ translation(0.4, 0, 0) @ about_axis(z, -0.5 * 0.6 + 0.25)
    np.testing.assert_allclose(pose(robot, np.array([0.6])), wanted, atol=1e-15)
