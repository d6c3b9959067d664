"""Solutions of a row's equations are singular: from random starts, at special places, and where equations are flat."""

from __future__ import annotations

from dataclasses import replace
from math import cos

import numpy as np
import pytest
from families.planted import PLANTED, problem

from rankdrop.families import table as families_module
from rankdrop.families.descent import verify_points
from rankdrop.families.inspection import Signature, inspect
from rankdrop.families.linear_conditions import Linear
from rankdrop.families.row import Row, membership
from rankdrop.families.searching import search
from rankdrop.families.soundness import solve_at_special_values, soundness
from rankdrop.formula.equation import Equation, System, Term, normalised_equation
from rankdrop.local.block import singular_values
from rankdrop.results.known import shipped
from rankdrop.robot.open import open_robot
from rankdrop.units import in_units


def coupled(*equations: Equation) -> Row:
    """A row of PUMA without pinned joints."""
    every = tuple(range(6))
    return Row(Linear.of(open_robot("puma560"), []), (), equations, Signature(1, (), (), every), PLANTED)


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


@pytest.mark.parametrize(("size", "judged"), [(1.0, True), (1e-5, True), (1e-8, False)])
def test_solutions_of_conditions_that_are_flat_everywhere_are_not_judged(size: float, judged: bool, rng) -> None:
    """Of 1e-8 sin θ2 Newton's method knows the zeros to 1e-2 rad: their σ says nothing of the elbow of a planar arm."""
    at = problem("planar2r", 1)
    elbow = Equation((Term(size, "sin", (0, 2), (0, 0)),))
    check, regular = soundness(at, System((elbow,)), 1, rng)
    assert (check.tested > 0) is judged
    assert len(regular) == 0
