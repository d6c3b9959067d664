"""A distance that keeps a speed: proven where random configurations agree, and hardly larger than it has to be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cover.regions import family_of, region_of
from scipy.optimize import linprog

import rankdrop
from rankdrop.cli import main
from rankdrop.cover.speed import SpeedRegion
from rankdrop.cover.speed_measures import residual
from rankdrop.errors import OptionError
from rankdrop.families.speed_distance import SpeedDistances
from rankdrop.local.rates import rate_limits
from rankdrop.results.analysis import Analysis
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.units import scale_lengths

WRISTS = [("irb120", 5, (0.0,)), ("ur5e", 5, (0.0, np.pi)), ("kr6r900", 5, (0.0,))]
FEW = np.radians(8.0)


def speeds(robot, q: np.ndarray) -> np.ndarray:
    """(N,) speed in the slowest direction of a 6-joint arm, from the inverse Jacobian of the package's front door."""
    inverse = np.linalg.inv(np.array([rankdrop.jacobian(robot, one) for one in q]))[:, :, :3]
    return (rate_limits(robot) / np.linalg.norm(inverse, axis=2)).min(axis=1)


@pytest.mark.slow_at("kr6r900-5-values2")
@pytest.mark.parametrize(("name", "number", "values"), WRISTS)
def test_no_configuration_of_the_region_is_slower_and_some_just_nearer_is(name, number, values, rng) -> None:
    region, j = region_of(name, span=FEW), number - 1
    found = region.distance("k1.f1", number, values)
    assert found.kept_from is not None
    assert found.slower_at is not None
    assert not found.spent
    q = region.around + rng.uniform(-FEW, FEW, (4000, 6))
    q[:, [0, 5]] = rng.uniform(-3, 3, (4000, 2))  # free
    side = np.sign(region.around[j] - found.value)
    q[:, j] = found.value + side * rng.uniform(found.kept_from, found.end, 4000)
    assert speeds(region.robot, q).min() >= 0.25
    q[:, j] = found.value + side * rng.uniform(0.0, 0.5 * found.slower_at, 4000)
    assert speeds(region.robot, q).min() < 0.25
    assert found.slower_speed < 0.25
    assert found.slower_at <= found.kept_from <= 1.021 * found.slower_at + np.radians(0.1)


@pytest.mark.parametrize("name", ["irb120", "ur5e", "panda", "gen3"])
def test_the_bound_of_a_box_is_below_every_configuration_in_it(name: str, rng) -> None:
    region = region_of(name)
    half = np.where(region.matters, rng.uniform(0.0, 0.02, (20, len(region.around))), 0.0)
    centre = region.around + rng.uniform(-0.5, 0.5, half.shape)
    least = region.least(centre, half)
    assert (least > 0.0).mean() > 0.5
    for _ in range(20):
        assert (region.slowest(centre + rng.uniform(-1, 1, half.shape) * half) >= least).all()
    point = region.least(centre, np.zeros_like(half))
    assert (point <= region.slowest(centre) * (1 + 1e-9)).all()


def test_the_rest_of_a_bound_is_of_second_order(rng) -> None:
    """Halving a box takes three quarters of what the bound and the slowest of its corners differ by."""
    region = region_of("irb120")
    corners = np.where(region.matters, np.stack(np.meshgrid(*[[-1.0, 1.0]] * 6), axis=-1).reshape(-1, 6), 0.0)
    gaps = []
    for half in (0.02, 0.01):
        least = region.least(region.around[None], np.where(region.matters, half, 0.0)[None])[0]
        gaps.append(region.slowest(region.around + half * corners).min() - least)
    assert 0.0 < gaps[1] < gaps[0] / 3


def inside(region: SpeedRegion, low: np.ndarray, high: np.ndarray, rng, count: int) -> np.ndarray:
    """(count, n) configurations of a region that goes on to the ends given."""
    q = rng.uniform(low, high, (count, len(low)))
    q[:, ~region.matters] = rng.uniform(-2, 2, (count, int((~region.matters).sum())))
    return q


