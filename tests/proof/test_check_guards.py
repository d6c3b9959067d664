"""Guards of the checker, each with a case planted so that only the guard refuses it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import flint
import numpy as np
import pytest
from proof.tasks import covers_task
from reference import arms
from reference.coverings import covering

from rankdrop.cover import covering as covers_of
from rankdrop.cover.certificates import record_of, verify, write_certificate
from rankdrop.cover.setting import best_setting, middle_of
from rankdrop.proof import covers
from rankdrop.proof.arm import Arm, Region
from rankdrop.proof.boxes import bits
from rankdrop.proof.check import arm_of
from rankdrop.proof.existence import _Zero, verify_existence
from rankdrop.proof.record import Link, Unproven, Work, read_certificate
from rankdrop.proof.regions import ClaimCheck, CurvePath
from rankdrop.robot.model import Joint, JointKind, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

pytestmark = pytest.mark.usefixtures("precise")


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
    check = ClaimCheck(arm, claim, Work(10))
    plan: Any = SimpleNamespace(variables=(2, 3, 4, 5), lower=low, upper=high)
    with pytest.raises(Seen):
        covers._verify_all(check, plan, SimpleNamespace(free_boxes=1))  # type: ignore[arg-type]
    for a, b in zip(low, high, strict=True):
        assert flint.arb(b) - flint.arb(a) < 2 * flint.arb.pi()
        assert flint.arb(b) - flint.arb(a) + 2 * flint.arb(given[0]) > 2 * flint.arb.pi()


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
