"""What a family of exact conditions assumes."""

from __future__ import annotations

from dataclasses import replace

from rankdrop.exact.family import Assumption
from rankdrop.robot.open import open_robot
from rankdrop.verbs.conditions import conditions


def test_an_assumption_that_is_false_is_no_exact_derivation() -> None:
    found = conditions(open_robot("planar3r"))
    assert found.verified
    wrong = replace(found, assumptions=(Assumption("a2 ≠ d4", holds=False, derived=False),))
    assert not wrong.verified
    assert wrong.verdict.word == "incomplete"
    assert wrong.verdict.claims in ((), ("sampled",))
    assert "a2 ≠ d4 is assumed, which is not true of this arm" in wrong.verdict.sentence
