"""What is drawn of the singular set is singular: planes, cubes, lines, workspace."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from families.known_families import known

from rankdrop.families.points import general_member, members
from rankdrop.families.slices import (
    Slice,
    curves,
    slice_through,
    solids,
    surface,
    sweeps,
    telling_joints,
    telling_slices,
)
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.problem import wrap
from rankdrop.results.analysis import Analysis

ARMS = ["pa10", "ur5", "stanford", "planar2r", "scara", "canadarm2"]
SINGULAR = 1e-9


@cache
def planes_of(name: str) -> tuple[Slice, ...]:
    analysis = known(name)
    return telling_slices(analysis.robot, analysis.task, analysis.families)


def sigma_lost(analysis: Analysis, q: np.ndarray, corank: int) -> float:
    """Largest of the singular values that have to vanish."""
    rank = generic_rank(analysis.robot, analysis.task) - corank
    return float(singular_values(analysis.robot, q, analysis.task)[:, rank].max(initial=0.0))


@pytest.mark.parametrize("name", ARMS)
def test_every_point_of_a_slice_is_singular(name: str) -> None:
    analysis = known(name)
    coranks = {family.id: family.corank for family in analysis.families}
    assert planes_of(name)
    for plane in planes_of(name):
        moving = [number - 1 for number in plane.joints]
        for trace in plane.traces:
            points = np.concatenate([*trace.curves, trace.points])
            q = np.repeat(plane.q[None], len(points), axis=0)
            q[:, moving] = points
            assert sigma_lost(analysis, q, coranks[trace.family]) <= SINGULAR


@pytest.mark.parametrize("name", ARMS)
def test_the_family_of_a_slice_is_seen_in_it(name: str) -> None:
    for plane in planes_of(name):
        seen = {trace.family for trace in plane.traces} | set(plane.filled)
        assert plane.family in seen


def test_a_slice_shows_the_values_of_a_pinned_pair() -> None:
    analysis = known("pa10")
    family = next(one for one in analysis.families if one.id == "k1.f3")  # θ2 and θ6 at 0 or π
    q = general_member(analysis.robot, analysis.task, family, (1, 5), 0, analysis.families)
    plane = slice_through(analysis.robot, analysis.task, analysis.families, q, (2, 6))
    (points,) = [trace.points for trace in plane.traces if trace.family == family.id]
    expected = {(x, y) for x in (-np.pi, 0.0, np.pi) for y in (-np.pi, 0.0, np.pi)}
    assert {(round(x, 6) + 0.0, round(y, 6) + 0.0) for x, y in points} == {
        (round(x, 6), round(y, 6)) for x, y in expected
    }


def test_the_joints_of_a_slice_are_those_that_are_tied_together() -> None:
    analysis = known("ur5")
    assert [telling_joints(analysis.robot, family) for family in analysis.families[:3]] == [(2, 3), (2, 3), (4, 5)]


def test_the_singular_set_of_almarkhi4_is_four_closed_curves() -> None:
    """AM Figure 5."""
    analysis = known("almarkhi4")
    (one,) = solids(analysis.robot, analysis.task, analysis.families)
    assert one.joints == (2, 3, 4)
    assert len(one.curves) == one.closed == 4
    assert all(np.abs(wrap(line[-1] - line[0])).max() < 1e-9 for line in one.curves)
    for line in one.curves:
        q = np.repeat(one.q[None], len(line), axis=0)
        q[:, 1:] = line
        assert sigma_lost(analysis, q, 1) <= SINGULAR
        assert np.linalg.norm(np.diff(line, axis=0), axis=1).max() < 0.14 + 1e-9


def test_the_curves_hold_every_singular_configuration_that_a_search_finds() -> None:
    from rankdrop.families.searching import search

    analysis = known("almarkhi4")
    (one,) = solids(analysis.robot, analysis.task, analysis.families)
    found = search(analysis.robot, 1, starts=300, seed=5).converged[:, 1:]
    points = np.concatenate(one.curves)
    gap = [np.linalg.norm(wrap(points - q), axis=1).min() for q in found]
    assert len(found) > 250
    assert max(gap) < 0.05


def test_a_surface_in_three_joints_is_singular() -> None:
    analysis = known("ur5")
    (one,) = solids(analysis.robot, analysis.task, analysis.families)
    q = np.repeat(one.q[None], len(one.vertices), axis=0)
    q[:, [number - 1 for number in one.joints]] = one.vertices
    assert len(one.triangles) > 1000
    assert one.triangles.max() < len(one.vertices)
    assert sigma_lost(analysis, q, 1) <= SINGULAR


@pytest.mark.parametrize("name", ["pa10", "stanford", "ur5"])
def test_members_satisfy_their_family(name: str) -> None:
    analysis = known(name)
    for family in analysis.families:
        q = members(analysis.robot, analysis.task, family, 50, 3)
        assert len(q) > 20
        assert max(np.abs(equation(q)).max() for equation in family.equations) < 1e-9
        assert sigma_lost(analysis, q, family.corank) <= SINGULAR


def test_a_general_member_keeps_away_from_the_other_families() -> None:
    analysis = known("ur5")
    for family in analysis.families[:3]:
        q = general_member(analysis.robot, analysis.task, family, (1, 2), 0, analysis.families)
        others = [one for one in analysis.families[:3] if one is not family]
        assert min(max(abs(float(e(q))) for e in other.equations) for other in others) > 0.05


def test_marching_squares_finds_a_circle() -> None:
    x = np.linspace(-2, 2, 81)
    (line,) = curves(x[:, None] ** 2 + x[None] ** 2 - 1.0, x, x)
    assert np.allclose(line[0], line[-1])
    assert np.abs(np.linalg.norm(line, axis=1) - 1).max() < 1e-3
    assert abs(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() - 2 * np.pi) < 0.01


def test_marching_squares_tells_saddles_apart() -> None:
    x = np.linspace(-1.05, 1.05, 22)
    lines = curves(x[:, None] * x[None] - 0.001, x, x)
    assert len(lines) == 2
    assert all((line.prod(axis=1) > 0).all() for line in lines)


def test_marching_tetrahedra_closes_a_sphere() -> None:
    x = np.linspace(-1.5, 1.5, 25)
    vertices, triangles = surface(
        x[:, None, None] ** 2 + x[None, :, None] ** 2 + x[None, None] ** 2 - 1.0, (x, x, x)
    )
    assert np.abs(np.linalg.norm(vertices, axis=1) - 1).max() < 0.01
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [0, 2]]]), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    assert len(vertices) - len(np.unique(edges, axis=0)) + len(triangles) == 2


@pytest.mark.parametrize("name", ["pa10", "stanford"])
def test_a_sweep_is_the_singular_values_along_a_line(name: str) -> None:
    analysis = known(name)
    robot, task = analysis.robot, analysis.task
    for family in analysis.families[:2]:
        for sweep in sweeps(robot, family.witness, task, count=31):
            q = np.repeat(np.array(family.witness)[None], len(sweep.values), axis=0)
            q[:, sweep.number - 1] = sweep.values
            assert np.array_equal(sweep.sigma, singular_values(robot, q, task)[:, : analysis.generic_rank])
            here = int(np.abs(sweep.values - sweep.at).argmin())
            assert sweep.values[here] == family.witness[sweep.number - 1]
            assert sweep.sigma[here, analysis.generic_rank - family.corank] <= SINGULAR
