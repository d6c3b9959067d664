"""Crossings and touched singularities on slivers of a path, by signs that rounding cannot have made."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from path.slivers import dip, proven, singular
from rankdrop.families import soundness as module
from rankdrop.families.record import Check
from rankdrop.formula.equation import Equation, Term
from rankdrop.path.check.check import check_path
from rankdrop.path.check.crossings import crossings, signs, signs_at
from rankdrop.path.curve import curve
from rankdrop.results.known import known_analysis
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.tolerances import DEFAULT


@pytest.mark.shipped
def test_a_condition_fitted_on_the_spot_that_fails_its_test_proves_no_crossing(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = open_robot("pa10")
    task = resolve_task(None, robot)
    elbow = [np.array([0.3, 0.4, 0.2, 0.0, 0.5, 0.7, 0.1])]
    tested = signs_at(robot, task, elbow, DEFAULT)
    assert len(tested) == 1
    sound, whole = module.soundness, []

    def failing(*arguments: object, **options: object) -> object:
        check, rest = sound(*arguments, **options)
        whole.append(check)
        return Check(400, 399), rest

    monkeypatch.setattr(module, "soundness", failing)
    assert signs_at(robot, task, elbow, DEFAULT) == {}
    assert whole[0].holds


@pytest.mark.shipped
@pytest.mark.slow
def test_what_is_left_of_an_unfinished_sliver_is_undecided_and_no_part_of_its_crossing() -> None:
    robot = open_robot("puma560")
    task = resolve_task(None, robot)
    path = curve(np.array([[0.1, -1.2, 1.0, 0.5, -0.4, 0.2], [0.5, -1.0, 1.3, 0.2, 0.5, 0.1]]), None)
    parts = crossings(robot, task, path, [((0, 0.2), (0, 0.8), False)], (), DEFAULT)
    assert [one.verdict for one in parts] == ["undecided", "crossing", "undecided"]
    assert path.spot(parts[0].start) == (0, 0.2)
    assert path.spot(parts[2].end) == (0, 0.8)
    assert parts[1].end.share - parts[1].start.share < 1e-8
    check = check_path(robot, path.control[0], evaluations=1)
    assert sum(one.verdict == "undecided" for one in check.stretches) == 2
    assert check.undecided_share > 0.99


def test_the_sign_of_a_family_that_failed_its_test_proves_no_crossing() -> None:
    """The Panda only touches its singular set; the sign of a plane of θ1, called a family, changes at that place."""
    robot = open_robot("panda")
    task = resolve_task(None, robot)
    family = next(one for one in known_analysis(robot, task).families if one.corank == 1)
    touched = np.array(family.witness)
    plane = Equation((
        Term(float(np.cos(touched[0])), "sin", (1, 0, 0, 0, 0, 0, 0), (0,) * 7),
        Term(-float(np.sin(touched[0])), "cos", (1, 0, 0, 0, 0, 0, 0), (0,) * 7),
    ))  # fmt: skip
    planted = replace(family, dimension=6, equations=(plane,))
    failed = replace(planted, soundness=Check(400, 399))
    assert planted.soundness.holds
    assert not failed.soundness.holds
    path = curve(np.stack([touched - 0.01, touched + 0.01]), None)
    sliver = ((0, 0.5 - 1e-7), (0, 0.5 + 1e-7), True)
    kinds = [one.verdict for one in crossings(robot, task, path, [sliver], [failed], DEFAULT)]
    assert kinds == ["touching"]
    assert signs(robot, task, [failed]) == {}
    assert list(signs(robot, task, [planted])) == [plane.text()]  # which a sound one would prove


def test_a_crossing_is_bracketed_by_the_determinant_alone() -> None:
    robot = open_robot("puma560")
    task = resolve_task(None, robot)
    path = curve(np.array([[0.1, -1.2, 1.0, 0.5, -0.4, 0.2], [0.5, -1.0, 1.3, 0.2, 0.5, 0.1]]), None)
    (one,) = crossings(robot, task, path, proven(robot, task, path).slivers, (), DEFAULT)
    low, high = (place.share for place in one.bracket)
    assert (one.verdict, one.evidence) == ("crossing", "determinant")
    assert low < 4 / 9 < high
    assert high - low < 1e-9


def test_a_change_of_sign_where_nothing_is_singular_is_no_crossing() -> None:
    """A family whose condition holds too widely: σ has the last word."""
    robot = open_robot("pa10")
    task = resolve_task(None, robot)
    family = next(one for one in known_analysis(robot, task).families if one.dimension == 6)
    other = Equation((Term(1.0, "sin", (0, 2, 0, 0, 0, 0, 0), (0,) * 7),))
    wrong = replace(family, equations=(other,))
    way = np.array([0.05, 0.1, 0.05, 0.05, 0.05, 0.05, 0.05])
    middle = np.array([0.3, 0.0, 0.4, 0.9, 0.3, 0.8, 0.2])
    path = curve(np.stack([middle - way, middle + way]), None)
    sliver = ((0, 0.3), (0, 0.7), True)
    (one,) = crossings(robot, task, path, [sliver], [wrong], DEFAULT)
    assert one.verdict == "undecided"


def test_a_sliver_that_is_singular_at_one_place_only_does_not_lie_in_the_set() -> None:
    robot = open_robot("puma560")
    task = resolve_task(None, robot)
    for depth, kind in ((0.0, "touching"), (-3e-8, "undecided")):  # made by hand: it would be proven free
        q, v, t = dip(depth)
        path = curve(q, t, v, None, "cubic")
        (one,) = crossings(robot, task, path, [((0, 0.3), (0, 0.7), True)], (), DEFAULT)
        assert (one.verdict, one.lies) == (kind, False)
        assert one.closest.place.share == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize("shares", [(0.5 - 1e-9, 0.5), (0.5, 0.5 + 1e-9)])
def test_a_zero_at_the_end_of_a_sliver_is_crossed(shares: tuple[float, float]) -> None:
    """On one side of it there is no certain sign inside, and what lies outside is proven free."""
    robot = open_robot("planar3r")
    path = curve(np.array([[0.1, -0.5, 0.2], [0.3, 0.5, 0.4]]), None)
    (one,) = crossings(robot, resolve_task(None, robot), path, [((0, shares[0]), (0, shares[1]), True)], (), DEFAULT)
    assert one.verdict == "crossing"
    assert (one.start.share, one.end.share) == shares


@pytest.mark.slow
def test_a_singularity_of_codimension_two_is_touched() -> None:
    """The Panda's determinant of J Jᵀ does not change its sign; a condition of two equations proves nothing."""
    robot = open_robot("panda")
    task = resolve_task(None, robot)
    target = next(q for q in singular(robot, task, 1, 80) if abs(q[3]) > 0.3)
    way = np.random.default_rng(3).normal(size=7) * 0.1
    found = check_path(robot, np.stack([target - way, target + 0.7 * way]))
    assert found.verdict == "touching"
    assert found.crossings[0].corank == 1
    np.testing.assert_allclose(found.crossings[0].closest.q, target, atol=1e-6)


def test_where_two_families_are_crossed_at_once_the_corank_is_two() -> None:
    robot = open_robot("puma560")
    target = np.array([0.3, 0.4, 0.0, 0.2, 0.0, 0.1])
    task = resolve_task(None, robot)
    elbow = singular(robot, task, 2, 200)
    target = elbow[np.abs(np.sin(elbow[:, 4])) < 1e-9][0]
    way = np.array([0.1, 0.2, 0.15, 0.1, 0.2, 0.1])
    found = check_path(robot, np.stack([target - way, target + way]))
    assert found.crossings[0].corank == 2
