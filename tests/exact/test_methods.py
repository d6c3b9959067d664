"""Every method finds the singular set: exactly at points modulo P of every stratum, and at numeric configurations."""

from __future__ import annotations

import random
from collections.abc import Sequence
from functools import cache
from itertools import combinations
from time import process_time
from types import SimpleNamespace

import numpy as np
import pytest
from exact.chains import SRS, chain_of

from rankdrop.algebra.field import ModularPoint, P, bivariate, common_zeros, complete, holds, roots, univariate
from rankdrop.algebra.polynomial import SIMPLE, Equality
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.work import Work, work_spent
from rankdrop.errors import OptionError
from rankdrop.exact import methods
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.arm.verify import random_points, rank_check
from rankdrop.exact.conjunctions import Conjunction, SetDerivation
from rankdrop.exact.derivation import _too_long
from rankdrop.exact.method_reason import MethodReason
from rankdrop.exact.methods import METHODS, derive
from rankdrop.exact.tree import rank_tree
from rankdrop.families.points import cloud
from rankdrop.kinematics import task_jacobian
from rankdrop.local.block import sample, singular_values
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.text.by_hand import Words, notes_of, steps_of
from rankdrop.units import out_of_units
from rankdrop.verbs.conditions import conditions

ARMS = ["ur5", "puma560", "anthropomorphic", "stanford", "scara", "planar3r", "pa10", "canadarm2"]
WRIST = {"puma560", "anthropomorphic", "stanford", "pa10"}
SLOW = {
    ("canadarm2", "singular_vector"), ("ur5", "singular_vector"), ("pa10", "singular_vector"),
}  # fmt: skip
PAIRS = [
    pytest.param(name, method, marks=pytest.mark.slow) if (name, method) in SLOW else (name, method)
    for name in ARMS
    for method in METHODS
    if method != "decomposition" or name in WRIST
]


@cache
def derived(name: str, method: str) -> SetDerivation:
    return derive(chain_of(name), method, 60.0)


def vanishes(equality: Equality, ring: Ring, point: ModularPoint) -> bool:
    parts = equality.atoms if equality.whole is None else (equality.whole,)
    return any(holds(ring, part, point) for part in parts)


def holds_at(condition: Conjunction, ring: Ring, point: ModularPoint) -> bool:
    """Whether a condition holds at a point modulo P, exactly."""
    unequal = (any(not vanishes(equality, ring, point) for equality in group) for group in condition.unequal)
    return all(vanishes(equality, ring, point) for equality in condition.equal) and all(unequal)


def holds_modulo(found: SetDerivation, points: Sequence[ModularPoint]) -> tuple[bool, ...]:
    """Whether one of the conditions holds at each of the points modulo P, exactly."""
    return tuple(any(holds_at(one, found.ring, point) for one in found.conditions) for point in points)


@cache
def strata(name: str, count: int = 200) -> tuple[tuple[ModularPoint, ...], tuple[bool, ...]]:
    """Points modulo P with joints at simple angles or where one or two minors vanish, and whether they are singular."""
    chain, rng = chain_of(name), random.Random(7)
    ring, m = chain.ring, chain.task.m
    points: list[ModularPoint] = []
    subsets = list(combinations(chain.columns, m))
    while len(points) < count:
        pins = {j: rng.choice(SIMPLE) for j in ring.revolute if rng.random() < rng.choice([0.0, 0.3, 0.6])}
        values = ModularPoint({name: rng.randrange(1, P) for name in ring.names if name not in {f"t{j}" for j in pins}})
        moving = [name for name in ring.names[: ring.moving] if name in values]
        rng.shuffle(moving)
        chosen = rng.sample(subsets, min(2, len(subsets)))
        minors = [ring.determinant([[column[row] for column in subset] for row in range(m)]) for subset in chosen]
        found = [ring.to_half(p).f for p in (ring.at(p, pins) for p in minors) if p != 0]
        if found and moving and rng.random() < 0.5:
            zeros = roots(univariate(ring, found[0], moving[0], values))
            if zeros:
                values[moving[0]] = rng.choice(zeros)
        elif len(found) == 2 and len(moving) > 1:
            x, y = moving[:2]
            pair = next(common_zeros(*(bivariate(ring, f, x, y, values) for f in found)), None)
            if pair is not None:
                values[x], values[y] = pair
        point = complete(ring, values, pins)
        if point is not None:
            points.append(point)
    return tuple(points), tuple(rank < min(m, chain.n) for rank in rank_check(chain, points))


