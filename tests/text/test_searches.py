"""A search in words: every outcome that occurred, the smallest near miss, and how the unseen share was estimated."""

from __future__ import annotations

import pytest

from rankdrop.families.corank_families import Estimator, Unseen
from rankdrop.families.searching import Outcome, none_found, search, unseen
from rankdrop.robot.open import open_robot
from rankdrop.text.searches import sections_of, unseen_words


@pytest.mark.parametrize("name", ["planar3r", "puma560"])
def test_the_table_counts_every_start_once(name: str) -> None:
    found = search(open_robot(name), 1, starts=60, seed=1)
    (section,) = sections_of(found)
    assert section.title == f"{name}: search for corank 1"
    assert sum(int(number) for _, number in section.rows) == 60
    assert dict(section.rows)["converged"] == str(found.count(Outcome.CONVERGED))
    assert all(number != "0" for _, number in section.rows)


def test_the_smallest_near_miss_is_stated_as_not_singular() -> None:
    """No configuration of a PUMA has corank 4: every start that ends is a near miss."""
    found = search(open_robot("puma560"), 4, starts=60)
    (section,) = sections_of(found)
    assert found.smallest_near_miss is not None
    assert section.after == (f"smallest near miss σ = {found.smallest_near_miss:.4g}, not singular",)
    assert "converged" not in dict(section.rows)


@pytest.mark.parametrize(("counts", "words"), [
    (unseen([500, 300]), "Good–Turing: 0 of 2 pieces found once in 800 points; rule of three"),
    (unseen([90, 1, 2]), "Good–Turing: 1 of 3 pieces found once in 93 points"),
    (unseen([]), "no point was found"),
    (none_found(2000), "none of 2000 starts converged; rule of three on the starts"),
    (Unseen(0.5, 0.7, Estimator.STORED, text="{by} hand"), "{by} hand"),
])  # fmt: skip
def test_an_estimate_names_its_estimator_and_counts(counts: Unseen, words: str) -> None:
    assert unseen_words(counts) == words
