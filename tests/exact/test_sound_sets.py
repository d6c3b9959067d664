"""No set of configurations is lost: of random structured arms, and where components are small or stand at θ = π."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction
from math import inf

import numpy as np
import pytest

pytest.importorskip("flint")

from reference.structured import H, arm, lost, structured

from rankdrop.algebra.field import P
from rankdrop.algebra.polynomial import flint
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.roots import PRIMES
from rankdrop.algebra.solving import Solved
from rankdrop.algebra.work import Work
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact import families
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.families import Reality, special_strays
from rankdrop.exact.tree import Drop, _Known, barren
from rankdrop.families.points import cloud, count_explained
from rankdrop.local.block import singular_values
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.verbs.analyze import analyze
from rankdrop.verbs.conditions import conditions


def all_offsets(seed: int) -> Robot:
    """7R, twists ±90°, no length zero, all different."""
    rng = random.Random(f"offsets-{seed}")
    alpha = [*(rng.choice((H, -H)) for _ in range(6)), 0.0]
    a = [*(round(rng.uniform(0.05, 0.6), 3) for _ in range(6)), 0.0]
    return arm(f"offsets{seed}", alpha, a, [round(rng.uniform(0.05, 0.6), 3) for _ in range(7)])


WRIST_OFFSETS = arm(
    "wrist offsets", [-H, H, H, -H, -H, H, 0], [0] * 7, [0.36, 0.0137, 0.42, 0.0131, 0.4, 0.0041, 0.126]
)


@pytest.mark.slow
def test_two_conditions_that_hold_on_several_sets_lose_none_of_them() -> None:
    found = lost(WRIST_OFFSETS)
    assert found.complete
    assert found.families >= 3
    assert found.tested >= 1000
    assert found.left == 0


@pytest.mark.by_hand_at("1", "2")
@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, *(pytest.param(one, marks=pytest.mark.slow) for one in (2, 12))])
def test_structured_arms_are_complete_and_nothing_is_missing(seed: int) -> None:
    found = lost(structured(seed))
    assert found.complete
    assert found.families >= 5
    assert found.tested >= 1000
    assert found.left == 0


@pytest.mark.slow
def test_a_condition_that_touches_zero_for_these_lengths_is_not_lost() -> None:
    """a5 = d3, along an axis and across one: a5 − d3 sin θ5 has a double zero, and letters meet no point of it."""
    found = lost(structured(66))
    assert found.complete
    assert found.tested >= 1000
    assert found.left == 0


@pytest.mark.by_hand
def test_a_configuration_beside_a_zero_of_fourth_order_is_on_its_family() -> None:
    """σ is 1e-11 already 4e-3 rad from the configurations that are singular: 24 of 1,449 were said to be on none."""
    found = lost(structured(73))
    assert found.complete
    assert found.tested >= 1400
    assert found.left == 0


@pytest.mark.by_hand
def test_a_set_on_which_a_solution_has_no_denominator_is_found_however_it_was_cut() -> None:
    """TIAGo at θ3 = ±114°, θ4 = ±90°, θ5 = 94°, and at θ3 = 0, θ5 = −173°: 397 of 1,900 points were on no family."""
    found = conditions(open_robot("tiago"), special=False)
    assert found.complete
    assert (found.explained.agree, found.explained.tested) == (1900, 1900)
    assert found.verified


@pytest.mark.by_hand
def test_conditions_do_not_hold_where_a_solution_is_undetermined_and_the_rank_is_full() -> None:
    """θ7 = 0 and a condition A t5 + B = 0 of TIAGo held at A = B = 0, whatever θ5: 3 of 569 points were regular."""
    found = analyze(open_robot("tiago"), starts=1000, fresh=True)
    assert found.verified


@pytest.mark.by_hand_at("j2n6s300")
@pytest.mark.slow
@pytest.mark.parametrize("name", ["m1n6s200", "j2n6s300"])
def test_points_of_a_set_that_stand_in_no_prime_field_are_not_lost(name: str) -> None:
    """Corank 2 of arms with two 60° twists: θ2 … θ5 at single values, roots of roots."""
    found = conditions(open_robot(name), method="tree", points=0, special=False)
    assert found.complete
    sizes = [(family.corank, family.codimension) for family in found.families]
    assert sizes == [(1, 1), (2, 3), (2, 3), (2, 4), (3, 4)]
    met = cloud(open_robot(name), found.task, 2, 100, 7)
    check, _ = count_explained(met, [family.equations for family in found.of_corank(2)])
    assert check.tested > 200
    assert check.holds


@pytest.mark.by_hand_at(
    "17", "18", "19", "20", "21", "22", "23", "24", "25", "27", "28", "29", "32", "12", "26", "30", "31",
)
@pytest.mark.by_hand_at("9")
@pytest.mark.by_hand_at("3", "4", "5", "6", "7", "8", "11", "13", "14", "15", "16")
@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3, 33))
def test_what_is_called_complete_misses_no_singular_configuration(seed: int) -> None:
    found = lost(structured(seed))
    assert found.tested >= 500
    assert found.left == 0 or not found.complete


@pytest.mark.by_hand
@pytest.mark.parametrize("seed", [0, 1])
def test_a_7r_arm_with_all_offsets_is_complete_with_letters_at_every_corank(seed: int) -> None:
    found = conditions(all_offsets(seed))
    assert found.complete
    assert found.verified
    assert len(found.letters) >= 10
    assert [(family.corank, family.codimension) for family in found.families] == [(1, 2)]
    assert found.explained.tested >= 1000


@pytest.mark.by_hand
@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2, 5))
def test_more_7r_arms_with_all_offsets(seed: int) -> None:
    test_a_7r_arm_with_all_offsets_is_complete_with_letters_at_every_corank(seed)


def proven(ring: Ring, *entries) -> bool:
    """Whether entries of a column are proven to have no common zero."""
    return barren(ring, [list(entries)], 1, {}, (), Work())


def test_elimination_proves_what_is_so_and_nothing_else() -> None:
    ring = Ring([1, 2, 3])
    s, c = ring.s, ring.c
    assert proven(ring, s[1], c[1])
    long = [s[1] * s[2] + c[3], s[1] * s[2] + c[3] * 2 + 1, c[1] * c[2] + s[3], s[1] + c[2] - 7, c[3] - s[2]]
    assert proven(ring, *long)
    assert not proven(ring, s[1], c[2])
    assert not proven(ring, s[1] - c[2], s[2] - c[3], s[3] - c[1])


@pytest.mark.parametrize("angle", [Fraction(0), Fraction(1, 3), Fraction(-7, 2)])
def test_a_single_common_zero_is_no_proof(angle: Fraction) -> None:
    """Two conditions on one joint with one zero in common, t = angle: what they share has degree 1."""
    ring = Ring([1])
    s, c = ring.s[1], ring.c[1]
    cosine, sine = (ring.constant(x) for x in ((1 - angle**2) / (1 + angle**2), 2 * angle / (1 + angle**2)))
    assert not proven(ring, c * sine - s * cosine, 1 - c * cosine - s * sine)
    assert proven(ring, c * sine - s * cosine, 2 - c * cosine - s * sine)


@pytest.mark.parametrize("corner", ["0", "pi", "pi/2"])
def test_a_zero_at_a_simple_angle_is_seen_where_tangents_are_infinite_too(corner: str) -> None:
    ring = Ring([1, 2])
    cosine, sine = {"0": (1, 0), "pi": (-1, 0), "pi/2": (0, 1)}[corner]
    s, c = ring.s, ring.c
    assert not proven(ring, c[1] - cosine, s[1] - sine, s[1] * c[2] - sine * c[2], (c[1] - cosine) * (s[2] + 3))


@pytest.mark.by_hand_at("pa10-4")
@pytest.mark.slow_at("pa10-4", "ur5-4")
@pytest.mark.parametrize(("name", "lowest"), [("pa10", 4), ("ur5", 4), ("puma560", 5)])
def test_no_rank_that_is_met_is_proven_away(name: str, lowest: int) -> None:
    chain = exact_chain(open_robot(name))
    for order in range(6, lowest - 1, -1):
        assert not barren(chain.ring, chain.columns, order, {}, (), Work()), order


@pytest.mark.slow
def test_a_7r_arm_with_all_offsets_loses_two_ranks_nowhere() -> None:
    chain = exact_chain(all_offsets(0))
    assert not barren(chain.ring, chain.columns, 6, {}, (), Work())
    assert barren(chain.ring, chain.columns, 5, {}, (), Work())


@pytest.mark.parametrize(("power", "degree", "empty"), [(1, 0, True), (2, 0, True), (1, 1, False), (0, 1, False)])
def test_points_of_no_configuration_are_no_zeros(power: int, degree: int, empty: bool) -> None:
    """1 + t² = 0 holds at no configuration, t = 3 does."""
    t = flint().nmod_mpoly_ctx.get(["t1"], P, flint().Ordering.lex).gens()[0]
    known = _Known(Ring([1]))
    known.add((1 + t**2) ** power * (t - 3) ** degree)
    assert known.barren == empty


@pytest.mark.parametrize(("power", "empty"), [(0, True), (1, False)])
def test_conditions_with_one_common_zero_prove_nothing(power: int, empty: bool) -> None:
    """t − 3 and (t − 3)(t − 5) share t = 3; t − 3 and t − 5 share nothing."""
    t = flint().nmod_mpoly_ctx.get(["t1"], P, flint().Ordering.lex).gens()[0]
    known = _Known(Ring([1]))
    known.add(t - 3)
    known.add((t - 3) ** power * (t - 5))
    assert known.barren is empty


def planted(kind: str) -> tuple[Chain, ZeroSet]:
    """A set of PUMA's with a condition that says nothing of θ5 at special places, where the arm is regular."""
    chain = exact_chain(open_robot("puma560"))
    ring = chain.ring
    if kind == "right angles":  # sin θ5 (cos² θ2 + cos² θ4) = 0
        f = ring.to_half(ring.s[5] * (ring.c[2] ** 2 + ring.c[4] ** 2)).f
        return chain, ZeroSet(ring, {}, rest=(f,), equations=(f,))
    t2, t4, t5 = (ring.form(ring.to_half(ring.s[1]).f).f.context().gen(k) for k in (1, 3, 4))
    numerator, denominator = t2 - 3, t4 - 2  # t5 = N / D
    return chain, ZeroSet(ring, {}, solved=(Solved(4, numerator, denominator),),
                          equations=(denominator * t5 - numerator,))  # fmt: skip