@pytest.mark.slow
def test_a_residual_keeps_the_speed_up_to_the_family_and_a_smaller_one_does_not(rng) -> None:
    region, family = region_of("ur5e", span=FEW), family_of("ur5e", "k1.f1")
    found = region.distance_from(family)
    assert (found.measure, found.unit, found.numbers) == ("residual", "m", family.coupled)
    assert found.slower_at <= found.kept_from < found.end
    measure, j = residual(region.robot, family), found.number - 1
    low, high = region._bounds()
    low[j], high[j] = min(low[j], found.value), max(high[j], found.value)
    there = region.around.copy()
    there[j] = found.value
    assert measure.at(there[None])[0] < 1e-9
    q = inside(region, low, high, rng, 20_000)
    away, speed = measure.at(q), speeds(region.robot, q)
    assert speed[away >= found.kept_from].min() >= 0.25
    assert speed[(away < found.slower_at) & (away > 0.5 * found.slower_at)].min() < 0.25
    assert found.slower_speed < 0.25


@pytest.mark.slow
def test_the_largest_distance_of_two_joints_keeps_the_speed_of_an_arm_with_seven(rng) -> None:
    around = np.radians([10.0, 25.0, 20.0, 70.0, 10.0, 30.0, 0.0])
    region = region_of("iiwa7", 0.1, span=np.radians(3.0), around=around, budget=4_000)
    family = family_of("iiwa7", "k1.f3")
    found = region.distance_from(family)
    assert (found.measure, found.numbers, found.values) == ("joints", (2, 6), (0.0, 0.0))
    assert found.kept_from is not None
    assert found.kept_from < found.end
    low, high = region._bounds()
    low[[1, 5]] = 0.0
    q = inside(region, low, high, rng, 800)
    away = np.abs(q[:, [1, 5]]).max(axis=1)
    speed = region.slowest(q)
    assert speed[away >= found.kept_from].min() >= 0.1
    near = inside(region, low, high, rng, 50)
    near[:, [1, 5]] *= 1e-3
    assert region.slowest(near).min() < 0.1


def test_slides_and_spare_joints_have_bounds_that_hold(rng) -> None:
    for name in ("stanford", "fetch8"):
        arm = open_robot(name)
        arm = replace(arm, joints=tuple(replace(joint, velocity=0.7) for joint in arm.joints))
        region = SpeedRegion(arm, resolve_task(None, arm), 0.25)
        half = np.where(region.matters, 0.01, 0.0) * np.ones((10, 1))
        centre = region.around + rng.uniform(-0.3, 0.3, half.shape)
        least = region.least(centre, half)
        assert (least > 0.0).mean() > 0.5
        for _ in range(20):
            assert (region.slowest(centre + rng.choice([-1.0, 1.0], half.shape) * half) >= least).all()


def test_the_slowest_motion_of_a_spare_joint_is_that_of_a_linear_programme() -> None:
    region = region_of("panda")
    J, limits = rankdrop.jacobian(region.robot, region.around), rate_limits(region.robot)
    each = []
    for u in np.eye(3):
        wanted = np.concatenate([u, np.zeros(3)])
        done = linprog(
            np.r_[np.zeros(7), -1.0], A_eq=np.c_[J, -wanted], b_eq=np.zeros(6),
            bounds=[*((-x, x) for x in limits), (0, None)],
        )
        each.append(done.x[-1])
    assert region.least(region.around[None], np.zeros((1, 7)))[0] <= min(each) * (1 + 1e-6)


@pytest.mark.slow
def test_an_arm_in_millimetres_has_the_same_distances() -> None:
    arm = open_robot("irb120")
    larger = scale_lengths(arm, 3)
    one, other = (SpeedRegion(x, resolve_task(None, x), 0.25, span=0.05) for x in (arm, larger))
    assert one.distance("", 5, (0.0,)).kept_from == pytest.approx(other.distance("", 5, (0.0,)).kept_from, abs=2e-3)


@pytest.mark.slow
def test_a_budget_that_is_spent_is_said_and_what_it_gives_is_larger() -> None:
    short, whole = (region_of("irb120", span=FEW, budget=budget).distance("", 5, (0.0,)) for budget in (200, 50_000))
    assert short.spent
    assert not whole.spent
    assert short.kept_from is None or short.kept_from >= whole.kept_from


