"""Regions within the joint limits: against a flood fill, and where limits cut, leave out or double an aspect."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from math import inf, pi
from types import SimpleNamespace

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from scipy import ndimage

from rankdrop.algebra.polynomial import Polynomial
from rankdrop.algebra.ring import Ring
from rankdrop.aspects.arm import count_of_arm
from rankdrop.aspects.cells import Box
from rankdrop.aspects.count import AspectCount, Left, count_in_box
from rankdrop.aspects.limits import count_within_limits
from rankdrop.aspects.posture_paths import aspects_of
from rankdrop.cli import main
from rankdrop.exact.signs import SignedFactor
from rankdrop.kinematics import task_jacobian
from rankdrop.robot.dh import from_dh
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
    found = within(open_robot("crx10ial"))
    assert (found.left, found.shared) == (Left.JOINTS, (2, 3, 4, 5))
    assert "conditions that share joints depend on joints 2, 3, 4 and 5, and cells are" in within_limits_sentence(found)
    ring = Ring([1], [2])
    found = in_box(ring.c[1] + ring.q[2] ** 2, {2: (-1.0, 1.0)}, ring)
    assert found.left is Left.SLIDE
    assert "a slide stands in two conditions, in a higher degree" in within_limits_sentence(found)


def in_box(p: Polynomial, box: Box, ring: Ring) -> AspectCount:
    """The regions that the zeros of one function leave of a box."""
    factor = SignedFactor(ring, tuple(atom for atom, _ in ring.factor(p).atoms), str(p), periodic=True, sense=1)
    chain = SimpleNamespace(ring=ring, numbers={})
    return count_in_box(SimpleNamespace(factors=[factor], chain=chain, names=(None,)), box, None)  # type: ignore[arg-type]


@pytest.mark.parametrize(("limits", "number"), [((-0.2, 0.3), 4), ((-5.0, 5.0), 2), ((0.9, 5.0), 2), ((3.0, 5.0), 1)])
def test_a_slide_between_limits_leaves_the_shadow_of_an_interval(limits: tuple[float, float], number: int) -> None:
    """cos 2θ1 + (2 + s1) q: positive where it is at the upper limit, negative where it is at the lower one."""
    ring = Ring([1], [2])
    found = in_box(2 * ring.c[1] ** 2 - 1 + (2 + ring.s[1]) * ring.q[2], {2: limits}, ring)
    assert found.exact
    assert (found.at_least, found.peeled, found.cells) == (number, (2,), (1,))


def test_both_limits_of_a_slide_may_leave_a_region() -> None:
    """c1 q with q on both sides of 0 has four regions, which touch."""
    ring = Ring([1], [2])
    found = in_box(ring.c[1] * ring.q[2], {2: (-1.0, 2.0)}, ring)
    assert found.at_most is not None
    assert found.at_least <= 4 <= found.at_most
    assert not found.exact


def test_a_joint_without_limits_is_peeled_off_and_one_with_limits_is_not() -> None:
    """sin(θ1/2) sin(θ2 + π/2 − θ1/2): θ1 = 0 cuts a line in two, and a circle not."""
    ring = Ring([1, 2])
    p = (1 - ring.c[1]) * ring.s[2] + ring.s[1] * ring.c[2]
    assert in_box(p, {}, ring).at_most == 2
    line = in_box(p, {1: (-1.0, 1.0)}, ring)
    assert (line.peeled, line.cells) == ((2,), (1,))
    assert line.at_most is not None
    assert line.at_least <= 4 <= line.at_most
    assert in_box(p, {1: (-1.0, 1.0), 2: (-1.0, 1.0)}, ring).peeled == ()


@pytest.mark.parametrize("unit", [1, 1000])
@pytest.mark.parametrize("twists", [(-pi / 2, pi / 4), (pi / 4, 0.0)])
def test_a_slide_and_a_turn_have_the_regions_of_a_flood_fill(twists: tuple[float, float], unit: float) -> None:
    """A turn, a slide and a turn that move a point, lengths in metres and in millimetres."""
    rows = [{"d": 0.4 * unit, "a": 0.15 * unit, "alpha": twists[0], "lower": -2.0, "upper": 2.0},
            {"theta": 0.3, "a": 0.1 * unit, "alpha": twists[1], "kind": "prismatic", "lower": -0.5 * unit,
             "upper": 0.6 * unit},
            {"d": 0.2 * unit, "a": 0.3 * unit, "alpha": 0.0, "lower": -2.5, "upper": 2.9}]  # fmt: skip
    robot = from_dh(rows, convention="standard", task="position", name="arm")
    axes = (np.linspace(robot.lower[joint], robot.upper[joint], 120) for joint in (1, 2))
    q = np.zeros((120 * 120, 3))
    q[:, 1:] = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    _, signs = count_of_arm(robot, resolve_task(None, robot))
    assert signs is not None
    values = signs.values(q)
    determinant = np.linalg.det(task_jacobian(robot, q, resolve_task(None, robot)))
    assert len({bool(one) for one in (determinant * values.prod(axis=1) > 0)}) == 1  # its factors, up to a sign
    sides = product((1, -1), repeat=values.shape[1])
    flooded = sum(ndimage.label((values * side > 0).all(axis=1).reshape(120, 120))[1] for side in sides)
    found = count_within_limits(robot, signs)
    assert found.exact
    assert (found.at_least, found.peeled) == (flooded, (2,))


def test_aspects_with_limits_prints_and_writes_the_number(capsys: pytest.CaptureFixture[str]) -> None:
    found = aspects_of(open_robot("iiwa14"), limits=True)
    assert found.within is not None
    assert found.within.at_least == 2
    Draft202012Validator(load_schema("aspects")).validate(found.to_dict())
    assert found.to_dict()["within_limits"]["at_least"] == 2
    assert main.run(["aspects", "iiwa14", "--limits", "--quiet"]) == 0
    assert "Within the joint limits: 2 regions (proven)." in " ".join(capsys.readouterr().out.split())
    assert aspects_of(open_robot("iiwa14")).within is None
