"""A member of a family is attributed to that family, or to one that lies inside it and holds there too."""

from __future__ import annotations

import numpy as np
import pytest
from known.arms import KINDS
from known.members import members

from rankdrop.distance.monitor import Monitor
from rankdrop.errors import ConfigurationError
from rankdrop.families.incidence import families_at
from rankdrop.local.block import singular_values
from rankdrop.results.known import shipped

EACH = 5


@pytest.mark.spread(9)
@pytest.mark.slow
@pytest.mark.by_hand_at("tiago", "gen3", "sawyer", "xarm6", "yumi")
@pytest.mark.parametrize("name", KINDS)
def test_random_members_of_every_family_are_attributed_to_it(name):
    found = shipped(name)
    robot, task = found.robot, found.task
    monitor = Monitor(robot, task, found.families)
    for index, family in enumerate(found.families):
        q = members(robot, task, family, EACH, seed=3)
        assert len(q) == EACH, f"{family.id}: too few members to tell"
        seen = monitor.look(q)
        for row, configuration in enumerate(q):
            met = families_at(found.families, robot, configuration, task)
            assert any(one.family is family for one in met), (family.id, configuration)
            first = met[0].family
            assert first.corank == family.corank == seen.corank[row]
            assert first.dimension <= family.dimension, "inside it: the smaller one says more"
            named = found.families[seen.family[row]]
            assert (named.corank, named.dimension) == (first.corank, first.dimension)
            assert seen.residual[row] < 1e-8
            if first is family:
                assert seen.family[row] == index or named.dimension == first.dimension


@pytest.mark.parametrize("name", ["pa10", "ur5", "canadarm2", "stanford", "fetch", "z1"])
def test_no_regular_configuration_lies_on_a_family(name, rng):
    found = shipped(name)
    q = rng.uniform(-3, 3, (40, found.robot.n))
    sigma = singular_values(found.robot, q, found.task)[:, found.generic_rank - 1]
    assert (sigma > 1e-6).all()
    for configuration in q:
        assert families_at(found.families, found.robot, configuration, found.task) == ()
    seen = Monitor(found.robot, found.task, found.families).look(q)
    assert (seen.family == -1).all()
    assert (seen.nearest >= 0).all()


def test_a_family_of_higher_corank_is_not_claimed_beside_it():
    """1e-7 rad off a corank-2 row, along the larger family: corank 1 by σ, so the row of corank 2 does not hold."""
    found = shipped("pa10")
    q = np.array([0.3, 0.0, 0.4, 0.0, 0.2, 0.0, 1.0])  # θ2 = θ4 = θ6 = 0
    assert families_at(found.families, found.robot, q, found.task)[0].family.corank == 2
    q[1] = 1e-7
    met = families_at(found.families, found.robot, q, found.task)
    assert {one.family.corank for one in met} == {1}
    assert "elbow: arm stretched or folded" in {one.family.name for one in met}


def test_where_families_meet_all_of_them_are_named():
    found = shipped("iiwa14")
    q = np.array([0.0, 0.0, np.pi / 2, 0.0, 0.0, 1.2, 0.0])  # elbow, and shoulder with axes 2 ⟂ 4
    met = families_at(found.families, found.robot, q, found.task)
    corank = int((singular_values(found.robot, q, found.task) <= 1e-9).sum())
    assert corank == 1
    assert [one.family.corank for one in met] == [1, 1]
    assert [one.family.dimension for one in met] == [5, 6], "the smaller one first"
    assert met[0].family.name.startswith("shoulder")
    assert "elbow" in met[1].family.name


def test_broken_input_is_refused():
    found = shipped("pa10")
    for bad in (np.zeros(6), np.full(7, np.nan), np.zeros((2, 7))):
        with pytest.raises(ConfigurationError):
            families_at(found.families, found.robot, bad, found.task)
