"""Exact conditions of arms whose joints follow others, against planted conditions and an independent Jacobian."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from reference import kinematics
from reference.arms import random_chain, standard_dh

pytest.importorskip("flint")

from rankdrop.errors import OptionError, RobotError
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.arm.structure import structure_of
from rankdrop.exact.decoupling import decouple, parting_of
from rankdrop.exact.method_reason import PartingKind
from rankdrop.exact.posture_changes import OPEN, decide_postures
from rankdrop.formula.equation import Equation, System
from rankdrop.results.conditions import Conditions
from rankdrop.robot.model import Array, Mimic, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import BODY, Task
from rankdrop.verbs.analyze import analyze
from rankdrop.verbs.conditions import conditions
from rankdrop.verbs.jacobian_in_frame import link_jacobian

HALF, EIGHTH = pi / 2, pi / 4
HALVES = range(-2, 3)
A1, A2, A3 = 0.5, 0.4, 0.3
PLANAR = standard_dh("planar", [(A1, 0, 0, 0), (A2, 0, 0, 0), (A3, 0, 0, 0)], "planar-position")
WRIST = [(0, EIGHTH, 0.4, 0), (0, -EIGHTH, 0, 0), (0, 0, 0.1, 0)]
"""A hollow wrist: three axes through one point, bent by 45° and back."""


def following(robot: Robot, follower: int, leader: int, multiplier: float, offset: float = 0.0) -> Robot:
    """The arm with one joint, numbered from 1, that follows another one."""
    joints = list(robot.joints)
    mimic = Mimic(joints[leader - 1].name, multiplier, offset)
    joints[follower - 1] = replace(joints[follower - 1], mimic=mimic)
    return replace(robot, joints=tuple(joints))


def hollow(before: list[tuple[float, ...]], task: str) -> Robot:
    """An arm with the hollow wrist, whose last joint turns back as far as its first one turns."""
    n = len(before) + 3
    return following(standard_dh("hollow", before + WRIST, task), n, n - 2, -1.0)


def bent_pair() -> Robot:
    """Three joints about one point, of which the first is taken back at a bend of 45°, and a turn across the last."""
    rows = [(0, EIGHTH, 0, 0), (0, -EIGHTH, 0, 0), (0, HALF, 0, 0), (0, 0, 0, 0)]
    return following(standard_dh("bent", rows, "orientation"), 3, 1, -1.0)


def behind_a_driven_joint() -> Robot:
    """A tool behind a joint that follows joint 1 about another direction."""
    rows = [(0.5, HALF, 0, 0), (0.4, 0, 0, 0), (0.2, 0, 0, 0), (0.3, 0, 0, 0)]
    return following(standard_dh("driven", rows, "position"), 3, 1, 1.0)


def sliding(length: float = 1.0) -> Robot:
    """A turn, a slide, a turn, and a slide that follows at half the rate; lengths in a unit of so many to the metre."""
    rows = [(0, HALF, 0, HALF), (0, -HALF, 0.2 * length, 0, 1), (0, HALF, 0, 0), (0, 0, 0.1 * length, 0, 1)]
    return following(standard_dh("sliding", rows, "planar-position"), 4, 2, 0.5, 0.05 * length)


def determinants(robot: Robot, q: Array, rows: tuple[int, ...]) -> Array:
    """(k,) det J of a square task Jacobian at q (k, n), not by the product's core."""
    return np.linalg.det(kinematics.jacobian(robot, q)[:, list(rows)])


def singular(robot: Robot, rows: tuple[int, ...]) -> Array:
    """(k, n) zeros of det J on random lines, by bisection, in all turns after which the arm is the same."""
    rng = np.random.default_rng(1)
    q, way = rng.uniform(-3, 3, (100, robot.n)) * np.maximum(robot.turns, 1), rng.normal(size=(100, robot.n))
    start, end = determinants(robot, q, rows), determinants(robot, q + way, rows)
    q, way, start = (x[start * end < 0] for x in (q, way, start))
    low, high = np.zeros(len(q)), np.ones(len(q))
    for _ in range(50):
        middle = (low + high) / 2
        same = start * determinants(robot, q + middle[:, None] * way, rows) > 0
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    assert len(q) > 10
    return q + low[:, None] * way


def assert_both_ways(robot: Robot, found: Conditions) -> None:
    """The conditions hold at zeros of det J, at no random configuration, and det J is zero where they hold."""
    assert found.verified
    assert found.complete
    systems = [System(family.equations) for family in found.families]
    zeros = singular(robot, found.task.rows)
    assert np.min([np.abs(one.values(zeros)).max(axis=1) for one in systems], axis=0).max() < 1e-9
    rng = np.random.default_rng(2)
    for family, system in zip(found.families, systems, strict=True):
        ends, good = system.solve(rng.uniform(-1, 1, (20, robot.n)), along=np.eye(robot.n), iterations=60)
        assert good.any(), family.id
        for q in ends[good]:
            sigma = np.linalg.svd(kinematics.jacobian(robot, q)[list(found.task.rows)], compute_uv=False)
            assert sigma[robot.n - family.corank] < 1e-7
    anywhere = rng.uniform(-3, 3, (200, robot.n))
    assert np.min([np.abs(one.values(anywhere)).max(axis=1) for one in systems]) > 1e-9


