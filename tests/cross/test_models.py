"""Robots from and to models of Pinocchio, MuJoCo, the Robotics Toolbox and yourdfpy, against these packages.

Over the whole catalogue, `rankdrop.jacobian` equals their Jacobian to 1e-12. Needs the extras "cross" and "mujoco";
each package that is missing is skipped with the reason.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from known.arms import KINDS, STRUCTURES
from reference.measure import relative

from cross.model_packages import PACKAGES, package
from cross.real_files import FILES
from rankdrop.errors import RobotError
from rankdrop.kinematics import jacobian, pose
from rankdrop.poses.branches import inverse
from rankdrop.robot import (
    from_mujoco,
    from_pinocchio,
    from_toolbox,
    from_yourdfpy,
    open_robot,
    to_mujoco,
    to_pinocchio,
    to_toolbox,
    to_yourdfpy,
)
from rankdrop.robot.model import Array, Joint, JointKind, Mimic, Robot
from rankdrop.robot.open import robot_names
from rankdrop.robot.screws import from_screws
from rankdrop.robot.urdf import from_urdf

TOLERANCE = 1e-12
FROM: dict[str, Callable[..., Robot]] = {
    "pinocchio": from_pinocchio, "mujoco": from_mujoco, "roboticstoolbox": from_toolbox, "yourdfpy": from_yourdfpy,
}  # fmt: skip
TO: dict[str, Callable[[Robot], Any]] = {
    "pinocchio": to_pinocchio, "mujoco": to_mujoco, "roboticstoolbox": to_toolbox, "yourdfpy": to_yourdfpy,
}  # fmt: skip
USUAL = {*KINDS, *STRUCTURES}
CATALOGUE = [
    pytest.param(name, marks=[] if name in USUAL else pytest.mark.by_hand) for name in sorted(robot_names())
]
"""All; one of each kind and structure, the others by hand."""


def theirs(name: str, model: Any, robot: Robot, q: Array) -> tuple[Array, Array]:
    """Pose (4, 4) and Jacobian (6, n) of the tip in the axes of the base, by the package's own kinematics."""
    their = package(name)
    if name == "pinocchio":
        data, frame = model.createData(), model.getFrameId(robot.tip)
        columns = their.computeFrameJacobian(model, data, q, frame, their.LOCAL_WORLD_ALIGNED)
        their.framesForwardKinematics(model, data, q)
        return data.oMf[frame].homogeneous, columns
    if name == "mujoco":
        data = their.MjData(model)
        data.qpos[:] = q
        their.mj_kinematics(model, data)
        their.mj_comPos(model, data)
        site = model.site(robot.tip).id
        linear, angular = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        their.mj_jacSite(model, data, linear, angular, site)
        at = np.eye(4)
        at[:3, :3], at[:3, 3] = data.site_xmat[site].reshape(3, 3), data.site_xpos[site]
        return at, np.concatenate([linear, angular])
    if name == "roboticstoolbox":
        return np.asarray(model.fkine(q).A), np.asarray(model.jacob0(q))
    model.update_cfg(q)  # yourdfpy has no Jacobian: its poses of the tip are differenced
    at = np.array(model.get_transform(robot.tip, robot.base))
    return at, differences(model, robot, q)


def differences(model: Any, robot: Robot, q: Array) -> Array:
    """The screw of each joint from yourdfpy's poses at half a turn, or 1 m, to either side: no step is small."""
    columns = []
    for i, joint in enumerate(robot.variables):
        ends = []
        for sign in (1.0, -1.0):
            model.update_cfg(q + sign * (1.0 if joint.kind is JointKind.PRISMATIC else np.pi / 2) * np.eye(robot.n)[i])
            ends.append(np.array(model.get_transform(robot.tip, robot.base)))
        half = (ends[0] - ends[1]) / 2.0  # of a turn: [ω]× R and [ω]× (p − a), a on the axis; of a slide: v
        model.update_cfg(q)
        middle = np.array(model.get_transform(robot.tip, robot.base))[:3, :3]
        spin = half[:3, :3] @ middle.T
        columns.append([*half[:3, 3], spin[2, 1], spin[0, 2], spin[1, 0]])
    return np.array(columns).T


def spread(robot: Robot, rng: np.random.Generator, count: int = 4) -> Array:
    """Configurations; the first is zero."""
    q = rng.uniform(-2.0, 2.0, (count, robot.n))
    q[0] = 0.0
    return q


def apart(one: Robot, two: Robot, q: Array) -> float:
    """How far two arms differ at configurations: pose and Jacobian."""
    assert [joint.kind for joint in one.joints] == [joint.kind for joint in two.joints]
    return max(relative(pose(one, q), pose(two, q)), relative(jacobian(one, q), jacobian(two, q)))


