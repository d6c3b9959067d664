"""The nearest singularity: singular, a local minimum of the distance, and right where it is known by construction."""

from __future__ import annotations

import numpy as np
import pytest
from reference import arms

from rankdrop import _core
from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.families.searching import search
from rankdrop.kinematics import chain_of, task_view
from rankdrop.local.block import block, generic_rank, joint_scale, singular_values
from rankdrop.local.nearest import NearestOptions, nearest_singularity
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import Task, resolve_task

ARMS = ("pa10", "ur5", "puma560", "panda", "gen3", "scara", "planar3r", "fetch8", "almarkhi4")
KINDS = ("rpr", "rrr", "rrrrrr", "rrprrr", "hrprhr", "rrmrrrr", "rrrprrrrr")  # p slide, h helical, m mimic


def arm_of(name: str) -> Robot:
    """From the catalogue, or a random chain of these joint kinds."""
    return arms.random_chain(np.random.default_rng(8), name) if set(name) <= set("rphm") else open_robot(name)


def task_of(robot: Robot) -> Task:
    """Three rows for three joints: a random chain of three has no singularity of its own in six."""
    return resolve_task("position" if robot.n == 3 and robot.task == "pose" else None, robot)


def singular_points(robot: Robot, task: Task, count: int) -> Array:
    """Regular points of the singular set: D has its generic rank there."""
    found = search(robot, 1, task=task, starts=40 * count, seed=3)
    d = block(robot, found.converged, task, found.rank).d
    d = d.reshape(len(d), -1, robot.n) * joint_scale(robot, task)
    size = np.linalg.svd(d, compute_uv=False)
    good = (size[:, 0] > 0.05) & ((size > 0.05) | (size < 1e-9)).all(axis=1)
    return found.converged[good][:count]


@pytest.mark.parametrize("name", [*ARMS, *KINDS])
def test_the_result_is_singular_and_a_minimum(name: str, rng: np.random.Generator) -> None:
    robot = arm_of(name)
    task, scale = task_of(robot), joint_scale(robot, task_of(robot))
    for q in rng.uniform(-3, 3, (4, robot.n)):
        found = nearest_singularity(robot, q, task)
        assert found is not None
        at, delta = np.array(found.q), np.array(found.delta)
        rank = generic_rank(robot, task) - 1
        sigma = singular_values(robot, at, task)
        assert sigma[rank] == found.sigma <= 1e-12
        assert found.corank == rank + 1 - (sigma > 1e-9).sum() >= 1
        assert found.stationarity < 1e-8
        assert found.distance == pytest.approx(np.linalg.norm(delta / scale), abs=1e-14)
        np.testing.assert_allclose(q + delta, at, atol=1e-14)
        assert found.agreeing > 0
        # walks; Newton's steps; these and few walks, where they disagree; and more walks, where these disagree as well
        assert found.starts in (128, 56, 88, 216)


def test_a_start_on_a_farther_sheet_does_not_hide_a_nearer_one() -> None:
    robot = arm_of("gen3")
    for q in np.random.default_rng(3).uniform(-3, 3, (6, 7)):
        nearest = nearest_singularity(robot, q)
        assert nearest is not None
        straight = np.array(q)
        straight[3] = np.pi * np.rint(q[3] / np.pi) + np.pi * (abs(q[3]) < np.pi / 2)  # elbow, at its farther value
        found = nearest_singularity(robot, q, seeds=[straight])
        assert found is not None
        assert found.distance == pytest.approx(nearest.distance, abs=1e-9)


STEPPED = ("pa10", "ur5", "puma560", "panda", "gen3", "canadarm2", "fetch8", "iiwa14", "sawyer", "rizon4")


