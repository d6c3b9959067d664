"""The tool that turns chains into tables: any chain of revolute joints is the chain of its table, written shortly."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from scripts import tool

from rankdrop.kinematics import pose
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.robot.screws import from_screws, revolute

TOOL = tool("dh_table")


def again(robot: Robot) -> Robot:
    """The robot of its table."""
    base, rows, end = TOOL.dh_table(robot)
    return from_dh(rows, convention="standard", base=base, tool=end)


@pytest.mark.parametrize("seed", range(10))
def test_a_chain_of_any_axes_is_that_of_its_table(seed: int, rng: np.random.Generator) -> None:
    given = np.random.default_rng(seed)
    screws = [revolute(given.normal(size=3), given.normal(size=3)) for _ in range(6)]
    home = open_robot("pa10").home.copy()
    home[:3, 3] = given.normal(size=3)
    robot = from_screws(screws, order="linear-first", kinds="RRRRRR", home=home)
    q = rng.uniform(-pi, pi, (20, 6))
    assert np.abs(pose(again(robot), q) - pose(robot, q)).max() < 1e-9


@pytest.mark.parametrize("name", ["pa10", "ur5", "canadarm2", "puma560", "gen3", "scara"])
def test_parallel_meeting_and_common_axes_have_tables_too(name: str, rng: np.random.Generator) -> None:
    robot = open_robot(name)
    if any(str(joint.kind) != "revolute" for joint in robot.joints):
        robot = from_screws([joint.screw for joint in robot.joints if joint.screw[3:].any()], order="linear-first")
    q = rng.uniform(-pi, pi, (20, robot.n))
    assert np.abs(pose(again(robot), q) - pose(robot, q)).max() < 1e-12
    for a, alpha, d, theta in TOOL.dh_table(robot)[1]:
        assert TOOL.angle_text(alpha) in ("0", '"pi/2"', '"-pi/2"', '"pi"')
        assert abs(theta) <= pi / 2 + 1e-9 or theta == pytest.approx(pi)
        assert max(abs(a), abs(d)) < 10


@pytest.mark.parametrize(
    ("angle", "text"),
    [(0.0, "0"), (pi / 2, '"pi/2"'), (-pi, '"-pi"'), (5 * pi / 6, '"5*pi/6"'), (0.3, "0.3"), (-1e-12, "0")],
)
def test_angles_are_written_exactly_where_they_are_parts_of_a_turn(angle: float, text: str) -> None:
    assert TOOL.angle_text(angle) == text


def test_numbers_are_written_without_the_rounding_of_their_sums() -> None:
    assert [TOOL.number_text(x) for x in (0.1 + 0.2, 0.16250000000000003, -0.0, 1.0)] == ["0.3", "0.1625", "0", "1"]


def test_poses_are_written_with_what_is_not_nothing() -> None:
    assert TOOL.pose_lines("tool", np.eye(4)) == []
    turned = np.diag([1.0, -1.0, -1.0, 1.0])
    turned[2, 3] = 0.1
    assert TOOL.pose_lines("tool", turned) == ["[tool]", "xyz = [0, 0, 0.1]", 'rpy = ["pi", 0, 0]', ""]
