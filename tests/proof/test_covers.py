"""Coverings, checked."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import flint
import numpy as np
import pytest
from proof.tasks import covers_task
from reference import arms
from reference.coverings import covering

from rankdrop.cover.certificates import covering_certificate, verify, write_certificate
from rankdrop.cover.covering import write_covering
from rankdrop.cover.setting import middle_of
from rankdrop.proof import covers
from rankdrop.proof.arm import Arm
from rankdrop.proof.boxes import digest
from rankdrop.proof.record import Link, Unproven
from rankdrop.robot.open import open_robot

pytestmark = pytest.mark.usefixtures("precise")


@pytest.mark.parametrize(("short", "whole"), [(0.0, True), (1e-12, False), (1e-6, False), (1e-3, False)])
def test_a_turn_that_is_a_little_short_is_none(tmp_path, short, whole):
    """A false covering: its boxes are all truly free, and the singular θ2 = 0 lies in the gap of its range."""
    robot = open_robot("planar3r")
    low, high = short / 2, 2 * np.pi - short / 2
    joints = tuple(replace(joint, lower=low, upper=high) if j == 1 else joint for j, joint in enumerate(robot.joints))
    found = covering(replace(robot, joints=joints), 0.4, limits=True)
    plan = replace(found.plan, limits=False, turns=(True,))
    write_covering(tmp_path / "a.cover", replace(found, plan=plan))
    record = covering_certificate(robot, plan, digest(plan, found.tree), "a.cover", covers_task(robot))
    told = verify(write_certificate(record, tmp_path / "a.json"), every=True)
    assert plan.variables == (2,)
    assert told.holds == whole, told.reason
    assert whole or "said to be a turn, and is none" in told.reason


def test_a_determinant_that_leaves_out_a_joint_that_decides_is_refused():
    """With it at 0 the others have a polynomial of their own, of which any box may be free."""
    robot = arms.random_chain(np.random.default_rng(3), "rrrrrr")
    links = [Link("revolute", tuple(joint.screw.tolist()), j) for j, joint in enumerate(robot.joints)]
    arm = Arm(links, 6, 3, [flint.arb(float(x)) for x in middle_of(robot)], flint.arb(1))
    assert arm.moving == [1, 2, 3, 4]
    for left in arm.moving:
        places = [j for j in arm.moving if j != left]
        with pytest.raises(Unproven, match="no trigonometric polynomial"):
            covers.Determinant(arm, [0, 1, 2, 3, 4, 5], places, (0.0,) * 3, (1.0,) * 3, 0.0)


@pytest.mark.parametrize("left", [0, 1, 2, 3])
def test_ranges_that_leave_out_a_joint_that_decides_are_refused(left):
    robot = arms.random_chain(np.random.default_rng(3), "rrrrrr")
    links = [Link("revolute", tuple(joint.screw.tolist()), j) for j, joint in enumerate(robot.joints)]
    variables = [j for place, j in enumerate((2, 3, 4, 5)) if place != left]
    entries = {"variables": variables, "lower": [-np.pi] * 3, "upper": [3.2] * 3, "turns": [True] * 3, "limits": False}
    claim: Any = SimpleNamespace(entries=entries, variables=6, links=links, limits=None)
    covers.check_ranges(claim, [j - 1 for j in variables])
    with pytest.raises(Unproven, match="leaves out a joint that decides"):
        covers.check_ranges(claim, [1, 2, 3, 4])
