"""Straight tool lines aimed past singularities: none that is called free leaves its line or needs rates above limits.

The judge is apart from the code it judges: dense points of the joint path, plain Newton steps with NumPy's
pseudo-inverse onto the line itself, and the joint rates there.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import count

import numpy as np
import pytest

from rankdrop.kinematics import pose, task_jacobian
from rankdrop.local.rates import rate_limits
from rankdrop.path.check.follow import follow
from rankdrop.path.check.record import PathCheck
from rankdrop.path.check.tool_path import check_poses
from rankdrop.results.known import known_analysis
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

pytestmark = pytest.mark.shipped
ARMS = ("ur5e", "puma560", "panda", "pa10", "gen3", "ur10e", "ur3e", "ur5", "lbr_iiwa_7_r800", "gp7")
DENSE = 4001
AWAY = 1e-3  # a row of the joint path and the configuration exactly on the line that stands for it, at most [rad]


def lines(name: str, number: int, seed: int):
    """(arm, poses, times, start) of lines of 0.2 reaches at 0.25 m/s that pass a family at 0.001° to 1°."""
    robot, rng = open_robot(name), np.random.default_rng(seed)
    if not np.isfinite(rate_limits(robot)).any():
        robot = replace(robot, joints=tuple(replace(joint, velocity=3.0) for joint in robot.joints))
    families = [one for one in known_analysis(robot, resolve_task(None, robot)).families if one.corank == 1]
    made = 0
    for k in count():
        if made == number:
            return
        near = np.array(families[k % len(families)].witness)
        away = rng.normal(size=robot.n)
        q = near + np.radians(10.0 ** rng.uniform(-3, 0)) * away / np.linalg.norm(away)
        q = np.clip(q, robot.lower + 1e-6, robot.upper - 1e-6)
        middle = pose(robot, q)
        ends = np.repeat(middle[None], 2, axis=0)
        way = rng.normal(size=3)
        half = 0.1 * np.linalg.norm(robot.home[:3, 3]) * way / np.linalg.norm(way)
        ends[0, :3, 3] -= half
        ends[1, :3, 3] += half
        back = follow(robot, np.stack([middle, ends[0]]), q)
        if len(back.q):
            ends[0] = pose(robot, back.last)
            made += 1
            length = float(np.linalg.norm(ends[1, :3, 3] - ends[0, :3, 3]))
            yield robot, ends, np.array([0.0, length / 0.25]), back.last


def judge(robot: Robot, check: PathCheck, ends: Array, times: Array) -> tuple[float, float, float]:
    """The farthest that the tip of the joint path is from the line [m], and the largest share of a rate limit.

    The share is that of the shortest rates which keep the tool on the line, then that of the joint path itself, which a
    redundant arm may choose longer.
    """
    share = np.linspace(0.0, 1.0, DENSE)
    place = check.tool.place - 1.0
    rows = np.concatenate([check.curve.control[:, 0], check.curve.control[-1:, -1]])
    share = np.unique(np.concatenate([share, place, (place[1:] + place[:-1]) / 2]))
    q = np.stack([np.interp(share, place, column) for column in rows.T], axis=1)
    wanted = ends[0, :3, 3] + share[:, None] * (ends[1, :3, 3] - ends[0, :3, 3])
    off = float(np.linalg.norm(pose(robot, q)[:, :3, 3] - wanted, axis=1).max())
    own = float((np.abs(np.diff(rows, axis=0) / (np.diff(place) * times[-1])[:, None]) / rate_limits(robot)).max())
    start = q
    for _ in range(4):
        now = pose(robot, q)
        turn = ends[0, :3, :3] @ now[:, :3, :3].swapaxes(1, 2)
        skew = (turn - turn.swapaxes(1, 2)) / 2
        twist = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)
        error = np.concatenate([wanted - now[:, :3, 3], twist], axis=1)
        q = q + np.einsum("nij,nj->ni", np.linalg.pinv(task_jacobian_of(robot, q)), error)
    # within 0.01 mm of a singularity the nearest configuration exactly on the line may be one that the arm is far from
    q = np.where(np.abs(q - start).max(axis=1, keepdims=True) <= AWAY, q, start)
    speed = np.zeros(6)
    speed[:3] = (ends[1, :3, 3] - ends[0, :3, 3]) / times[-1]
    rates = np.abs(np.linalg.pinv(task_jacobian_of(robot, q)) @ speed)
    return off, float((rates / rate_limits(robot)).max()), own


def task_jacobian_of(robot: Robot, q: Array) -> Array:
    """(N, 6, n) in metres and radians."""
    task = resolve_task(None, robot)
    scale = np.array([task.scale(robot)] * 3 + [1.0] * 3)
    return np.asarray(task_jacobian(robot, q, task) * scale[:, None])


def hold(name: str, number: int, seed: int) -> dict[str, int]:
    verdicts: dict[str, int] = {}
    for robot, ends, times, start in lines(name, number, seed):
        check = check_poses(robot, ends, times, start=start)
        verdicts[check.verdict] = verdicts.get(check.verdict, 0) + 1
        if check.tool.complete:
            off, share, own = judge(robot, check, ends, times)
            assert off <= min(1e-4, check.tool.off)
            if check.holds:
                # an arm with a spare joint chooses its joint path, which is what is checked: micrometres from it the
                # rates that keep the tool on the line exactly may have no bound for milliseconds
                fastest = own if robot.n > 6 else max(share, own)
                assert fastest <= 1.0 + 1e-6, (name, share, own)
            if check.verdict == "too fast":
                assert check.violations[0].amount == pytest.approx(max(share, own), rel=0.2)  # far beyond any limit
    return verdicts


@pytest.mark.by_hand_at("ur5e")
@pytest.mark.by_hand_at("panda")
@pytest.mark.slow_at("panda", "ur5e")
@pytest.mark.parametrize("name", ["ur5e", "panda"])
def test_lines_past_singularities_are_not_called_free(name: str) -> None:
    verdicts = hold(name, 3, 1)
    assert verdicts.get("free", 0) < 3


@pytest.mark.by_hand
@pytest.mark.by_hand_at("ur5e", "puma560", "panda", "pa10", "gen3", "ur10e", "ur3e", "ur5", "gp7")
@pytest.mark.parametrize("name", ARMS)
def test_no_line_that_is_called_free_breaks_a_rate_or_leaves_its_line(name: str) -> None:
    assert sum(hold(name, 10, 2).values()) == 10


@pytest.mark.by_hand
@pytest.mark.parametrize("name", ARMS)
def test_no_line_of_a_thousand_that_is_called_free_breaks_a_rate_or_leaves_its_line(name: str) -> None:
    assert sum(hold(name, 100, 3).values()) == 100


@pytest.mark.by_hand
def test_the_line_of_the_issue_is_not_possible_at_the_programmed_speed() -> None:
    """0.2 m that pass the UR5e's wrist at 0.005°: the joint path of rows 0.02 reaches apart left it by 29 mm."""
    robot = open_robot("ur5e")
    middle = pose(robot, [0.3, -1.2, 1.4, -1.0, np.radians(0.005), 0.4])
    ends = np.repeat(middle[None], 2, axis=0)
    half = 0.1 * np.array([0.3, 0.9, 0.2]) / np.linalg.norm([0.3, 0.9, 0.2])
    ends[:, :3, 3] += np.stack([-half, half])
    check = check_poses(robot, ends, [0.0, 2.0])
    assert (check.verdict, check.clear, check.holds) == ("too fast", True, False)
    (one,) = check.violations
    assert (one.what, one.proven, one.joint) == ("rate", True, 4)
    assert one.amount > 300
    assert check.sentence.startswith("Not possible at the programmed speed: ")
    assert f"times the limit of joint 4 at {one.place.time:.4g} s" in check.sentence
    slow = check_poses(robot, ends, [0.0, 2.0 * one.amount * 1.001])
    assert slow.holds
    assert check_poses(robot, ends).holds  # without times nothing is said of rates


