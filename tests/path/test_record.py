"""A checked path as a record: when it holds, when it is clear, and where it reaches singularities, in order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rankdrop.path.check.check import check_path
from rankdrop.path.check.record import CROSSING, TOUCHING, PathCheck
from rankdrop.robot.open import open_robot

ARM = open_robot("planar3r")


@pytest.fixture(scope="module")
def free() -> PathCheck:
    """θ2 from 1 to 0.25 rad and back to 1.2: never 0 or π."""
    return check_path(ARM, np.array([[0.0, 1.0, 0.0], [0.4, 0.25, 0.0], [1.0, 1.2, 0.1]]), [0.0, 1.0, 2.0])


@pytest.fixture(scope="module")
def crossing() -> PathCheck:
    """θ2 through 0 three times."""
    q = np.array([[0.0, 1.0, 0.0], [0.4, -0.5, 0.0], [0.8, 0.5, 0.1], [1.0, -1.2, 0.1]])
    return check_path(ARM, q, [0.0, 1.0, 2.0, 3.0])


def test_a_free_path_holds_as_long_as_it_is_complete(free: PathCheck) -> None:
    assert (free.holds, free.clear, free.crossings) == (True, True, ())
    assert not replace(free, complete=False).holds
    assert not replace(free, complete=False).clear


def test_a_distance_that_is_not_proven_to_be_kept_is_not_clear(free: PathCheck) -> None:
    clear = {margin: replace(free, margin=margin).clear for margin in (None, "kept", "violated", "not proven")}
    assert clear == {None: True, "kept": True, "violated": False, "not proven": False}


def test_crossings_are_in_the_order_of_the_path_and_stretches_worst_first(crossing: PathCheck) -> None:
    """The zeros of θ2 between its rows, by hand: at 2/3, 1/2 and 5/17 of the stretches."""
    assert (crossing.holds, crossing.clear) == (False, False)
    places = [stretch.closest.place for stretch in crossing.crossings]
    expected = [1 + 1.0 / 1.5, 2 + 0.5, 3 + 0.5 / 1.7]
    assert [place.row + place.share for place in places] == pytest.approx(expected, abs=1e-6)
    assert {stretch.verdict for stretch in crossing.crossings} <= {CROSSING, TOUCHING}
    assert all(np.abs(stretch.closest.q[1]) < 1e-6 for stretch in crossing.crossings)
    backwards = replace(crossing, stretches=crossing.stretches[::-1])
    assert backwards.crossings == crossing.crossings
    reached = [stretch.verdict in (CROSSING, TOUCHING) for stretch in crossing.stretches]
    assert reached == sorted(reached, reverse=True)


def test_only_proven_rates_are_overruns(crossing: PathCheck) -> None:
    """The planar arm states no rates; with one of 1 rad/s joint 2 is too fast, by the slope of its rows."""
    assert crossing.overruns == ()
    slow = replace(ARM, joints=tuple(replace(joint, velocity=1.0) for joint in ARM.joints))
    found = check_path(slow, crossing.curve.control[[0, 1], 0], [0.0, 1.0])
    (violation,) = found.violations
    assert (violation.what, violation.joint, violation.proven) == ("rate", 2, True)
    assert violation.amount == pytest.approx(1.5)
    assert [overrun.joint for overrun in found.overruns] == [2]
    doubted = replace(found, violations=(replace(violation, proven=False),))
    assert doubted.overruns == ()


def test_a_joint_path_has_no_reason_to_end(free: PathCheck) -> None:
    assert free.why_ended == ""
    assert free.length_scale == free.task.scale(ARM)
