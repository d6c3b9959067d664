"""`analyze` of arms of any number of joints: an answer, and every root of a family."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.robot.dh import from_dh
from rankdrop.verbs.analyze import analyze


def wrist_with_offset(d5: float):
    """Six joints, axes 4 and 6 apart by d5: next to θ2 = ±90° the conditions of two families of corank 2 are flat."""
    rows = [(0, -90, 0.12), (0.285, 0, 0), (0.022, 90, 0), (0, -90, 0.25), (0, 90, d5), (0, 0, 0.09)]
    return from_dh([(a, np.radians(alpha), d, 0.0) for a, alpha, d in rows], convention="standard", name="wrist-offset")


@pytest.mark.by_hand
@pytest.mark.parametrize("d5", [0.0014])
def test_a_row_has_every_real_root_of_its_set(d5: float) -> None:
    found = analyze(wrist_with_offset(d5), starts=1000)
    assert found.verified
    assert found.verdict.claims == ("sampled", "derived exactly")
    assert [len(found.of_corank(k)) for k in (1, 2, 3)] == [1, 5, 0]
    assert all(one.completeness.agree == one.completeness.tested for one in found.coranks)


@pytest.mark.by_hand
def test_an_analysis_of_thirty_joints_ends() -> None:
    rng = np.random.default_rng(30)
    rows = [(rng.uniform(0.1, 0.5), f"{rng.choice([0, 90, -90])} deg", rng.choice([0, 0.1, 0.3]), 0) for _ in range(30)]
    found = analyze(from_dh(rows, convention="standard"), starts=300, threads=1)
    assert found.families
