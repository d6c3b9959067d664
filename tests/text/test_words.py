"""Numbers and names in sentences."""

from __future__ import annotations

import pytest

from rankdrop.robot.open import open_robot
from rankdrop.sections import text
from rankdrop.text.words import angle_below, tolerant_sections, tolerant_sentence
from rankdrop.verbs.tolerant import most_tolerant


def test_the_proven_radius_is_rounded_down() -> None:
    assert angle_below(0.99999) == "0.9999 rad (57.2°)"
    assert angle_below(0.0) == "0 rad (0°)"
    assert angle_below(1e-5) in ("1e−5 rad (0.000572°)", "9.999e−6 rad (0.000572°)")


@pytest.mark.by_hand
def test_a_relative_best_below_the_bound_is_not_called_the_best_there_is():
    found = most_tolerant(open_robot("panda"), relative=True, starts=20, show=1)
    assert 0.0 < found.places[0].value < 0.5 * found.bound
    assert not found.optimal
    assert "none is better" not in text(tolerant_sections(found))


@pytest.mark.parametrize(("name", "crucial"), [("pa10", (4,)), ("ur5", (1, 2, 3, 4, 5, 6))])
def test_a_joint_that_is_always_needed_is_named(name, crucial):
    found = most_tolerant(open_robot(name))
    assert found.crucial == crucial
    assert found.places == ()
    assert found.complete
    told = tolerant_sentence(found)
    assert told.startswith(f"No configuration of {name} tolerates every single joint failure: ")
    assert not list(tolerant_sections(found))
    assert ("without joint 4 the rank is below 6" in told) == (name == "pa10")
