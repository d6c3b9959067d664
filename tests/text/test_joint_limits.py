"""Values within the joint limits: moved by whole turns, and those that no turn brings inside."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import pytest

from rankdrop.families.record import Pin
from rankdrop.results.known import shipped
from rankdrop.robot.open import open_robot
from rankdrop.text.joint_limits import inside_limits, outside_text


def test_slides_do_not_turn():
    robot, found = open_robot("stanford"), shipped("stanford")
    slides = [row for row in found.families if any(pin.number == 3 for pin in row.pinned)]
    assert slides
    for row in slides:
        values = next(pin.values for pin in row.pinned if pin.number == 3)
        inside = inside_limits(row, robot)
        kept = next(pin.values for pin in inside.pinned if pin.number == 3)
        assert kept == tuple(value for value in values if robot.lower[2] <= value <= robot.upper[2])


def test_a_row_outside_the_limits_says_so():
    """θ4 = 0 of a Panda is outside −3.07 … −0.07; of θ5 = 0 or π the latter is."""
    robot, found = open_robot("panda"), shipped("panda")
    told = []
    for row in found.families:
        inside = inside_limits(row, robot)
        for one in inside.outside:
            j = one.number - 1
            assert all(not robot.lower[j] <= value + 2 * pi * turn <= robot.upper[j]
                       for value in one.values for turn in (-1, 0, 1))  # fmt: skip
        if inside.outside:
            told.append(outside_text(inside, robot))
        assert inside.holds == all(one.values for one in inside.pinned)
    assert any("is outside" in text or "are outside" in text for text in told)
    assert any(text.startswith("the row lies outside the joint limits: ") for text in told)


def test_values_move_by_whole_turns_into_the_limits() -> None:
    """θ6 of a Panda goes from −0.0175 to 3.7525: −2.9 is 3.38 there; 4 is outside at every turn."""
    robot, found = open_robot("panda"), shipped("panda")
    row = replace(found.families[0], pinned=(Pin("panda_joint6", 6, (-2.9, 0.5, 4.0)),))
    inside = inside_limits(row, robot)
    assert inside.pinned[0].values == pytest.approx((2 * pi - 2.9, 0.5))
    assert inside.outside == (Pin("panda_joint6", 6, (4.0,)),)
    assert inside.holds
    assert outside_text(inside, robot) == "θ6 = 4.0000 (229.18°) is outside −0.0175 … 3.7525 rad"
    assert inside.with_values_inside(row).pinned == inside.pinned
