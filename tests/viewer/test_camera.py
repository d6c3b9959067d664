"""The camera of the viewer: the arm fills the part of the window that the panel leaves."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.local.posture import spine
from rankdrop.results.known import shipped
from rankdrop.robot import Array

pytest.importorskip("viser", reason="viser and trimesh are not installed")

from rankdrop.families.pictured import upright_start
from rankdrop.viewer.stage import FOV, FREE, camera_for  # needs viser


def seen(points: Array, position: Array, aim: Array, aspect: float) -> Array:
    """(N, 2) places in the window, from 0 at the left and the top to 1."""
    ahead = (aim - position) / np.linalg.norm(aim - position)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    off = points - position
    half = np.tan(FOV / 2) * (off @ ahead)
    return np.stack([(off @ right / (half * aspect) + 1) / 2, (1 - off @ np.cross(right, ahead) / half) / 2], axis=1)


@pytest.mark.parametrize(("wide", "aspect"), [(True, 1.55), (False, 0.5)])
@pytest.mark.parametrize("name", ["crx10ial", "pa10", "ur5e"])
def test_the_arm_fills_the_free_part_of_the_window(name: str, wide: bool, aspect: float) -> None:
    """A CRX filled 9 % by 21 % of the window."""
    found = shipped(name)
    q = upright_start(found.robot, found.task)
    points = spine(found.robot, q[None]).reshape(-1, 3)
    flat = seen(points, *camera_for(points, wide=wide, aspect=aspect), aspect)
    free = np.array(FREE[wide])
    assert (np.ptp(flat, axis=0) / free).max() >= 0.6
    assert flat.min() >= 0.0
    assert (flat <= free).all()
