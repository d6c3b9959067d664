"""Guards of the checker, each with a case planted so that only the guard refuses it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import flint
import numpy as np
import pytest
from reference import arms
from reference.coverings import covering

from rankdrop.cover import covering as covers_of
from rankdrop.cover.certificates import (
    covering_certificate,
    existence_certificate,
    record_of,
    verify,
    write_certificate,
)
from rankdrop.cover.covering import write_covering
from rankdrop.cover.setting import best_setting, middle_of
from rankdrop.proof import covers
from rankdrop.proof.arm import BITS, Arm, Region
from rankdrop.proof.boxes import bits, digest
from rankdrop.proof.check import arm_of
from rankdrop.proof.existence import _Zero, verify_existence
from rankdrop.proof.record import Link, Unproven, Work, read_certificate
from rankdrop.proof.regions import Cell, Check, CurvePath
from rankdrop.robot.model import Joint, JointKind, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


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
    assert zero._krawczyk_inside(start, start, flint.arb_mat([[0]]), width) is inside


def test_a_box_next_to_a_singular_configuration_holds_none(tmp_path):
    """Krawczyk's test about a place 1.5 widths beside the zero of a real arm."""
    robot = open_robot("planar3r")
    claim = read_certificate(write_certificate(existence_certificate(robot, [0.3, 0.0, 0.2]), tmp_path / "e.json"))
    zero = _Zero(arm_of(claim), claim.entries["q"], [0, 1, 5])
    start = zero._start()
    _, slope = zero._equations(start)
    planes, width = zero._planes(slope), 1e-6
    assert zero._krawczyk_inside(start, start, planes, width)
    beside = [x + 1.5 * width * (place == 0) for place, x in enumerate(start)]
    assert not zero._krawczyk_inside(beside, start, planes, width)


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
    boxes = covers_of._Boxes(robot, None, covers_of.best_setting(robot, covers_task(robot)), found.plan, 1)
    cells = np.array([[0] * found.plan.shape.variables, [(1 << d) - 1 for d in found.plan.depth]], dtype=np.int32)
    q, half = boxes._centres_and_halves(cells, level)
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
    boxes = covers_of._Boxes(robot, task, covers_of.best_setting(robot, task), found.plan, 1)
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


@pytest.mark.parametrize(("short", "whole"), [(0.0, True), (1e-12, False), (1e-6, False), (1e-3, False)])
def test_a_turn_that_is_a_little_short_is_none(tmp_path, short, whole):
    """A false covering: its boxes are all truly free, and the singular θ2 = 0 lies in the gap of its range."""
    robot = open_robot("planar3r")
    low, high = short / 2, 2 * np.pi - short / 2
    joints = tuple(replace(joint, lower=low, upper=high) if j == 1 else joint for j, joint in enumerate(robot.joints))
    found = covering(replace(robot, joints=joints), 0.4, limits=True)
    plan = replace(found.plan, limits=False, turns=(True,))
    write_covering(tmp_path / "a.cover", replace(found, plan=plan))
    record = covering_certificate(robot, plan, digest(plan, found.tree), "a.cover", covers_task(robot))
    told = verify(write_certificate(record, tmp_path / "a.json"), every=True)
    assert plan.variables == (2,)
    assert told.holds == whole, told.reason
    assert whole or "said to be a turn, and is none" in told.reason


class Seen(Exception):
    """The determinant that a check makes was looked at."""


