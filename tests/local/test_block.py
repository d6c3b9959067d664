"""The block U₂ᵀ J V₂: what it is, and that D is its derivative with U₂ and V₂ held."""

from __future__ import annotations

import numpy as np
import pytest
from reference import arms, kinematics
from reference import block as oracle
from reference.measure import central_differences, relative

from rankdrop.kinematics import task_jacobian
from rankdrop.local.block import block, decompose, singular_values
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task

CASES = [("pa10", "pose"), ("pa10", "position"), ("puma", "pose"), ("scara", "pose"), ("planar3r", "planar-position")]


def sample(name: str, rng: np.random.Generator) -> tuple[Robot, Array]:
    """Generic, exactly singular and nearly singular configurations."""
    robot, singular = arms.singular_configurations(name, rng, 9)
    near = singular + 1e-8 * rng.normal(size=singular.shape)
    return robot, np.concatenate([rng.uniform(-np.pi, np.pi, (6, robot.n)), singular, near])


@pytest.mark.parametrize(("name", "words"), CASES)
def test_a_task_may_be_its_name(name: str, words: str, rng: np.random.Generator) -> None:
    robot, q = sample(name, rng)
    task = resolve_task(words, robot)
    assert (singular_values(robot, q, words) == singular_values(robot, q, task)).all()
    assert (singular_values(robot, q) == singular_values(robot, q, robot.task)).all()
    assert (decompose(robot, q, words).u == decompose(robot, q, task).u).all()
    kept = min(task.m, robot.n) - 1
    assert (block(robot, q, words, kept).f == block(robot, q, task, kept).f).all()


@pytest.mark.parametrize(("name", "words"), CASES)
def test_decomposition_is_orthogonal_and_gives_the_jacobian_back(
    name: str, words: str, rng: np.random.Generator
) -> None:
    robot, q = sample(name, rng)
    task = resolve_task(words, robot)
    u, sigma, v = decompose(robot, q, task).u, decompose(robot, q, task).sigma, decompose(robot, q, task).v
    m, n, short = task.m, robot.n, min(task.m, robot.n)
    assert u.shape == (len(q), m, m)
    assert v.shape == (len(q), n, n)
    assert sigma.shape == (len(q), short)
    assert (sigma >= 0).all()
    assert (np.diff(sigma, axis=-1) <= 0).all()
    for basis in (u, v):
        gram = np.swapaxes(basis, -1, -2) @ basis
        assert np.abs(gram - np.eye(gram.shape[-1])).max() < 1e-14
    again = (u[..., :short] * sigma[:, None, :]) @ np.swapaxes(v[..., :short], -1, -2)
    assert relative(again, task_jacobian(robot, q, task)) < 1e-14
    assert relative(sigma, singular_values(robot, q, task)) < 1e-15
    assert relative(sigma, oracle.singular_values(robot, q, task)) < 1e-14


@pytest.mark.slow
@pytest.mark.parametrize(("name", "words"), CASES)
@pytest.mark.parametrize("corank", [1, 2, 3])
def test_d_is_the_derivative_of_the_block_with_its_bases_held(
    name: str, words: str, corank: int, rng: np.random.Generator
) -> None:
    robot, q = sample(name, rng)
    task = resolve_task(words, robot)
    rank = oracle.generic_rank(robot, task) - corank
    if rank < 0:
        pytest.skip(f"{name} has no corank {corank} at the task {words}")
    got = block(robot, q, task, rank)
    p, r = task.m - rank, robot.n - rank
    assert got.f.shape == (len(q), p, r)
    assert got.d.shape == (len(q), p, r, robot.n)
    assert got.u2.shape == (len(q), task.m, p)
    assert got.v2.shape == (len(q), robot.n, r)
    assert relative(got.f, held(robot, q, task, got.u2, got.v2)) < 1e-14
    assert relative(got.d, central_differences(lambda x: held(robot, x, task, got.u2, got.v2), q)) < 1e-10


def held(robot: Robot, q: Array, task: Task, u2: Array, v2: Array) -> Array:
    """U₂ᵀ J(q) V₂ for given bases."""
    return np.swapaxes(u2, -1, -2) @ kinematics.task_jacobian(robot, q, task) @ v2


@pytest.mark.parametrize(("name", "words"), CASES)
@pytest.mark.parametrize("corank", [1, 2])
def test_block_agrees_with_the_oracle_up_to_the_choice_of_bases(
    name: str, words: str, corank: int, rng: np.random.Generator
) -> None:
    """Where the block is apart from the rest, the singular values of D as a matrix do not depend on U₂ and V₂."""
    robot, q = sample(name, rng)
    q = q[:6]
    task = resolve_task(words, robot)
    rank = oracle.generic_rank(robot, task) - corank
    got, want = block(robot, q, task, rank), oracle.block(robot, q, task, rank)
    assert relative(got.sigma, want.sigma) < 1e-14
    for mine, theirs in ((got.u2, want.u2), (got.v2, want.v2)):
        assert relative(mine @ np.swapaxes(mine, -1, -2), theirs @ np.swapaxes(theirs, -1, -2)) < 1e-11
    flat = [np.linalg.svd(d.reshape(6, -1, robot.n), compute_uv=False) for d in (got.d, want.d)]
    assert relative(flat[0], flat[1]) < 1e-11


def test_gradient_of_a_singular_value_is_a_block_of_one(rng: np.random.Generator) -> None:
    """AM eq. 7: ∂σ_i/∂q_k = u_iᵀ (∂J/∂q_k) v_i. For σ_6, u is U₂ and v = V₂fᵀ/|f|, in whatever basis V₂ comes."""
    robot = arms.pa10()
    task = resolve_task("pose", robot)
    q = rng.uniform(-np.pi, np.pi, (20, 7))
    got = block(robot, q, task, 5)
    gradient = (got.f[:, 0, :, None] * got.d[:, 0]).sum(axis=1) / np.linalg.norm(got.f[:, 0], axis=-1)[:, None]
    numeric = central_differences(lambda x: singular_values(robot, x, task)[..., 5], q, h=1e-4)
    assert np.abs(gradient - numeric).max() < 1e-8


@pytest.mark.parametrize("shape", [(), (0,), (2, 3)], ids=str)
def test_leading_axes_are_kept(shape: tuple[int, ...], rng: np.random.Generator) -> None:
    robot = arms.pa10()
    task = resolve_task("pose", robot)
    q = rng.uniform(-np.pi, np.pi, (*shape, 7))
    assert singular_values(robot, q, task).shape == (*shape, 6)
    got = block(robot, q, task, 4)
    assert got.f.shape == (*shape, 2, 3)
    assert got.d.shape == (*shape, 2, 3, 7)
    assert decompose(robot, q, task).v.shape == (*shape, 7, 7)