@pytest.mark.spread(3)
@pytest.mark.slow
@pytest.mark.parametrize(("name", "count"), [
    *((name, 40) for name in STEPPED), *(pytest.param(name, 1000, marks=pytest.mark.by_hand) for name in STEPPED),
])  # fmt: skip
def test_newtons_steps_come_no_less_near_than_walks(name: str, count: int) -> None:
    """Against 128 walks, as they were before there were steps; one of 1,000 may be missed, as walks miss some."""
    robot = open_robot(name)
    above = 0
    for q in np.random.default_rng(77).uniform(-np.pi, np.pi, (count, robot.n)):
        stepped, walked = nearest_singularity(robot, q), nearest_singularity(robot, q, starts=128)
        assert stepped is not None
        assert walked is not None
        above += stepped.distance > walked.distance + 1e-9
    assert above <= count // 1000


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pa10", "ur5", "gen3", "fetch8", "rrrrrr", "hrprhr", "rrhrrrr", "rrrprrrrr"])
def test_newtons_steps_end_where_they_should(name: str, rng: np.random.Generator) -> None:
    """From beside a foot ten at most arrive there, to six digits or more: by the right second derivatives only."""
    robot = arm_of(name)
    task = task_of(robot)
    scale, chain, view = joint_scale(robot, task), chain_of(robot), task_view(robot, task)
    arrived = total = 0
    for q in rng.uniform(-3, 3, (12, robot.n)):
        foot = nearest_singularity(robot, q, task, starts=128)
        assert foot is not None
        d = block(robot, np.array(foot.q), task, 5).d.reshape(-1, robot.n) * scale
        if np.linalg.svd(d, compute_uv=False).min() < 1e-2 or foot.distance > 1.5:
            continue  # families cross there or it is folded, and steps are as good as they get
        starts = np.array(foot.q) + 0.02 * rng.uniform(-1, 1, (8, robot.n)) * scale
        turn = 2 * np.pi * robot.periodic
        ends, met, _ = _core.set_feet(chain, view, starts, centre=q, scale=scale, turn=turn, farthest=np.inf)
        away = np.linalg.norm((ends - foot.q) / scale, axis=1)
        total += 8
        arrived += int(((met == 0) & (away < 1e-6)).sum())
    assert arrived >= 0.9 * total
    assert total > 0


def test_newtons_steps_are_for_six_rows_only() -> None:
    robot = open_robot("pa10")
    view = task_view(robot, resolve_task("position", robot))
    zero = np.zeros(7)
    with pytest.raises(ValueError, match="all six rows"):
        _core.set_feet(chain_of(robot), view, zero[None], centre=zero, scale=zero + 1, turn=zero, farthest=1.0)


@pytest.mark.parametrize("name", [*ARMS[:5], "almarkhi4", "rpr", "rrprrr", "rrmrrrr", "rrrprrrrr"])
@pytest.mark.parametrize("away", [1e-3, 1e-6, 1e-9])
def test_beside_the_set_the_distance_is_the_offset(name: str, away: float) -> None:
    """Along a normal of the set the foot is where the normal began, as long as the set is flatter than that."""
    robot = arm_of(name)
    task = task_of(robot)
    scale = joint_scale(robot, task)
    points = singular_points(robot, task, 4)
    assert len(points) == 4
    for point in points:
        d = block(robot, point, task, generic_rank(robot, task) - 1).d.reshape(-1, robot.n) * scale
        normal = np.linalg.svd(d)[2][0]
        found = nearest_singularity(robot, point + away * normal * scale, task)
        assert found is not None
        assert found.distance == pytest.approx(away, abs=1e-10 if away > 1e-8 else 1e-12)


@pytest.mark.parametrize("name", ["pa10", "ur5", "scara", "rrprrr", "rrmrrrr"])
@pytest.mark.parametrize("corank", [1, 2])
def test_at_a_singularity_it_is_zero(name: str, corank: int) -> None:
    robot = arm_of(name)
    task = task_of(robot)
    points = singular_points(robot, task, 5) if corank == 1 else search(robot, 2, starts=40, seed=1).converged[:5]
    assert len(points) == 5 or (corank, name) == (2, "scara")  # which has none
    for point in points:
        found = nearest_singularity(robot, point, task, corank=corank)
        assert found is not None
        assert found.distance < (1e-11 if corank == 1 else 1e-6)  # pieces of the set may cross at the second
        assert found.corank >= corank


def test_at_an_exact_singularity_it_is_exactly_zero() -> None:
    robot = open_robot("pa10")
    for q in ([0.3, 1.1, 0.2, 0.0, 0.7, 1.3, 0.1], [0.0] * 7):
        found = nearest_singularity(robot, q)
        assert found is not None
        assert (found.distance, found.q, found.stationarity) == (0.0, tuple(q), 0.0)


