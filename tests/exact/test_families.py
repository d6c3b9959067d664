"""Which sets are real: thin ones are cut down, and what is said of the others is what was done."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction
from math import prod

import numpy as np
import pytest

pytest.importorskip("flint")

from rankdrop.algebra.work import Work, tick
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact import families
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.families import full_rank, real_points, real_sets, reality
from rankdrop.exact.family import Unreal
from rankdrop.exact.letters import sign_of
from rankdrop.exact.tree import Drop
from rankdrop.families.record import exact_of
from rankdrop.families.unfinished import Unfinished
from rankdrop.local.block import singular_values
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.tolerances import REAL_STARTS
from rankdrop.verbs.conditions import conditions


@pytest.fixture(scope="module")
def chain() -> Chain:
    return exact_chain(open_robot("anthropomorphic"))


def test_a_sum_of_squares_is_cut_down_to_its_real_points(chain: Chain) -> None:
    """s3² + s5² = 0 has one condition and binds two angles: θ3, θ5 ∈ {0, π}."""
    t = chain.ring.t
    f = t[3] ** 2 * (1 + t[5] ** 2) ** 2 + t[5] ** 2 * (1 + t[3] ** 2) ** 2
    (f,) = [g for g, _ in f.factor()[1]]
    piece = ZeroSet(chain.ring, {}, rest=(f,), equations=(f,))
    left: list[Unfinished] = []
    sets, not_real = real_sets(chain, [Drop(piece, 5)], Work(), left)
    both = ("0", "pi")
    assert {tuple(sorted(one.piece.pins.items())) for one, _ in sets} == {((3, x), (5, y)) for x in both for y in both}
    assert {one.rank for one, _ in sets} == {5}
    assert not left
    assert not not_real


def test_a_set_without_a_real_point_is_told_with_what_was_done(chain: Chain) -> None:
    f = 3 + chain.ring.t[3] ** 2 * chain.ring.t[5] ** 2 + chain.ring.t[5] ** 4
    piece = ZeroSet(chain.ring, {}, rest=(f,), equations=(f,))
    sets, (unreal,) = real_sets(chain, [Drop(piece, 5)], Work(), [])
    assert sets == []
    assert (unreal.reason, unreal.tried) == (Unreal.NOT_FOUND, REAL_STARTS)


def test_a_negative_discriminant_is_a_proof(chain: Chain) -> None:
    ring = chain.ring
    a2 = ring.letter_half["a2"]
    f = a2**2 * ring.t[3] ** 2 + a2 * ring.t[3] + 1
    found = reality(chain, ZeroSet(ring, {}, rest=(f,), equations=(f,)), 5, np.random.default_rng(0))
    assert (found.excluded, found.discriminants) == (True, ("−a2²",))
    assert not found.real
    assert not len(found.points)


def test_a_limit_that_was_met_is_told(chain: Chain) -> None:
    left: list[Unfinished] = []
    work = Work(1.0)
    tick(1.1e6)
    sets, not_real = real_sets(chain, [Drop(ZeroSet(chain.ring, {3: "0"}), 5)], work, left)
    assert (sets, not_real) == ([], [])
    assert list(map(str, left)) == ["the limit on work was reached: 1 of 1 sets were not searched for real points"]


def test_points_near_which_conditions_touch_zero_are_told(chain: Chain) -> None:
    """t5² = 0 is met to 1e-8 only: the rank is neither lost there nor clearly higher."""
    left: list[Unfinished] = []
    f = chain.ring.t[5] ** 2
    piece = ZeroSet(chain.ring, {}, rest=(f,), zero=(chain.ring.s[5],), equations=(f,))
    sets, not_real = real_sets(chain, [Drop(piece, 5)], Work(), left)
    assert (sets, not_real) == ([], [])
    assert len(left) == 1
    assert "its conditions are dependent at all that were found" in str(left[0])


def test_conditions_that_hold_where_the_rank_is_higher_are_told(
    chain: Chain, monkeypatch: pytest.MonkeyPatch
) -> None:
    """θ5 = 0 or θ4 = 3 θ1, as it were: on the second set the rank is full."""
    t = chain.ring.t
    f = t[5] * (t[4] - t[1] * 3)
    piece = ZeroSet(chain.ring, {}, rest=(f,), equations=(f,))
    monkeypatch.setattr(families, "add_separating_condition", lambda *_: None)
    left: list[Unfinished] = []
    sets, _ = real_sets(chain, [Drop(piece, 5)], Work(), left)
    assert len(sets) == 1
    assert len(left) == 1
    assert "hold at configurations of higher rank, too" in str(left[0])
    left.clear()
    sets, _ = real_sets(chain, [Drop(ZeroSet(chain.ring, {5: "0"}), 5)], Work(), left)
    assert len(sets) == 1
    assert not left


def test_points_of_a_set_have_its_rank(chain: Chain) -> None:
    found = real_points(chain, ZeroSet(chain.ring, {5: "pi"}), 5, np.random.default_rng(1))
    points, smooth, strays = found.points, found.smooth, found.strays
    assert smooth
    assert len(points) > 50
    assert not len(strays)
    sigma = singular_values(chain.robot, points, resolve_task(None, chain.robot))
    assert (sigma[:, 5] < 1e-9).all()
    found = real_points(chain, ZeroSet(chain.ring, {4: "pi"}), 5, np.random.default_rng(1))
    points, strays = found.points, found.strays
    assert not len(points), "θ4 = π is regular"
    assert len(strays)


def test_points_of_a_lower_rank_than_claimed_are_none_of_a_set(chain: Chain) -> None:
    """θ3 = θ4 = θ5 = 0 together lose two freedoms, not one: σ of the second is 1e-16 (`RANK_KEPT`)."""
    found = real_points(chain, ZeroSet(chain.ring, {3: "0", 4: "0", 5: "0"}), 5, np.random.default_rng(1))
    points, strays = found.points, found.strays
    assert not len(points)
    assert not len(strays)
    found = real_points(chain, ZeroSet(chain.ring, {3: "0", 4: "0", 5: "0"}), 4, np.random.default_rng(1))
    points, smooth = found.points, found.smooth
    assert smooth
    assert len(points) > 50


def test_a_set_that_one_start_in_ten_reaches_is_found_whatever_the_seed(chain: Chain) -> None:
    """θ5 = 0 among nine sheets θ4 = const that are regular: `REAL_STARTS` are enough (16 miss it with a seventh of the
    seeds)."""
    t = chain.ring.t
    f = t[5] * prod(t[4] - k for k in (0, 1, -1, 2, -2, 3, -3, 5, -5))
    sheets = ZeroSet(chain.ring, {}, rest=(f,), equations=(f,))
    reached = [len(real_points(chain, sheets, 5, np.random.default_rng(seed)).points) for seed in range(40)]
    assert 0.05 < np.mean(reached) / REAL_STARTS < 0.15
    assert min(reached) > 0


def test_gradients_at_a_double_zero_are_rounding_and_small_ones_are_not() -> None:
    double, small = np.array([[[1e-7, 0.0]]]), np.array([[[2e-6, 0.0]]])
    assert full_rank(np.concatenate([double, small]), 1).tolist() == [False, True]


def test_a_rank_that_is_a_little_higher_is_unclear_and_one_that_is_plainly_higher_a_stray(chain: Chain) -> None:
    """Where θ5 is 1e-5 the smallest σ is 1e-6 to 1e-5, where it is 1e-2 nearly everywhere 1e-4 and more
    (`RANK_HIGHER`)."""
    t5, found = chain.ring.t[5], []
    for slope in (200_000, 200):
        f = slope * t5 - 1
        piece = ZeroSet(chain.ring, {}, rest=(f,), equations=(f,))
        found.append(reality(chain, piece, 5, np.random.default_rng(1)))
        assert not len(found[-1].points)
    little, plainly = found
    assert not len(little.strays)
    assert little.unclear > 30
    assert len(plainly.strays) > 30
    assert plainly.unclear < 5


def test_a_condition_fails_where_it_is_more_than_rounding(chain: Chain) -> None:
    near, far = np.zeros((2, chain.n)), np.zeros((3, chain.n))
    near[:, 4], far[:, 4] = 1e-8, 1e-4  # sin θ5 = 0, as a condition on t5
    assert families._count_violations(chain, chain.ring.t[5], np.concatenate([near, far])) == 3


def test_lengths_that_agree_to_their_digits_are_equal(chain: Chain) -> None:
    f = chain.ring.letter_half["a2"] - chain.ring.letter_half["d4"]
    length = Fraction(43, 100)
    for apart, sign in ((Fraction(1, 10**14), 0), (Fraction(1, 10**9), 1)):
        letters = {**chain.letters, "a2": length + apart, "d4": length}
        assert sign_of(replace(chain, letters=letters), f) == sign


@pytest.mark.slow
def test_every_family_has_a_witness_of_its_corank() -> None:
    found = conditions(open_robot("anthropomorphic"), points=0)
    assert all(family.witness for family in found.families)
    for family in found.families:
        sigma = singular_values(found.robot, np.array([family.witness]), found.task)[0]
        assert int((sigma > 1e-9).sum()) == found.generic_rank - family.corank


def test_gradients_that_are_small_but_no_rounding_count() -> None:
    flat, steep = np.diag([1.0, 2e-6])[None], np.diag([1.0, 1e-7])[None]  # small; what a double zero leaves
    assert full_rank(flat, 2).all()
    assert not full_rank(steep, 2).any()


@pytest.mark.parametrize("what", ["a system", "a set without points"])
def test_real_points_that_are_not_all_separated_are_reported(
    chain: Chain, what: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Planted: the thin part of s3² + s5² = 0 cannot be taken apart, or has no point modulo the primes."""
    t = chain.ring.t
    f = t[3] ** 2 * (1 + t[5] ** 2) ** 2 + t[5] ** 2 * (1 + t[3] ** 2) ** 2
    (f,) = [g for g, _ in f.factor()[1]]
    piece = ZeroSet(chain.ring, {}, rest=(f,), equations=(f,))

    def unfinished(_chain: Chain, one: ZeroSet, work: Work) -> list[Drop]:
        if what == "a system":
            work.leave({}, [f])
        else:
            work.without_points[one.key] = one
        return []

    left: list[Unfinished] = []
    real_sets(chain, [Drop(piece, 2)], Work(), left)
    assert not any("were not all taken apart" in str(one) for one in left)
    monkeypatch.setattr(families, "_thinner", unfinished)
    left = []
    real_sets(chain, [Drop(piece, 2)], Work(), left)
    assert any("the real points of a set were not all taken apart" in str(one) for one in left)


@pytest.mark.by_hand_at("1", "2")
@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_random_points_of_a_set_satisfy_a_condition_that_was_added_to_it(seed: int) -> None:
    """Both tool translations across the flange are lost where θ2 = ±π/2; θ6 = const fulfils all conditions but one."""
    derived = conditions(open_robot("puma560"), "across-tool-axis", coranks=2, points=0, seed=seed)
    added = [piece for family in derived.of_corank(2) for piece in exact_of(family).pieces]
    points = [(piece, point) for piece in added for point in piece.points(random.Random(seed), 10)]
    assert len(points) == 10 * len(added) > 0
    assert all(piece.holds_at([point]) for piece, point in points)
    assert not derived.disagreements
