"""Second order and self-motions: types, boundary and avoidability, against inverse kinematics and traced curves."""

from __future__ import annotations

import numpy as np
import pytest
from reference import arms

from rankdrop.configuration import configuration_at
from rankdrop.families.searching import search
from rankdrop.kinematics import jacobian, pose, task_jacobian
from rankdrop.local import ways_out as still
from rankdrop.local.block import singular_values
from rankdrop.local.orientation import Displacement, determined_by_pose
from rankdrop.local.ways_out import Escape, definite, escape, forms, null_basis, trace, vanishing
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.text.words import PROOF, avoidable_words, boundary_words
from rankdrop.tolerances import DEFAULT

HALF = np.pi / 2
WRIST = [0.1, 0.5, 0.7, 0.3, 0, 0.4]


def sign_change(low: Array, high: Array) -> Array:
    """Between two configurations of the PUMA, where its determinant changes sign."""
    robot = open_robot("puma560")
    values = [np.linalg.det(jacobian(robot, q)) for q in (low, high)]
    assert values[0] * values[1] < 0
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if np.linalg.det(jacobian(robot, middle)) * values[0] > 0 else (low, middle)
    return middle


def puma_shoulder() -> Array:
    """Wrist centre above joint 1: the determinant changes sign in θ2."""
    low, high = (np.array([0.1, x, -0.6, 0.3, 0.8, 0.4]) for x in (0.9, 2.5))
    return sign_change(low, high)


def puma_elbow() -> Array:
    """tan θ3 = a3/d4 up to sign and half turns: the determinant changes sign in θ3."""
    low, high = (np.array([0.1, 0.5, x, 0.3, 0.8, 0.4]) for x in (-1.9, -1.2))
    return sign_change(low, high)


def test_puma_types_and_boundary() -> None:
    robot = open_robot("puma560")
    wrist, shoulder, elbow = (escape(robot, q) for q in (WRIST, puma_shoulder(), puma_elbow()))
    assert {joint.number for joint in elbow.single if joint.gain} == {3}
    assert {2, 3} <= {joint.number for joint in shoulder.single if joint.gain}
    assert [found.corank for found in (wrist, shoulder, elbow)] == [1, 1, 1]
    # the wrist centre cannot come nearer to axis 1 than the offset d3: with it the shoulder is an inner boundary
    assert [found.types[0].type for found in (wrist, shoulder, elbow)] == [2, 1, 1]
    assert [found.boundary for found in (wrist, shoulder, elbow)] == [None, True, True]
    assert [found.avoidable for found in (wrist, shoulder, elbow)] == [False, False, False]
    assert "(no proof)" in avoidable_words(wrist)
    assert avoidable_words(elbow) == "you cannot leave it with the tool held still"
    assert "is definite" in PROOF[elbow.avoidable_reason]
    assert "not decided" in boundary_words(wrist)


def test_a_shoulder_without_offset_is_left_by_internal_motion_only() -> None:
    """The wrist centre on axis 1: joint 1 and the wrist turn on the spot, and the lost direction stays lost."""
    robot = arms.standard_dh(
        "no offset",
        [(0, HALF, 0, 0), (0.43, 0, 0, 0), (0, -HALF, 0, 0), (0, HALF, 0.4, 0), (0, -HALF, 0, 0), (0, 0, 0.06, 0)],
    )
    q3 = 0.7
    q2 = float(np.arctan2(0.43 - 0.4 * np.sin(q3), 0.4 * np.cos(q3)))  # radial distance of the wrist centre is zero
    found = escape(robot, [0.1, q2, q3, 0.3, 0.8, 0.4])
    assert found.corank == 1
    assert {joint.number for joint in found.single if joint.gain} == {2, 3}
    assert found.types[0].type == 2
    assert found.boundary is None
    assert found.avoidable is False
    assert "not decided" in boundary_words(found)
    assert "(no proof)" in avoidable_words(found)


def reachable(robot: Robot, q: Array, lost: Array, size: float) -> bool:
    """Whether inverse kinematics near q finds the pose moved by `size` along a lost direction of the scaled task."""
    task = resolve_task(None, robot)
    displaced = Displacement(robot, np.asarray(q), task)
    goal = np.asarray(lost) * np.r_[np.full(3, task.scale(robot)), np.ones(3)]  # unit wrench to scaled task
    goal = size * goal / np.linalg.norm(goal)
    x = q + 0.05 * np.random.default_rng(0).normal(size=(60, robot.n))
    for _ in range(200):
        error = displaced.error(x) - goal
        jac = task_jacobian(robot, x, task)
        damp = 1e-3 * np.linalg.norm(error, axis=1)[:, None, None] * np.eye(6)
        step = np.swapaxes(jac, 1, 2) @ np.linalg.solve(jac @ np.swapaxes(jac, 1, 2) + damp, error[..., None])
        step = step[..., 0]
        x = x - step * np.minimum(1, 0.05 / np.maximum(np.linalg.norm(step, axis=1), 1e-300))[:, None]
    error = np.linalg.norm(displaced.error(x) - goal, axis=1)
    return bool(((error < 1e-9) & (np.linalg.norm(x - q, axis=1) < 0.5)).any())


BOUNDARY = [
    ("puma560", puma_elbow(), True),
    ("puma560", puma_shoulder(), True),
    ("anthropomorphic", np.array([0.1, 0.5, 0, 0.3, 0.4, 0.4]), True),
    ("pa10", np.array([0.1, 0.5, 0.7, 0, 0.9, 0.4, 0.2]), True),
    ("rcrrrr", np.zeros(7), True),
    ("pa10", np.array([0.1, 0, HALF, 0.8, 0.9, 0.4, 0.2]), False),
]


