"""The checker confirms what is honest, for every kind of arm, and refuses whatever is changed afterwards."""

from __future__ import annotations

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from reference import arms, region

from rankdrop.certify import check as checker
from rankdrop.certify.ball import certified_radius
from rankdrop.certify.check import Arm, check
from rankdrop.certify.setting import enclose, settings_for
from rankdrop.errors import OptionError
from rankdrop.robot.open import open_robot
from rankdrop.task import Frame, Task, resolve_task

ARMS = {
    **{name: (lambda name=name: open_robot(name)) for name in (
        "planar3r", "puma560", "ur5", "pa10", "panda", "scara", "stanford", "almarkhi4", "planar2r")},
    "random slides": lambda: arms.random_chain(np.random.default_rng(4), "rprrpr"),
    "random screws": lambda: arms.random_chain(np.random.default_rng(5), "rhrphrr"),
    "mimics": lambda: region.coupled(np.random.default_rng(6), "r p r1:0.3 p1:-0.4 r h0:2.5 r p0:0.3 r"),
    "turns led by a slide": lambda: region.coupled(np.random.default_rng(8), "r p r1:2 r r1:-3 r1:2 r r"),
    "five joints": lambda: arms.random_chain(np.random.default_rng(7), "rrrrr"),
}  # fmt: skip


def honest(robot, task=None, seed=3, evaluations=200):
    """A certificate with boxes, of the ball that one enclosure certifies and a bit more."""
    q = np.random.default_rng(seed).uniform(-1.5, 1.5, robot.n)
    single = certified_radius(robot, q, task, evaluations=0).single
    return certified_radius(robot, q, task, at_most=min(1.3 * single, 3.1), evaluations=evaluations, keep_boxes=True)


@pytest.fixture(scope="module")
def puma():
    return open_robot("puma560")


@pytest.fixture(scope="module")
def certificate(puma):
    found = honest(puma, evaluations=2000)
    assert found.radius > 0.1
    assert len(found.boxes[0]) > 5
    return found


@pytest.mark.parametrize("name", ARMS)
def test_honest_certificates_hold(name):
    robot = ARMS[name]()
    found = honest(robot)
    verdict = check(robot, found)
    assert verdict.holds, verdict
    assert found.radius > 0.0
    assert verdict.boxes == len(found.boxes[0]) > 0


@pytest.mark.parametrize("name", ["planar2r", "planar3r", "scara", "pa10"])
def test_a_ball_just_as_large_as_one_enclosure_allows_holds(name):
    robot = open_robot(name)
    for q in np.random.default_rng(5).uniform(-1.5, 1.5, (5, robot.n)):
        single = certified_radius(robot, q, evaluations=0).single
        found = certified_radius(robot, q, at_most=single, keep_boxes=True)
        assert found.radius == single
        assert check(robot, found).holds


@pytest.mark.slow_at("puma560")
@pytest.mark.parametrize("name", ["planar3r", "scara", "puma560"])
def test_a_ball_that_is_asked_for_without_an_end_holds_as_far_as_it_was_proven(name):
    robot = open_robot(name)
    q = np.random.default_rng(6).uniform(-1.5, 1.5, robot.n)
    found = certified_radius(robot, q, keep_boxes=True, evaluations=2000)
    assert found.radius > 0.05
    verdict = check(robot, found)
    assert verdict.holds, verdict


def test_a_radius_found_without_boxes_can_be_proven_again_with_them():
    robot, q = open_robot("ur5"), np.array([0.3, -0.8, 1.2, 0.4, 0.3, 0.1])
    first = certified_radius(robot, q, evaluations=2000)
    again = certified_radius(robot, q, at_most=first.radius, evaluations=20_000, keep_boxes=True)
    assert again.radius == first.radius > 1.2 * first.single
    assert check(robot, again).holds


@pytest.mark.parametrize("task", ["position", "orientation", "planar-position", "pose"])
def test_every_task_that_can_be_certified_can_be_checked(task):
    robot = open_robot("planar3r" if task.startswith("planar") else "puma560")
    assert check(robot, honest(robot, task)).holds


