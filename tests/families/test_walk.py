"""Walks along one family, and slices of the singular set."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.errors import OptionError
from rankdrop.families.walk import Walk, in_slice
from rankdrop.formula.equation import System
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.results.known import known_analysis
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

ARMS = ("ur5", "pa10", "puma560", "stanford", "scara")


@pytest.mark.parametrize("name", ARMS)
def test_every_step_stays_on_the_family_and_moves_the_joint(name: str) -> None:
    arm = open_robot(name)
    task = resolve_task(None, arm)
    known = known_analysis(arm, task)
    assert known is not None
    for family in known.families:
        walk, start = Walk(arm, task, family), np.array(family.witness)
        assert walk.tangent(start).shape == (arm.n, family.dimension)
        for joint in walk.movable(start):
            q = start
            for _ in range(5):
                following = walk.step(q, joint, 0.03)
                assert following is not None
                assert 0 < np.linalg.norm(following - q) < 0.1 * max(1.0, task.scale(arm))
                q = following
            assert np.abs(System(family.equations).values(q[None])).max() <= 1e-9
            assert singular_values(arm, q, task)[generic_rank(arm, task) - family.corank] <= 1e-9
            assert (q - start)[joint - 1] != 0.0


def test_a_pinned_joint_cannot_be_walked() -> None:
    arm = open_robot("pa10")
    task = resolve_task(None, arm)
    known = known_analysis(arm, task)
    assert known is not None
    elbow = known.families[0]
    walk = Walk(arm, task, elbow)
    assert 4 not in walk.movable(elbow.witness)
    assert walk.step(elbow.witness, 4, 0.1) is None


def test_a_family_without_equations_is_walked_by_the_block() -> None:
    from dataclasses import replace

    arm = open_robot("ur5")
    task = resolve_task(None, arm)
    known = known_analysis(arm, task)
    assert known is not None
    wrist = known.families[2]
    bare = replace(wrist, equations=(), named=False)
    there, same = (Walk(arm, task, one).step(wrist.witness, 2, 0.05) for one in (wrist, bare))
    assert there is not None
    assert same is not None
    assert np.abs(there - same).max() < 1e-6


def test_slice_of_ur5_shows_elbow_and_shoulder_curves() -> None:
    arm = open_robot("ur5")
    task = resolve_task(None, arm)
    q = np.array([0.3, -1.0, 0.8, 0.4, 0.9, 0.1])
    found = in_slice(arm, task, q, (2, 3), starts=300)
    assert len(found.q) == 300
    others = [0, 3, 4, 5]
    assert (found.q[:, others] == q[others]).all()
    assert singular_values(arm, found.q, task)[:, 5].max() <= 1e-9
    elbow = np.abs(np.sin(found.q[:, 2])) < 1e-8
    assert 0 < elbow.sum() < 300  # sin θ3 = 0, and the curve of the shoulder


def test_a_set_of_codimension_two_is_met_by_a_plane_in_points_only() -> None:
    arm = open_robot("pa10")
    task = resolve_task(None, arm)
    found = in_slice(arm, task, [0.3, 0.5, 0.2, 0.9, 0.7, 0.4, 0.1], (2, 3), starts=400)
    assert len(found.q) > 0
    assert (np.abs(np.sin(found.q[:, 1])) < 1e-8).all()  # sin θ2 = cos θ3 = 0 is the only family there
    assert (np.abs(np.cos(found.q[:, 2])) < 1e-8).all()


def test_a_slice_that_misses_the_set_is_empty() -> None:
    arm = open_robot("gen3")
    found = in_slice(arm, resolve_task(None, arm), [0.3, 0.5, 0.2, 0.9, 0.7, 0.8, 0.1], (1, 7), starts=50)
    assert len(found.q) == 0


def test_limits_keep_the_points_inside() -> None:
    arm = open_robot("panda")
    task = resolve_task(None, arm)
    found = in_slice(arm, task, 0.5 * (arm.lower + arm.upper) + 0.1, (2, 3, 4), starts=200, limits=True)
    assert (found.q >= arm.lower - 1e-6).all()
    assert (found.q <= arm.upper + 1e-6).all()


def test_same_seed_same_points() -> None:
    arm = open_robot("scara")
    task = resolve_task(None, arm)
    one, same = (in_slice(arm, task, [0.1] * 4, (1, 2), starts=40, seed=3) for _ in range(2))
    assert (one.q == same.q).all()


@pytest.mark.parametrize("joints", [(), (0, 1), (2, 2), (1, 9)])
def test_joints_that_span_no_slice_are_refused(joints: tuple[int, ...]) -> None:
    arm = open_robot("scara")
    with pytest.raises(OptionError, match="no slice"):
        in_slice(arm, resolve_task(None, arm), [0.1] * 4, joints)