@pytest.mark.spread(5)
@pytest.mark.slow
@pytest.mark.by_hand_at(
    "planar3r-determinant", "puma560-singular_vector", "scara-determinant", "canadarm2-cofactors", "scara-cofactors",
    "scara-reciprocity", "scara-elementary", "planar3r-elementary",
)  # fmt: skip
@pytest.mark.by_hand_at(
    "ur5-singular_vector",
    "pa10-reciprocity",
    "pa10-singular_vector",
    "canadarm2-determinant",
    "canadarm2-reciprocity",
    "canadarm2-singular_vector",
)
@pytest.mark.parametrize(("name", "method"), [*PAIRS, pytest.param("gen3", "cofactors", marks=pytest.mark.slow)])
def test_the_conditions_hold_exactly_where_the_rank_drops_modulo_p(name: str, method: str) -> None:
    found = derived(name, method)
    assert found.complete
    assert not found.generic
    points, singular = strata(name)
    assert 15 <= sum(singular) <= len(points) - 15, "both kinds of points are needed"
    assert holds_modulo(found, points) == singular


@pytest.mark.spread(14)
@pytest.mark.slow
@pytest.mark.by_hand_at(
    "canadarm2-determinant", "canadarm2-reciprocity", "canadarm2-singular_vector", "pa10-singular_vector",
    "ur5-singular_vector",
)  # fmt: skip
@pytest.mark.parametrize(("name", "method"), PAIRS)
def test_every_numerically_found_singular_configuration_satisfies_a_condition(name: str, method: str) -> None:
    found = derived(name, method)
    points = cloud(found.chain.robot, found.chain.task, 1, 100)
    assert len(points.q) >= 100
    assert found.holds(points.q).all()


@pytest.mark.slow_at("pa10-reciprocity")
@pytest.mark.by_hand_at(
    "canadarm2-determinant", "canadarm2-reciprocity", "canadarm2-singular_vector", "ur5-singular_vector"
)
@pytest.mark.parametrize(("name", "method"), PAIRS)
def test_no_regular_configuration_satisfies_a_condition(name: str, method: str) -> None:
    found = derived(name, method)
    rng = np.random.default_rng(2)
    q = rng.uniform(-3, 3, (150, found.chain.n))
    pinned = rng.random(q.shape) < 0.3
    q[pinned] = rng.integers(-1, 3, pinned.sum()) * (np.pi / 2)
    # a sum of squares is as small as the square of σ: it cannot tell 1e-3 from zero
    regular = singular_values(found.chain.robot, q, found.chain.task).min(axis=1) > 0.02
    assert regular.sum() > 50
    assert not found.holds(q[regular]).any()


@pytest.mark.parametrize("name", ["ur5", "scara", "canadarm2"])
def test_decomposition_refuses_an_arm_without_a_spherical_wrist_and_says_why(name: str) -> None:
    with pytest.raises(OptionError, match=r"spherical wrist.*d[56] = |all six rows"):
        derive(chain_of(name), "decomposition")


def test_the_arm_and_the_wrist_of_the_pa10_come_apart() -> None:
    found = derived("pa10", "decomposition")
    keys = [[{atom.key for atom in equality.atoms} for equality in c.equal] for c in found.conditions]
    assert keys[:2] == [[{"θ4=0"}], [{"θ4=pi"}]]
    assert all({"θ6=0"} in c or {"θ6=pi"} in c for c in keys[3:])


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("scara", {"θ2=0", "θ2=pi"}),
        ("planar3r", {"θ2=0", "θ2=pi"}),
        ("stanford", {"θ2=0", "θ2=pi", "θ5=0", "θ5=pi", "q3"}),
    ],
)
def test_known_determinants(name: str, expected: set[str]) -> None:
    keys = {atom.key for c in derived(name, "determinant").conditions for atom in c.equal[0].atoms}
    assert keys == expected


