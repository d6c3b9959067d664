"""Singular or nearly so: points on no family are followed with 50 digits before they count."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.exact.family import derived_in_units
from rankdrop.families.descent import descents, not_singular, task_jacobian_exactly
from rankdrop.families.row import row_of
from rankdrop.kinematics import task_jacobian
from rankdrop.problem import Problem
from rankdrop.results.stored_conditions import shipped_conditions
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import BODY, resolve_task
from rankdrop.text.claims import of_conditions
from rankdrop.units import in_units, task_in_units
from rankdrop.verbs.analyze import analyze
from rankdrop.verbs.conditions import conditions

flint = pytest.importorskip("flint")
Q = np.pi / 2


def nearly_srs(error: float) -> Robot:
    """A 7R with spherical shoulder and wrist, every number off by about `error`."""
    rows = np.array([[0, -Q, 0.36, 0], [0, Q, 0, 0], [0, Q, 0.42, 0], [0, -Q, 0, 0], [0, -Q, 0.4, 0], [0, Q, 0, 0],
                     [0, 0, 0.126, 0]])  # fmt: skip
    off = np.random.default_rng(0).standard_normal((3, 7)) * error
    rows[:, :3] += off.T
    return from_dh([tuple(row) for row in rows], convention="standard", name="nearly SRS")


def offset_wrist(offset: float) -> Robot:
    """A 6R whose fifth axis misses the fourth by `offset` [m]."""
    rows = [(0, Q, 0.4, 0), (0.45, 0, 0, 0), (0.04, Q, 0, 0), (0, -Q, 0.44, 0), (offset, Q, 0, 0), (0, 0, 0.08, 0)]
    return from_dh(rows, convention="standard", name="offset wrist")


def offset_forearm(offset: float) -> Robot:
    """The same arm with `offset` [m] between its fourth and fifth axes."""
    rows = [(0, Q, 0.4, 0), (0.45, 0, 0, 0), (0.04, Q, 0, 0), (offset, -Q, 0.44, 0), (0, Q, 0, 0), (0, 0, 0.08, 0)]
    return from_dh(rows, convention="standard", name="offset forearm")


def problem(robot: Robot, corank: int = 1) -> Problem:
    return Problem(in_units(robot), task_in_units(resolve_task(None, robot), robot), corank)


@pytest.mark.parametrize("task", ["pose", "position", "vx,vz,wy"])
@pytest.mark.parametrize("name", ["ur5", "stanford", "gen3"])
def test_the_jacobian_of_many_digits_is_that_of_the_core(name: str, task: str, rng) -> None:
    robot = open_robot(name)
    for asked in (resolve_task(task, robot), resolve_task(task, robot, frame=BODY)):
        q = rng.uniform(-1, 1, robot.n)
        exactly = task_jacobian_exactly(robot, asked, np.array([flint.arb(x) for x in q]), flint)
        rounded = np.array([[float(x.mid()) for x in row] for row in exactly])
        np.testing.assert_allclose(rounded, task_jacobian(robot, q, asked), atol=2e-15)


def test_a_singular_point_comes_to_zero_and_a_minimum_of_sigma_does_not() -> None:
    """Elbow stretched: the SRS arm is singular; with errors of 1e-5 rad it is not, though σ is below 1e-9."""
    q = np.array([0.3, 0.8, -0.5, 1e-7, 0.4, 0.9, 0.2])
    ends = descents(problem(nearly_srs(0.0)), q)
    assert min(sigma for _, sigma in ends) < 1e-16
    at = problem(nearly_srs(1e-5))
    near, _ = descents(at, q)
    sigma = float(at.sigma(near[0])[at.rank])
    assert 1e-12 < sigma < 1e-9
    assert near[1] == pytest.approx(sigma, rel=1e-3)


@pytest.mark.slow
def test_points_are_not_singular_only_where_no_zero_is_near_that_lies_on_no_family() -> None:
    q = np.array([[0.3, 0.8, -0.5, 0.0, 0.4, 0.9, 0.2], [0.1, 0.7, 0.5, 0.0, -0.6, 1.1, 0.2]])
    for error, family, wrong in ((1e-5, False, True), (0.0, False, False), (0.0, True, True)):
        at = problem(nearly_srs(error))
        close = np.array([descents(at, one)[0][0] for one in q])
        assert (at.sigma(close)[:, at.rank] <= at.tolerances.singular).all()
        found, _ = not_singular(at, close, lambda x, family=family: np.full(len(x), family))
        assert found.tolist() == [wrong, wrong]


@pytest.mark.by_hand
@pytest.mark.parametrize(
    "robot",
    [
        offset_wrist(2e-5),
        pytest.param(nearly_srs(1e-5), marks=pytest.mark.slow),
        *(pytest.param(nearly_srs(error), marks=pytest.mark.by_hand) for error in (1e-4, 1e-3)),
    ],
    ids=["wrist 20 µm", "SRS 1e-5", "SRS 1e-4", "SRS 1e-3"],
)
def test_next_to_a_special_structure_nothing_is_contradicted(robot: Robot) -> None:
    found = analyze(robot, starts=2000, threads=1)
    assert found.exact is not None
    assert found.exact.agrees
    assert found.verified
    assert all(family.named for family in found.families)


@pytest.mark.by_hand
def test_near_misses_do_not_contradict_conditions() -> None:
    """An offset of 2 µm: 36 configurations with σ of 1e-13 are no singularities of corank 2."""
    found = conditions(offset_forearm(2e-6))
    assert of_conditions(found).sentence.startswith("Verified")
    assert found.explained.tested == found.explained.agree
    assert [one for one in map(str, found.remarks) if one.startswith("corank 2: ") and "50 digits" in one]


@pytest.mark.by_hand
def test_a_position_task_within_limits_is_not_contradicted() -> None:
    found = analyze(open_robot("so101"), "position", starts=2000, limits=True, threads=1)
    assert found.exact is not None
    assert found.exact.agrees
    assert found.verified


@pytest.mark.shipped
def test_a_pin_of_almost_flat_conditions_is_known_to_thirteen_digits(rng) -> None:
    """xArm 7, k1.f1: the conditions have slope 2e-6 in θ4, which leaves 1e-10 of it open; the arm itself does not."""
    robot = open_robot("xarm7")
    family = shipped_conditions("xarm7").families[0]
    at = problem(robot)
    row = row_of(at, derived_in_units(family, robot))
    assert row.sets[0] == pytest.approx([-3.0554984495581], abs=1e-13)
    q = row.linear.place(rng.uniform(-3, 3, (20, 7)), np.array([row.combinations[0]] * 20), rng)
    assert at.sigma(q)[:, at.rank].max() < 1e-13
