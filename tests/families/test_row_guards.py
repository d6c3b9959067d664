"""Each guard against a false row or a missing one, with a case in which nothing else would notice."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi

import numpy as np
import pytest

from rankdrop.families import table as families_module
from rankdrop.families.descent import verify_points
from rankdrop.families.evidence import FamilyEvidence, ObtainedFrom
from rankdrop.families.fit import linear_rows
from rankdrop.families.inspection import Signature, inspect
from rankdrop.families.row import Linear, Row, membership, on_row, solve_at_special_values, soundness, verify_values
from rankdrop.families.searching import search, unseen
from rankdrop.formula.equation import Equation, System, Term, normalised_equation
from rankdrop.local.block import singular_values
from rankdrop.problem import Problem
from rankdrop.results.known import shipped
from rankdrop.robot.model import Joint, JointKind, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.units import in_units

PLANTED = FamilyEvidence(ObtainedFrom.VALUES)

STRAIGHT = (0.0, pi)


def problem(name: str, corank: int) -> Problem:
    robot = open_robot(name)
    task = resolve_task(None, robot)
    return Problem(robot, replace(task, length_scale=task.scale(robot)), corank)


def pinned(problem: Problem, *joints: int, values: tuple[float, ...] = STRAIGHT) -> Row:
    """The row on which joints (from 0) stand at the values."""
    n = problem.robot.n
    linear = Linear.of(problem.robot, [tuple(int(i == j) for i in range(n)) for j in joints])
    free = tuple(j for j in range(n) if j not in joints)
    return Row(linear, (values,) * len(joints), (), Signature(len(joints), joints, free, ()), PLANTED)


def coupled(*equations: Equation) -> Row:
    """A row of PUMA without pinned joints."""
    every = tuple(range(6))
    return Row(Linear.of(open_robot("puma560"), []), (), equations, Signature(1, (), (), every), PLANTED)


def test_what_loses_more_everywhere_is_no_row_of_this_corank(rng) -> None:
    """PUMA, shoulder and elbow at once: every point is singular, and of corank 2; no family of corank 1."""
    values = [(pi / 2, float(np.arctan2(-0.4318, 0.0203)))]  # θ2; a3 s3 + d4 c3 = 0
    for corank, holds in ((1, False), (2, True)):
        at = problem("puma560", corank)
        assert verify_values(at, pinned(at, 1, 2), values, rng) == [holds]


def test_a_point_near_a_square_that_is_not_singular_to_rounding_is_not_on_the_row() -> None:
    """Stanford arm: σ ~ q3² near q3 = 0. 50 µm off, σ is small and far above rounding."""
    at = problem("stanford", 1)
    row = pinned(at, 2, values=(0.0,))
    q = np.array([[0.3, 1.0, 5e-5, 0.4, 1.1, 0.2]])
    sigma = singular_values(at.robot, q, at.task)[0, at.rank]
    assert 1e-9 < sigma < 5e-8
    assert not on_row(at, row, q).any()
    assert on_row(at, row, q * [1, 1, 0, 1, 1, 1]).all()


def test_a_point_on_two_rows_is_one_point(rng) -> None:
    """PA-10, corank 1: the elbow twice over. Counted twice, single points would look like pieces met twice."""
    at = problem("pa10", 1)
    inspection = inspect(at, verify_points(at, search(at.robot, 1, task=at.task, starts=60).converged))
    cover = membership(at, inspection.q)
    elbow, again = pinned(at, 3), pinned(at, 3)
    once = families_module._pieces(cover, [elbow], inspection)
    assert families_module._pieces(cover, [elbow, again], inspection) == once
    assert sum(once) == int((inspection.exact & cover(elbow)).sum())
    assert unseen([1, 1, 8]).estimate == pytest.approx(0.2)


def test_equations_are_solved_where_only_held_joints_reach() -> None:
    """PUMA's wrist, sin θ5 = 0, times 3 + cos 2θ2 + cos 2θ4 + cos 2θ6: that is zero at θ2, θ4, θ6 = ±π/2 alone, where
    no random start arrives, and where θ5 is anything the arm is regular."""
    at, zero = problem("puma560", 1), (0,) * 6
    wrist, wide = (0, 0, 0, 0, 2, 0), widened()
    found, strangers = soundness(at, System((wide,)), 1, np.random.default_rng(0))
    assert (found.holds, len(strangers)) == (True, 0)  # random starts see nothing
    tested, strangers = solve_at_special_values(at, coupled(wide), {}, np.random.default_rng(0))
    assert tested > 50
    assert len(strangers) > 0
    assert np.allclose(np.cos(strangers[:, [1, 3, 5]]), 0, atol=1e-3)
    assert singular_values(at.robot, strangers, at.task)[:, 5].min() > 1e-2
    alone = Equation((Term(1.0, "sin", wrist, zero),))
    tested, strangers = solve_at_special_values(at, coupled(alone), {}, np.random.default_rng(0))
    assert tested > 10
    assert not len(strangers)


def widened(joints: tuple[int, ...] = (1, 3, 5)) -> Equation:
    """PUMA's wrist, sin θ5 = 0, times 3 + Σ cos 2θ_j over three joints: zero where all of them are at ±π/2, too."""
    zero, wrist = (0,) * 6, (0, 0, 0, 0, 2, 0)
    terms = [Term(3.0, "sin", wrist, zero)]
    for joint in joints:  # sin a cos b = (sin(a + b) + sin(a − b))/2
        for sign in (4, -4):
            terms.append(Term(0.5, "sin", tuple(sign * (i == joint) + h for i, h in enumerate(wrist)), zero))
    return normalised_equation(terms)


