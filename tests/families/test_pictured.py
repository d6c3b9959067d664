"""Postures of pictures: upright, inside the limits, seen from the side, and called by the part of the arm."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rankdrop.families import pose_witness
from rankdrop.families.pictured import TALL, height, upright, upright_start
from rankdrop.local import fault, singular_values
from rankdrop.results.known import shipped


@pytest.mark.parametrize("name", ["pa10", "crx10ial"])
def test_an_arm_is_drawn_upright(name: str) -> None:
    """Both lay on the floor (0.18 and 0.22 of the reach)."""
    found = shipped(name)
    robot, task = found.robot, found.task
    before = [pose_witness(robot, task, family, found.families) for family in found.families]
    after = [upright(robot, task, family, found.families) for family in found.families]
    assert min(height(robot, np.array([one.witness for one in before]))) < 0.25
    for family, usual in zip(after, before, strict=True):
        q = np.array(family.witness)
        assert height(robot, q[None])[0] >= 0.95 * TALL
        assert ((q >= robot.lower - 1e-9) & (q <= robot.upper + 1e-9)).all()
        assert fault(robot, q[None])[0] <= fault(robot, np.array([usual.witness]))[0] + 0.15 + 1e-9
        sigma = singular_values(robot, q, task)
        assert (sigma[-family.corank :] <= 1e-9).all()
        assert sigma[-family.corank - 1] > 1e-3


def test_a_member_inside_the_limits_is_drawn_where_round_starts_lead_to_none() -> None:
    """The family enters the box of joint limits at one corner only: its middle is joined to members outside."""
    found = shipped("ur5e")
    family = next(one for one in found.families if one.coupled)
    corner = np.array(family.witness)
    bound = [number - 1 for number in family.coupled]
    slope = family.system.linear(corner[None])[1][0, 0, bound]
    low, high = found.robot.lower.copy(), found.robot.upper.copy()
    step = np.sign(slope) * np.array([0.08, 0.01, 0.16])
    low[bound] = corner[bound] + np.minimum(-0.004 * np.sign(slope), step)
    high[bound] = corner[bound] + np.maximum(-0.004 * np.sign(slope), step)
    joints = tuple(
        replace(joint, lower=float(first), upper=float(last))
        for joint, first, last in zip(found.robot.joints, low, high, strict=True)
    )
    arm = replace(found.robot, joints=joints)
    away = replace(family, witness=tuple(corner + 1.0))
    usual, drawn = (np.array(choose(arm, found.task, away).witness) for choose in (pose_witness, upright))
    assert ((usual < arm.lower) | (usual > arm.upper)).any()
    assert ((drawn >= arm.lower) & (drawn <= arm.upper)).all()


def test_lost_directions_are_those_of_the_new_posture() -> None:
    found = shipped("crx10ial")
    family = upright(found.robot, found.task, found.families[0], found.families)
    assert family.witness != found.families[0].witness
    assert family.lost_directions.shape == (1, 6)
    assert not np.allclose(family.lost_directions, found.families[0].lost_directions)


@pytest.mark.parametrize("name", ["pa10", "panda", "crx10ia"])
def test_pictures_begin_with_an_arm_that_stands(name: str) -> None:
    found = shipped(name)
    q = upright_start(found.robot, found.task)
    assert height(found.robot, q[None])[0] >= 0.95 * TALL
    assert ((q >= found.robot.lower) & (q <= found.robot.upper)).all()
    assert singular_values(found.robot, q, found.task)[-1] > 0.02