def test_puma_has_elbow_shoulder_and_wrist() -> None:
    found = derived("puma560", "determinant")
    parts = [equality for c in found.conditions for equality in c.equal]
    assert [len(part.atoms) for part in parts] == [1, 1, 1, 1]
    pins = {part.atoms[0].key for part in parts if part.atoms[0].is_pin}
    assert pins == {"θ5=0", "θ5=pi"}
    assert {str(f) for f in found.assumptions} == {"a2"}


def test_the_determinant_of_a_redundant_arm_is_its_minors_that_vanish_together() -> None:
    """det(J Jᵀ) is the sum of their squares: over the reals no more is needed, and nothing is left."""
    found = derived("canadarm2", "determinant")
    assert found.complete
    assert found.conditions == derived("canadarm2", "cofactors").conditions
    assert any("the sum of the squares of 7 minors" in note for note in notes_of(found))
    assert any("without a change of sign" in note for note in notes_of(found))


def test_a_redundant_arm_has_as_many_cofactors_as_choices_of_columns() -> None:
    found = derived("canadarm2", "cofactors")
    assert found.sizes["minors"] == 7
    assert len(found.conditions[-1].equal) == 7


@pytest.mark.by_hand
def test_the_reciprocal_screw_of_canadarm2_vanishes_where_its_notes_say() -> None:
    """KG section 1: the expression of the screw is invalid where all of its elements vanish."""
    found = derived("canadarm2", "reciprocity")
    assert found.sizes["exceptional"] > 0
    notes = notes_of(found)
    place = next(i for i, note in enumerate(notes) if note.startswith("in general: the screw reciprocal to"))
    assert "all six elements vanish, and it says nothing, where θ4 = 0 or π, or where θ6 = 0" in notes[place + 1]
    assert found.sizes["choices"] > 1
    first = found.conditions[0]
    assert first.unequal, "the first choice holds only where its screw does not vanish"


@pytest.mark.by_hand
@pytest.mark.parametrize(("theta4", "singular"), [("0", ()), ("π", ("θ3 + θ5 = 0 and (θ6 = 0 or π)",))])
def test_the_screw_of_kg_vanishes_where_c5_and_s6_do(theta4: str, singular: tuple[str, ...]) -> None:
    """KG section 1, of the screw reciprocal to joints 2 to 7 where s4 = 0: invalid where s6 = 0 and c5 = 0."""
    found = derive(chain_of("canadarm2"), "reciprocity", frame=5, basic=(2, 3, 4, 5, 6, 7))
    notes = notes_of(found)
    place = next(i for i, note in enumerate(notes) if note.startswith(f"θ4 = {theta4}: the screw reciprocal to"))
    assert "joints 2, 3, 4, 6, 7" in notes[place]
    for said in ("θ5 = ±π/2 and (θ6 = 0 or π)", *singular):
        assert said in notes[place + 1]


def test_basic_screws_are_chosen_for_reciprocity_alone() -> None:
    with pytest.raises(OptionError, match="chosen for another method"):
        derive(chain_of("canadarm2"), "cofactors", basic=(2, 3, 4, 5, 6, 7))
    with pytest.raises(OptionError, match="six different joints"):
        derive(chain_of("canadarm2"), "reciprocity", basic=(2, 3, 4, 5, 6, 8))


@pytest.mark.slow
def test_without_the_exceptional_cases_reciprocity_misses_singularities() -> None:
    found = derived("canadarm2", "reciprocity")
    points, singular = strata("canadarm2")
    alone = [holds_at(found.conditions[0], found.ring, point) for point in points]
    assert sum(alone) < sum(singular)


CORANKS = [
    (name, corank) for name, last in [
        ("planar3r", 2), ("scara", 2), ("anthropomorphic", 3), ("puma560", 2), ("ur5", 3), ("stanford", 2), ("pa10", 3)
    ] for corank in range(2, last + 1)
]  # fmt: skip


@cache
def reciprocal(name: str, corank: int) -> SetDerivation:
    return derive(chain_of(name), "reciprocity", 60.0, corank=corank)


@cache
def ranked(name: str) -> tuple[tuple[ModularPoint, ...], tuple[int, ...]]:
    """Points modulo P on every set of the rank tree and on other strata, and their ranks."""
    chain, rng = chain_of(name), random.Random(3)
    found = [drop.piece.point(rng) for drop in rank_tree(chain, Work(60.0)).drops]
    points = (*(point for point in found if point is not None), *strata(name, 120)[0])
    return points, rank_check(chain, points)


