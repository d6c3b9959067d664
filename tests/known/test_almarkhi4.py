"""AM's 4-DoF arm: corank 1 only, four curves times the first joint's circle, and the two printed configurations."""

from __future__ import annotations

import numpy as np
import pytest

from known.truths import all_explained, all_sound
from rankdrop.families.searching import refine
from rankdrop.local.block import decompose
from rankdrop.robot.open import open_robot
from rankdrop.verbs.analyze import analyze

# AM Figure 6, printed to two decimals; the true lost direction at the exact singularity nearby, recomputed
FIGURE_6 = [
    ([-3.11, 3.02, -1.53, 0.15], [0.1834, -0.9687, 0.1673], 0.0019),
    ([-1.76, -1.85, -1.39, 0.02], [-0.9872, 0.1574, 0.0241], 0.0039),
]


@pytest.mark.slow
def test_only_corank_one_and_all_of_it_explained():
    analysis = analyze(open_robot("almarkhi4"), starts=2000, seed=2, exact="off")
    assert [summary.converged > 0 for summary in analysis.coranks] == [True, False]
    assert all_explained(analysis, at_least=1000)
    assert all_sound(analysis)
    assert {family.dimension for family in analysis.families} == {2}
    assert all(1 in family.free for family in analysis.families)


@pytest.mark.parametrize(("printed", "direction", "away"), FIGURE_6)
def test_printed_configurations_are_singular_within_rounding(printed, direction, away):
    robot = open_robot("almarkhi4")
    found = refine(robot, [printed], 1)
    assert found.outcome[0] == 0
    assert np.abs(found.q[0] - printed).max() < away
    lost = decompose(robot, found.q[0], found.task).u[:, 2]
    assert abs(abs(lost @ direction) - 1) < 1e-4