@pytest.mark.parametrize(("m", "b"), [(1, 0.0), (-1, 0.0), (2, 0.0), (-3, HALF), (-1, EIGHTH), (1, pi / 12)])
def test_planar_arm_with_a_following_joint(m: int, b: float) -> None:
    """det J = −½ ∂|p|²/∂q2, p the tip: a1 a2 sin q2 + (1 + m) a1 a3 sin((1 + m) q2 + b) + m a2 a3 sin(m q2 + b)."""
    robot = following(PLANAR, 3, 2, m, b)
    found = conditions(robot, points=100)
    assert_both_ways(robot, found)
    q2 = np.linspace(-pi, pi, 20001)
    planted = (
        A1 * A2 * np.sin(q2)
        + (1 + m) * A1 * A3 * np.sin((1 + m) * q2 + b)
        + m * A2 * A3 * np.sin(m * q2 + b)
    )
    changes = int(np.sum(planted[1:] * planted[:-1] < 0))
    q = np.stack([np.zeros_like(q2), q2], axis=1)
    values = [System(family.equations).values(q)[:, 0] for family in found.families]
    product = np.prod(values, axis=0)
    assert int(np.sum(product[1:] * product[:-1] < 0)) == changes
    largest = np.argmax(np.abs(planted))
    assert np.abs(product / product[largest] - planted / planted[largest]).max() < 1e-9


def test_opposite_joint_leaves_the_elbow() -> None:
    """a3 keeps its direction while q2 turns: a1 a2 sin q2 = m a2 a3 sin(m q2) has the zeros of sin q2 only."""
    found = conditions(following(PLANAR, 3, 2, -1.0), points=100)
    assert [family.texts for family in found.families] == [("θ2 = 0 or π",)]


def test_bent_pair_turns_nothing_where_it_is_straight() -> None:
    robot = bent_pair()
    found = conditions(robot, points=100)
    assert_both_ways(robot, found)
    assert ("θ2 = 0",) in [family.texts for family in found.families]  # axes 1 and 3 are one, and the turns cancel


@pytest.mark.slow
def test_arm_with_a_hollow_wrist() -> None:
    robot = hollow([(0, HALF, 0.4, 0), (0.5, 0, 0, 0), (0, HALF, 0, 0)], "pose")
    found = conditions(robot)
    assert found.verified
    assert found.generic_rank == 5
    pinned = next(family for family in found.families if family.texts == ("θ5 = 0",))
    assert pinned.name == "joint 4 moves nothing"
    column = kinematics.jacobian(robot, [0.3, 0.4, -0.8, 1.1, 0.0])[:, 3]
    assert np.abs(column).max() < 1e-12


def test_tool_behind_a_driven_joint() -> None:
    robot = behind_a_driven_joint()
    assert_both_ways(robot, conditions(robot, points=100, coranks=1))


@pytest.mark.parametrize("length", [1.0, 1000.0])
def test_slide_that_follows_at_half_the_rate(length: float) -> None:
    robot = sliding(length)
    found = conditions(robot, points=100)
    assert found.verified
    chain = exact_chain(robot)
    for q in np.random.default_rng(0).uniform(-1, 1, (3, robot.n)) * [1, length, 1]:
        checks = link_jacobian(robot, 2, q=q, symbolic=True).checks
        assert all(check.holds for check in checks)
    assert chain.sections[3].multiplier == 0.5
    assert float(chain.sections[3].d) == pytest.approx(0.05 * length)  # the offset of the mimic relation


ODD = Task("vx vz", (0, 2), BODY)
MIXED = Task("vy wz", (1, 5))


@pytest.mark.parametrize(
    ("kinds", "task"),
    [*(("rmrpmr", task) for task in (ODD, MIXED, "position", "orientation")), ("mrrr", MIXED), ("mrprrrrr", "pose")],
)
def test_columns_span_the_rows_of_the_numeric_jacobian(kinds: str, task: str | Task) -> None:
    """Both matrices have one null space at random configurations, of random axes and offsets."""
    robot = random_chain(np.random.default_rng(5), kinds)
    for number, m in zip((j for j, kind in enumerate(kinds, 1) if kind == "m"), (-2.0, 1.0), strict=False):
        leader = next(i for i, kind in enumerate(kinds, 1) if kind != "m")
        robot = following(robot, number, leader, m, 0.7)
    chain = exact_chain(robot, task)
    assert (chain.n, chain.links) == (robot.n, len(kinds))
    assert chain.task.m < chain.n  # else any row space is the whole one
    for q in np.random.default_rng(6).uniform(-pi, pi, (2, robot.n)):
        exact, numeric = _at(robot, task, q), kinematics.jacobian(robot, q, chain.task.frame)[list(chain.task.rows)]
        both = np.vstack([exact / np.abs(exact).max(), numeric / np.abs(numeric).max()])
        ranks = {np.linalg.matrix_rank(matrix, tol=1e-6) for matrix in (exact, numeric, both)}
        assert len(ranks) == 1


