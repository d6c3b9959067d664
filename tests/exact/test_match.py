"""Numeric and exact families have the same points; whatever is taken away from either side, or added to it, shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from rankdrop.compare.comparison import Agreement, match, solutions
from rankdrop.exact.family import ExactFamily
from rankdrop.families.linear import vanishing_on
from rankdrop.families.row import soundness
from rankdrop.family.equation import Equation, System, Term
from rankdrop.problem import Problem
from rankdrop.results.known import shipped
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.verbs.conditions import conditions

ARMS = ("pa10", "puma560", "stanford", "scara", "anthropomorphic", "planar3r")


@dataclass(frozen=True)
class Given:
    """Equations as a family of either side."""

    id: str
    corank: int
    dimension: int
    equations: tuple[Equation, ...]
    witness: tuple[float, ...]
    name: str = "given"


@cache
def derived(name: str) -> tuple[ExactFamily, ...]:
    return conditions(shipped(name).robot, method="tree", points=0, special=False).families


def held(
    name: str, rows: Sequence[Any] | None = None, families: Sequence[Any] | None = None, *, limits: bool = False,
    seed: int = 0,
) -> Agreement:
    found = shipped(name)
    rows = found.families if rows is None else rows
    families = derived(name) if families is None else families
    return match(Problem(found.robot, found.task, limits=limits), rows, families, seed=seed)


@pytest.mark.slow_at("pa10", "puma560")
@pytest.mark.parametrize("name", ARMS)
def test_two_ways_that_know_nothing_of_each_other_find_the_same_families(name: str) -> None:
    agreement = held(name)
    assert agreement.differences == ()
    assert agreement.numeric.tested == agreement.numeric.agree > 200
    assert agreement.exact.tested == agreement.exact.agree > 200
    assert [one.row for one in agreement.matches] == [row.id for row in shipped(name).families]
    assert all(one.families and not one.parts for one in agreement.matches)
    named = [family for one in agreement.matches for family in one.families]
    assert sorted(named) == sorted(family.id for family in derived(name))


@pytest.mark.slow_at("puma560", "stanford")
@pytest.mark.parametrize("name", ["stanford", "puma560"])
def test_each_exact_family_that_is_missing_is_missed(name: str) -> None:
    for gone in derived(name):
        agreement = held(name, families=[family for family in derived(name) if family is not gone])
        rows = [one.row for one in held(name).matches if one.families == (gone.id,)]
        assert rows
        said = [text for text in map(str, agreement.differences) if text.startswith(f"numeric {rows[0]} ")]
        assert len(said) == 1
        assert "on no exact family of this corank, q = (" in said[0]


@pytest.mark.slow
def test_each_row_that_is_missing_is_missed() -> None:
    rows = shipped("puma560").families
    for gone in rows:
        agreement = held("puma560", rows=[row for row in rows if row is not gone])
        assert any("on no numeric family of this corank" in text for text in map(str, agreement.differences))


@pytest.mark.slow
@pytest.mark.slow
def test_a_value_too_few_and_a_value_too_many_are_seen() -> None:
    rows = shipped("pa10").families
    for values, said, loose in (((0.0,), ["exact k1.f1"], []), ((0.0, 3.141592653589793, 1.0), [], ["k1.f1"])):
        only = vanishing_on([0, 0, 0, 1, 0, 0, 0], values, periodic=True)
        agreement = held("pa10", rows=[replace(rows[0], equations=(only,)), *rows[1:]])
        assert rows[0].name.startswith("elbow")
        assert [text.split(" (")[0] for text in map(str, agreement.differences)] == said
        assert [one.family for one in agreement.loose] == loose
        assert all(0 < one.elsewhere < one.solved for one in agreement.loose)


@pytest.mark.slow
def test_a_row_of_another_dimension_is_seen() -> None:
    rows = shipped("pa10").families
    agreement = held("pa10", rows=[replace(rows[0], dimension=5), *rows[1:]])
    assert any("dimension" in text for text in map(str, agreement.differences))


def test_a_row_whose_conditions_contradict_each_other_is_seen() -> None:
    row = shipped("planar3r").families[0]
    never = Equation((Term(1.0, "cos", (0, 0, 0), (0, 0, 0)),))
    agreement = held("planar3r", rows=[replace(row, equations=(*row.equations, never))])
    assert any("no configuration satisfies its own conditions" in text for text in map(str, agreement.differences))


def test_a_row_without_conditions_is_known_by_its_witness() -> None:
    rows = shipped("scara").families
    bare = replace(rows[0], equations=(), named=False, dimension=4)
    agreement = held("scara", rows=[bare])
    assert [one.families or one.parts for one in agreement.matches] == [("k1.f1",)]
    agreement = held("scara", rows=[replace(bare, witness=(0.1, 1.0, 0.1, 0.2))])
    assert any("numeric k1.f1" in text for text in map(str, agreement.differences))


def test_unions_are_matched_as_unions() -> None:
    """θ4 = 0 and θ4 = π apart on one side, together on the other."""
    found = shipped("pa10")
    row = found.families[0]
    apart = [
        Given(f"k1.f{k}", 1, 6, (vanishing_on([0, 0, 0, 1, 0, 0, 0], (value,), periodic=True),),
              (0.1, 0.2, 0.3, value, 0.5, 0.6, 0.7))
        for k, value in ((1, 0.0), (2, 3.141592653589793))
    ]  # fmt: skip
    one = held("pa10", rows=[row], families=apart)
    assert [(m.families, m.parts) for m in one.matches] == [(("k1.f1", "k1.f2"), ())]
    other = held("pa10", rows=apart, families=[row])
    assert [(m.families, m.parts) for m in other.matches] == [((), ("k1.f1",)), ((), ("k1.f1",))]
    assert one.differences == other.differences == ()


@pytest.mark.slow
def test_conditions_that_hold_on_more_than_the_family_are_told() -> None:
    wide = {one.family for one in held("puma560").wider}
    assert wide <= {"k2.f3"}
    wrist = [row for row in shipped("puma560").families if row.id == "k1.f3"]
    half = vanishing_on([0, 0, 0, 0, 1, 0], (0.0, 3.141592653589793, 1.0), periodic=True)
    loose = Given("k1.f1", 1, 5, (half,), (0.1, 0.1, 0.1, 0.1, 0.0, 0.2))
    agreement = held("puma560", rows=wrist, families=[loose])
    assert agreement.differences == ()
    assert [one.family for one in agreement.wider] == ["k1.f1"]
    assert 0 < agreement.wider[0].elsewhere < agreement.wider[0].solved


def test_with_limits_only_points_within_them_count() -> None:
    agreement = held("puma560", limits=True)
    assert agreement.differences == ()
    assert 0 < agreement.numeric.tested < held("puma560").numeric.tested


def test_the_same_seed_gives_the_same_answer() -> None:
    assert held("puma560", seed=3) == held("puma560", seed=3)


def test_what_is_all_but_a_zero_is_no_regular_solution() -> None:
    """Of sin θ2 · (sin⁴(θ2 − 1) + 5e-13) the value at θ2 = 1 is 4e-13, and the arm is regular there.

    Beside sin θ2 · sin(θ2 − 1), which is zero there, Newton comes to rest. Conditions of offset 7R arms do so where
    several joints are near 0 or π.
    """
    rows = shipped("planar3r").families
    both = (product_with_sine(waves_of(1)), product_with_sine(waves_of(4, 5e-13)))
    assert abs(both[1](np.array([0.3, 1.0, 0.4]))) == pytest.approx(4.2e-13, rel=0.05)
    agreement = held("planar3r", rows=[replace(rows[0], equations=both)])
    assert agreement.loose == ()
    system = System(both)
    places = np.array([[0.3, 1.0, 0.4], [0.3, 0.0, 0.4]])
    assert system.zero(places).tolist() == [False, True]
    problem = Problem(open_robot("planar3r"), resolve_task(None, open_robot("planar3r")))
    found, strangers = soundness(problem, system, 1, np.random.default_rng(0))
    assert found.tested == found.agree > 20
    assert not len(strangers)


def waves_of(power: int, plus: float = 0.0) -> dict[int, complex]:
    """sin^power(θ − 1) + plus as Σ c_k exp(i k θ)."""
    found = {0: 1.0 + 0j}
    for _ in range(power):
        step: dict[int, complex] = {}
        for k, c in found.items():
            for sign in (1, -1):
                step[k + sign] = step.get(k + sign, 0) + c * sign * np.exp(-1j * sign) / 2j
        found = step
    found[0] = found.get(0, 0) + plus
    return found


def product_with_sine(waves: dict[int, complex]) -> Equation:
    """sin θ2 · Σ c_k exp(i k θ2), real, of an arm with three joints."""
    total: dict[int, complex] = {}
    for k, c in waves.items():
        for sign in (1, -1):
            total[k + sign] = total.get(k + sign, 0) + c * sign / 2j
    terms = []
    for k in sorted(k for k in total if k >= 0):
        c = total[k] * (1 if k == 0 else 2)
        for value, kind in ((c.real, "cos"), (-c.imag, "sin")):
            if abs(value) > 1e-17:
                terms.append(Term(float(value), kind, (0, 2 * k, 0), (0, 0, 0)))
    return Equation(tuple(terms))


def test_conditions_that_are_all_but_one_another_are_solved_and_squares_are_not() -> None:
    """PUMA: sin θ5 = 0 and sin θ5 + 1e-5 sin θ3 = 0 have gradients 1e-5 rad apart at every solution, whose joints are
    exact to 1e-10 all the same (xArm 7's first family is like that); of 1 − cos θ5 = 0 they are to 1e-8 only."""
    zero = (0,) * 6
    wrist, elbow = Term(1.0, "sin", (0, 0, 0, 0, 2, 0), zero), Term(1e-5, "sin", (0, 0, 2, 0, 0, 0), zero)
    square = Equation((Term(1.0, "cos", zero, zero), Term(-1.0, "cos", (0, 0, 0, 0, 2, 0), zero)))
    found = shipped("puma560")
    problem, witness = Problem(found.robot, found.task, 1), (0.1, 0.2, 0.0, 0.4, 0.0, 0.6)
    flat = Given("flat", 1, 4, (Equation((wrist,)), Equation((wrist, elbow))), witness)
    _, q, solved = solutions(problem, flat, np.random.default_rng(0))
    assert solved.tested > 100
    assert solved.holds
    assert np.abs(np.sin(q[:, [2, 4]])).max() < 1e-8
    *_, solved = solutions(problem, Given("square", 1, 5, (square,), witness), np.random.default_rng(0))
    assert solved.tested == 0
