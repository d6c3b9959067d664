"""Elimination case by case: which pivots vanish, and which minors border the last one."""

from __future__ import annotations

import pytest
from exact.chains import chain_of
from exact.strata import derived, holds_at, holds_modulo, strata

from rankdrop.exact.methods import derive


@pytest.mark.slow
def test_a_case_analysis_that_is_cut_short_keeps_what_it_found() -> None:
    found = derive(chain_of("canadarm2"), "singular_vector", 0.1)
    assert not found.complete
    assert found.generic
    assert "cases" in str(found.left[0])
    points, singular = strata("canadarm2")
    held = holds_modulo(found, points)
    assert any(held)
    assert all(is_singular for is_singular, holds in zip(singular, held, strict=True) if holds)


@pytest.mark.parametrize("name", ["anthropomorphic", "stanford", "puma560"])
def test_every_case_of_a_pivot_is_followed(name: str) -> None:
    """Where a pivot vanishes the elimination goes on with another one: cases together hold where the rank drops."""
    found = derived(name, "singular_vector")
    points, singular = strata(name, 100)
    assert found.sizes["cases"] > 1
    assert holds_modulo(found, points) == singular
    first = [holds_at(found.conditions[0], found.ring, point) for point in points]
    assert sum(first) < sum(singular)
