"""An arm of each kind has a report of all its families that is small enough to send."""

from __future__ import annotations

import pytest
from known.arms import KINDS

from rankdrop.report.content import content
from rankdrop.report.page import page
from rankdrop.results.known import shipped

LARGEST = 15_000_000


@pytest.mark.spread(2)
@pytest.mark.by_hand_at(
    "yumi", "tiago", "fr3", "z1", "hc10", "mycobot280", "anthropomorphic", "fetch", "irb140", "irb6640", "kr16",
    "kr210l150", "m1013", "puma560", "rcrrrr",
)  # fmt: skip
@pytest.mark.by_hand_at("almarkhi4", "iiwa14", "pa10")
@pytest.mark.by_hand_at("canadarm2", "fetch8", "gen3", "panda", "sawyer", "ur5", "ur5e", "xarm6", "xarm7")
@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_the_report_of_a_catalogue_arm_has_all_its_families_and_can_be_sent(name: str) -> None:
    text = page(content(shipped(name)))
    assert len(text.encode()) < LARGEST
    assert all(f'data-go="{family.id}"' in text for family in shipped(name).families)