def test_regular_solutions_count_against_a_row(rng) -> None:
    """A row of which random starts see nothing wrong is unsound by its regular solutions, and those alone."""
    at = problem("puma560", 1)
    inspection = inspect(at, verify_points(at, search(at.robot, 1, task=at.task, starts=40).converged))
    cover = membership(at, inspection.q)
    alone = Equation((Term(1.0, "sin", (0, 0, 0, 0, 2, 0), (0,) * 6),))
    for equation, sound in ((alone, True), (widened(), False)):
        row = coupled(equation)
        random, _ = soundness(at, System((equation,)), 1, np.random.default_rng(0))
        check = families_module._test_rows(at, [row], inspection, cover, 0)[row][0]
        assert random.holds
        assert check.holds is sound
        assert check.tested > random.tested  # those elsewhere were counted


def test_equations_are_solved_together_from_anywhere() -> None:
    """PUMA's wrist, sin θ5 = 0, times sin(θ1 − 0.7), sin(θ3 − 0.4) and sin(θ5 − 0.9): three equations that also vanish
    where these three joints stand so. The first equation alone leads to the wrist; no right angle leads there."""
    at = problem("puma560", 1)
    equations = tuple(wrist_times(joint, value) for joint, value in ((0, 0.7), (2, 0.4), (4, 0.9)))
    found, _ = soundness(at, System(equations), 1, np.random.default_rng(0))
    assert found.holds
    assert found.tested > 50
    _, strangers = solve_at_special_values(at, coupled(*equations), {}, np.random.default_rng(0))
    assert len(strangers) > 0
    assert np.allclose(np.sin(strangers[:, [0, 2, 4]] - (0.7, 0.4, 0.9)), 0, atol=1e-9)


@pytest.mark.slow
def test_regular_solutions_at_special_places_count_against_a_derived_family() -> None:
    """The same equations as those of a derived family: random starts call them sound, the table does not."""
    robot = in_units(open_robot("puma560"))
    wrist = next(one for one in shipped("puma560").families if one.id == "k1.f3")
    equations = tuple(wrist_times(joint, value) for joint, value in ((0, 0.7), (2, 0.4), (4, 0.9)))
    wide = replace(wrist, pinned=(), coupled=(1, 3, 5), free=(2, 4, 6), equations=equations)
    cloud = search(robot, 1, starts=200)
    for one, holds in ((wrist, True), (wide, False)):
        found = families_module.families(cloud, known=[one], fresh=100)
        row = found.families[0]
        assert (row.id, row.name) == (wrist.id, wrist.name)
        assert row.soundness.holds == holds
        assert row.soundness.tested > 50


