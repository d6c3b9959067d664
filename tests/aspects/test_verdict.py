"""Whether an arm changes its posture without a singularity, of an arm of one's own."""

from __future__ import annotations

from math import pi

import pytest
from reference import cuspidal

from rankdrop.aspects import verdict
from rankdrop.aspects.verdict import judged_summary
from rankdrop.results.aspect_summary import CUSPIDAL, NOT_ASKED, NOT_FOUND
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


@pytest.mark.slow
def test_the_verdict_of_an_own_arm_is_proven_or_searched_for_at_a_few_poses(monkeypatch: pytest.MonkeyPatch) -> None:
    wenger = cuspidal.wenger()
    assert judged_summary(wenger, resolve_task(None, wenger)).posture_change == CUSPIDAL
    monkeypatch.setattr(verdict, "POSES", 1)
    rows = [(0, 0.9, -pi / 2), (0.5, 0.3, pi / 2), (0, 1.2, 0)]
    table = [{"d": float(d), "a": float(a), "alpha": float(x)} for d, a, x in rows]
    undecided = from_dh(table, convention="standard", task="position", name="open")
    assert judged_summary(undecided, resolve_task(None, undecided)).posture_change == NOT_FOUND
    redundant = open_robot("planar3r")
    assert judged_summary(redundant, resolve_task("planar-position", redundant)).posture_change == NOT_ASKED
