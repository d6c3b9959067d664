"""Every method finds the singular set: exactly at points modulo P of every stratum, and at numeric configurations."""

from __future__ import annotations

import random
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from exact.chains import chain_of
from exact.strata import derived, holds_modulo, strata

from rankdrop.algebra.field import ModularPoint, complete, holds
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.work import Work, work_spent
from rankdrop.errors import OptionError
from rankdrop.exact import methods
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.arm.verify import random_points, rank_check
from rankdrop.exact.conjunctions import SetDerivation
from rankdrop.exact.derivation import _too_long
from rankdrop.exact.method_reason import MethodReason
from rankdrop.exact.methods import METHODS, derive
from rankdrop.exact.tree import rank_tree
from rankdrop.families.points import cloud
from rankdrop.local.block import singular_values
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.text.by_hand import Words, steps_of
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


def general_7r(*twists: float) -> Robot:
    """Seven turning joints, every offset there; twists [°]."""
    rows = [(0.11 + 0.03 * i, np.deg2rad(twist), 0.2 + 0.07 * i, 0) for i, twist in enumerate(twists)]
    return from_dh(rows, convention="standard")


RIGHT = (-90, 90, -90, 90, -90, 90, -90)


@pytest.mark.by_hand
@pytest.mark.parametrize("method", ["determinant", "cofactors", "reciprocity"])
def test_a_7r_arm_with_every_offset_has_its_family(method: str) -> None:
    arm = general_7r(*RIGHT)
    found = conditions(arm, coranks=1, method=method, points=100, special=False, seconds=300.0)  # reciprocity needs 90
    assert len(found.families) == 1
    assert found.verified
    assert found.explained.agree == found.explained.tested > 0


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