@pytest.mark.spread(4)
@pytest.mark.slow
@pytest.mark.by_hand_at("pa10-2", "pa10-3")
@pytest.mark.parametrize(("name", "corank"), CORANKS)
def test_reciprocal_screws_hold_exactly_where_the_corank_is_reached_modulo_p(name: str, corank: int) -> None:
    found = reciprocal(name, corank)
    assert found.complete
    assert not found.generic
    points, ranks = ranked(name)
    reached = tuple(rank <= found.chain.task.m - corank for rank in ranks)
    assert any(reached) == bool(found.conditions)
    assert holds_modulo(found, points) == reached


@pytest.mark.spread(3)
@pytest.mark.slow
@pytest.mark.by_hand_at("pa10-2", "pa10-3")
@pytest.mark.parametrize(("name", "corank"), CORANKS)
def test_reciprocal_screws_hold_at_configurations_found_of_their_corank_alone(name: str, corank: int) -> None:
    found = reciprocal(name, corank)
    robot, task = found.chain.robot, found.chain.task
    met, lower = cloud(robot, task, corank, 40), cloud(robot, task, corank - 1, 40)
    assert bool(len(met.q)) == bool(found.conditions)
    if len(met.q):
        assert found.holds(met.q).all()
    q = np.concatenate([np.random.default_rng(2).uniform(-3, 3, (50, found.chain.n)), lower.q])
    clear = singular_values(robot, q, task)[:, task.m - corank] > 0.02
    assert clear.sum() > 60
    assert not found.holds(q[clear]).any()


def test_without_the_exceptional_cases_reciprocal_screws_miss_configurations(monkeypatch: pytest.MonkeyPatch) -> None:
    """The planted fault: nothing follows where the chosen minor vanishes, θ2 = ±π/2 of PUMA's first joints."""
    monkeypatch.setattr(SetDerivation, "branches", lambda *_: [])
    found = derive(chain_of("puma560"), "reciprocity", corank=2)
    met = cloud(found.chain.robot, found.chain.task, 2, 40)
    assert 0 < found.holds(met.q).sum() < len(met.q)


def test_reciprocal_screws_of_corank_two_are_written_with_the_minor_that_makes_them_independent() -> None:
    (step,) = steps_of(chain_of("scara"), reciprocal("scara", 2))
    assert step.title == "Method: reciprocity, corank 2"
    assert step.lines[1:] == (
        "in general: screws reciprocal to joints 1, 2:",
        "  (a1, 0, 0, a1 a2 s2)",
        "  (0, 0, −a1, 0)",
        "  independent where |$1 $2| of rows vy wz is not zero: a1",
    )


@pytest.mark.parametrize(("method", "corank"), [("reciprocity", 0), ("reciprocity", 5), ("cofactors", 2)])
def test_a_corank_that_a_method_does_not_derive_is_refused(method: str, corank: int) -> None:
    with pytest.raises(OptionError, match="corank"):
        derive(chain_of("scara"), method, corank=corank)


def test_the_corank_of_all_rows_is_that_of_no_motion_at_all() -> None:
    """No joint is chosen: every screw is reciprocal to none, and all entries have to vanish."""
    found = derive(exact_chain(open_robot("planar3r"), "vx"), "reciprocity")
    assert found.holds([[0.0, 0.0, 0.0], [0.0, np.pi, 0.0], [0.3, 0.0, 0.0]]).tolist() == [True, True, False]
    deeper = derive(chain_of("planar3r"), "reciprocity", corank=3)
    assert deeper.complete
    assert deeper.conditions == []


@pytest.mark.parametrize("method", METHODS)
def test_a_time_limit_holds_and_what_is_left_is_told(method: str) -> None:
    before = work_spent()
    found = derive(chain_of("pa10"), method, 0.0)
    assert work_spent() - before < 1.0
    assert not found.complete
    assert found.left


@pytest.mark.parametrize("method", ["cofactors", "reciprocity", "singular_vector", "determinant"])
def test_the_limit_holds_on_an_arm_without_any_structure(method: str) -> None:
    rng = np.random.default_rng(0)
    rows = [[round(x, 3) for x in (*rng.uniform(0.1, 0.5, 1), *rng.uniform(-1.5, 1.5, 1), 0.2, 0.0)] for _ in range(7)]
    chain = exact_chain(from_dh(rows, convention="standard"))
    assert len(chain.columns) == 7
    before = work_spent()
    found = derive(chain, method, 0.02)
    assert work_spent() - before < 2.0
    assert not found.complete
    assert found.left


