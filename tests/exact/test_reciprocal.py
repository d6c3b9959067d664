"""Conditions of higher coranks by reciprocal screws."""

from __future__ import annotations

import pytest
from exact.derived import derived

from rankdrop.exact import reciprocal
from rankdrop.exact.conjunctions import Conjunction


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "said"),
    [([], "found numerically, where they do not hold"), ([Conjunction(())], "of a lower corank, where they hold")],
    ids=["too few", "too many"],
)
def test_wrong_conditions_of_a_higher_corank_are_disagreements(
    fault: list[Conjunction], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reciprocal, "_products_vanish", lambda *_: fault)
    found = derived("stanford")
    assert found.verdict.word == "contradicted"
    assert "for corank 2 are wrong on " in str(found.disagreements[0])
    assert any(str(one).endswith(said) for one in found.disagreements)
