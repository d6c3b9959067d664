"""The families of one corank with what the search for them found: counts that add up."""

from __future__ import annotations

import pytest

from rankdrop.families.corank_families import CorankFamilies, CorankSummary, Estimator, Unseen
from rankdrop.families.record import Check
from rankdrop.results.analysis import Analysis


@pytest.mark.parametrize("estimator", Estimator)
def test_an_estimate_is_told_with_the_counts_that_it_used(estimator: Estimator) -> None:
    how = Unseen(0.1, 0.2, estimator, once=11, pieces=22, number=33, text="by hand").how
    counts = {"once": "11", "pieces": "22", "number": "33"}
    used = {Estimator.GOOD_TURING: ("once", "pieces", "number"), Estimator.NO_START: ("number",)}
    assert {name for name, count in counts.items() if count in how} == set(used.get(estimator, ()))
    assert (how == "by hand") == (estimator == Estimator.STORED)


def test_starts_and_fresh_points_of_an_analysis_add_up(found: Analysis) -> None:
    assert found.coranks
    for summary in found.coranks:
        assert summary.rank + summary.corank == found.generic_rank
        assert summary.starts > 0
        assert summary.converged + summary.near_misses + summary.slow <= summary.starts
        assert 0 <= summary.completeness.agree <= summary.completeness.tested
        assert summary.higher >= 0
        assert 0.0 <= summary.unseen.estimate <= summary.unseen.upper <= 1.0
        assert (summary.smallest_near_miss is None) == (summary.near_misses == 0)


def test_a_corank_without_contradictions_says_so_by_its_defaults() -> None:
    unseen = Unseen(1.0, 1.0, Estimator.NO_POINT)
    families = CorankFamilies(CorankSummary(1, 5, 10, 0, 10, 0, 0.3, Check(0, 0), 0, unseen), ())
    assert (families.contradictions, families.mistaken) == ((), 0)
    assert families.lowest > 1e300  # no minimum of σ next to the threshold
