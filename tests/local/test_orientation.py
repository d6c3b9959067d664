"""Analytical Jacobians equal differences of the coordinates; their singularities are not the arm's."""

from __future__ import annotations

from functools import partial
from math import inf, pi

import numpy as np
import pytest
from reference import arms
from reference.measure import central_differences

from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.kinematics import jacobian, pose
from rankdrop.local.block import sample
from rankdrop.local.orientation import (
    EULER,
    MAIN,
    NAMES,
    analytical_jacobian,
    orientation_coordinates,
    rate_matrix,
    representation_at,
)
from rankdrop.robot.model import Array, Joint, JointKind, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

H = pi / 2


def about(axis: str, angle: float) -> Array:
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    turn = np.eye(3)
    turn[i, i] = turn[j, j] = np.cos(angle)
    turn[i, j], turn[j, i] = -np.sin(angle), np.sin(angle)
    return turn


def rebuilt(c: Array, name: str) -> Array:
    """The rotation that the coordinates stand for, from their definition."""
    if name == "zyz":
        return about("z", c[0]) @ about("y", c[1]) @ about("z", c[2])
    if name == "rpy":
        return about("z", c[2]) @ about("y", c[1]) @ about("x", c[0])
    if name in EULER:
        return about(name[0], c[0]) @ about(name[1], c[1]) @ about(name[2], c[2])
    if name in ("rodrigues", "mrp"):
        square = float(c @ c)
        if name == "rodrigues":
            whole = np.array([1.0, *c]) / np.sqrt(1.0 + square)
        else:
            whole = np.array([1.0 - square, *(2.0 * c)]) / (1.0 + square)
        return rebuilt(whole, "quaternion")
    if name == "rotvec":
        angle = float(np.linalg.norm(c))
        w, v = np.cos(angle / 2), c / 2 * np.sinc(angle / (2 * pi))
    else:
        w, v = c[0], c[1:]
    hat = np.cross(np.eye(3), v)
    return np.eye(3) + 2 * w * hat + 2 * hat @ hat


def orientations() -> list[Array]:
    """Random ones, exact singularities of every representation, and the close neighbourhood of these."""
    rng = np.random.default_rng(1)
    found = [arms.rigid(rng)[:3, :3] for _ in range(40)]
    exact = [np.eye(3), *(about(axis, angle) for axis in "xyz" for angle in (H, pi, -H))]
    exact += [about("z", a) @ about("y", b) @ about("x", 0.7) for a in (0.3, -2.0) for b in (H, -H)]
    near = [turn @ about(axis, off) for turn in exact for axis in "xyz" for off in (1e-3, 1e-7, 1e-12)]
    return found + exact + near


@pytest.mark.parametrize("name", NAMES)
def test_coordinates_stand_for_the_orientation_everywhere(name: str) -> None:
    every = orientations()
    batch = orientation_coordinates(np.array(every), name)
    assert batch.shape == (len(every), len(NAMES[name]))
    for turn, coordinates in zip(every, batch, strict=True):
        if name == "rodrigues" and np.trace(turn) < -1 + 1e-5:  # half a turn, where they are infinite or all but that
            assert np.abs(coordinates).max() > 300
            continue
        # near a gimbal lock of 1e-12 one of the angles is left out, and its sine with it
        assert np.abs(rebuilt(coordinates, name) - turn).max() < 2e-9
    exact = [np.abs(rebuilt(c, name) - t).max() for c, t in zip(batch[:40], every[:40], strict=True)]
    assert max(exact) < 1e-14


@pytest.mark.spread(12)
@pytest.mark.by_hand_at("panda", "ur5")
@pytest.mark.slow
@pytest.mark.parametrize("robot_name", ["panda", "pa10", "ur5", "scara"])
@pytest.mark.parametrize("name", NAMES)
def test_analytical_jacobian_equals_differences(name: str, robot_name: str) -> None:
    robot = open_robot(robot_name)
    compared = 0
    for q in sample(robot, resolve_task("pose", robot), 20, 3):
        here = representation_at(robot, q).of(name)
        if here.singular or here.jump < 1e-9:  # SCARA's tool points down: half a turn, where coordinates jump
            continue
        h = min(1e-3, here.angle / 50, here.jump / 50)

        def coordinates(x: Array, centre: Array | None = None) -> Array:
            t = pose(robot, x)
            value = orientation_coordinates(t[:3, :3], name)
            if centre is not None and name in ("zyz", "rpy", *EULER):
                value -= 2 * pi * np.round((value - centre) / (2 * pi))
            return np.concatenate([t[:3, 3], value])

        centre = coordinates(q)[3:]
        want = central_differences(partial(coordinates, centre=centre), q, h)
        assert np.abs(analytical_jacobian(robot, q, name) - want).max() < 1e-11 / h / min(1.0, here.angle) ** 2
        compared += 1
    if name in MAIN:
        assert compared == (20 if robot_name != "scara" or name == "rpy" else 0)
    else:
        assert compared == 20 or robot_name == "scara"


