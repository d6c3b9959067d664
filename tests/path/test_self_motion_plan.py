"""Null-space motion planned over whole self-motions, from the same start, past singular sets that the path crosses."""

from __future__ import annotations

import numpy as np
import pytest

import rankdrop
from rankdrop.kinematics import pose
from rankdrop.path.mend.joint_tool_path import tool_path
from rankdrop.path.mend.self_motion_plan import plan_as_run, plan_path
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot

ROWS = 81


def through_the_shoulder() -> Array:
    """A Panda's path through a point of its first family, axes 1 and 3 aligned, that the shortest joint motion goes
    through as well: 0.0035 rad from it.
    """
    first = [0.391578384, 0.151140839, -1.528716280, -1.656719362, 2.240071761, 1.664091082, -2.503999720]
    last = [0.452851150, -0.151140839, -1.654132803, -1.745586987, 2.245277332, 1.570285614, -2.354685380]
    return np.linspace(first, last, ROWS)


@pytest.mark.slow
def test_a_path_through_a_singularity_is_led_around_it_from_the_same_start() -> None:
    robot, q = open_robot("panda"), through_the_shoulder()
    found = rankdrop.check_path(robot, q)
    assert found.verdict in ("crossing", "touching")
    tool = tool_path(robot, found.task, found.curve)
    place, plan, free = plan_path(tool, q[:1], lambda done, count: None, around=False)
    assert len(plan)
    assert place[-1] == ROWS - 1
    assert free > 0.15
    assert tool.room(tool.coarse().follow_branch(q[0]).q).min() < 0.005
    finer, followed = tool.refine_run(plan_as_run(place, plan))
    assert followed.complete
    np.testing.assert_array_equal(followed.q[0], q[0])
    rows = np.flatnonzero(finer.place == np.round(finer.place))
    np.testing.assert_allclose(pose(robot, followed.q[rows]), pose(robot, q), atol=1e-10)
    again = rankdrop.check_path(robot, followed.q)
    assert again.verdict == "free"
    assert ((followed.q >= robot.lower) & (followed.q <= robot.upper)).all()


@pytest.mark.slow
def test_where_all_self_motions_are_singular_there_is_no_plan_and_its_place_is_told() -> None:
    robot = open_robot("pa10")
    q = np.linspace([0.1, 0.6, 0.3, 0.3, 0.4, 0.9, 0.2], [0.2, 0.7, 0.2, -0.3, 0.3, 0.8, 0.3], 61)  # the elbow, θ4 = 0
    found = rankdrop.check_path(robot, q)
    assert found.verdict == "crossing"
    place, plan, _ = plan_path(tool_path(robot, found.task, found.curve), q[:1], lambda done, count: None, around=True)
    assert not len(plan)
    assert 25.0 < place[-1] < 30.0
