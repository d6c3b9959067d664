"""Share of the joint space near families: closed forms, distances walked one by one, and what is said of bounds."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import partial
from math import pi, radians

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from rankdrop.codec import json_text
from rankdrop.distance.distance import family_distances
from rankdrop.distance.share import _reaches_zero, near_shares, slow_share, slower_than
from rankdrop.errors import OptionError
from rankdrop.families.points import near_family
from rankdrop.kinematics import jacobian
from rankdrop.local.block import joint_scale, sample
from rankdrop.local.rates import rate_limits
from rankdrop.problem import Problem
from rankdrop.report.sections import corank_tables
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import shipped
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema
from rankdrop.task import resolve_task
from rankdrop.text.joint_limits import inside_limits
from rankdrop.text.shares import slow_line
from rankdrop.verbs.analyze import analyze
from rankdrop.verbs.explain import explain


def test_a_pinned_joint_takes_the_share_of_its_range():
    """Elbow of the PA-10: θ4 within δ of 0 or π is 4δ/2π; shoulder and wrist: a disc around each pair of values."""
    found, robot = shipped("pa10"), open_robot("pa10")
    near = near_shares(found.families, Problem(robot, found.task), radians(8), samples=40_000)
    shares = {family.name: one for family, one in zip(found.families, near.families, strict=True)}
    elbow = next(one for family, one in zip(found.families, near.families, strict=True)
                 if family.corank == 1 and [pin.number for pin in family.pinned] == [4])  # fmt: skip
    assert abs(elbow.share - 32 / 360) < 4 * elbow.error
    pairs = [one for family, one in zip(found.families, near.families, strict=True)
             if family.corank == 1 and len(family.pinned) == 2]  # fmt: skip
    assert len(pairs) == 3
    for one in pairs:
        assert abs(one.share - 4 * pi * radians(8) ** 2 / (2 * pi) ** 2) < 4 * one.error
        assert not one.bound
    assert near.any.share >= max(one.share for one in shares.values())


@pytest.mark.parametrize("name", ["puma560", "panda", "ur5", "stanford"])
def test_being_near_is_what_walking_there_says(name):
    robot, found = open_robot(name), shipped(name)
    rows = found.of_corank(1)
    q, delta = sample(robot, found.task, 40, 3), 0.6
    scale = joint_scale(robot, found.task)
    walked = np.zeros((len(rows), len(q)), dtype=bool)
    for i, at in enumerate(q):
        distances = {one.family.id: one.distance for one in family_distances(rows, robot, at, found.task)}
        walked[:, i] = [distances[row.id] <= delta for row in rows]
    walks = [partial(_reaches_zero, row, scale, np.random.default_rng(0)) for row in rows]
    pairs = zip(rows, walks, strict=True)
    ours = np.array([near_family(row, q, delta, scale, robot.periodic, walk) for row, walk in pairs])
    assert np.array_equal(ours, walked)
    assert walked.any()


def test_limits_count_the_range_alone():
    """θ5 of the PUMA within 5° of 0, inside ±100°: 10° of 200°; π is outside and too far to be near."""
    robot, found = open_robot("puma560"), shipped("puma560")
    wrist = [row for row in found.of_corank(1) if [pin.number for pin in row.pinned] == [5]]
    lower, upper = robot.lower[4], robot.upper[4]
    (one,) = near_shares(wrist, Problem(robot, found.task, limits=True), radians(5), samples=20_000).families
    assert abs(one.share - 2 * radians(5) / (upper - lower)) < 4 * one.error


def test_the_interval_holds_the_share_and_never_leaves_0_to_1():
    robot, found = open_robot("pa10"), shipped("pa10")
    near = near_shares(found.families, Problem(robot, found.task), 0.05, samples=200)
    for one in (*near.families, near.any):
        low, high = one.interval
        assert 0.0 <= low <= one.share <= high <= 1.0
        assert high > 0.0


@pytest.mark.parametrize("wrong", [0.0, -0.1, 2.0, float("nan")])
def test_no_distance_is_refused(wrong):
    with pytest.raises(OptionError):
        analyze(open_robot("planar2r"), starts=10, within=wrong)


@pytest.fixture(scope="module")
def panda() -> Analysis:
    return analyze(open_robot("panda"), starts=1500, limits=True, exact="off", within=radians(5))


@pytest.mark.by_hand
def test_an_analysis_keeps_its_shares_through_json_and_the_report(panda):
    record = json.loads(json_text(panda.to_dict()))
    Draft202012Validator(load_schema("analysis")).validate(record)
    assert Analysis.from_dict(record) == panda
    assert Analysis.from_dict(record).near == panda.near
    assert "of singularities" in corank_tables(panda)
    assert not Draft202012Validator(load_schema("analysis")).is_valid(record | {"near": {"within": 0.1}})


@pytest.mark.by_hand
def test_values_are_told_inside_the_range(panda):
    robot = panda.robot
    (row,) = panda.of_corank(2)
    inside = inside_limits(row, robot)
    assert inside.holds
    shown = {one.number: one.values for one in inside.with_values_inside(row).pinned}
    for number, values in shown.items():
        assert all(robot.lower[number - 1] <= value <= robot.upper[number - 1] for value in values)
    assert shown[6] == pytest.approx([3.3614], abs=1e-3)
    (record,) = [one for one in panda.to_dict()["families"] if one["corank"] == 2]
    assert next(one["values"] for one in record["inside"]["pinned"] if one["number"] == 6) == list(shown[6])
    assert "3.3614" in panda._repr_html_()
    assert "2.9218" not in panda._repr_html_()


def test_the_task_decides_as_ever():
    robot = open_robot("scara")
    found = analyze(robot, "position", starts=200, exact="off", within=0.1)
    assert found.near is not None
    assert found.near.families
    assert resolve_task("position", robot).m == 3


def test_the_share_that_is_slow_is_that_of_configurations_explained_as_slow():
    """Of 60 configurations inside the limits, those at which `explain` says that a straight motion is slow."""
    robot = open_robot("gen3")
    task = resolve_task(None, robot)
    share, slow = slow_share(Problem(robot, task), samples=60, seed=3)
    q = sample(robot, task, 60, 3, limits=True)
    said = [any(one.speed < one.limit for one in explain(robot, here, evaluations=0).straight) for here in q]
    assert said == slow.tolist()
    assert 0 < share.near == sum(said)
    assert slow_share(Problem(robot, task), speed=10.0, samples=60)[0].share == 1.0
    bare = replace(robot, joints=tuple(replace(joint, velocity=float("inf")) for joint in robot.joints))
    assert slow_share(Problem(bare, task), samples=60)[0] is None


def test_the_share_slower_than_a_speed_is_that_of_the_inverse_jacobian():
    """min_i limit_i / ‖row_i of the first three columns of J⁻¹‖ at the same configurations, and Wilson's interval."""
    robot = open_robot("irb120")
    task = resolve_task(None, robot)
    found = slower_than(Problem(robot, task), 0.25, samples=400, seed=3)
    q = sample(robot, task, 400, 3, limits=True)
    inverse = np.linalg.inv(np.array([jacobian(robot, one) for one in q]))[:, :, :3]
    slow = int(((rate_limits(robot) / np.linalg.norm(inverse, axis=2)).min(axis=1) < 0.25).sum())
    assert (found.share.near, found.share.samples, found.seed, found.tool_speed) == (slow, 400, 3, 0.25)
    assert 0 < slow < 400
    low, high = found.share.interval
    for end in (low, high):  # ends of Wilson's interval: |p − end| = z √(end (1 − end)/N)
        assert abs(slow / 400 - end) == pytest.approx(1.959964 * np.sqrt(end * (1 - end) / 400), rel=1e-5)
    assert low < slow / 400 < high
    assert re.search(rf"At {100 * slow / 400:.3g} % of .* 250 mm/s .*95 %: .*400 random .*seed 3", slow_line(found))


@pytest.mark.by_hand
def test_analyze_within_a_distance_reports_the_slow_share_too():
    found = analyze(open_robot("ur5e"), within=radians(5), starts=200)
    assert found.near.slow.share == pytest.approx(0.0745, abs=0.01)
    assert Analysis.from_dict(json.loads(json_text(found.to_dict()))).near.slow == found.near.slow
