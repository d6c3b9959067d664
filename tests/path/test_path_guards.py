"""Guards of a path's proof, each with a case planted for it: without the guard the case ends in a false claim."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.cover.setting import enclose, settings_for
from rankdrop.path.check.certificate import ball
from rankdrop.path.check.check import check_path
from rankdrop.path.check.prove import ROUNDED, Along, Proof, free_boxes, join_neighbours
from rankdrop.path.curve import Curve
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

pytestmark = pytest.mark.shipped
FAR = 1e5 * np.pi
"""A joint value with digits to 6e-11: halving a curve there leaves errors, which an enclosure allows for."""


def wrist_far_away(off: float) -> np.ndarray:
    return np.array([0.1, -1.2, 1.0, 0.5, FAR + off, 0.2])


def test_enclosures_of_curves_and_boxes_allow_for_the_rounding_of_large_joint_values() -> None:
    """A piece of length 0 stands 9.5e-9 beside the wrist's singularity at θ5 = 1e5 π: the point alone would be free."""
    robot = open_robot("puma560")
    task = resolve_task(None, robot)
    setting = settings_for(robot, task)[0]
    beside, nothing = wrist_far_away(9.5e-9)[None], np.zeros((1, 6))
    assert enclose(robot, setting, beside, nothing)[0][0]
    assert not Along(robot, setting).enclose_curves(beside, nothing, nothing).free[0]
    work = Proof(setting, 10, 1, None)
    assert not free_boxes(robot, beside, beside, work)[0]
    clear = wrist_far_away(1e-5)[None]
    assert Along(robot, setting).enclose_curves(clear, nothing, nothing).free[0]
    assert free_boxes(robot, clear, clear, work)[0]
    _, rho = ball(beside, beside, setting)
    assert rho[0] >= ROUNDED * FAR


def test_a_curve_bent_within_its_piece_is_enclosed_with_its_bend() -> None:
    """θ5 = 0.01 (1 − (2 s − 1)²) − 0.0099 crosses zero twice; its chord stays 0.0099 below it."""
    robot = open_robot("puma560")
    low = np.array([0.1, -1.2, 1.0, 0.5, -0.0099, 0.2])
    control = np.repeat(low[None], 4, axis=0)
    control[1:3, 4] += 0.04 / 3  # a cubic's control points of 0.04 s (1 − s)
    path = Curve(control[None], None)
    assert path.at(np.array([0]), np.array([0.5]))[0, 4] == pytest.approx(1e-4)
    speeds = 3 * np.diff(control, axis=0)[[0, -1]]
    check = check_path(robot, control[[0, -1]], [0.0, 1.0], velocities=speeds, interpolate="cubic")
    assert [one.verdict for one in check.crossings] == ["crossing", "crossing"]


def test_an_unfinished_sliver_is_not_joined_to_a_finished_one_beside_it() -> None:
    pieces = [(0, 0.0, 0.5, True), (0, 0.5, 1.0, False), (1, 0.0, 0.25, False), (1, 0.25, 0.5, True)]
    joined = join_neighbours(pieces)
    assert joined == [((0, 0.0), (0, 0.5), True), ((0, 0.5), (1, 0.25), False), ((1, 0.25), (1, 0.5), True)]
    apart = join_neighbours([(0, 0.5, 1.0, True), (2, 0.0, 0.5, True)])  # a stretch lies between
    assert apart == [((0, 0.5), (0, 1.0), True), ((2, 0.0), (2, 0.5), True)]
