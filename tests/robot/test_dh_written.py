"""Letters of a table in plain signs, and what all its readers refuse alike."""

from __future__ import annotations

import pytest

from rankdrop.robot.dh_written import names_twist, plain_letters, two_arms


@pytest.mark.parametrize(
    ("text", "plain"),
    [("α₁", "alpha₁"), ("⍺ⱼ", "alphaⱼ"), ("θ + π", "theta + pi"), ("ϑ", "theta"), ("−90°", "-90°"), ("–90º", "-90°"),
     ("a, d", "a, d")],
)  # fmt: skip
def test_letters_and_signs_become_plain(text: str, plain: str) -> None:
    assert plain_letters(text) == plain


def test_the_twist_has_two_names() -> None:
    assert [names_twist(text) for text in ("Alpha [deg]", "link twist", "a, d, theta")] == [True, True, False]


def test_two_arms_are_refused_with_the_place_and_the_fix() -> None:
    assert str(two_arms("arm.py, line 3", "L1 again")) == (
        "arm.py, line 3: the file has two arms; got L1 again; fix: keep the rows of one arm"
    )
