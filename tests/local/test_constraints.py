"""What is lost, as a constraint on the motions that remain: every motion that the joints can make obeys it."""

from __future__ import annotations

import re

import numpy as np
import pytest
from known.arms import KINDS

from rankdrop.errors import OptionError, RobotError
from rankdrop.kinematics import jacobian, pose
from rankdrop.local.directions import constraint, in_short
from rankdrop.local.rates import joint_rates
from rankdrop.results.analysis import robot_from_dict, robot_to_dict
from rankdrop.results.known import shipped
from rankdrop.robot.model import with_tool
from rankdrop.robot.open import open_robot
from rankdrop.robot.urdf import from_urdf
from rankdrop.task import TIP, Frame
from rankdrop.text import lost_text
from rankdrop.units import scale_lengths
from rankdrop.verbs.explain import explain

TOOL = ((0.03, -0.05, 0.12), (0.3, -0.4, 0.5))
TERM = re.compile(r"([−+]?) ?(?:([\d.e−]+) )?(?:(m|rad/m)·)?([vω])([xyz])")


def value(text: str, twist: np.ndarray) -> float:
    """The left side of a constraint as it is printed, at a twist."""
    left = text.removesuffix(" = 0")
    assert re.sub(TERM, "", left).strip() == ""
    total = 0.0
    for sign, number, _, kind, axis in TERM.findall(left):
        size = float(number.replace("−", "-")) if number else 1.0
        total += (-size if sign == "−" else size) * twist["xyz".index(axis) + 3 * (kind == "ω")]
    return total


def twists(robot, q, frame, rng):
    """Feasible twists in a frame, of random joint rates; each of length one."""
    made = rng.normal(size=(40, robot.n)) @ jacobian(robot, q, frame).T
    return made / np.linalg.norm(made, axis=1, keepdims=True)


