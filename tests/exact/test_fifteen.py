"""Random structured arms with twists in multiples of 15°, any task: derived to the end, and nothing is missed."""

from __future__ import annotations

import pytest
from reference.structured import fifteen

from rankdrop.verbs.conditions import conditions


@pytest.mark.spread(2)
@pytest.mark.slow
@pytest.mark.by_hand_at("8", "21", "39")
@pytest.mark.parametrize(
    "seed", [11, 16, 17, 19, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (3, 8, 14, 21, 37, 39))]
)
def test_a_structured_arm_is_complete_and_explains_what_the_search_finds(seed: int) -> None:
    robot, task = fifteen(seed)
    found = conditions(robot, task, method="tree", points=200, seconds=60.0)
    assert found.complete, found.left
    assert found.verified, found.verdict.sentence
    assert found.explained.holds


@pytest.mark.slow
def test_minors_that_vanish_together_on_curves_are_taken_apart() -> None:
    robot, task = fifteen(37)
    found = conditions(robot, task, method="tree", points=0, seconds=60.0)
    assert found.in_families
    assert not found.undivided