@pytest.mark.slow
def test_a_case_analysis_that_is_cut_short_keeps_what_it_found() -> None:
    found = derive(chain_of("canadarm2"), "singular_vector", 0.1)
    assert not found.complete
    assert found.generic
    assert "cases" in str(found.left[0])
    points, singular = strata("canadarm2")
    held = holds_modulo(found, points)
    assert any(held)
    assert all(is_singular for is_singular, holds in zip(singular, held, strict=True) if holds)


def test_a_long_determinant_without_time_is_kept_whole_and_said_to_be_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rankdrop.algebra.ring.Ring.factors_within", lambda *_: None)
    found = derive(chain_of("puma560"), "determinant", 10.0)
    assert list(map(str, found.left)) == ["determinant: factors of 1 polynomial"]
    points, singular = strata("puma560")
    assert holds_modulo(found, points) == singular


@pytest.mark.slow
def test_minors_that_are_not_factored_are_conditions_with_a_zero_of_each(monkeypatch: pytest.MonkeyPatch) -> None:
    """The set is complete without factors; what is open is said: terms, degree, and where a minor vanishes."""
    monkeypatch.setattr("rankdrop.algebra.ring.Ring.factors_within", lambda *_: None)
    chain = chain_of("canadarm2")
    found = derive(chain, "determinant", 10.0)
    points, singular = strata("canadarm2", 30)
    assert holds_modulo(found, points) == singular
    assert found.complete
    facts = [note for what, note in found.notes if what == "unfactored"]
    minors = {six: chain.ring.determinant([[chain.columns[j - 1][i] for j in six] for i in range(6)])
              for six in combinations(range(1, 8), 6)}  # fmt: skip
    assert [one["choice"][1] for one in facts] == [six for six, minor in minors.items() if minor != 0]
    for one in facts:
        columns = task_jacobian(chain.robot, np.array(one["zero"]), chain.task)[:, [j - 1 for j in one["choice"][1]]]
        assert abs(np.linalg.det(columns)) < 1e-9
        assert abs(np.linalg.det(columns / np.linalg.norm(columns, axis=0))) < 1e-9
    said = [line for line in notes_of(found) if "was not factored" in line]
    assert len(said) == len(facts)
    assert said[0].startswith(f"|$1 $2 $3 $4 $5 $6| = 0, of {facts[0]['terms']} terms and degree {facts[0]['degree']} ")


def test_long_polynomials_are_not_factored_where_little_work_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    chain = chain_of("puma560")
    p = chain.ring.determinant([[column[row] for column in chain.columns] for row in range(6)])
    assert chain.ring.factors_within(p, 0.0) == chain.ring.factor(p)
    monkeypatch.setattr("rankdrop.algebra.ring._SHORT", 0)
    assert chain.ring.factors_within(p, 0.0) is None
    assert chain.ring.factors_within(p, 20.0) == chain.ring.factor(p)
    monkeypatch.setattr("rankdrop.algebra.ring._LASTING", 0)
    assert chain.ring.factors_within(p, 20.0) is None


@pytest.mark.parametrize("method", ["determinant", "cofactors", "singular_vector"])
def test_an_arm_of_fewer_joints_than_rows(method: str) -> None:
    chain = exact_chain(open_robot("scara"), "position")
    found = derive(chain, method)
    points = random_points(chain, 30, seed=4)
    for point in points[:15]:
        point.update(s2=0, c2=1, t2=0)
    assert holds_modulo(found, points) == tuple(rank < 3 for rank in rank_check(chain, points))


def test_a_rank_that_is_nowhere_full_is_refused() -> None:
    chain = exact_chain(open_robot("planar3r"), "vx,vz,wz")
    with pytest.raises(OptionError, match=r"sees a rank that is not full"):
        derive(chain, "cofactors")


def test_reciprocity_refuses_an_arm_of_fewer_joints_than_rows() -> None:
    chain = exact_chain(open_robot("planar2r"), "vx,vy,wz")
    with pytest.raises(OptionError, match=r"fewer joints"):
        derive(chain, "reciprocity")