@pytest.mark.parametrize("kind", ["right angles", "undetermined"])
def test_configurations_of_higher_rank_are_met_where_no_start_leads_to(kind: str) -> None:
    chain, piece = planted(kind)
    q = special_strays(chain, piece, 5)
    theta = q + chain.shifts
    assert len(q)
    assert singular_values(chain.own, q, chain.own_task)[:, 5].min() > 1e-3
    if kind == "right angles":
        assert np.allclose(np.cos(theta[:, [1, 3]]), 0.0, atol=1e-6)
        assert np.abs(np.sin(theta[:, 4])).max() > 1e-2
    else:
        both = np.isclose(np.tan(theta[:, [1, 3]] / 2), (3.0, 2.0), atol=1e-6).all(axis=1)
        assert both.sum() > 3
        assert np.ptp(np.sin(theta[both, 4])) > 0.5  # whatever θ5


def test_configurations_of_higher_rank_that_few_starts_reach_are_met() -> None:
    """t5 (t2 − 3) = t5 (t4 − 2) = t5 (t5 − 7) = 0 hold at the wrist, and at one point of θ2, θ4, θ5 besides."""
    chain = exact_chain(open_robot("puma560"))
    t2, t4, t5 = (chain.ring.form(chain.ring.to_half(chain.ring.s[1]).f).f.context().gen(k) for k in (1, 3, 4))
    equations = t5 * (t2 - 3), t5 * (t4 - 2), t5 * (t5 - 7)
    q = special_strays(chain, ZeroSet(chain.ring, {}, rest=equations, equations=equations), 5)
    assert len(q)
    assert np.allclose(np.tan((q + chain.shifts)[:, [1, 3, 4]] / 2), (3.0, 2.0, 7.0), atol=1e-6)
    assert singular_values(chain.own, q, chain.own_task)[:, 5].min() > 1e-2


