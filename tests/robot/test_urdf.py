"""URDF: the chain that is read, what is tolerated with a note, and what is refused with file and line."""

from __future__ import annotations

from contextlib import suppress
from math import inf, pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference.kinematics import exponential, pose

from rankdrop.errors import RobotError
from rankdrop.robot.model import Array, JointKind
from rankdrop.robot.transform import from_xyz_rpy
from rankdrop.robot.urdf import from_urdf
from robot.urdf_text import chain, joint, robot

LIMIT = '<limit lower="-1" upper="1"/>'


def spaced(values: Array) -> str:
    return " ".join(repr(float(value)) for value in values)


def test_pose_is_the_product_of_origins_and_joint_motions(rng: np.random.Generator) -> None:
    kinds = ["revolute", "fixed", "prismatic", "continuous", "fixed", "revolute"]
    joints, expected = [], np.eye(4)
    q = rng.uniform(-1, 1, 4)
    value = iter(q)
    for i, kind in enumerate(kinds):
        xyz, rpy, axis = rng.uniform(-2, 2, (3, 3))
        inside = f'<origin xyz="{spaced(xyz)}" rpy="{spaced(rpy)}"/><axis xyz="{spaced(axis)}"/>{LIMIT}'
        joints.append(joint(f"j{i}", f"l{i}", f"l{i + 1}", kind, inside))
        expected = expected @ from_xyz_rpy(xyz, rpy)
        unit, still = axis / np.linalg.norm(axis), np.zeros(3)
        if kind != "fixed":
            screw = np.concatenate([unit, still] if kind == "prismatic" else [still, unit])
            expected = expected @ exponential(screw, next(value))
    arm = from_urdf(robot(joints))
    assert arm.n == 4
    assert pose(arm, q) == pytest.approx(expected, abs=1e-13)
    assert [str(entry.kind) for entry in arm.joints] == ["revolute", "prismatic", "revolute", "revolute"]


def test_names_limits_and_frames_come_along() -> None:
    arm = from_urdf(robot(chain(2)))
    assert (arm.name, arm.base, arm.tip, arm.source.kind) == ("test", "base", "l2", "urdf")
    assert [entry.name for entry in arm.joints] == ["j1", "j2"]
    assert (arm.joints[0].lower, arm.joints[0].upper, arm.joints[0].velocity) == (-1.0, 2.0, 3.0)
    inside = '<origin xyz="1 2 3"/><axis xyz="0 0 1"/>'
    assert from_urdf(robot([joint("j", "a", "b", "continuous", inside)])).joints[0].frame[:3, 3].tolist() == [1, 2, 3]


def test_the_default_axis_is_x_and_the_length_of_an_axis_does_not_matter() -> None:
    arm = from_urdf(robot([joint("j", "a", "b", "continuous", "<origin/>")]))
    assert arm.joints[0].screw.tolist() == [0, 0, 0, 1, 0, 0]
    arm = from_urdf(robot([joint("j", "a", "b", "prismatic", f'<axis xyz="0 0 0.01"/>{LIMIT}')]))
    assert arm.joints[0].screw.tolist() == [0, 0, 1, 0, 0, 0]


def test_continuous_joints_have_no_limits_even_where_some_are_written() -> None:
    arm = from_urdf(robot([joint("j", "a", "b", "continuous", f'<axis xyz="0 0 1"/>{LIMIT}')]))
    assert (arm.joints[0].lower, arm.joints[0].upper) == (-inf, inf)


def test_a_velocity_of_minus_one_is_not_known() -> None:
    """It is SDF's default, no limit; the legs of EVE R3 (Halodi, eve_r3.urdf) have velocity="-1.0"."""
    arm = from_urdf(robot([joint("j", "a", "b", "revolute", '<limit lower="0" upper="1" velocity="-1.0"/>')]))
    assert arm.joints[0].velocity == np.inf
    assert "joint 'j': velocity -1 is read as not known" in map(str, arm.notes)


def test_missing_limits_are_tolerated_with_a_note() -> None:
    arm = from_urdf(robot([joint("j", "a", "b", "revolute", '<axis xyz="0 0 1"/>')]))
    assert (arm.joints[0].lower, arm.joints[0].upper, arm.joints[0].velocity) == (-inf, inf, inf)
    assert "joint 'j' has no limits: it counts as unlimited" in map(str, arm.notes)
    arm = from_urdf(robot([joint("j", "a", "b", "revolute", '<limit upper="1" velocity="0"/>')]))
    assert (arm.joints[0].lower, arm.joints[0].upper, arm.joints[0].velocity) == (0.0, 1.0, inf)
    assert any("no lower limit: it is 0" in str(note) for note in arm.notes)


def test_prefixes_without_a_namespace_are_tolerated() -> None:
    text = robot([joint("j", "a", "b", "continuous", '<axis xyz="0 0 1"/><drake:rotor_inertia value="1"/>')])
    assert from_urdf(text).n == 1


