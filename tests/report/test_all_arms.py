"""Every arm of the catalogue has a report that is made in time and small enough to send."""

from __future__ import annotations

from time import process_time

import pytest

from rankdrop.known import known_names, shipped
from rankdrop.report.content import content
from rankdrop.report.page import page

SECONDS = 20.0
LARGEST = 15_000_000


@pytest.mark.slow
@pytest.mark.parametrize("name", known_names())
def test_the_report_of_a_catalogue_arm_is_made_in_time(name: str) -> None:
    begun = process_time()
    text = page(content(shipped(name)))
    assert process_time() - begun < SECONDS
    assert len(text.encode()) < LARGEST
    assert all(f'data-go="{family.id}"' in text for family in shipped(name).families)
