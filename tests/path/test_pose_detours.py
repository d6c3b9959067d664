"""Tool poses that lead through a singularity, or out of reach beside it: the tool led around it.

Checked by forward kinematics of the mended rows, σ along it, and the poses outside the windows.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from path.planar_detours import CLEARANCE, checked, planar
from rankdrop.kinematics import pose
from rankdrop.local.block import singular_values
from rankdrop.path.check.follow import follow
from rankdrop.path.check.record import PathCheck
from rankdrop.path.check.tool_path import check_poses
from rankdrop.path.mend import local_remedies, pose_detours
from rankdrop.path.mend.detours import Hindrance, lost_motions
from rankdrop.path.mend.mend import mend_path
from rankdrop.path.mend.pose_detours import Blocked, PoseDetourer
from rankdrop.path.mend.record import LOCAL, Remedy
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot


@pytest.mark.slow
def test_no_tool_motion_of_the_same_size_goes_farther_along_the_lost_direction() -> None:
    """At wrists of the KUKA KR 6: a size is |v|/ℓ + |ω|, of which the motion along û needs up to 1.2 times more."""
    arm, rng = open_robot("kr6r900"), np.random.default_rng(3)
    q = np.radians([[0, -80, 90, 20, 20, 0], [1, -80, 90, 20, 20, 0]])
    work = PoseDetourer(check_poses(arm, pose(arm, q), start=q[0], branches=False), 0.05, CLEARANCE)
    gains = []
    for _ in range(20):
        q = np.append(rng.uniform(-1.0, 1.0, 4), [0.0, 0.3])
        lost = np.linalg.svd(work.aim.jacobian(q[None])[0])[0][:, -1]
        other = rng.normal(size=(500, 6)) * np.repeat(10.0 ** rng.uniform(-2.0, 2.0, (500, 2)), 3, axis=1)
        other = np.concatenate([other, lost[None]])
        other /= (np.linalg.norm(other[:, :3], axis=1) + np.linalg.norm(other[:, 3:], axis=1))[:, None]
        way = lost_motions(work.aim, work.tool.rank, q)[0]
        assert np.linalg.norm(way[:3]) + np.linalg.norm(way[3:]) == pytest.approx(1.0)
        assert lost @ way >= (other @ lost).max() - 1e-12
        gains.append(lost @ way / (other[-1] @ lost))
    assert max(gains) > 1.1


@pytest.mark.by_hand_at("kr6r900")
@pytest.mark.slow
@pytest.mark.parametrize("name", ["kr6r900", "pa10"])
def test_the_tool_is_led_around_and_all_other_poses_stay(name: str) -> None:
    """Held against the poses, interpolated by SciPy: they are reached outside the window, and left inside by no more
    than is told; σ stays above what the clearance leaves.
    """
    poses, t, check = checked(name)
    assert not check.clear
    work = PoseDetourer(check, float(np.radians(2.0)), CLEARANCE)
    windows = work.find_windows(lambda done, count: None)
    assert not isinstance(windows, Blocked)
    (window,) = windows
    made = work.trajectory()
    now = pose(check.robot, made.q)
    where = np.stack([np.interp(made.times, t, column) for column in poses[:, :3, 3].T], axis=1)
    turn = Slerp(t, Rotation.from_matrix(poses[:, :3, :3]))(made.times)
    away = np.linalg.norm(now[:, :3, 3] - where, axis=1)
    turned = (Rotation.from_matrix(now[:, :3, :3]) * turn.inv()).magnitude()
    row = made.times / (t[1] - t[0])
    outside = (row < window.low - 1e-9) | (row > window.high + 1e-9)
    assert outside.sum() > 20
    assert away[outside].max() < 1e-9
    assert turned[outside].max() < 1e-9
    assert 1e-6 < away.max() < 1.01 * window.off[0] < 0.02
    assert turned.max() < 1.01 * window.off[1] + 1e-9 < np.radians(2.0)
    assert (made.times[0], made.times[-1]) == (t[0], t[-1])
    assert singular_values(check.robot, made.q, check.task)[:, 5].min() > 1e-4
    assert np.abs(np.diff(made.q, axis=0)).max() < 0.3
    best = mend_path(check, kinds=LOCAL).best
    assert best is not None
    assert (best.kind, best.check.verdict, len(best.changes)) == ("detour", "free", 1)


@pytest.mark.slow
def test_a_planar_arm_stays_inside_its_reach() -> None:
    """Led inside, by as much as the poses are beyond it at least."""
    poses, t, check = planar()
    (one,) = mend_path(check, kinds=("detour",)).remedies
    assert (one.kind, one.check.verdict) == ("detour", "free")
    assert 2e-4 < one.deviation[0] < 2e-3
    (change,) = one.changes
    now = pose(check.robot, one.trajectory.q)
    early, late = t < change.start.time - 1e-9, t > change.end.time + 1e-9
    assert early.any()
    assert late.any()
    for row in np.flatnonzero(early | late):
        assert np.abs(now - poses[row]).max(axis=(1, 2)).min() < 1e-9
    assert np.abs(np.sin(one.trajectory.q[:, 1])).min() > 1e-3


def test_a_joint_that_stays_inside_its_limits_needs_no_wider_range(monkeypatch: pytest.MonkeyPatch) -> None:
    """Followed without limits the branch may lead elsewhere: a range of less than nothing was advised."""
    arm = open_robot("ur5")
    start = np.array([0.3, -1.2, 1.4, -1.0, 1.2, 0.4])
    poses = pose(arm, [start, start + 0.1])
    work = PoseDetourer(check_poses(arm, poses, start=start, branches=False), 0.03, CLEARANCE)
    blocked = Blocked(0.5, Hindrance.RANGE)
    assert work._with_excess(blocked, np.array([0.0, 1.0]), start) is blocked
    wound = replace(follow(arm, poses, start), q=np.stack([start, start + 7.0 * np.eye(6)[5]]))
    monkeypatch.setattr(pose_detours, "follow", lambda *given, **options: wound)
    assert work._with_excess(blocked, np.array([0.0, 1.0]), start).joint == 6


def _line(name: str, first: tuple[float, ...], last: tuple[float, ...]) -> tuple[Array, Array, PathCheck]:
    """60 poses of a joint path that is straight between two configurations [deg], within 6 s; rates have no limit."""
    given, t = open_robot(name), np.linspace(0.0, 6.0, 60)
    arm = replace(given, joints=tuple(replace(joint, velocity=np.inf) for joint in given.joints))
    start, end = np.radians(first), np.radians(last)
    q = start + (t / t[-1])[:, None] * (end - start)
    poses = pose(arm, q)
    return poses, t, check_poses(arm, poses, t, start=q[0], branches=False)


def _keeps_to(poses: Array, t: Array, remedy: Remedy) -> None:
    """Free, the tool where it was outside the changes, near it within them, and the joints clear of singularities."""
    made = remedy.trajectory
    assert remedy.check.verdict == "free"
    now = pose(remedy.check.robot, made.q)
    straight = Slerp(t, Rotation.from_matrix(poses[:, :3, :3]))(made.times)
    where = np.stack([np.interp(made.times, t, column) for column in poses[:, :3, 3].T], axis=1)
    away = np.linalg.norm(now[:, :3, 3] - where, axis=1)
    turned = (Rotation.from_matrix(now[:, :3, :3]) * straight.inv()).magnitude()
    outside = np.ones(len(made.times), dtype=np.bool_)
    for change in remedy.changes:
        outside &= (made.times < change.start.time - 1e-9) | (made.times > change.end.time + 1e-9)
    assert max(away[outside].max(), turned[outside].max()) < 1e-8
    assert away.max() < 1.01 * remedy.off[0] + 1e-9
    assert turned.max() < np.radians(2.0)
    assert singular_values(remedy.check.robot, made.q, remedy.check.task)[:, 5].min() > 1e-4


def test_an_elbow_that_is_straight_between_two_poses_is_led_around() -> None:
    """PA-10: both poses beside the crossing have room, and nothing was found to lead around."""
    poses, t, check = _line(
        "pa10", (-78.17, -150.44, 1.75, 9.21, -130.78, 114.44, -117.33),
        (-43.87, -147.67, -6.48, -9.21, -97.14, 132.62, -159.36),
    )  # fmt: skip
    (one,) = mend_path(check, kinds=("detour",)).remedies
    _keeps_to(poses, t, one)
    assert 1e-6 < one.off[0] < 1e-4


def test_poses_that_are_out_of_reach_for_a_second_are_led_inside() -> None:
    """iiwa 7: the tool turned aside by half a degree is out of reach for a fourth of the path."""
    poses, t, before = _line(
        "iiwa7", (13.0, 65.26, 82.41, 13.53, -167.48, -65.01, -117.41),
        (24.17, 46.36, 139.23, -13.53, -80.11, -104.86, -123.81),
    )  # fmt: skip
    poses[:, :3, 3] += 3e-4 * np.exp(-(((t - 3.0) / 0.8) ** 2))[:, None] * poses[30, :3, 3] / 0.7
    start = np.radians((13.0, 65.26, 82.41, 13.53, -167.48, -65.01, -117.41))
    check = check_poses(before.robot, poses, t, start=start, branches=False)
    assert check.tool is not None
    assert not check.tool.complete
    (one,) = mend_path(check, kinds=("detour",)).remedies
    _keeps_to(poses, t, one)
    (change,) = one.changes
    assert change.end.time - change.start.time > 0.8


def test_poses_that_end_at_a_limit_are_followed_on_another_branch() -> None:
    """LR Mate: joint 4 would have to turn to 215°, beyond its limit at 190°; with the wrist flipped it turns to 35°."""
    poses, t, check = _line("lrmate200id", (10, 20, 10, 150, 60, 10), (20, 30, 20, 215, 70, 20))
    assert check.tool is not None
    assert (check.tool.reason, check.tool.joint) == ("limit", 4)
    (one,) = mend_path(check, kinds=("flip",)).remedies
    _keeps_to(poses, t, one)
    assert one.trajectory.q[-1, 3] == pytest.approx(np.radians(35.0), abs=1e-6)


@pytest.mark.slow
def test_another_branch_is_led_around_a_singularity_of_its_own() -> None:
    """IRB 120: joint 1 reaches its limit while the tool passes by axis 1; bent over backwards it stays within it."""
    poses, t, check = _line(
        "irb120", (-47.69, -20.62, -68.46, -100.37, 59.6, 73.67), (-2.45, 11.59, -68.55, -95.38, 30.64, 88.49)
    )  # fmt: skip
    mending = mend_path(check, kinds=("detour", "flip"))
    (one,) = mending.remedies
    assert one.how == ("detour elsewhere", 1)
    assert [name for name, *_ in one.parameters] == ["start"]
    assert "another branch" in one.words
    _keeps_to(poses, t, one)
    assert np.abs(one.trajectory.q[0] - np.radians([-47.69, -20.62, -68.46, -100.37, 59.6, 73.67])).max() > 0.5
    failed = [fact for kind, fact in mending.failures if kind == "detour"]
    assert failed[0][1][0][3] == (1,)
    assert any("joint 1 reaches its limit" in note for note in mending.notes)


@pytest.mark.slow
def test_the_detours_of_all_branches_share_a_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of poses that pass a singularity many times on every branch, detours were looked for during 20 s and more."""
    _, _, check = _line(
        "irb120", (-47.69, -20.62, -68.46, -100.37, 59.6, 73.67), (-2.45, 11.59, -68.55, -95.38, 30.64, 88.49)
    )  # fmt: skip
    monkeypatch.setattr(local_remedies, "_ELSEWHERE", 0)
    mending = mend_path(check, kinds=("detour", "flip"))
    assert mending.remedies == ()
    ((followed, count, searched),) = [fact for kind, fact in mending.failures if kind == "other branches"]
    assert (followed, searched) == (0, 0)
    assert mending.notes[-1] == (
        f"detour on other branches: 0 of {count} were followed until the budget of 0 detours was spent"
    )


