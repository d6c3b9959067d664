"""Solutions of a pose from random starts: isolated ones, curves and surfaces along which the tool stands still."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference.kinematics import pose as reference_pose

from rankdrop.kinematics import pose
from rankdrop.poses.branches import inverse
from rankdrop.poses.inverse import Aim
from rankdrop.poses.solution_search import SolutionSearch, joints_beyond
from rankdrop.questions import InverseOptions
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


@pytest.mark.slow
def test_a_redundant_arm_has_curves() -> None:
    robot = open_robot("iiwa14")
    found = inverse(robot, [0.5, 0.1, 0.4, np.pi, 0.0, 0.3])
    assert not found.branches
    assert found.continua
    assert len(found.continua) <= 16
    assert any(0.0 < one.inside < 1.0 for one in found.continua), "limits cut self-motions"
    for one in found.continua:
        within = bool(((one.q >= robot.lower) & (one.q <= robot.upper)).all())
        assert within == (one.inside > 0.0) == (one.beyond == ()), "it is shown inside the limits where it can be"
    for one in found.continua:
        assert one.dimension == 1
        assert not one.singular
        np.testing.assert_allclose(pose(robot, one.q), found.pose, atol=1e-9)
    assert "infinitely many solutions" in found.sentence
    assert "self-motion curve" in found.sentence


@pytest.mark.by_hand
@pytest.mark.slow_at("ur5")
@pytest.mark.parametrize(("name", "q", "joints"), [
    ("puma560", [0.3, 0.5, 0.4, 0.2, 0.0, 0.6], (4, 6)), ("ur5", [0.1, -1.0, 0.7, 0.3, 0.0, 0.2], (2, 3, 4, 6)),
])  # fmt: skip
def test_a_wrist_singularity_is_one_curve_beside_isolated_solutions(name: str, q: list[float], joints: tuple) -> None:
    robot = open_robot(name)
    found = inverse(robot, pose(robot, q), starts=600)
    singular = [one for one in found.continua if one.singular]
    assert 1 <= len(singular) == len(found.continua) <= 2
    for one in singular:
        assert one.dimension == 1
        moving = np.flatnonzero(one.highest - one.lowest > 1e-3) + 1
        assert tuple(moving) == joints
    assert all(one.verdict != "singular" for one in found.branches)
    assert f"all of {'it' if len(singular) == 1 else 'them'} singular" in found.sentence


@pytest.mark.slow
def test_a_point_of_higher_corank_on_a_self_motion_is_no_isolated_solution() -> None:
    """With the wrist aligned and the wrist centre in the plane of axes 1 and 2 each curve passes points of rank 4."""
    robot = open_robot("stanford")
    found = inverse(robot, pose(robot, [0.0, 0.0, 0.4, 0.3, 0.0, 0.5]))
    assert [one.dimension for one in found.continua] == [1] * len(found.continua)
    assert found.continua
    assert not found.branches


@pytest.mark.parametrize(("name", "place", "task"), [
    ("px150", [0.3, 0.0, 0.2], "position"), ("so101", [0.25, 0.0, 0.15], "position"),
])  # fmt: skip
def test_a_surface_is_shown_inside_the_joint_limits_where_it_has_a_place_there(
    name: str, place: list[float], task: str
) -> None:
    robot = open_robot(name)
    found = inverse(robot, place, task)
    (surface,) = found.continua
    assert surface.dimension == 2
    assert not surface.beyond
    assert (surface.q >= robot.lower).all()
    assert (surface.q <= robot.upper).all()
    np.testing.assert_allclose(pose(robot, surface.q)[:3, 3], place, atol=1e-8)
    assert "It has configurations inside the joint limits" in found.sentence


def test_a_surface_is_moved_inside_narrow_limits() -> None:
    """Chance hits no configuration inside these limits; projections do."""
    free = open_robot("px150")
    inside = np.array([0.05, -0.4, 0.6, 0.5, 0.3])
    robot = replace(free, joints=tuple(
        replace(joint, lower=value - 0.02, upper=value + 0.02) for joint, value in zip(free.joints, inside, strict=True)
    ))  # fmt: skip
    (surface,) = inverse(robot, pose(robot, inside), "position").continua
    assert not surface.beyond
    assert np.abs(surface.q - inside).max() <= 0.02 + 1e-9


def test_an_isolated_singular_solution_is_one() -> None:
    robot = open_robot("planar2r")
    found = inverse(robot, pose(robot, [0.3, 0.0]))
    assert [one.verdict for one in found.branches] == ["singular"]
    np.testing.assert_allclose(found.branches[0].q, [0.3, 0.0], atol=1e-5)
    assert not found.continua


def test_sets_of_more_dimensions_are_not_counted_as_curves() -> None:
    robot = open_robot("pa10")
    found = inverse(robot, pose(robot, [0.0] * 7), starts=400)
    assert [one.dimension for one in found.continua] == [3]
    assert "dimension 3" in found.sentence


def test_solutions_reach_the_pose_and_differ_and_are_all_eight_of_a_puma() -> None:
    robot = open_robot("puma560")
    task = resolve_task(None, robot)
    goal = reference_pose(robot, np.array([0.3, -0.8, 0.5, 0.4, 0.9, -0.6]))
    search = SolutionSearch(Aim(robot, task), task, goal)
    search.run(InverseOptions(starts=300))
    solutions, continua, more = search.isolated_and_curves()
    assert (len(solutions), continua, more) == (8, (), False)
    assert reference_pose(robot, solutions) == pytest.approx(np.broadcast_to(goal, (8, 4, 4)), abs=1e-9)
    assert search.residual(solutions) < 1e-9
    turns = np.exp(1j * solutions)
    apart = np.abs(turns[:, None] - turns).max(axis=2) + 2 * np.eye(8)
    assert apart.min() > 0.1
    assert (search.sigma(solutions) > 1e-3).all()


def test_joints_beyond_their_limits_are_named_with_how_far() -> None:
    robot = open_robot("panda")
    q = (robot.lower + robot.upper) / 2
    assert joints_beyond(robot, q) == ()
    q[[1, 3]] = robot.upper[1] + 0.2, robot.lower[3] - 0.3
    (first, far), (second, farther) = joints_beyond(robot, q)
    assert (first, second) == (2, 4)
    assert (far, farther) == pytest.approx((0.2, 0.3), abs=1e-8)


@pytest.mark.parametrize(("far", "curves"), [(0.15, 2), (0.25, 1), (0.55, 2), (0.8, 1), (1.15, 1)])
def test_self_motions_of_a_planar_arm_are_those_of_its_four_bar_linkage(far: float, curves: int) -> None:
    """Links 0.5, 0.4, 0.3 m and the way to the target: two curves where the shortest and the longest of the four are
    together shorter than the other two (Grashof); else one. Each goes round, its points on the pose and a step apart.
    """
    links = (0.5, 0.4, 0.3)
    robot = from_dh([(length, 0, 0, 0) for length in links], convention="standard")
    task = resolve_task("vx,vy", robot)
    shortest, *middle, longest = sorted((*links, far))
    assert curves == (2 if shortest + longest < sum(middle) else 1)
    goal = np.eye(4)
    goal[0, 3] = far
    search = SolutionSearch(Aim(robot, task), task, goal)
    search.run(InverseOptions(starts=40))
    isolated, continua, more = search.isolated_and_curves()
    assert (len(isolated), len(continua), more) == (0, curves, False)
    for curve in search.curves:
        assert (curve.closed, curve.complete) == (True, True)
        assert np.abs(reference_pose(robot, curve.points)[:, :2, 3] - [far, 0.0]).max() < 1e-9
        steps = np.abs(np.exp(1j * np.roll(curve.points, -1, axis=0)) - np.exp(1j * curve.points))
        assert np.linalg.norm(steps, axis=1).max() < 0.12
    for continuum in continua:
        assert (continuum.dimension, continuum.closed, continuum.singular) == (1, True, False)
