"""All real roots of an exact set belong to its row: one that sampling leaves out for its flat conditions too."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rankdrop.exact.family import derived_in_units
from rankdrop.families.row import on_row, row_of
from rankdrop.formula.equation import Equation, System, Term
from rankdrop.problem import Problem
from rankdrop.robot.open import open_robot
from rankdrop.units import in_units, task_in_units
from rankdrop.verbs.conditions import conditions

ELBOW = str(Path(__file__).parents[1] / "data" / "near" / "elbow_0mm44.toml")


def test_steps_go_on_where_the_gradients_of_two_conditions_are_all_but_one() -> None:
    """sin θ1 = 0 and sin θ1 + 1e-9 sin θ2 = 0: a step that leaves out small singular values never turns joint 2."""
    zero = (0, 0)
    along = Term(1.0, "sin", (2, 0), zero)  # harmonics count half angles
    system = System((Equation((along,)), Equation((along, Term(1e-9, "sin", (0, 2), zero)))))
    starts = np.random.default_rng(0).uniform(-np.pi, np.pi, (20, 2))
    _, plainly = system.solve(starts, along=np.eye(2))
    q, solved = system.solve_flat(starts, along=np.eye(2), iterations=60)
    assert not plainly.any()
    assert solved.all()
    assert np.abs(np.sin(q)).max() < 1e-3


@pytest.mark.slow
def test_a_row_is_not_narrowed_where_a_further_root_has_dependent_gradients() -> None:
    """sin θ2 = 0.000532 and 0.0218, θ4 = 0.06° and 179.94°: at the second one the two conditions have nearly one
    gradient; 595 of 1,142 fresh points of this arm were on no row.
    """
    robot = open_robot(ELBOW)
    derived = conditions(robot, points=0, special=False, method="tree", coranks=1)
    problem = Problem(in_units(robot), task_in_units(derived.task, robot), 1)
    family = derived_in_units(derived.families[0], robot)
    row = row_of(problem, family)
    there = np.tile([0.3, 0.0218134704363, -0.6, 3.1405020533736, 1.0, 0.5, 0.7], (1, 1))
    q, arrived = row.system.solve_flat(there, along=np.eye(7), iterations=60)
    assert arrived.all()
    assert np.abs(q - there).max() < 1e-4
    assert problem.singular(q).all()
    assert on_row(problem, row, q).all()
