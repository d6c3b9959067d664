"""A slow straight motion is explained by a family of the arm itself, or of the ideal arm nearby."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.local.slowest import slowest_motions
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.verbs.explain import explain

SLOW = {"gen3": 0.04, "panda": 0.02, "rizon4": 0.005, "ur5e": 0.04}
"""Arm -> least share of its joint space in which some straight motion is slower than 25 mm/s, as drawn here."""


def drawn(arm: Robot, count: int, seed: int) -> Array:
    low, high = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    return np.random.default_rng(seed).uniform(low, high, (count, arm.n))


@pytest.mark.by_hand
@pytest.mark.slow_at("gen3")
@pytest.mark.parametrize("name", SLOW)
def test_nothing_slow_is_called_regular(name: str) -> None:
    """60 random configurations per arm at which some straight motion is limited to 25 mm/s by the maker's rates."""
    arm = open_robot(name)
    q = drawn(arm, 6000, seed=4)
    slow = slowest_motions(arm, q, resolve_task(None, arm))[0].speed < 0.025
    assert slow.mean() > SLOW[name]
    for one in q[slow][: 60 if name == "gen3" else 25]:
        found = explain(arm, one, evaluations=0)
        assert found.verdict != "regular"
        assert not found.sections()[0].title.endswith("is lost.")
        if found.cause == "slow":
            assert found.slow_family is not None
            assert any(line.startswith("Slow: at most") for line in found.sections()[0].lines)


def test_gen3_near_the_elbow_that_its_offsets_keep_from_being_exact() -> None:
    arm = open_robot("gen3")
    found = explain(arm, [0.3, 0.5, 0.2, 0.02, 0.4, 0.8, 0.1])
    assert (found.verdict, found.cause) == ("near", "slow")
    summary = found.summary
    assert (summary.ideal, summary.family.startswith("elbow")) == (True, True)
    assert summary.length == pytest.approx(0.01275, abs=1e-6)
    assert summary.distance == pytest.approx(0.02, abs=1e-9)
    translation = found.straight[0]
    assert (translation.number, translation.unit) == (4, "m/s")
    assert translation.speed == pytest.approx(0.00220, abs=5e-5)
    assert "offsets of 13 mm keep it from being exact" in str(found)
    assert found.to_dict()["slow_family"]["ideal"] is True
    assert explain(arm, found.q, speed=0.001, turn_speed=0.001).verdict == "regular"
    assert explain(arm, found.q, speed=0.0, turn_speed=0.0).verdict == "regular"


def test_a_slow_motion_near_a_family_of_the_arm_itself() -> None:
    """3.8° from a wrist singularity: regular by distance and σ, slow by the rates of the joints."""
    arm = open_robot("ur5e")
    found = explain(arm, [2.448, 1.364, 2.693, 0.802, -0.0668, 0.381])
    assert (found.verdict, found.cause) == ("near", "slow")
    assert not found.summary.ideal
    assert found.summary.family.startswith("wrist")
    assert found.summary.family_id
