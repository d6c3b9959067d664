"""Back onto the singular set."""

from __future__ import annotations

import numpy as np

from rankdrop.families.points import move_to_singularity
from rankdrop.problem import Problem
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


def test_onto_moves_only_along_the_span() -> None:
    arm = open_robot("puma560")
    task = resolve_task(None, arm)
    start = np.array([[0.3, 0.5, 0.4, 0.2, 0.5, 0.6]])
    end, arrived = move_to_singularity(Problem(arm, task), start, np.eye(6)[:, [4]])
    assert arrived.all()
    assert np.abs(end[0, 4]) < 1e-9
    assert (np.delete(end - start, 4, axis=1) == 0).all()
