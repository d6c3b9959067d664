"""Following a tool path: poses kept to rounding, the branch kept, and the place told where it ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rankdrop.errors import ConfigurationError, TaskError
from rankdrop.kinematics import pose, task_jacobian
from rankdrop.local.block import singular_values
from rankdrop.path.check.follow import follow
from rankdrop.path.check.tool_line import poses_between
from rankdrop.path.check.tool_path import check_poses
from rankdrop.poses.inverse import Aim, rotation
from rankdrop.robot.open import open_robot
from rankdrop.task import Frame, Task, resolve_task
from rankdrop.units import scale_lengths

ARMS = ("ur5", "puma560", "stanford", "panda", "planar3r", "scara")


def smooth(robot, rng, rows: int = 60):
    """A path well inside regular ground: a bow through a random configuration with large σ."""
    task = resolve_task(None, robot)
    q = rng.uniform(-1.2, 1.2, (400, robot.n))
    q = np.clip(q, robot.lower + 0.35, robot.upper - 0.35)
    weakest = singular_values(robot, q, task)[:, min(task.m, robot.n) - 1]
    middle = q[int(weakest.argmax())]
    s = np.linspace(-1.0, 1.0, rows)[:, None]
    return middle + 0.08 * s * rng.normal(size=robot.n) + 0.05 * s**2 * rng.normal(size=robot.n)


@pytest.mark.parametrize("name", ARMS)
def test_poses_are_met_to_rounding_and_the_branch_is_kept(name: str) -> None:
    robot = open_robot(name)
    rng = np.random.default_rng(1)
    q = smooth(robot, rng)
    wanted = pose(robot, q)
    found = follow(robot, wanted, q[0], limits=False)
    assert found.complete
    assert found.q.shape == q.shape
    np.testing.assert_allclose(pose(robot, found.q), wanted, atol=1e-10)
    if resolve_task(None, robot).m == robot.n:  # nothing else moves the tool alike
        np.testing.assert_allclose(found.q, q, atol=1e-8)


def test_rows_that_are_far_apart_are_reached_along_the_straight_line_between_them() -> None:
    robot = open_robot("ur5")
    q = np.array([[0.0, -1.2, 1.2, 0.3, 0.9, 0.1], [0.6, -1.0, 1.5, 0.1, 1.3, 0.5]])
    found = follow(robot, pose(robot, q), q[0])
    dense = follow(robot, poses_between(*pose(robot, q), np.linspace(0, 1, 500)), q[0])
    assert found.complete
    assert dense.complete
    np.testing.assert_allclose(found.q[-1], dense.q[-1], atol=1e-9)
    np.testing.assert_allclose(found.q[-1], q[1], atol=1e-8)


@pytest.mark.parametrize("rows", [3, 40, 3000])
def test_the_branch_ends_at_the_singularity_that_it_runs_into(rows: int) -> None:
    robot = open_robot("planar2r")
    q = np.array([0.3, 1.2])
    start = pose(robot, q)
    out = np.repeat(start[None], rows, axis=0)
    radius = np.linalg.norm(start[:2, 3])
    away = start[:2, 3] / radius
    out[:, :2, 3] += np.linspace(0, 2 * float(np.sum(np.abs(robot.home[:2, 3]))) - radius, rows)[:, None] * away
    found = follow(robot, out, q)
    assert not found.complete
    assert found.reason == "singular"
    assert found.sigma < 1e-2
    reach = np.linalg.norm(robot.home[:2, 3])
    place = 1 + (rows - 1) * (reach - radius) / (np.linalg.norm(out[-1, :2, 3]) - radius)
    assert found.reached == pytest.approx(place, abs=1e-4 * rows)
    assert len(found.q) == int(found.reached)


def test_the_other_side_of_a_singularity_is_another_branch() -> None:
    robot = open_robot("ur5")
    q = np.linspace([0.0, -1.2, 1.2, 0.3, 0.4, 0.1], [0.2, -1.1, 1.3, 0.2, -0.4, 0.3], 101)
    found = follow(robot, pose(robot, q), q[0])
    assert not found.complete
    assert found.reason == "singular"
    assert found.reached == pytest.approx(51.0, abs=0.6)
    assert abs(found.last[4]) < 0.1


def test_a_turn_of_the_joint_itself_does_not_carry_it_through() -> None:
    robot = open_robot("puma560")
    q = np.tile([0.0, 0.7, -0.2, 0.3, 0.4, 0.1], (31, 1))
    q[:, 4] = np.linspace(0.4, -0.41, 31)  # no error of second order stops Newton there
    found = follow(robot, pose(robot, q), q[0])
    assert (found.complete, found.reason) == (False, "singular")
    assert found.last[4] == pytest.approx(0.0, abs=1e-3)


def test_limits_end_it_and_are_named() -> None:
    robot = open_robot("ur5")
    tight = replace(robot, joints=tuple(
        replace(joint, upper=0.25) if k == 0 else joint for k, joint in enumerate(robot.joints)
    ))  # fmt: skip
    q = np.linspace([0.0, -1.2, 1.2, 0.3, 0.9, 0.1], [0.5, -1.1, 1.3, 0.2, 0.8, 0.3], 21)
    found = follow(tight, pose(robot, q), q[0])
    assert (found.reason, found.complete) == ("limit", False)
    assert found.joint == 1
    assert found.reached == pytest.approx(11.0, abs=1e-4)
    assert follow(tight, pose(robot, q), q[0], limits=False).complete


def test_a_pull_moves_the_elbow_and_not_the_tool() -> None:
    robot = open_robot("panda")
    q = smooth(robot, np.random.default_rng(2), rows=200)
    wanted = pose(robot, q)
    plain = follow(robot, wanted, q[0], limits=False)
    pulled = follow(robot, wanted, q[0], limits=False, pull=lambda _: np.eye(7)[0])
    assert plain.complete
    assert pulled.complete
    np.testing.assert_allclose(pose(robot, pulled.q), wanted, atol=1e-10)
    assert pulled.q[-1, 0] - plain.q[-1, 0] > 0.01


@pytest.mark.parametrize(("name", "rows", "axes"), [
    ("ur5", (0, 1, 2), 0), ("ur5", (3, 4, 5), 0), ("ur5", (0, 1, 2, 4), -1), ("puma560", (1, 3, 4), 0)
])  # fmt: skip
def test_other_tasks_keep_their_rows(name: str, rows: tuple[int, ...], axes: int) -> None:
    robot = open_robot(name)
    task = Task("part", rows, Frame(axes, -1, (0.0, 0.02, 0.1)))
    q = smooth(robot, np.random.default_rng(3), rows=30)
    wanted = pose(robot, q)
    found = follow(robot, wanted, q[0], task, limits=False)
    assert found.complete
    now = pose(robot, found.q)
    point = np.array([0.0, 0.02, 0.1, 1.0])
    if rows == (0, 1, 2):
        np.testing.assert_allclose(now @ point, wanted @ point, atol=1e-10)
    elif rows == (3, 4, 5):
        np.testing.assert_allclose(now[:, :3, :3], wanted[:, :3, :3], atol=1e-10)
    else:
        turned = now[:, :3, :3] if axes else np.eye(3)[None].repeat(30, axis=0)
        shift = np.einsum("nji,nj->ni", turned, ((wanted - now) @ point)[:, :3])
        np.testing.assert_allclose(shift[:, [row for row in rows if row < 3]], 0.0, atol=1e-10)


def test_bad_input_is_refused() -> None:
    robot = open_robot("ur5")
    with pytest.raises(ConfigurationError, match="one configuration"):
        follow(robot, np.eye(4)[None], np.zeros(5))
    with pytest.raises(TaskError, match="does not determine"):
        follow(robot, np.eye(4)[None], np.zeros(6), Task("part", (0, 1), Frame(2, -1)))
    far = np.eye(4)[None].copy()
    far[0, 0, 3] = 100.0
    assert follow(robot, far, np.full(6, 0.5)).reason == "start"


def test_an_arm_in_millimetres_goes_the_same_way() -> None:
    robot = open_robot("stanford")
    q = smooth(robot, np.random.default_rng(5))
    other = scale_lengths(robot, 3)
    there = q.copy()
    slide = [joint.unit for joint in robot.variables].index("m")
    there[:, slide] *= 1000
    one, two = follow(robot, pose(robot, q), q[0]), follow(other, pose(other, there), there[0])
    assert one.complete == two.complete
    two.q[:, slide] /= 1000
    np.testing.assert_allclose(one.q, two.q, atol=1e-7)


@pytest.mark.by_hand
@pytest.mark.slow_at("puma560", "ur5")
@pytest.mark.parametrize("name", ["ur5", "puma560"])
def test_whatever_the_steps_no_singularity_is_passed_through(name: str) -> None:
    robot = open_robot(name)
    task = resolve_task(None, robot)
    rng = np.random.default_rng(6)
    ended = 0
    for _ in range(40):
        middle, way = rng.uniform(-1.5, 1.5, robot.n), rng.normal(size=robot.n) * 0.3
        q = middle + np.linspace(-1, 1, int(rng.integers(5, 60)))[:, None] * way
        found = follow(robot, pose(robot, q), q[0], limits=False)
        sides = np.sign(np.linalg.det(task_jacobian(robot, found.q, task)))
        assert (sides == sides[0]).all()
        ended += not found.complete
    assert ended >= 3


def test_a_branch_that_creeps_along_a_singularity_ends_there_soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """500 poses of the Gen3, turned by 0.1° from a path through its elbow: steps of 1e-8 of a move led on, hundreds."""
    robot = open_robot("gen3")
    start, end = np.radians([[4, 28, 8, 6, 30, 39, -1.0], [5, 27, 9, -6, 31, 38, 0.0]])
    poses = pose(robot, start + np.linspace(0.0, 1.0, 500)[:, None] * (end - start))
    poses[:, :3, :3] = rotation(np.array([[2e-3, 0.0, 0.0]]))[0] @ poses[:, :3, :3]
    solved = []
    solve = Aim.solve
    monkeypatch.setattr(Aim, "solve", lambda aim, goal, q: solved.append(len(q)) or solve(aim, goal, q))
    found = follow(robot, poses, start, tolerance=(1e-4, 1e-3))
    assert (found.complete, found.reason) == (False, "singular")
    assert 145.0 < found.reached < 155.0
    assert len(solved) < 400  # 1,446 without an end


def test_a_line_of_many_short_steps_through_a_singularity_does_not_creep() -> None:
    """80 mm through an elbow of a KR 6, without a share along the lost direction: 75 tries lead over a third of it."""
    robot = open_robot("kr6r900")
    singular = [-0.8333070332006834, 1.2620280124025074, 0.7897086567443616, -1.1976367206352627, 0.482796989290571,
                0.4315384941497946]  # fmt: skip
    start = [-0.833307033197975, 1.1414609450206588, 0.9855420681611434, -1.3387184037818958, 0.460300441614862,
             0.5898250252154271]  # fmt: skip
    way = np.array([-0.37620500271221624, -0.41409644662696127, -0.8288509690078342])
    ends = np.stack([pose(robot, singular)] * 2)
    ends[:, :3, 3] += np.outer([-0.04, 0.04], way)
    found = follow(robot, ends, start, tolerance=(1e-4, 1e-4), limits=False, through=True)
    assert (found.complete, found.reason) == (True, "")
    assert found.passed[0].place == pytest.approx(1.5, abs=1e-3)


@pytest.mark.parametrize("q5", [50.0, 0.001])
def test_where_the_tool_stands_still_so_do_the_joints(q5: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """1,000 equal poses, a motion, 1,000 equal poses: steps that shrink with the joint motion would end there."""
    robot = open_robot("irb120")
    start = np.radians([0.0, -10.0, 10.0, 80.0, q5, 0.0])
    share = np.clip(np.linspace(-20.0, 21.0, 2051), 0.0, 1.0)
    rows = start + 0.1 * share[:, None]
    solved = []
    solve = Aim.solve
    monkeypatch.setattr(Aim, "solve", lambda aim, goal, q: solved.append(len(q)) or solve(aim, goal, q))
    found = follow(robot, pose(robot, rows), start, tolerance=(1e-4, 1e-3))
    assert found.complete
    at_poses = found.q[found.place == np.floor(found.place)]
    np.testing.assert_allclose(at_poses, rows, atol=1e-6)
    assert len(solved) < 400


@pytest.mark.parametrize("degrees", [1e-1, 1e-3, 1e-5])
def test_a_line_that_misses_a_wrist_by_however_little_is_followed(degrees: float) -> None:
    """Within one move of a KUKA KR 6, in up to 250 steps: for 150 of them joints move by less than half a radian."""
    robot = open_robot("kr6r900")
    q = np.radians([0.0, -80.0, 90.0, 20.0, degrees, 0.0])
    middle = pose(robot, q)
    ends = np.stack([middle, middle])
    ends[:, :3, 3] += np.outer([-0.1, 0.1], [0.5, 0.7, -0.5])
    back = follow(robot, np.stack([middle, ends[0]]), q, limits=False)
    found = follow(robot, ends, back.last, limits=False, tolerance=(1e-4, 1e-3))
    assert found.complete
    assert abs(np.degrees(found.q[-1, 3] - found.q[0, 3])) > 100.0


def test_a_first_pose_that_the_solver_does_not_reach_is_refused_in_a_sentence(rng: np.random.Generator) -> None:
    """Wrists straight at the start, the first pose with six digits: checked, or refused with how to mend it."""
    arm = open_robot("ur5e")
    for _ in range(12):
        q = rng.uniform(-0.8, 0.8, 6) + np.array([0.0, -1.0, 1.0, 0.0, 0.0, 0.0])
        q[4] = 0.0
        poses = pose(arm, np.stack([q, q + 0.05 * rng.normal(size=6)]))
        poses[0, :3, 3] = poses[0, :3, 3].round(6)
        left, _, right = np.linalg.svd(poses[0, :3, :3].round(6))
        poses[0, :3, :3] = left @ right
        told = ""
        try:
            check = check_poses(arm, poses, start=q, branches=False)
            rows = len(check.tool.q)
        except ConfigurationError as error:
            rows, told = 0, str(error)
        assert rows > 0 or "next to a singularity" in told
