"""How the ideal arm near an arm is worded."""

from __future__ import annotations

import json

import pytest
from cli.calibrated import CALIBRATED, TOLERANCE, Q
from printed import one_line

from rankdrop.cli import exits


@pytest.mark.slow
def test_explain_says_where_the_ideal_arm_is_singular_and_what_the_arm_itself_does_there(run) -> None:
    ended = run("explain", CALIBRATED, "--ideal", TOLERANCE, "--q", Q)
    text = one_line(ended.out)
    assert "the ideal arm is singular 0.29° from here; this arm's σ6 there is " in text
    assert "σ6 of the arm itself here: " in text
    assert "wrist" in text
    at = one_line(run("explain", CALIBRATED, "--ideal", TOLERANCE, "--q", "0.1,-2,1.5,1,0,0", "--full").out)
    assert "the ideal arm is singular here; this arm's σ6 here is " in at
    assert "α1 1, 2 90.094° 90° 0.0941°" in at
    record = json.loads(run("explain", CALIBRATED, "--ideal", TOLERANCE, "--q", Q, "--json", "-").out)
    assert record["ideal"]["here"]["distance"] == pytest.approx(0.005, rel=0.05)


def test_a_tolerance_within_which_nothing_is_moved_is_told(run) -> None:
    ended = run("conditions", "scara", "--ideal", "1mm", "--quiet")
    assert "nothing is moved within 1mm: the arm is as exact as it can be" in one_line(ended.out)
    assert "not of the arm itself" not in one_line(ended.out)
    assert ended.code == exits.FINE