@pytest.mark.spread(80)
@pytest.mark.slow
@pytest.mark.parametrize("name", PACKAGES)
@pytest.mark.parametrize("arm", CATALOGUE)
def test_the_catalogue_in_the_models_of_others(arm: str, name: str, rng: np.random.Generator) -> None:
    package(name)
    robot = open_robot(arm)
    if name != "yourdfpy" and any(joint.mimic for joint in robot.joints):
        with pytest.raises(RobotError, match="follows another"):
            TO[name](robot)
        return
    model = TO[name](robot)
    # MuJoCo and yourdfpy take a turn below 1e-8 rad for none; two arms have one of 9.5e-11 rad at the tip
    hardly = 0.0 < np.abs(robot.home[:3, :3] - np.eye(3)).max() < 1e-8
    for q in spread(robot, rng):
        at, columns = theirs(name, model, robot, q)
        assert relative(pose(robot, q), at) < (2e-10 if hardly else TOLERANCE)
        assert relative(jacobian(robot, q), columns) < TOLERANCE


@pytest.mark.parametrize("name", PACKAGES)
@pytest.mark.parametrize("arm", ["pa10", "scara", "ur5", "stanford", "puma560"])
def test_there_and_back(arm: str, name: str, rng: np.random.Generator) -> None:
    package(name)
    robot = open_robot(arm)
    ends = {} if name == "roboticstoolbox" else {"tip": robot.tip}
    back = FROM[name](TO[name](robot), as_written=True, **ends)
    assert apart(back, robot, spread(robot, rng)) < TOLERANCE
    if name != "roboticstoolbox":  # which has no names
        assert [joint.name for joint in back.joints] == [joint.name for joint in robot.joints]
    both = np.isfinite(robot.lower) & np.isfinite(robot.upper)
    np.testing.assert_array_equal(back.lower[both], robot.lower[both])
    np.testing.assert_array_equal(back.upper[both], robot.upper[both])
    assert not np.isfinite(back.lower[~both]).any() or name in ("pinocchio", "yourdfpy")


@pytest.mark.parametrize("name", ["pinocchio", "yourdfpy"])
@pytest.mark.parametrize("file", FILES)
def test_a_model_of_a_makers_file_is_the_arm_of_the_file(file: str, name: str, rng: np.random.Generator) -> None:
    """Read by the package, then taken from it, with the same base and tip; continuous joints are points of a circle."""
    their, real = package(name), FILES[file]
    if name == "pinocchio":
        model = their.buildModelFromUrdf(str(real.path))
    else:
        model = their.URDF.load(str(real.path), load_meshes=False, build_scene_graph=False)
    want = open_robot(real.path, tip=real.tip, as_written=True)
    robot = FROM[name](model, base=want.base, tip=real.tip, as_written=True)
    assert [joint.name for joint in robot.joints] == [joint.name for joint in want.joints]
    assert apart(robot, want, spread(want, rng)) < TOLERANCE
    np.testing.assert_allclose(robot.lower, want.lower, rtol=0, atol=0)
    np.testing.assert_allclose(robot.upper, want.upper, rtol=0, atol=0)
    np.testing.assert_allclose([j.velocity for j in robot.joints], [j.velocity for j in want.joints])


MJCF = """<mujoco model="two"> <compiler angle="radian" autolimits="true"/> <worldbody>
  <body name="a" pos="0 0 .3" euler="0 0 .7"> <geom size=".1"/>
    <joint name="one" axis="0 0 1" range="-1 2"/> <joint name="out" type="slide" axis="1 0 0" pos="0 .1 0"/>
    <body name="b" pos=".5 0 .1" quat=".8 .6 0 0"> <geom size=".1"/>
      <joint name="two" axis="0 1 1" pos=".1 0 .2" ref=".4"/>
      <site name="end" pos=".2 .3 .4" euler=".1 .2 .3"/> </body> </body> </worldbody>
  <equality> <joint joint1="one" joint2="two"/> </equality> </mujoco>"""


def test_a_mujoco_model_in_memory(rng: np.random.Generator) -> None:
    their = package("mujoco")
    model = their.MjModel.from_xml_string(MJCF)
    robot = from_mujoco(model, tip="end", as_written=True)
    assert (robot.name, [joint.name for joint in robot.joints]) == ("two", ["one", "out", "two"])
    assert (robot.lower[0], robot.upper[0]) == (-1.0, 2.0)
    assert any("coupled" in str(note) for note in robot.notes)
    for q in spread(robot, rng, 20):
        at, columns = theirs("mujoco", model, robot, q)
        assert relative(pose(robot, q), at) < TOLERANCE
        assert relative(jacobian(robot, q), columns) < TOLERANCE


@pytest.mark.parametrize("model", ["Puma560", "Panda", "Stanford", "KR5", "IRB140", "LWR4", "Jaco", "Mico", "UR10"])
def test_arms_of_the_toolbox(model: str, rng: np.random.Generator) -> None:
    """Their own DH models, standard and modified, with offsets, tools, slides."""
    their = package("roboticstoolbox")
    arm = getattr(their.models.DH, model)()
    robot = from_toolbox(arm, as_written=True)
    assert robot.n == arm.n
    for q in spread(robot, rng, 10):
        assert relative(pose(robot, q), arm.fkine(q).A) < TOLERANCE
        assert relative(jacobian(robot, q), arm.jacob0(q)) < TOLERANCE


