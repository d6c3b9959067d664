"""Exact singular configurations drawn without a search against the families that are shipped: two gates.

Coverage: every family of every corank is met, of one arm of every structure of the catalogue (all but four with
`-m slow`). Precision: every configuration is singular for an independent model of the arm, and lies on a family.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from reference.kinematics import jacobian

from known.arms import STRUCTURES
from rankdrop.families.incidence import families_at
from rankdrop.families.reciprocal import EXACT
from rankdrop.families.record import Family
from rankdrop.families.searching import Search, search
from rankdrop.results.known import shipped
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.tolerances import DEFAULT

QUICK = ("almarkhi4", "puma560", "scara", "planar3r")
COUNT = 600
MORE = {"tiago": 1200, "yumi": 2400}
"""Configurations of each corank, where the usual number is not enough."""
POINTS = "yumi"
"""42 of its 47 families are single points of five joints, of which random starts lead to some far more often than to
others: 2,400 configurations meet most of them."""
UNFINISHED = ("rizon10",)
"""Its analysis says so: not every singular configuration is on one of its families."""
ARMS = [*QUICK, *(pytest.param(name, marks=pytest.mark.by_hand) for name in STRUCTURES if name not in QUICK)]


@cache
def drawn(name: str, corank: int) -> Search:
    """What is drawn of a corank."""
    return search(open_robot(name), corank, starts=MORE.get(name, COUNT), method="reciprocal", seed=1)


def unmet(name: str) -> list[Family]:
    """Families on which nothing lies that is drawn."""
    robot, families = open_robot(name), shipped(name).families
    task = resolve_task(None, robot)
    left = list(families)
    for corank in coranks(name):
        for q in drawn(name, corank).q:
            here = {one.family.id for one in families_at(left, robot, q, task, DEFAULT)} if left else set()
            left = [one for one in left if one.id not in here]
    return left


def coranks(name: str) -> list[int]:
    """Those of which the arm has families."""
    return sorted({one.corank for one in shipped(name).families})


@pytest.mark.spread(1)
@pytest.mark.by_hand_at("almarkhi4", "puma560")
@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_every_family_is_met(name: str) -> None:
    left = unmet(name)
    if name == POINTS:
        assert len(left) <= len(shipped(name).families) // 4
    else:
        assert not left, [(one.id, one.name) for one in left]


@pytest.mark.slow_at("almarkhi4", "planar3r")
@pytest.mark.by_hand_at("puma560")
@pytest.mark.slow_at("puma560")
@pytest.mark.parametrize("name", ARMS)
def test_every_configuration_is_singular_and_on_a_family(name: str) -> None:
    robot = open_robot(name)
    task = resolve_task(None, robot)
    scale = task.scale(robot)
    unit = np.array([scale if row < 3 else 1.0 for row in task.rows])[:, None]
    for corank in coranks(name):
        found = drawn(name, corank)
        assert len(found.q) == MORE.get(name, COUNT)
        if name not in UNFINISHED:
            families = [one for one in shipped(name).families if one.corank >= corank]
            assert all(families_at(families, robot, q, task, DEFAULT) for q in found.q[:COUNT])
        if task.frame.axes != 0 or task.frame.origin != -1:
            continue  # the model of the tests knows the tip in base axes
        for q in found.q[:50]:
            sigma = np.linalg.svd(jacobian(robot, q)[list(task.rows)] / unit, compute_uv=False)
            assert sigma[found.rank] <= 10 * EXACT * sigma[0]
