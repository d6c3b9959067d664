"""Conditions on the screen and in files."""

from __future__ import annotations

import pytest

from rankdrop.robot.open import open_robot
from rankdrop.text.conditions import steps_text
from rankdrop.verbs.conditions import conditions


@pytest.mark.by_hand
def test_long_factors_are_folded_on_the_screen_and_whole_in_the_file() -> None:
    found = conditions(open_robot("canadarm2"), method="cofactors", coranks=1, points=0, steps=True)
    screen, whole = str(found), steps_text(found)
    assert "a polynomial of 252 half-angle terms = 0" in screen
    assert "the whole of it: steps_text(conditions)" in screen
    assert "a polynomial of" not in whole
    assert "4 d c2 cos(θ4/2) s6 cos²(θ3 + θ4/2)" in whole
    said = found.determinants
    assert any("[17 sines and cosines, of θ2, θ3, θ4, θ5, θ6]" in line for line in said.lines(100))
    assert not any("sines and cosines" in line for line in said.lines(None))
