"""Remarks on the letters of an arm."""

from __future__ import annotations

from exact.lettered import arm

from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.remark import chain_remarks


def test_a_letter_that_no_length_has_is_told():
    found = exact_chain(arm({"h": 1.0, "L": 0.4}))
    assert "h" not in found.letters
    assert found.unused == (("h", 1.0),)
    assert "the letter h of the robot stands for no length" in str(chain_remarks(found)[0])
    assert exact_chain(arm({"h": 1.0}), lengths="numbers").unused == ()
    assert exact_chain(arm({"h": 1.0}), lengths={"L": 0.4}).unused == ()
