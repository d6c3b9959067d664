"""Lines of the tool exactly through singularities: the branch goes on, folds back, or needs an internal turn first.

The judge of the first test is a continuation by fixed steps of arc length in NumPy, with difference quotients.
"""

from __future__ import annotations

from collections import Counter
from types import SimpleNamespace

import numpy as np
import pytest

from rankdrop.kinematics import pose, task_jacobian
from rankdrop.local.orientation import rotation_vector
from rankdrop.path import mend_path
from rankdrop.path.check import follow as follow_module
from rankdrop.path.check import passing
from rankdrop.path.check.follow import _BranchWalk, follow
from rankdrop.path.check.passing import Departure, StraightMove, departures, internal_turn
from rankdrop.path.check.solution_curve import follow_curve
from rankdrop.path.check.tool_branch import Followed
from rankdrop.path.check.tool_path import check_poses
from rankdrop.poses.inverse import Aim, rotation, solutions
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

TOLERANCE = (1e-4, 1e-4)  # of the tip [m, rad]


def at(home: np.ndarray, along: np.ndarray, s: float) -> np.ndarray:
    """The pose a way s along a screw-free line: straight, with a constant turn."""
    made = home.copy()
    made[:3, 3] += s * along[:3]
    made[:3, :3] = rotation(s * along[None, 3:])[0] @ home[:3, :3]
    return made


def line(robot, q, along, *places: float) -> np.ndarray:
    home = pose(robot, np.array(q, dtype=float)[None])[0]
    return np.array([at(home, np.array(along, dtype=float), s) for s in places])


def continued(robot, home, along, q, start: float, end: float, step: float = 1e-2):
    """("goes on" or "folds back", y) of y = (q, s) by steps of arc length from `start`, until s passes an end."""
    shifts = 1e-6 * np.eye(7)

    def missing(ys):
        now = pose(robot, ys[:, :-1])
        goals = np.array([at(home, along, s) for s in ys[:, -1]])
        return np.hstack([now[:, :3, 3] - goals[:, :3, 3],
                          rotation_vector(now[:, :3, :3] @ goals[:, :3, :3].swapaxes(1, 2))])  # fmt: skip

    def slope(y):
        ends = missing(np.concatenate([y + shifts, y - shifts]))
        return ((ends[:7] - ends[7:]) / 2e-6).T

    y = np.append(q, start)
    way = np.linalg.svd(slope(y))[2][-1]
    way = way * np.sign(way[-1])
    for _ in range(20_000):
        guess = y + step * way
        new = guess
        for _ in range(8):
            off = np.append(missing(new[None])[0], way @ (new - guess))
            if np.linalg.norm(off) < 1e-11:
                break
            new = new - np.linalg.solve(np.vstack([slope(new), way]), off)
        assert np.linalg.norm(new - guess) < 0.3 * step
        way = (new - y) / np.linalg.norm(new - y)
        y = new
        if not start <= y[-1] <= end:
            return ("goes on" if y[-1] > end else "folds back"), y[:-1]
    raise AssertionError("no end")


def singular_near(robot, q, joint: int) -> np.ndarray:
    """q with one joint turned to the first zero of det J."""
    task = resolve_task(None, robot)

    def det(x):
        return np.linalg.det(task_jacobian(robot, np.concatenate([q[:joint], [x], q[joint + 1:]]), task))

    grid = np.linspace(q[joint], q[joint] + np.pi, 200)
    values = np.array([det(x) for x in grid])
    k = int(np.flatnonzero(values[:-1] * values[1:] <= 0.0)[0])
    low, high = grid[k], grid[k + 1]
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if det(low) * det(middle) > 0.0 else (low, middle)
    return np.concatenate([q[:joint], [low], q[joint + 1:]])


def determinant(robot: Robot, q: np.ndarray) -> float:
    return float(np.linalg.det(task_jacobian(robot, q, resolve_task(None, robot))))


