"""What is kept of a derivation."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

import pytest

from rankdrop.families.contradiction import Contradiction, ContradictionKind
from rankdrop.families.derivation import DIFFERS
from rankdrop.results.conditions import Conditions
from rankdrop.robot.open import open_robot
from rankdrop.verbs.analyze import analyze
from rankdrop.verbs.conditions import conditions


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"disagreements": (Contradiction(ContradictionKind.RANK, "k1.f1", rank=3, wrong=2, tested=6),)},
            "k1.f1: the rank modulo a prime is not 3 at 2 of 6 random points",
        ),
        ({"generic_rank": 3}, "the rank is 3 almost everywhere exactly, 4 numerically"),
    ],
)
def test_ranks_that_differ_are_a_disagreement(monkeypatch: pytest.MonkeyPatch, change, said: str) -> None:
    """The families agree; the ranks alone do not."""
    robot = open_robot("scara")

    def changed(*args: Any, **options: Any) -> Conditions:
        return replace(conditions(*args, **options), **change)

    monkeypatch.setattr(sys.modules["rankdrop.verbs.conditions"], "conditions", changed)
    found = analyze(robot, starts=100, fresh=True).exact
    assert found is not None
    assert found.status == DIFFERS
    assert len(found.disagreements) == 1
    assert said in str(found.disagreements[0])
    assert not found.holds
