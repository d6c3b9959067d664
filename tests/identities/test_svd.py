"""Singular values of the core against mpmath: wrong by at most 4·eps·‖J‖, at exactly singular matrices above all.

The default sample is small. All 12 000 matrices: `pytest -m slow tests/identities/test_svd.py`.
"""

from __future__ import annotations

import numpy as np
import pytest
from reference import arms, kinematics, mp

from rankdrop import _core
from rankdrop.robot.model import Array

EPS = float(np.finfo(float).eps)


def generic(rng: np.random.Generator, count: int) -> Array:
    """(count, 6, 7) Jacobians of the PA-10 at random configurations, every fourth within 1e-7 of a singular one."""
    robot, q = arms.singular_configurations("pa10", rng, count)
    near = np.arange(count) % 4 == 0
    spread = np.where(near, 1e-7, 10.0)[:, None]
    return kinematics.jacobian(robot, q + spread * rng.normal(size=q.shape))


def singular(rng: np.random.Generator, count: int) -> Array:
    """(count, 6, 7) Jacobians of the PA-10 at exactly singular configurations, coranks 1 to 3."""
    robot, q = arms.singular_configurations("pa10", rng, count)
    return kinematics.jacobian(robot, q)


def integer(rng: np.random.Generator, count: int, rank: int, m: int = 6, n: int = 7) -> Array:
    """(count, m, n) products of integer matrices: of rank ≤ `rank` exactly, no rounding at all."""
    product = rng.integers(-9, 10, (count, m, rank)) @ rng.integers(-9, 10, (count, rank, n))
    return product.astype(float)


def graded(rng: np.random.Generator, count: int) -> Array:
    """(count, 6, 7) random matrices whose columns fall over twelve decades."""
    return rng.normal(size=(count, 6, 7)) * 10.0 ** rng.uniform(-12, 0, (count, 1, 7))


def matrices(rng: np.random.Generator, count: int) -> Array:
    """A third exactly singular Jacobians, a third generic ones, the rest integer products and graded columns."""
    third, rest = count // 3, count - 2 * (count // 3)
    whole = [integer(rng, rest // 10, rank) for rank in (1, 2, 3, 4, 5)]
    last = graded(rng, rest - 5 * (rest // 10))
    return np.concatenate([singular(rng, third), generic(rng, third), *whole, last])


def worst_error(batch: Array) -> float:
    """Largest error of a singular value, in units of eps·‖J‖."""
    got = _core.svd(batch)[1]
    truth = np.stack([mp.singular_values(matrix) for matrix in batch])
    return float((np.abs(got - truth).max(axis=-1) / (EPS * np.maximum(truth[:, 0], 1e-300))).max())


@pytest.mark.by_hand
def test_error_of_600_singular_values_against_mpmath(rng: np.random.Generator) -> None:
    assert worst_error(matrices(rng, 600)) <= 4.0


@pytest.mark.by_hand
def test_error_of_12000_singular_values_against_mpmath(rng: np.random.Generator) -> None:
    assert worst_error(matrices(rng, 12_000)) <= 4.0


SHAPES = [(1, 1), (2, 1), (2, 2), (3, 4), (3, 7), (4, 4), (6, 3), (6, 4), (6, 6), (6, 8), (6, 12)]


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_every_shape(shape: tuple[int, int], rng: np.random.Generator) -> None:
    batch = np.concatenate([rng.normal(size=(10, *shape)), integer(rng, 10, 1, *shape), np.zeros((1, *shape))])
    assert worst_error(batch) <= 4.0
    u, s, v = _core.svd(batch)
    short = min(shape)
    assert u.shape == (21, shape[0], shape[0])
    assert s.shape == (21, short)
    assert v.shape == (21, shape[1], shape[1])
    for basis in (u, v):
        assert np.abs(np.swapaxes(basis, -1, -2) @ basis - np.eye(basis.shape[-1])).max() < 16 * EPS
    again = (u[..., :short] * s[:, None, :]) @ np.swapaxes(v[..., :short], -1, -2)
    assert np.abs(again - batch).max() <= 16 * EPS * np.abs(batch).max()


def test_exact_zeros_stay_below_the_error_bound(rng: np.random.Generator) -> None:
    """Integer products of rank r: every σ after the r-th is zero in truth."""
    for rank in (1, 2, 3, 4, 5):
        s = _core.svd(integer(rng, 500, rank))[1]
        assert (s[:, rank:] <= 4 * EPS * s[:, :1]).all()


def test_equal_singular_values_and_zero_matrices(rng: np.random.Generator) -> None:
    turn = np.linalg.qr(rng.normal(size=(50, 7, 7)))[0][:, :6]
    assert np.abs(_core.svd(turn)[1] - 1.0).max() <= 4 * EPS * 2
    u, s, v = _core.svd(np.zeros((3, 6, 7)))
    assert (s == 0).all()
    assert np.abs(np.swapaxes(u, -1, -2) @ u - np.eye(6)).max() < 4 * EPS
    assert np.abs(np.swapaxes(v, -1, -2) @ v - np.eye(7)).max() < 4 * EPS


@pytest.mark.parametrize("size", [1e-60, 1e-20, 1e20, 1e60])
def test_size_of_the_matrix_does_not_matter(size: float, rng: np.random.Generator) -> None:
    batch = matrices(rng, 60)
    small = _core.svd(batch)[1]
    assert (np.abs(_core.svd(batch * size)[1] / size - small) <= 8 * EPS * small[:, :1]).all()


def test_the_same_bits_alone_and_in_a_batch_of_any_length(rng: np.random.Generator) -> None:
    batch = matrices(rng, 33)
    together = _core.svd(batch)
    for b in (0, 7, 16, 31, 32):
        for whole, alone in zip(together, _core.svd(batch[b : b + 1]), strict=True):
            np.testing.assert_array_equal(whole[b], alone[0])


def test_no_matrices_give_no_values() -> None:
    u, s, v = _core.svd(np.zeros((0, 6, 7)))
    assert (u.shape, s.shape, v.shape) == ((0, 6, 6), (0, 6), (0, 7, 7))
