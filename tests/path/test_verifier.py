"""A changed path is a remedy only where a new check proves it free, inside its limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import rankdrop
from rankdrop.path.mend import verifier as module
from rankdrop.path.mend.record import Proposal
from rankdrop.path.mend.verifier import Verifier
from rankdrop.path.read.trajectory import Trajectory, regular_times
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot

ARM = open_robot("planar3r")
NONE = np.full(ARM.n, np.inf)
CROSSING = np.linspace([0.3, 0.4, 0.1], [0.5, -0.2, 0.3], 5)  # through θ2 = 0
CLEAR = np.linspace([0.3, 0.4, 0.1], [0.5, 0.6, 0.3], 5)


def proposal(q: Array, times: Array | None = None) -> Proposal:
    """Rows as a changed path."""
    at = regular_times(len(q)) if times is None else times
    return Proposal(("branch", None), (), Trajectory("", at, q, times is not None, ()), (0.0, 0.0))


def verifier(times: Array | None = None, rates: Array = NONE) -> Verifier:
    return Verifier(rankdrop.check_path(ARM, CROSSING, times), None, (rates, NONE))


def test_the_first_that_is_proven_free_is_the_remedy() -> None:
    work = verifier()
    assert work.first_proven("flip", [proposal(CROSSING)]) is None
    remedy = work.first_proven("flip", [proposal(CROSSING), proposal(CLEAR), proposal(CLEAR[::-1])])
    assert remedy is not None
    assert (remedy.kind, remedy.check.verdict, remedy.retimed) == ("flip", "free", False)
    np.testing.assert_array_equal(remedy.trajectory.q, CLEAR)
    before, after = remedy.gains["distance"]
    assert before == 0.0 < 0.1 < after


def test_a_distance_that_is_asked_for_is_kept_by_the_new_check() -> None:
    work = Verifier(rankdrop.check_path(ARM, CROSSING, min_distance=0.9), None, (NONE, NONE))
    assert work.first_proven("flip", [proposal(CLEAR)]) is None


def test_a_changed_path_that_is_too_fast_gets_a_new_time_law() -> None:
    times, rates = np.linspace(0.0, 1.0, 5), np.full(ARM.n, 0.1)
    work = verifier(times, rates)
    assert work.breaks_limits(work.before.curve)
    remedy = work.first_proven("flip", [proposal(CLEAR, times)])
    assert remedy is not None
    assert remedy.retimed
    speed = np.abs(np.diff(remedy.trajectory.q, axis=0)) / np.diff(remedy.trajectory.times)[:, None]
    assert speed.max() <= 0.1 * (1 + 1e-9)
    before, after = remedy.gains["duration"]
    assert before == 1.0 < 2.0 - 1e-9 <= after


def test_a_changed_path_within_its_limits_keeps_its_times() -> None:
    times = np.linspace(0.0, 1.0, 5)
    remedy = verifier(times, np.full(ARM.n, 0.7)).first_proven("flip", [proposal(CLEAR, times)])
    assert remedy is not None
    assert not remedy.retimed
    np.testing.assert_array_equal(remedy.trajectory.times, times)


def test_without_times_or_limits_no_limit_is_broken() -> None:
    times = np.linspace(0.0, 1e-3, 5)
    assert verifier(times).usage(verifier(times).before.curve) is None
    assert not verifier(None, np.full(ARM.n, 0.1)).breaks_limits(verifier().before.curve)


def test_a_check_that_is_interrupted_interrupts_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    work = verifier()
    monkeypatch.setattr(module, "check_path", lambda *given, **options: replace(work.before, complete=False))
    with pytest.raises(KeyboardInterrupt):
        work.check_changed(proposal(CLEAR).trajectory)
