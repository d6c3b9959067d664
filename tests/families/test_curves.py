"""Curves of singular configurations: closed, complete, on the set."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.families.searching import search
from rankdrop.families.slices import singular_curves
from rankdrop.local.block import singular_values
from rankdrop.robot.open import open_robot


@pytest.fixture(scope="module")
def curves():
    return singular_curves(open_robot("almarkhi4"), (2, 3, 4))


@pytest.mark.slow
def test_am_figure_5_is_four_closed_curves(curves):
    assert [(curve.closed, curve.windings) for curve in curves] == [(True, (0, 1, 0, 0))] * 4
    # recomputed with steps of 0.02 rad
    assert [curve.length for curve in curves] == pytest.approx([11.383, 10.888, 10.864, 9.846], abs=0.005)


@pytest.mark.slow
def test_every_singular_configuration_is_near_a_curve(curves):
    robot = open_robot("almarkhi4")
    points = np.concatenate([curve.q[:, 1:] for curve in curves])
    for q in search(robot, 1, starts=200, seed=77).converged:
        off = points - q[1:]
        off -= 2 * np.pi * np.round(off / (2 * np.pi))
        assert np.linalg.norm(off, axis=1).min() < 0.03


def test_every_point_is_singular_and_steps_are_short(curves):
    robot = open_robot("almarkhi4")
    for curve in curves:
        task = search(robot, 1, starts=1).task
        assert singular_values(robot, curve.q, task)[:, 2].max() < 1e-10
        assert np.linalg.norm(np.diff(curve.q, axis=0), axis=1).max() < 0.1
        assert not curve.q.flags.writeable


def test_held_joints_stand_still():
    held = [0.7, 0.0, 0.0, 0.0]
    (first, *_) = singular_curves(open_robot("almarkhi4"), (2, 3, 4), held=held, starts=20, step=0.1)
    assert np.all(first.q[:, 0] == 0.7)


def test_a_line_of_singular_configurations_closes_too():
    """θ2 = 0 of the planar arm: the other joint goes once round."""
    found = singular_curves(open_robot("planar2r"), (1, 2), starts=20)
    assert sorted(round(abs(float(np.cos(curve.q[0, 1])))) for curve in found) == [1, 1]
    assert {curve.windings for curve in found} == {(1, 0)}
    assert [curve.length for curve in found] == pytest.approx([2 * np.pi] * 2, abs=1e-9)


@pytest.mark.parametrize("joints", [(), (0, 2), (2, 9)])
def test_joints_that_are_not_there_are_refused(joints):
    with pytest.raises(OptionError, match="joint"):
        singular_curves(open_robot("almarkhi4"), joints)


def test_slides_and_wrong_configurations_are_refused():
    with pytest.raises(OptionError, match="revolute"):
        singular_curves(open_robot("scara"), (1, 2))
    with pytest.raises(ConfigurationError):
        singular_curves(open_robot("almarkhi4"), (2, 3), held=[0.0])