def test_a_polynomial_is_evaluated_with_its_own_degrees_where_joints_stand_at_pi() -> None:
    """t1 t2 + 1 stands for cos((θ1 − θ2)/2), and t1 + t2 for sin((θ1 + θ2)/2)."""
    ring = Ring([1, 2])
    difference, total = ring.atom(ring.t[1] * ring.t[2] + 1), ring.atom(ring.t[1] + ring.t[2])
    one, both = complete(ring, ModularPoint(), {1: "0", 2: "pi"}), complete(ring, ModularPoint(), {1: "pi", 2: "pi"})
    assert one is not None
    assert both is not None
    assert [holds(ring, difference, one), holds(ring, difference, both)] == [True, False]
    assert [holds(ring, total, one), holds(ring, total, both)] == [False, True]


def test_conditions_in_words() -> None:
    words = Words(chain_of("puma560").ring)
    texts = [words.conjunction(c) for c in derived("puma560", "decomposition").conditions]
    assert texts == ["a3 s3 + d4 c3 = 0", "a2 c2 + a3 c23 − d4 s23 = 0", "θ5 = 0", "θ5 = π"]


def test_factors_of_one_polynomial_are_joined_by_or_and_polynomials_by_and() -> None:
    words = Words(chain_of("pa10").ring)
    texts = [words.conjunction(c) for c in derived("pa10", "cofactors").conditions]
    assert texts[:2] == ["θ4 = 0", "θ4 = π"]
    assert texts[2].startswith("(θ2 = 0 or π or θ5 = ±π/2) and (θ3 = ±π/2 or θ6 = 0 or π) and ")


@pytest.mark.slow
def test_what_must_not_vanish_and_what_is_too_long_to_read_is_told_in_words() -> None:
    words = Words(chain_of("canadarm2").ring)
    reciprocity = words.conjunction(derived("canadarm2", "reciprocity").conditions[0])
    assert "a s345 + d c3 + d c34 = 0, where not all of these hold: θ4 = 0 or π" in reciprocity
    cofactors = words.conjunction(derived("canadarm2", "cofactors").conditions[0])
    assert "a polynomial of 392 half-angle terms = 0" in cofactors


def test_an_unknown_method_is_refused_with_the_list() -> None:
    with pytest.raises(OptionError, match=r"determinant, cofactors, decomposition, reciprocity, singular_vector, elem"):
        derive(chain_of("scara"), "guess")


def test_the_docstring_names_every_method() -> None:
    assert methods.__doc__ is not None
    assert all(f"| {name} |" in methods.__doc__ for name in METHODS)


@pytest.mark.by_hand
def test_a_sum_of_squares_raises_no_false_alarm_near_singularities() -> None:
    """Of 20,000 random configurations some lie close to singular ones: det(J Jᵀ) is tiny there, and not zero."""
    rows = [*SRS[:4], (0, -np.pi / 2, 0.35, 0), *SRS[5:]]
    chain = exact_chain(from_dh(rows, convention="standard"))
    found = derive(chain, "determinant")
    assert found.complete
    q = out_of_units(chain.robot, sample(chain.own, chain.own_task, 20_000, 1))
    sigma = singular_values(chain.robot, q, chain.task)[:, 5]
    assert (sigma < 0.01).sum() > 100
    assert not found.holds(q[sigma > 1e-3]).any()
    met = cloud(chain.own, chain.own_task, 1, 100)
    assert found.holds(out_of_units(chain.robot, met.q)).all()


def general_7r(*twists: float) -> Robot:
    """Seven turning joints, every offset there; twists [°]."""
    rows = [(0.11 + 0.03 * i, np.deg2rad(twist), 0.2 + 0.07 * i, 0) for i, twist in enumerate(twists)]
    return from_dh(rows, convention="standard")


RIGHT = (-90, 90, -90, 90, -90, 90, -90)


