"""How remedies are worded, and why there are none."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from path.planar_detours import CLEARANCE, planar

from rankdrop.kinematics import pose
from rankdrop.path.check.tool_path import check_poses
from rankdrop.path.mend.detours import Hindrance
from rankdrop.path.mend.mend import mend_path
from rankdrop.path.mend.pose_detours import Blocked, PoseDetourer
from rankdrop.path.mend.record import LOCAL
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot
from rankdrop.text.remedies import local_lines, remedy_note


@pytest.mark.slow
def test_a_file_that_is_not_followed_to_its_end_is_not_mended_by_other_kinds() -> None:
    """They would mend the part up to there, and write a file cut short."""
    _, _, check = planar()
    assert check.tool is not None
    assert not check.tool.complete
    found = mend_path(check, kinds=("null-space", "flip", "bump", "retime"))
    assert found.remedies == ()
    first, second = found.notes
    assert first.startswith("null-space: there is no joint motion")
    assert second == "flip: 1 tried: 1 end at a singularity"
    assert remedy_note("range", (2, float(np.radians(13.0)), check.robot)) == (
        "joint limits: with 13° more range of joint 2 the poses are followed to the end")  # fmt: skip


def test_how_far_a_joint_would_go_beyond_its_limit_is_measured_between_the_poses() -> None:
    """A line of two poses in front of an IRB 2400: joint 3 is inside its range at the ends, 5.8° beyond between."""
    arm = open_robot("irb2400")
    ends = np.repeat(np.diag([1.0, -1.0, -1.0, 1.0])[None], 2, axis=0)
    ends[:, :3, 3] = [[0.4, -0.3, 0.3], [0.4, 0.3, 0.3]]
    check = check_poses(arm, ends, [0.0, 4.0])
    assert check.tool is not None
    assert (check.tool.reason, check.tool.joint) == ("limit", 3)
    blocked = PoseDetourer(check, 0.03, CLEARANCE).find_windows(lambda done, count: None)
    assert isinstance(blocked, Blocked)
    assert (blocked.hindrance, blocked.joint) == (Hindrance.RANGE, 3)
    q, third = check.tool.q[0], []
    for y in np.linspace(-0.3, 0.3, 601):  # Newton's method in small steps, with the Jacobian by finite differences
        for _ in range(4):
            now, wanted = pose(arm, q), ends[0].copy()
            wanted[1, 3] = y
            columns = [(_error(pose(arm, q + step), now) / 1e-6) for step in 1e-6 * np.eye(6)]
            q = q + np.linalg.solve(np.transpose(columns), _error(wanted, now))
        third.append(q[2])
    assert blocked.beyond == pytest.approx(max(third) - arm.upper[2], abs=np.radians(0.1))
    assert "where no singularity is near" in " ".join(local_lines(mend_path(check, kinds=LOCAL)))


def _error(wanted: Array, now: Array) -> Array:
    """(6,) from one pose to another: the way, and the rotation vector of a small turn."""
    turn = wanted[:3, :3] @ now[:3, :3].T
    skew = (turn - turn.T) / 2.0
    return np.array([*(wanted[:3, 3] - now[:3, 3]), skew[2, 1], skew[0, 2], skew[1, 0]])


@pytest.mark.parametrize(("retimed", "lines"), [(True, 2), (False, 1)])
def test_a_remedy_that_keeps_the_times_is_named_beside_one_that_does_not(retimed: bool, lines: int) -> None:
    robot = open_robot("ur5e")

    def remedy(*, retimed: bool) -> SimpleNamespace:
        check = SimpleNamespace(robot=robot, clear=True)
        return SimpleNamespace(kind="blend", words="a corner is cut", changes=(), turns=(), retimed=retimed,
                               deviation=(0.0, 0.0), check=check)  # fmt: skip

    best = remedy(retimed=retimed)
    said = local_lines(SimpleNamespace(best=best, remedies=(best, remedy(retimed=False)), notes=()))
    assert len(said) == lines
    assert said[-1].startswith("Or in the same time: a corner is cut") == retimed
