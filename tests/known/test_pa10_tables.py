"""AM's PA-10: Tables 3, 4 and 5 come out as printed, with nothing beyond, and what is not in them is not singular."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from known.truths import PA10_TABLES, all_explained, all_sound, text_values
from rankdrop.kinematics import jacobian
from rankdrop.local.block import singular_values
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.verbs.analyze import analyze


@pytest.fixture(scope="module")
def analysis():
    return analyze(open_robot("pa10"), starts=2000, seed=11, exact="off")


@pytest.mark.parametrize("corank", [1, 2, 3])
def test_rows_of_the_tables(analysis, corank):
    rows = [family for family in analysis.families if family.corank == corank]
    found = [{one.number: tuple(sorted(one.values)) for one in family.pinned} for family in rows]
    assert len(found) == len(PA10_TABLES[corank])
    for expected in PA10_TABLES[corank]:
        match = [row for row in found if row.keys() == expected.keys() and np.allclose(
            [row[j] for j in sorted(row)], [expected[j] for j in sorted(expected)], atol=1e-12)]  # fmt: skip
        assert len(match) == 1
    for family in rows:
        assert family.dimension == 7 - len(family.pinned)
        assert family.coupled == ()
        assert family.free == tuple(j for j in range(1, 8) if j not in {one.number for one in family.pinned})


def test_corank_four_is_searched_and_not_found(analysis):
    last = analysis.coranks[-1]
    assert (last.corank, last.converged) == (4, 0)
    assert last.near_misses > 0
    assert last.smallest_near_miss > 0.1


def test_complete_and_sound(analysis):
    assert all_explained(analysis, at_least=1000)
    assert all_sound(analysis)


def test_witnesses_have_exactly_their_corank_and_satisfy_their_equations(analysis):
    for family in analysis.families:
        witness = np.array(family.witness)
        sigma = singular_values(analysis.robot, witness, analysis.task)
        assert sigma[6 - family.corank] < 1e-12
        assert sigma[5 - family.corank] > 1e-3
        assert family.equations
        for equation in family.equations:
            assert abs(text_values(equation.text(), witness)) < 1e-12


@pytest.mark.parametrize("pinned", [{2: 0.0}, {6: 0.0}, {2: 0.0, 3: 0.0}, {5: 0.0, 6: 0.0}, {2: pi}, {5: pi, 6: pi}])
def test_less_than_a_row_is_not_singular(pinned, rng):
    robot = open_robot("pa10")
    q = rng.uniform(0.3, 1.2, (50, 7))
    for joint, value in pinned.items():
        q[:, joint - 1] = value
    assert singular_values(robot, q, resolve_task("pose", robot))[:, 5].min() > 1e-4


def test_lost_directions_are_lost(analysis):
    # each is orthogonal to every column of the Jacobian at the witness, in metres and radians; together they are k
    for family in analysis.families:
        columns = jacobian(analysis.robot, np.array(family.witness))
        assert np.abs(family.lost_directions @ columns).max() < 1e-12
        assert np.allclose(family.lost_directions @ family.lost_directions.T, np.eye(family.corank), atol=1e-12)
        assert len(family.lost_freedoms) == family.corank


def test_figure_9_configurations_have_corank_three():
    robot = open_robot("pa10")
    task = resolve_task("pose", robot, length_scale=1.0)
    sigma = singular_values(robot, np.array([[0.0] * 7, [pi, 0, pi, pi, pi, pi, pi]]), task)
    # AM Figure 9, recomputed
    assert np.allclose(sigma[0, :3], [2.415095983541647, 2.0, 0.48198691920113834], atol=1e-14)
    assert np.allclose(sigma[1, :3], [2.0, 1.795512478538517, 0.37567930394482735], atol=1e-14)
    assert sigma[:, 3:].max() < 1e-15
