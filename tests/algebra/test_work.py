"""Limits on work, and the clock that counts it."""

from __future__ import annotations

import pytest

from rankdrop.algebra.work import GRACE, SAFETY, OutOfTime, Work, tick, work_spent


def test_the_clock_counts_work_and_a_share_of_it_ends_with_its_block() -> None:
    work = Work(100.0)
    before = work_spent()
    with work.share(0.1):
        assert work.remaining == pytest.approx(10.0)
        tick(9e6)
        work.check()
        tick(2e6)
        with pytest.raises(OutOfTime, match="limit on work"):
            work.check()
    assert work_spent() - before == pytest.approx(11.0)
    work.check()
    assert work.remaining == pytest.approx(89.0)
    assert work.restarted().remaining == pytest.approx(89.0)


def test_time_is_only_the_outermost_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 1000.0
    monkeypatch.setattr("rankdrop.algebra.work.process_time", lambda: now)
    work = Work(100.0)
    now += 0.9 * SAFETY * 100.0
    work.check()
    assert work.remaining == pytest.approx(100.0), "time passes, no work is done"
    now += 0.2 * SAFETY * 100.0
    for one in (work, work.restarted()):
        with pytest.raises(OutOfTime, match="processor's time"):
            one.check()
    work = Work(100.0)
    work.interrupt()
    assert work.time_left == GRACE
    assert work.remaining == pytest.approx(100.0)
