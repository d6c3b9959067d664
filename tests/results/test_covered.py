"""A covering as a result: its width is that of its boxes, and it holds where known families explain all of them."""

from __future__ import annotations

from dataclasses import replace
from math import ceil, log2, pi

import numpy as np
import pytest

from rankdrop.results.covered import Covered
from rankdrop.results.known import known_analysis
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.verbs import cover

PLANAR = open_robot("planar3r")


@pytest.fixture(scope="module")
def planar() -> Covered:
    """Every singular configuration of a planar arm, in boxes of 0.2 rad."""
    return cover(PLANAR, width=0.2)


@pytest.mark.parametrize("width", [0.5, 0.2, 0.1])
def test_a_turn_is_halved_until_boxes_are_as_narrow_as_asked(width: float) -> None:
    halvings = ceil(log2(2 * pi / width))
    assert cover(PLANAR, width=width).width == pytest.approx(2 * pi / 2**halvings)


def test_sides_of_slides_are_measured_by_the_length_scale() -> None:
    """Of the Stanford arm the slide decides: a side of it is a length, of a tool in millimetres a thousand times it."""
    robot = open_robot("stanford")
    found = cover(robot, width=0.8)
    plan, shape = found.covering.plan, found.covering.tree.shape
    sides = (np.array(plan.upper) - plan.lower) / 2.0 ** np.array(shape.depth)
    slides = np.array([robot.variables[j - 1].unit != "rad" for j in plan.variables])
    assert slides.any()
    scaled = np.where(slides, sides / found.task.scale(robot), sides)
    assert found.width == pytest.approx(scaled.max())
    assert found.width <= 0.8


def test_boxes_that_no_family_explains_are_no_contradiction_and_do_not_hold(planar: Covered) -> None:
    known = known_analysis(PLANAR, resolve_task(None, PLANAR))
    assert known is not None
    assert planar.holds
    without = cover(PLANAR, width=0.2, analysis=replace(known, families=()))
    assert without.account is not None
    assert without.account.spots
    assert (without.complete, without.holds) == (True, False)
    assert replace(without, account=None).holds  # families were not asked for


def test_the_hash_is_that_of_plan_and_boxes(planar: Covered) -> None:
    again, finer = cover(PLANAR, width=0.2), cover(PLANAR, width=0.1)
    assert planar.sha256 == again.sha256 != finer.sha256
    assert len(planar.sha256) == 64
