"""Nothing that is proven free holds an exact singular configuration; `benchmarks/soundness.py` tries a million."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from rankdrop.cover.setting import enclose

BENCHMARK = Path(__file__).resolve().parents[2] / "benchmarks" / "soundness.py"


@pytest.fixture(scope="module")
def soundness():
    spec = importlib.util.spec_from_file_location("soundness", BENCHMARK)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.by_hand
def test_a_few_hundred_hold(soundness):
    tally = soundness.run(300, 5, ("puma560", "almarkhi4"), tell=False)
    assert not any(tally.wrong.values()), tally.wrong
    assert min(tally.tried.values()) >= 2
    shares = np.concatenate(tally.shares)
    assert 0.9 < shares.max() <= 1.0 + 1e-12  # the bounds are not merely timid


@pytest.mark.by_hand
def test_bounds_that_are_too_small_are_noticed(soundness, monkeypatch):
    """Boxes of which only the middle is looked at are called free though they hold a singular configuration."""

    def short(robot, setting, q, half=None, **options):
        return enclose(robot, setting, q, None if half is None else 0.4 * half, **options)

    monkeypatch.setattr(soundness, "enclose", short)
    tally = soundness.run(200, 5, ("puma560",), tell=False)
    assert tally.wrong["boxes"] > 10


@pytest.mark.by_hand
def test_thirty_thousand_hold(soundness):
    tally = soundness.run(30_000, 2, tell=False)
    assert not any(tally.wrong.values()), tally.wrong
    assert tally.tried["boxes"] == tally.tried["curves"] == tally.tried["balls, one enclosure"] == 30_000
    assert tally.tried["coverings"] == 15_000
