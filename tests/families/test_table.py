"""The pipeline on arms with known answers: rows, soundness, completeness, and that nothing is hidden."""

from __future__ import annotations

from dataclasses import replace
from math import atan2, pi, radians

import numpy as np
import pytest
from known.truths import PA10_TABLES

from rankdrop.families import fit as fit_module
from rankdrop.families.record import Check, Family
from rankdrop.families.searching import search
from rankdrop.families.soundness import soundness
from rankdrop.families.table import families
from rankdrop.formula.equation import Equation, System
from rankdrop.local.block import singular_values
from rankdrop.problem import Problem
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

STRAIGHT, SQUARE = {0.0, pi}, {pi / 2, -pi / 2}


def table(name, corank, starts=400, seed=0, **options):
    robot = open_robot(name) if isinstance(name, str) else name
    return families(search(robot, corank, starts=starts, seed=seed, **options), seed=seed)


def pins(family: Family) -> dict:
    return {pinned.number: set(pinned.values) for pinned in family.pinned}


def coefficients(equation: Equation) -> dict:
    return {(t.kind, t.harmonics): t.coefficient for t in equation.terms}


def random_arm(n, seed):
    rng = np.random.default_rng(seed)
    rows = [(rng.uniform(-1, 1), rng.uniform(-pi, pi), rng.uniform(-1, 1), 0.0) for _ in range(n)]
    return from_dh(rows, convention="standard", name=f"random{n}r")


PA10 = {
    corank: sorted(
        ({joint: set(values) for joint, values in row.items()} for row in rows), key=lambda row: (len(row), sorted(row))
    )
    for corank, rows in PA10_TABLES.items()
}
"""AM Tables 3, 4 and 5 in the order of the product: large dimension first."""


@pytest.mark.parametrize("corank", [1, 2, 3])
def test_pa10_has_exactly_the_rows_of_am_tables_3_to_5(corank):
    found = table("pa10", corank)
    assert [pins(family) for family in found.families] == PA10[corank]
    assert [family.dimension for family in found.families] == [7 - len(row) for row in PA10[corank]]
    assert all(family.soundness.holds and family.named for family in found.families)
    share = found.summary.completeness
    assert share.tested >= 1000
    assert share.agree == share.tested


def test_pa10_has_nothing_at_corank_4():
    found = table("pa10", 4)
    assert found.families == ()
    assert found.summary.completeness.tested == 0
    assert found.summary.unseen.estimate == 0.0
    assert found.summary.near_misses == 400


def test_puma_conditions_have_the_coefficients_of_its_determinant():
    """det = a2·s5·(d4c3 + a3s3)(a2c2 + a3c23 − d4s23)."""
    a2, a3, d4 = 0.4318, 0.0203, 0.4318
    shoulder, elbow, wrist = table("puma560", 1).families
    got = coefficients(shoulder.equations[0])
    want = {("cos", (0, 2, 0, 0, 0, 0)): a2, ("cos", (0, 2, 2, 0, 0, 0)): a3, ("sin", (0, 2, 2, 0, 0, 0)): -d4}
    assert got.keys() == want.keys()
    np.testing.assert_allclose([got[key] / want[key] for key in want], got[("cos", (0, 2, 0, 0, 0, 0))] / a2, rtol=1e-9)
    np.testing.assert_allclose(sorted(elbow.pinned[0].values), sorted([atan2(-d4, a3), atan2(d4, -a3)]), atol=1e-9)
    assert pins(wrist) == {5: STRAIGHT}


def test_ur5_conditions_have_the_coefficients_of_its_determinant():
    shoulder, elbow, wrist = table("ur5", 1).families
    got = coefficients(shoulder.equations[0])
    ratio = got[("cos", (0, 2, 2, 0, 0, 0))] / got[("cos", (0, 2, 0, 0, 0, 0))]
    assert ratio == pytest.approx(0.39225 / 0.425, rel=1e-9)
    assert abs(got[("sin", (0, 2, 2, 2, 0, 0))]) == pytest.approx(0.09465 / 0.425, rel=1e-9)
    assert pins(elbow) == {3: STRAIGHT}
    assert pins(wrist) == {5: STRAIGHT}


@pytest.mark.spread(5)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "corank", "dimensions"),
    [
        ("scara", 1, [3]),
        ("planar3r", 1, [2]),
        ("planar2r", 1, [1]),
        ("anthropomorphic", 1, [5, 5, 5]),
        ("almarkhi4", 1, [2]),
        ("puma560", 2, [4, 3, 3]),
        ("canadarm2", 3, [2]),
        ("panda", 2, [3, 2, 2]),
    ],
)
def test_known_dimensions_and_full_completeness(name, corank, dimensions):
    found = table(name, corank)
    assert [family.dimension for family in found.families] == dimensions
    assert all(family.named and family.soundness.holds for family in found.families)
    assert found.summary.completeness.agree == found.summary.completeness.tested >= 1000