def _at(robot: Robot, task: str | Task, q: Array) -> Array:
    """(m, n) the exact columns at a configuration."""
    chain = exact_chain(robot, task)
    theta, values = q + chain.shifts, dict(chain.numbers)
    values |= {f"c{j}": cos(theta[j - 1]) for j in chain.ring.revolute}
    values |= {f"s{j}": sin(theta[j - 1]) for j in chain.ring.revolute}
    values |= {f"q{j}": theta[j - 1] for j in chain.ring.prismatic}
    names = chain.ring.trig.names()

    def value(p) -> float:
        terms = ((int(c.p) / int(c.q), powers) for powers, c in p.terms())
        return sum(c * np.prod([values[x] ** int(e) for x, e in zip(names, es, strict=True)]) for c, es in terms)

    return np.array([[value(x) for x in column] for column in chain.columns]).T


def test_jacobian_of_every_link_frame() -> None:
    robot = behind_a_driven_joint()
    for link in range(1, 5):
        found = link_jacobian(robot, link, q=[0.3, -0.4, 0.9], symbolic=True)
        assert all(check.holds for check in found.checks)
    with pytest.raises(OptionError, match="no such link"):
        link_jacobian(robot, 5, symbolic=True)


def test_numeric_and_exact_families_agree() -> None:
    found = analyze(following(PLANAR, 3, 2, -1.0, EIGHTH), exact="on", starts=300)
    assert found.exact is not None
    assert found.exact.agrees


def test_methods_that_need_one_screw_for_each_column_are_left_out() -> None:
    robot = bent_pair()
    chain = exact_chain(robot)
    assert decouple(chain) is None
    assert parting_of(chain).kind is PartingKind.COUPLED
    assert structure_of(chain).points == ()
    assert decide_postures(chain).kind == OPEN
    found = conditions(robot, points=100)
    assert (found.method, found.reason.parting) == ("determinant", parting_of(chain))
    assert any("column 1 of the Jacobian contains −1 times the screw" in str(remark) for remark in found.remarks)
    for method in ("suppression", "decoupling"):
        with pytest.raises(OptionError, match=r"joints (that )?follow others"):
            conditions(robot, method=method)


URDF = """<robot name="geared">
  <link name="base"/><link name="l1"/><link name="l2"/><link name="l3"/><link name="l4"/><link name="tool"/>
  <joint name="j1" type="revolute"><parent link="base"/><child link="l1"/><origin xyz="0 0 0.4"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="j2" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="0.1 0 0"/><axis xyz="0 -1 0"/>
    <limit lower="{lower}" upper="{upper}" effort="1" velocity="1"/></joint>
  <joint name="j3" type="revolute"><parent link="l2"/><child link="l3"/><origin xyz="0.5 0 0"/><axis xyz="0 -1 0"/>
    <limit lower="-9" upper="9" effort="1" velocity="1"/><mimic joint="j2" multiplier="{multiplier}"/></joint>
  <joint name="j4" type="revolute"><parent link="l3"/><child link="l4"/><origin xyz="0.3 0 0"/><axis xyz="0 -1 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="t" type="fixed"><parent link="l4"/><child link="tool"/><origin xyz="0.2 0 0"/></joint>
</robot>"""


def geared(folder: Path, multiplier: str, turns: float = 4.0) -> Robot:
    """A URDF arm of three variables that point the tool, joint 3 following joint 2; limits of ±turns half turns."""
    path = folder / "geared.urdf"
    path.write_text(URDF.format(multiplier=multiplier, lower=-turns * pi, upper=turns * pi))
    return replace(open_robot(str(path)), task="position")


