"""Detours of the tool around a singularity."""

from __future__ import annotations

import numpy as np
import pytest

from path.planar_detours import CLEARANCE, checked
from rankdrop.local.block import singular_values
from rankdrop.path.mend.detours import Hindrance, lost_motions
from rankdrop.path.mend.pose_detours import Blocked, PoseDetourer, PoseWindow


@pytest.mark.slow
def test_the_way_lost_before_the_joints_turn_leads_around(monkeypatch: pytest.MonkeyPatch) -> None:
    """At the wrist of a UR10e joints 4 and 6 turn half around between two poses. Along the direction that is lost while
    they turn, the share of a turn is larger; no such turn leads around, and the other motion is tried.
    """
    _, t, check = checked("ur10e")
    work = PoseDetourer(check, float(np.radians(2.0)), CLEARANCE)
    way, turn = lost_motions(work.aim, work.tool.rank, np.radians([-1, -69, 87, -78, 0.1, 4]))
    assert not way[3:].any()
    assert not turn[:3].any()
    (window,) = _windows(work)
    assert 1e-3 < window.off[0] < 4e-3
    assert window.off[1] == 0.0
    made = work.trajectory()
    assert singular_values(check.robot, made.q, check.task)[:, 5].min() > 1e-4
    assert (made.times[0], made.times[-1]) == (t[0], t[-1])
    again = PoseDetourer(check, float(np.radians(2.0)), CLEARANCE)
    motions = [np.array([0.0, 0.0, 0.0, 0.867, -0.015, 0.498]), way]
    monkeypatch.setattr("rankdrop.path.mend.pose_detours.lost_motions", lambda aim, rank, q: motions)
    tried: list[object] = []
    led = again._led_along
    monkeypatch.setattr(again, "_led_along", lambda *arguments: tried.append(led(*arguments)) or tried[-1])
    assert [one.off[1] for one in _windows(again)] == [0.0]
    assert [isinstance(one, Blocked) for one in tried] == [True, False]


def _windows(work: PoseDetourer) -> list[PoseWindow]:
    found = work.find_windows(lambda done, count: None)
    assert not isinstance(found, Blocked)
    return found


@pytest.mark.slow
def test_where_no_window_does_the_bound_is_named() -> None:
    """With a bound that is too small: the one that would do."""
    _, _, check = checked("pa10")
    found = PoseDetourer(check, 2e-4, CLEARANCE).find_windows(lambda done, count: None)
    assert isinstance(found, Blocked)
    assert found.hindrance == Hindrance.TOOL
    assert 2e-4 < found.needed < np.radians(2.0)
    assert abs(found.place - 60) < 10
