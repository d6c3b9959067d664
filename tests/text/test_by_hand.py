"""The steps of a derivation by hand, as they are printed."""

import pytest

from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.suppression import suppress
from rankdrop.robot.open import open_robot
from rankdrop.text.by_hand import steps_of


@pytest.mark.by_hand
def test_why_these_screws_and_this_frame_is_told():
    """KG's rules with counts: of Canadarm2's sixes 1–6 and 2–7 are in a row with joints 3, 4, 5."""
    found = suppress(exact_chain(open_robot("canadarm2")))
    assert (
        "why these: (a) not dependent everywhere: 7 of 7 sixes; (b) with three joints that are one, 3–5 (planar): 4; "
        "(c) in a row: 2; terms of the determinant: 10 for 1–6, 10 for 2–7; of equals the last"
        in steps_of(found.chain, found)[1].lines
    )
    why = steps_of(found.chain, found)[0].lines[1]
    assert why.startswith("why this frame: the screws are shortest there; terms, multiplied out")
    assert f"link {found.frame}: {sum(len(x) for column in found.columns for x in column)}" in why
