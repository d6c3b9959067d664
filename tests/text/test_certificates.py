"""Result of checking a certificate in words: a claim that holds, with what it rests on; or why it is not confirmed."""

from __future__ import annotations

from rankdrop.cover.certificates import Verified
from rankdrop.text.certificates import verified_sections

HOLDS = Verified(
    True, "ball", "ur5", "No singular configuration is within 0.1 rad", enclosures=12_345,
    assumed=("the numbers of the arm",), statement=("arm: ur5", "task: pose"),
)  # fmt: skip
FAILS = Verified(False, "ball", "ur5", reason="the rank is not kept", enclosures=7, statement=("arm: ur5",))


def test_a_claim_that_holds_says_what_it_rests_on() -> None:
    (section,) = verified_sections(HOLDS)
    assert (section.title, section.summary, section.tone) == ("Holds", "ball of 'ur5'", "good")
    assert section.lines == ("No singular configuration is within 0.1 rad.", "arm: ur5", "task: pose")
    assert section.notes == ("12,345 enclosures of interval arithmetic", "the numbers of the arm")


def test_a_claim_that_is_not_confirmed_says_why_and_claims_nothing() -> None:
    (section,) = verified_sections(FAILS)
    assert (section.title, section.tone) == ("Not confirmed", "bad")
    assert section.lines == ("the rank is not kept.", "arm: ur5")
    assert section.notes == ("7 enclosures of interval arithmetic",)


def test_a_damaged_file_is_of_no_arm_and_took_no_work() -> None:
    (section,) = verified_sections(Verified(False, reason="the hash is another one"))
    assert (section.summary, section.notes) == ("certificate", ())
