"""Curves through the rows of a path."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rankdrop.path.curve import Curve, chord_form, curve, halves


@pytest.mark.parametrize("degree", ["linear", "cubic", "quintic"])
def test_a_curve_lies_where_its_chord_says(degree: str) -> None:
    rng = np.random.default_rng(2)
    q, v, a = rng.normal(size=(3, 5, 4))
    made = curve(q, np.arange(5.0), v, a, degree)
    control = halves(halves(made.control))
    middle, chord, extra = chord_form(control)
    share = np.linspace(0, 1, 101)
    ratios = []
    for k in range(4):
        points = made.at(np.full(101, k), share).reshape(101, 4)
        for part in range(4):
            piece = points[25 * part : 25 * part + 26]
            tau = np.linspace(-1, 1, 26)[:, None]
            off = np.abs(piece - middle[4 * k + part] - tau * chord[4 * k + part]).max(axis=0)
            assert (off <= extra[4 * k + part] + 1e-13).all()
            ratios.append(off / np.maximum(extra[4 * k + part], 1e-12))
    if degree != "linear":
        assert np.max(ratios) > 0.5


@pytest.mark.parametrize("degree", [2, 3, 5])
def test_how_far_a_curve_leaves_its_chord_is_reached(degree: int) -> None:
    """All control points but the ends equally far to one side."""
    control = np.linspace([0.0, 1.0], [2.0, 3.0], degree + 1)[None]
    control[:, 1:-1] += [0.3, -0.7]
    middle, chord, extra = chord_form(control)
    share = np.linspace(0, 1, 101)
    there = Curve(control, None).at(np.zeros(101, dtype=np.int64), share)
    off = np.abs(there - middle - (2 * share - 1)[:, None] * chord).max(axis=0)
    assert (off <= extra[0] * (1 + 1e-12)).all()
    assert (off >= 0.999 * extra[0]).all()


def test_the_curve_goes_through_samples_with_their_rates() -> None:
    rng = np.random.default_rng(3)
    q, v, a = rng.normal(size=(3, 4, 2))
    t = np.array([0.0, 0.5, 2.0, 2.1])
    for degree in ("cubic", "quintic"):
        made = curve(q, t, v, a, degree)
        for k in range(3):
            for share, row in ((0.0, k), (1.0, k + 1)):
                at = np.array([k]), np.array([share])
                np.testing.assert_allclose(made.at(*at)[0], q[row], atol=1e-13)
                np.testing.assert_allclose(made.slope(*at)[0] / (t[k + 1] - t[k]), v[row], atol=1e-12)
    h = 1e-4
    bend = (made.at(np.array([1] * 3), np.array([0.0, h, 2 * h])) * [[1], [-2], [1]]).sum(axis=0) / (h * 1.5) ** 2
    np.testing.assert_allclose(bend, a[1], atol=2e-2)


def test_a_place_of_a_tool_path_has_its_pose() -> None:
    path = curve(np.zeros((3, 2)), None)
    assert path.place((1, 0.5)).pose is None
    tool = replace(path, poses=np.array([1.0, 1.2, 2.0]))
    assert [tool.place(spot).pose for spot in ((0, 0.0), (1, 0.5), (1, 1.0))] == pytest.approx([1.0, 1.6, 2.0])
