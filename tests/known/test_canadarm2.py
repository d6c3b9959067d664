"""KG's Canadarm2: the five families are found, eq. 26 in its half-angle form, and nothing is hidden."""

from __future__ import annotations

import numpy as np
import pytest

from known.truths import text_values
from rankdrop.local.block import singular_values
from rankdrop.robot.open import open_robot
from rankdrop.verbs.analyze import analyze

A, C, D = 0.635, 0.504, 6.85  # lengths [m]


@pytest.fixture(scope="module")
def analysis():
    return analyze(open_robot("canadarm2"), starts=2000, seed=8, exact="off")


def rows_holding(analysis, q):
    """Corank-1 families whose every equation vanishes at every row of q."""
    return [
        family
        for family in analysis.families
        if family.corank == 1
        and family.named
        and all(np.abs(text_values(equation.text(), q)).max() < 1e-7 for equation in family.equations)
    ]


def on_case_3(q):
    """θ5 such that a·s345 + d·c34 + d·c3 = 0, where it exists."""
    t3, t4 = q[:, 2], q[:, 3]
    value = -D * (np.cos(t3 + t4) + np.cos(t3)) / A
    q = q[np.abs(value) < 1].copy()
    q[:, 4] = np.arcsin(value[np.abs(value) < 1]) - q[:, 2] - q[:, 3]
    return q


def eq_20(rng):
    q = rng.uniform(-3, 3, (4000, 7))
    t4, t5 = q[:, 3], q[:, 4]
    value = D * (np.cos(t4 + t5) + np.cos(t5)) / A
    q = q[np.abs(value) < 1]
    q[:, 2] = np.arcsin(value[np.abs(value) < 1]) - q[:, 3] - q[:, 4]
    q[:, 5] = 0.0
    return q


def eq_21(rng):
    q = rng.uniform(-3, 3, (300, 7))
    q[:, 5], q[:, 1] = 0.0, np.pi
    return q


def eq_26(rng):
    """θ5 = θ3 + π and d·cos(θ4/2) = a·sin(θ3 + θ4/2)."""
    q = rng.uniform(-3, 3, (4000, 7))
    value = D * np.cos(q[:, 3] / 2) / A
    q = q[np.abs(value) < 1]
    q[:, 2] = np.arcsin(value[np.abs(value) < 1]) - q[:, 3] / 2
    q[:, 4] = q[:, 2] + np.pi
    return q


def eq_27(rng):
    q = on_case_3(rng.uniform(-3, 3, (4000, 7)))
    q[:, 1] = 0.0
    return q


@pytest.mark.spread(1)
@pytest.mark.by_hand_at("eq_20", "eq_21")
@pytest.mark.slow
@pytest.mark.parametrize("family", [eq_20, eq_21, eq_26, eq_27], ids=lambda f: f.__name__)
def test_kg_s_family_is_one_row(analysis, family, rng):
    q = family(rng)
    assert len(q) > 50
    assert singular_values(analysis.robot, q, analysis.task)[:, 5].max() < 1e-12
    rows = rows_holding(analysis, q)
    assert len(rows) == 1
    assert rows[0].dimension == 5


@pytest.mark.slow
def test_eq_26_is_written_with_half_angles(analysis, rng):
    (row,) = rows_holding(analysis, eq_26(rng))
    assert set(row.coupled) == {3, 4, 5}
    assert row.soundness.holds
    texts = [equation.text() for equation in row.equations]
    assert any("/2" in text or "0.5*" in text for text in texts)


@pytest.mark.slow
def test_eq_15_points_lie_on_rows_with_joint_4_straight(analysis, rng):
    # KG eq. 15: θ4 = 0 or π and one long equation; solved for θ6 here
    q = rng.uniform(-3, 3, (300, 7))
    q[:, 3] = np.where(np.arange(300) % 2 == 0, 0.0, np.pi)
    s2, c2, s3, c3 = np.sin(q[:, 1]), np.cos(q[:, 1]), np.sin(q[:, 2]), np.cos(q[:, 2])
    c4, c5 = np.cos(q[:, 3]), np.cos(q[:, 4])
    s35, c35 = np.sin(q[:, 2] + q[:, 4]), np.cos(q[:, 2] + q[:, 4])
    first, second = A * s35 * c4 + D * c3 * c4 + D * c3, s2 * (-A * c35 * c4 + D * s3 * c4 + D * s3 - A)
    on_sine = (-c2 * A * c3 + 2 * C * s2 * s3) * first - 2 * C * c3 * second
    on_cosine = s2 * c35 * A * c5 * first + A * s35 * c5 * second
    q[:, 5] = np.arctan2(-on_cosine, on_sine)
    assert singular_values(analysis.robot, q, analysis.task)[:, 5].max() < 1e-12
    named = [f for f in analysis.families if f.corank == 1 and f.named]
    explained = [
        any(all(abs(text_values(e.text(), point)) < 1e-6 for e in family.equations) for family in named) for point in q
    ]
    assert np.mean(explained) == 1.0


@pytest.mark.slow
def test_every_fresh_point_is_explained_or_shown_as_unexplained(analysis):
    summary = analysis.coranks[0]
    assert summary.completeness.tested >= 1000
    named = [family for family in analysis.families if family.corank == 1 and family.named]
    assert all(family.soundness.holds for family in named)
    if summary.completeness.agree < summary.completeness.tested:
        assert any(not family.named for family in analysis.families if family.corank == 1)
    assert summary.completeness.agree >= 0.99 * summary.completeness.tested