@pytest.mark.slow
def test_a_region_on_both_sides_of_the_value_is_proven_on_both(rng) -> None:
    around = np.array([0.5, -1.0, 1.4, 0.3, 0.05, 0.1])
    region = region_of("ur5e", 0.2, around=around, span=np.radians(20.0))
    found = region.distance("k1.f1", 5, (0.0, np.pi))
    assert found.kept_from is not None
    one_side = region._search(4, 0.05, 1.0, 0.05 + region.span)
    other = region._search(4, 0.05, -1.0, region.span - 0.05)
    assert found.kept_from == pytest.approx(max(one_side.distance, other.distance or other.end), rel=1e-9)
    q = around + rng.uniform(-1, 1, (4000, 6)) * region.span
    q = q[np.abs(q[:, 4]) >= found.kept_from]
    assert (q[:, 4] < 0).any()
    assert speeds(region.robot, q).min() >= 0.2


def test_a_region_around_a_singular_posture_has_no_speed_that_is_kept() -> None:
    region = region_of("ur5e", around=np.zeros(6), span=0.05)
    assert region.least(region.around[None], np.zeros((1, 6)))[0] == 0.0
    assert region.distance("", 5, (0.0,)).kept_from is None


def test_a_speed_beyond_the_region_is_kept_nowhere() -> None:
    found = region_of("irb120", 5.0, span=0.05).distance("", 5, (0.0,))
    assert found.kept_from is None


@pytest.mark.parametrize(
    ("name", "given", "said"),
    [("planar3r", {}, "no rate limits"), ("irb120", {"span": 0.0}, "span"), ("irb120", {"speed": -1.0}, "speed"),
     ("irb120", {"around": [0.0] * 5}, "expected q of shape")],
)
def test_what_has_no_distance_is_refused(name: str, given: dict, said: str) -> None:
    with pytest.raises(rankdrop.RankdropError, match=said):
        region_of(name, **given)


def test_an_arm_with_too_few_rate_limits_is_refused_with_what_is_missing() -> None:
    """A panda with one rate limit: the six other joints alone make any motion, as fast as they like."""
    arm = open_robot("panda")
    joints = tuple(replace(one, velocity=np.inf) if k else one for k, one in enumerate(arm.joints))
    with pytest.raises(OptionError, match=r"no rate limits that bound.*1 of 7 joints.*at least 2.*velocity"):
        SpeedRegion(replace(arm, joints=joints), resolve_task(None, arm), 0.25)


@pytest.mark.slow
@pytest.mark.shipped
def test_analyze_has_a_table_and_a_file_keeps_it(tmp_path) -> None:
    found = rankdrop.analyze(open_robot("irb120"), starts=100, speed=0.25, span=0.1)
    assert isinstance(found.speeds, SpeedDistances)
    assert [one.family for one in found.speeds.distances] == ["k1.f1", "k1.f2", "k1.f3"]
    assert found.speeds.others == ()
    assert found.speeds.free == (1, 6)
    found.save(tmp_path / "arm.json")
    assert Analysis.load(tmp_path / "arm.json").speeds == found.speeds
    assert found.slow is not None
    assert Analysis.load(tmp_path / "arm.json").slow == found.slow
    assert 0.36 < found.slow.share.share < 0.42
    more = found.to_dict()
    more["slow"]["share"]["near"] = 10_001
    with pytest.raises(rankdrop.RankdropError, match="more configurations are slow than there are"):
        Analysis.from_dict(more)
    forged = found.to_dict()
    forged["speeds"]["others"] = ["k1.f9"]
    with pytest.raises(rankdrop.RankdropError, match=r"a distance is of no family"):
        Analysis.from_dict(forged)
    assert rankdrop.analyze(open_robot("irb120"), starts=100).speeds is None
    with pytest.raises(OptionError, match="around"):
        rankdrop.analyze(open_robot("irb120"), speed=0.25, around="0,0,0,0,0,0")


@pytest.mark.slow
@pytest.mark.shipped
def test_the_command_prints_how_far_to_stay(capsys) -> None:
    words = ["analyze", "irb120", "--speed", "250mm/s", "--span", "5deg", "--around", "0,0.3,0.2,0,0.8,0"]
    assert main.run([*words, "--starts", "100", "--quiet"]) == 0
    out = capsys.readouterr().out
    assert "keeps 250 mm/s from" in out
    assert "° from 0°" in out
    assert "of the configurations inside the joint limits the tool is slower" in " ".join(out.split())
    assert main.run(["analyze", "irb120", "--speed", "0mm/s"]) == 2
