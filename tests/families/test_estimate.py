"""The estimate of what sampling has not seen."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.families.evidence import FamilyEvidence, ObtainedFrom
from rankdrop.families.record import Estimator, Unseen
from rankdrop.families.searching import binomial_upper, none_found, unseen
from rankdrop.results.estimate import evidence_of_sentence, unseen_of_sentence


def test_without_singletons_it_is_the_rule_of_three():
    result = unseen([500, 300, 200])
    assert result.estimate == 0.0
    assert result.upper == pytest.approx(3 / 1000, rel=1e-2)
    assert "rule of three" in result.how


def test_singletons_are_counted():
    result = unseen([90, 1, 1, 1, 2, 5, 0])
    assert result.estimate == pytest.approx(3 / 100)
    assert 0.03 < result.upper < 0.12


def test_without_points_nothing_is_known():
    assert unseen([]).estimate == 1.0
    assert unseen([0, 0]).upper == 1.0


def test_when_nothing_converges_the_starts_bound_it():
    result = none_found(2000)
    assert result.estimate == 0.0
    assert result.upper == pytest.approx(3 / 2000, rel=1e-2)


def test_bound_is_exact_at_the_ends():
    assert binomial_upper(5, 5) == 1.0
    assert binomial_upper(0, 1) == pytest.approx(0.95)


def test_bound_holds_at_least_nineteen_times_in_twenty(rng):
    """40 pieces, some rare: the true unseen mass is below the bound."""
    weights = 1.0 / np.arange(1, 41) ** 2
    weights /= weights.sum()
    inside = 0
    for _ in range(300):
        counts = rng.multinomial(150, weights)
        inside += unseen(counts.tolist()).upper >= weights[counts == 0].sum()
    assert inside >= 0.95 * 300


@pytest.mark.parametrize(
    "result",
    [unseen([500, 300]), unseen([90, 1, 2, 0]), unseen([]), none_found(2000),
     Unseen(0.5, 0.7, Estimator.STORED, text="Good–Turing: 0 of 5 pieces found once in 10 points, by hand"),
     Unseen(0.5, 0.7, Estimator.STORED, text=f"none of {'9' * 5000} starts converged; rule of three on the starts")],
)  # fmt: skip
def test_a_file_that_has_the_estimate_in_words_is_read_as_counts(result: Unseen) -> None:
    assert unseen_of_sentence(result.how, result.estimate, result.upper) == result


@pytest.mark.parametrize(("sentence", "kind"), [
    ("exact condition", ObtainedFrom.EXACT), ("values verified", ObtainedFrom.VALUES),
    ("fitted, then verified", ObtainedFrom.FITTED), ("shared values, verified", ObtainedFrom.SHARED_VALUES),
    ("12 points of the cloud and 3 fresh ones, no condition found", ObtainedFrom.STORED),
])  # fmt: skip
def test_the_evidence_of_a_file_keeps_its_sentence(sentence: str, kind: ObtainedFrom) -> None:
    found = evidence_of_sentence(sentence)
    assert (found.kind, str(found)) == (kind, sentence)


def test_evidence_without_a_clear_rank_bounds_the_dimension() -> None:
    assert str(FamilyEvidence(ObtainedFrom.CLOUD, cloud=12, fresh=3, clear_rank=False)) == (
        "12 points of the cloud and 3 fresh ones, no condition found; D has no clear rank there, so that the "
        "dimension is an upper bound"
    )
