"""What AM, KG and the geometry of the Panda say, in words and in numbers: exact families of the catalogue's arms."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("flint")

from rankdrop import conditions, open_robot
from rankdrop.families.record import exact_of
from rankdrop.results.conditions import Conditions

HALVES, QUARTERS = ("0", "pi"), ("pi/2", "-pi/2")
TABLES = {  # AM Tables 3, 4 and 5; Table 5 is truncated in print, all five joints are at 0 or ±π
    1: [{4: HALVES}, {2: HALVES, 3: QUARTERS}, {2: HALVES, 6: HALVES}, {5: QUARTERS, 6: HALVES}],
    2: [
        {2: HALVES, 3: HALVES, 4: HALVES}, {2: HALVES, 4: HALVES, 6: HALVES}, {4: HALVES, 5: HALVES, 6: HALVES},
        {2: HALVES, 3: QUARTERS, 5: QUARTERS, 6: HALVES},
    ],
    3: [{2: HALVES, 3: HALVES, 4: HALVES, 5: HALVES, 6: HALVES}],
}  # fmt: skip
A, D = 0.635, 6.85  # KG's letters for the Canadarm2 [m]


def rows(found: Conditions, corank: int) -> list[dict[int, tuple[str, ...]]]:
    assert not any(exact_of(family).polynomials for family in found.of_corank(corank))
    return [dict(exact_of(family).pins) for family in found.of_corank(corank)]


def in_order(table: list[dict[int, tuple[str, ...]]]) -> list[list[tuple[int, tuple[str, ...]]]]:
    return sorted(sorted(row.items()) for row in table)


@pytest.mark.by_hand
def test_pa10_has_the_tables_of_am_and_their_exception() -> None:
    found = conditions(open_robot("pa10"), special=True, fresh=True)
    for corank, table in TABLES.items():
        assert in_order(rows(found, corank)) == in_order(table)
    assert not found.of_corank(4)
    (assumed,) = found.assumptions
    assert (assumed.text, assumed.holds) == ("d3 ≠ d5", True)
    assert assumed.words.startswith("if d3 = d5, θ4 = π alone loses two freedoms")


@pytest.mark.slow
def test_the_canadarm2_has_eq_26_as_two_relations() -> None:
    found = conditions(open_robot("canadarm2"), coranks=1, points=0)
    (family,) = [one for one in found.families if not exact_of(one).pins]
    assert "θ5 = θ3 + π" in family.texts
    rng = np.random.default_rng(0)
    theta4 = rng.uniform(np.pi - 0.1, np.pi + 0.1, 50)  # elsewhere d cos(θ4/2) is longer than a: not real
    theta3 = np.arcsin(D / A * np.cos(theta4 / 2)) - theta4 / 2  # d cos(θ4/2) = a sin(θ3 + θ4/2)
    q = rng.uniform(-3, 3, (50, 7))
    q[:, 2], q[:, 3], q[:, 4] = theta3, theta4, theta3 + np.pi
    assert max(np.abs(equation(q)).max() for equation in family.equations) < 1e-12
    q[:, 4] += 0.01
    assert max(np.abs(equation(q)).max() for equation in family.equations) > 1e-3


@pytest.mark.by_hand
def test_eq_15_splits_where_the_elbow_is_folded() -> None:
    found = conditions(open_robot("canadarm2"), coranks=1, points=0)
    folded = [one.texts for one in found.families if dict(exact_of(one).pins).get(4) == ("pi",)]
    assert len(folded) == 2
    assert ("θ4 = π", "θ3 + θ5 = 0") in folded


@pytest.mark.by_hand
def test_the_panda_says_when_its_wrist_is_singular() -> None:
    found = conditions(open_robot("panda"), coranks=1, points=0)
    (family,) = [one for one in found.families if exact_of(one).reality]
    assert family.texts == ("θ4 = 0", "a6 + d3 s6 + d5 s6 = 0")
    assert exact_of(family).reality == "real if and only if (d3 + d5 − a6) (d3 + d5 + a6) ≥ 0"
    (unreal,) = found.not_real
    assert "(d3 − d5 − a6) (d3 − d5 + a6) ≥ 0 does not hold" in unreal.proof  # |d3 − d5| = 0.068 m, a6 = 0.088 m
