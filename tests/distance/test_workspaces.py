"""Sections of the workspace."""

from __future__ import annotations

import numpy as np
import pytest
from families.known_families import known

from rankdrop.distance.workspaces import _normals_to, section_of, workspace
from rankdrop.kinematics import pose
from rankdrop.local.block import sample
from rankdrop.robot.model import Joint, JointKind, Robot


def test_the_section_is_distance_and_height() -> None:
    analysis = known("pa10")
    section = workspace(analysis.robot, analysis.task, (), tips=2000).section
    q = sample(analysis.robot, analysis.task, 50, 1)
    tips = pose(analysis.robot, q)[:, :3, 3]
    expected = np.stack([np.hypot(tips[:, 0], tips[:, 1]), tips[:, 2]], axis=1)
    assert np.allclose(section(tips), expected, atol=1e-12)


def test_the_walls_of_a_planar_arm_are_its_two_circles() -> None:
    analysis = known("planar2r")
    found = workspace(analysis.robot, analysis.task, analysis.families, tips=5000)
    radius = np.linalg.norm(found.walls, axis=1)
    assert found.section.planar
    assert found.one_sided.all()
    assert {round(float(r), 6) for r in radius} == {0.3, 1.7}  # links of 1 m and 0.7 m


def test_the_rim_of_the_workspace_is_a_wall_that_nothing_crosses() -> None:
    analysis = known("pa10")
    found = workspace(analysis.robot, analysis.task, analysis.families, tips=50_000)
    away = np.linalg.norm(found.walls, axis=1)
    rim = away > away.max() - 1e-6
    assert rim.any()
    assert found.one_sided[rim].all()
    assert not found.one_sided.all()  # inside, another posture passes


def test_the_same_seed_gives_the_same_pictures() -> None:
    analysis = known("ur5")
    first, again = (workspace(analysis.robot, analysis.task, analysis.families, tips=3000, seed=4) for _ in range(2))
    assert np.array_equal(first.tips, again.tips)
    assert np.array_equal(first.walls, again.walls)
    assert all(np.array_equal(a, b) for (_, a), (_, b) in zip(first.images, again.images, strict=True))


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.6, 0.0, 0.8), (-0.95, 0.3122498999199199, 0.0)])
def test_a_section_has_two_unit_vectors_across_its_axis(axis: tuple[float, float, float]) -> None:
    x, y = _normals_to(np.array(axis))
    frame = np.array([x, y, axis])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(frame) == pytest.approx(1.0)


def test_a_section_is_about_the_first_axis_that_turns_or_upright_where_none_does() -> None:
    """The first axis of this arm passes through (0.3, −0.2, 0) along x; slides alone have the base's z."""
    place, along = np.array([0.3, -0.2, 0.5]), np.array([1.0, 0.0, 0.0])
    slide = Joint("out", JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]))
    turn = Joint("turn", JointKind.REVOLUTE, np.array([*np.cross(place, along), *along]))
    section = section_of(Robot("turned", (slide, turn)), np.random.default_rng(0).normal(size=(20, 3)))
    np.testing.assert_allclose(section.axis, along)
    np.testing.assert_allclose(np.cross(section.origin - place, along), 0.0, atol=1e-15)
    assert not section.planar
    gantry = section_of(Robot("gantry", (slide,)), np.array([[1.0, 2.0, 0.1], [0.5, 0.0, 0.1]]))
    assert (gantry.origin.tolist(), gantry.axis.tolist(), gantry.planar) == ([0.0] * 3, [0.0, 0.0, 1.0], True)