def test_flipped_joints_and_shared_variables_of_the_toolbox(rng: np.random.Generator) -> None:
    their = package("roboticstoolbox")
    sequence = their.ET.tx(0.4) * their.ET.Ry(flip=True) * their.ET.tz(0.3) * their.ET.ty(flip=True) * their.ET.Rx(0.3)
    robot = from_toolbox(sequence, as_written=True)
    assert [joint.kind for joint in robot.joints] == [JointKind.REVOLUTE, JointKind.PRISMATIC]
    for q in spread(robot, rng, 10):
        assert relative(jacobian(robot, q), sequence.jacob0(q)) < TOLERANCE
    with pytest.raises(RobotError, match="numbered"):
        from_toolbox(their.ET.Rz(jindex=1) * their.ET.tx(1.0) * their.ET.Rz(jindex=0))


@pytest.mark.parametrize("name", PACKAGES)
def test_joints_that_others_do_not_have(name: str, rng: np.random.Generator) -> None:
    """A joint that follows is yourdfpy's too, a helical one Pinocchio's."""
    package(name)
    joints = open_robot("scara").joints
    follower = Joint("hand", JointKind.REVOLUTE, joints[-1].screw, mimic=Mimic(joints[0].name, -0.5, 0.1))
    led = Robot("led", (*joints, follower))
    screw = from_screws([[0.1, 0.2, 0.3, 0.0, 0.0, 1.0], [0.1, 0.0, 0.0, 0.0, 0.6, 0.8]], order="linear-first")
    assert JointKind.HELICAL in {joint.kind for joint in screw.joints}
    for robot, able in ((led, "yourdfpy"), (screw, "pinocchio")):
        if name != able:
            with pytest.raises(RobotError, match=r"follow others|helical"):
                TO[name](robot)
            continue
        back = FROM[name](TO[name](robot), tip=robot.tip, as_written=True)
        assert back.n == robot.n
        assert apart(back, robot, spread(robot, rng)) < TOLERANCE


def test_what_a_model_of_pinocchio_may_not_have() -> None:
    their = package("pinocchio")
    model = their.Model()
    ball = model.addJoint(0, their.JointModelSpherical(), their.SE3.Identity(), "ball")
    one = model.addJoint(ball, their.JointModelRX(), their.SE3.Identity(), "one")
    model.addFrame(their.Frame("hand", one, 0, their.SE3.Identity(), their.FrameType.BODY))
    with pytest.raises(RobotError, match=r"joint 'ball'.*one freedom"):
        from_pinocchio(model, tip="hand")
    with pytest.raises(RobotError, match="no link for the tip"):
        from_pinocchio(model, tip="hend")
    assert from_pinocchio(model, base="after ball", tip="hand").n == 1


def test_noise_of_a_model_is_taken_as_in_files() -> None:
    """A right angle written as 1.5708 is one in the file and in the model that was made of it."""
    their = package("pinocchio")
    text = """<robot name="r"> <link name="a"/> <link name="b"/> <link name="c"/>
      <joint name="j" type="continuous"> <parent link="a"/> <child link="b"/> <axis xyz="0 0 1"/> </joint>
      <joint name="k" type="continuous"> <parent link="b"/> <child link="c"/> <origin xyz="1 0 0" rpy="1.5708 0 0"/>
      <axis xyz="0 0 1"/> </joint> </robot>"""
    taken, literal = (from_pinocchio(their.buildModelFromXML(text), as_written=written) for written in (False, True))
    assert taken.joints[1].screw[5] == 0.0 == from_urdf(text).joints[1].screw[5]
    assert literal.joints[1].screw[5] != 0.0
    assert taken.notes


@pytest.mark.slow
def test_the_toolbox_finds_the_same_solutions_of_a_pose() -> None:
    """Its closed form for the Puma 560: eight configurations, of which none is missed."""
    toolbox = package("roboticstoolbox")
    model = toolbox.models.DH.Puma560()
    arm = from_toolbox(model)
    for q in ([0.1, 0.5, 0.3, 0.2, 0.9, 0.6], [-0.7, 1.1, 0.6, -0.4, 0.8, 0.2]):
        goal = model.fkine(q)
        words = [a + b + c for a in "lr" for b in "ud" for c in "nf"]
        theirs = [model.ikine_a(goal, word) for word in words]
        ours = np.array([one.q for one in inverse(arm, goal.A).branches])
        assert len(ours) == sum(one.success for one in theirs) == 8
        for one in theirs:
            assert np.abs(np.angle(np.exp(1j * (ours - one.q)))).max(axis=1).min() < 1e-7
