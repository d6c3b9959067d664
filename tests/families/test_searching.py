"""The search: what it finds, what it calls a near miss, what it may have missed; only the seed decides the result."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rankdrop import _core
from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.families import searching
from rankdrop.families.searching import METHODS, Outcome, binomial_upper, none_found, refine, search, unseen
from rankdrop.kinematics import task_jacobian
from rankdrop.local.block import sample, singular_values
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


def random_arm(n: int, seed: int):
    rng = np.random.default_rng(seed)
    rows = [(rng.uniform(-1, 1), rng.uniform(-np.pi, np.pi), rng.uniform(-1, 1), 0.0) for _ in range(n)]
    return from_dh(
        [{"a": a, "alpha": alpha, "d": d, "theta": theta} for a, alpha, d, theta in rows], convention="standard",
        name=f"random{n}r",
    )


@pytest.mark.parametrize(
    ("name", "coranks"), [("pa10", (1, 2, 3)), ("ur5", (1, 2)), ("canadarm2", (1, 2, 3)), ("puma560", (1, 2))]
)
def test_nearly_every_start_reaches_a_corank_that_exists(name, coranks):
    robot = open_robot(name)
    for corank in coranks:
        found = search(robot, corank, starts=500, seed=3)
        assert len(found.converged) >= 0.99 * 500
        assert found.residual() <= 1e-12
        sigma = np.linalg.svd(_plain_jacobian(robot, found), compute_uv=False)
        assert sigma[:, found.rank].max() < 1e-12  # LAPACK agrees with the core's own verdict


@pytest.mark.parametrize(
    ("name", "corank", "least"), [("pa10", 4, 0.2), ("puma560", 3, 0.004), ("canadarm2", 4, 0.3), ("almarkhi4", 2, 0.1)]
)
def test_a_corank_that_does_not_exist_ends_in_near_misses_never_in_a_find(name, corank, least):
    found = search(open_robot(name), corank, starts=300, seed=5)
    assert found.count(Outcome.CONVERGED) == 0
    assert found.count(Outcome.NEAR_MISS) > 250
    assert found.smallest_near_miss is not None
    assert found.smallest_near_miss > least


def test_the_smallest_sigma_met_is_that_of_sigma_not_of_the_sum_of_squares():
    robot = open_robot("almarkhi4")
    task = resolve_task("position", robot, length_scale=1.0)
    missed = search(robot, 2, task=task, starts=1000, seed=1)
    at_block_minima = missed.sigma[missed.outcome == Outcome.NEAR_MISS, 1].min()
    assert at_block_minima == pytest.approx(0.7177, abs=2e-4)  # where (σ2² + σ3²)/2 is least
    assert missed.smallest_near_miss == pytest.approx(0.70833, abs=1e-5)


def test_steps_to_linearised_zero_reach_rank_1_quickly():
    robot = open_robot("pa10")
    found = search(robot, 1, starts=50, seed=1, method="gradient", step=1.0, history=True)
    assert found.count(Outcome.CONVERGED) == 50
    assert np.median(found.iterations) < 10
    small = search(robot, 1, starts=1, seed=1, method="gradient", step=0.01, iterations=50, history=True)
    sigma = small.history.sigma[0, :, 5]
    assert sigma[1:] / sigma[:-1] == pytest.approx(0.99 * np.ones(50), abs=2e-3)
    assert small.outcome[0] == Outcome.SLOW
    assert (small.step, small.most) == (0.01, 50)


def test_ties_are_treated_below_the_gap_that_is_asked_for():
    robot = open_robot("pa10")
    task = resolve_task("pose", robot, length_scale=1.0)
    q = sample(robot, task, 106, 2)[-1:]
    never = refine(robot, q, 2, task=task, method="almarkhi", tie=0.0, step=0.0)
    plain = refine(robot, q, 2, task=task, method="gradient", step=0.0)
    assert np.array_equal(never.q, plain.q)
    assert plain.outcome[0] == Outcome.CREASE
    treated = refine(robot, q, 2, task=task, method="almarkhi", step=0.0)
    assert treated.outcome[0] == Outcome.CONVERGED
    assert treated.iterations[0] == 20
    assert not np.array_equal(refine(robot, q, 2, task=task, method="almarkhi", tie=0.5, step=0.0).q, treated.q)


def test_a_start_on_its_own_ends_as_in_the_search_it_belongs_to():
    robot = open_robot("puma560")
    whole = search(robot, 3, starts=8, seed=5)
    q = sample(robot, resolve_task(None, robot), 8, 5)
    alone = refine(robot, q[6:7], 3, seed=5, first=6)
    assert np.array_equal(alone.q[0], whole.q[6])


@pytest.mark.by_hand
def test_plain_descents_of_rank_2_end_on_creases_not_at_minima():
    found = search(open_robot("pa10"), 2, starts=500, seed=2, method="gradient", step=0.0, iterations=300)
    assert found.count(Outcome.CREASE) > 20
    assert found.count(Outcome.NEAR_MISS) == 0
    tied = found.sigma[found.outcome == Outcome.CREASE, 4:]
    assert (tied[:, 0] - tied[:, 1] < 1e-3 * tied[:, 0]).all()


@pytest.mark.by_hand
def test_the_default_steps_of_descents_reach_corank_3_where_a_line_search_is_stuck():
    robot = open_robot("pa10")
    default = search(robot, 3, starts=200, seed=2, method="gradient")
    line = search(robot, 3, starts=200, seed=2, method="gradient", step=0.0, iterations=300)
    assert default.count(Outcome.CONVERGED) == 200
    assert line.count(Outcome.CONVERGED) < 80
    assert line.count(Outcome.CREASE) > 20


@pytest.mark.parametrize(
    "wrong", [{"step": 0.5}, {"method": "gradient", "step": -0.1}, {"method": "gradient", "step": 2.5}, {"tie": -0.1},
              {"tie": float("nan")}, {"iterations": 0}, {"iterations": 1.5}]
)  # fmt: skip
def test_rules_of_steps_that_cannot_be_are_refused(wrong):
    with pytest.raises(OptionError):
        search(open_robot("pa10"), 1, starts=1, **wrong)


@pytest.mark.parametrize("seed", range(3))
def test_random_geometries_have_corank_two_at_six_joints_and_not_beyond(seed):
    assert len(search(random_arm(6, seed), 2, starts=300, seed=seed).converged) > 0
    for n in (7, 8):
        found = search(random_arm(n, seed), 2, starts=200, seed=seed)
        assert len(found.converged) == 0
        assert found.count(Outcome.NEAR_MISS) + found.count(Outcome.SLOW) == 200


@pytest.mark.by_hand_at("almarkhi", "gradient")
@pytest.mark.slow_at("gradient", "almarkhi")
@pytest.mark.parametrize("method", METHODS)
def test_same_seed_same_bits_on_any_number_of_threads(method):
    robot = open_robot("canadarm2")
    starts = 150 if method == "lm" else 24
    one, four = (search(robot, 2, starts=starts, seed=7, method=method, threads=t) for t in (1, 4))
    assert np.array_equal(one.q, four.q)
    assert np.array_equal(one.sigma, four.sigma)
    assert np.array_equal(one.outcome, four.outcome)
    assert not np.array_equal(one.q, search(robot, 2, starts=starts, seed=8, method=method).q)


def test_same_bits_on_every_instruction_set():
    robot, results = open_robot("pa10"), []
    used = _core.instruction_set()
    try:
        for name in _core.instruction_sets():
            assert _core.choose_instruction_set(name)
            results.append(search(robot, 3, starts=200, seed=1))
    finally:
        _core.choose_instruction_set(used)
    for other in results[1:]:
        assert np.array_equal(results[0].q, other.q)
        assert np.array_equal(results[0].sigma, other.sigma)
    assert not _core.choose_instruction_set("abacus")


def test_within_limits_every_configuration_is_inside_them():
    robot = open_robot("panda")
    found = search(robot, 1, starts=400, seed=2, limits=True)
    assert len(found.converged) > 100
    assert (found.q >= robot.lower).all()
    assert (found.q <= robot.upper).all()
    assert found.residual() <= 1e-9


def test_panda_inside_its_limits_is_never_stretched_straight():
    # joint 4 of a Panda stays below -0.0698 rad, so q4 = 0 is outside
    found = search(open_robot("panda"), 1, starts=400, seed=2, limits=True)
    assert found.q[:, 3].max() <= -0.0698


@pytest.mark.slow
def test_descent_methods_follow_almarkhi_and_keep_their_history():
    robot = open_robot("pa10")
    task = resolve_task("pose", robot, length_scale=1.0)
    for method in ("gradient", "almarkhi"):
        found = search(robot, 2, task=task, starts=100, seed=0, method=method, step=0.0, iterations=300,
                       history=True)  # fmt: skip
        assert 0.6 < len(found.converged) / 100 < 0.9  # about 73 % of the starts reach corank 2
        sigma = found.history.sigma[:, :, found.rank]
        for start, used in enumerate(found.iterations):
            assert np.isfinite(sigma[start, : used + 1]).all()
            assert np.isnan(sigma[start, used + 1 :]).all()
            assert (np.diff(sigma[start, : used + 1]) <= 1e-12).all()  # steepest descent never climbs
        turning = found.history.turning[np.isfinite(found.history.turning)]
        assert turning.min() >= 0
        assert np.degrees(turning.max()) > 100  # beyond 90° only where values tie: the line search is exact
        assert found.residual() <= 1e-6


def test_lm_history_ends_at_the_reported_values():
    found = search(open_robot("ur5"), 1, starts=50, seed=0, history=True)
    for start, used in enumerate(found.iterations):
        assert np.array_equal(found.history.sigma[start, used], found.sigma[start])


def test_a_search_in_parts_equals_one_in_one_go():
    robot = open_robot("pa10")
    seen = []
    whole = search(robot, 1, starts=3000, seed=4, progress=lambda done, total: seen.append((done, total)))
    assert seen[-1] == (3000, 3000)
    assert len(seen) > 1
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)
    again = search(robot, 1, starts=3000, seed=4)
    assert np.array_equal(whole.q, again.q)


def test_refine_starts_where_it_is_told():
    robot = open_robot("pa10")
    near = np.array([[0.3, 0.7, 0.2, 1e-3, 0.4, 0.9, 0.1]])
    found = refine(robot, near, 1)
    assert found.outcome[0] == Outcome.CONVERGED
    assert abs(found.q[0, 3]) < 1e-12
    assert np.abs(found.q - near).max() < 2e-3


def test_the_end_points_are_wrapped_and_still_singular():
    robot = open_robot("puma560")
    found = search(robot, 1, starts=300, seed=9)
    assert np.abs(found.q).max() <= np.pi
    assert singular_values(robot, found.converged, found.task)[:, found.rank].max() < 1e-12


def test_bad_options_say_what_is_allowed():
    robot = open_robot("pa10")
    with pytest.raises(OptionError, match=r"got 7; allowed: 1 … 6"):
        search(robot, 7)
    with pytest.raises(OptionError, match="lm, gradient, almarkhi"):
        search(robot, 1, method="newton")
    with pytest.raises(OptionError, match="starts: this value is not allowed"):
        search(robot, 1, starts=0)
    with pytest.raises(ConfigurationError, match="index"):
        refine(robot, np.full((2, 7), np.nan), 1)


def _plain_jacobian(robot, found):
    return task_jacobian(robot, found.converged, found.task)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"starts": 2.5}, r"starts: this value is not allowed; got 2\.5; allowed: a whole number"),
        ({"starts": True}, "starts: this value is not allowed; got True"),
        ({"starts": 0}, "starts: .* got 0; allowed: a whole number, 1 … 10000000"),
        ({"seed": "x"}, "seed: .* got 'x'"),
        ({"seed": -1}, "seed: .* got -1"),
        ({"seed": 2**63}, "seed: this value"),
        ({"threads": 1025}, "threads: .* got 1025; allowed: a whole number, 0 … 1024"),
    ],
)
def test_numbers_out_of_range_are_refused(options: dict[str, Any], words: str) -> None:
    arm = open_robot("scara")
    with pytest.raises(OptionError, match=words):
        search(arm, 1, **options)
    if "starts" not in options:
        with pytest.raises(OptionError, match=words):
            refine(arm, np.zeros((1, 4)), 1, **options)


def test_the_largest_seed_and_numbers_of_numpy_are_taken() -> None:
    assert search(open_robot("scara"), 1, starts=np.int64(10), seed=2**63 - 1).seed == 2**63 - 1  # type: ignore[arg-type]


def test_near_misses_of_the_sum_of_squares_that_lead_on_to_zero_are_no_smallest_sigma():
    found = search(open_robot("dobot_cr5"), 3, starts=10_000, seed=0)
    assert found.count(Outcome.NEAR_MISS) > 0
    assert found.sigma[found.outcome == Outcome.NEAR_MISS, found.rank].min() > 0.1
    assert len(found.converged) > 9000
    assert found.smallest_near_miss is None


def test_starts_of_a_barren_search_are_not_moved_on_from_their_minima(monkeypatch):
    robot = open_robot("panda")
    monkeypatch.setattr(searching, "_TRIED", 50)
    found = search(robot, 3, starts=200)
    ever = refine(robot, starts_of(robot, 200), 3)
    assert not (found.outcome == Outcome.CONVERGED).any()
    np.testing.assert_array_equal(found.iterations[:50], ever.iterations[:50])
    assert found.iterations[50:].mean() < 0.6 * ever.iterations[50:].mean()


def test_a_search_that_finds_late_is_run_as_if_it_had_found_at_once(monkeypatch):
    robot, seed = open_robot("panda"), 8
    ever = refine(robot, starts_of(robot, 200, seed), 2, seed=seed)
    assert ever.outcome[0] == Outcome.NEAR_MISS
    monkeypatch.setattr(searching, "_TRIED", 1)
    found = search(robot, 2, starts=200, seed=seed)
    np.testing.assert_array_equal(found.outcome, ever.outcome)
    np.testing.assert_array_equal(found.iterations, ever.iterations)


def test_the_lowest_near_misses_of_a_barren_search_are_followed_to_zero(monkeypatch):
    robot = open_robot("panda")
    monkeypatch.setattr(searching, "_MET", 1.1)  # every place counts as a minimum
    monkeypatch.setattr(searching, "_TRIED", 10)
    found = search(robot, 1, starts=20)
    assert found.count(Outcome.CONVERGED) == 20
    assert found.sigma[:, found.rank].max() <= 1e-9
    assert found.smallest_near_miss is None


def starts_of(robot, count, seed=0):
    return sample(robot, resolve_task(None, robot), count, seed)


def test_without_singletons_it_is_the_rule_of_three():
    result = unseen([500, 300, 200])
    assert result.estimate == 0.0
    assert result.upper == pytest.approx(3 / 1000, rel=1e-2)
    assert "rule of three" in result.how


def test_singletons_are_counted():
    result = unseen([90, 1, 1, 1, 2, 5, 0])
    assert result.estimate == pytest.approx(3 / 100)
    assert 0.03 < result.upper < 0.12


def test_without_points_nothing_is_known():
    assert unseen([]).estimate == 1.0
    assert unseen([0, 0]).upper == 1.0


def test_when_nothing_converges_the_starts_bound_it():
    result = none_found(2000)
    assert result.estimate == 0.0
    assert result.upper == pytest.approx(3 / 2000, rel=1e-2)


def test_bound_is_exact_at_the_ends():
    assert binomial_upper(5, 5) == 1.0
    assert binomial_upper(0, 1) == pytest.approx(0.95)


def test_bound_holds_at_least_nineteen_times_in_twenty(rng):
    """40 pieces, some rare: the true unseen mass is below the bound."""
    weights = 1.0 / np.arange(1, 41) ** 2
    weights /= weights.sum()
    inside = 0
    for _ in range(300):
        counts = rng.multinomial(150, weights)
        inside += unseen(counts.tolist()).upper >= weights[counts == 0].sum()
    assert inside >= 0.95 * 300
