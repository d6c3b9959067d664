"""Regions within the joint limits: against a flood fill, and where limits cut, leave out or double an aspect."""

from __future__ import annotations

from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from scipy import ndimage

from rankdrop.aspects.arm import count_of_arm
from rankdrop.aspects.cells import clusters
from rankdrop.aspects.count import AspectCount, Left
from rankdrop.aspects.limits import count_within_limits
from rankdrop.aspects.posture_paths import aspects_of
from rankdrop.cli import main
from rankdrop.kinematics import task_jacobian
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema
from rankdrop.task import resolve_task
from rankdrop.text.aspects import within_limits_sentence


def within(robot: Robot) -> AspectCount:
    _, signs = count_of_arm(robot, resolve_task(None, robot))
    assert signs is not None
    return count_within_limits(robot, signs)


def limited(name: str, *ends: tuple[float, float]) -> Robot:
    """An arm of the catalogue with other limits of its joints, in order."""
    robot = open_robot(name)
    pairs = zip(robot.joints, ends, strict=True)
    return replace(robot, joints=tuple(replace(one, lower=low, upper=high) for one, (low, high) in pairs))


ROUND = (-inf, inf)
ELBOWS = {
    "joints without limits": (ROUND, 2, True),
    "both elbows": ((-2.5, 2.5), 2, True),
    "one elbow only": ((0.1, 2.5), 1, True),
    "two turns: each elbow twice": ((-2 * pi, 2 * pi), 4, True),
    "one elbow cut in two by a full turn that begins on it": ((0.5, 0.5 + 2 * pi), 3, True),
    "a sliver beyond 180°": ((-2.5, pi + 1e-6), 2, False),
}


@pytest.mark.parametrize("case", ELBOWS)
def test_limits_cut_leave_out_and_double_an_aspect(case: str) -> None:
    ends, number, proven = ELBOWS[case]
    found = within(limited("planar2r", ROUND, ends))
    assert found.at_least == number
    assert found.proven is proven


@pytest.mark.slow
@pytest.mark.parametrize(("name", "number"), [("irb120", 10), ("puma560", 12)])
def test_regions_are_those_of_a_flood_fill(name: str, number: int) -> None:
    """det J = f(θ2, θ3) s5, and joint 5 passes 0 once within its limits: twice the regions in joints 2 and 3."""
    robot = open_robot(name)
    axes = (np.linspace(robot.lower[joint], robot.upper[joint], 160) for joint in (1, 2))
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    q = np.full((len(grid), 6), 0.7)
    q[:, 1:3] = grid
    values = np.linalg.det(task_jacobian(robot, q, resolve_task(None, robot))).reshape(160, 160)
    flooded = sum(ndimage.label(side)[1] for side in (values > 0, values < 0))
    found = within(robot)
    assert found.exact
    assert found.at_least == 2 * flooded == number


def test_what_is_not_counted_says_why() -> None:
    assert within(open_robot("crx10ial")).left is Left.JOINTS
    assert within(open_robot("stanford")).left is Left.SLIDE
    sentence = within_limits_sentence(within(open_robot("stanford")))
    assert sentence == "Within the joint limits nothing was counted: a condition depends on a slide."


def test_cells_at_the_two_ends_of_a_limited_joint_are_no_neighbours() -> None:
    mask = np.array([True, False, True])
    assert len(set(clusters(mask, (True,))[mask])) == 1
    assert len(set(clusters(mask, (False,))[mask])) == 2


def test_aspects_with_limits_prints_and_writes_the_number(capsys: pytest.CaptureFixture[str]) -> None:
    found = aspects_of(open_robot("iiwa14"), limits=True)
    assert found.within is not None
    assert found.within.at_least == 2
    Draft202012Validator(load_schema("aspects")).validate(found.to_dict())
    assert found.to_dict()["within_limits"]["at_least"] == 2
    assert main.run(["aspects", "iiwa14", "--limits", "--quiet"]) == 0
    assert "Within the joint limits: 2 regions (proven)." in " ".join(capsys.readouterr().out.split())
    assert aspects_of(open_robot("iiwa14")).within is None
