"""The numbers of aspects of an arm, counted again."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rankdrop.aspects.arm import count_of_arm, summary_of
from rankdrop.results.known import catalogue_aspects
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.task import resolve_task

QUICK = ("planar2r", "ur5e", "iiwa14")

ANEW = [pytest.param(name, marks=() if name in QUICK else pytest.mark.by_hand) for name in robot_names()]


@pytest.mark.slow_at("iiwa14", "ur5e")
@pytest.mark.parametrize("name", ANEW)
def test_a_stored_number_is_counted_again(name: str) -> None:
    arm = open_robot(name)
    count, _ = count_of_arm(arm, resolve_task(None, arm))
    assert replace(catalogue_aspects()[name], posture_change=None) == summary_of(count)