def test_the_check_of_a_covering_hands_the_seam_to_the_determinant(monkeypatch):
    """Boxes of a determinant made by the check itself reach around a whole turn, which one of doubles does not."""
    robot = arms.random_chain(np.random.default_rng(3), "rrrrrr")
    links = [Link("revolute", tuple(joint.screw.tolist()), j) for j, joint in enumerate(robot.joints)]
    arm = Arm(links, 6, 3, [flint.arb(float(x)) for x in middle_of(robot)], flint.arb(1))
    low = (-np.pi - np.pi / 8,) * 4
    high = tuple(x + 2 * np.pi for x in low)
    given: list[float] = []

    def spy(arm: Any, rows: Any, places: Any, lower: Any, upper: Any, wider: float) -> Any:
        given.append(wider)
        raise Seen

    monkeypatch.setattr(covers, "Determinant", spy)
    claim: Any = SimpleNamespace(tolerance=None, whole_rows=[0, 1, 2, 3, 4, 5], rank=6, record={})
    check = Check(arm, claim, Work(10))
    plan: Any = SimpleNamespace(variables=(2, 3, 4, 5), lower=low, upper=high)
    with pytest.raises(Seen):
        covers._verify_all(check, plan, SimpleNamespace(free_boxes=1))  # type: ignore[arg-type]
    for a, b in zip(low, high, strict=True):
        assert flint.arb(b) - flint.arb(a) < 2 * flint.arb.pi()
        assert flint.arb(b) - flint.arb(a) + 2 * flint.arb(given[0]) > 2 * flint.arb.pi()


def test_a_determinant_that_leaves_out_a_joint_that_decides_is_refused():
    """With it at 0 the others have a polynomial of their own, of which any box may be free."""
    robot = arms.random_chain(np.random.default_rng(3), "rrrrrr")
    links = [Link("revolute", tuple(joint.screw.tolist()), j) for j, joint in enumerate(robot.joints)]
    arm = Arm(links, 6, 3, [flint.arb(float(x)) for x in middle_of(robot)], flint.arb(1))
    assert arm.moving == [1, 2, 3, 4]
    for left in arm.moving:
        places = [j for j in arm.moving if j != left]
        with pytest.raises(Unproven, match="no trigonometric polynomial"):
            covers.Determinant(arm, [0, 1, 2, 3, 4, 5], places, (0.0,) * 3, (1.0,) * 3, 0.0)


@pytest.mark.parametrize("left", [0, 1, 2, 3])
def test_ranges_that_leave_out_a_joint_that_decides_are_refused(left):
    robot = arms.random_chain(np.random.default_rng(3), "rrrrrr")
    links = [Link("revolute", tuple(joint.screw.tolist()), j) for j, joint in enumerate(robot.joints)]
    variables = [j for place, j in enumerate((2, 3, 4, 5)) if place != left]
    entries = {"variables": variables, "lower": [-np.pi] * 3, "upper": [3.2] * 3, "turns": [True] * 3, "limits": False}
    claim: Any = SimpleNamespace(entries=entries, variables=6, links=links, limits=None)
    covers.check_ranges(claim, [j - 1 for j in variables])
    with pytest.raises(Unproven, match="leaves out a joint that decides"):
        covers.check_ranges(claim, [1, 2, 3, 4])


@pytest.mark.parametrize("link", range(7))
def test_every_joint_that_moves_a_column_decides(link):
    """The joints that a covering has to bound are those that change a column in the link's axes, and no others."""
    robot = arms.random_chain(np.random.default_rng(5), "rprrrr")
    links = [Link(str(joint.kind), tuple(joint.screw.tolist()), j) for j, joint in enumerate(robot.joints)]
    arm = Arm(links, 6, link, [flint.arb(float(x)) for x in middle_of(robot)], flint.arb(1))
    q, zero = np.full(6, 0.3), [flint.arb(0)] * 6

    def columns(at: Any) -> Any:
        return arm.jacobian(arm.screws_over([flint.arb(float(x)) for x in at], zero)[0])

    changing = [j for j in range(6) if np.abs(columns(q + 0.5 * np.eye(6)[j]) - columns(q)).max() > 1e-9]
    assert arm.moving == changing


def curve_of(points: list[list[float]], degree: int = 1) -> tuple[CurvePath, list[Region]]:
    """A path of a planar arm, and the regions that its proof encloses; each is said to be free."""
    robot = open_robot("planar2r")
    links = [Link("revolute", tuple(joint.screw.tolist()), j) for j, joint in enumerate(robot.joints)]
    arm = Arm(links, 2, 2, [flint.arb(0)] * 3, flint.arb(1))
    entries = {"points": np.array(points), "degree": degree}
    regions: list[Region] = []

    def keep(region: Region, *, near: bool = True) -> bool:
        regions.append(region)
        return True

    check: Any = SimpleNamespace(arm=arm, claim=SimpleNamespace(entries=entries, variables=2), keeps_rank=keep)
    return CurvePath(check), regions


