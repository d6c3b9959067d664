"""A good posture is inside the limits, above the base and not folded; start poses of the whole catalogue are such."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import rankdrop
from rankdrop.families import pictured
from rankdrop.families.pictured import _turned_share, pose_witness
from rankdrop.families.record import Family
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.local.directions import lost_directions
from rankdrop.local.posture import fault, spine, start_posture
from rankdrop.problem import Problem
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import shipped
from rankdrop.results.stored_conditions import known_conditions
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.task import resolve_task
from rankdrop.verbs.deriving import posed_exactly


def test_each_fault_counts_and_limits_count_most() -> None:
    arm = open_robot("ur5")
    up, under, folded, beyond = np.radians(
        [[0, -90, 60, 0, 80, 0], [0, 60, 20, 0, 80, 0], [0, -90, 179, 0, 80, 0], [0, -90, 60, 0, 80, 400]]
    )
    good, low, doubled, outside = fault(arm, [up, under, folded, beyond])
    assert good < 0.1
    assert 1.0 < low < outside
    assert 0.5 < doubled < outside
    assert outside >= 6.0


@pytest.mark.spread(76)
@pytest.mark.slow
@pytest.mark.parametrize("name", robot_names())
def test_an_arm_begins_regular_inside_its_limits_and_no_lower_than_it_must(name: str) -> None:
    arm = open_robot(name)
    task = resolve_task(None, arm)
    q = start_posture(arm, task)
    assert ((q >= arm.lower - 1e-9) & (q <= arm.upper + 1e-9)).all()
    rank = generic_rank(arm, task)
    assert singular_values(arm, q, task)[rank - 1] > 1e-4
    assert fault(arm, q)[0] <= 1.0 + 1e-9  # arms in one plane with the base have a tip on the floor


def test_the_ur5_opens_above_the_floor() -> None:
    arm = open_robot("ur5")
    assert spine(arm, start_posture(arm, resolve_task(None, arm))[None])[0, :, 2].min() >= 0.0


def worst(found: Analysis, family: Family) -> Family:
    """The family with the member that is worst to look at, of some, for its witness."""
    problem = Problem(found.robot, found.task, family.corank)
    starts = np.random.default_rng(3).uniform(-3, 3, (200, found.robot.n))
    q, solved = family.system.solve(starts)
    q = q[solved]
    q = q[problem.singular(q) & (problem.sigma(q)[:, problem.rank - 1] > 1e-3)]
    at = q[fault(found.robot, q).argmax()]
    directions = lost_directions(found.robot, at, found.task, family.corank)
    return replace(family, witness=tuple(at), lost_directions=directions)


@pytest.mark.parametrize("name", ["ur5", "kr16", "puma560", "stanford", "gen3"])
def test_a_posed_family_is_the_same_family_at_a_better_place(name: str) -> None:
    found = shipped(name)
    for family in map(partial(worst, found), found.families):
        after = pose_witness(found.robot, found.task, family)
        before, there = fault(found.robot, [family.witness])[0], fault(found.robot, [after.witness])[0]
        assert there <= before - 0.15 or after is family
        assert (after.id, after.equations, after.pinned) == (family.id, family.equations, family.pinned)
        rank = found.generic_rank - family.corank
        sigma = singular_values(found.robot, after.witness, found.task)
        assert sigma[rank] <= 1e-9
        assert rank == 0 or sigma[rank - 1] > 1e-6
        assert max(abs(float(equation(np.array(after.witness)))) for equation in family.equations) < 1e-8


def test_a_posed_family_tells_what_is_lost_where_it_stands() -> None:
    found = shipped("ur5")
    before = worst(found, found.families[0])
    family = pose_witness(found.robot, found.task, before)
    assert family.witness != before.witness
    lost = lost_directions(found.robot, np.array(family.witness), found.task, 1)
    assert abs(float((lost @ family.lost_directions.T).item())) == pytest.approx(1.0)
    assert not np.allclose(family.lost_directions, before.lost_directions)


def test_an_example_of_two_families_is_given_up_for_one_of_its_own() -> None:
    """PA-10: axes 1 and 3 aligned, and the arm stretched as well, in a posture that has no other fault."""
    found = shipped("pa10")
    family = next(one for one in found.families if one.id == "k1.f2")
    both = replace(family, witness=tuple(0.0 if i == 3 else x for i, x in enumerate(family.witness)))
    after = pose_witness(found.robot, found.task, both, found.families)
    assert abs(np.sin(after.witness[3])) > 0.1
    assert family.system.zero(np.array([after.witness])).all()


def test_the_first_joint_counts_twice_in_how_far_an_arm_is_turned() -> None:
    robot = open_robot("planar3r")
    q = np.array([[np.pi / 2, 0.0, 0.0], [0.0, -np.pi / 2, 0.0], [0.0, 0.0, 0.0]])
    first, second, none = _turned_share(robot, q)
    assert (first, second, none) == (pytest.approx(1.0), pytest.approx(0.5), 0.0)


def test_a_family_of_rank_zero_is_posed_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """The tip of a 2R arm stands still along x where both joints' columns have no x: σ₁ itself is zero there."""
    found = rankdrop.analyze(open_robot("planar2r"), task="vx", starts=200)
    family = found.families[0]
    assert found.generic_rank == family.corank == 1
    monkeypatch.setattr(pictured, "_WORTH", -10.0)  # wherever it goes
    after = pose_witness(found.robot, found.task, replace(family, witness=(9.0, 9.0)))
    assert after.witness != (9.0, 9.0)
    assert singular_values(found.robot, after.witness, found.task)[0] <= 1e-9


@pytest.mark.shipped
@pytest.mark.parametrize("name", ["ur5", "puma560", "kr16"])
def test_what_is_printed_is_what_is_drawn(name: str) -> None:
    """Witnesses of shipped analyses and conditions stand where `pose_witness` would put them: pictures keep them."""
    found = shipped(name)
    exactly = known_conditions(found.robot, found.task)
    assert exactly is not None
    for family in found.families:
        assert pose_witness(found.robot, found.task, family, found.families) == family
    again = posed_exactly(found.robot, found.task, exactly.families)
    assert [one.witness for one in again] == [one.witness for one in exactly.families]
    good = fault(found.robot, [family.witness for family in found.families]) < 0.5
    assert good.sum() >= len(good) - 1


@pytest.mark.by_hand
def test_an_analysis_made_now_has_its_witnesses_in_good_postures(monkeypatch: pytest.MonkeyPatch) -> None:
    arm = open_robot("puma560")
    found = rankdrop.analyze(arm, starts=300, exact="off")
    good = fault(arm, [family.witness for family in found.families])
    monkeypatch.setattr("rankdrop.verbs.analyze.pose_witness", lambda robot, task, family, others: family)
    plain = rankdrop.analyze(arm, starts=300, exact="off")
    assert (good < 0.5).sum() > (fault(arm, [family.witness for family in plain.families]) < 0.5).sum()
    assert found.residual().holds(found.settings.tolerances)
