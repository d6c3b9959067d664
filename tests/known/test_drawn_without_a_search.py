"""Exact singular configurations drawn without a search against the families that are shipped: two gates.

Coverage: every family of every corank is met. Precision: every configuration is singular for an independent model of
the arm, and lies on a family. Thirteen arms, nine of them with `-m slow`. Of the Cobotta two families of corank 2,
each of two dimensions, are missed by as few draws: it is not among them.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from reference.kinematics import jacobian

from rankdrop.families.reciprocal import EXACT
from rankdrop.families.search_record import Search
from rankdrop.families.searching import search
from rankdrop.family.record import Family
from rankdrop.family.which import families_at
from rankdrop.results.known import shipped
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.tolerances import DEFAULT

QUICK = ("almarkhi4", "puma560", "scara", "planar3r")
MORE = ("anthropomorphic", "baxter", "canadarm2", "e0509", "fetch", "fetch8", "fr3", "gen3", "ur5")
COUNT = 600
ARMS = [*QUICK, *(pytest.param(name, marks=pytest.mark.slow) for name in MORE)]


@cache
def met(name: str) -> list[tuple[Search, list[list[Family]]]]:
    """For every corank that has families: what is drawn, and the families each lies on."""
    robot, found = open_robot(name), shipped(name)
    task = resolve_task(None, robot)
    made = []
    for corank in sorted({one.corank for one in found.families}):
        drawn = search(robot, corank, starts=COUNT, method="reciprocal", seed=1)
        on = [[one.family for one in families_at(found.families, robot, q, task, DEFAULT)] for q in drawn.q]
        made.append((drawn, on))
    return made


@pytest.mark.parametrize("name", ARMS)
def test_every_family_is_met(name: str) -> None:
    there = {family.id for _, on in met(name) for here in on for family in here}
    assert {one.id for one in shipped(name).families} <= there


@pytest.mark.parametrize("name", ARMS)
def test_every_configuration_is_singular_and_on_a_family(name: str) -> None:
    robot = open_robot(name)
    task = resolve_task(None, robot)
    scale = task.scale(robot)
    unit = np.array([scale if row < 3 else 1.0 for row in task.rows])[:, None]
    for drawn, on in met(name):
        assert len(drawn.q) == COUNT
        assert all(any(one.corank >= drawn.corank for one in here) for here in on)
        if task.frame.axes != 0 or task.frame.origin != -1:
            continue  # the model of the tests knows the tip in base axes
        for q in drawn.q[:50]:
            sigma = np.linalg.svd(jacobian(robot, q)[list(task.rows)] / unit, compute_uv=False)
            assert sigma[drawn.rank] <= 10 * EXACT * sigma[0]
