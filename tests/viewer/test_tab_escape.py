"""What the buttons of the tab "Escape" say."""

from __future__ import annotations

from rankdrop.local import escape
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.viewer.tab_escape import _direction_label, _why_not


def test_a_joint_that_does_not_help_says_why() -> None:
    """At a wrist singularity joint 5 leads out; joints 1, 4 and 6 turn the arm, and nothing changes."""
    arm = open_robot("puma560")
    out = escape(arm, [0.3, 0.5, 0.4, 0.2, 0.0, 0.6], resolve_task(None, arm))
    told = {way.number: _why_not(way, lost=True) for way in out.single if way.order is None}
    assert 5 not in told
    assert told[1] == told[4] == told[6] == "no help"


def test_a_direction_is_labelled_with_what_is_gained() -> None:
    arm = open_robot("puma560")
    out = escape(arm, [0.3, 0.5, 0.4, 0.2, 0.0, 0.6], resolve_task(None, arm))
    assert out.best_direction is not None
    label = _direction_label("best direction", out.best_direction, 6)
    assert label.startswith("best direction → σ6 = ")
    assert float(label.rpartition(" ")[2]) > 0.0
