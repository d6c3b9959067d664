"""Joint rates and attainable speeds: against an independent linear programme, exactly zero where nothing moves."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations, product
from math import inf, pi

import numpy as np
import pytest
from scipy.optimize import linprog

from rankdrop.errors import OptionError
from rankdrop.kinematics import jacobian
from rankdrop.local.block import sample
from rankdrop.local.rates import joint_rates, largest_speeds, rate_growth, rate_limits
from rankdrop.robot.model import Array, Mimic, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

ARMS = ["panda", "gen3", "fetch8", "ur5", "iiwa14"]


def looked_at(robot: Robot) -> Array:
    task = resolve_task(None, robot)
    return np.concatenate([sample(robot, task, 4, 4), np.zeros((1, robot.n)), np.full((1, robot.n), 1e-3)])


def by_vertices(rows: Array, twist: Array, limits: Array) -> float:
    """Largest s by brute force for a square or wide J: the support function of the zonotope J·box along its rays.

    max {s : s d ∈ J·box} = min over facet normals w (w·d = 1) of Σ |w·J_i| limit_i. Facet normals are orthogonal to
    m − 1 independent columns.
    """
    m, n = rows.shape
    best = inf
    for chosen in combinations(range(n), m - 1):
        u, sigma, _ = np.linalg.svd(rows[:, chosen])
        if m > 1 and sigma[-1] < 1e-11:
            continue
        w = u[:, -1]
        if abs(w @ twist) > 1e-11:
            best = min(best, float((np.abs(w @ rows) * limits).sum() / abs(w @ twist)))
    return best


@pytest.mark.parametrize("task_name", ["pose", "position", "orientation"])
@pytest.mark.parametrize("name", ARMS)
def test_speeds_are_those_of_the_zonotope(name: str, task_name: str) -> None:
    robot = open_robot(name)
    task = resolve_task(task_name, robot)
    bounded = replace(
        robot,
        joints=tuple(replace(joint, velocity=min(joint.velocity, 2.0)) for joint in robot.joints),
    )
    limits = rate_limits(bounded)
    compared = 0
    for q in sample(bounded, task, 3, 4):
        found = joint_rates(bounded, q, task)
        rows = jacobian(bounded, q)[list(task.rows)]
        assert found.weakest is not None
        assert not found.lost
        for part in (*found.axes, found.weakest):
            want = by_vertices(rows, np.array(part.direction)[list(task.rows)], limits)
            assert part.exact
            assert part.speed == pytest.approx(want, rel=1e-9)
            assert part.speed >= part.speed_smallest_rates * (1 - 1e-12)
            compared += 1
    assert compared == 3 * (task.m + 1)


@pytest.mark.parametrize("task_name", [None, "position"])
@pytest.mark.parametrize("name", [*ARMS, "pa10", "scara", "planar2r", "planar3r", "almarkhi4"])
def test_rates_make_the_direction_and_nothing_makes_a_lost_one(name: str, task_name: str | None) -> None:
    robot = open_robot(name)
    task = resolve_task(task_name, robot)
    lost = 0
    for q in looked_at(robot):
        found = joint_rates(robot, q, task)
        rows = jacobian(robot, q)[list(task.rows)]
        for part in (*found.axes, found.weakest, *found.lost):
            assert part is not None
            if part.possible:
                made = rows @ np.array(part.joint_rates)
                assert np.abs(made - np.array(part.direction)[list(task.rows)]).max() < 1e-8 * (1 + part.norm)
                assert part.speed > 0.0
                assert part.worst is not None
            else:
                assert (part.speed, part.speed_smallest_rates, part.norm) == (0.0, 0.0, inf)
                assert part.joint_rates == ()
                assert part.worst is None
        lost += len(found.lost)
        assert all(not part.possible for part in found.lost)
    if (name, task_name) in {("pa10", None), ("panda", None), ("planar2r", None), ("scara", None)}:
        assert lost, "the zero pose is singular"


def test_the_worst_joint_is_measured_by_its_limit() -> None:
    robot = open_robot("panda")
    part = joint_rates(robot, [0.1, -0.5, 0.2, -1.8, 0.3, 1.6, 0.4]).axes[0]
    share = np.abs(part.joint_rates) / rate_limits(robot)
    assert part.worst == int(np.argmax(share)) + 1
    assert part.speed_smallest_rates == pytest.approx(1 / share.max())


def test_without_limits_speeds_are_endless_and_a_mimic_joint_holds_its_leader_back() -> None:
    robot = open_robot("planar2r")
    assert joint_rates(robot, [0.1, 0.7]).axes[0].speed == inf
    first, second = robot.joints
    follower = replace(second, mimic=Mimic(first.name, -2.0), velocity=3.0)
    pair = replace(robot, joints=(replace(first, velocity=2.0), follower))
    assert rate_limits(pair).tolist() == [1.5]


@pytest.mark.parametrize("seed", range(30))
def test_largest_speeds_equal_a_grid_of_all_corners(seed: int) -> None:
    """One row J: the maximum of J ẋ over the box is Σ |J_i| l_i, whatever n."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 9))
    row, limits = rng.normal(size=(1, n)), rng.uniform(0.1, 3.0, n)
    limits[rng.random(n) < 0.2] = 0.0
    row[:, rng.random(n) < 0.2] = 0.0
    if not row.any():
        return
    null = np.linalg.svd(row)[2][1:].T
    speeds, exact = largest_speeds(np.linalg.pinv(row).T, null, limits)
    assert exact
    assert speeds[0] == pytest.approx(max(float(row[0] @ (limits * s)) for s in product((-1, 1), repeat=n)), abs=1e-12)


