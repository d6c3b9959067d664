"""How a sweep is worded: its winner, or why it has none."""

from __future__ import annotations

import pytest

import rankdrop


@pytest.mark.slow
def test_where_no_variant_has_a_measure_none_is_ranked_and_the_sentence_says_which() -> None:
    """The region is out of reach."""
    found = rankdrop.sweep({
        "robot": "planar3r", "parameters": {"forearm": {"sets": "3.a", "values": [0.3, 0.4]}},
        "region": {"lower": [5, 5, 0], "upper": [6, 6, 0], "points": 2, "rpy": [0, 0, 0]},
    }, workers=1)  # fmt: skip
    assert found.pareto == []
    assert found.sentence == "None of 2 variants of planar3r is ranked: none has sigma."
    titles = [section.title for section in found.sections()]
    assert "Variants" in titles
    assert "Pareto-optimal variants" not in titles