def test_a_point_on_the_tool_can_be_checked(puma):
    task = resolve_task("position", puma, frame=Frame(0, -1, (0.1, 0.2, 0.3)))
    found = honest(puma, task)
    assert check(puma, found).holds
    assert not check(puma, replace(found, frame=Frame(0, -1, (0.1, 0.2, 0.31)))).holds


def changed(certificate, **values):
    return replace(certificate, setting=replace(certificate.setting, **values))


@pytest.mark.parametrize("factor", [1.001, 1.3, 10.0, np.inf, np.nan, -1.0])
def test_another_radius_is_refused(puma, certificate, factor):
    radius = certificate.radius * factor
    assert not check(puma, replace(certificate, radius=radius)).holds
    if factor > 1.0:
        assert not check(puma, replace(certificate, radius=radius, at_most=radius)).holds
        assert not check(puma, replace(certificate, at_most=certificate.radius / 2)).holds


def test_a_smaller_radius_holds(puma, certificate):
    assert check(puma, replace(certificate, radius=certificate.radius / 2)).holds


def test_every_missing_box_is_noticed(puma):
    found = honest(puma, evaluations=60)  # cut short: the boxes do not fill the ball asked for
    centre, half = found.boxes
    needed = np.linalg.norm(np.maximum(0.0, np.abs(centre) - half), axis=1) < found.radius * 0.999
    assert needed.sum() > 0
    for i in np.flatnonzero(needed)[:10]:
        fewer = (np.delete(centre, i, axis=0), np.delete(half, i, axis=0))
        assert not check(puma, replace(found, boxes=fewer)).holds
    assert not check(puma, replace(found, boxes=(centre[:0], half[:0]))).holds


def test_boxes_that_were_moved_or_widened_are_noticed(puma, certificate):
    centre, half = certificate.boxes
    for axis in np.flatnonzero(certificate.setting.matters):
        wide, shifted, narrow = half.copy(), centre.copy(), half.copy()
        wide[0, axis] *= 4.0
        shifted[0, axis] += half[0, axis]
        narrow[0, axis] *= 0.999
        for boxes in ((centre, wide), (shifted, half), (centre, narrow)):
            verdict = check(puma, replace(certificate, boxes=boxes))
            assert not verdict.holds
    whole = (np.zeros((1, 6)), np.full((1, 6), certificate.at_most) * certificate.setting.matters)
    verdict = check(puma, replace(certificate, boxes=whole))
    assert not verdict.holds
    assert verdict.doubtful == 1  # one box for all covers the ball, but is not free


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_boxes_that_are_no_numbers_are_refused(puma, certificate, bad):
    centre, half = (part.copy() for part in certificate.boxes)
    half[0, 1] = bad
    assert not check(puma, replace(certificate, boxes=(centre, half))).holds
    verdict = check(puma, replace(certificate, boxes=(centre, -certificate.boxes[1])))
    assert (verdict.holds, verdict.reason) == (False, "a box has a negative width")
    assert not check(puma, replace(certificate, boxes=(centre[:, :5], half[:, :5]))).holds
    assert not check(puma, replace(certificate, q=np.full(6, bad))).holds


def test_another_arm_or_another_place_is_refused(puma, certificate):
    assert not check(open_robot("ur5"), certificate).holds
    assert not check(region.scaled(puma, 1.001), certificate).holds
    q = certificate.q.copy()
    q[4] = 0.0  # the wrist is singular
    assert not check(puma, replace(certificate, q=q)).holds


