"""The displacement of a task: its derivative, the way back for many configurations at once, and which rows it fits."""

from __future__ import annotations

import numpy as np
import pytest
from reference import arms
from reference.measure import central_differences

from rankdrop.errors import TaskError
from rankdrop.kinematics import pose, task_jacobian
from rankdrop.local.block import joint_scale
from rankdrop.local.orientation import WEAK, Displacement, determined_by_pose
from rankdrop.local.self_motions import REACHED, self_motion
from rankdrop.local.ways_out import distinct, escape
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot
from rankdrop.task import BASE, BODY, SPACE, TIP, WORLD_ALIGNED, Frame, resolve_task
from rankdrop.text.words import avoidable_words

WORDS = ["pose", "position", "orientation", "vx,vy,vz,wx,wy"]


@pytest.mark.parametrize("words", WORDS)
@pytest.mark.parametrize("frame", [WORLD_ALIGNED, BODY], ids=["world", "body"])
def test_at_the_start_the_derivative_is_the_task_jacobian(words: str, frame: Frame, rng: np.random.Generator) -> None:
    robot = arms.random_chain(rng, "rrprrrr")
    task = resolve_task(words, robot, frame=frame)
    q = rng.uniform(-1, 1, 7)
    where = Displacement(robot, q, task)
    assert np.abs(where.error(q)).max() < 1e-15
    scaled = task_jacobian(robot, q, task) * joint_scale(robot, task)
    found = where.derivative(q)
    if words == "pose":  # taken at the tip's origin, whatever the frame
        assert np.linalg.matrix_rank(np.concatenate([found, scaled]), tol=1e-9) == 6
    else:
        assert np.abs(found - scaled).max() < 1e-12


@pytest.mark.parametrize("words", WORDS)
def test_batches_are_what_each_of_their_members_is(words: str, rng: np.random.Generator) -> None:
    robot = arms.random_chain(rng, "rrprrrr")
    task = resolve_task(words, robot, frame=BODY)
    q = rng.uniform(-1, 1, 7)
    where = Displacement(robot, q, task)
    moved = q + 0.02 * rng.normal(size=(2, 3, 7))
    moved[1, 2] = q + 2.5  # hopeless, or elsewhere: the others must not mind
    error, slopes, (back, arrived) = where.error(moved), where.derivative(moved), where.back(moved)
    assert error.shape == (2, 3, task.m)
    assert back.shape == (2, 3, 7)
    assert arrived.reshape(-1)[:5].all()
    for i, j in np.ndindex(2, 3):
        alone, came = where.back(moved[i, j])
        assert np.abs(where.error(moved[i, j]) - error[i, j]).max() < 1e-14
        differences = central_differences(where.error, moved[i, j], 1e-3) * joint_scale(robot, task)
        assert np.abs(differences - slopes[i, j]).max() < 1e-6
        assert bool(came) == arrived[i, j]
        if came:
            assert np.abs(alone - back[i, j]).max() < 1e-12
            assert np.linalg.norm(where.error(back[i, j])) <= 1e-11


def test_those_that_come_back_do_not_mind_those_that_do_not(rng: np.random.Generator) -> None:
    robot = arms.random_chain(rng, "rrprrr")
    q = rng.uniform(-1, 1, 6)
    where = Displacement(robot, q, resolve_task(None, robot))
    far = q + rng.uniform(-20, 20, (300, 6))
    back, arrived = where.back(np.concatenate([far, q + 1e-3 * rng.normal(size=(5, 6))]))
    assert not arrived[:300].all()
    assert arrived[300:].all()
    assert np.abs(back[300:] - q).max() < 1e-9  # no redundancy: there is one way back
    assert np.linalg.norm(where.error(back[arrived]), axis=-1).max() <= 1e-11


