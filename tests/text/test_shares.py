"""Shares of the joint space in words: rounded alike in table, line and total, and a bound is marked as one."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rankdrop.distance.share import JointSpaceShares, NearShare, SlowShare
from rankdrop.results.known import shipped
from rankdrop.text.shares import near_overview, near_total, share_cell, slow_configurations, slow_line

FAMILIES = shipped("puma560").families
SOME = NearShare(FAMILIES[0].id, 775, 10_000, False)
ANY = NearShare("", 1_234, 10_000, True)


def near(*shares: NearShare, slow: NearShare | None = None) -> JointSpaceShares:
    return JointSpaceShares(0.0872664625997, 10_000, 7, True, shares, ANY, slow)


@pytest.mark.parametrize(
    ("count", "bound", "text"),
    [(775, False, "7.75 %"), (570, True, "≥ 5.7 %"), (0, False, "0 %"), (10_000, False, "100 %")],
)
def test_a_share_has_three_digits_and_a_mark_where_it_may_be_larger(count: int, bound: bool, text: str) -> None:
    assert share_cell(NearShare("", count, 10_000, bound)) == text


def test_a_table_of_shares_has_families_by_name_then_any_then_slow() -> None:
    section = near_overview(near(SOME, slow=NearShare("", 50, 10_000, False)), FAMILIES)
    assert section.title == "Within 5° of singularities"
    assert [row[:3] for row in section.rows] == [
        (FAMILIES[0].id, FAMILIES[0].name, "7.75 %"), ("any", "", "≥ 12.3 %"),
        ("slow", "tool slower than 25 mm/s or 5°/s, inside the limits", "0.5 %"),
    ]  # fmt: skip
    low, high = SOME.interval
    assert section.rows[0][4] == f"{100 * low:.2g} … {100 * high:.2g} %"
    assert any("seed 7" in note for note in section.notes)
    assert any(note.startswith("≥: ") for note in section.notes)


def test_of_many_families_the_largest_shares_are_shown() -> None:
    """Rows of calibrated arms are hundreds; the note says how many there are."""
    many = [NearShare(f"f{k}", k, 10_000, False) for k in range(40)]
    section = near_overview(near(*many), ())
    assert [row[0] for row in section.rows[:-1]] == [f"f{k}" for k in range(39, 31, -1)]
    assert "the 8 largest of 40; all of them in the JSON" in section.notes


def test_a_total_has_the_slow_share_where_the_arm_has_rate_limits() -> None:
    alone = near_total(near(SOME))
    assert alone == f"any: ≥ 12.3 % ± {100 * ANY.error:.2g} %"
    assert near_total(near(SOME, slow=SOME)) == f"{alone}; tool slower than 25 mm/s or 5°/s: 7.75 %"


def test_slow_configurations_have_their_speed_interval_and_samples() -> None:
    low, high = (f"{100 * end:.3g}" for end in SOME.interval)
    line = slow_line(SlowShare(0.25, SOME, 3))
    assert "At 7.75 % of the configurations" in line
    assert f"slower than 250 mm/s in its worst direction (95 %: {low} … {high} %): 10,000 random" in line
    page = slow_configurations(replace(SOME, bound=True), 0.025, 0.0872664626)
    assert page.startswith("below 25 mm/s or 5°/s in some direction: ≥ 7.75 % of configurations inside limits ")
    assert f"(95 %: {low} … {high} %; 10,000 random ones" in page
    assert slow_configurations(None, 0.025, 0.1).startswith("unknown: too few joints have a rate limit")
