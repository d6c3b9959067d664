"""A path through a singular configuration: known answers, the law of second order, rates of the joints followed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.posture_changes import decide_postures
from rankdrop.kinematics import jacobian, pose, task_jacobian, task_jacobian_derivative
from rankdrop.path.mend.time_law import CORNER, NOT, PASSES, REGULAR, TANGENT, TURNS, Through, through
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import Task, resolve_task

H = np.pi / 2
WRIST = [0.1, 0.5, 0.4, 0.2, 0.0, 0.6]


def wenger(unit: float = 1.0) -> Robot:
    rows = [(0.0, 1.0, -H), (1.0, 2.0, H), (0.0, 1.5, 0.0)]
    table = [{"d": d * unit, "a": a * unit, "alpha": x} for d, a, x in rows]
    return from_dh(table, convention="standard", task="position", name="wenger")


def directions(robot: Robot, q: Any, task: Task) -> np.ndarray:
    """Left singular vectors as columns, in metres and rad; the lost one last."""
    unit = np.array([task.scale(robot) if row < 3 else 1.0 for row in task.rows])
    return np.linalg.svd(task_jacobian(robot, q, task))[0] * unit[:, None]


def on_the_path(found: Through) -> None:
    """The tool is on the path at every time, by the pose alone."""
    at = pose(found.robot, found.joints)[:, :3, 3] - pose(found.robot, found.q)[:3, 3]
    rows = [i for i, row in enumerate(found.task.rows) if row < 3]
    wanted = found.s[:, None] * found.along[rows] + 0.5 * found.s[:, None] ** 2 * found.bend[rows]
    there = at[:, [row for row in found.task.rows if row < 3]]
    assert np.abs(there - wanted).max() < 1e-9 * max(1.0, float(found.task.scale(found.robot)))
    assert found.off < 1e-9


@pytest.mark.parametrize(("q", "along", "bend", "kind"), [
    ([0, 0], [-1, 0], None, TURNS), ([0, 0], [1, 0], None, TURNS), ([0, 0], [0, 1], None, NOT),
    ([0, 0], [0, 1], [-1, 0], TANGENT), ([0, 0], [0, 1], [-0.5, 0], NOT),  # the reach is 1.7: a circle has 0.588
    ([0, np.pi], [1, 0], None, TURNS), ([0, np.pi], [0, 1], None, TANGENT), ([0, 1], [1, 0], None, REGULAR),
])  # fmt: skip
def test_the_planar_arm_stretched_and_folded(q: Any, along: Any, bend: Any, kind: str) -> None:
    found = through(open_robot("planar2r"), q, along, bend=bend)
    assert found.kind == kind
    assert found.trackable == (kind in (TANGENT, REGULAR))
    if kind == TURNS:
        assert found.order == 2
        assert found.side == (-1 if along == [1, 0] and q == [0, 0] else 1)
        assert abs(found.exponent + 1 / 2) < 0.02
    if len(found.s):
        on_the_path(found)


def test_at_a_cusp_the_lost_direction_is_passed_with_the_cube_of_time() -> None:
    arm = wenger()
    for cusp in decide_postures(exact_chain(arm)).cusps:
        q = np.array([0.3, *cusp])
        found = through(arm, q, directions(arm, q, resolve_task(None, arm))[:, 2])
        assert (found.kind, found.order, found.trackable) == (PASSES, 3, True)
        assert (np.diff(np.sign(found.s)[found.s != 0]) != 0).sum() == 1
        assert abs(found.exponent + 2 / 3) < 0.03
        on_the_path(found)
        rates = np.diff(found.joints, axis=0) / np.diff(found.times)[:, None]
        assert np.abs(rates).max() < 2.0
        assert np.abs(np.diff(rates, axis=0)).max() < 0.1
        at_constant_speed = np.diff(found.joints, axis=0) / np.diff(found.s)[:, None]
        assert np.abs(at_constant_speed).max() > 50 * np.abs(rates).max()


@pytest.mark.parametrize(("name", "q"), [
    ("planar2r", [0.4, 0.0]), ("puma560", [0.3, 0.5, float(np.arctan2(-0.4318, 0.0203)), 0.2, 0.7, 0.1]),
])  # fmt: skip
def test_the_term_of_second_order_is_that_of_the_bracket(name: str, q: Any) -> None:
    robot = open_robot(name)
    task = resolve_task(None, robot)
    u, sigma, vt = np.linalg.svd(task_jacobian(robot, q, task))
    assert sigma[-1] < 1e-9
    lost, v = u[:, -1], vt[-1]
    found = through(robot, q, directions(robot, q, task)[:, -1])
    wanted = lost @ np.einsum("ijk,j,k->i", task_jacobian_derivative(robot, q, task), v, v) / 2.0
    middle = len(found.s) // 2
    near = (found.s[middle - 1] + found.s[middle + 1]) / (2.0 * found.times[middle + 1] ** 2)
    assert abs(near / wanted - 1.0) < 1e-3


def test_a_wrist_takes_paths_in_the_image_of_its_jacobian_and_no_other() -> None:
    robot = open_robot("puma560")
    task = resolve_task(None, robot)
    found = directions(robot, WRIST, task)
    for k in range(5):
        ahead = through(robot, WRIST, found[:, k])
        assert (ahead.kind, ahead.order) == (TANGENT, 1)
        on_the_path(ahead)
    assert through(robot, WRIST, found[:, 5]).kind == NOT


def test_gallardo_and_rico_s_arm_can_go_along_what_is_left_and_turns_back_from_the_rest() -> None:
    robot = open_robot("rcrrrr")
    task = resolve_task(None, robot)
    found = directions(robot, np.zeros(7), task)
    kinds = [through(robot, np.zeros(7), found[:, k]).kind for k in range(6)]
    assert kinds == [TANGENT] * 5 + [TURNS]


def test_joints_to_spare_turn_a_corner_where_the_kernel_bends_both_ways() -> None:
    table = [{"d": 0.0, "a": a, "alpha": 0.0} for a in (1.0, 0.8, 0.5)]
    robot = from_dh(table, convention="standard", task="planar-position", name="planar3")
    found = through(robot, [0.0, 0.0, np.pi], [1.0, 0.0])
    assert (found.kind, found.trackable, found.order) == (CORNER, True, 2)
    on_the_path(found)
    rates = np.diff(found.joints, axis=0) / np.diff(found.times)[:, None]
    middle = len(rates) // 2
    assert np.abs(rates[[middle - 1, middle]]).max() < 0.5 * np.abs(rates).max()
    assert found.s[0] < 0.0 < found.s[-1]
    assert through(robot, [0.0, 0.0, 0.0], [1.0, 0.0]).kind == TURNS


def test_neither_the_unit_nor_the_base_nor_the_sense_of_the_path_matters() -> None:
    cusp = [0.3, *decide_postures(exact_chain(wenger())).cusps[0]]
    along = directions(wenger(), cusp, resolve_task(None, wenger()))[:, 2]
    kept = through(wenger(), cusp, along)
    large = through(wenger(1000.0), cusp, 1000.0 * along)
    assert (large.kind, large.order) == (kept.kind, kept.order)
    assert np.allclose(large.joints, kept.joints, atol=1e-9)
    assert np.allclose(large.s, kept.s, atol=1e-9)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    turned = through(wenger(), [cusp[0] + H, *cusp[1:]], turn @ along)
    assert np.allclose(np.abs(turned.s), np.abs(kept.s), atol=1e-9)
    back = through(wenger(), cusp, -along)
    assert np.allclose(back.s, -kept.s, atol=1e-9)


def test_what_cannot_be_asked_is_refused() -> None:
    arm = open_robot("planar2r")
    for along in ([1.0], [np.nan, 0.0], [0.0, 0.0]):
        with pytest.raises(OptionError):
            through(arm, [0, 0], along)
    with pytest.raises(ConfigurationError, match="corank 2"):
        through(open_robot("pa10"), [0.0] * 7, [1, 0, 0, 0, 0, 0])


def test_a_path_that_needs_an_internal_turn_first_is_told_with_the_turn() -> None:
    """IRB 120 with joints 4 and 6 in line: sideways no joint moves it; with joint 4 at 90° joint 5 does."""
    arm, home, along = open_robot("irb120"), [0.0] * 6, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]
    found = through(arm, home, along)
    assert found.kind == NOT
    assert found.turn is not None
    turned = found.turn.to
    assert np.abs(turned - np.radians([0, 0, 0, 90, 0, -90])).max() < 1e-6
    assert pose(arm, turned) == pytest.approx(pose(arm, home), abs=1e-9)
    lost = np.linalg.svd(jacobian(arm, turned))[0][:, -1]
    assert abs(lost @ along) < 1e-6
    assert through(arm, turned, along).trackable
    assert "joint 4 from 0° to 90° with the tool held still" in found.sentence
    assert through(open_robot("planar2r"), [0, 0], [0, 1]).turn is None
