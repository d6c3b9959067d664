"""Distances to families: closed form where joints are pinned, minima of the distance where they are coupled."""

from __future__ import annotations

from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest
from known.members import members
from known.truths import PA10_TABLES

from rankdrop.distance.distance import family_distances, feet_on, walls_of
from rankdrop.errors import ConfigurationError
from rankdrop.families.record import Family
from rankdrop.formula.equation import System
from rankdrop.local.block import joint_scale
from rankdrop.local.nearest import nearest_singularity
from rankdrop.problem import Problem
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import shipped
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot
from rankdrop.tolerances import DEFAULT
from rankdrop.verbs.analyze import analyze

ARMS = ("pa10", "puma560", "ur5", "panda", "canadarm2", "stanford", "scara", "planar3r")
_analyses: dict[str, Analysis] = {}


def analysed(name: str) -> Analysis:
    if name not in _analyses:
        _analyses[name] = analyze(open_robot(name), starts=800, seed=8, exact="off")
    return _analyses[name]


def pinned_distance(family: Family, q: Array) -> float:
    """Norm of what separates the pinned joints from the nearest of their values, up to whole turns."""
    parts = []
    for joint in family.pinned:
        off = q[joint.number - 1] - np.array(joint.values)
        parts.append(np.abs(off - 2 * pi * np.round(off / (2 * pi))).min())
    return float(np.linalg.norm(parts))


@pytest.mark.slow
def test_pa10_is_closed_form(rng: np.random.Generator) -> None:
    found = analysed("pa10")
    families = found.families
    counts = {k: sum(family.corank == k for family in families) for k in PA10_TABLES}
    assert counts == {k: len(rows) for k, rows in PA10_TABLES.items()}
    for q in rng.uniform(-30, 30, (100, 7)):
        records = family_distances(families, found.robot, q, found.task)
        assert len(records) == len(families)
        for record in records:
            assert record.exact
            assert record.distance == pytest.approx(pinned_distance(record.family, q), abs=1e-12)
            assert record.residual < 1e-14
            assert record.sigma < 1e-14
            np.testing.assert_allclose(np.add(q, record.delta), record.q, atol=1e-14)
        assert [record.distance for record in records] == sorted(record.distance for record in records)


@pytest.mark.spread(2)
@pytest.mark.by_hand_at("canadarm2", "panda", "ur5")
@pytest.mark.slow
@pytest.mark.parametrize("name", [pytest.param(a, marks=pytest.mark.slow if a == "canadarm2" else ()) for a in ARMS])
def test_the_nearest_family_is_what_the_search_finds(name: str, rng: np.random.Generator) -> None:
    found = analysed(name)
    for q in rng.uniform(-3, 3, (12, found.robot.n)):
        records = family_distances(found.families, found.robot, q, found.task)
        nearest = nearest_singularity(found.robot, q, found.task)
        assert nearest is not None
        assert nearest.distance == pytest.approx(records[0].distance, abs=1e-6)


@pytest.mark.slow_at("puma560")
@pytest.mark.spread(1)
@pytest.mark.slow_at("ur5")
@pytest.mark.slow_at("canadarm2", "panda")
@pytest.mark.parametrize("name", ["puma560", "ur5", "panda", "canadarm2"])
def test_points_are_minima_on_their_family(name: str, rng: np.random.Generator) -> None:
    """They solve the equations, and no point of the family beside them is nearer."""
    found = analysed(name)
    scale = joint_scale(found.robot, found.task)
    coupled = [family for family in found.families if family.coupled and family.corank == 1]
    assert coupled
    for q in rng.uniform(-3, 3, (3, found.robot.n)):
        for record in family_distances(coupled, found.robot, q, found.task):
            assert np.isfinite(record.distance)
            assert record.residual <= 1e-12
            assert record.sigma <= 1e-9
            system = System(record.family.equations)
            beside = np.array(record.q) + rng.normal(0, 0.05, (200, found.robot.n)) * scale
            beside, solved = system.solve(beside)
            assert solved.sum() > 150
            distance = np.linalg.norm((beside[solved] - q) / scale, axis=1)
            assert distance.min() >= record.distance - 1e-9


