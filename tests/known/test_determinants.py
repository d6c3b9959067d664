"""Arms whose determinant is known: as many corank-1 families as it has factors, each with the factor's zero set."""

from __future__ import annotations

import numpy as np
import pytest

from known.truths import DETERMINANTS, all_explained, all_sound, text_values, zeros
from rankdrop.local.block import singular_values
from rankdrop.robot.open import open_robot
from rankdrop.verbs.analyze import analyze


@pytest.fixture(scope="module", params=sorted(DETERMINANTS))
def case(request):
    robot = open_robot(request.param)
    return DETERMINANTS[request.param], analyze(robot, starts=2000, seed=5, exact="off")


@pytest.mark.by_hand_at("anthropomorphic", "puma560", "ur5")
@pytest.mark.slow
def test_complete_and_sound(case):
    _, analysis = case
    assert all_explained(analysis, at_least=1000)
    assert all_sound(analysis)


@pytest.mark.spread(1)
@pytest.mark.by_hand_at("puma560")
@pytest.mark.slow
def test_each_factor_is_one_family_with_the_same_zero_set(case):
    factors, analysis = case
    robot, n = analysis.robot, analysis.robot.n
    rng = np.random.default_rng(77)
    rows = [family for family in analysis.families if family.corank == 1]
    assert len(rows) == len(factors)
    for factor in factors:
        q = zeros(factor, n, 200, rng)
        assert singular_values(robot, q, analysis.task)[:, analysis.generic_rank - 1].max() < 1e-12  # the truth is true
        matches = [row for row in rows if max(_distance(e, q).max() for e in row.equations) < 1e-9]
        assert len(matches) == 1  # the family vanishes on the factor's zeros to 1e-9
        assert matches[0].dimension == n - 1
        assert len(matches[0].equations) == 1


def _distance(equation, q):
    values = np.abs(text_values(equation.text(), q))
    slope = np.linalg.norm(equation.gradient(q), axis=-1)
    return values / np.maximum(slope, 1e-3)


@pytest.mark.by_hand_at("anthropomorphic", "ur5")
@pytest.mark.slow
@pytest.mark.parametrize("name", ["anthropomorphic", "puma560", "ur5", "scara"])
def test_coefficients_to_one_in_a_billion(name):
    analysis = analyze(open_robot(name), starts=1500, seed=1, exact="off")
    rng = np.random.default_rng(3)
    q = rng.uniform(-np.pi, np.pi, (400, analysis.robot.n))
    for factor in DETERMINANTS[name]:
        best = np.inf
        for family in analysis.families:
            if family.corank != 1 or len(family.equations) != 1:
                continue
            ours, truth = text_values(family.equations[0].text(), q), factor(q)
            ratio = (ours @ truth) / (truth @ truth)
            best = min(best, np.abs(ours - ratio * truth).max() / np.abs(ours).max())
        assert best < 1e-9