def places(name, most=3):
    """Witnesses of an arm's families, of several coranks."""
    families = shipped(name).families
    return [np.array(one.witness) for one in families[:: max(1, len(families) // most)]][:most]


@pytest.mark.parametrize("name", ["ur5e", "puma560", "panda", "scara"])
@pytest.mark.parametrize("tool", [None, TOOL])
def test_motions_that_the_joints_make_obey_what_is_told_in_every_frame(name, tool):
    robot = open_robot(name) if tool is None else with_tool(open_robot(name), *tool)
    rng = np.random.default_rng(0)
    for q in places(name):
        found = explain(robot, q, "pose" if tool is None else None, evaluations=0)
        assert found.rank.corank
        assert set(found.lost.seen) >= {"base", "tool"}
        for name, seen in found.lost.seen.items():
            frame = found.lost.framed.frame if name == "link" else Frame(TIP if name == "tool" else 0, TIP)
            for twist in twists(robot, q, frame, rng):
                for direction, text in zip(seen.directions, lost_text(robot, seen)["constraints"], strict=True):
                    assert abs(direction @ twist) < 1e-9
                    assert abs(value(text, twist)) < 2e-2  # three digits of six numbers


def test_finite_motion_of_the_tool_point_obeys_it_to_first_order():
    robot, q = with_tool(open_robot("ur5e"), *TOOL), np.radians([0, -60, 0, 40, 50, 0])
    (base,) = explain(robot, q, frame="base", evaluations=0).lost.seen.values()
    here, rng = pose(robot, q), np.random.default_rng(3)
    for rates in rng.normal(size=(20, robot.n)):
        there = pose(robot, q + 1e-6 * rates)
        turn = (there[:3, :3] @ here[:3, :3].T - here[:3, :3] @ there[:3, :3].T) / 2
        moved = np.array([*(there - here)[:3, 3], turn[2, 1], turn[0, 2], turn[1, 0]]) / 1e-6
        assert abs(base.directions[0] @ moved) < 1e-4 * np.linalg.norm(moved)


def test_a_plain_translation_along_what_is_called_lost_is_almost_all_lost():
    """UR5e at (0, −60, 0, 40, 50, 0)°: the sentence says that the plain translation is lost, and it is, but for 2 %."""
    robot, q = open_robot("ur5e"), np.radians([0, -60, 0, 40, 50, 0])
    (base,) = explain(robot, q, frame="base", evaluations=0).lost.seen.values()
    assert lost_text(robot, base)["short"][0].startswith("nearly no motion along")
    along = np.concatenate([base.directions[0][:3] / np.linalg.norm(base.directions[0][:3]), np.zeros(3)])
    columns = jacobian(robot, q)
    left = columns @ np.linalg.lstsq(columns, along, rcond=1e-9)[0]
    assert left @ along < 0.03
    assert not in_short([0.7, 0, 0, 0.7, 0, 0])


@pytest.mark.parametrize("name", KINDS[::4])
def test_what_remains_of_each_axis_is_the_nearest_motion_and_can_be_made(name):
    robot = open_robot(name)
    for q in places(name, 2):
        found = explain(robot, q, evaluations=0)
        rows = list(found.task.rows)
        matrix = jacobian(robot, q, found.task.frame)[rows]
        reached = np.linalg.svd(matrix)[0][:, : found.rank.rank]  # 1 m counts as 1 rad
        for axis, share, left in zip(np.eye(len(rows)), found.rates.lost_shares, found.rates.remaining, strict=True):
            nearest = reached @ (reached.T @ axis)
            assert share == pytest.approx(1 - nearest @ axis, abs=1e-9)
            if left is None:
                assert share == pytest.approx(1.0, abs=1e-9)
                continue
            assert np.array(left.direction)[rows] == pytest.approx(nearest / (1 - share), abs=1e-6)
            made = matrix @ np.array(left.joint_rates)
            assert made == pytest.approx(np.array(left.direction)[rows], abs=1e-7)
            assert made @ axis == pytest.approx(1.0, abs=1e-7)


def test_the_axes_of_what_motion_costs_are_those_asked_for():
    robot, q = open_robot("ur5e"), np.radians([0, -60, 0, 40, 50, 0])
    turn = pose(robot, q)[:3, :3]
    base, tool = (explain(robot, q, frame=frame, evaluations=0) for frame in ("base", "tool"))
    inside = tool.lost.directions[0]  # in the task's frame, the base, whatever the axes of the sentences
    assert base.lost.directions[0] == pytest.approx(inside)
    expected = np.concatenate([turn.T @ inside[:3], turn.T @ inside[3:]]) ** 2
    assert tool.rates.lost_shares == pytest.approx(expected, abs=1e-9)
    link = explain(robot, q, frame="link", evaluations=0)
    assert link.rates.lost_shares == pytest.approx(link.lost.framed.directions[0] ** 2, abs=1e-9)


def test_a_tool_moves_no_singularity_and_families_keep_their_names():
    plain = open_robot("puma560")
    robot = with_tool(plain, *TOOL)
    for q in places("puma560"):
        one, other = (explain(arm, q, evaluations=0) for arm in (plain, robot))
        assert (one.verdict, one.rank.corank) == (other.verdict, other.rank.corank)
        assert [met.family.name for met in one.met] == [met.family.name for met in other.met]
        assert other.source == "catalogue"


def test_it_is_the_same_in_millimetres():
    plain, q = open_robot("ur5e"), np.radians([0, -60, 0, 40, 50, 0])
    small = scale_lengths(plain, 3)
    one, other = (explain(arm, q, frame="base", evaluations=0) for arm in (plain, small))
    assert other.rates.lost_shares == pytest.approx(one.rates.lost_shares, abs=1e-9)
    assert constraint([0, 1, 0, 0, 0, 0.1]) == "vy + 0.1 m·ωz = 0"
    assert constraint([0, 1, 0, 0, 0, 0.1], 1000.0) == "vy + 100 m·ωz = 0"
    twist = jacobian(small, q) @ np.ones(6)
    first = lost_text(other.robot, next(iter(other.lost.seen.values())))["constraints"][0]
    assert abs(value(first, twist)) < 2e-2 * np.linalg.norm(twist)


@pytest.mark.parametrize("wrong", [(0, 0), (0, np.nan, 1), "abc"])
def test_a_tool_is_three_numbers(wrong):
    with pytest.raises((RobotError, ValueError)):
        with_tool(open_robot("planar2r"), wrong)


def test_other_axes_are_refused():
    with pytest.raises(OptionError, match="frame: this value is not allowed; got 'world'; allowed: base, tool, link"):
        explain(open_robot("ur5e"), np.zeros(6), frame="world")


def test_rates_of_a_regular_configuration_lose_nothing():
    rates = joint_rates(open_robot("ur5e"), np.radians([0, -60, 40, 40, 50, 0]))
    assert set(rates.lost_shares) == {0.0}
    assert [one.direction for one in rates.remaining] == [one.direction for one in rates.axes]


def test_a_link_is_called_as_its_file_calls_it():
    text = """<robot name="r"><link name="a"/><link name="upper"/><link name="forearm"/><link name="c"/>
    <joint name="i" type="continuous"><parent link="a"/><child link="upper"/><axis xyz="0 0 1"/></joint>
    <joint name="j" type="continuous"><parent link="upper"/><child link="forearm"/><origin xyz="1 0 0"/>
    <axis xyz="0 0 1"/></joint>
    <joint name="k" type="fixed"><parent link="forearm"/><child link="c"/><origin xyz="1 0 0" rpy="0 0 0.6"/></joint>
    </robot>"""
    arm = from_urdf(text)
    assert [joint.link for joint in arm.joints] == ["upper", "forearm"]
    found = explain(arm, [0.4, 0.0], "planar-position", evaluations=0)
    axes = [lost_text(found.robot, one)["axes"] for one in found.lost.seen.values()]
    assert axes == ["base axes", "tool axes", "axes of link 2 (forearm)"]
    assert lost_text(found.robot, found.lost.seen["link"])["constraints"] == ["vx = 0"]
    again = robot_from_dict(robot_to_dict(arm, found.task, 2))
    assert [joint.link for joint in again.joints] == ["upper", "forearm"]


@pytest.mark.parametrize("off", [-1e-12, 0.0, 1e-12])
def test_a_tie_of_three_digits_is_written_in_one_way(off: float) -> None:
    """0.7345 m fell to 0.734 or to 0.735 by the last bit, which libraries of linear algebra differ in."""
    assert constraint([0.0, 1.0, 0.0, 0.7345 + off, 0.0, 0.0]) == "vy + 0.735 m·ωx = 0"


def test_a_coefficient_that_matters_to_nobody_is_left_out():
    assert constraint([1.48e-5, 0.63, 0.7766, 0, 0, 2e-5]) == "0.63 vy + 0.777 vz = 0"
    assert constraint([0, 0.6, 0.8, 0, 0, 1e-3]) == "0.6 vy + 0.8 vz + 0.001 m·ωz = 0"