@pytest.mark.parametrize("name", ["pa10", "ur5", "panda", "gen3", "fetch8"])
def test_joints_that_do_not_matter_stay(name: str, rng: np.random.Generator) -> None:
    robot = open_robot(name)
    idle = Problem(robot, resolve_task(None, robot)).idle
    assert idle[0]
    for q in rng.uniform(-3, 3, (5, robot.n)):
        found = nearest_singularity(robot, q)
        assert found is not None
        assert not np.array(found.delta)[idle].any()


def test_whole_turns_change_nothing(rng: np.random.Generator) -> None:
    robot = open_robot("ur5")
    for q in rng.uniform(-3, 3, (10, 6)):
        plain = nearest_singularity(robot, q)
        turned = nearest_singularity(robot, q + 2 * np.pi * rng.integers(-2, 3, 6))
        assert plain is not None
        assert turned is not None
        assert turned.distance == pytest.approx(plain.distance, abs=1e-12)
        np.testing.assert_allclose(turned.delta, plain.delta, atol=1e-7)


def test_same_seed_same_result(rng: np.random.Generator) -> None:
    robot, q = open_robot("panda"), rng.uniform(-3, 3, 7)
    first, again, other = (nearest_singularity(robot, q, seed=seed) for seed in (4, 4, 5))
    assert first == again
    assert first is not None
    assert other is not None
    assert first != other
    assert first.distance == pytest.approx(other.distance, abs=1e-11)


@pytest.mark.parametrize("name", ["panda", "puma560", "iiwa14", "xarm7", "stanford", "scara"])
def test_limits_are_kept_and_cost_distance(name: str, rng: np.random.Generator) -> None:
    robot = open_robot(name)
    low, high = robot.lower, robot.upper
    for q in rng.uniform(np.maximum(low, -3), np.minimum(high, 3), (6, robot.n)):
        inside, free = nearest_singularity(robot, q, limits=True), nearest_singularity(robot, q)
        assert inside is not None
        assert free is not None
        assert inside.within_limits
        assert ((low <= inside.q) & (inside.q <= high)).all()
        assert inside.distance >= free.distance - 1e-10
        assert inside.stationarity < 1e-8
        if free.within_limits:
            assert inside.distance == pytest.approx(free.distance, abs=1e-9)
    beyond = np.where(np.isfinite(high), high + 0.2, 0.3)
    outside = nearest_singularity(robot, beyond, limits=True)
    assert outside is not None
    assert outside.within_limits
    assert outside.distance >= np.linalg.norm((beyond - high)[np.isfinite(high)]) / 10


def test_a_limit_can_make_the_difference() -> None:
    """The iiwa's joint 4 folds to ±2.09 rad only: θ4 = π is out of reach, and θ4 = 0 is the nearest one inside."""
    robot = open_robot("iiwa14")
    q = [0.1, 1.5, 0.1, 2.0, 0.1, 1.5, 0.2]
    free, inside = nearest_singularity(robot, q), nearest_singularity(robot, q, limits=True)
    assert free is not None
    assert inside is not None
    assert not free.within_limits
    assert free.distance == pytest.approx(np.pi - 2.0, abs=1e-12)
    assert inside.distance == pytest.approx(2.0, abs=1e-12)


def test_near_misses_never_count() -> None:
    """PUMA has no corank 3; its smallest local minimum of σ is 0.005."""
    assert nearest_singularity(open_robot("puma560"), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6], corank=3) is None


def test_higher_coranks_are_farther(rng: np.random.Generator) -> None:
    robot = open_robot("pa10")
    for q in rng.uniform(-3, 3, (5, 7)):
        found = [nearest_singularity(robot, q, corank=corank) for corank in (1, 2, 3)]
        distances = [one.distance for one in found if one]
        assert len(distances) == 3
        assert distances == sorted(distances)


