"""Random structured arms with twists in multiples of 15°, any task: derived to the end, and nothing is missed."""

from __future__ import annotations

import numpy as np
import pytest
from reference.structured import fifteen

from rankdrop.exact import tree
from rankdrop.formula.equation import System
from rankdrop.results.conditions import Conditions
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
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


def _of_special_lengths() -> Robot:
    """For general lengths no corank 2 at θ2, θ4, θ5 = ±π/2: here a3 = 2 a1 = −2 d2."""
    h = np.pi / 2
    first = [(0.2, -h, -0.2, 0.0), (0.0, -h, -0.2, 0.0), (0.4, 0.0, -0.2, 0.0)]
    last = [(0.2, -h, 0.0, 0.0), (0.4, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)]
    return from_dh([*first, *last], convention="standard", name="lengths")


def _holds(found: Conditions) -> bool:
    h = np.pi / 2
    return any(System(one.equations).zero(np.array([[-0.2, h, np.pi, h, h, 3.0]]))[0] for one in found.of_corank(2))


@pytest.mark.slow
def test_a_rank_that_is_lost_for_these_lengths_only_is_derived() -> None:
    """Where all joints are bound, no minor was factored: the relation of lengths was met nowhere."""
    found = conditions(_of_special_lengths(), "vx,vy,vz,wx,wy", method="tree", points=0, special=False, coranks=2)
    assert found.letters
    assert _holds(found)


@pytest.mark.by_hand
def test_where_sampling_contradicts_letters_numbers_are_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tree, "_lower_for_these_lengths", lambda *_: False)
    found = conditions(_of_special_lengths(), "vx,vy,vz,wx,wy", method="tree", points=200, special=False)
    assert found.verified, found.verdict.sentence
    assert found.in_families
    assert not found.letters
    assert any("conditions for general lengths miss" in str(remark) for remark in found.remarks)
    assert _holds(found)
