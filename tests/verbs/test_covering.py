"""`cover` within a budget."""

from __future__ import annotations

import numpy as np
import pytest
from reference.coverings import covering

from rankdrop.cover.covering import CoveringEnd
from rankdrop.jobs.running import perform
from rankdrop.robot.open import open_robot
from rankdrop.verbs import cover


def backwards(job, engine, *, folder, report, each):
    """`finish`, as if workers had the last chunks ready first."""
    for chunk in reversed(range(job.chunks)):
        each(chunk, perform(job.work, job.plan, chunk))
        yield chunk, b""


@pytest.mark.by_hand_at("backwards", "by processes")
@pytest.mark.slow_at("backwards")
@pytest.mark.slow_at("by processes")
@pytest.mark.parametrize("made", ["here", "by processes", "backwards"])
def test_a_budget_pays_for_the_same_chunks_whoever_makes_them(made, monkeypatch, tmp_path):
    robot = open_robot("almarkhi4")
    budget = covering(robot, 0.2).tested // 2
    if made == "by processes":
        monkeypatch.setattr("rankdrop.verbs.covering._QUICK_BY_ENCLOSURES", 0)
    if made == "backwards":
        monkeypatch.setattr("rankdrop.verbs.covering.finish", backwards)
    found = cover(robot, width=0.2, budget=budget, out=tmp_path / "x", threads=2, explain=False).covering
    assert (found.complete, found.stopped) == (False, CoveringEnd.BUDGET_SPENT)
    assert 0 < found.tested <= budget
    usual = covering(robot, 0.2, budget=budget)
    np.testing.assert_array_equal(found.tree.finished, usual.tree.finished)
    assert found.tested == usual.tested
    monkeypatch.undo()
    assert cover(robot, width=0.2, out=tmp_path / "x", explain=False).complete
