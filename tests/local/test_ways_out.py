"""Escape: printed and closed-form answers, and what must not depend on base, tool, signs and length scale."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from reference import arms

from rankdrop.errors import ConfigurationError, OptionError, TaskError
from rankdrop.families.searching import search
from rankdrop.local.block import singular_values
from rankdrop.local.ways_out import Escape, escape
from rankdrop.robot.model import JointKind
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.text.words import avoidable_words

HALF = np.pi / 2


def by_number(found: Escape) -> dict[int, tuple[int, int | None, float]]:
    return {joint.number: (joint.gain, joint.order, joint.rate) for joint in found.single}


def test_gr_arm_escapes_by_joints_3_and_4_only() -> None:
    """GR section 5, corrected: the rates are those of σ_6 with the length unit 1 m."""
    robot = open_robot("rcrrrr")
    found = escape(robot, [0] * 7, resolve_task(None, robot, length_scale=1.0))
    assert found.corank == 1
    numbers = by_number(found)
    assert {number for number, (gain, _, _) in numbers.items() if gain} == {3, 4}
    assert [joint.number for joint in found.single[:2]] == [4, 3]
    assert numbers[3][1] == numbers[4][1] == 1
    assert numbers[3][2] == pytest.approx(0.7036, abs=7e-5)
    assert numbers[4][2] == pytest.approx(2.0713, abs=7e-5)
    assert all(joint.agrees for joint in found.single)
    receptors = {joint.number: joint.receptors for joint in found.single}
    assert receptors[4] == (6, 7)
    assert all(receptor > number for number, them in receptors.items() for receptor in them)


def test_second_order_where_two_pa10_families_meet() -> None:
    found = escape(open_robot("pa10"), [0.1, 0, 0.7, 0, 0.9, 0.4, 0.2])
    numbers = by_number(found)
    assert numbers[4][:2] == (1, 2)
    assert {number for number, (gain, _, _) in numbers.items() if gain} == {4}
    assert found.single[0].number == 4
    robot, task = open_robot("pa10"), resolve_task(None, open_robot("pa10"))
    q, t = np.array([0.1, 0, 0.7, 0, 0.9, 0.4, 0.2]), 1e-3
    after = singular_values(robot, q + t * np.eye(7)[3], task)[-1]
    assert after / t**2 == pytest.approx(numbers[4][2], rel=2e-3)


def test_puma_wrist_leaves_by_joint_5() -> None:
    found = escape(open_robot("puma560"), [0.1, 0.5, 0.7, 0.3, 0, 0.4])
    numbers = by_number(found)
    assert numbers[5][:2] == (1, 1)
    assert {number for number, (gain, _, _) in numbers.items() if gain} == {5}
    receptors = {joint.number: joint.receptors for joint in found.single}
    assert receptors[5] == (6,)
    assert receptors[1] == (4, 6)  # joints 2, 3 and 5 take part in no dependency
    assert receptors[4] == receptors[6] == ()


def test_no_single_joint_frees_the_zero_pose_of_pa10_but_joints_4_and_6_do() -> None:
    robot = open_robot("pa10")
    task = resolve_task(None, robot)
    found = escape(robot, [0] * 7)
    assert found.corank == 3
    assert all(joint.order is None and joint.gain < 3 for joint in found.single)
    pair = found.best_pair
    assert pair is not None
    assert pair.restores
    assert pair.gain == pair.measured_gain == 3
    assert pair.numbers == (4, 6)
    best = 0.0
    angles = np.linspace(0, 2 * np.pi, 360, endpoint=False)
    for a, b in combinations(range(7), 2):
        q = np.zeros((360, 7))
        q[:, a], q[:, b] = 0.1 * np.cos(angles), 0.1 * np.sin(angles)
        best = max(best, float(singular_values(robot, q, task)[:, 5].max()))
    assert pair.sigma_after >= best * (1 - 1e-3)
    assert found.best_direction.sigma_after >= pair.sigma_after * (1 - 1e-12)


@pytest.mark.parametrize(
    ("name", "q"),
    [
        ("pa10", [0.1, 0.5, 0.7, 0, 0.9, 0.4, 0.2]), ("pa10", [0.0] * 7), ("pa10", [0.1, 0.3, 0.2, 0.8, 0.9, 0.4, 0.2]),
        ("puma560", [0.1, 0.5, 0.7, 0.3, 0, 0.4]), ("scara", [0.1, 0, 0.1, 0.2]),
        ("canadarm2", [0.1, 0, HALF, 0.2, HALF, 0, 0.3]),
    ],
)  # fmt: skip
def test_nothing_that_dense_search_finds_beats_the_best_direction(name: str, q: list[float]) -> None:
    robot = open_robot(name)
    task = resolve_task(None, robot)
    found = escape(robot, q).best_direction
    rank = 4 if name == "scara" else 6
    random = np.random.default_rng(1).normal(size=(40_000, robot.n))
    random /= np.linalg.norm(random, axis=1, keepdims=True)
    scale = np.array([task.scale(robot) if joint.unit == "m" else 1.0 for joint in robot.variables])
    reached = np.asarray(q) + 0.1 * random * scale
    reached = np.clip(reached, robot.lower, robot.upper)
    best = singular_values(robot, reached, task)[:, rank - 1].max()
    assert found.restores
    assert found.sigma_after >= best * (1 - 1e-2)
    after = np.asarray(q) + found.step * np.array(found.delta)
    assert singular_values(robot, after, task)[rank - 1] == pytest.approx(found.sigma_after, rel=1e-9)
    assert np.linalg.norm(np.array(found.delta) / scale) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.spread(2)
@pytest.mark.slow
@pytest.mark.parametrize(("name", "corank"), [("ur5", 2), ("ur5", 3), ("canadarm2", 2), ("canadarm2", 3)])
def test_the_best_direction_is_found_where_singular_values_tie(name: str, corank: int) -> None:
    robot = open_robot(name)
    task = resolve_task(None, robot)
    random = np.random.default_rng(5).normal(size=(20_000, robot.n))
    random *= 0.1 / np.linalg.norm(random, axis=1, keepdims=True)
    points = search(robot, corank, starts=30, seed=1).converged[:12]
    assert len(points) == 12
    for q in points:
        dense = singular_values(robot, np.clip(q + random, robot.lower, robot.upper), task)[:, 5].max()
        assert escape(robot, q).best_direction.sigma_after >= 0.965 * dense


def test_motions_stay_inside_the_limits() -> None:
    arm = open_robot("pa10")
    joints = list(arm.joints)
    joints[3] = replace(joints[3], lower=0.0, upper=2.0)  # q4 = 0 is at the lower limit
    joints[4] = replace(joints[4], lower=0.9, upper=0.9)  # no room at all
    robot = replace(arm, joints=tuple(joints))
    q = np.array([0.1, 0.5, 0.7, 0, 0.9, 0.4, 0.2])
    found = escape(robot, q)
    single = {joint.number: joint for joint in found.single}
    assert single[4].step == 0.1
    assert single[4].within_limits
    assert not single[5].within_limits
    assert single[5].step == 0.0
    for direction in (found.best_pair, found.best_direction):
        assert direction is not None
        after = q + direction.step * np.array(direction.delta)
        assert (after >= robot.lower - 1e-12).all()
        assert (after <= robot.upper + 1e-12).all()
        assert direction.within_limits
        assert direction.restores


def test_an_arm_with_no_room_says_so() -> None:
    arm = open_robot("planar3r")
    joints = tuple(replace(joint, lower=0.0, upper=0.0) for joint in arm.joints)
    found = escape(replace(arm, joints=joints), [0, 0, 0])
    assert not any(joint.within_limits for joint in found.single)
    assert not found.best_direction.within_limits
    assert found.best_direction.step == 0.0
    assert {joint.number: joint.gain for joint in found.single}[2] == 1  # the geometry is told all the same


def test_a_regular_configuration_gets_slopes() -> None:
    robot = open_robot("pa10")
    q, task = np.array([0.1, 0.3, 0.2, 0.8, 0.9, 0.4, 0.2]), resolve_task(None, robot)
    found = escape(robot, q)
    assert found.corank == 0
    for joint in found.single:
        h = 1e-5 * np.eye(7)[joint.number - 1]
        slope = (singular_values(robot, q + h, task)[5] - singular_values(robot, q - h, task)[5]) / 2e-5
        assert joint.order == 1
        assert joint.gain == joint.measured_gain == 0
        assert joint.rate == pytest.approx(slope, abs=1e-8)
    assert found.best_direction.sigma_after > singular_values(robot, q, task)[5]
    assert found.avoidable is None


def test_near_a_singularity_the_given_corank_is_taken() -> None:
    robot = open_robot("pa10")
    q = np.array([0.1, 0.5, 0.7, 1e-5, 0.9, 0.4, 0.2])
    found = escape(robot, q, corank=1)
    assert {joint.number for joint in found.single if joint.gain} == {4}
    assert all(joint.agrees for joint in found.single)
    assert found.boundary is None  # q itself is regular
    assert found.avoidable is not False
    assert "only near" in avoidable_words(found)


@pytest.mark.parametrize(
    ("changes", "error"),
    [
        ({"q": [0, 0]}, ConfigurationError), ({"q": [np.nan] * 7}, ConfigurationError), ({"task": "no"}, TaskError),
        ({"step": 0.0}, OptionError), ({"step": np.nan}, OptionError), ({"corank": 7}, OptionError),
        ({"corank": 2}, OptionError),
    ],
)  # fmt: skip
def test_bad_input_is_refused(changes: dict[str, object], error: type[Exception]) -> None:
    given = {"q": [0.0] * 7, "task": None, **changes}
    with pytest.raises(error):
        escape(open_robot("pa10"), **given)  # type: ignore[arg-type]


def test_a_task_the_arm_cannot_do_at_all_is_refused() -> None:
    with pytest.raises(TaskError):
        escape(open_robot("planar3r"), [0, 0, 0], "vz")


CASES = [
    ("pa10", [0.1, 0.5, 0.7, 0, 0.9, 0.4, 0.2]),
    ("pa10", [0.1, 0, 0.7, 0, 0.9, 0.4, 0.2]),
    ("pa10", [0.0] * 7),
    ("puma560", [0.1, 0.5, 0.7, 0.3, 0, 0.4]),
    ("stanford", [0.1, 0.5, 0.6, 0.3, 0, 0.4]),
    ("rcrrrr", [0.0] * 7),
]


def told(found: Escape) -> tuple[object, ...]:
    """What may not depend on where the base, the tool or the unit of length is."""
    single = sorted(
        (joint.number, joint.gain, joint.order, joint.measured_gain, joint.receptors) for joint in found.single
    )
    return found.corank, single, found.avoidable, found.boundary, [lost.type for lost in found.types]


@pytest.mark.parametrize(("name", "q"), CASES)
def test_base_tool_and_length_scale_do_not_matter(name: str, q: list[float], rng: np.random.Generator) -> None:
    robot = open_robot(name)
    reference = told(escape(robot, q))
    scaled = [escape(robot, q, resolve_task(None, robot, length_scale=length)) for length in (0.3, 3.0)]
    moved = arms.remade(robot, motion=arms.rigid(rng))
    tool = replace(robot, home=robot.home @ arms.rigid(rng, 0.2))
    for other in (*scaled, escape(moved, q), escape(tool, q)):
        assert told(other) == reference


@pytest.mark.parametrize(("name", "q"), CASES)
def test_the_sign_of_a_joint_only_turns_its_motion_round(name: str, q: list[float]) -> None:
    robot = open_robot(name)
    joints = [
        replace(joint, screw=-joint.screw, lower=-joint.upper, upper=-joint.lower) if i % 2 else joint
        for i, joint in enumerate(robot.joints)
    ]
    sign = np.where(np.arange(robot.n) % 2, -1.0, 1.0)
    one, other = escape(robot, q), escape(replace(robot, joints=tuple(joints)), sign * np.array(q))
    assert told(other) == told(one)
    rates = [{joint.number: joint.rate for joint in found.single} for found in (one, other)]
    assert rates[0] == pytest.approx(rates[1], abs=1e-9)


@pytest.mark.parametrize(("name", "q"), CASES)
def test_the_reversed_chain_has_the_same_gains_and_orders(name: str, q: list[float]) -> None:
    """Seen from the tip, screws, ranks and their losses are the same, joint n − j + 1 for joint j."""
    robot = open_robot(name)
    n = robot.n
    back = arms.reversed_chain(robot)
    one, other = by_number(escape(robot, q)), by_number(escape(back, np.array(q)[::-1]))
    for number in range(1, n + 1):
        assert one[number][:2] == other[n + 1 - number][:2]


@pytest.mark.parametrize("length", [0.5, 2.0])
def test_rates_are_per_radian_and_per_metre(length: float, rng: np.random.Generator) -> None:
    robot = arms.random_chain(rng, "rpphrrr")
    task = resolve_task(None, robot, length_scale=length)
    points = search(robot, 1, task=task, starts=20, seed=1).converged
    assert len(points) >= 10
    sliding = 0
    for q in points:
        for joint in escape(robot, q, task).single:
            if joint.order is None:
                continue
            sliding += robot.variables[joint.number - 1].kind is JointKind.PRISMATIC
            t = 1e-6
            after = singular_values(robot, q + t * np.eye(7)[joint.number - 1], task)[5]
            assert after / t**joint.order == pytest.approx(joint.rate, rel=1e-2, abs=1e-6)
    assert sliding > 5


def test_same_seed_same_answer() -> None:
    robot = open_robot("pa10")
    assert escape(robot, [0.0] * 7, seed=3) == escape(robot, [0.0] * 7, seed=3)
