"""The determinant in Bernstein form, by which coverings are proven again.

It is the determinant, its bounds hold and are reached, and what it loses to rounding is less than it says.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import count

import flint
import numpy as np
import pytest
from reference import arms
from reference import kinematics as oracle

from rankdrop.cover.certificates import covering_certificate, verify, write_certificate
from rankdrop.cover.covering import Covering, plan_of, write_covering
from rankdrop.cover.setting import middle_of
from rankdrop.errors import OptionError, ResultFileError
from rankdrop.families.reciprocal import draw_singular
from rankdrop.problem import Problem
from rankdrop.proof import covers, determinant
from rankdrop.proof.arm import BITS, Arm
from rankdrop.proof.boxes import BitTree, digest
from rankdrop.proof.determinant import Determinant, applies
from rankdrop.proof.record import Link, Unproven
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.units import in_units
from rankdrop.verbs.covering import cover

ROWS = [0, 1, 2, 3, 4, 5]
PLACES = [1, 2, 3, 4]
LOW, HIGH = (-3.2,) * 4, (-3.2 + 2 * np.pi,) * 4
SEAM = 1e-14


@cache
def robot_of(name: str):
    return open_robot(name) if name != "random" else arms.random_chain(np.random.default_rng(3), "rrrrrr")


def arm_of(name: str, link: int = 3) -> Arm:
    robot = robot_of(name)
    links = [Link("revolute", tuple(joint.screw.tolist()), j) for j, joint in enumerate(robot.joints)]
    return Arm(links, 6, link, [flint.arb(float(x)) for x in middle_of(robot)], flint.arb(1))


@cache
def found_for(name: str) -> Determinant:
    with flint.ctx.workprec(BITS):
        return Determinant(arm_of(name), ROWS, PLACES, LOW, HIGH, SEAM)


def values(name: str, q):
    robot = robot_of(name)
    return np.linalg.det(oracle.screws(robot, oracle.carried(robot, q)).swapaxes(-1, -2))


def weighed(name, level, cells, share):
    """Determinant times its weight at places −1 … 1 of boxes."""
    width = 2 * np.pi / 2**level
    delta = share * width / 2
    q = np.zeros((len(cells), 6))
    q[:, PLACES] = LOW[0] + (cells + 0.5) * width + delta
    weight = (1 + np.tan(delta / 2) ** 2) ** np.array([1, 2, 2, 1])
    return values(name, q) * weight.prod(axis=1)


@pytest.mark.parametrize("name", ["ur5", "puma560", "random"])
@pytest.mark.parametrize("level", [1, 3, 6])
def test_the_determinant_lies_within_its_bounds_and_reaches_them(name, level):
    made, rng = found_for(name), np.random.default_rng(level)
    cells = rng.integers(0, 2**level, (400, 4))
    with flint.ctx.workprec(BITS):
        low, high, lost = made.bounds([level] * 4, cells)
    share = rng.uniform(-1, 1, (400, 4))
    corners = rng.choice([-1.0, 1.0], (400, 4))
    samples = np.stack([weighed(name, level, cells, one) for one in (share, corners, np.sign(share) * 0.999)])
    scale = np.abs(values(name, rng.uniform(-np.pi, np.pi, (500, 6)))).max()
    assert (samples >= low - lost - 1e-12 * scale).all()
    assert (samples <= high + lost + 1e-12 * scale).all()
    if level == 6:  # the least and the largest coefficient stand at corners, or nearly
        every = np.array(np.meshgrid(*[[-1.0, 1.0]] * 4)).reshape(4, -1).T
        there = np.stack([weighed(name, level, cells, np.tile(one, (400, 1))) for one in every])
        reached = (there.max(axis=0) - there.min(axis=0)) / (high - low)
        assert reached.max() <= 1 + 1e-9
        assert np.quantile(reached, 0.5) > 0.9


@pytest.mark.parametrize("name", ["ur5", "random"])
def test_rounding_stays_below_what_is_said(name):
    """The coefficients in intervals of 90 bits against those in doubles, exact products of the same matrices."""
    made = found_for(name)
    level, cells = 5, np.random.default_rng(2).integers(0, 32, (20, 4))
    with flint.ctx.workprec(BITS):
        low, high, lost = made.bounds([level] * 4, cells)
        coefficients = determinant._coefficients(arm_of(name), ROWS, PLACES, [1, 2, 2, 1])
        worst = 0.0
        for row, cell in enumerate(cells):
            entries = coefficients
            for j, (degree, place) in enumerate(zip([1, 2, 2, 1], cell.tolist(), strict=True)):
                size = 2 * degree + 1
                centre = flint.arb(LOW[j]) + (flint.arb(HIGH[j]) - LOW[j]) * (2 * place + 1) / 2 ** (level + 1)
                form = determinant._bernstein(degree, (made._width(j, level) / 2).tan())
                matrix = form * determinant._shifted_waves(degree, centre)
                entries = (matrix * flint.arb_mat(size, len(entries) // size, entries)).transpose().entries()
            exact = [float(x.mid()) for x in entries]
            worst = max(worst, abs(min(exact) - low[row]), abs(max(exact) - high[row]))
        assert max(float(x.rad()) for x in entries) < 1e-3 * lost
    assert 0 < worst < lost
    assert lost < 1e-12 * np.abs(made._g).sum()


@pytest.mark.by_hand_at("puma560")
@pytest.mark.slow_at("puma560", "ur5")
@pytest.mark.parametrize("name", ["ur5", "puma560"])
def test_no_box_around_a_singular_configuration_is_free(name):
    """Boxes of five sizes that hold one of 1000 exact singular configurations, at whatever place."""
    made = found_for(name)
    robot = in_units(robot_of(name))
    q = draw_singular(Problem(robot, resolve_task(None, robot)), 1000, 1)[0][:, PLACES]
    with flint.ctx.workprec(BITS):
        for level in (3, 5, 7, 8):
            width = 2 * np.pi / 2**level
            cells = np.floor((np.mod(q - LOW[0], 2 * np.pi)) / width).astype(np.int64)
            assert not made.free([level] * 4, np.clip(cells, 0, 2**level - 1)).any()
        cells = np.random.default_rng(0).integers(0, 128, (5000, 4))
        assert made.free([7] * 4, cells).mean() > 0.9  # 94 % of the joint space are


def test_more_waves_than_looked_for_are_told(monkeypatch):
    monkeypatch.setattr(determinant, "_DEGREE", 1)
    with flint.ctx.workprec(BITS), pytest.raises(Unproven, match="no trigonometric polynomial"):
        Determinant(arm_of("puma560"), ROWS, PLACES, LOW, HIGH, SEAM)


def test_it_is_for_square_arms_of_turning_joints():
    arm = arm_of("ur5")
    assert applies(arm, ROWS, 6)
    assert not applies(arm, ROWS, 5)
    slide = [*arm.links[:5], Link("prismatic", (0.0, 0.0, 1.0, 0.0, 0.0, 0.0), 5)]
    assert not applies(Arm(slide, 6, 3, [flint.arb(0)] * 3, flint.arb(1)), ROWS, 6)
    led = [*arm.links[:5], Link("revolute", arm.links[5].screw, 5, 2.0)]
    assert not applies(Arm(led, 6, 3, [flint.arb(0)] * 3, flint.arb(1)), ROWS, 6)


@pytest.fixture(scope="module")
def ur5(tmp_path_factory):
    """A coarse covering of a UR5, and its certificate."""
    folder = tmp_path_factory.mktemp("boxes")
    robot = open_robot("ur5")
    found = cover(robot, width=0.2, out=folder / "ur5.cover", explain=False)
    record = covering_certificate(robot, found.covering.plan, found.sha256, "ur5.cover", found.task)
    return folder, write_certificate(record, folder / "ur5.json"), found


@pytest.fixture(autouse=True)
def _few_across(monkeypatch):
    monkeypatch.setattr(covers, "ACROSS", 5)


@pytest.mark.slow
def test_a_covering_of_six_joints_is_verified_whole(ur5):
    told = verify(ur5[1], open_robot("ur5"))
    assert told.holds, told.reason
    assert "by the determinant in Bernstein form" in told.how
    assert 1 <= told.enclosures < 10_000
    assert " chosen at random by " in told.how
    assert not told.how.split("; ")[1].startswith("0 of")


@pytest.mark.slow
def test_a_covering_of_six_joints_that_lost_a_box_does_not_hold(ur5, tmp_path):
    from dataclasses import replace

    covering = ur5[2].covering
    tree, plan = covering.tree, covering.plan
    last = tree.masks[-1].copy()
    place = len(last) // 3
    assert last[place] & (last[place] - 1)  # more than one
    last[place] &= last[place] - 1
    lost = replace(tree, masks=(*tree.masks[:-1], last), proven=tree.proven & last)
    write_covering(tmp_path / "ur5.cover", replace(covering, tree=lost))
    told = digest(plan, lost)
    record = covering_certificate(open_robot("ur5"), plan, told, "ur5.cover", ur5[2].task)
    found = verify(write_certificate(record, tmp_path / "c.json"), enclosures=3000)
    assert not found.holds
    assert "before every box was proven" in found.reason or "could not be proven free" in found.reason


@pytest.mark.slow
def test_what_the_determinant_leaves_is_left_to_enclosures(ur5, monkeypatch):
    """Boxes that it does not decide are not passed over."""
    monkeypatch.setattr(Determinant, "free", lambda self, levels, cells: np.arange(len(cells)) > 0)
    found = verify(ur5[1])
    assert found.holds
    assert " by enclosures; " in found.how
    monkeypatch.setattr(Determinant, "free", lambda self, levels, cells: np.zeros(len(cells), dtype=bool))
    assert not verify(ur5[1], enclosures=50).holds


@pytest.mark.slow
def test_a_journal_keeps_what_is_proven(ur5, tmp_path):
    journal, seen = tmp_path / "checked", []

    def stop(done, total):
        seen.append(done)
        if done > total // 2:
            raise KeyboardInterrupt

    found = verify(ur5[1], journal=journal, progress=stop)
    assert not found.complete
    assert not found.holds
    assert "interrupted" in found.reason
    assert str(journal) in found.reason
    half = seen[-1]
    assert int(journal.read_bytes().split(b"\n")[-2]) == half
    journal.write_bytes(journal.read_bytes() + b"99999")  # cut off
    seen.clear()
    resumed = verify(ur5[1], journal=journal, progress=lambda done, total: seen.append(done))
    assert resumed.holds
    assert seen[0] >= half
    count = int(journal.read_bytes().split(b"\n")[-2])
    assert f"{half:,} of them in an earlier run, as the journal says, {count - half:,} by the det" in resumed.how
    seen.clear()
    again = verify(ur5[1], journal=journal, progress=lambda done, total: seen.append(done))
    assert again.holds
    assert f"{count:,} of them in an earlier run, as the journal says, 0 by the determinant" in again.how
    assert not seen  # all are proven
    journal.write_bytes(journal.read_bytes() + b"%d\n" % (count + 1))
    with pytest.raises(ResultFileError, match="more boxes than the covering has"):
        verify(ur5[1], journal=journal)
    (tmp_path / "other").write_text("something else\n")
    with pytest.raises(ResultFileError, match="journal of another"):
        verify(ur5[1], journal=tmp_path / "other")
    with pytest.raises(OptionError, match="journal"):
        verify(ur5[1], journal=tmp_path / "third", sample=3)


def test_a_check_that_would_take_hours_says_so_first(tmp_path):
    robot = open_robot("planar3r")
    found = cover(robot, width=0.2, out=tmp_path / "a.cover", explain=False)
    record = covering_certificate(robot, found.covering.plan, found.sha256, "a.cover", found.task)
    place = write_certificate(record, tmp_path / "a.json")
    told = verify(place, enclosures=3)
    assert told.reason.startswith("not begun")
    assert "--all" in told.reason
    assert not told.enclosures
    journal = tmp_path / "checked"
    assert verify(place, enclosures=3, every=True, journal=journal).holds
    again = verify(place, enclosures=3, every=True, journal=journal)
    assert again.enclosures == 0
    assert "in an earlier run, as the journal says" in again.how


@pytest.mark.slow
def test_a_range_halved_forty_times_costs_no_table_of_its_parts(tmp_path, monkeypatch):
    """A covering of 700 bytes asked for tables of 2^40 matrices; deep boxes are proven by enclosures instead."""
    arm = from_dh([(0, "pi/2", 0, 0), (0, "-pi/2", 0, 0), (0, 0, 0.1, 0)], convention="standard", name="wrist")
    task, low, depth = resolve_task("orientation", arm), -np.pi - 0.1, 40
    plan = replace(plan_of(arm, 0.05, task), depth=(depth,), top=1, lower=(low,), upper=(low + 2 * np.pi,))
    shape, zeros = plan.shape, [Fraction((x - low) / (2 * np.pi)) for x in (-np.pi, 0.0)]
    cells = [sorted({int(zero * 2**level) for zero in zeros}) for level in range(depth + 1)]
    masks = tuple(
        np.array([sum(1 << (cell & 1) for cell in cells[level + 1] if cell >> 1 == one) for one in cells[level]],
                 shape.kind) for level in range(1, depth)
    )  # fmt: skip
    tree = BitTree(shape, np.ones(2, bool), np.ones(2, bool), masks, np.zeros(2, shape.kind))
    assert (tree.leaves, tree.free_boxes) == (2, 2 * (depth - 1))
    write_covering(tmp_path / "deep.cover", Covering(plan, tree, 0, 0))
    file = write_certificate(covering_certificate(arm, plan, digest(plan, tree), "deep.cover", task), tmp_path / "deep")
    made, calls = determinant._shifted_waves, count(1)

    def turned(*given):
        assert next(calls) < 100_000, "a table of all parts"
        return made(*given)

    monkeypatch.setattr(determinant, "_shifted_waves", turned)
    assert verify(file, arm).holds