def test_joints_inside_transmissions_are_not_joints() -> None:
    text = robot([*chain(1), '<transmission name="t"><joint name="j1"/></transmission>'])
    assert from_urdf(text).n == 1


def test_a_file_is_read_like_its_text(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(robot(chain(3)), encoding="utf-8")
    arm = from_urdf(path)
    assert arm.n == 3
    assert arm.source.origin == str(path)


def mimic(leader: str, numbers: str = "") -> str:
    return f'<axis xyz="0 0 1"/><limit lower="-1" upper="1"/><mimic joint="{leader}" {numbers}/>'


def test_mimic_joints_follow_their_leader_in_the_chain() -> None:
    follower = joint("b", "1", "2", inside=mimic("a", 'multiplier="-2" offset="0.5"'))
    arm = from_urdf(robot([joint("a", "0", "1"), follower]))
    assert arm.n == 1
    assert arm.joints[1].mimic is not None
    assert (arm.joints[1].mimic.leader, arm.joints[1].mimic.multiplier, arm.joints[1].mimic.offset) == ("a", -2.0, 0.5)
    assert pose(arm, [0.4])[:2, 0] == pytest.approx([np.cos(0.4 - 0.8 + 0.5), np.sin(0.4 - 0.8 + 0.5)])
    assert any("'b' follows joint 'a'" in str(note) for note in arm.notes)


def test_a_follower_of_a_follower_is_traced_to_the_first_leader() -> None:
    two = [joint("b", "1", "2", inside=mimic("a", 'multiplier="2" offset="1"'))]
    three = [joint("c", "2", "3", inside=mimic("b", 'multiplier="3" offset="-1"'))]
    arm = from_urdf(robot([joint("a", "0", "1"), *two, *three]))
    assert arm.joints[2].mimic is not None
    assert (arm.joints[2].mimic.leader, arm.joints[2].mimic.multiplier, arm.joints[2].mimic.offset) == ("a", 6.0, 2.0)


def test_the_first_of_several_followers_of_a_leader_outside_leads() -> None:
    outside = joint("motor", "0", "side")
    first = joint("b", "0", "2", inside=mimic("motor", 'multiplier="2" offset="1"'))
    second = joint("c", "2", "3", inside=mimic("motor", 'multiplier="-3" offset="0.5"'))
    arm = from_urdf(robot([outside, first, second]), tip="3")
    assert arm.n == 1
    assert arm.joints[0].mimic is None
    assert arm.joints[1].mimic is not None
    motor = 0.7
    b, c = 2 * motor + 1, -3 * motor + 0.5
    assert arm.joints[1].mimic.multiplier * b + arm.joints[1].mimic.offset == pytest.approx(c)
    assert any("counts as a variable" in str(note) for note in arm.notes)
    assert any("follows 'b' instead" in str(note) for note in arm.notes)


ONE = chain(1)[0]
BAD = [
    ([joint("j", "a", "b", "revolute", '<axis xyz="0 0 nan"/>')], 2, "<axis> of joint 'j': xyz is not a finite number"),
    ([joint("j", "a", "b", "revolute", '<axis xyz="0 0 inf"/>')], 2, "xyz is not a finite number; got 'inf'"),
    ([joint("j", "a", "b", "revolute", '<axis xyz="0 0 1e999"/>')], 2, "xyz is not a finite number"),
    ([joint("j", "a", "b", "revolute", '<axis xyz="0 0 0"/>')], 2, "axis has no length; got '0 0 0'"),
    ([joint("j", "a", "b", "revolute", '<axis xyz="0 0"/>')], 2, "xyz is three numbers; got '0 0'"),
    ([joint("j", "a", "b", "revolute", '<origin xyz="0 0 one"/>')], 2, "<origin> of joint 'j': xyz is not a finite"),
    ([joint("j", "a", "b", "revolute", '<origin rpy="0 0 ${pi}"/>')], 2, "rpy is not a finite number"),
    ([joint("j", "a", "b", "revolute", '<origin quat_xyzw="0 0 0 1"/>')], 2, "not given as rpy"),
    ([joint("j", "a", "b", "revolute", '<limit lower="2" upper="1"/>')], 2, "lower limit above upper limit; got lower"),
    ([joint("j", "a", "b", "revolute", '<limit lower="nan" upper="1"/>')], 2, "<limit> of joint 'j': lower is not"),
    ([joint("j", "a", "b", "revolute", '<limit lower="-1" upper="inf"/>')], 2, "upper is not.*leave the attribute out"),
    ([joint("j", "a", "b", "revolute", '<limit lower="1,5" upper="2"/>')], 2, "lower is not a finite number"),
    ([joint("j", "a", "b", "revolute", '<limit lower="0" upper="1" velocity="-2"/>')], 2, "velocity is negative"),
    ([ONE, joint("j", "l1", "b", "floating")], 3, "joint 'j': a joint of the chain has several freedoms; got"),
    ([ONE, joint("j", "l1", "b", "planar")], 3, "several freedoms; got type 'planar'; allowed: revolute"),
    ([ONE, joint("j", "l1", "b", "ball")], 3, "joint type is not known; got type 'ball'"),
    ([ONE, joint("j", "l1", "b", "")], 3, "joint type is not known; got type ''"),
    ([ONE, joint("j", "l1", "b", "Revolute")], 3, "joint type is not known"),
    ([ONE, joint("j", "l1", "b").replace("joint", "drake:joint").replace("revolute", "screw")], 3, "type is not known"),
    ([ONE, ONE], 3, "two joints have the name 'j1'; got the first on line 2"),
    ([*chain(2), joint("j3", "base", "l2")], 4, "link 'l2' has two parents; got joints 'j2' and 'j3'"),
    ([joint("a", "x", "y"), joint("b", "y", "x")], 2, "the links form a cycle; got "),
    ([joint("a", "x", "x")], 2, "the links form a cycle; got a"),
    ([ONE, '<joint name="k" type="fixed"><child link="l1"/></joint>'], 3, "joint 'k': the joint names no parent link"),
    ([ONE, '<joint name="k" type="fixed"><parent link="l1"/></joint>'], 3, "joint 'k': the joint names no child link"),
    ([ONE, '<joint type="fixed"><parent link="l1"/></joint>'], 3, "a joint has no name"),
    ([ONE, "<link/>"], 3, "a link has no name"),
    ([ONE, '<link name="l1"/>'], 4, "two links have the name 'l1'; got the first on line 3"),
    ([joint("j", "a", "b", inside=mimic("ghost"))], 2, "<mimic> of joint 'j': .*not in the file; got 'ghost'"),
    ([joint("j", "a", "b", inside=mimic("j"))], 2, "in a circle; got j -> j"),
    ([ONE, joint("j", "l1", "b", inside=mimic("j1", 'multiplier="0"'))], 3, "multiplier of a mimic joint is zero"),
    ([ONE, joint("j", "l1", "b", inside=mimic("j1", 'offset="x"'))], 3, "<mimic> of joint 'j': offset is not a finite"),
    ([joint("f", "0", "a", "fixed"), joint("j", "a", "b", inside=mimic("f"))], 3, "follows a fixed joint; got 'f'"),
]  # fmt: skip


@pytest.mark.parametrize(("joints", "line", "words"), BAD)
def test_what_cannot_be_used_names_file_line_joint_and_value(joints: list[str], line: int, words: str) -> None:
    with pytest.raises(RobotError, match=words) as caught:
        from_urdf(robot(joints), file="arm.urdf")
    assert str(caught.value).startswith(f"arm.urdf, line {line}, ")
    assert "\n" not in str(caught.value)


def test_a_link_that_is_not_declared_is_named_with_close_names() -> None:
    text = robot([ONE]).replace('child link="l1"', 'child link="L1"')
    with pytest.raises(RobotError, match="line 2, <child> of joint 'j1': the child link is not in the file; got 'L1'"):
        from_urdf(text)


def test_trouble_outside_the_chain_does_not_matter() -> None:
    aside = [joint("k", "base", "side", "floating"), joint("m", "side", "x", "revolute", '<axis xyz="0 0 0"/>')]
    assert from_urdf(robot([*chain(2), *aside]), tip="l2").n == 2


def test_another_root_element_is_said() -> None:
    with pytest.raises(RobotError, match=r"line 2: this is not a URDF; got <sdf>; allowed: <robot>"):
        from_urdf("<?xml version='1.0'?>\n<sdf/>")


@pytest.mark.slow
@given(st.sampled_from(["revolute", "prismatic", "continuous", "fixed"]), st.text(max_size=12))
def test_any_number_text_gives_a_robot_or_a_robot_error(kind: str, text: str) -> None:
    safe = "".join(c for c in text if c.isprintable() and c not in "<&\"")
    inside = f'<origin xyz="{safe}"/><axis xyz="0 {safe} 1"/><limit lower="{safe}" upper="1"/>'
    with suppress(RobotError):
        arm = from_urdf(robot([*chain(1), joint("k", "l1", "end", kind, inside)]), tip="end")
        assert np.isfinite(arm.home).all()


def test_joint_kinds_have_their_units() -> None:
    arm = from_urdf(robot([joint("p", "a", "b", "prismatic"), joint("r", "b", "c", "continuous")]))
    assert [entry.kind for entry in arm.joints] == [JointKind.PRISMATIC, JointKind.REVOLUTE]
    assert [entry.unit for entry in arm.joints] == ["m", "rad"]


def test_right_angles_in_rpy_leave_exact_zeros() -> None:
    inside = f'<origin rpy="{pi / 2!r} 0 {-pi / 2!r}"/><axis xyz="0 0 1"/>'
    arm = from_urdf(robot([joint("j", "a", "b", "continuous", inside)]))
    assert sorted(abs(arm.joints[0].screw[3:])) == [0.0, 0.0, 1.0]