@pytest.mark.by_hand
def test_a_tighter_tolerance_puts_more_rows_and_the_bound_is_above_what_is_measured() -> None:
    robot = open_robot("ur5e")
    ends = pose(robot, [[0.3, -1.2, 1.4, -1.0, 1.2, 0.4], [0.9, -1.0, 1.2, -1.2, 1.0, 0.1]])
    coarse, fine = (check_poses(robot, ends, start=[0.3, -1.2, 1.4, -1.0, 1.2, 0.4], tip_tolerance=size,
                                turn_tolerance=size) for size in (1e-3, 1e-5))  # fmt: skip
    assert fine.rows > 5 * coarse.rows
    for check, most in ((coarse, 1e-3), (fine, 1e-5)):
        assert max(check.tool.off, check.tool.turned) <= most
        assert (check.options.tip_tolerance, check.verdict) == (most, "free")


@pytest.mark.slow
def test_a_branch_does_not_pass_the_singularity_at_which_it_ends() -> None:
    """A line of a Gen3 that folds back beside its stretched elbow, after looking for a way on there."""
    arm = open_robot("gen3")
    middle = pose(arm, [0.229314, 0.765568, 0.133878, -0.001396, 0.568332, 0.630965, -0.069957])
    ends = np.stack([middle, middle])
    ends[:, :3, 3] += np.outer([-0.1, 0.1], [-0.204708, -0.616265, 0.760468])
    start = [0.160997, 1.155873, 0.141679, -0.728974, 0.535117, 0.975682, 0.075454]
    check = check_poses(arm, ends, start=start, branches=False)
    assert check.tool is not None
    assert (check.tool.reason, check.tool.passed, check.verdict) == ("singular", (), "cannot be followed")
    assert "goes on" not in check.summary[0]