@pytest.mark.by_hand
def test_canadarm2_families_of_kg_with_eq_26_in_half_angles():
    """KG's five families; eq. 15 splits by θ4 = 0, π, and at θ4 = π gives off θ3 + θ5 = 0, on which D vanishes."""
    found = table("canadarm2", 1, starts=1500)
    assert found.summary.completeness.agree == found.summary.completeness.tested
    by_pins = [(pins(family), family.coupled) for family in found.families]
    assert ({2: STRAIGHT, 6: STRAIGHT}, ()) in by_pins
    assert ({2: STRAIGHT}, (3, 4, 5)) in by_pins
    assert ({6: STRAIGHT}, (3, 4, 5)) in by_pins
    assert ({4: {0.0}}, (2, 3, 5, 6)) in by_pins
    assert ({4: {pi}}, (2, 3, 5, 6)) in by_pins
    (split,) = (family for family in found.families if (pins(family), family.coupled) == ({4: {pi}}, (3, 5)))
    assert split.soundness.holds
    (eq26,) = (family for family in found.families if not family.pinned)
    assert eq26.equations[0].text() == "cos((q3-q5)/2)"
    got = coefficients(eq26.equations[1])
    assert set(got) == {("cos", (0, 0, 0, 1, 0, 0, 0)), ("sin", (0, 0, 2, 1, 0, 0, 0))}
    ratio = got[("sin", (0, 0, 2, 1, 0, 0, 0))] / got[("cos", (0, 0, 0, 1, 0, 0, 0))]
    assert ratio == pytest.approx(-0.635 / 6.85, rel=1e-9)


def test_a_condition_that_is_a_square_is_recognised():
    """Stanford arm: det is q3²·sin θ2·sin θ5 up to a constant, D vanishes all over q3 = 0."""
    found = table("stanford", 1)
    assert sorted(str(family.equations[0]) for family in found.families) == ["q3", "sin θ2", "sin θ5"]
    assert found.summary.completeness.agree == found.summary.completeness.tested


@pytest.mark.slow
def test_generic_6r_has_one_long_equation():
    found = table(random_arm(6, 0), 1, starts=800)
    (family,) = found.families
    assert family.named
    assert family.coupled == (2, 3, 4, 5)
    assert 150 < len(family.equations[0].terms) <= 225
    assert found.summary.completeness.agree == found.summary.completeness.tested


@pytest.mark.by_hand_at("8")
@pytest.mark.slow
@pytest.mark.parametrize("n", [7, 8])
def test_generic_redundant_arms_run_to_an_honest_end(n):
    found = table(random_arm(n, 0), 1, starts=2000)
    share = found.summary.completeness
    unnamed = sum(family.explained.agree for family in found.families if not family.named)
    assert share.agree + unnamed >= share.tested >= 1000
    assert all(family.soundness.holds for family in found.families if family.named)


@pytest.mark.spread(2)
@pytest.mark.slow
@pytest.mark.parametrize(("name", "corank"), [("puma560", 2), ("ur5", 2), ("canadarm2", 2)])
def test_every_row_stands_up_to_an_independent_check(name, corank, rng):
    """Texts evaluated from random starts on the row, witness, directions: from the record alone."""
    robot = open_robot(name)
    task = resolve_task(None, robot)
    found = table(name, corank)
    for family in found.families:
        q, solved = System(family.equations).solve(rng.uniform(-pi, pi, (200, robot.n)), iterations=60)
        q = q[solved]
        assert len(q) > 30
        names = {f"q{j + 1}": q[:, j] for j in range(robot.n)}
        for equation in family.equations:
            value = eval(equation.text(), {"sin": np.sin, "cos": np.cos, "pi": pi, **names})
            np.testing.assert_allclose(value, 0, atol=1e-11)
        sigma = singular_values(robot, q, task)
        assert np.quantile(sigma[:, found.summary.rank], 0.9) < 1e-9
        at = singular_values(robot, np.array(family.witness), task)
        assert at[found.summary.rank] <= 1e-9 < 1e-4 < at[found.summary.rank - 1]
        assert family.lost_directions.shape == (corank, 6)
        assert len(family.lost_freedoms) == corank
        numbers = sorted([*pins(family), *family.free, *family.coupled])
        assert numbers == list(range(1, robot.n + 1))


@pytest.mark.by_hand
@pytest.mark.slow_at("canadarm2")
@pytest.mark.parametrize("name", ["puma560", "canadarm2", "almarkhi4"])
def test_a_broken_coefficient_is_unsound(name, rng):
    robot = open_robot(name)
    task = resolve_task(None, robot)
    found = table(name, 1)
    problem = Problem(robot, task)
    broken = 0
    for family in found.families:
        for i, equation in enumerate(family.equations):
            if len(equation.terms) == 1:
                continue
            first, *rest = equation.terms
            wrong = Equation((replace(first, coefficient=1.01 * first.coefficient), *rest))
            equations = (*family.equations[:i], wrong, *family.equations[i + 1 :])
            verdict, strangers = soundness(problem, System(equations), robot.n - family.dimension, rng)
            assert not verdict.holds
            assert len(strangers) == verdict.tested - verdict.agree
            broken += 1
    assert broken