@pytest.mark.parametrize(("name", "task"), [
    ("pa10", "position"), ("panda", "orientation"), ("scara", "pose"), ("scara", "planar-position"),
    ("ur5", "vx,vz,wy"),
])  # fmt: skip
def test_other_tasks(name: str, task: str, rng: np.random.Generator) -> None:
    robot = open_robot(name)
    resolved = resolve_task(task, robot)
    for q in rng.uniform(-3, 3, (3, robot.n)):
        found = nearest_singularity(robot, q, task)
        assert found is not None
        assert singular_values(robot, np.array(found.q), resolved)[generic_rank(robot, resolved) - 1] < 1e-12
        assert found.stationarity < 1e-8


def test_a_slide_is_measured_by_the_length_scale() -> None:
    """Stanford arm: the shoulder is singular where its slide is at 0, and σ has a double zero there."""
    robot = open_robot("stanford")
    task = resolve_task(None, robot)
    for slide in (0.05, 0.02):
        found = nearest_singularity(robot, [0.2, 1.2, slide, 0.4, 1.4, 0.3])
        assert found is not None
        assert found.distance == pytest.approx(slide / task.scale(robot), abs=1e-7)
        assert found.delta[2] == pytest.approx(-slide, abs=1e-7)


def test_seeds_are_starts(rng: np.random.Generator) -> None:
    robot, q = open_robot("pa10"), rng.uniform(-3, 3, 7)
    full = nearest_singularity(robot, q)
    assert full is not None
    seeded = nearest_singularity(robot, q, starts=1, seeds=[full.q])
    assert seeded is not None
    assert seeded.distance == pytest.approx(full.distance, abs=1e-12)
    assert seeded.starts == 2


@pytest.mark.parametrize("options", [
    {"corank": 0}, {"corank": 7}, {"corank": 1.0}, {"starts": 0}, {"starts": 10**9}, {"seed": -1}, {"seed": "1"},
])  # fmt: skip
def test_options_out_of_range_are_refused(options: dict[str, object]) -> None:
    with pytest.raises(OptionError):
        nearest_singularity(open_robot("pa10"), [0.1] * 7, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("q", [[0.1] * 6, [0.1] * 6 + [np.nan], [[0.1] * 7]])
def test_only_one_finite_configuration(q: list[float]) -> None:
    robot = open_robot("pa10")
    with pytest.raises(ConfigurationError):
        nearest_singularity(robot, q)
    with pytest.raises(ConfigurationError):
        nearest_singularity(robot, [0.1] * 7, seeds=[q])


def test_too_many_joints_for_a_high_corank_is_said() -> None:
    robot = arms.random_chain(np.random.default_rng(0), "r" * 18)
    assert nearest_singularity(robot, [0.3] * 18) is not None
    with pytest.raises(OptionError, match="too many joints"):
        nearest_singularity(robot, [0.3] * 18, corank=2)


def test_a_question_is_a_record_or_keywords() -> None:
    arm, q = open_robot("pa10"), [0.1, 0.9, 0.4, 0.25, 0.7, 1.1, 0.2]
    asked = NearestOptions(corank=2, starts=40, seed=3)
    assert nearest_singularity(arm, q, None, asked) == nearest_singularity(arm, q, corank=2, starts=40, seed=3)
    other = nearest_singularity(arm, q, None, asked, corank=1)
    assert other is not None
    assert other.corank == 1
    with pytest.raises(OptionError, match="no option has this name"):
        nearest_singularity(arm, q, coranks=2)


@pytest.mark.parametrize(
    ("name", "q", "distance"),
    [("canadarm2", [1.641, 2.997, -2.931, -0.184, 1.463, -1.613, -2.576], 1.302082913165439),
     ("canadarm2", [-2.977, -2.612, -0.658, -0.374, 0.653, -0.504, -0.48], 0.731084385509825),
     ("gen3", [-0.023, -1.166, 1.826, 0.032, 0.568, 2.713, 2.262], 0.6244252046227574)],
)  # fmt: skip
def test_few_walks_that_disagree_are_followed_by_many(name: str, q: list[float], distance: float) -> None:
    """32 walks end 0.03 to 0.37 rad farther away here; the distances are those of 2,048 walks with another seed."""
    found = nearest_singularity(arm_of(name), q)
    assert found is not None
    assert found.distance == pytest.approx(distance, abs=1e-9)
    assert found.starts == 216
