"""How the solutions of a pose are worded, and why there are none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import pose
from rankdrop.poses.branches import inverse, matrix_of
from rankdrop.poses.unreached import POSITION
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot
from rankdrop.text.inverse import tool_place, tool_sentence


def test_lengths_have_the_unit_in_which_they_are_read() -> None:
    """An arm in centimetres reaches 70 m as it is read; its tool was once printed in mm."""
    centimetres = from_dh([(40.0, 0, 0, 0), (30.0, 0, 0, 0)], convention="standard")
    assert tool_sentence(centimetres, pose(centimetres, [0.0, 0.0])).startswith("Tool at (70.0, 0.0, 0.0) m,")
    small = from_dh([(0.01, 0, 0, 0), (0.01, 0, 0, 0)], convention="standard")
    assert tool_sentence(small, pose(small, [0.0, 0.0])).startswith("Tool at (20.0, 0.0, 0.0) mm,")
    there = matrix_of([100.0, 0.0, 0.0])
    assert "by 30 m" in inverse(centimetres, there, "planar-position", starts=64).sentence


def test_a_pose_that_was_typed_in_millimetres_is_recognised() -> None:
    arm = from_dh([(0.4, 0, 0, 0), (0.3, 0, 0, 0)], convention="standard")
    far = inverse(arm, [600.0, 200.0, 0.0], "planar-position", starts=64).sentence
    assert "are the numbers millimetres? Write 600mm" in far
    assert "millimetres" not in inverse(arm, [6.0, 2.0, 0.0], "planar-position", starts=64).sentence


def test_the_turn_of_a_free_tool_axis_is_across_that_axis() -> None:
    """The tool axis leaves the vertical plane of a five-joint arm; the least turn back is about a line across it."""
    half = np.pi / 2
    table = [(0.0, half, 0.3, 0.0), (0.35, 0.0, 0.0, 0.0), (0.3, 0.0, 0.0, 0.0), (0.0, half, 0.0, half),
             (0.0, 0.0, 0.12, 0.0)]  # fmt: skip
    robot = from_dh(table, convention="standard")
    wanted = matrix_of([0.4, 0.1, 0.3, *np.radians([170.0, 10.0, 0.0])])
    found = inverse(robot, wanted, "tool-axis-free", starts=300)
    assert found.unreached is not None
    made = found.unreached.turned
    turn = np.cross(wanted[:3, 2], made[:3, 2])
    assert found.unreached.turn == pytest.approx(float(np.arcsin(np.linalg.norm(turn))), abs=1e-6)
    axis = ", ".join(f"{x:.2f}".replace("-", "−") for x in turn / np.linalg.norm(turn))
    assert f"turning about ({axis})" in found.sentence


@pytest.mark.slow
def test_out_of_reach_says_by_how_much() -> None:
    robot = open_robot("planar2r")  # reaches 1.7 or so in its plane
    far = pose(robot, [0.4, 0.0])[:3, 3] * 1.25
    found = inverse(robot, far)
    assert found.unreached is not None
    assert found.unreached.kind == POSITION
    assert found.unreached.position == pytest.approx(float(np.linalg.norm(far)) / 5, abs=1e-6)
    np.testing.assert_allclose(found.unreached.tip[:2, 3], far[:2] / 1.25, atol=1e-5)
    assert "Out of reach by" in found.sentence
    arm = open_robot("puma560")
    found = inverse(arm, [2.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert found.unreached is not None
    low = np.random.default_rng(1).uniform(-np.pi, np.pi, (20000, 6))
    sampled = np.linalg.norm(pose(arm, low)[:, :3, 3] - [2.0, 0.0, 0.0], axis=1).min()
    assert found.unreached.position <= sampled + 1e-9


def test_a_position_without_an_orientation_is_for_tasks_without_rotation() -> None:
    arm = open_robot("irb120")
    with pytest.raises(ConfigurationError, match="no orientation"):
        inverse(arm, [0.3, 0.1, 0.3])
    found = inverse(arm, [0.3, 0.1, 0.3], "position", starts=64)
    assert found.continua
    assert found.sections()[0].lines == ("Position: (300.0, 100.0, 300.0) mm, base axes.",)


def test_explain_says_where_the_tool_is(run) -> None:
    q = [0.1, 0.5, 0.3, 0.2, 0.9, 0.6]
    robot = open_robot("puma560")
    out = " ".join(run("explain", "puma560", "--q", ",".join(map(str, q)), "--evaluations", "0").out.split())
    assert tool_sentence(robot, pose(robot, q)) in out
    assert tool_place(robot, matrix_of([0.1, -0.2, 0.3, 0.1, 0.2, 0.3])) == (
        "(100.0, −200.0, 300.0) mm, roll 5.73°, pitch 11.46°, yaw 17.19°"
    )


def test_an_arm_without_limits_has_none_inside_them(run, tmp_path: Path) -> None:
    """The table of the Rokae XB25 in roboticstoolbox-python issue 440: eight solutions, no limits."""
    path = tmp_path / "xb25.toml"
    rows = [(0, 0, 0.49, 0), (0.16, -90, 0, -90), (0.78, 0, 0, 0), (0.15, -90, 0.66, 0)]
    rows += [(0, 90, 0, 0), (0, -90, 0.11, 180)]
    joints = [f'[[joints]]\na = {a}\nalpha = "{b} deg"\nd = {d}\ntheta = "{t} deg"\n' for a, b, d, t in rows]
    path.write_text('convention = "modified"\n' + "".join(joints))
    out = " ".join(run("explain", str(path), "--deg", "--pose", "0.2834,0.2788,0.3,0,180,0").out.split())
    assert "8 solutions; a 6R arm has at most 16. The arm has no joint limits." in out
    assert "inside" not in out
