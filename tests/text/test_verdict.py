"""The verdict of `explain`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rankdrop.robot.open import open_robot
from rankdrop.text.verdict import speed_text, summary_lines
from rankdrop.verbs.explain import explain


def test_no_jog_is_advised_that_does_not_raise_sigma() -> None:
    """The table of jogs once listed one that lowers σ, and the answer one that raises it by 0.1 %."""
    place = [0.0916, -0.1983, -0.0199, -2.4732, -0.0131, 2.304, 0.8481]
    found = explain(open_robot("panda"), place, evaluations=0)
    lowered = [one for one in found.escape.single if one.step and one.sigma_after < found.rank.sigma[5]]
    assert lowered
    assert not found.summary.way_out
    shown = str(found)
    assert "no small jog of one joint raises σ6 by 1 %" in " ".join(shown.split())
    assert not [one for one in found.escape.single if f"{one.number} {one.joint}  " in shown]
    away = explain(open_robot("puma560"), np.radians([10, 20, 30, 40, 50, 60]), evaluations=0)
    before, after = away.rank.sigma[5], away.summary.sigma_after
    assert after > 1.01 * before
    assert f"rises from {before:.2g} to {after:.2g}." in " ".join(str(away).split())


@pytest.mark.parametrize("angle", [0.02, 0.5, 2.0])
def test_near_a_singularity_the_answer_says_how_fast_the_tool_still_moves(angle: float) -> None:
    """The straight motion that joint 4 limits is 375°/s times the wrist's offset times sin θ5: 51.6 mm/s per degree."""
    arm = open_robot("kr6r900")
    found = explain(arm, np.radians([0.0, -90.0, 90.0, 0.0, angle, 0.0]))
    slowest = found.summary.slowest
    assert (found.verdict, slowest.number) == ("near", 4)
    assert 1e3 * slowest.speed == pytest.approx(51.6 * angle, rel=0.02)
    assert f"; straight motion at most {speed_text(slowest.speed, 'm/s')} along Y, limited by joint 4." in "".join(
        summary_lines(found)
    )


def test_a_rise_has_digits_that_show_it_and_a_speed_that_is_not_checked_is_said(run, tmp_path: Path) -> None:
    """The table of the AR3 in roboticstoolbox-python issue 199; it has no joint rates."""
    path = tmp_path / "ar3.toml"
    rows = ((0.0642, -90, 0.16977), (0.305, 0, 0), (0, 90, 0), (0, -90, -0.22263), (0, 90, 0), (0, 0, -0.03625))
    joints = [f'[[joints]]\na = {a}\nalpha = "{turn} deg"\nd = {d}\n' for a, turn, d in rows]
    path.write_text('convention = "standard"\n' + "".join(joints))
    words = ("explain", str(path), "--deg", "--q", "180,0,0,0,90,0", "--evaluations", "0")
    out = " ".join(run(*words).out.split())
    assert "σ6 rises from 0.226 to 0.235." in out
    assert "Lost: nothing. Get" in out
    asked = " ".join(run(*words, "--speed", "250mm/s").out.split())
    assert "Lost: nothing. Speed is not checked: the arm's file has no joint rates." in asked


def test_where_turning_alone_is_nearly_lost_the_answer_says_how_fast_the_tool_turns() -> None:
    """An xArm 6 near its zero pose cannot turn about X; its slowest translation, 361 mm/s, says nothing of that."""
    found = explain(open_robot("xarm6"), [0.0, 0.0, 0.0, 0.0, np.radians(0.5), 0.0])
    turning = next(motion for motion in found.straight if motion.unit == "rad/s")
    answer = " ".join(summary_lines(found))
    assert f"; turning at most {speed_text(turning.speed, 'rad/s')} about" in answer
    assert "straight motion" not in answer
