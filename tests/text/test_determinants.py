"""How determinants and their minors are worded."""

from __future__ import annotations

from itertools import combinations

from rankdrop.algebra.work import Work
from rankdrop.codec import encode
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.determinants import determinants_of
from rankdrop.robot.open import open_robot
from rankdrop.schema.families import DETERMINANTS


def test_minors_that_no_time_is_left_for_are_facts() -> None:
    """PA-10 has 7 minors of 6 columns: each is named in text and JSON, none of them computed."""
    found = determinants_of(exact_chain(open_robot("pa10")), Work(-1.0))
    assert [left.joints for left in found.left] == list(combinations(range(1, 8), 6))
    assert found.lines()[1] == "not done: |$1 $2 $3 $4 $5 $6|"
    assert encode(DETERMINANTS, found)["left"] == [str(left) for left in found.left]
