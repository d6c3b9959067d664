"""MJCF: the chain of bodies moves as MuJoCo moves it, with its joint values; what cannot be a chain is refused."""

from __future__ import annotations

import sys
from math import inf, pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rankdrop.errors import MissingExtraError, RobotError
from rankdrop.kinematics import jacobian, pose
from rankdrop.robot.mjcf import from_mjcf
from rankdrop.robot.model import JointKind, Robot
from rankdrop.robot.open import open_robot

GEOM = '<geom size="0.05"/>'

SEVERAL = f"""<mujoco model="several in a body"><compiler angle="radian" autolimits="true"/><worldbody>
<body name="carriage" pos="0.1 -0.2 0.3" quat="0.9 0.1 -0.3 0.2">
  <joint name="x" type="slide" axis="1 2 0" pos="0.3 0 0.1" range="-1 1"/>
  <joint name="turn" axis="0 1 1" pos="0.1 0.2 -0.3"/>
  <joint name="lift" type="slide" axis="0 -1 3" ref="0.25"/>{GEOM}
  <body name="arm" pos="0 0.4 0.1" axisangle="1 1 0 0.7">
    <joint name="elbow" axis="2 0 1" pos="0 -0.1 0.05" ref="-0.6" range="-2 0.5"/>
    <joint name="roll" axis="0 0 1" pos="0.02 0 0" ref="1.1"/>{GEOM}
    <body name="plate" pos="0.1 0 0" xyaxes="0 1 0 -1 0 1"><site name="mark" pos="0 0 0.1" zaxis="1 1 1"/>{GEOM}</body>
  </body></body></worldbody></mujoco>"""

DEGREES = f"""<mujoco><compiler eulerseq="zyx"/><default><joint axis="0 1 0" range="-90 45"/>
<default class="free turning"><joint axis="1 0 0" limited="false"/></default></default><worldbody>
<frame pos="0 0 0.2" euler="30 0 0"><body name="a" pos="0.1 0 0" euler="10 20 30"><joint name="ja" ref="30"/>{GEOM}
  <frame euler="0 0 90"><body name="b" pos="0 0.3 0" childclass="free turning"><joint name="jb" pos="0 0.1 0"/>{GEOM}
    <body name="c" pos="0 0 0.2"><joint name="jc" class="main" ref="-20" range="-120 10"/>{GEOM}</body></body></frame>
</body></frame></worldbody></mujoco>"""

USED = """<mujoco model="used"><asset><mesh name="m" file="nowhere.stl"/><material name="blue" rgba="0 0 1 1"/></asset>
<worldbody><light pos="0 0 3"/><body name="l1"><joint name="j1" axis="0 0 1"/><geom type="mesh" mesh="m"/>
  <body name="l2" pos="0.5 0 0"><joint name="j2" axis="0 1 0"/><geom name="g" type="mesh" mesh="m" material="blue"/>
    <site name="attachment_site" pos="0.4 0 0" material="blue"/><camera name="eye"/></body></body></worldbody>
<contact><exclude body1="l1" body2="l2"/></contact>
<equality><joint joint1="j2" joint2="j1" polycoef="0 1 0 0 0"/></equality>
<tendon><fixed name="t"><joint joint="j1" coef="1"/></fixed></tendon>
<actuator><motor joint="j1"/><motor tendon="t"/></actuator><sensor><jointpos joint="j1"/><framepos objtype="geom"
objname="g"/></sensor><keyframe><key name="home" qpos="0 0"/></keyframe></mujoco>"""


def write(folder: Path, text: str, name: str = "arm.xml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def moved_by_mujoco(mujoco: Any, path: Path, arm: Robot, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(4, 4) pose of the tip and (6, n) Jacobian (v at the tip; ω), both in MuJoCo's world."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    for joint, value in zip(arm.variables, q, strict=True):
        data.joint(joint.name).qpos[0] = value
    mujoco.mj_forward(model, data)
    place = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, arm.tip)
    what = data.site(arm.tip) if place >= 0 else data.body(arm.tip)
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = what.xmat.reshape(3, 3), what.xpos
    v, w = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    mujoco.mj_jac(model, data, v, w, what.xpos, model.site(arm.tip).bodyid[0] if place >= 0 else model.body(arm.tip).id)
    columns = [int(model.joint(joint.name).dofadr[0]) for joint in arm.variables]
    return result, np.vstack([v, w])[:, columns]


@pytest.mark.spread(1)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "tip"),
    [(SEVERAL, "mark"), (SEVERAL, "plate"), (SEVERAL, "arm"), (DEGREES, "c"), (DEGREES, "b"), (DEGREES, "a")],
)
def test_every_body_moves_as_mujoco_moves_it(tmp_path: Path, text: str, tip: str) -> None:
    mujoco = pytest.importorskip("mujoco")
    path = write(tmp_path, text)
    arm = from_mjcf(path, tip=tip, as_written=True)
    for q in np.random.default_rng(5).uniform(-2, 2, (20, arm.n)):
        there, columns = moved_by_mujoco(mujoco, path, arm, q)
        assert np.abs(pose(arm, q) - there).max() < 1e-12
        assert np.abs(jacobian(arm, q) - columns).max() < 1e-12