def test_an_endless_joint_takes_everything_over() -> None:
    null = np.array([[1.0], [-1.0]])
    assert largest_speeds(np.array([[0.5, 0.5]]), null, np.array([1.0, inf]))[0].tolist() == [inf]
    assert largest_speeds(np.array([[0.5, 0.5]]), null, np.array([0.0, 0.0]))[0].tolist() == [0.0]


def test_rates_grow_as_one_over_the_distance_and_over_its_square_at_second_order() -> None:
    arm = open_robot("pa10")
    first = rate_growth(arm, [0.3, 0.5, 0.2, 0.0, 0.2, 0.7, 1.0], np.eye(7)[3])
    assert first.power == pytest.approx(1.0, abs=0.01)
    second = rate_growth(arm, [0.3, 0.0, 0.2, 0.0, 0.2, 0.7, 1.0], np.eye(7)[3])
    assert second.power == pytest.approx(2.0, abs=0.05)
    nowhere = rate_growth(open_robot("planar2r"), [0.3, pi / 2], [1, 0])
    assert nowhere.power == pytest.approx(0.0, abs=1e-9)
    with pytest.raises(OptionError, match="direction of the joints"):
        rate_growth(arm, [0.0] * 7, [0.0] * 7)


@pytest.mark.slow
def test_against_scipy() -> None:
    """The same speeds as scipy's linear programme, lost directions and slides included."""
    compared = 0
    for name in ("panda", "fetch8", "ur5"):
        robot = open_robot(name)
        for q in looked_at(robot):
            found = joint_rates(robot, q)
            rows = jacobian(robot, q)
            bounds = [(None if limit == inf else -limit, None if limit == inf else limit) for limit in found.limits]
            for part in (*found.axes, *found.lost):
                done = linprog(
                    np.r_[np.zeros(robot.n), -1.0], A_eq=np.c_[rows, -np.array(part.direction)], b_eq=np.zeros(6),
                    bounds=[*bounds, (0, None)],
                )  # fmt: skip
                want = done.x[-1] if done.status == 0 else inf
                assert part.speed == pytest.approx(want, rel=1e-6, abs=1e-6)
                compared += 1
    assert compared > 100


@pytest.mark.parametrize(("tilt", "possible"), [(0.0, True), (1e-10, True), (1e-8, False), (1e-3, False)])
def test_an_axis_that_is_nearly_in_the_range_is_not_in_it(tilt: float, possible: bool) -> None:
    """A stretched planar arm moves across itself only; tilted by 1e-8, the Y axis is no longer that direction."""
    along_y = joint_rates(open_robot("planar2r"), [tilt, 0.0]).axes[1]
    assert along_y.possible == possible
    assert (along_y.speed == 0.0) == (not possible)
