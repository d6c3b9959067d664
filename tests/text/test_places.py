"""How places on a path are worded: which joint, when, and for how long."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from path.overrun import ARM, LIMIT
from printed import one_line

from rankdrop.kinematics import pose
from rankdrop.path.check.overrun import fastest, overruns
from rankdrop.path.check.tool_path import check_poses
from rankdrop.path.curve import Place, curve
from rankdrop.text.places import fastest_words, interval_words, overrun_words, place_text, when

WRIST = np.radians([0, -70, 90, -110, 1, 0])


def test_rates_durations_and_turns_by_hand() -> None:
    rows = np.zeros((5, 6))
    rows[1:, 3] = LIMIT * np.array([0.5, 1.5, 2.0, 5.0])  # 0.5, 1, 0.5 and 3 times the limit
    rows[1:, 4] = LIMIT * np.array([0.0, 1.2, 1.2, 1.2])
    path = curve(rows, np.arange(5.0))
    first, second = overruns(ARM, path)
    assert (first.joint, second.joint) == (4, 5)
    assert (first.rate, first.limit) == pytest.approx((3 * LIMIT, LIMIT))
    assert (first.seconds, first.travel) == pytest.approx((1.0, 3 * LIMIT))
    assert (first.start.time, first.end.time, first.place.time) == (3.0, 4.0, 3.5)
    assert (second.seconds, second.travel) == pytest.approx((1.0, 1.2 * LIMIT))
    assert [overrun.joint for overrun in overruns(ARM, path, 1, 3)] == [5]
    assert overruns(ARM, path, 0, 1) == overruns(ARM, path, 2, 3) == ()
    assert overruns(ARM, curve(rows, None)) == ()
    assert overrun_words((first,), ARM) == (
        "joint 4 needs up to 540°/s (limit 180°/s): above it for 1 s, between 3 and 4 s, while it turns 540°"
    )


def near_wrist(speed: float) -> tuple[np.ndarray, np.ndarray]:
    """A line that passes the wrist singularity of a UR5 at 1°, 0.1 m each way, at a speed [m/s]."""
    middle = pose(ARM, WRIST)
    poses = np.stack([middle, middle, middle])
    poses[[0, 2], 1, 3] += [-0.1, 0.1]
    return poses, np.array([0.0, 0.1, 0.2]) / speed


@pytest.mark.slow
def test_a_line_past_a_wrist_says_which_joint_is_too_fast_and_how_long() -> None:
    poses, times = near_wrist(0.1)
    check = check_poses(ARM, poses, times, start=WRIST, branches=False)
    assert check.verdict == "too fast"
    assert [overrun.joint for overrun in check.overruns] == [4, 6]
    worst = check.overruns[0]
    assert worst.rate / worst.limit == pytest.approx(check.violations[0].amount)
    rates = check.curve.rates[:, 3]
    assert worst.seconds == pytest.approx(np.diff(check.curve.times)[rates > LIMIT].sum())
    said = one_line("\n".join(check.summary))
    assert "Too fast: joint 4 needs up to 663°/s (limit 180°/s): above it for 0.33 s, between 0.82" in said
    assert "; joint 6 needs up to 539°/s (limit 180°/s): above it for 0.3 s" in said


@pytest.mark.slow
def test_a_free_line_near_a_wrist_names_its_fastest_joint() -> None:
    poses, times = near_wrist(0.01)
    check = check_poses(ARM, poses, times, start=WRIST, branches=False)
    assert (check.verdict, check.overruns) == ("free", ())
    assert "Fastest: joint 4 turns at up to 66.3°/s, 37 % of its limit, at 9.96" in one_line("\n".join(check.summary))
    unlimited = replace(ARM, joints=tuple(replace(joint, velocity=np.inf) for joint in ARM.joints))
    quickest = fastest(unlimited, check.curve)
    assert fastest_words(quickest, unlimited).startswith("joint 4 turns at up to 66.3°/s, no limit is known, at 9.96")


def test_places_are_times_else_poses_else_rows() -> None:
    timed, tool, joint = Place(3, 0.5, 1.25, 2.5), Place(3, 0.5, None, 1.46789), Place(3, 0.5, None)
    assert [when(place) for place in (timed, tool, joint)] == ["at 1.25 s", "at pose 1.4679", "between rows 3 and 4"]
    assert [place_text(place) for place in (timed, tool, joint)] == ["1.25 s", "pose 1.4679", "row 3.5"]
    assert interval_words(tool, Place(4, 0.0, None, 2.0)) == "between poses 1.4679 and 2"
    assert interval_words(joint, Place(4, 0.0, None)) == "between rows 3.5 and 4"
