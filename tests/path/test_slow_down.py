"""A path that is too fast is made slower there and nowhere else: checked from the rows of both files alone."""

from __future__ import annotations

import numpy as np
import pytest

import rankdrop
from rankdrop.local.rates import rate_limits
from rankdrop.path.mend.mend import mend_path
from rankdrop.path.mend.record import Mending
from rankdrop.path.mend.slow_down import slowed_down
from rankdrop.path.read.trajectory import Trajectory
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot

ARM = open_robot("irb120")
NONE = np.full(ARM.n, np.inf)


def turning(rows: int = 600, places: tuple[float, ...] = (2.0, 4.5)) -> tuple[Array, Array]:
    """Joint 4 turns by 40° within some hundredths of a second at each of some times, the wrist bent by 20°."""
    t = np.arange(rows) * 0.01
    q = np.radians([0.0, -30, 30, 0, 20, 0]) + np.radians([10.0, 5, 5, 0, 3, 8]) * (1 - np.cos(np.pi * t / 3))[:, None]
    q[:, 3] += np.radians(40.0) * sum(np.arctan((t - at) / 0.01) / np.pi for at in places)
    return q, t


def mended() -> tuple[Array, Array, Mending]:
    """The program and its remedies."""
    q, t = turning()
    return q, t, mend_path(rankdrop.check_path(ARM, q, t), kinds=("slow-down", "retime"))


@pytest.mark.slow
def test_only_the_rows_around_get_more_time() -> None:
    """All rows are there, in order; the durations outside the parts told are the old ones; limits are kept."""
    q, t, found = mended()
    assert found.before.verdict == "too fast"
    (one,) = found.remedies
    assert (one.kind, one.check.holds, one.deviation, len(one.changes)) == ("slow-down", True, (0.0, 0.0), 2)
    made = one.trajectory
    rows = np.array([int(np.flatnonzero((made.q == row).all(axis=1))[0]) for row in q])
    assert (np.diff(rows) > 0).all()
    at = made.times[rows]
    first, second = one.changes
    before, after = t <= first.start.time, t >= second.end.time
    assert (at[before] == t[before]).all()
    assert np.allclose(at[after] - t[after], first.longer + second.longer, rtol=0, atol=1e-12)
    between = (t >= first.end.time) & (t <= second.start.time)
    assert between.sum() > 50
    assert np.allclose(at[between] - t[between], first.longer, rtol=0, atol=1e-12)
    rates = np.abs(np.diff(made.q, axis=0)) / np.diff(made.times)[:, None]
    assert (rates <= rate_limits(ARM)).all()
    assert (rates / rate_limits(ARM)).max() > 0.99


def test_rows_put_in_lie_on_the_old_path() -> None:
    """A long stretch beside a fast one gets rows, on the straight way between its ends; nowhere else."""
    rows, t = np.array([[0.0], [0.1], [0.5], [0.6]]), np.array([0.0, 1.0, 1.1, 2.1])
    found = slowed_down(Trajectory("", t, rows, True, ()).curve("linear"), np.array([2.0]), np.array([np.inf]))
    assert found is not None
    made, (part,) = found
    old = np.interp(made.q[:, 0], rows[:, 0], t)
    assert set(rows[:, 0]) <= set(made.q[:, 0])
    speed = np.diff(old) / np.diff(made.times)
    assert abs(speed.min() - 0.5) < 1e-5
    assert speed[0] == 1.0
    assert np.abs(np.diff(speed)).max() < 0.1
    assert 1 - speed[1:4].min() < 0.01  # it begins smoothly
    assert np.isclose(made.times[-1] - t[-1], part.longer)


def test_limits_of_accelerations_are_kept_or_no_local_change_is_made() -> None:
    """Held against the accelerations of the mended rows, by differences; None where even the rest is too fast."""
    q, t = turning(places=(3.0,))
    path, most = Trajectory("", t, q, True, ()).curve("linear"), np.full(ARM.n, 60.0)
    found = slowed_down(path, rate_limits(ARM), most)
    assert found is not None
    made = found[0]
    speed = np.diff(made.q, axis=0) / np.diff(made.times)[:, None]
    bend = np.diff(speed, axis=0) / ((made.times[2:] - made.times[:-2]) / 2)[:, None]
    assert 10.0 < np.abs(bend).max() <= 60.0
    assert slowed_down(path, rate_limits(ARM), np.full(ARM.n, 0.1)) is None
    assert slowed_down(path, NONE, NONE) is None
