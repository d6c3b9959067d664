"""Results at one configuration show themselves in a notebook: their own numbers, nothing loaded from elsewhere."""

from __future__ import annotations

import pytest

from rankdrop import escape, nearest_singularity, open_robot, redundancy

PA10 = open_robot("pa10")
HERE = [0.1, 0.5, 0.3, 0.2, 0.9, 0.4, 0.2]


def test_the_way_to_the_nearest_is_shown() -> None:
    found = nearest_singularity(PA10, HERE)
    assert found is not None
    page = found._repr_html_()
    assert f"{found.distance:.6g} rad" in page
    assert all(f"{x:.6g}" in page for x in found.q)
    assert "not proven" in page


def test_every_joint_stands_in_the_ways_out() -> None:
    found = escape(PA10, [0.0] * 7)
    page = found._repr_html_()
    assert all(f"{one.number} {one.joint}" in page for one in found.single)
    assert f"at an edge of the reach: not known ({found.boundary_reason})" in page


def test_the_projector_is_shown_entry_by_entry() -> None:
    found = redundancy(PA10, HERE)
    page = found._repr_html_()
    assert page.count("<tr>") == 3 + found.range_basis.shape[0] + found.null_basis.shape[0] + 7
    assert f"{found.projector[2, 2]:.4g}" in page


@pytest.mark.parametrize("make", [lambda: redundancy(PA10, HERE), lambda: escape(PA10, [0.0] * 7)])
def test_nothing_is_loaded(make) -> None:
    page = make()._repr_html_()
    assert "http" not in page
    assert "<script" not in page