def test_a_piece_of_a_path_is_as_wide_as_its_ends_are_uncertain():
    """Ends that are known to 0.01 are enclosed with it: a piece is the hull of all that they may be."""
    path, regions = curve_of([[0.1, 0.9], [0.3, 0.5]])
    path._piece([[flint.arb(x, 0.01) for x in row] for row in ([0.1, 0.9], [0.3, 0.5])], 0)
    for half in regions[0].half:
        assert half >= 0.01
    for centre, middle in zip(regions[0].centre, (0.2, 0.7), strict=True):
        assert abs(centre - middle) < 1e-9
        assert centre.is_exact()


def test_a_piece_of_a_path_is_as_wide_as_its_control_points_leave_the_chord():
    path, regions = curve_of([[0.1, 0.9], [0.3, 0.9], [0.4, 0.7], [0.4, 0.6]], 3)
    path.prove((0, 0.0), (0, 1.0))
    assert regions[0].half[0] >= 0.099999999  # of the first joint b_1 is 0.1 off the chord
    assert regions[0].half[1] >= 0.099999999


def test_boxes_around_a_piece_hold_all_that_is_nearer_than_the_distance():
    """Their sizes are doubles, rounded outwards: else the outermost configurations would be in none."""
    rng = np.random.default_rng(1)
    for _ in range(40):
        path, regions = curve_of([[0.1, 0.9], [0.3, 0.5]])
        centre, wide, scale = rng.uniform(-2, 2, 2), rng.uniform(0, 0.3, 2), rng.uniform(0.1, 2.0, 2)
        distance = float(rng.uniform(0.01, 0.5))
        assert path._surroundings(centre, wide, distance, scale, 1)
        for j in path._check.arm.moving:
            away = flint.arb(float(wide[j])) + flint.arb(distance) * flint.arb(float(scale[j]))
            half, off = regions[0].half[j], abs(regions[0].centre[j] - flint.arb(float(centre[j])))
            assert half >= away + off


def test_a_box_around_a_piece_holds_its_ends():
    """Its middle and its width are rounded: where the middle is 0 nothing else makes up for it."""
    rng = np.random.default_rng(2)
    seen: list[Any] = []
    for one in rng.uniform(0.1, 1.0, 60).tolist():
        low, high = -one, float(np.nextafter(one, 2.0))
        path, _ = curve_of([[low, low], [high, high]])
        path._surroundings = lambda centre, wide, *rest: seen.append((centre, wide)) or True  # type: ignore
        path.keeps_away(0, 10.0, np.ones(2))
        centre, wide = seen[-1]
        for j in range(2):
            assert flint.arb(float(centre[j])) + flint.arb(float(wide[j])) >= flint.arb(high)
            assert flint.arb(float(centre[j])) - flint.arb(float(wide[j])) <= flint.arb(low)


def test_a_rank_that_the_arm_never_has_is_not_lost(tmp_path):
    """The third axis goes through the point: the rank of its translation is 2 wherever the arm stands, and a wrench
    that does nothing exists by Krawczyk's test next to any configuration."""
    screws = ([0, 0, 0, 0, 0, 1.0], [0, -0.3, 0, 0, 0, 1.0], [0.4, -0.7, 0, 0, 0, 1.0])
    joints = tuple(Joint(name, JointKind.REVOLUTE, np.array(screw)) for name, screw in zip("abc", screws, strict=True))
    home = np.eye(4)
    home[:3, 3] = (0.7, 0.4, 0.2)
    robot = Robot("blind", joints, home)
    task = resolve_task("position", robot)
    setting = replace(best_setting(robot, task), rank=3)
    record = record_of(robot, task, "existence", setting, {"q": [0.3, 0.9, 0.2], "radius": 1e-6}, {})
    claim = read_certificate(write_certificate(record, tmp_path / "e.json"))
    assert claim.rank == 3
    with pytest.raises(Unproven, match="the rank is below 3 at"):
        verify_existence(arm_of(claim), claim)
    assert not verify(tmp_path / "e.json").holds