@pytest.mark.slow
def test_joints_a_family_does_not_depend_on_stay(rng: np.random.Generator) -> None:
    found = analysed("panda")
    for q in rng.uniform(-3, 3, (3, 7)):
        for record in family_distances(found.families, found.robot, q, found.task):
            for number in record.family.free:
                assert record.delta[number - 1] == 0.0


@pytest.mark.slow
def test_limits_are_kept(rng: np.random.Generator) -> None:
    robot = open_robot("iiwa14")
    found = analysed("pa10")  # the same rows: spherical shoulder and wrist, an elbow between them
    families = [family for family in found.families if family.corank == 1]
    q = np.array([0.1, 1.5, 0.1, 2.0, 0.1, 1.5, 0.2])
    free, inside = (family_distances(families, robot, q, found.task, limits=limits)[0] for limits in (False, True))
    assert free.distance == pytest.approx(pi - 2.0, abs=1e-12)
    assert inside.distance == pytest.approx(2.0, abs=1e-12)
    found = analysed("panda")
    low, high = found.robot.lower, found.robot.upper
    reached = 0
    for q in rng.uniform(low, high, (4, 7)):
        free = {r.family.id: r.distance for r in family_distances(found.families, found.robot, q, found.task)}
        for record in family_distances(found.families, found.robot, q, found.task, limits=True):
            if np.isfinite(record.distance):
                reached += 1
                assert ((low - 1e-9 <= record.q) & (record.q <= high + 1e-9)).all()
                assert record.distance >= free[record.family.id] - 1e-9
    assert reached > 8


@pytest.mark.parametrize(("name", "limits"), [("pa10", False), ("puma560", True), ("z1", False)])
def test_one_configuration_has_the_feet_of_a_batch(name: str, limits: bool, rng: np.random.Generator) -> None:
    found = shipped(name)
    problem = Problem(found.robot, found.task, limits=limits)
    for q in rng.uniform(-3, 3, (2, found.robot.n)):
        for record in family_distances(found.families, found.robot, q, found.task, limits=limits):
            parts = feet_on(record.family, problem, q[None], walls_of(problem), zero=DEFAULT.singular, seed=0)
            foot, distance, residual, sigma = (part[0] for part in parts)
            assert (record.distance, record.residual, record.sigma) == (distance, residual, sigma)
            assert record.q == (tuple(foot) if np.isfinite(distance) else ())


def test_same_seed_same_result(rng: np.random.Generator) -> None:
    found, q = analysed("puma560"), rng.uniform(-3, 3, 6)
    first, again = (family_distances(found.families, found.robot, q, found.task, seed=3) for _ in range(2))
    assert first == again


@pytest.mark.slow
def test_families_without_conditions_are_reported_as_not_asked(rng: np.random.Generator) -> None:
    found, q = analysed("pa10"), rng.uniform(-3, 3, 7)
    known = found.families[0]
    bare = replace(known, id="k1.f9", equations=(), named=False)
    records = family_distances([bare, known], found.robot, q, found.task)
    assert [record.family for record in records] == [known, bare]
    assert (records[1].distance, records[1].q, records[1].exact) == (inf, (), False)


@pytest.mark.slow
def test_a_family_that_is_not_singular_is_not_near(rng: np.random.Generator) -> None:
    """Conditions of another arm: solved, but σ does not vanish."""
    found, other = analysed("pa10"), open_robot("panda")
    records = family_distances(found.families, other, rng.uniform(-3, 3, 7), found.task)
    assert [record.distance for record in records if record.family.corank == 2] == [inf] * 4


def test_one_configuration_is_needed() -> None:
    found = analysed("pa10")
    with pytest.raises(ConfigurationError):
        family_distances(found.families, found.robot, [0.0] * 6, found.task)


@pytest.mark.parametrize("name", ["ur5", "z1"])
def test_no_member_of_a_shipped_family_is_nearer_than_the_family_is_said_to_be(name: str) -> None:
    """Rows that were cut as the exact conditions are have more equations than their codimension."""
    found = shipped(name)
    rng = np.random.default_rng(41)
    for family in found.families:
        reached = members(found.robot, found.task, family, 20, seed=7)
        for member in reached[:3]:
            q = member + rng.normal(size=found.robot.n) * 0.2
            (record,) = family_distances([family], found.robot, q, found.task)
            assert record.distance <= np.linalg.norm(member - q) + 1e-9, (family.id, family.name)