def lost_direction(robot: Robot, q: np.ndarray) -> np.ndarray:
    """(6,) unit vector in m and rad, without a share of any motion of the tool at q."""
    task = resolve_task(None, robot)
    lost = np.linalg.svd(task_jacobian(robot, q, task))[0][:, -1]
    lost[:3] /= task.scale(robot)
    return np.asarray(lost / np.linalg.norm(lost))


def way_across(
    robot: Robot, joint: int, near: list[float], along: list[float]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A singular configuration, the motion (6,) that is lost there, and a way (6,) without a share of it."""
    q = singular_near(robot, np.array(near), joint)
    lost = lost_direction(robot, q)
    return q, lost, np.array(along) - (lost @ along) * lost


def followed_across(name: str, joint: int, near: list[float], along: list[float], start: list[float]) -> Followed:
    """A line of 0.08 whose middle is singular, and which has no share along the motion that is lost there."""
    robot = open_robot(name)
    q, _, way = way_across(robot, joint, near, along)
    home = pose(robot, q[None])[0]
    ends = np.array([at(home, way, s) for s in (-0.04, 0.04)])
    return follow(robot, ends, start, limits=False, tolerance=TOLERANCE, through=True)


@pytest.mark.by_hand
@pytest.mark.by_hand_at("irb120", "lrmate200id")
@pytest.mark.parametrize("name", ["irb120", "lrmate200id", "ur5e", "puma560"])
def test_lines_through_singularities_go_on_or_fold_back_as_a_continuation_does(name: str) -> None:
    robot, rng = open_robot(name), np.random.default_rng(3)
    task = resolve_task(None, robot)
    kinds: Counter[str] = Counter()
    for joint in (4, 2, 1):  # wrist, elbow, shoulder
        q = singular_near(robot, rng.uniform(-1.2, 1.2, 6), joint)
        home = pose(robot, q[None])[0]
        along = rng.normal(size=6) * np.array([1, 1, 1, 0.5, 0.5, 0.5])
        along /= np.linalg.norm(along)
        for way in (along, -along):
            ends = np.array([at(home, way, s) for s in (-0.04, 0.04)])
            for start in solutions(robot, task, ends[0], starts=60, seed=0)[:2]:
                kind, last = continued(robot, home, way, start, -0.04, 0.04)
                found = follow(robot, ends, start, limits=False, tolerance=(1e-4, 1e-3), through=True)
                kinds[kind] += 1
                assert found.complete == (kind == "goes on"), (joint, way)
                assert found.folds == (kind == "folds back"), (joint, way)
                kinds["through"] += bool(found.passed)
                if found.complete:
                    apart = np.abs(np.remainder(last - found.q[-1] + np.pi, 2 * np.pi) - np.pi)
                    assert apart.max() < 0.05
    assert kinds["goes on"]
    assert kinds["through"]


def test_where_two_solution_curves_cross_the_joints_go_straight_on() -> None:
    """The shoulder of the UR5e, and a line along no lost motion: the other curve leaves at 25° to the one that arrives.
    """
    robot = open_robot("ur5e")
    q = singular_near(robot, np.radians([-71.844, 61.044, 164.0, -3.297, 46.148, 18.359]), 2)
    along = np.array([0.077, -0.206, 0.967, -0.026, 0.081, 0.093])
    lost = np.linalg.svd(task_jacobian(robot, q, resolve_task(None, robot)))[0][:, -1]
    scale = np.array([resolve_task(None, robot).scale(robot)] * 3 + [1.0] * 3)
    lost = lost / scale
    along -= (lost @ along) / (lost @ lost) * lost
    home = pose(robot, q[None])[0]
    ends = np.array([at(home, along, s) for s in (-0.04, 0.04)])
    start = np.radians([-71.838, 47.457, 160.557, 14.543, 45.856, 18.353])
    found = follow(robot, ends, start, limits=False, tolerance=(1e-4, 1e-3), through=True)
    kind, last = continued(robot, home, along, found.q[0], -0.04, 0.04)
    assert (kind, found.complete, [one.rest for one in found.passed]) == ("goes on", True, [False])
    np.testing.assert_allclose(found.q[-1], last, atol=0.01)  # a step beyond; the other curve is 0.13 away
    turns = np.diff(found.q, axis=0)
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    assert (turns[1:] * turns[:-1]).sum(axis=1).min() > 0.99


@pytest.mark.by_hand_at("2", "3", "4")
@pytest.mark.slow
@pytest.mark.parametrize("rows", [2, 3, 4, 400])
def test_a_wrist_turned_for_the_line_passes_at_any_speed(rows: int) -> None:
    robot = open_robot("lrmate200id")
    poses = line(robot, np.zeros(6), [0, 1, 0, 0, 0, 0], *np.linspace(-0.1, 0.1, rows))
    check = check_poses(robot, poses, np.linspace(0.0, 1.0, rows), start=np.radians([-14, 2, -2, 90, 14, -90]))
    assert check.verdict == "crossing"
    assert check.tool.complete
    (passed,) = check.tool.passed
    assert passed.place == pytest.approx((rows + 1) / 2, abs=1e-4 * rows)
    assert not passed.rest
    assert check.curve.speeds.max() < 0.53  # 2.6 rad/m at 0.2 m/s
    assert check.tool.off <= 1e-4
    assert not check.violations
    assert "goes on through it, at any speed" in check.sentence


@pytest.mark.parametrize(("rows", "end"), [(2, 0.1), (2, 0.001), (400, 0.1)])
def test_rows_next_to_a_crossing_are_left_out_but_those_of_poses(rows: int, end: float) -> None:
    """Next to it rows are ill-conditioned. Poses have rows all the same, 0.4 mm apart and just behind it."""
    robot = open_robot("lrmate200id")
    poses = line(robot, np.zeros(6), [0, 1, 0, 0, 0, 0], *np.linspace(-0.1, end, rows))
    found = follow(robot, poses, np.radians([-14, 2, -2, 90, 14, -90]), tolerance=(1e-4, 1e-3), through=True)
    assert (found.complete, [passed.rest for passed in found.passed]) == (True, [False])
    assert np.isin(np.arange(1, rows + 1), found.place).all()
    between = found.q[found.place != np.floor(found.place)]
    near = np.linalg.norm(between - np.radians([0, 0, 0, 90, 0, -90]), axis=1) < 1e-3
    assert rows == 400 or not near.any()


@pytest.mark.parametrize("before", [0, 20])
def test_a_tool_that_waits_at_a_singularity_goes_on_from_there(before: int) -> None:
    """50 equal poses, in the middle of a line or at its start: they have no direction to go on in."""
    robot = open_robot("lrmate200id")
    places = np.concatenate([np.linspace(-0.1, 0.0, before + 1)[:-1], np.zeros(50), np.linspace(0.0, 0.1, 20)])
    poses = line(robot, np.zeros(6), [0, 1, 0, 0, 0, 0], *places)
    start = np.radians([-14, 2, -2, 90, 14, -90] if before else [0, 0, 0, 90, 0, -90])
    found = follow(robot, poses, start, tolerance=(1e-4, 1e-3), through=True)
    assert found.complete
    assert [(one.place, one.rest) for one in found.passed] == [(before + 51.0, False)]
    np.testing.assert_allclose(pose(robot, found.q[-1]), poses[-1], atol=1e-9)
    waits = found.q[(found.place >= before + 1.0) & (found.place <= before + 50.0)]
    assert np.ptp(waits, axis=0).max() < 1e-9


def test_a_start_that_waits_at_a_singularity_is_turned_before_the_tool_moves() -> None:
    """By 0.7° of joint 4, which is near enough."""
    robot = open_robot("lrmate200id")
    poses = line(robot, np.zeros(6), [0, 1, 0, 0, 0, 0], 0.0, 0.0, 0.0, 0.1)
    found = follow(robot, poses, np.radians([0, 0, 0, 89.3, 0, -89.3]), tolerance=(1e-4, 1e-3), through=True)
    assert found.complete
    np.testing.assert_allclose(np.degrees(found.q[0]), [0, 0, 0, 90, 0, -90], atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(("degrees", "straight"), [(1e-3, True), (0.0688833, False)])
def test_a_line_that_misses_a_wrist_goes_on_behind_it(degrees: float, *, straight: bool) -> None:
    """Of a PUMA, by some 1e-7 rad. Exactly followed, joint 4 turns half around at rest, and the determinant keeps its
    sign; where a row clear of the singularity is straight behind it, the joints go straight on within the tolerance.
    """
    robot = open_robot("puma560")
    q = np.radians([-2.285303, 25.054618, 9.727722, 106.948241, degrees, -4.826506])
    poses = line(robot, q, [-0.234686, -0.427842, -0.872854, 0, 0, 0], 0.0, -0.1, 0.1)
    back = follow(robot, poses[:2], q, limits=False)
    found = follow(robot, poses[1:], back.last, limits=False, tolerance=(1e-4, 1e-3), through=True)
    assert (found.complete, [passed.rest for passed in found.passed]) == (True, [not straight])
    kept = np.sign(determinant(robot, found.last)) == np.sign(determinant(robot, back.last))
    assert kept != straight
    assert abs(found.q[-1, 3] - found.q[0, 3]) == pytest.approx(0.0 if straight else np.pi, abs=0.3)


@pytest.mark.slow
def test_a_start_at_the_singularity_says_which_turn_comes_first() -> None:
    robot = open_robot("lrmate200id")
    poses = line(robot, np.zeros(6), [0, 1, 0, 0, 0, 0], 0.0, 0.1)
    check = check_poses(robot, poses, start=np.zeros(6))
    assert not check.holds
    assert check.sentence.startswith("Cannot be followed beyond pose 1 of 2 without an internal turn")
    turn = check.tool.turn
    assert check.tool.reason == "turn"
    np.testing.assert_allclose(np.abs(np.degrees(turn.to)), [0, 0, 0, 90, 0, 90], atol=1e-6)
    np.testing.assert_allclose(pose(robot, turn.to[None]), poses[:1], atol=1e-11)
    assert turn.rest_complete
    assert check_poses(robot, poses, start=turn.to).tool.complete
    assert "turn joint 4 from 0° to" in check.sentence
    assert "after it the path can be followed to its end" in check.sentence
    notes = " ".join(mend_path(check).notes)
    assert "along the whole path" in notes or "null-space" not in notes


@pytest.mark.slow
def test_a_corner_at_a_singular_waypoint_needs_the_turn_there() -> None:
    robot = open_robot("lrmate200id")
    ahead = line(robot, np.zeros(6), [0, 1, 0, 0, 0, 0], -0.1, 0.0)
    side = line(robot, np.zeros(6), [0, 0, -1, 0, 0, 0], 0.1)
    start = np.radians([-14, 2, -2, 90, 14, -90])
    check = check_poses(robot, np.concatenate([ahead, side]), start=np.array(
        follow(robot, line(robot, np.zeros(6), [0, 1, 0, 0, 0, 0], -0.1), start).q[0]))  # fmt: skip
    assert check.tool.reason == "turn"
    assert check.tool.turn.place == 2.0
    assert check.tool.reached == pytest.approx(2.0)
    assert check.tool.turn.rest_complete
    assert abs(np.degrees(check.tool.turn.to - check.tool.turn.q)[3]) == pytest.approx(90.0, abs=1e-4)


@pytest.mark.slow
def test_a_start_that_is_not_asked_for_is_turned_already() -> None:
    robot = open_robot("lrmate200id")
    check = check_poses(robot, line(robot, np.zeros(6), [0, 1, 0, 0, 0, 0], 0.0, 0.1))
    assert check.tool.complete


@pytest.mark.parametrize(("turned", "place", "rest"), [(25.0, 0.5, True), (25.0, 1.0, False), (5.0, 0.5, False)])
def test_a_corner_of_the_joints_within_a_straight_move_needs_a_rest(turned: float, place: float, rest: bool) -> None:
    """At a pose the file may turn a corner; within a move, and by more than 14°, the arm has to stop for one."""
    made = SimpleNamespace(now=np.zeros(2), place=place, direction=lambda joints: np.array([1.0, 0.0]))
    walk = SimpleNamespace(aim=SimpleNamespace(joints=np.ones(2)))
    angle = np.radians(turned)
    corner = Departure(place, np.array([np.cos(angle), np.sin(angle)]), False)
    back = Departure(place, np.array([-1.0, 0.1]), False)
    first, last = _BranchWalk._sort_by_turn(walk, made, [back, corner])
    assert (first.q is corner.q, first.rest, last.q is back.q) == (True, rest, True)


def test_a_line_across_a_self_motion_stays_on_its_own_curve() -> None:
    """The shoulder of the UR5e: joint 4 turns by 370 rad/m where the tool could stand still and turn it as well."""
    found = followed_across(
        "ur5e", 1, [0.298, 1.931, -1.065, 0.924, -0.045, -0.877], [0.618, 0.19, -0.676, 0.196, -0.102, -0.276],
        [-0.1018, 2.02, -0.8274, 2.0769, 0.4039, -2.3419],
    )  # fmt: skip
    assert (found.complete, [passed.rest for passed in found.passed]) == (True, [False])
    assert found.passed[0].place == pytest.approx(1.5, abs=1e-5)
    np.testing.assert_allclose(found.q[-1], [0.698, 2.247, -1.486, 5.431, 0.423, -5.270], atol=1e-3)


@pytest.mark.parametrize(("name", "near", "along", "start", "reached"), [
    ("lrmate200id", [0.5, 1.201, 1.398, -1.17, 3.132, 0.252], [0.568, -0.562, -0.565, 0.086, -0.017, -0.185],
     [0.5466, 1.1593, 1.3865, -2.2772, 3.1914, -0.866], 0.0102066),
    ("ur10e", [-0.682, 0.803, 1.379, 0.017, -0.01, 0.637], [0.089, -0.072, 0.463, 0.28, 0.114, -0.825],
     [-0.7944, 0.7232, 1.7976, -2.4795, -0.1455, 2.8056], 0.00090976),
])  # fmt: skip
def test_a_line_folds_back_after_the_crossing_or_before_it(
    name: str, near: list[float], along: list[float], start: list[float], reached: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What folds back is not followed again: that would add a row next to the last one."""
    joint, parts = 4, []
    monkeypatch.setattr(follow_module, "follow_curve", lambda *given: parts.append(follow_curve(*given)) or parts[-1])
    found = followed_across(name, joint, near, along, start)
    assert [part.folds for part in parts].index(True) == len(parts) - 1
    assert (found.complete, found.folds, found.reason) == (False, True, "singular")
    assert -0.04 + 0.08 * (found.reached - 1.0) == pytest.approx(reached, abs=2e-6)
    assert not any(passed.rest for passed in found.passed)


@pytest.mark.parametrize("degrees", [1e-3, 1e-2, 0.0688833])
def test_two_curves_that_pass_closely_are_no_crossing(degrees: float) -> None:
    """A PUMA misses its wrist by some 1e-7 rad; from 0.03 rad before, the first steps of the curve are long."""
    robot = open_robot("puma560")
    q = np.radians([-2.285303, 25.054618, 9.727722, 106.948241, degrees, -4.826506])
    poses = line(robot, q, [-0.234686, -0.427842, -0.872854, 0, 0, 0], 0.0, -0.02, 0.1)
    start = follow(robot, poses[:2], q, limits=False).last
    move = StraightMove(Aim(robot, resolve_task(None, robot)), poses[1:], 0.0)
    move.seen_from(start)
    part = follow_curve(move, start, None)
    assert part is not None
    sides = {np.sign(determinant(robot, row)) for row in part.q}
    assert sides == {np.sign(determinant(robot, start))}
    assert all(crossing.rest for crossing in part.crossings)


def test_a_branch_whose_curve_is_not_known_ends_before_the_singularity(monkeypatch: pytest.MonkeyPatch) -> None:
    """The local geometry of a singular configuration is none of one that is 1e-5 before it."""
    robot = open_robot("puma560")
    q = np.radians([-2.285303, 25.054618, 9.727722, 106.948241, 1e-3, -4.826506])
    poses = line(robot, q, [-0.234686, -0.427842, -0.872854, 0, 0, 0], 0.0, -0.02, 0.1)
    start = follow(robot, poses[:2], q, limits=False).last
    monkeypatch.setattr(follow_module, "follow_curve", lambda *given: None)
    found = follow(robot, poses[1:], start, limits=False, tolerance=TOLERANCE, through=True)
    assert (found.complete, found.reason, found.passed) == (False, "stuck", ())
    assert 1.0 < found.reached < 1.0 + 1.0 / 6.0
    assert 1e-6 < found.sigma < 1.1e-6


def test_a_turn_next_to_corank_two_is_found() -> None:
    """A KR 6 whose wrist is stretched, with joint 4 near zero: the motion that is lost turns by 90° within 0.3° of it.
    """
    robot = open_robot("kr6r900")
    q = np.array([-1.16557, 0.1234, 0.08981, 0.81043, np.pi, -0.86664])
    along = [0.9181, 0.38227, -0.10468, 0.0, 0.0, 0.0]
    found = follow(robot, line(robot, q, along, 0.0, 0.04), q, limits=False, tolerance=TOLERANCE, through=True)
    assert found.reason == "turn"
    turn = found.turn.to
    assert turn[3] == pytest.approx(-0.003, abs=3e-4)
    assert abs(lost_direction(robot, turn) @ along) < 1e-9
    np.testing.assert_allclose(pose(robot, turn[None]), line(robot, q, along, 0.0), atol=1e-11)


def test_a_self_motion_of_unknown_lost_direction_is_not_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Next to corank 2 the lost direction is known nowhere but at the configuration itself."""
    robot, q = open_robot("lrmate200id"), np.zeros(6)
    aim, poses = Aim(robot, resolve_task(None, robot)), line(robot, q, [0, 1, 0, 0, 0, 0], 0.0, 0.1)
    turned = internal_turn(aim, poses, 0.0, q, limits=False)
    assert turned is not None
    assert abs(np.degrees(turned[3])) == pytest.approx(90.0, abs=1e-6)
    monkeypatch.setattr(passing, "_keeps_lost_direction", lambda aim, new, u: np.abs(new - q).max() < 1e-15)
    assert internal_turn(aim, poses, 0.0, q, limits=False) is None


def test_a_branch_ends_where_its_curve_leaves_the_joint_limits() -> None:
    """A line past the wrist of a KR 6 by 2e-5 rad: joint 4 turns to its limit at rest."""
    robot = open_robot("kr6r900")
    q = np.array([-0.13947310307939287, -1.3443310785425726, 1.6198181832201315, 0.20645006437293298, 2.25e-5,
                  -0.12969866046623163])  # fmt: skip
    start = [-0.08485148579282296, -1.3174626306785941, 1.8205332036668889, 0.2294501583446972, -0.23306827023547855,
             -0.13182930933983059]  # fmt: skip
    way = [0.1360287897407231, 0.3079085087800128, 0.9416413959584311, 0, 0, 0]
    found = follow(robot, line(robot, q, way, -0.1, 0.1), start, tolerance=TOLERANCE, through=True)
    assert (found.complete, found.reason, found.joint) == (False, "limit", 4)
    assert found.last[3] == pytest.approx(robot.upper[3], abs=1e-2)


@pytest.mark.parametrize(("name", "joint", "near", "along", "ways"), [
    ("ur5e", 1, [0.298, 1.931, -1.065, 0.924, -0.045, -0.877], [0.618, 0.19, -0.676, 0.196, -0.102, -0.276], 2),
    ("lrmate200id", 4, [0.5, 1.201, 1.398, -1.17, 3.132, 0.252], [0.568, -0.562, -0.565, 0.086, -0.017, -0.185], 1),
])  # fmt: skip
def test_every_curve_that_leaves_a_crossing_is_found(
    name: str, joint: int, near: list[float], along: list[float], ways: int
) -> None:
    """Flattest first, by reference kinematics; at the wrist the other curve is the self-motion, which is no way on."""
    robot = open_robot(name)
    q, lost, way = way_across(robot, joint, near, along)
    home = pose(robot, q[None])[0]
    ends = np.array([at(home, way, s) for s in (-0.04, 0.04)])
    found, folds = departures(Aim(robot, resolve_task(None, robot)), ends, 0.5, q)
    assert (len(found), folds) == (ways, False)
    for departure in found:
        assert not departure.rest
        np.testing.assert_allclose(pose(robot, departure.q[None])[0], at(home, way, 0.08 * departure.place - 0.04),
                                   atol=1e-9)  # fmt: skip
    turned = [float(np.linalg.norm(departure.q - q) / (departure.place - 0.5)) for departure in found]
    assert turned == sorted(turned)
    needed = np.array([at(home, way + 1e-4 * lost, s) for s in (-0.04, 0.04)])
    move = StraightMove(Aim(robot, resolve_task(None, robot)), needed, 0.5)
    assert not passing._crossing_departures(move, q, move.seen_from(q), move.room)  # no two curves cross there


def test_the_flattest_curve_comes_first_whatever_the_order_of_zeros(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = open_robot("ur5e")
    q = singular_near(robot, np.array([0.298, 1.931, -1.065, 0.924, -0.045, -0.877]), 1)
    lost = lost_direction(robot, q)
    way = np.array([0.618, 0.19, -0.676, 0.196, -0.102, -0.276])
    way -= (lost @ way) * lost
    home = pose(robot, q[None])[0]
    aim, ends = Aim(robot, resolve_task(None, robot)), np.array([at(home, way, s) for s in (-0.04, 0.04)])
    first = [departure.place for departure in departures(aim, ends, 0.5, q)[0]]
    zeros = passing._zeros
    monkeypatch.setattr(passing, "_zeros", lambda *given: zeros(*given)[::-1])
    assert [departure.place for departure in departures(aim, ends, 0.5, q)[0]] == first


@pytest.mark.parametrize(("form", "count"), [
    ([[1, 0], [0, 1]], 0), ([[-1, 0], [0, -2]], 0), ([[1, 0], [0, 0]], 0), ([[1, 0], [0, -4]], 2),
    ([[0, 1], [1, 0]], 2), ([[1, 0], [0, -1e-9]], 0),
])  # fmt: skip
def test_zeros_of_a_quadratic_form(form: list[list[float]], count: int) -> None:
    """None where rounding would decide."""
    plane = np.array([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0]])
    found = passing._zeros(np.array(form, dtype=float), plane)
    assert len(found) == count
    for way in found:
        x = plane @ way
        assert x @ np.array(form) @ x == pytest.approx(0.0, abs=1e-12)
        assert np.linalg.norm(way) == pytest.approx(1.0)
        assert way[-1] >= 0.0