def test_a_witness_stays_where_the_limits_are():
    """The second joint of a planar arm turns from 190° to 400° only: straight is 360° there, not 0."""
    robot = open_robot("planar3r")
    turned = replace(robot.joints[1], lower=radians(190.0), upper=radians(400.0))
    within = replace(robot, joints=(robot.joints[0], turned, robot.joints[2]))
    (family,) = table(within, 1, limits=True).families
    assert family.witness[1] == pytest.approx(2 * pi)
    (anywhere,) = table(robot, 1).families
    assert abs(anywhere.witness[1]) <= pi


def test_a_row_without_solutions_is_not_sound(rng):
    robot = open_robot("scara")
    problem = Problem(robot, resolve_task(None, robot))
    never = Equation.from_dict(
        {
            "terms": [
                {"coefficient": 1.0, "kind": "sin", "harmonics": [0, 1, 0, 0], "powers": [0] * 4, "shift": 0.0},
                {"coefficient": 2.0, "kind": "cos", "harmonics": [0] * 4, "powers": [0] * 4, "shift": 0.0},
            ]
        }
    )
    verdict, _ = soundness(problem, System((never,)), 1, rng)
    assert verdict == Check(0, 0)
    assert not verdict.holds


@pytest.mark.slow
def test_what_cannot_be_fitted_is_shown_without_a_name(monkeypatch):
    monkeypatch.setattr(fit_module, "fitted_equations", lambda source, work: None)
    found = table("puma560", 1)
    share = found.summary.completeness
    (unnamed,) = (family for family in found.families if not family.named)
    assert unnamed.equations == ()
    assert unnamed.dimension == 5
    assert unnamed.free == (1, 4, 5, 6)
    assert unnamed.coupled == (2, 3)
    assert unnamed.explained.agree == share.tested - share.agree > 0
    assert unnamed.soundness == Check(0, 0)
    robot = open_robot("puma560")
    assert singular_values(robot, np.array(unnamed.witness), resolve_task(None, robot))[5] <= 1e-9


def test_within_limits_no_value_outside_them_is_claimed():
    found = table("iiwa14", 1, limits=True)
    assert [pins(family) for family in found.families] == [
        {4: {0.0}}, {2: {0.0}, 3: SQUARE}, {2: {0.0}, 6: {0.0}}, {5: SQUARE, 6: {0.0}},
    ]  # fmt: skip
    assert found.summary.completeness.agree == found.summary.completeness.tested
    robot = open_robot("iiwa14")
    for family in found.families:
        assert ((robot.lower <= family.witness) & (family.witness <= robot.upper)).all()


def test_fresh_points_given_are_the_ones_counted():
    robot = open_robot("pa10")
    fresh = search(robot, 1, starts=137, seed=99)
    found = families(search(robot, 1, starts=300), fresh=fresh)
    assert found.summary.completeness.tested == len(fresh.converged)
    assert all(family.explained.tested == len(fresh.converged) for family in found.families)


@pytest.mark.by_hand
def test_same_seed_same_table_and_progress_rises():
    steps: list[tuple[int, int]] = []
    cloud = search(open_robot("ur5"), 2, starts=300)
    one = families(cloud, seed=3, progress=lambda done, total: steps.append((done, total)))
    other = families(cloud, seed=3)
    assert [(f.equations, f.witness, f.explained, f.name) for f in one.families] == [
        (f.equations, f.witness, f.explained, f.name) for f in other.families
    ]
    assert one.summary == other.summary
    assert [done for done, _ in steps] == sorted(done for done, _ in steps)
    assert steps[-1] == (100, 100)


def test_few_points_are_enough_for_the_pieces_they_meet():
    """Symmetry completes value sets: 40 points, 14 combinations."""
    found = table("pa10", 1, starts=40)
    assert [pins(family) for family in found.families] == PA10[1]


def test_a_helical_joint_enters_through_waves_and_powers():
    robot = open_robot("puma560")
    joints = list(robot.joints)
    screw = joints[2].screw + 0.05 * np.concatenate([joints[2].screw[3:], np.zeros(3)])
    joints[2] = replace(joints[2], kind="helical", screw=screw)
    found = table(replace(robot, joints=tuple(joints), name="puma, joint 3 helical"), 1, starts=800)
    assert found.summary.completeness.agree == found.summary.completeness.tested
    assert [family.dimension for family in found.families] == [5, 5, 5]
