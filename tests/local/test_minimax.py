"""The step over a crease: what it promises, and what no step can better."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.local.minimax import largest, promised_step


def model(rng: np.random.Generator, pieces: int, k: int, count: int = 8) -> tuple[np.ndarray, np.ndarray]:
    """Values that nearly tie, and symmetric tensors."""
    values = 1.0 + rng.uniform(0.0, 0.05, (count, pieces, k))
    tensor = rng.normal(size=(count, pieces, k, k, 5))
    return values, tensor + tensor.swapaxes(2, 3)


def after(values: np.ndarray, tensor: np.ndarray, step: np.ndarray) -> np.ndarray:
    moved = values[..., None] * np.eye(values.shape[-1]) + np.einsum("bjacn,bn->bjac", tensor, step)
    return np.linalg.eigvalsh(moved).max(axis=(1, 2))


@pytest.mark.slow_at("1-6")
@pytest.mark.parametrize(("pieces", "k"), [(1, 1), (1, 2), (1, 3), (1, 6), (3, 1), (4, 2)])
def test_no_step_betters_what_is_promised_at_most(rng, pieces, k):
    values, tensor = model(rng, pieces, k)
    tau = rng.uniform(0.1, 1.0, len(values))
    move, fall, most, _ = promised_step(values, tensor, tau, effort=5000)
    np.testing.assert_allclose(fall, largest(values) - after(values, tensor, move), atol=1e-12)
    mine = fall - (move**2).sum(axis=1) / (2.0 * tau)
    assert (mine >= 0.9 * most - 1e-14).all()
    best = mine.copy()
    for size in (1e-3, 1e-2, 0.1, 1.0):
        for _ in range(300):
            step = (move if rng.integers(2) else 0.0) + size * rng.normal(size=move.shape)
            gain = largest(values) - after(values, tensor, step) - (step**2).sum(axis=1) / (2.0 * tau)
            best = np.maximum(best, gain)
    assert (best <= most + 1e-12).all()


@pytest.mark.parametrize(("pieces", "k"), [(1, 2), (3, 2)])
def test_the_mixture_is_positive_with_traces_that_sum_to_one(rng, pieces, k):
    values, tensor = model(rng, pieces, k)
    mixed = promised_step(values, tensor, np.ones(len(values)))[3]
    np.testing.assert_allclose(np.einsum("bjaa->b", mixed), 1.0, atol=1e-12)
    assert (np.linalg.eigvalsh(mixed) >= -1e-12).all()


def test_where_every_way_leads_up_nothing_is_promised():
    """Two values with opposite gradients: the crease is a minimum."""
    values, tensor = np.ones((1, 2, 1)), np.zeros((1, 2, 1, 1, 3))
    tensor[0, :, 0, 0, 1] = 1.0, -1.0
    move, _, most, _ = promised_step(values, tensor, np.ones(1))
    assert most[0] <= 1e-12
    np.testing.assert_allclose(move, 0.0, atol=1e-7)
    tensor[0, 1, 0, 0, 1] = 0.0  # now only one of them rises
    assert promised_step(values, tensor, np.ones(1))[2][0] <= 1e-12
    tensor[0, 1, 0, 0, 1] = 0.5  # both fall one way
    assert promised_step(values, tensor, np.ones(1))[1][0] > 0.2
