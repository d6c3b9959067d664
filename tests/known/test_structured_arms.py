"""Random structured arms, twists 0 and ±90°, lengths out of a small set with zeros: two gates, held apart.

Precision: whatever solves a row's equations, from starts anywhere and from starts at right angles, is singular.
Coverage: every singular configuration found from such starts lies on a row, or the analysis says that it is not
complete. Double zeros, joints on one axis and equations that vanish on more than their family all come up by chance.
"""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.families import fit as fit_module
from rankdrop.families.points import Cloud, count_explained
from rankdrop.families.searching import refine, search
from rankdrop.families.table import families
from rankdrop.local.block import singular_values
from rankdrop.results.analysis import Analysis
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.task import resolve_task
from rankdrop.verbs.analyze import analyze

LENGTHS = (0.0, 0.0, 0.2, 0.3, 0.5, 1.0)
RIGHT = np.array([0.0, np.pi, np.pi / 2, -np.pi / 2])


def structured_arm(n: int, seed: int) -> Robot:
    rng = np.random.default_rng([n, seed])
    rows = []
    for _ in range(n):
        a, alpha, d = float(rng.choice(LENGTHS)), float(rng.choice([0, 1, -1])) * np.pi / 2, float(rng.choice(LENGTHS))
        rows.append((a, alpha, d, 0.0))
    return from_dh(rows, convention="standard", name=f"structured{n}r{seed}")


def starts(n: int, count: int, rng: np.random.Generator) -> np.ndarray:
    """Anywhere, and with any joints at right angles."""
    q = rng.uniform(-np.pi, np.pi, (count, n))
    held = rng.random((count, n)) < rng.uniform(0.0, 0.9, (count, 1))
    return np.where(held, RIGHT[rng.integers(4, size=(count, n))], q)


def solutions(equations, q: np.ndarray) -> np.ndarray:
    """Where a plain Gauss–Newton method on all equations at once ends, steps of 0.5 rad at most, and all hold."""
    q = np.array(q)
    for _ in range(80):
        f = np.stack([one(q) for one in equations], axis=-1)
        a = np.stack([one.gradient(q) for one in equations], axis=-2)
        step = -(np.linalg.pinv(a, rcond=1e-8) @ f[..., None])[..., 0]
        q += step * np.minimum(1.0, 0.5 / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-300))
    return q[np.stack([np.abs(one(q)) for one in equations]).max(axis=0) <= 1e-12]


def unsound(found: Analysis, rng: np.random.Generator, count: int = 400) -> dict[str, int]:
    """Rows, not said to be unsound, whose equations hold at regular configurations; and at how many."""
    wrong = {}
    for row in found.families:
        if row.named and row.soundness.holds:
            q = solutions(row.equations, starts(found.robot.n, count, rng))
            sigma = singular_values(found.robot, q, found.task)[:, found.generic_rank - row.corank]
            if (sigma > 1e-2).any():
                wrong[row.id] = int((sigma > 1e-2).sum())
    return wrong


def uncovered(found: Analysis, rng: np.random.Generator, count: int = 400) -> dict[int, int]:
    """Coranks said to be complete at which singular configurations lie on no row; and how many."""
    missed = {}
    for summary in found.coranks:
        share, k = summary.completeness, summary.corank
        back = refine(found.robot, starts(found.robot.n, count, rng), k, task=found.task)
        kept = back.q[(back.outcome == 0) & (back.sigma[:, found.generic_rank - k - 1] > 1e-5)]
        rows = [row.equations for row in found.families if row.corank >= k and row.named]
        _, over = count_explained(Cloud(found.robot, found.task, kept, np.full(len(kept), k)), rows)
        if len(over) and share.agree == share.tested:
            missed[k] = len(over)
    return missed


def analysed(n: int, seed: int, count: int = 1000) -> Analysis:
    return analyze(structured_arm(n, seed), starts=count)


@pytest.mark.by_hand
def test_a_condition_squared_that_binds_four_joints_is_found() -> None:
    """7R of seed 16: {θ5 = π, one equation in θ2, θ3, θ4, θ6} is a double zero, a fifth of its singular set."""
    found = analysed(7, 16)
    (row,) = (one for one in found.of_corank(1) if [(pin.number, pin.values) for pin in one.pinned] == [(5, (np.pi,))])
    assert row.coupled == (2, 3, 4, 6)
    assert row.soundness.holds
    assert row.explained.agree > 0.15 * row.explained.tested
    assert all(one.completeness.agree == one.completeness.tested for one in found.coranks)


@pytest.mark.by_hand
def test_a_squared_condition_on_one_joint_at_no_simple_value_is_found() -> None:
    """6R of seed 32: det contains (0.2 c3 + s3)², θ3 = −atan 0.2."""
    found = analysed(6, 32)
    (row,) = (family for family in found.of_corank(1) if [one.number for one in family.pinned] == [3])
    assert sorted(row.pinned[0].values) == pytest.approx([-np.arctan(0.2), np.pi - np.arctan(0.2)], abs=1e-10)
    assert found.sound_and_complete


@pytest.mark.slow
def test_a_squared_condition_on_one_joint_is_fitted_too() -> None:
    """The same arm without a derivation: D vanishes there; values that points share are known to half the digits."""
    table = families(search(structured_arm(6, 32), 1, starts=600))
    (row,) = (family for family in table.families if [one.number for one in family.pinned] == [3])
    assert row.pinned[0].values == pytest.approx([-np.arctan(0.2), np.pi - np.arctan(0.2)], abs=1e-12)
    assert row.soundness.holds
    assert table.summary.completeness.holds


@pytest.mark.by_hand
def test_joints_on_one_axis_count_as_one() -> None:
    """7R of seed 4: axes 5 and 6 are one line; one equation of 5 joints is one of 4 in θ5 + θ6."""
    found = analysed(7, 4)
    row = found.of_corank(1)[0]
    assert row.coupled == (2, 3, 4, 5, 6)
    for term in row.equations[0].terms:
        assert term.harmonics[4] == term.harmonics[5]
    assert found.sound_and_complete


@pytest.mark.slow
def test_what_holds_elsewhere_too_is_tightened_or_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """7R of seed 3: three conditions of its family hold together on θ6 = π besides, where the arm is regular."""
    arm = structured_arm(7, 3)
    cloud = search(arm, 1, task=resolve_task(None, arm), starts=600)
    (row,) = families(cloud).families
    assert row.soundness.holds
    monkeypatch.setattr(fit_module, "solve_at_special_values", lambda *arguments: (0, np.zeros((0, 7))))
    (wide,) = families(cloud).families
    assert len(wide.equations) < len(row.equations)
    assert wide.named
    assert 0 < wide.soundness.agree < wide.soundness.tested


@pytest.mark.by_hand
@pytest.mark.by_hand_at("6-6")
@pytest.mark.slow_at("6-6", "6-32")
@pytest.mark.parametrize(("n", "seed"), [(6, 6), (6, 32)])
def test_rows_are_sound_everywhere_and_singular_points_are_on_them(n: int, seed: int) -> None:
    found, rng = analysed(n, seed), np.random.default_rng(seed)
    assert unsound(found, rng) == {}
    assert uncovered(found, rng) == {}


@pytest.mark.by_hand
@pytest.mark.parametrize(("n", "seed"), [(n, seed) for n in (6, 7) for seed in range(40)])
def test_both_gates_hold_for_forty_arms(n: int, seed: int) -> None:
    test_rows_are_sound_everywhere_and_singular_points_are_on_them(n, seed)
