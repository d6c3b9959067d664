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
from rankdrop.path.check.tool_path import check_poses
from rankdrop.path.mend import pose_detours
from rankdrop.path.mend.detours import Hindrance, lost_motions
from rankdrop.path.mend.pose_detours import Blocked, PoseDetourer
from rankdrop.path.mend.remedies import LOCAL, mend_path
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
