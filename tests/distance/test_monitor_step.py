"""A step of a control loop: what slows, what does not, which internal motion leads away; beside MoveIt Servo's rule."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from reference.servo import HARD_STOP, condition, servo_scaling

import rankdrop
from rankdrop import Monitor
from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.local.block import joint_scale
from rankdrop.results.known import shipped
from rankdrop.robot.model import Array

ARMS = ("pa10", "panda", "sawyer", "ur5e", "puma560", "hc10", "open_manipulator", "px150", "scara", "planar3r",
        "canadarm2", "almarkhi4")  # fmt: skip
REDUNDANT = ("pa10", "panda", "sawyer", "canadarm2", "almarkhi4")


@cache
def monitor_of(name: str, start: float = 0.2, stop: float = 0.02) -> Monitor:
    found = shipped(name)
    return Monitor(found.robot, found.task, found.families, start=start, stop=stop)


def places(name: str, rng: np.random.Generator) -> Array:
    """Configurations at all distances from all families: 8 beside each, and 40 anywhere."""
    monitor = monitor_of(name)
    beside = [
        np.array(family.witness) + rng.normal(size=(8, monitor.robot.n)) * 10.0 ** rng.uniform(-3, -0.5, (8, 1))
        for family in monitor.families
    ]
    return np.concatenate([*beside, rng.uniform(-3.0, 3.0, (40, monitor.robot.n))])


def by_hand(monitor: Monitor, q: Array, velocity: Array) -> float:
    """The least s of all families, 1/s = 1 − c + c/k."""
    at, least = monitor.nearby(q), 1.0
    length = float(np.linalg.norm(velocity / joint_scale(monitor.robot, monitor.task)))
    for far, away in zip(at.distance, at.away, strict=True):
        c = max(0.0, -float(away @ velocity) / length)
        if np.isnan(far) or far <= 1e-5 or c <= 1e-9:
            continue
        k = min(1.0, max(0.0, (far - monitor.stop) / (monitor.start - monitor.stop)))
        least = min(least, 1.0 / (1.0 - c + c / k) if k > 0.0 else 0.0)
    return least


@pytest.mark.slow_at("almarkhi4")
@pytest.mark.by_hand_at("hc10", "sawyer")
@pytest.mark.slow_at("sawyer", "hc10")
@pytest.mark.parametrize("name", ARMS)
def test_the_scaling_is_that_of_its_equation(name: str, rng: np.random.Generator) -> None:
    monitor, slowed = monitor_of(name), 0
    for q in places(name, rng):
        velocity = rng.normal(size=monitor.robot.n)
        seen = monitor.step(q, velocity)
        assert seen.scaling == pytest.approx(by_hand(monitor, q, velocity), abs=1e-12)
        assert 0.0 <= seen.scaling <= 1.0
        slowed += seen.scaling < 1.0
    assert slowed >= 2


@pytest.mark.spread(9)
@pytest.mark.by_hand_at("sawyer")
@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_the_distance_grows_along_its_gradient(name: str, rng: np.random.Generator) -> None:
    monitor, tried = monitor_of(name), 0
    for q in places(name, rng)[::3]:
        at, x = monitor.nearby(q), rng.normal(size=monitor.robot.n)
        ahead, behind = monitor.nearby(q + 1e-7 * x), monitor.nearby(q - 1e-7 * x)
        slope = (ahead.distance - behind.distance) / 2e-7
        for f, family in enumerate(monitor.families):
            if family.coupled or at.distance[f] < 1e-3 or not family.pinned:
                continue  # of coupled joints `away` is that of the tangent plane
            if abs(slope[f]) < 5.0 and abs(ahead.distance[f] + behind.distance[f] - 2 * at.distance[f]) < 1e-9:
                assert slope[f] == pytest.approx(at.away[f] @ x, abs=1e-5)
                tried += 1
    assert tried or all(family.coupled for family in monitor.families)


@pytest.mark.slow_at("hc10")
@pytest.mark.slow_at("sawyer")
@pytest.mark.parametrize("name", ["hc10", "ur5e", "sawyer", "puma560"])
def test_near_a_coupled_family_its_gradient_is_that_of_the_distance(name: str, rng: np.random.Generator) -> None:
    """The distance is |f|/|∇f| there; its slope differs by what curvature makes of that."""
    monitor, tried = monitor_of(name), 0
    for f, family in enumerate(monitor.families):
        if not family.coupled or family.corank != 1 or family.pinned or not family.equations:
            continue
        for _ in range(12):
            q = np.array(family.witness) + rng.normal(size=monitor.robot.n) * 1e-3
            at, x = monitor.nearby(q), rng.normal(size=monitor.robot.n)
            if at.distance[f] < 1e-4:
                continue
            slope = (monitor.nearby(q + 1e-7 * x).distance[f] - monitor.nearby(q - 1e-7 * x).distance[f]) / 2e-7
            assert slope == pytest.approx(at.away[f] @ x, abs=0.02 * float(np.linalg.norm(x)))
            tried += 1
    assert tried >= 4


@pytest.mark.slow_at("sawyer")
@pytest.mark.parametrize("name", ARMS)
def test_motion_away_from_all_families_is_never_slowed(name: str, rng: np.random.Generator) -> None:
    """At every corank, with fewer than six joints, redundant: what leaves goes at full speed."""
    monitor, inside = monitor_of(name), 0
    for q in places(name, rng):
        at = monitor.nearby(q)
        near = np.flatnonzero(at.distance < monitor.start)
        velocity = at.away[near].sum(axis=0) if len(near) else rng.normal(size=monitor.robot.n)
        if not len(near) or (at.away[near] @ velocity < 0).any():
            continue
        assert monitor.step(q, velocity).scaling == 1.0
        inside += int((at.distance[near] < monitor.stop).any())
    assert inside >= 1


@pytest.mark.by_hand_at("sawyer")
@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_every_motion_leaves_from_a_singular_configuration(name: str, rng: np.random.Generator) -> None:
    """An arm that stands on a family is let go: what slows it, if anything, is another family."""
    monitor = monitor_of(name)
    for f, family in enumerate(monitor.families):
        if not family.equations:
            continue
        alone = Monitor(monitor.robot, monitor.task, [family])
        seen = alone.step(np.array(family.witness), rng.normal(size=monitor.robot.n))
        assert seen.corank >= 1
        assert seen.scaling == 1.0, monitor.families[f].id


@pytest.mark.parametrize("name", ["pa10", "ur5e", "scara"])
def test_motion_straight_towards_a_family_comes_to_rest_at_the_second_threshold(name: str) -> None:
    monitor = monitor_of(name, 0.3, 0.05)
    f = next(i for i, one in enumerate(monitor.families) if one.corank == 1 and one.pinned and not one.coupled)
    q = np.array(monitor.families[f].witness)
    q[monitor.families[f].pinned[0].number - 1] += 0.4
    alone = Monitor(monitor.robot, monitor.task, [monitor.families[f]], start=0.3, stop=0.05)
    far = []
    for _ in range(1500):
        velocity = -alone.nearby(q).away[0]
        seen = alone.step(q, velocity)
        assert seen.approach == pytest.approx(1.0)
        far.append(seen.distance)
        q = q + 0.01 * seen.scaling * velocity
    assert far[0] == pytest.approx(0.4)
    assert min(far) >= 0.05
    assert far[-1] == pytest.approx(0.05, abs=1e-6)


def test_the_scaling_has_no_jump_where_the_motion_turns() -> None:
    """Near a singularity the rule of one direction jumps to 1 as soon as a motion leads away (moveit2 issue 1440)."""
    monitor = monitor_of("pa10")
    f = next(i for i, one in enumerate(monitor.families) if [p.number for p in one.pinned] == [4])
    alone = Monitor(monitor.robot, monitor.task, [monitor.families[f]])
    q = np.array([0.3, 0.6, 0.4, 0.1, 0.7, 0.9, 0.2])
    turns = np.linspace(0.0, np.pi, 2001)
    scaling = [alone.step(q, np.sin(t) * np.eye(7)[0] - np.cos(t) * np.eye(7)[3]).scaling for t in turns]
    assert max(scaling) == 1.0
    assert min(scaling) < 0.5
    assert np.abs(np.diff(scaling)).max() < 5e-3


@pytest.mark.parametrize("name", REDUNDANT)
def test_the_internal_step_moves_away_with_the_end_effector_at_rest(name: str, rng: np.random.Generator) -> None:
    monitor, steps = monitor_of(name), 0
    scale = joint_scale(monitor.robot, monitor.task)
    rows = list(monitor.task.rows)
    for q in places(name, rng):
        seen = monitor.step(q)
        if seen.null_rate == 0.0:
            assert not seen.null_step.any()
            continue
        steps += 1
        assert np.linalg.norm(seen.null_step / scale) == pytest.approx(1.0)
        assert np.abs(rankdrop.jacobian(monitor.robot, q, monitor.task.frame)[rows] @ seen.null_step).max() < 1e-9
        at = monitor.nearby(q)
        near = (at.distance < monitor.start) & (at.distance > 1e-5)
        assert (at.away[near] @ seen.null_step >= -1e-5).all()
        assert at.away[seen.nearest] @ seen.null_step == pytest.approx(seen.null_rate, abs=1e-9)
        assert monitor.step(q, seen.null_step).scaling > 0.999
    assert steps >= 20


@pytest.mark.parametrize("name", ["pa10", "iiwa14"])
def test_internal_steps_one_after_the_other_leave_the_neighbourhood(name: str, rng: np.random.Generator) -> None:
    """20 motions of 0.3 rad at most. (A Panda near θ2 = θ4 = 0 has none to speak of: inside, θ4 cannot move.)"""
    monitor, left = monitor_of(name), 0
    f = next(i for i, one in enumerate(monitor.families) if one.corank == 1 and len(one.pinned) == 2)
    for _ in range(20):
        q = rng.uniform(-2.0, 2.0, 7)
        for one in monitor.families[f].pinned:
            q[one.number - 1] = one.values[0] + rng.uniform(0.02, 0.08)
        first = seen = monitor.step(q)
        for _ in range(60):
            q = q + 0.005 * seen.null_step
            seen = monitor.step(q)
        assert seen.distance >= first.distance - 1e-4
        left += seen.distance > first.distance + 0.02
    assert left >= 15


@pytest.mark.parametrize("name", REDUNDANT)
def test_at_a_singular_configuration_there_is_no_internal_step(name: str) -> None:
    """The null space is larger there, and most of it no motion with the end effector at rest."""
    monitor = monitor_of(name)
    for family in monitor.families:
        seen = monitor.step(np.array(family.witness) + 1e-11)
        assert seen.corank >= 1
        assert seen.null_rate == 0.0
        assert not seen.null_step.any()


def steepest(goal: Array, others: Array) -> Array:
    """goal projected on {h: others · h ≥ 0}, by trying every set of those that bind."""
    for bits in range(2 ** len(others)):
        on = others[[bool(bits >> i & 1) for i in range(len(others))]]
        push = np.linalg.lstsq(on.T, -goal, rcond=None)[0]
        h = goal + on.T @ push
        if (push >= -1e-12).all() and (others @ h >= -1e-9).all():
            return np.asarray(h)
    raise AssertionError("no set binds")


def test_of_internal_motions_the_steepest_that_approaches_nothing_is_taken(rng: np.random.Generator) -> None:
    """Four freedoms to spare: a 7R arm of which only the position matters, among families that lie close together."""
    found = shipped("pa10")
    monitor, turned = Monitor(found.robot, "position", found.families, start=1.0), 0
    for q in rng.uniform(-0.9, 0.9, (60, 7)):
        seen, at = monitor.step(q), monitor.nearby(q)
        null = np.linalg.svd(rankdrop.jacobian(found.robot, q)[:3])[2][3:].T
        inside = at.away @ null @ null.T
        near = np.flatnonzero((at.distance < 1.0) | (np.arange(len(at.distance)) == seen.nearest))
        want = steepest(inside[seen.nearest], inside[near])
        length = np.linalg.norm(want)
        if length < 1e-4:
            continue
        np.testing.assert_allclose(seen.null_step, want / length, atol=1e-4)
        turned += np.linalg.norm(want - inside[seen.nearest]) > 1e-3
    assert turned >= 5


def test_arms_without_a_joint_to_spare_have_no_internal_step(rng: np.random.Generator) -> None:
    for name in ("ur5e", "open_manipulator", "scara"):
        seen = monitor_of(name).step(rng.uniform(-2, 2, monitor_of(name).robot.n))
        assert seen.null_rate == 0.0
        assert not seen.null_step.any()


def test_joint_rates_are_kept_where_a_motion_leaves_too() -> None:
    """moveit2 620: a twist away from a singularity is let go, and the joints run wild; their rates bound it."""
    found = shipped("ur5e")
    monitor = Monitor(found.robot, found.task, found.families, rates=np.full(6, 2.0))
    q = np.array([0.1, -1.2, 1.4, -0.7, 0.01, 0.3])  # the wrist, 0.01 rad away
    _, sigma, vt = np.linalg.svd(rankdrop.jacobian(found.robot, q))
    velocity = vt[-1] * 0.1 / sigma[-1]  # a twist of 0.1 along what is nearly lost
    away = monitor.nearby(q).away[monitor.step(q).nearest]
    velocity = velocity if away @ velocity > 0 else -velocity
    seen = monitor.step(q, velocity)
    assert seen.scaling == 1.0
    assert np.abs(velocity).max() > 3.0
    assert np.abs(velocity * min(seen.scaling, seen.rate_scaling)).max() == pytest.approx(2.0)
    assert seen.rate_scaling == pytest.approx(2.0 / np.abs(velocity).max())


def test_without_conditions_the_slope_of_sigma_slows() -> None:
    found = shipped("ur5e")
    q = np.array([0.1, -1.2, 1.4, -0.7, 0.1, 0.3])
    for families in ((), (replace(found.families[0], equations=(), named=False),)):
        monitor = Monitor(found.robot, found.task, families)
        assert monitor.beyond
        towards, along = monitor.step(q, -np.eye(6)[4]), monitor.step(q, np.eye(6)[4])
        assert towards.distance == pytest.approx(0.1, rel=0.2)
        assert towards.scaling == pytest.approx((towards.distance - 0.02) / 0.18, rel=0.2)
        assert along.scaling == 1.0
    assert not Monitor(found.robot, found.task, found.families).beyond


# MoveIt Servo's rule on the same motions


def recorded(name: str, seed: int, least: float, size: float = 0.25, samples: int = 400) -> tuple[Array, Array]:
    """A motion as it is recorded: joint angles and rates of sums of sines, at least so far from every family."""
    monitor, t = monitor_of(name), np.linspace(0.0, 8.0, samples)[:, None]
    rng = np.random.default_rng(seed)
    for _ in range(400):
        centre, wide = rng.uniform(-2.5, 2.5, monitor.robot.n), rng.uniform(0.2 * size, size, monitor.robot.n)
        speed, phase = rng.uniform(0.4, 1.6, monitor.robot.n), rng.uniform(0.0, 6.0, monitor.robot.n)
        q, rates = centre + wide * np.sin(speed * t + phase), wide * speed * np.cos(speed * t + phase)
        if min(monitor.step(row).distance for row in q[::8]) >= least + 0.05:
            return q, rates
    raise AssertionError(f"{name}: no motion that far from every singularity")


@pytest.mark.parametrize(("name", "joints"), [("open_manipulator", 4), ("px150", 5)])
def test_arms_below_six_joints_are_not_stopped_for_ever(name: str, joints: int) -> None:
    """moveit2 issue 3411, pull request 3750: a 4R arm gets constant emergency stops, with any threshold.

    Reading past the last singular value explains it; but as many as there are, in metres and radians, halt it as well
    0.2 rad and more away from every singularity.
    """
    monitor, halted = monitor_of(name), 0
    assert monitor.robot.n == joints
    for seed in range(5):
        q, rates = recorded(name, seed, monitor.start)
        for row, rate in zip(q, rates, strict=True):
            assert monitor.step(row, rate).scaling == 1.0
        twists = [rankdrop.jacobian(monitor.robot, row) @ rate for row, rate in zip(q, rates, strict=True)]
        halted += all(servo_scaling(monitor.robot, *pair) == 0.0 for pair in list(zip(q, twists, strict=True))[::20])
    assert halted >= 1


def test_a_planned_path_of_a_motoman_is_not_halted_where_nothing_is_near() -> None:
    """ros-industrial/motoman 556: an HC10DTP halts on paths that were planned; here the HC10, at 0.2 rad and more."""
    monitor, halted = monitor_of("hc10"), 0
    for seed in range(60):
        q, rates = recorded("hc10", seed, monitor.start, size=0.1)
        if all(condition(monitor.robot, row) < HARD_STOP for row in q[::40]):
            continue
        halted += 1
        for row, rate in zip(q, rates, strict=True):
            assert monitor.step(row, rate).scaling == 1.0
        twists = (rankdrop.jacobian(monitor.robot, row) @ rate for row, rate in zip(q, rates, strict=True))
        assert min(servo_scaling(monitor.robot, row, twist) for row, twist in zip(q, twists, strict=True)) == 0.0
    assert halted >= 2


def test_leaving_is_not_slowed_where_the_rule_halts_for_ever() -> None:
    """Beyond the hard stop the rule halts whatever the direction; joints have to be jogged out of it (moveit2 620)."""
    monitor = monitor_of("ur5e")
    q = np.array([0.1, -1.2, 1.4, -0.7, 0.01, 0.3])
    for sign in (1.0, -1.0):
        rate = sign * np.eye(6)[4]
        twist = rankdrop.jacobian(monitor.robot, q) @ rate
        assert servo_scaling(monitor.robot, q, twist) == 0.0
        assert monitor.step(q, rate).scaling == (1.0 if sign > 0 else 0.0)


def test_two_singularities_at_once_are_both_kept() -> None:
    """Leaving the wrist while closing on the elbow: of two small singular values the rule asks the smallest alone."""
    monitor = monitor_of("ur5e")
    q = np.array([0.1, -1.2, 0.12, -0.7, 0.12, 0.3])
    rate = np.array([0.0, 0.0, -1.0, 0.0, 1.0, 0.0])
    seen = monitor.step(q, rate)
    k, c = (0.12 - 0.02) / 0.18, np.sqrt(0.5)
    assert seen.scaling == pytest.approx(1.0 / (1.0 - c + c / k), abs=1e-9)
    assert monitor.step(q, np.abs(rate)).scaling == 1.0


def test_bad_input_is_refused() -> None:
    found = shipped("pa10")
    monitor = monitor_of("pa10")
    for q, velocity in ((np.zeros(6), None), (np.zeros(7), np.zeros(6)), (np.zeros(7), np.full(7, np.nan))):
        with pytest.raises(ConfigurationError):
            monitor.step(q, velocity)
    refused = ({"start": 0.1, "stop": 0.1}, {"stop": -0.1}, {"start": np.inf}, {"rates": [1.0]}, {"rates": [0.0] * 7})
    for options in refused:
        with pytest.raises(OptionError):
            Monitor(found.robot, found.task, found.families, **options)
    assert monitor.step([0.1] * 7, [0] * 7).scaling == 1.0
