"""A readable basis: AM's printed example, planted bases found again, nothing depends on the basis handed in."""

from __future__ import annotations

import numpy as np
import pytest
from reference.readable import entries, random_rotation

from rankdrop.errors import OptionError
from rankdrop.local.directions import readable_basis
from rankdrop.robot.model import Array

AM_BEFORE = np.array(
    [
        [0, 0, 0],
        [-0.27, 0.62, -0.61],
        [0.74, -0.17, -0.5],
        [-0.5, -0.71, -0.5],
        [-0.33, 0.08, 0.23],
        [-0.12, 0.28, -0.27],
    ]
)
AM_AFTER = np.array([[0, 0, 0], [0, -0.91, 0], [0, 0, 0.91], [-1, 0, 0], [0, 0, -0.41], [0, -0.41, 0]])


def planted_apart(rng: np.random.Generator, count: int) -> Array:
    """Unit columns, no two with an entry in the same row."""
    rows = rng.permutation(6)[: rng.integers(count, 7)]
    basis = np.zeros((6, count))
    for column, chosen in enumerate(np.array_split(rows, count)):
        basis[chosen, column] = rng.uniform(0.2, 1.0, len(chosen)) * rng.choice([-1, 1], len(chosen))
    return np.asarray(basis / np.linalg.norm(basis, axis=0))


def planted_overlapping(rng: np.random.Generator, count: int) -> Array:
    """Columns of a product of a few plane rotations of space."""
    basis = np.eye(6)
    for _ in range(rng.integers(1, 4)):
        i, j = rng.permutation(6)[:2]
        angle = rng.uniform(0.2, 1.3)
        turn = np.eye(6)
        turn[[i, i, j, j], [i, j, i, j]] = np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)
        basis = turn @ basis
    return basis[:, rng.permutation(6)[:count]]


def same_up_to_sign_and_order(a: Array, b: Array) -> bool:
    overlap = np.abs(a.T @ b)
    return bool(np.allclose(np.sort(overlap, axis=1)[:, -1], 1.0, atol=1e-9) and overlap.sum() < a.shape[1] + 1e-6)


def test_the_example_of_am_section_2_3_is_reproduced_to_its_rounding() -> None:
    basis = readable_basis(AM_BEFORE)
    overlap = basis.T @ (AM_AFTER / np.linalg.norm(AM_AFTER, axis=0))
    order = np.argmax(np.abs(overlap), axis=1)
    assert sorted(order) == [0, 1, 2]
    printed = AM_AFTER[:, order] * np.sign(overlap[np.arange(3), order])
    assert np.abs(basis - printed).max() < 0.0065


@pytest.mark.slow
def test_planted_bases_are_found_again_in_1000_random_rotations(rng: np.random.Generator) -> None:
    for trial in range(1000):
        planted = planted_apart(rng, 1 + trial % 3)
        found = readable_basis(planted @ random_rotation(rng, planted.shape[1]))
        assert same_up_to_sign_and_order(found, planted), (trial, planted, found)


@pytest.mark.parametrize("count", [2, 3, 4, 5])
def test_a_planted_basis_never_has_fewer_entries_than_the_one_found(count: int, rng: np.random.Generator) -> None:
    for _ in range(300 // count**2):
        planted = planted_overlapping(rng, count)
        assert entries(readable_basis(planted @ random_rotation(rng, count))) <= entries(planted)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 6])
def test_the_result_depends_on_the_subspace_only(count: int, rng: np.random.Generator) -> None:
    for _ in range(10):
        basis = np.linalg.qr(rng.normal(size=(6, count)))[0]
        mixed = basis @ rng.normal(size=(count, count))
        assert np.abs(readable_basis(basis) - readable_basis(mixed)).max() < 1e-7


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 6])
def test_columns_are_orthonormal_and_span_the_same(count: int, rng: np.random.Generator) -> None:
    given = rng.normal(size=(6, count))
    basis = readable_basis(given)
    assert np.abs(basis.T @ basis - np.eye(count)).max() < 1e-12
    assert np.abs(given - basis @ basis.T @ given).max() < 1e-12
    assert (basis.max(axis=0) == np.abs(basis).max(axis=0)).all(), "the largest entry is positive"


def test_tied_bases_are_told_apart_the_same_way_from_every_input(rng: np.random.Generator) -> None:
    tilted = np.array([[1.0, 1.0], [-1.0, 1.0], [0.0, -2.0]]) / np.sqrt([2.0, 6.0])  # the plane normal to (1, 1, 1)
    expected = readable_basis(tilted)
    for _ in range(50):
        assert np.abs(readable_basis(tilted @ random_rotation(rng, 2)) - expected).max() < 1e-9


def test_no_columns_give_no_columns() -> None:
    assert readable_basis(np.zeros((6, 0))).shape == (6, 0)


@pytest.mark.parametrize(
    "bad", [np.ones((6, 2)), np.ones(6), np.full((6, 1), np.nan), np.ones((2, 3)), np.zeros((6, 1))]
)
def test_dependent_or_broken_columns_are_refused(bad: Array) -> None:
    with pytest.raises(OptionError):
        readable_basis(bad)
