"""The number of aspects: against the literature, and planted cases; `test_flood_fill.py` has random arms."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

from rankdrop.algebra.polynomial import Polynomial
from rankdrop.algebra.ring import Ring
from rankdrop.aspects.cells import PartCount, Positive, count_parts
from rankdrop.aspects.count import AspectCount, Left, count_aspects
from rankdrop.aspects.posture_paths import CUSPIDAL, NOT_ASKED, NOT_FOUND, aspects_of
from rankdrop.aspects.waves import wave_of
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.signs import SignedFactor, signs_of
from rankdrop.kinematics import task_jacobian
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.task import resolve_task

H = np.pi / 2


def counted(robot: Robot) -> AspectCount:
    return count_aspects(signs_of(exact_chain(robot, lengths="numbers")))


def arm(rows: list[tuple[float, float, float]], task: str) -> Robot:
    table = [{"d": d, "a": a, "alpha": alpha} for d, a, alpha in rows]
    return from_dh(table, convention="standard", task=task, name="arm")


UR = ("ur3", "ur5", "ur10", "ur3e", "ur5e", "ur10e", "ur16e", "ur20", "ur30")


@pytest.mark.slow_at("ur3e", "ur10e", "ur16e", "ur20", "ur30")
@pytest.mark.parametrize("name", [*UR, "puma560", "e0509"])
def test_eight_aspects_one_for_each_posture(name: str) -> None:
    """As in the literature: shoulder, elbow and wrist."""
    found = counted(open_robot(name))
    assert found.exact
    assert (found.at_least, len(found.factors)) == (8, 3)
    assert found.signs_decide


@pytest.mark.parametrize("name", ["crx10ial", "crx10ia", "j2n6s300", "gen3_6dof"])
def test_arms_with_offset_wrists_have_two(name: str) -> None:
    found = counted(open_robot(name))
    assert found.exact
    assert found.at_least == 2
    assert found.signs_decide


@pytest.mark.by_hand
@pytest.mark.parametrize("name", robot_names())
def test_the_catalogue(name: str) -> None:
    robot = open_robot(name)
    if robot.n != 6:
        pytest.skip("not an arm of six joints")
    found = counted(robot)
    assert found.left is None
    assert found.at_least in (2, 8)
    assert found.at_most == found.at_least


RING = Ring([1, 2])
C1, S1, C2, S2 = RING.c[1], RING.s[1], RING.c[2], RING.s[2]


def positive(p: Polynomial, sign: int = 1) -> Positive:
    return Positive(wave_of(RING, p, {}, unit=1), sign)


@pytest.mark.parametrize(
    ("conditions", "number"),
    [
        ([positive(C1)], 1),
        ([positive(2 * C1**2 - 1)], 2),
        ([positive(C1 + C2 + RING.constant(1))], 1),
        ([positive(C1), positive(2 * S2 * C2)], 2),
        ([positive(C1), positive(10 * C1 + RING.constant(1), -1)], 0),
        ([positive(RING.constant(1))], 1),
        ([positive(2 * C1**2 - 1), positive(2 * C2**2 - 1)], 4),
    ],
)
def test_sets_with_a_known_number_of_parts(conditions: list[Positive], number: int) -> None:
    assert count_parts(conditions) == PartCount(number, number, proven=True)


def test_a_part_smaller_than_a_coarse_cell_is_not_missed() -> None:
    """A disc of radius 0.045 rad: no cell of the first grid is inside it."""
    small = positive(1000 * C1 + 1000 * C2 - RING.constant(1999))
    assert count_parts([small]) == PartCount(1, 1, proven=True)


def test_two_parts_that_touch_are_not_told_apart_and_that_is_said() -> None:
    found = count_parts([positive(C1 * C2)])
    assert found.at_least == 1
    assert found.at_most == 2
    assert not found.exact


def test_an_enclosure_holds_at_random_points(rng: np.random.Generator) -> None:
    p = 3 * S1 * C2 - 2 * C1**2 * S2 + C2 - RING.constant(2)
    wave = wave_of(RING, p, {}, unit=1)
    middle, radius = rng.uniform(-3, 3, (50, 2)), 0.2
    at = {1: middle[:, 0], 2: middle[:, 1]}
    values, slopes = wave.over(at, radius), wave.slopes_over(at, radius)
    for _ in range(20):
        a, b = (middle + rng.uniform(-radius, radius, middle.shape)).T
        here = 3 * np.sin(a) * np.cos(b) - 2 * np.cos(a) ** 2 * np.sin(b) + np.cos(b) - 2
        slope = 3 * np.cos(a) * np.cos(b) + 4 * np.cos(a) * np.sin(a) * np.sin(b)
        assert (values.low <= here).all()
        assert (here <= values.high).all()
        assert (slopes[1].low <= slope).all()
        assert (slope <= slopes[1].high).all()
    assert (values.high - values.low).max() < 6


def whole(ring: Ring, p: Polynomial) -> SignedFactor:
    """A polynomial as one factor, though it may fall apart."""
    return SignedFactor(ring, tuple(atom for atom, _ in ring.factor(p).atoms), str(p), periodic=True, sense=1)


def regions(*factors: Polynomial, ring: Ring = RING) -> AspectCount:
    """The regions that the zeros of these functions leave of the torus."""
    chain = SimpleNamespace(ring=ring, numbers={})
    signs = SimpleNamespace(factors=[whole(ring, p) for p in factors], chain=chain, names=(None,) * len(factors))
    return count_aspects(signs)  # type: ignore[arg-type]


HALVES = (1 - C1) * S2 + S1 * C2  # 2 sin(θ1/2) sin(θ2 + π/2 − θ1/2), one atom times another


def test_a_common_factor_that_cuts_a_circle_once_separates_nothing() -> None:
    """Joint 2 peeled off leaves θ1 ≠ 0, and joint 1 stands nowhere else."""
    found = regions(HALVES)
    assert found.exact
    assert (found.at_least, found.peeled, found.cells) == (2, (2,), ())


def test_a_common_factor_that_cuts_a_circle_twice_is_not_left_out() -> None:
    """s1 c2 has two parts of each sign: c2 is left, which is zero at two values of θ2."""
    found = regions(S1 * C2)
    assert found.cells == (2,)
    assert found.at_least <= 4 <= found.at_most
    assert not found.exact or found.at_least == 4


def test_a_common_factor_in_a_joint_that_another_factor_holds_is_not_left_out() -> None:
    """θ1 ≠ 0 and s1 + c1 ≠ 0 leave three arcs, on which the sign of the first factor is either."""
    found = regions(HALVES, S1 + C1)
    assert found.cells == (1,)
    assert found.at_least <= 6 <= found.at_most
    assert not found.exact or found.at_least == 6


def test_a_common_factor_that_is_part_of_another_factor_is_implied() -> None:
    found = regions(HALVES, S1)
    assert found.exact
    assert (found.at_least, found.cells) == (4, ())


def test_a_factor_in_more_than_one_angle_of_a_joint_is_not_peeled() -> None:
    found = regions(2 * C1**2 - 1 + RING.constant(Fraction(1, 2)) * C2)
    assert 1 not in found.peeled
    assert found.at_least <= found.at_most


def test_joints_that_are_left_are_said() -> None:
    ring = Ring([1, 2, 3, 4])
    double = [2 * ring.c[j] ** 2 - 1 for j in range(1, 5)]
    found = regions(sum(double, ring.zero) + ring.constant(1), ring=ring)
    assert found.left == Left.JOINTS
    assert found.at_most is None


def test_a_slide_that_stands_with_a_number_is_peeled_and_another_is_not() -> None:
    ring = Ring([1], [2])
    found = regions(ring.c[1] + 3 * ring.q[2], ring=ring)
    assert found.exact
    assert (found.at_least, found.peeled) == (2, (2,))
    assert regions(ring.one + ring.s[1] * ring.q[2] ** 2, ring=ring).left == Left.SLIDE


@pytest.mark.slow
def test_within_limits_the_number_of_aspects_decides_nothing() -> None:
    """Two solutions with equal signs prove a change of posture only where joints turn as they like."""
    q = [0.2, 0.9, 0.4, -0.6, 0.9, 0.0]
    free = replace(aspects_of(open_robot("crx10ia"), q=q, starts=200), change=None)
    assert free.verdict == CUSPIDAL
    assert free.shared is not None
    assert "lie in one of the 2 aspects" in free.sentence
    bound = replace(free, options=replace(free.options, limits=True))
    assert bound.shared is None
    assert bound.verdict == NOT_FOUND


@pytest.mark.parametrize(("name", "number"), [("pa10", 2), ("gen3", 1), ("canadarm2", 1), ("px150", 2)])
def test_other_numbers_of_joints_than_rows(name: str, number: int) -> None:
    """By the sets of codimension 1: the elbow of an S-R-S arm parts its configurations, and nothing those of others."""
    found = aspects_of(open_robot(name))
    assert found.count.exact
    assert found.count.at_least == number
    assert found.verdict == NOT_ASKED
    assert found.sentence
    assert f"{number} aspect" in next(found.sections()).title


def test_the_wall_of_an_arm_with_a_spherical_shoulder_is_its_elbow() -> None:
    """The PA-10 is singular wherever θ4 = 0, and at random configurations beside it nowhere."""
    robot = open_robot("pa10")
    rng = np.random.default_rng(0)
    q = rng.uniform(-3, 3, (2000, 7))
    straight, bent = q.copy(), q.copy()
    straight[:, 3] = 0.0
    bent[:, 3] = 0.5
    task = resolve_task(None, robot)
    rank = [np.linalg.matrix_rank(task_jacobian(robot, some, task), tol=1e-9) for some in (straight, bent)]
    assert (rank[0] == 5).all()
    assert (rank[1] == 6).all()


def test_what_was_not_counted_has_no_upper_bound() -> None:
    assert AspectCount(left=Left.WORK).at_most is None
    assert not AspectCount(left=Left.WORK).exact