@pytest.mark.slow
@pytest.mark.parametrize("twists", [RIGHT, (60, -45, 90, -30, 60, -90, 0)])
def test_the_determinant_of_a_general_7r_ends_with_seven_minors(twists: tuple[float, ...]) -> None:
    """Multiplied out it has 169,524 terms, and whether these have factors remained open."""
    before = process_time()
    found = derive(exact_chain(general_7r(*twists)), "determinant", 30.0)
    assert process_time() - before < 8.0
    assert found.complete
    assert [len(one.equal) for one in found.conditions] == [7]
    assert not any(what == "unfactored" for what, _ in found.notes)


@pytest.mark.by_hand
@pytest.mark.parametrize("method", ["determinant", "cofactors", "reciprocity"])
def test_a_7r_arm_with_every_offset_has_its_family(method: str) -> None:
    arm = general_7r(*RIGHT)
    found = conditions(arm, coranks=1, method=method, points=100, special=False, seconds=300.0)  # reciprocity needs 90
    assert len(found.families) == 1
    assert found.verified
    assert found.explained.agree == found.explained.tested > 0


@pytest.mark.parametrize(("task", "frame"), [("pose", 0), ("pose", 7), ("position", 2)])
def test_a_link_frame_that_is_none_or_of_some_rows_is_refused(task: str, frame: int) -> None:
    with pytest.raises(OptionError, match="no such link frame"):
        derive(exact_chain(open_robot("puma560"), task), "reciprocity", frame=frame)


@pytest.mark.parametrize(
    ("name", "task", "method"),
    [
        ("puma560", "position", "reciprocity"),
        ("px150", None, "determinant"),
        ("planar3r", "position", "tree"),  # the rank is full nowhere: no other method
    ],
)
def test_auto_derives_corank_1_twice_where_another_method_can(name: str, task: str | None, method: str) -> None:
    found = conditions(open_robot(name), task, points=0, coranks=1, special=False, fresh=True)
    assert (found.method, found.verified) == (method, True)
    assert ("corank 1 derived twice" in str(found)) == (method != "tree")


def test_coranks_that_no_configuration_has_are_derived_too() -> None:
    """Rows that numbers clear never lose rank: nothing is left below it."""
    chain = exact_chain(open_robot("px150"))
    assert chain.cleared_columns[1] > 0
    assert rank_tree(chain, Work(20.0)).lowest == 0
    assert rank_tree(chain, Work(20.0), lowest=4).lowest == 4


@pytest.mark.parametrize(
    ("name", "methods"),
    [("panda", ("suppression", "reciprocity", "singular-vector")), ("puma560", ())],
)
def test_methods_that_are_not_run_are_those_for_this_arm(name: str, methods: tuple[str, ...]) -> None:
    """Suppression is for seven or eight joints and all six rows; a square Jacobian has its determinant."""
    chain = chain_of(name)
    long = SimpleNamespace(piece=SimpleNamespace(equations=[range(10_000)]))
    tree = SimpleNamespace(generic_rank=6, complete=True, drops=[long])
    assert _too_long(chain, tree, MethodReason()).not_run == methods
    assert _too_long(chain, SimpleNamespace(generic_rank=6, complete=True, drops=[]), MethodReason()).not_run == ()


def _sparse(rng: np.random.Generator, rows: int, columns: int) -> np.ndarray:
    entries = rng.integers(-3, 4, (rows, columns))
    return np.where(rng.random((rows, columns)) < 0.45, entries, 0)


@pytest.mark.parametrize("shape", [(1, 1), (3, 3), (5, 5), (3, 4), (4, 6)])
def test_full_rank_is_that_of_the_blocks_and_of_the_rest(shape: tuple[int, int]) -> None:
    rng, both = np.random.default_rng(5), set()
    for _ in range(60):
        matrix = _sparse(rng, *shape)
        blocks, rest = methods._blocks(matrix.T.tolist())
        full = all(np.linalg.matrix_rank(np.array(block)) == len(block) for block in blocks)
        if rest:
            full &= np.linalg.matrix_rank(np.array(rest)) == len(rest[0])
        assert full == (np.linalg.matrix_rank(matrix) == shape[0])
        assert not (rest and shape[0] == shape[1] and full)
        both.add(full)
    assert both == {True, False}


@pytest.mark.parametrize(("name", "blocks"), [("scara", 3), ("ur5", 2), ("stanford", 2), ("irb120", 1)])
def test_elementary_transformations_leave_blocks(name: str, blocks: int) -> None:
    assert derived(name, "elementary").sizes["blocks"] == blocks
