"""Guards of the checker, each with a case planted so that only the guard refuses it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import flint
import numpy as np
import pytest
from reference import arms
from reference.coverings import covering

from rankdrop.certify import covering as covers_of
from rankdrop.certify.certificates import existence_certificate, write_certificate
from rankdrop.certify.setting import middle_of
from rankdrop.proof import covers
from rankdrop.proof.arm import BITS, Arm
from rankdrop.proof.boxes import bits
from rankdrop.proof.check import arm_of
from rankdrop.proof.existence import _Zero
from rankdrop.proof.record import Link, read_certificate
from rankdrop.proof.regions import Cell
from rankdrop.robot.open import open_robot


@pytest.fixture(autouse=True)
def _precise():
    with flint.ctx.workprec(BITS):
        yield


class Linear(_Zero):
    """One equation x = away of one unknown: Krawczyk's operator maps every box around 0 to the point `away`."""

    def __init__(self, away: float) -> None:
        self._f, self._away = flint, away

    def _equations(self, x: list[Any]) -> tuple[Any, Any]:
        return flint.arb_mat([[x[0] - self._away]]), flint.arb_mat([[1]])


@pytest.mark.parametrize(("away", "inside"), [(0.0, True), (0.9, True), (1.0, False), (1.2, False), (-1.9, False)])
def test_a_zero_outside_the_box_is_none_in_it(away, inside):
    """The image has to lie in the inside of the box itself, not in one of twice the width."""
    width = 1e-10
    zero = Linear(away * width)
    start = [flint.arb(0)]
    assert zero._inside(start, start, flint.arb_mat([[0]]), width) is inside


def test_a_box_next_to_a_singular_configuration_holds_none(tmp_path):
    """Krawczyk's test about a place 1.5 widths beside the zero of a real arm."""
    robot = open_robot("planar3r")
    claim = read_certificate(write_certificate(existence_certificate(robot, [0.3, 0.0, 0.2]), tmp_path / "e.json"))
    zero = _Zero(arm_of(claim), claim.entries["q"], [0, 1, 5])
    start = zero._start()
    _, slope = zero._equations(start)
    planes, width = zero._planes(slope), 1e-6
    assert zero._inside(start, start, planes, width)
    beside = [x + 1.5 * width * (place == 0) for place, x in enumerate(start)]
    assert not zero._inside(beside, start, planes, width)


def region_of(lower: tuple[float, ...], upper: tuple[float, ...], cell: Cell) -> Any:
    """The region that the checker makes of a box."""
    plan: Any = SimpleNamespace(variables=tuple(range(1, len(lower) + 1)), lower=lower, upper=upper)
    return covers.region_of(plan, len(lower), cell)


def test_boxes_of_a_whole_turn_overlap_at_its_seam():
    """2π of doubles is shorter than 2π: the first and the last box reach across the gap, and neighbours overlap."""
    lower = -np.pi - np.pi / 8
    upper = lower + 2 * np.pi
    true_turn = 2 * flint.arb.pi()
    first, last, second = (region_of((lower,), (upper,), Cell((index,), (3,))) for index in (0, 7, 1))

    def ends(region: Any) -> tuple[Any, Any]:
        return region.centre[0] - region.half[0], region.centre[0] + region.half[0]

    assert flint.arb(upper) - flint.arb(lower) < true_turn  # the gap that the seam closes
    assert ends(last)[1] > ends(first)[0] + true_turn
    assert ends(first)[1] > ends(second)[0]


def test_boxes_of_the_determinant_overlap_at_the_seam_as_well():
    robot = arms.random_chain(np.random.default_rng(3), "rrrrrr")
    links = [Link("revolute", tuple(joint.screw.tolist()), j) for j, joint in enumerate(robot.joints)]
    arm = Arm(links, 6, 3, [flint.arb(float(x)) for x in middle_of(robot)], flint.arb(1))
    low = (-np.pi - np.pi / 8,) * 4
    high = tuple(x + 2 * np.pi for x in low)
    made = covers.Determinant(arm, [0, 1, 2, 3, 4, 5], [1, 2, 3, 4], low, high, covers._SEAM)
    for j in range(4):
        boxes = 8 * 2 * made._width(j, 3)
        assert boxes > 2 * flint.arb.pi()
        assert made._width(j, 3) > (flint.arb(high[j]) - flint.arb(low[j])) / 16


def test_a_box_is_enclosed_wider_than_its_rounded_centre_can_be_off():
    """Centres and widths of a covering are doubles: what they lose is added to the box before it is enclosed."""
    robot = open_robot("almarkhi4")
    found = covering(robot, 1.6)
    level = found.plan.shape.levels
    boxes = covers_of._Boxes(robot, None, covers_of.viewed(robot, covers_task(robot)), found.plan, 1)
    cells = np.array([[0] * found.plan.shape.variables, [(1 << d) - 1 for d in found.plan.depth]], dtype=np.int32)
    q, half = boxes._at(cells, level)
    for row, cell in enumerate(cells):
        for place, j in enumerate(found.plan.variables):
            low, high = flint.arb(found.plan.lower[place]), flint.arb(found.plan.upper[place])
            width = (high - low) / (1 << found.plan.depth[place])
            begin, end = low + int(cell[place]) * width, low + (int(cell[place]) + 1) * width
            centre, reach = flint.arb(float(q[row, j - 1])), flint.arb(float(half[row, j - 1]))
            assert centre - reach < begin
            assert centre + reach > end
            slack = 1e-15 * max(1.0, abs(found.plan.lower[place]))
            assert reach - width / 2 > slack  # the allowance itself, not luck of one rounding


def covers_task(robot: Any) -> Any:
    from rankdrop.task import resolve_task

    return resolve_task(None, robot)


def test_two_signs_need_more_than_rounding(monkeypatch):
    """A leaf is proven to hold a singularity by determinants beyond the rounding of their products, not by any sign."""
    robot = open_robot("planar3r")
    found = covering(robot, 0.4)
    task = covers_task(robot)
    boxes = covers_of._Boxes(robot, task, covers_of.viewed(robot, task), found.plan, 1)
    cells = found.plan.shape.children(*_last(found), found.plan.shape.levels)[0]
    assert boxes.proven(cells).any()
    sizes = iter(range(100))

    def tiny(robot: Any, at: Any, task: Any) -> Any:
        sign = 1 if next(sizes) % 2 else -1
        matrix = np.tile(np.ones((3, 3)), (len(at), 1, 1))
        matrix[:, 2, 2] += sign * 1e-14
        matrix[:, 1, 0] += 1e-3
        return matrix

    monkeypatch.setattr(covers_of, "task_jacobian", tiny)
    assert not boxes.proven(cells).any()


def _last(found: Any) -> tuple[Any, Any]:
    for level, cells, masks, _ in found.tree.walk():
        if level == found.plan.shape.levels and bits(masks, found.plan.shape.variables).any():
            return cells, masks
    raise AssertionError("no leaf is left")
