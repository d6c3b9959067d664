"""The camera of the viewer: the arm fills the part of the window that the panel leaves."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.local.posture import spine
from rankdrop.results.known import shipped
from rankdrop.robot import Array
from rankdrop.robot.open import robot_names

pytest.importorskip("viser", reason="viser and trimesh are not installed")

from rankdrop.families.pictured import upright_start
from rankdrop.viewer.stage import FOV, FREE, camera_for, extent, leaves_window  # needs viser


def seen(points: Array, position: Array, aim: Array, aspect: float) -> Array:
    """(N, 2) places in the window, from 0 at the left and the top to 1."""
    ahead = (aim - position) / np.linalg.norm(aim - position)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    off = points - position
    half = np.tan(FOV / 2) * (off @ ahead)
    return np.stack([(off @ right / (half * aspect) + 1) / 2, (1 - off @ np.cross(right, ahead) / half) / 2], axis=1)


def check(name: str, wide: bool, aspect: float) -> None:
    """The axes of the arm are nearly six tenths of the free part or more, and its body does not leave it."""
    robot = shipped(name).robot
    q = upright_start(robot, shipped(name).task)
    body = extent(robot, q)
    camera = camera_for(body, wide=wide, aspect=aspect)
    free = np.array(FREE[wide])
    assert (np.ptp(seen(spine(robot, q[None])[0], *camera, aspect), axis=0) / free).max() >= 0.59
    whole = seen(body, *camera, aspect)
    assert whole.min() >= 0.0
    assert (whole <= free).all()


@pytest.mark.parametrize(("wide", "aspect"), [(True, 1.55), (False, 0.5)])
@pytest.mark.parametrize("name", ["crx10ial", "pa10", "ur5e", "panda", "yumi"])
def test_the_arm_fills_the_free_part_of_the_window(name: str, wide: bool, aspect: float) -> None:
    """A CRX filled 29 % of the window's height: the camera saw four more postures whole."""
    check(name, wide, aspect)


@pytest.mark.by_hand
@pytest.mark.parametrize("name", robot_names())
def test_every_arm_fills_the_free_part_of_the_window(name: str) -> None:
    check(name, wide=True, aspect=1.55)


def test_a_camera_that_sees_only_a_part_is_moved_along_its_view() -> None:
    found = shipped("crx10ial")
    start, other = upright_start(found.robot, found.task), np.array(found.families[1].witness)
    first = camera_for(extent(found.robot, start), wide=True)
    ends = spine(found.robot, other[None])[0] + [0.0, 0.0, 2.0]
    assert not leaves_window(spine(found.robot, start[None])[0], *first, 1.55)
    assert leaves_window(ends, *first, 1.55)
    toward = np.array([0.6, 0.0, 0.8])
    position, aim = camera_for(ends, wide=True, toward=toward)
    assert not leaves_window(ends, position, aim, 1.55)
    assert np.allclose((position - aim) / np.linalg.norm(position - aim), toward)