def test_settings_that_were_changed_are_refused(puma, certificate):
    setting = certificate.setting
    assert check(puma, changed(certificate, arm=setting.arm * 1.1)).holds  # too long is no lie
    for i in np.flatnonzero(setting.arm > 1e-6):
        shorter = setting.arm.copy()
        shorter[i] *= 0.9
        verdict = check(puma, changed(certificate, arm=shorter))
        assert not verdict.holds
        assert "reaches" in verdict.reason
    for i in np.flatnonzero(setting.matters):
        fewer = setting.matters.copy()
        fewer[i] = False
        assert not check(puma, changed(certificate, matters=fewer)).holds
    for values in (
        {"rank": 5}, {"rank": 0}, {"rows": (0, 1, 2)}, {"rows": (3, 4, 5)}, {"scale": np.full(6, 2.0)},
        {"scale": np.zeros(6)}, {"link": 9}, {"link": -1}, {"length": 0.0}, {"length": np.nan},
        {"arm": setting.arm[:5]},
    ):  # fmt: skip
        assert not check(puma, changed(certificate, **values)).holds, values
    assert not check(puma, replace(changed(certificate, rank=5), rank=5)).holds
    assert not check(puma, replace(changed(certificate, rows=(3, 4, 5), rank=3), rank=3)).holds


def test_another_point_is_proven_or_refused_but_never_believed(puma, certificate):
    # any link and point would do for a proof; reaches and bounds are then those of that place
    far = changed(certificate, point=(50.0, 0.0, 0.0))
    assert not check(puma, far).holds
    assert not check(puma, changed(far, arm=np.full(6, 200.0))).holds


def test_another_task_is_refused(puma, certificate):
    for rows in ((0, 1), (0, 1, 2), (3, 4, 5), (0, 1, 2, 3)):
        assert not check(puma, replace(certificate, rows=rows)).holds
    position = honest(puma, "position")
    assert not check(puma, replace(position, rows=(0, 1, 2, 3, 4, 5))).holds
    assert not check(puma, changed(position, point=(0.0, 0.0, 1e-6))).holds
    planar = open_robot("planar3r")
    tilted = Task("planar", (0, 1, 5), Frame(0, -1))
    assert check(planar, honest(planar, tilted)).holds


def test_a_certificate_without_boxes_cannot_be_checked(puma):
    with pytest.raises(OptionError, match="keep_boxes"):
        check(puma, certified_radius(puma, [0.3] * 6, evaluations=0))


def test_a_single_singular_box_is_not_free():
    robot = open_robot("planar3r")
    found = certified_radius(robot, [0.3, 0.5, 0.2], at_most=0.4, keep_boxes=True, evaluations=200)
    assert check(robot, found).holds
    assert not check(robot, replace(found, q=np.array([0.3, 0.3, 0.2]))).holds


@pytest.mark.parametrize("name", ARMS)
def test_the_bounds_of_the_checker_are_those_of_the_core(name):
    # the bounds of the core are tested against the arm itself; two programs agree on all of it
    robot = ARMS[name]()
    q = np.random.default_rng(9).uniform(-2, 2, (4, robot.n))
    half = np.array([0.0, 1e-3, 0.05, 0.4])[:, None] * np.random.default_rng(10).uniform(0.3, 1, q.shape)
    for setting in settings_for(robot, resolve_task(None, robot))[::5]:
        _, _, bound, sigma, *_ = enclose(robot, setting, q, half)
        arm = Arm(robot, setting.link, setting.point, setting.length)
        np.testing.assert_allclose(arm.reach, setting.arm, rtol=1e-9, atol=1e-12)
        for i in range(len(q)):
            again = arm.bound(q[i], half[i], setting.scale, list(setting.rows), setting.rank)
            np.testing.assert_allclose(again[0], sigma[i], atol=1e-12 * sigma[i, 0])
            np.testing.assert_allclose(again[1], bound[i], rtol=1e-6, atol=1e-12)


def test_the_checker_shares_no_code_with_what_it_checks():
    allowed = {"robot.model", "errors", "certify.ball"}
    for node in ast.walk(ast.parse(Path(checker.__file__).read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("rankdrop"):
            assert node.module.removeprefix("rankdrop.") in allowed
            if node.module == "rankdrop.certify.ball":
                assert {item.name for item in node.names} <= {"Certificate", "LARGEST"}  # data, no code
        if isinstance(node, ast.Import):
            assert not any(item.name.startswith("rankdrop") for item in node.names)
