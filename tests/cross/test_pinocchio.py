"""Real files through rankdrop and through Pinocchio: poses, Jacobians, their rates and singular values agree to 1e-12.

Needs the extra "cross" (`pip install ".[cross,test]"`: Pinocchio and two packages of robot descriptions). Without it
these tests are skipped and `pytest -rs` says so.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pinocchio", reason='the extra "cross" is not installed')
pytest.importorskip("rtbdata", reason='the extra "cross" is not installed')
pytest.importorskip("xacrodoc", reason='the extra "cross" is not installed')

import pinocchio as pin
import xacrodoc
from reference.measure import relative

from cross.pinocchio_arm import PinocchioArm
from cross.real_files import FILES, XACROS, RealFile
from rankdrop.kinematics import jacobian, jacobian_derivative, pose
from rankdrop.local.block import singular_values
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import BODY, SPACE, WORLD_ALIGNED, Frame, resolve_task

TOLERANCE = 1e-12
REFERENCES = {"LOCAL": BODY, "LOCAL_WORLD_ALIGNED": WORLD_ALIGNED, "WORLD": SPACE}


@cache
def arm(name: str) -> tuple[Robot, PinocchioArm]:
    """The arm read by rankdrop and by Pinocchio from the same file."""
    file = FILES[name]
    robot = open_robot(file.path, tip=file.tip, as_written=True)
    return robot, PinocchioArm(pin.buildModelFromUrdf(str(file.path)), robot)


def sample(robot: Robot, rng: np.random.Generator) -> Array:
    """Configurations of every kind: q = 0, right angles (singular on most arms), a straight elbow, generic ones."""
    q = rng.uniform(-np.pi, np.pi, (40, robot.n))
    q[0] = 0.0
    q[1:10] = rng.choice([0.0, np.pi / 2, -np.pi / 2, np.pi], (9, robot.n))
    q[10:20, robot.n // 2] = 0.0
    return q


@pytest.mark.parametrize("name", FILES)
def test_the_chain_is_the_arm(name: str) -> None:
    robot, _ = arm(name)
    assert (robot.n, robot.tip) == (FILES[name].n, FILES[name].tip)


@pytest.mark.parametrize("name", FILES)
def test_pose(name: str, rng: np.random.Generator) -> None:
    robot, other = arm(name)
    q = sample(robot, rng)
    assert relative(pose(robot, q), np.stack([other.pose(row) for row in q])) < TOLERANCE


@pytest.mark.parametrize("reference", REFERENCES)
@pytest.mark.parametrize("name", FILES)
def test_jacobian_in_the_three_frames_of_pinocchio(name: str, reference: str, rng: np.random.Generator) -> None:
    robot, other = arm(name)
    q = sample(robot, rng)
    want = np.stack([other.jacobian(row, getattr(pin, reference)) for row in q])
    assert relative(jacobian(robot, q, REFERENCES[reference]), want) < TOLERANCE


@pytest.mark.parametrize("reference", REFERENCES)
@pytest.mark.parametrize("name", FILES)
def test_rate_of_the_jacobian(name: str, reference: str, rng: np.random.Generator) -> None:
    robot, other = arm(name)
    q, rate = sample(robot, rng), rng.normal(size=(40, robot.n))
    want = np.stack([other.jacobian_rate(*row, getattr(pin, reference)) for row in zip(q, rate, strict=True)])
    got = (jacobian_derivative(robot, q, REFERENCES[reference]) @ rate[:, None, :, None])[..., 0]
    assert relative(got, want) < TOLERANCE


@pytest.mark.parametrize("name", FILES)
def test_jacobian_of_every_link_on_the_way(name: str, rng: np.random.Generator) -> None:
    """`Joint.frame` is the URDF child link, whose frame at q is the joint's frame in Pinocchio."""
    robot, other = arm(name)
    q = sample(robot, rng)
    for link in range(1, robot.n + 1):
        want = np.stack([other.joint_jacobian(row, link) for row in q])
        assert relative(jacobian(robot, q, Frame(link, link))[..., :link], want) < TOLERANCE


@pytest.mark.parametrize("name", FILES)
def test_singular_values(name: str, rng: np.random.Generator) -> None:
    """With lengths in metres: numpy's singular values of Pinocchio's Jacobian against the core's."""
    robot, other = arm(name)
    q = sample(robot, rng)
    want = np.linalg.svd(np.stack([other.jacobian(row, pin.LOCAL_WORLD_ALIGNED) for row in q]), compute_uv=False)
    got = singular_values(robot, q, resolve_task("pose", robot, length_scale=1.0))
    assert np.abs(got - want).max() < TOLERANCE


@pytest.mark.parametrize("name", XACROS)
def test_a_xacro_is_the_arm_that_it_expands_to(name: str, tmp_path: Path, rng: np.random.Generator) -> None:
    file = XACROS[name]
    robot = open_robot(file.path, tip=file.tip, packages=file.packages, as_written=True)
    expanded = tmp_path / "expanded.urdf"
    expanded.write_text(expand(file), encoding="utf-8")
    other = PinocchioArm(pin.buildModelFromUrdf(str(expanded)), robot)
    q = sample(robot, rng)
    assert robot.n == file.n
    want = np.stack([other.jacobian(row, pin.LOCAL_WORLD_ALIGNED) for row in q])
    assert relative(pose(robot, q), np.stack([other.pose(row) for row in q])) < TOLERANCE
    assert relative(jacobian(robot, q), want) < TOLERANCE
    sigma = singular_values(robot, q, resolve_task("pose", robot, length_scale=1.0))
    assert np.abs(sigma - np.linalg.svd(want, compute_uv=False)).max() < TOLERANCE


def expand(file: RealFile) -> str:
    """The URDF that xacrodoc makes of a xacro file."""
    xacrodoc.packages.update_package_cache({name: str(folder) for name, folder in file.packages.items()})
    return str(xacrodoc.XacroDoc.from_file(str(file.path), resolve_packages=False).to_urdf_string())
