"""New time laws as remedies: the path stays as it is, and its limits are kept."""

from __future__ import annotations

import numpy as np
import pytest

import rankdrop
from rankdrop.path.mend.record import Remedy
from rankdrop.path.mend.time_remedies import in_new_time, slower
from rankdrop.path.mend.verifier import Verifier
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot

ARM = open_robot("planar3r")
RATES, ACCELERATIONS = np.full(ARM.n, 1.0), np.full(ARM.n, 60.0)


def hurried() -> tuple[Array, Array]:
    """A path in time, free of singularities, that is too fast around 2 s only."""
    t = np.linspace(0.0, 4.0, 401)
    fast = 0.03 * np.arctan((t - 2.0) / 0.02)
    return np.stack([0.1 * t + fast, 1.0 + 0.05 * t, 0.3 + 0.02 * t], axis=1), t


def verifier(**options: str) -> Verifier:
    q, t = hurried()
    return Verifier(rankdrop.check_path(ARM, q, t, **options), None, (RATES, ACCELERATIONS))


@pytest.mark.parametrize("law", [slower, in_new_time])
def test_the_path_stays_and_the_limits_are_kept(law) -> None:
    work = verifier()
    assert work.breaks_limits(work.before.curve)
    remedy = law(work)
    assert isinstance(remedy, Remedy)
    assert (remedy.retimed, remedy.off, remedy.check.clear) == (True, (0.0, 0.0), True)
    q, _ = hurried()
    assert max(np.abs(remedy.trajectory.q - row).max(axis=1).min() for row in q) < 1e-12
    duration = np.diff(remedy.trajectory.times)
    speed = np.diff(remedy.trajectory.q, axis=0) / duration[:, None]
    assert np.abs(speed).max() <= 1.0 + 1e-9
    middle = (remedy.trajectory.times[1:] + remedy.trajectory.times[:-1]) / 2
    assert np.abs(np.diff(speed, axis=0) / np.diff(middle)[:, None]).max() <= 60.0 * (1 + 1e-6)


def test_slower_around_the_fast_rows_leaves_the_other_times() -> None:
    remedy = slower(verifier())
    assert isinstance(remedy, Remedy)
    (change,) = remedy.changes
    assert 0.0 < change.start.time < 2.0 < change.end.time < 4.0
    _, t = hurried()
    before, after = t[t < change.start.time], t[t > change.end.time]
    np.testing.assert_allclose(remedy.trajectory.times[: len(before)], before)
    np.testing.assert_allclose(remedy.trajectory.times[-len(after) :], after + change.longer)
    assert change.longer > 0.01


def test_a_smooth_path_is_not_slowed_down_in_part() -> None:
    q, t = hurried()
    velocities = np.gradient(q, t, axis=0)
    check = rankdrop.check_path(ARM, q, t, velocities=velocities, interpolate="cubic")
    assert slower(Verifier(check, None, (RATES, ACCELERATIONS))) == ("slow-down", False)
