"""Corners of a joint path cut by parabolas."""

from __future__ import annotations

import numpy as np
import pytest

import rankdrop
from rankdrop.kinematics import pose
from rankdrop.path.curve import curve
from rankdrop.path.mend.blends import blends, cut_corners, largest_radius
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot

ARM = open_robot("planar3r")
CORNER = np.array([[0.3, 0.4, 0.1], [0.5, -0.2, 0.3], [0.9, 0.5, 0.3]])  # through θ2 = 0 and back


@pytest.mark.parametrize(("cut", "radius"), [((0,), 1.0), ((1,), 2.0), ((0, 1), 0.5), ((0, 2), 1.0)])
def test_a_corner_is_cut_as_far_as_the_next_one_and_half_as_far_where_both_are(
    cut: tuple[int, ...], radius: float
) -> None:
    until = np.array([0.0, 1.0, 3.0, 7.0, 11.0])
    assert largest_radius(until, np.array([1, 2, 3]), np.array(cut)) == radius


def test_a_corner_is_left_and_reached_along_the_path_half_as_far_in() -> None:
    path = curve(CORNER, None)
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(CORNER, axis=0), axis=1))])
    place, q, off = cut_corners(ARM, path, lengths, np.array([1]), 0.2)
    assert (np.diff(place) >= 0).all()
    np.testing.assert_array_equal(q[[0, -1]], CORNER[[0, -1]])
    parabola = q[1:-1]
    ways = [(CORNER[k + 1] - CORNER[k]) / np.linalg.norm(CORNER[k + 1] - CORNER[k]) for k in (0, 1)]
    np.testing.assert_allclose(parabola[[0, -1]], [CORNER[1] - 0.2 * ways[0], CORNER[1] + 0.2 * ways[1]], atol=1e-12)
    in_by = np.linalg.norm(parabola[len(parabola) // 2] - CORNER[1])
    assert in_by == pytest.approx(0.5 * np.linalg.norm((parabola[0] + parabola[-1]) / 2 - CORNER[1]))
    steps = np.diff(parabola, axis=0)[[0, -1]]
    cosines = (steps * ways).sum(axis=1) / np.linalg.norm(steps, axis=1)
    assert cosines.min() > 0.998
    measured = corner_distance(parabola, 0.2)
    assert measured <= off < measured + 5e-4


def corner_distance(q: Array, radius: float) -> float:
    """How far the tip is at most from the part of the path that is cut away [m], by closer samples of it."""
    path = np.concatenate([np.linspace(*CORNER[k : k + 2], 20001) for k in (0, 1)])
    path = path[np.linalg.norm(path - CORNER[1], axis=1) <= radius]
    way, points = pose(ARM, path)[:, :2, 3], pose(ARM, q)[:, :2, 3]
    return max(float(np.linalg.norm(way - point, axis=1).min()) for point in points)


def test_blends_are_larger_one_by_one_and_within_the_bound() -> None:
    found = rankdrop.check_path(ARM, CORNER)
    assert found.verdict == "crossing"
    proposals = list(blends(found, 1.0))
    radii = [value for proposal in proposals for name, value, _ in proposal.parameters if name == "radius"]
    assert radii == sorted(radii)
    off = [proposal.off[0] for proposal in proposals]
    assert min(off) > 0.0
    within = [proposal.off[0] for proposal in blends(found, off[3])]
    assert within == [size for size in off if size <= off[3]]
    assert len(within) < len(off)
    assert list(blends(found, 1e-4)) == []


def test_a_path_without_a_corner_has_no_blend() -> None:
    found = rankdrop.check_path(ARM, CORNER[:2])
    assert found.verdict == "crossing"
    assert list(blends(found, 1.0)) == []
