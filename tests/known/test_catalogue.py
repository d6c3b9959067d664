"""Arms of the catalogue, judged from the JSON alone, as a user's own script would.

Of each kind: `pytest -m slow tests/known/test_catalogue.py`; three of them run by default.
"""

from __future__ import annotations

import json

import numpy as np
import pytest

from known.arms import KINDS
from known.truths import text_values
from rankdrop.codec import json_text
from rankdrop.families.searching import search
from rankdrop.kinematics import task_jacobian
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.verbs.analyze import analyze

QUICK = ("irb140", "iiwa14", "stanford")
ARMS = [pytest.param(name, marks=() if name in QUICK else pytest.mark.by_hand) for name in KINDS]


@pytest.mark.by_hand_at("iiwa14", "irb140")
@pytest.mark.slow_at("iiwa14", "irb140")
@pytest.mark.parametrize("name", ARMS)
def test_texts_of_the_equations_explain_an_independent_cloud(name):
    robot = open_robot(name)
    task = resolve_task(None, robot)
    result = json.loads(json_text(analyze(robot, starts=2000, seed=21, exact="off").to_dict()))
    generic = result["robot"]["generic_rank"]
    assert result["coranks"][-1]["converged"] == 0
    for summary in result["coranks"][:-1]:
        corank = summary["corank"]
        rank = generic - corank
        rows = [family for family in result["families"] if family["corank"] == corank and family["named"]]
        q = search(robot, corank, task=task, starts=2000, seed=987_654).converged
        sigma = np.linalg.svd(task_jacobian(robot, q, task), compute_uv=False)
        q = q[sigma[:, rank - 1] > 1e-6] if rank else q
        residual = [
            np.max([np.abs(text_values(text, q) + 0 * q[:, 0]) for text in row["equations"]], axis=0) for row in rows
        ]
        explained = np.min(residual, axis=0) < 1e-4  # unpolished points where families meet are known to 1e-5 only
        assert len(q) > 300
        shown_unnamed = any(not family["named"] for family in result["families"] if family["corank"] == corank)
        assert explained.all() or shown_unnamed
        assert explained.mean() > 0.99
        for row in rows:
            witness = np.array(row["witness"])
            values = np.linalg.svd(task_jacobian(robot, witness, task), compute_uv=False)
            assert max(abs(text_values(text, witness)) for text in row["equations"]) < 1e-9
            assert values[rank] < 1e-9
            assert rank == 0 or values[rank - 1] > 1e-5
            assert 0 < row["soundness"]["tested"] == row["soundness"]["singular"]
