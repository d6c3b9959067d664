"""A pose half a turn off is not reached: errors at π, solutions confirmed by forward kinematics, and budgets."""

from __future__ import annotations

from itertools import permutations, product
from pathlib import Path

import numpy as np
import pytest

from rankdrop.kinematics import pose
from rankdrop.local.orientation import rotation_vector
from rankdrop.path.check import follow
from rankdrop.path.check.path_file import PathQuestion, check_file
from rankdrop.path.check.tool_path import check_poses
from rankdrop.poses import inverse
from rankdrop.poses.inverse import Aim, rotation
from rankdrop.questions import PathOptions
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.task import resolve_task

HEAD = "x,y,z,qx,qy,qz,qw\n"
HALF = float(np.sqrt(0.5))
FILES = {"irb120": "1,0,0,0", "lrmate200id": f"0,{HALF!r},0,{HALF!r}"}


def parallel_rotations() -> np.ndarray:
    """(24, 3, 3) all rotations that carry the axes of the base into each other."""
    found = []
    for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        turn = np.eye(3)[list(order)] * np.array(signs)[:, None]
        if np.linalg.det(turn) > 0:
            found.append(turn)
    return np.array(found)


def axis_parallel_poses(robot, count: int, seed: int) -> np.ndarray:
    """(count, 4, 4) poses with the tool along axes of the base, the tip in a plane through the base's axis."""
    rng = np.random.default_rng(seed)
    made = np.tile(np.eye(4), (count, 1, 1))
    turns = parallel_rotations()
    made[:, :3, :3] = turns[rng.integers(0, len(turns), count)]
    made[:, :3, 3] = reach(robot) * rng.uniform((0.2, 0.0, 0.0), (0.6, 0.0, 0.6), (count, 3))
    return made


def off_by(robot, q: np.ndarray, goal: np.ndarray) -> float:
    """The largest difference of any entry of the pose: 2 at half a turn."""
    return float(np.abs(pose(robot, q) - goal).max(initial=0.0))


def test_the_rotation_vector_of_half_a_turn_has_its_full_length() -> None:
    rng = np.random.default_rng(3)
    axes = np.concatenate([np.eye(3), -np.eye(3), rng.normal(size=(50, 3))])
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    for angle in (1e-12, 1e-7, 0.1, 2.5, 3.0, np.pi - 1e-4, np.pi - 1e-9):
        np.testing.assert_allclose(rotation_vector(rotation(angle * axes)), angle * axes, rtol=1e-7, atol=1e-15)
    half = 2 * axes[:, :, None] * axes[:, None, :] - np.eye(3)
    found = rotation_vector(half)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), np.pi, rtol=1e-12)
    np.testing.assert_allclose(np.abs((found * axes).sum(axis=1)), np.pi, rtol=1e-12)


@pytest.mark.parametrize("task", ["pose", "tool-axis-free", "vx,vy,vz,wx,wy", "orientation"])
def test_an_error_of_half_a_turn_is_never_zero(task: str) -> None:
    robot = open_robot("ur5")
    resolved = resolve_task(task, robot)
    aim = Aim(robot, resolved)
    q = np.array([[0.3, -1.2, 1.4, -1.0, 1.2, 0.4]])
    here = pose(robot, q)
    turned = here.copy()
    axis = here[0, :3, 0] if aim.with_tip else np.eye(3)[0]
    turned[0, :3, :3] = (2 * np.outer(axis, axis) - np.eye(3)) @ here[0, :3, :3]
    assert np.linalg.norm(aim.error(turned, q)) == pytest.approx(np.pi, abs=1e-6)
    assert not aim.confirms(turned, q)[0]
    assert aim.confirms(here, q)[0]


def test_a_planar_tool_turned_over_has_no_heading() -> None:
    robot = open_robot("planar3r")
    aim = Aim(robot, resolve_task(None, robot))
    q = np.array([[0.3, 0.4, 0.2]])
    goal = pose(robot, q)
    goal[0, :3, :3] = np.diag([1.0, -1.0, -1.0])
    assert len(aim.solve_from(goal[0], q)) == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_the_files_of_the_reports_end_and_keep_to_their_poses(name: str, tmp_path: Path) -> None:
    file = tmp_path / "poses.csv"
    file.write_text(HEAD + "".join(f"0.35,0,{z},{FILES[name]}\n" for z in (0.40, 0.45)))
    robot = open_robot(name)
    check = check_file(robot, file, PathQuestion(None, None, PathOptions()))
    assert check.tool is not None
    assert check.tool.complete
    assert len(check.tool.q) < 1000
    ends = check.tool.q[np.isin(check.tool.place, (1.0, 2.0))]
    x, y, z, w = map(float, FILES[name].split(","))
    turn = rotation(2 * np.arctan2(np.linalg.norm([x, y, z]), w) * np.array([[x, y, z]]) / np.linalg.norm([x, y, z]))[0]
    for q, height in zip(ends, (0.40, 0.45), strict=True):
        there = pose(robot, q)
        np.testing.assert_allclose(there[:3, 3], (0.35, 0.0, height), atol=1e-9)
        np.testing.assert_allclose(there[:3, :3], turn, atol=1e-9)


def check_arm(name: str, poses: int, starts: int) -> None:
    robot = open_robot(name)
    task = resolve_task("pose", robot)
    aim = Aim(robot, task)
    rng = np.random.default_rng(1)
    for goal in axis_parallel_poses(robot, poses, 5):
        begin = rng.uniform(-np.pi, np.pi, (starts, 6))
        begin[::2, 0] = 0.0  # in the plane of the arm, where the error of half a turn is symmetric
        found = aim.solve_from(goal, begin)
        assert off_by(robot, found, goal) <= 1e-9, name


@pytest.mark.parametrize("name", ["irb120", "lrmate200id", "puma560", "ur5"])
def test_no_solution_misses_an_axis_parallel_pose(name: str) -> None:
    check_arm(name, 6, 60)


@pytest.mark.by_hand
def test_no_solution_of_any_arm_misses_an_axis_parallel_pose() -> None:
    names = [name for name in robot_names() if open_robot(name).n == 6]
    assert len(names) > 100
    for name in names:
        check_arm(name, 12, 200)


@pytest.mark.slow
def test_a_bound_that_cannot_fall_costs_no_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows are put in only while there is hope: where the bound stays, the path ends, and says so."""
    robot = open_robot("ur5")
    q = np.array([[0.3, -1.2, 1.4, -1.0, 1.2, 0.4], [0.4, -1.1, 1.3, -1.0, 1.2, 0.4]])
    most = 0

    def hopeless(self, rows, poses):
        nonlocal most
        most = max(most, len(rows))
        return np.full(len(rows) - 1, 1.0), np.full(len(rows) - 1, 1.0)

    monkeypatch.setattr(inverse.Aim, "deviation", hopeless)
    check = check_poses(robot, pose(robot, q), start=q[0], branches=False)
    assert most <= 100_000
    assert not check.holds
    assert check.tool.reason in ("stuck", "budget")


@pytest.mark.slow
def test_a_spent_budget_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(follow, "_ROWS", 20)
    robot = open_robot("ur5")
    q = np.array([[0.3, -1.2, 1.4, -1.0, 1.2, 0.4], [1.4, -0.6, 1.9, -1.0, 1.2, 0.4]])
    check = check_poses(robot, pose(robot, q), start=q[0], branches=False)
    assert check.tool.reason == "budget"
    assert not check.holds
    assert "used up" in check.sentence
    assert check.verdict == "undecided"
