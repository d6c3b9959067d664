"""The first sentence of an analysis: how many families, and what was verified."""

from __future__ import annotations

import rankdrop
from rankdrop.named_tasks import WORLD_ALIGNED
from rankdrop.results.known import shipped
from rankdrop.robot.open import open_robot
from rankdrop.task import Task


def test_ur5e_is_summarised_by_rank() -> None:
    """The sentence that the issue asks for, word for word."""
    assert shipped("ur5e").answer == (
        "ur5e has 9 families of singularities: shoulder, elbow, wrist (rank 5); 5 combinations (rank 4); 1 (rank 3)."
    )


def test_an_arm_that_moves_no_row_of_the_task_is_singular_everywhere() -> None:
    arm = open_robot("planar3r")
    lifted = Task("lift", (2,), WORLD_ALIGNED)
    told = "planar3r is singular everywhere: it moves no row of this task."
    assert rankdrop.analyze(arm, lifted, starts=10).answer == told
    assert rankdrop.conditions(arm, lifted, points=0).answer == told
    assert rankdrop.analyze(arm, lifted, starts=10).verdict.sentence == "Verified by exact derivation."
