"""Inverses: exact where nothing is lost, exact in what is not about to be lost, right at singular configurations."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from reference import arms

from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.kinematics import jacobian
from rankdrop.local.block import decompose, joint_scale, sample
from rankdrop.local.inverses import damped_inverse, factor, pseudo_inverse, selective_inverse
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import Task, resolve_task

ARMS = ["pa10", "panda", "fetch8", "ur5", "scara", "stanford", "rcrrrr", "planar2r", "planar3r", "almarkhi4"]
H = pi / 2


def si_jacobian(robot: Robot, q: Array, task: Task) -> Array:
    return jacobian(robot, q, task.frame)[..., list(task.rows), :]


def configurations(robot: Robot, task: Task) -> Array:
    """Generic ones, all zero (singular on most arms), and close to that."""
    zero = np.zeros((1, robot.n))
    return np.concatenate([sample(robot, task, 20, 5), zero, zero + 1e-5])


@pytest.mark.parametrize("task_name", [None, "pose", "position", "vx,wz"])
@pytest.mark.parametrize("name", ARMS)
def test_pseudo_inverse_obeys_the_four_conditions_in_scaled_coordinates(name: str, task_name: str | None) -> None:
    robot = open_robot(name)
    task = resolve_task(task_name, robot)
    q = configurations(robot, task)
    parts = factor(robot, q, task)
    j = parts.rows[:, None] * si_jacobian(robot, q, task) * parts.joints
    x = pseudo_inverse(robot, q, task) / parts.joints[:, None] / parts.rows
    size = np.abs(x).max(axis=(1, 2))
    sigma = decompose(robot, q, task).sigma
    dropped = np.where(sigma <= 1e-9, sigma, 0.0).max(axis=1)  # counts as zero, but is still in J
    assert (np.abs(j @ x @ j - j).max(axis=(1, 2)) < 1e-14 * (1 + size) + 2 * dropped).all()
    assert (np.abs(x @ j @ x - x).max(axis=(1, 2)) < 1e-13 * (1 + size) ** 2).all()
    for product in (j @ x, x @ j):
        assert (np.abs(product - product.swapaxes(1, 2)).max(axis=(1, 2)) < 1e-13 * (1 + size)).all()


@pytest.mark.parametrize("name", ["pa10", "ur5", "almarkhi4"])
def test_pseudo_inverse_is_numpys_at_full_rank_whatever_the_length(name: str) -> None:
    robot = open_robot(name)
    for length in (None, 1.0, 0.3):
        task = resolve_task(None, robot, length_scale=length)
        q = sample(robot, task, 20, 1)
        want = np.linalg.pinv(si_jacobian(robot, q, task))
        assert np.abs(pseudo_inverse(robot, q, task) - want).max() < 1e-10 * np.abs(want).max()


def test_pseudo_inverse_does_not_depend_on_the_unit_of_length() -> None:
    """An arm with a slide, drawn in millimetres: rates of turning joints stay, slides are 1000 times faster."""
    robot = open_robot("fetch8")
    large = _in_millimetres(robot)
    q = sample(robot, resolve_task(None, robot), 10, 2)
    stretch = np.where(joint_scale(robot, resolve_task(None, robot)) == 1.0, 1.0, 1000.0)
    twist = np.array([1000.0] * 3 + [1.0] * 3)
    found = pseudo_inverse(large, q * stretch) * twist / stretch[:, None]
    assert np.abs(found - pseudo_inverse(robot, q)).max() < 1e-9


def _in_millimetres(robot: Robot) -> Robot:
    def stretched(frame: Array) -> Array:
        return frame * np.array([[1, 1, 1, 1000.0]] * 3 + [[1, 1, 1, 1]])

    joints = []
    for joint in robot.joints:
        screw = joint.screw.copy()
        longer = 1000.0 if joint.kind.value == "prismatic" else 1.0
        if longer == 1.0:
            screw[:3] *= 1000.0
        lower, upper = joint.lower * longer, joint.upper * longer
        joints.append(replace(joint, screw=screw, frame=stretched(joint.frame), lower=lower, upper=upper))
    return replace(robot, joints=tuple(joints), home=stretched(robot.home))


LOST = [
    ("pa10", None, [0.3, 0.4, 0.5, 0.0, 0.2, 0.4, 1.0], 1),
    ("pa10", None, [0.3, 0.0, 0.0, 0.0, 0.2, 0.3, 1.0], 2),
    ("pa10", None, [0.0] * 7, 3),
    ("ur5", None, [0.1, -0.5, 0.6, 0.3, 0.0, 0.2], 1),
    ("scara", None, [0.3, 0.0, 0.1, 0.2], 1),
    ("scara", "pose", [0.3, 0.0, 0.1, 0.2], 1),
    ("planar3r", None, [0.3, pi, 0.1], 1),
    ("planar2r", None, [0.3, 0.0], 1),
    ("almarkhi4", "pose", [0.3, 0.2, 0.4, 0.1], 0),
]


@pytest.mark.parametrize("drop", [False, True])
@pytest.mark.parametrize("off", [0.0, 1e-8, 1e-4, 1e-2])
@pytest.mark.parametrize(("name", "task_name", "q", "corank"), LOST)
def test_selective_inverse_follows_exactly_what_is_not_about_to_be_lost(
    name: str, task_name: str | None, q: list[float], corank: int, off: float, drop: bool
) -> None:
    robot = open_robot(name)
    task = resolve_task(task_name, robot)
    near = np.array(q) + off * np.random.default_rng(3).normal(size=robot.n)
    threshold = 0.03
    parts = factor(robot, near, task)
    strong = int((parts.sigma >= threshold).sum())
    assert strong > 0
    if corank:
        assert strong < parts.sigma.size
    inverse = selective_inverse(robot, near, task, threshold=threshold, drop=drop)
    error = parts.rows[:, None] * (si_jacobian(robot, near, task) @ inverse - np.eye(task.m))
    assert np.abs(parts.u[:, :strong].T @ error).max() < 1e-12
    lengths = np.linalg.norm(inverse / parts.joints[:, None] / parts.rows, 2)
    assert lengths <= 2 / (3**0.5 * threshold) * (1 + 1e-9), "gains are bounded"


def test_constant_damping_is_the_textbook_formula() -> None:
    robot = open_robot("pa10")
    task = resolve_task(None, robot)
    for q in ([0.0] * 7, [0.3, 0.5, 0.2, 0.9, 0.2, 0.7, 1.0]):
        parts = factor(robot, q, task)
        j = parts.rows[:, None] * si_jacobian(robot, np.array(q), task)
        want = j.T @ np.linalg.inv(j @ j.T + 0.01 * np.eye(6)) * parts.rows
        assert np.abs(damped_inverse(robot, q, task, damping=0.1) - want).max() < 1e-12


def test_variable_damping_vanishes_away_from_singularities_and_not_before() -> None:
    robot = open_robot("pa10")
    far, near = [0.3, 0.5, 0.2, 0.9, 0.2, 0.7, 1.0], [0.3, 0.5, 0.2, 0.01, 0.2, 0.7, 1.0]
    kept = damped_inverse(robot, far, damping=0.05, threshold=0.01)
    assert np.abs(kept - pseudo_inverse(robot, far)).max() < 1e-12
    assert np.linalg.norm(damped_inverse(robot, near, damping=0.05, threshold=0.01)) < 40
    assert np.linalg.norm(pseudo_inverse(robot, near)) > 400


def test_variable_damping_of_an_arm_that_is_always_singular_looks_at_its_generic_rank() -> None:
    scara = open_robot("scara")
    q = [0.3, 1.2, 0.1, 0.2]
    found = damped_inverse(scara, q, "pose", damping=0.05, threshold=0.01)
    assert np.abs(found - pseudo_inverse(scara, q, "pose")).max() < 1e-12


@pytest.mark.parametrize("kinds", [*arms.CHAINS])
def test_batches_are_rows_and_shapes_hold_for_every_chain(kinds: str) -> None:
    robot = arms.random_chain(np.random.default_rng(7), kinds)
    q = sample(robot, resolve_task("pose", robot), 6, 1).reshape(2, 3, -1)
    for function in (pseudo_inverse, damped_inverse, selective_inverse):
        found = function(robot, q)
        assert found.shape == (2, 3, robot.n, 6)
        assert np.abs(found[1, 2] - function(robot, q[1, 2])).max() < 1e-12 * max(1.0, np.abs(found).max())
        assert function(robot, np.zeros((0, robot.n))).shape == (0, robot.n, 6)


def test_the_gains_are_continuous_at_the_threshold() -> None:
    robot = open_robot("pa10")
    q = np.array([0.3, 0.5, 0.2, 0.05, 0.2, 0.7, 1.0])
    sigma = float(decompose(robot, q, resolve_task(None, robot)).sigma[-1])
    below = selective_inverse(robot, q, threshold=sigma * (1 + 1e-9))
    above = selective_inverse(robot, q, threshold=sigma * (1 - 1e-9))
    assert np.abs(below - above).max() < 1e-5 * np.abs(above).max()


def test_options_are_refused() -> None:
    robot = open_robot("planar2r")
    with pytest.raises(OptionError, match="threshold"):
        selective_inverse(robot, [0.0, 0.0], threshold=0.0)
    with pytest.raises(OptionError, match="damping"):
        damped_inverse(robot, [0.0, 0.0], damping=-1.0)
    with pytest.raises(ConfigurationError):
        pseudo_inverse(robot, [0.0, np.nan])


def test_nothing_is_damped_at_or_above_the_threshold() -> None:
    robot = open_robot("pa10")
    q = [0.3, 0.5, 0.2, 0.05, 0.2, 0.7, 1.0]
    sigma = float(decompose(robot, q, resolve_task(None, robot)).sigma[-1])
    exact = pseudo_inverse(robot, q)
    for inverse in (
        selective_inverse(robot, q, threshold=sigma * (1 - 1e-9)),
        damped_inverse(robot, q, threshold=sigma * (1 - 1e-9)),
    ):
        assert np.abs(inverse - exact).max() < 1e-12 * np.abs(exact).max()


def test_rows_that_never_move_do_not_damp_for_ever() -> None:
    """Planar arm, all three translations: rank 2 of min(3, 3) everywhere."""
    robot = open_robot("planar3r")
    q = [0.3, 1.2, 0.4]
    found = damped_inverse(robot, q, "position", damping=0.05, threshold=0.01)
    assert np.abs(found - pseudo_inverse(robot, q, "position")).max() < 1e-12


@pytest.mark.parametrize("name", ["pa10", "puma", "scara", "planar3r"])
def test_pseudo_inverse_stays_small_at_exactly_singular_configurations(name: str) -> None:
    """Singular values that are rounding are not inverted: the norm is one over the smallest that is none."""
    robot, q = arms.singular_configurations(name, np.random.default_rng(8), 60)
    task = resolve_task(None, robot)
    parts = factor(robot, q, task)
    sigma = decompose(robot, q, task).sigma
    assert (sigma[:, -1] < 1e-12).all()
    smallest = np.where(sigma > 1e-9, sigma, np.inf).min(axis=1)
    norm = np.linalg.norm(pseudo_inverse(robot, q) / parts.joints[:, None] / parts.rows, 2, axis=(1, 2))
    if (parts.joints == 1.0).all():
        assert np.abs(norm * smallest - 1).max() < 1e-9
    assert norm.max() < 1e4