@pytest.mark.slow
@pytest.mark.parametrize(("multiplier", "turns", "angle"), [("-0.5", 2, "θ2/2"), ("0.666666666666667", 3, "θ2/3")])
def test_fraction_of_a_leader_s_angle(tmp_path: Path, multiplier: str, turns: int, angle: str) -> None:
    """Families against zeros of det J of an independent Jacobian, over all turns after which the arm is the same."""
    robot = geared(tmp_path, multiplier)
    assert robot.turns.tolist() == [1, turns, 1]
    found = conditions(robot, points=100, coranks=1)
    assert_both_ways(robot, found)
    assert any(angle in text for family in found.families for text in family.texts)
    for family in found.families:
        later = np.add(family.witness, [0.0, 2 * pi * turns, 0.0])  # the arm is the same there
        assert np.abs(System(family.equations).values(later[None])).max() < 1e-9
        sigma = np.linalg.svd(kinematics.jacobian(robot, family.witness)[:3], compute_uv=False)
        assert sigma[-1] < 1e-9
        assert [Equation.from_dict(one.to_dict()) for one in family.equations] == [*family.equations]


def test_values_of_a_fraction_are_those_of_all_turns_inside_the_limits() -> None:
    """θ3 = −θ2/2 bends the planar arm back at θ2 = 2πk, whichever k: sin(θ2/2) = 0."""
    for turns, expected in ((0.9, [0.0, 2 * pi]), (2.0, [0.0, 2 * pi, -2 * pi]), (5.0, [2 * pi * k for k in HALVES])):
        joints = list(following(PLANAR, 3, 2, -0.5).joints)
        joints[1] = replace(joints[1], lower=-turns * pi, upper=turns * pi)
        robot = replace(PLANAR, joints=tuple(joints))
        (pinned,) = [pin for family in conditions(robot, points=30).families for pin in family.pinned]
        assert sorted(pinned.values) == pytest.approx(sorted(expected))


@pytest.mark.slow
def test_offsets_of_a_joint_that_others_follow_by_a_third() -> None:
    """θ2 = q2 + 0.3, by its place in the file: conditions, values, flags and code are all in q2."""
    turned = standard_dh("turned", [(A1, 0, 0, 0), (A2, 0, 0, 0.3), (A3, 0, 0, 0)], "planar-position")
    robot = following(turned, 3, 2, 2 / 3, -0.2)
    found = conditions(robot, points=50)
    assert_both_ways(robot, found)
    assert found.shifts == (0.0, pytest.approx(0.3))
    names: dict[str, Any] = {}
    exec(found.code("python"), names)  # as a user would
    zeros = singular(robot, found.task.rows)
    values = np.abs([function(zeros)[:, 0] for function in names["FAMILIES"].values()])
    sizes = np.max([np.abs(function(zeros + 0.3)).max() for function in names["FAMILIES"].values()])
    assert values.min(axis=0).max() < 1e-10 * sizes  # twists of the phases are exact to 1e-12
    (flag,) = found.flags([0.0, 0.4]).flags
    det = determinants(robot, np.array([[0.0, 0.4]]), found.task.rows)[0]
    assert (flag.sign or 0) * det > 0


@pytest.mark.slow
def test_half_an_angle_beside_a_sampled_analysis_and_a_condition_by_hand() -> None:
    """Without limits the search goes through both turns of joint 2; a condition may be written in its own angle."""
    robot = following(PLANAR, 3, 2, -0.5)
    found = analyze(robot, exact="on", starts=300, limits=False)
    assert found.exact is not None
    assert found.exact.agrees
    derived = conditions(robot, points=30)
    assert derived.test("sin(q2/2) * (4*a1*a2*cos(q2/2) + a1*a3 + a2*a3)").verdict == "exact"
    assert derived.test("sin(q2)").verdict != "exact"
    code = derived.code("c")
    assert "gradient[0][1] = 0.5*cos(q[1]/2.0)" in code
    assert "remainder(q[1] - (6.283185307179586), 12.566370614359172)" in code


def test_multipliers_without_small_parts_are_refused() -> None:
    for m in (13.0, 0.3001, 7.5, 1 / 13):
        with pytest.raises(RobotError, match="whole, or a fraction of small numbers"):
            exact_chain(following(PLANAR, 3, 2, m), parts=True)
    fifth_and_seventh = following(standard_dh("many", [(A1, 0, 0, 0)] * 4, "planar-position"), 3, 1, 0.2)
    with pytest.raises(RobotError, match="the common denominator of all joints that follow"):
        exact_chain(following(fifth_and_seventh, 4, 1, 1 / 7), parts=True)
    with pytest.raises(RobotError, match="`conditions` and `analyze` take fractions"):
        link_jacobian(following(PLANAR, 3, 2, 0.5), 1)


def test_ratios_of_file_numbers_count_as_whole() -> None:
    assert exact_chain(following(PLANAR, 3, 2, -0.3 / 0.1)).sections[2].multiplier == -3


def test_kinds_that_do_not_go_together_are_refused() -> None:
    with pytest.raises(RobotError, match="where a slide follows a turning joint"):
        exact_chain(following(sliding(), 4, 1, 1.0))
    with pytest.raises(RobotError, match="helical"):
        exact_chain(random_chain(np.random.default_rng(0), "rhr"))