def _back_step_by_step(where: Displacement, q: Array) -> Array:
    """What `Displacement.back` finds for one configuration (n,), by shortest steps in NumPy."""
    for _ in range(12):
        u, sigma, v = where.split(q)
        kept = np.flatnonzero(sigma > WEAK)
        step = -v[:, kept] @ (where.error(q) @ u[:, kept] / sigma[kept])
        length = np.linalg.norm(step)
        q = q + step * min(1.0, 0.5 / max(length, 1e-300)) * where.joints
        if length <= 1e-9:
            break
    return q


@pytest.mark.parametrize("kinds", arms.CHAINS)
def test_the_way_back_takes_shortest_steps(kinds: str, rng: np.random.Generator) -> None:
    robot = arms.random_chain(rng, kinds)
    q = rng.uniform(-1, 1, robot.n)
    for words, far in (("pose", 0.02), ("orientation", 0.3), ("position", 0.1)):
        where = Displacement(robot, q, resolve_task(words, robot, frame=BODY))
        starts = q + far * rng.normal(size=(9, robot.n)) * where.joints
        back, arrived = where.back(starts)
        for start, end in zip(starts[arrived], back[arrived], strict=True):
            assert np.abs(_back_step_by_step(where, start) - end).max() < 1e-10


@pytest.mark.parametrize("bent", [0.0, 1e-7, 1e-3], ids=["singular", "weak", "near"])
def test_the_way_back_to_a_singularity_takes_shortest_steps(bent: float, rng: np.random.Generator) -> None:
    robot = open_robot("pa10")
    q = np.array([0.1, 0.5, 0.7, bent, 0.9, 0.4, 0.2])
    where = Displacement(robot, q, resolve_task(None, robot))
    null = where.split(q)[2][:, 6:].T
    starts = q + 1e-2 * rng.normal(size=(9, 1)) * null + 1e-4 * bent * rng.normal(size=(9, 7))
    back, arrived = where.back(starts)
    assert arrived.all()
    for start, end in zip(starts, back, strict=True):
        assert np.abs(_back_step_by_step(where, start) - end).max() < 1e-9


def test_directions_that_differ_by_sign_or_rounding_are_one() -> None:
    vectors = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [1e-3, -1.0], [0.6, 0.8]])
    assert distinct(vectors, np.arange(5)) == [0, 2, 4]
    assert distinct(vectors, np.arange(5)[::-1]) == [4, 3, 1]


TOLD = [
    ("pose", Frame(2, 3), True), ("orientation", SPACE, True), ("position", Frame(3, TIP), True),
    ("position", SPACE, False), ("vx", WORLD_ALIGNED, True), ("vx", BODY, False), ("vx", Frame(2, TIP), False),
    ("wx,wy", BODY, True), ("vx,vy,vz,wx", BODY, True), ("vx,vy,wx", BODY, False),
]  # fmt: skip


@pytest.mark.parametrize(("words", "frame", "expected"), TOLD)
def test_rows_that_say_where_the_arm_is(words: str, frame: Frame, expected: bool) -> None:
    robot = open_robot("pa10")
    task = resolve_task(words, robot, frame=frame)
    assert determined_by_pose(task) is expected
    found = escape(robot, [0.1, 0.5, 0.7, 0.2, 0.9, 0.4, 0.2], task)
    assert ("not looked for" in avoidable_words(found)) is not expected
    assert (found.still is not None) is expected


def test_an_orientation_stands_still_at_any_point_and_a_position_does_not() -> None:
    robot = open_robot("pa10")
    q = np.array([0.1, 0.5, 0.7, 0.2, 0.9, 0.4, 0.2])
    traced = self_motion(robot, q, resolve_task("orientation", robot, frame=SPACE), length=0.5, limits=False)
    assert traced.ended == REACHED
    turned = pose(robot, traced.q)[..., :3, :3]
    assert np.abs(turned - turned[0]).max() < 1e-10
    with pytest.raises(TaskError):
        Displacement(robot, q, resolve_task("position", robot, frame=Frame(BASE, BASE)))