@pytest.mark.parametrize("name", NAMES)
def test_determinant_and_sigma_are_those_of_the_matrix(name: str) -> None:
    robot = open_robot("panda")
    for q in sample(robot, resolve_task(None, robot), 20, 4):
        part = representation_at(robot, q).of(name)
        matrix = rate_matrix(part.coordinates, name)
        assert part.sigma_min == pytest.approx(np.linalg.svd(matrix, compute_uv=False)[-1])
        if name == "quaternion":
            assert part.sigma_min == pytest.approx(2.0)
            assert part.angle == inf
        else:
            assert part.determinant == pytest.approx(np.linalg.det(matrix), rel=1e-12, abs=1e-14)
        if name == "rotvec":
            assert part.sigma_min >= 2 / pi - 1e-12, "inside ‖φ‖ ≤ π it never gets smaller"
            assert part.angle >= pi


@pytest.mark.parametrize("name", ["zyz", "rpy", "xyx", "xyz", "zyx", "rodrigues"])
@pytest.mark.parametrize("off", [0.0, 1e-10, 1e-6, 1e-2, 0.3])
def test_angle_is_the_turn_that_is_missing(name: str, off: float) -> None:
    """One joint turning about Y through the singular orientation."""
    base = {"zyz": 0.0, "xyx": 0.0, "rodrigues": pi}.get(name, H)
    robot = revolute_about_y()
    part = representation_at(robot, [base + off]).of(name)
    assert part.angle == pytest.approx(off, abs=1e-15)
    lost = 1e-6 if name == "rodrigues" else 1e-10  # σ of Rodrigues parameters is 2 cos²(θ/2): it falls as the square
    assert part.singular == (off <= lost)
    assert part.near == (lost < off <= 0.1)


def revolute_about_y() -> Robot:
    return Robot("pan", (Joint("turn", JointKind.REVOLUTE, np.array([0, 0, 0, 0, 1.0, 0])),))


@pytest.mark.parametrize("name", NAMES)
def test_batches_and_wrong_names(name: str) -> None:
    robot = open_robot("ur5")
    q = sample(robot, resolve_task(None, robot), 6, 2).reshape(2, 3, 6)
    found = analytical_jacobian(robot, q, name)
    assert found.shape == (2, 3, 7 if name == "quaternion" else 6, 6)
    assert np.abs(found[1, 1] - analytical_jacobian(robot, q[1, 1], name)).max() < 1e-12
    assert np.abs(found[..., :3, :] - jacobian(robot, q)[..., :3, :]).max() == 0.0
    assert analytical_jacobian(robot, np.zeros((0, 6)), name).shape[0] == 0
    with pytest.raises(OptionError, match="no such representation"):
        analytical_jacobian(robot, q, "euler")


def test_at_a_gimbal_lock_one_angle_is_zero_by_convention() -> None:
    lock = about("z", 0.3) @ about("y", H) @ about("x", 0.7)
    roll, pitch, yaw = orientation_coordinates(lock, "rpy")
    assert (roll, pitch) == (0.0, pytest.approx(H))
    assert yaw == pytest.approx(0.3 - 0.7)
    alpha, beta, gamma = orientation_coordinates(about("z", 0.3) @ about("z", 0.4), "zyz")
    assert (alpha, beta, gamma) == (pytest.approx(0.7), 0.0, 0.0)


def test_rodrigues_parameters_are_infinite_at_half_a_turn_and_modified_ones_jump() -> None:
    half = representation_at(revolute_about_y(), [pi])
    assert half.of("rodrigues").singular
    assert half.of("rodrigues").coordinates[1] in (inf, -inf)
    assert (half.of("rodrigues").sigma_min, half.of("rodrigues").determinant) == (0.0, 0.0)
    assert not half.of("mrp").singular
    assert half.of("mrp").jump == pytest.approx(0.0, abs=1e-12)
    assert half.of("mrp").angle == pytest.approx(pi)
    with pytest.raises(ConfigurationError, match="rodrigues coordinates are singular"):
        analytical_jacobian(revolute_about_y(), [pi], "rodrigues")


def test_every_order_of_euler_angles_is_there() -> None:
    """Twelve: six in which the first axis comes back, six in which all three differ; rpy is zyx from the other end."""
    orders = {a + b + c for a in "xyz" for b in "xyz" for c in "xyz" if a != b != c}
    assert {"zyz", *EULER} == orders
    assert len(orders) == 12
    turn = about("z", 0.3) @ about("y", -0.4) @ about("x", 1.2)
    np.testing.assert_allclose(orientation_coordinates(turn, "zyx"), orientation_coordinates(turn, "rpy")[::-1])
