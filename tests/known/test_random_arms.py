"""Arms with no special geometry run to an honest end: 6R has corank 2, 7R and 8R do not."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.robot.dh import from_dh
from rankdrop.verbs.analyze import analyze


def random_arm(n: int, seed: int):
    rng = np.random.default_rng(seed)
    rows = [{"a": rng.uniform(-1, 1), "alpha": rng.uniform(-np.pi, np.pi), "d": rng.uniform(-1, 1)} for _ in range(n)]
    return from_dh(rows, convention="standard", name=f"random{n}r")


@pytest.mark.slow
@pytest.mark.by_hand_at("6-coranks0")
@pytest.mark.parametrize(
    ("n", "coranks"),
    [(6, [True, True, False]), (7, [True, False]), pytest.param(8, [True, False], marks=pytest.mark.by_hand)],
)
def test_coranks_that_exist(n, coranks):
    analysis = analyze(random_arm(n, 4), starts=600, seed=4, exact="off")
    assert [summary.converged > 0 for summary in analysis.coranks] == coranks
    assert analysis.complete
    for summary in analysis.coranks:
        assert summary.starts == summary.converged + summary.near_misses + summary.slow
        shown = [family for family in analysis.families if family.corank == summary.corank]
        assert bool(shown) == bool(summary.converged)  # named or not, what was found is shown
        for family in shown:
            assert family.soundness.holds or not family.named