@pytest.mark.parametrize(("name", "q", "expected"), BOUNDARY)
def test_at_a_boundary_one_side_is_out_of_reach(name: str, q: Array, expected: bool) -> None:
    robot = open_robot(name)
    found = escape(robot, q)
    assert found.boundary is expected
    sides = [reachable(robot, q, np.array(found.types[0].direction), sign * 3e-4) for sign in (1.0, -1.0)]
    assert sides.count(True) == (1 if expected else 2)
    if expected:  # the side is the form's
        assert sides[0] == (found.types[0].form[-1] > 1e-6)


def test_the_form_is_twice_the_second_order_displacement() -> None:
    """u · e(q + tΔ) = ½ t² u · dJ(Δ)Δ, for the null motion Δ of a non-redundant arm."""
    robot = open_robot("anthropomorphic")
    q, task = np.array([0.1, 0.5, 0, 0.3, 0.4, 0.4]), resolve_task(None, robot)
    lost = escape(robot, q).types[0]
    delta = null_basis(configuration_at(robot, q, task, DEFAULT))[:, 0]
    u = np.array(lost.direction) * np.r_[np.full(3, task.scale(robot)), np.ones(3)]
    u /= np.linalg.norm(u)
    t = 1e-3
    ahead, back = Displacement(robot, q, task).error(q + np.array([[t], [-t]]) * delta) @ u
    assert (ahead + back) / t**2 == pytest.approx(lost.form[0], rel=1e-4)


def test_pa10_wrist_and_elbow_differ_in_what_a_self_motion_can_do() -> None:
    robot = open_robot("pa10")
    avoided = escape(robot, [0.1, 0, HALF, 0.8, 0.9, 0.4, 0.2])
    assert avoided.avoidable is True
    assert avoided.still is not None
    assert avoided.still.restores
    assert avoided.still.sigma_after > 1e-3
    assert np.linalg.norm(jacobian(robot, [0.1, 0, HALF, 0.8, 0.9, 0.4, 0.2]) @ avoided.still.delta) < 1e-12
    elbow = escape(robot, [0.1, 0.5, 0.7, 0, 0.9, 0.4, 0.2])
    assert elbow.still is None
    assert elbow.avoidable is False  # an extended arm can only turn about its own line
    assert "(no proof)" in avoidable_words(elbow)


@pytest.mark.by_hand
@pytest.mark.slow_at("rrrrrrr", "rrrrrrrr")
@pytest.mark.parametrize("kinds", ["rrrrrrr", "rrrrrrrr", "rrprrrr"])
def test_traced_self_motions_are_self_motions(kinds: str, rng: np.random.Generator) -> None:
    robot = arms.random_chain(rng, kinds)
    task = resolve_task(None, robot)
    seen = {True: 0, False: 0, None: 0}
    for q in search(robot, 1, starts=40, seed=2).converged[:30]:
        place = configuration_at(robot, q, task, DEFAULT)
        basis = null_basis(place)
        each = forms(place, basis)
        vectors, _ = vanishing(each, 0)
        found: Escape = escape(robot, q)
        seen[found.avoidable] += 1
        if definite(each, 0):
            assert len(vectors) == 0
            assert found.avoidable is False
            assert found.boundary is True
            random = rng.normal(size=(20, basis.shape[1])) @ basis.T
            random /= np.linalg.norm(random, axis=1, keepdims=True)
            assert determined_by_pose(place.task)
            assert not trace(place, random, 0.12)[3].any()
        if found.avoidable:
            assert found.still is not None
            assert determined_by_pose(place.task)
            tangent = np.array(found.still.delta) / place.scale
            path, _, _, valid = trace(place, tangent[None], 0.12)
            assert valid.all()
            assert np.abs(pose(robot, path[0]) - pose(robot, q)).max() < 1e-9
            assert np.linalg.norm((path[0, -1] - q) / place.scale) > 0.07
            assert singular_values(robot, path[0, -1], task)[5] == pytest.approx(found.still.sigma_after, rel=1e-6)
            first = singular_values(robot, path[0, 1], task)[5]
            assert first > 1e-6
    assert seen[True] + seen[False] >= 20
    assert seen[True] > 0


@pytest.mark.parametrize("words", ["position", "orientation", "vx,vy,vz,wx,wy"])
def test_self_motions_of_smaller_tasks_keep_the_task(words: str, rng: np.random.Generator) -> None:
    robot = arms.random_chain(rng, "rrrrrr")
    task = resolve_task(words, robot)
    q = rng.uniform(-1, 1, 6)
    place = configuration_at(robot, q, task, DEFAULT)
    assert place.corank == 0
    assert determined_by_pose(place.task)
    basis = null_basis(place)
    path, _, _, valid = trace(place, np.concatenate([basis.T, -basis.T]), 0.12)
    assert valid.all()
    if words != "orientation":
        assert np.abs(pose(robot, path)[..., :3, 3] - pose(robot, q)[:3, 3]).max() < 1e-9
    if words == "orientation":
        assert np.abs(pose(robot, path)[..., :3, :3] - pose(robot, q)[:3, :3]).max() < 1e-9


@pytest.mark.parametrize(
    ("diagonals", "few"),
    [([[1.0]], True), ([[1.0, -1.0]], True), ([[1, 1, 0]], True), ([[1, 0, 0]], False), ([[1, 1, -1]], False),
     ([[1.0, 0, -1], [0, 1.0, 0]], False)],
)  # fmt: skip
def test_when_all_tangents_of_self_motions_are_known(diagonals: list[list[float]], few: bool) -> None:
    assert still._few(np.array([np.diag(row) for row in diagonals], dtype=float)) is few