def test_kinds_limits_and_values_are_those_of_the_file(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    arm = open_robot(write(tmp_path, SEVERAL))
    assert (arm.name, arm.source.kind, arm.base, arm.tip) == ("several in a body", "mjcf", "world", "mark")
    assert [joint.name for joint in arm.joints] == ["x", "turn", "lift", "elbow", "roll"]
    slides = [joint.kind is JointKind.PRISMATIC for joint in arm.joints]
    assert slides == [True, False, True, False, False]
    assert arm.lower.tolist() == [-1, -inf, -inf, -2, -inf]
    assert arm.upper.tolist() == [1, inf, inf, 0.5, inf]


def test_degrees_defaults_and_frames_are_resolved(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    arm = open_robot(write(tmp_path, DEGREES))
    assert arm.name == "arm"
    assert arm.lower == pytest.approx([-pi / 2, -inf, -2 * pi / 3])
    assert arm.upper == pytest.approx([pi / 4, inf, pi / 18])


def test_meshes_actuators_and_constraints_are_neither_needed_nor_followed(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    arm = open_robot(write(tmp_path, USED))
    assert (arm.n, arm.tip) == (2, "attachment_site")
    assert arm.home[:3, 3].tolist() == [0.9, 0, 0]
    assert str(arm.notes[-1]) == "joint 'j2' is coupled to 'j1' by a constraint: they count as independent"


@pytest.mark.slow
def test_included_files_and_a_scene_around_the_arm_are_read(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    write(tmp_path, USED, "used.xml")
    cube = f'<body name="cube" pos="1 0 0"><freejoint/>{GEOM}</body>'
    world = f'<worldbody><body name="floor"/>{cube}</worldbody>'
    scene = write(tmp_path, f'<mujoco><include file="used.xml"/>{world}</mujoco>')
    assert (open_robot(scene).n, open_robot(scene).base) == (2, "world")


@pytest.mark.slow
def test_rounded_angles_in_radians_are_right_angles(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    inner = f'<body name="b" pos="0.3 0 0.1" axisangle="1 0 0 -1.5708"><joint name="k"/>{GEOM}</body>'
    outer = f'<body name="a" euler="0 0 1.5708"><joint name="j"/>{GEOM}{inner}</body>'
    text = f'<mujoco><compiler angle="radian"/><worldbody>{outer}</worldbody></mujoco>'
    path = write(tmp_path, text)
    one, two = (joint.screw[3:] for joint in open_robot(path).joints)
    assert (one.tolist(), two.tolist()) == ([0, 0, 1], [-1, 0, 0])
    words = str(open_robot(path).notes[-1])
    assert words.startswith("2 angles read as the multiples of 15° they round, at most 3.7e-06")
    two = open_robot(path, as_written=True).joints[1].screw[3:]
    assert 1e-6 < np.abs(two - (-1, 0, 0)).max() < 1e-5


def test_joints_and_bodies_without_names_have_one(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    body = f'<body pos="0 0 0.3"><joint axis="1 0 0"/>{{}}{GEOM}</body>'
    text = body.format('<joint type="slide"/>' + body.format("").replace("<body", '<body name="last"'))
    arm = open_robot(write(tmp_path, f"<mujoco><worldbody>{text}</worldbody></mujoco>"))
    assert [joint.name for joint in arm.joints] == ["body1_joint1", "body1_joint2", "last_joint"]


@pytest.mark.slow
def test_a_floating_body_is_the_base_and_no_chain_passes_it(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    foot = f'<body name="foot" pos="0 0 -1"><joint name="knee"/>{GEOM}</body>'
    leg = f'<body name="leg"><joint name="hip"/>{GEOM}{foot}</body>'
    pelvis = f'<body name="pelvis"><freejoint/>{GEOM}{leg}</body>'
    path = write(tmp_path, f"<mujoco><worldbody>{pelvis}</worldbody></mujoco>")
    arm = open_robot(path)
    assert (arm.base, arm.n) == ("pelvis", 2)
    assert "body 'pelvis' floats freely: its own motion is not counted" in map(str, arm.notes)
    with pytest.raises(RobotError, match="the chain would pass a free joint, which has several freedoms") as caught:
        open_robot(path, base="world", tip="foot")
    assert caught.value.on_command_line().endswith("fix: --base pelvis")


@pytest.mark.slow
def test_a_ball_joint_is_refused_with_the_base_below_it(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    lower = f'<body name="lower"><joint name="e"/>{GEOM}</body>'
    ball = f'<body name="upper"><joint name="s" type="ball"/>{GEOM}{lower}</body>'
    path = write(tmp_path, f"<mujoco><worldbody>{ball}</worldbody></mujoco>")
    with pytest.raises(RobotError, match=r"joint 's': a joint of the chain has several freedoms; got a ball") as caught:
        open_robot(path)
    assert caught.value.mend == "name a base below it: base='upper'"
    assert caught.value.on_command_line().endswith("--base upper")
    assert open_robot(path, base="upper").n == 1


@pytest.mark.spread(3)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<mujoco><worldbody><body><joint type='screw'/></body></worldbody></mujoco>", "MuJoCo .*: invalid keyword"),
        ("<mujoco><worldbody><body name='a'/><body name='a'/></worldbody></mujoco>", "MuJoCo cannot compile the file"),
        ("<mujoco><worldbody><body name='a'/></worldbody></mujoco>", "no moving joint in the file"),
        ("<mujoco><include file='no.xml'/></mujoco>", "MuJoCo cannot compile the file"),
        ('<!DOCTYPE m [<!ENTITY x "y">]><mujoco/>', "document types and entities are refused"),
        ("<mujoco><worldbody>", "not well-formed"),
    ],
)
def test_what_is_no_arm_is_refused_in_one_line(tmp_path: Path, text: str, words: str) -> None:
    pytest.importorskip("mujoco")
    with pytest.raises(RobotError, match=words) as caught:
        open_robot(write(tmp_path, text))
    assert "\n" not in str(caught.value)


def test_without_mujoco_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingExtraError, match=r'needs the package mujoco; .*source: pip install "\.\[mujoco\]"'):
        open_robot(write(tmp_path, SEVERAL))