@pytest.mark.slow
@pytest.mark.parametrize(("y", "last"), [(0.0, 0.8), (0.002, 0.8), (0.002, 0.7)])
def test_a_wider_range_is_named_where_the_poses_are_followed_to_their_end_with_it(y: float, last: float) -> None:
    """IRB 120, tool level, up past its wrist: 20° more of joint 4 were named though 0.8 m is out of reach."""
    arm = open_robot("irb120")
    poses = np.tile(np.eye(4), (60, 1, 1))
    poses[:, :3, :3] = Rotation.from_euler("y", np.pi / 2.0).as_matrix()
    poses[:, 0, 3], poses[:, 1, 3], poses[:, 2, 3] = 0.45, y, np.linspace(0.35, last, 60)
    check = check_poses(arm, poses, np.linspace(0.0, 3.0, 60), branches=False)
    ranges = [fact for kind, fact in mend_path(check, kinds=("detour",)).failures if kind == "range"]
    assert len(ranges) == (last == 0.7)
    for joint, beyond, _ in ranges:
        limits = arm.joints[joint - 1]
        wider = replace(limits, lower=limits.lower - beyond - 1e-6, upper=limits.upper + beyond + 1e-6)
        free = replace(arm, joints=(*arm.joints[: joint - 1], wider, *arm.joints[joint:]))
        moved = PoseDetourer(check_poses(free, poses, branches=False), float(np.radians(2.0)), CLEARANCE)
        assert not isinstance(moved.find_windows(lambda done, count: None), Blocked)