def wrist_times(joint: int, value: float) -> Equation:
    """sin θ5 · sin(θ − value) = (cos(θ5 − θ + value) − cos(θ5 + θ − value))/2, of a joint from 0."""
    terms = []
    for sign in (-1, 1):
        turned = tuple(2 * (i == 4) + sign * 2 * (i == joint) for i in range(6))
        terms.append(Term(-sign * cos(value) / 2, "cos", turned, (0,) * 6))
        terms.append(Term(-np.sin(value) / 2, "sin", turned, (0,) * 6))
    return normalised_equation(terms)


def spot_arm() -> Robot:
    """Arm of Boston Dynamics' Spot: screws (v; ω) at q = 0 of `spot_arm.urdf` in the ROS package spot_description."""
    screws = [
        [0, 0, 0, 0, 0, 1], [0, -0.115, 0, -1, 0, 0], [0, 0.115, -0.3125, 1, 0, 0],
        [-0.0475, 0, -0.001, 0, 1, 0], [0, 0.0475, -0.69859, 1, 0, 0], [-0.0475, 0, -0.0085, 0, 1, 0],
    ]  # fmt: skip
    home = np.eye(4)
    home[:3, 3] = -0.0085, 0.77959, 0.0475
    joints = [Joint(f"j{i + 1}", JointKind.REVOLUTE, np.array(s, dtype=float)) for i, s in enumerate(screws)]
    return Robot("spot_arm", tuple(joints), home)


def test_values_of_a_square_that_round_to_pi_are_pi(rng) -> None:
    """Elbow and wrist of Spot's arm, where D vanishes too much: values are known to 2e-12, and π was two values."""
    robot = in_units(spot_arm())
    task = resolve_task(None, robot)
    at = Problem(robot, replace(task, length_scale=task.scale(robot)), 2)
    points = search(at.robot, 2, task=at.task, starts=400).converged
    rows = linear_rows(at, points[np.abs(np.cos(points[:, 1])) < 1e-6], rng)
    assert sorted(row.sets[2] for row in rows) == [(0.0,), (pi,)]
    assert all(singular_values(at.robot, row.sample(at, 1, rng)[0][0, :1], at.task)[0, 4] < 1e-9 for row in rows)


@pytest.mark.parametrize("step", [0.3, 6e-6])
def test_the_value_at_the_witness_is_among_those_that_are_listed(step: float) -> None:
    """Twelve of 20 values are listed, the smallest; a file with a witness at another one was refused as damaged."""
    at = problem("puma560", 1)
    q = np.zeros((20, 6))
    q[:, 4] = 0.2 + step * np.arange(20)
    for witness in q[:, 4]:
        values = families_module._values(at, q, 4, float(witness))
        assert min(abs(np.sin((value - witness) / 2)) for value in values) <= 0.5 * at.tolerances.value
        assert len(values) == (12 if step > 1e-5 else 1)


@pytest.mark.parametrize(("size", "judged"), [(1.0, True), (1e-5, True), (1e-8, False)])
def test_solutions_of_conditions_that_are_flat_everywhere_are_not_judged(size: float, judged: bool, rng) -> None:
    """Of 1e-8 sin θ2 Newton's method knows the zeros to 1e-2 rad: their σ says nothing of the elbow of a planar arm."""
    at = problem("planar2r", 1)
    elbow = Equation((Term(size, "sin", (0, 2), (0, 0)),))
    check, regular = soundness(at, System((elbow,)), 1, rng)
    assert (check.tested > 0) is judged
    assert len(regular) == 0
