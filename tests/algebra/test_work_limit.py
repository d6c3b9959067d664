"""A limit on work ends a derivation at the same place on any machine."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from reference.arms import random_chain

pytest.importorskip("flint")

from rankdrop.algebra import work
from rankdrop.verbs.conditions import conditions


def ended(seconds: float) -> tuple[Any, ...]:
    """What a derivation that a limit ends has found, and what it left."""
    found = conditions(random_chain(np.random.default_rng(3), "rrrrrrr"), seconds=seconds, points=0)
    assert found.limited
    return [one.texts for one in found.families], found.left, [one.words for one in found.undivided]


@pytest.mark.slow
def test_a_slow_machine_ends_at_the_same_place(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nine times slower is within `SAFETY`; ten thousand times is not, and the answer says that time ended it."""
    monkeypatch.setattr(work, "process_time", work.work_spent)
    first = ended(0.15)
    monkeypatch.setattr(work, "process_time", lambda: 9.0 * work.work_spent())
    assert ended(0.15) == first
    monkeypatch.setattr(work, "process_time", lambda: 1e4 * work.work_spent())
    assert "the processor's time ran out" in ' '.join(map(str, ended(0.15)[1]))