@pytest.mark.parametrize("kind", ["right angles", "undetermined"])
def test_a_set_is_cut_off_from_its_special_strays(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Random starts find nothing to cut off; a condition is asked for that fails at the special ones all the same."""
    chain, piece = planted(kind)
    asked: list[int] = []

    def separated(chain: Chain, piece: ZeroSet, rank: int, strays: np.ndarray, *rest: object) -> ZeroSet | None:
        asked.append(len(strays))
        return replace(piece, pins={5: "0"}) if len(strays) and not piece.pins else None

    none = np.empty((0, 6))
    monkeypatch.setattr(families, "reality", lambda *_: Reality(np.zeros((1, 6)), True, False, (), none))
    monkeypatch.setattr(families, "add_separating_condition", separated)
    monkeypatch.setattr(families, "tidy", lambda piece, work: piece)
    sharp, _ = families._sharp(chain, Drop(piece, 5), np.random.default_rng(0), [], Work())
    assert asked[0] == 0
    assert max(asked) > 0
    assert sharp.pins == {5: "0"}


def test_a_resultant_is_zero_where_two_polynomials_share_a_factor_with_the_variable() -> None:
    module = flint()
    context = module.nmod_mpoly_ctx.get(["t1", "t2"], PRIMES[0], module.Ordering.lex)
    (x, y), known = context.gens(), _Known(Ring([1, 2]))
    for f, g, place in [(x * y + 1, x + y, 0), ((x + y) * (x - 2), (x + y) * y, 0), ((x + 1) * y, (x + 1) * x, 1)]:
        if g.degrees()[place]:
            zero = f.resultant(g, ("t1", "t2")[place]) == 0
            assert known._resultant_vanishes(f, g, place) == zero


def test_pairs_that_were_tried_are_of_polynomials_that_live() -> None:
    """The address of one that is gone may be that of the next, whose pairs would count as tried."""
    module = flint()
    t, u = module.nmod_mpoly_ctx.get(["t1", "t2"], P, module.Ordering.lex).gens()
    known = _Known(Ring([1, 2]))
    for f in (t * u - 2, t + 2 * u + 3, (t - 3) * (t - 5)):
        known.add(f)
    assert list(known.eliminate_pairs(Work(), inf))
    assert known._tried
    assert all(key[:2] == (id(f), id(g)) for key, (f, g) in known._tried.items())
