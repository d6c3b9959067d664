"""Planted sparse bases come back, whatever basis of their span is handed in; the core chooses as the oracle does."""

from __future__ import annotations

import numpy as np
import pytest
from reference.readable import entries, random_rotation
from reference.readable import readable_basis as plain

from rankdrop.local.directions import readable_bases, readable_basis
from rankdrop.robot.model import Array

EACH = 120  # planted bases of each size: 600 in all


def block_columns(rng: np.random.Generator, count: int) -> Array:
    """One column out of each of `count` rotation blocks of sizes that fill up to six rows, rows permuted."""
    sizes = np.ones(count, dtype=int)
    for _ in range(rng.integers(0, 7 - count)):
        sizes[rng.integers(count)] += 1
    basis, row = np.zeros((6, count)), 0
    for column, size in enumerate(sizes):
        while True:
            entry = random_rotation(rng, size)[:, 0]
            if np.abs(entry).min() > 0.05:
                break
        basis[row : row + size, column] = entry
        row += size
    return basis[rng.permutation(6)]


def chained(rng: np.random.Generator, count: int) -> Array:
    """Columns of a product of plane rotations that share rows, by 45° half of the time: ties are common."""
    basis = np.eye(6)
    for _ in range(rng.integers(1, 4)):
        i, j = rng.permutation(6)[:2]
        angle = rng.choice([np.pi / 4, rng.uniform(0.2, 1.3)])
        turn = np.eye(6)
        turn[[i, i, j, j], [i, j, i, j]] = np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)
        basis = turn @ basis
    return basis[:, rng.permutation(6)[:count]]


def same_columns(found: Array, planted: Array) -> bool:
    """Equal up to sign and order."""
    return bool(np.allclose(np.sort(np.abs(found.T @ planted), axis=1)[:, -1], 1.0, atol=1e-9))


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5])
def test_every_planted_basis_is_recovered_from_three_random_inputs(count: int, rng: np.random.Generator) -> None:
    for trial in range(EACH):
        planted = block_columns(rng, count)
        found = [readable_basis(planted @ random_rotation(rng, count)) for _ in range(3)]
        assert same_columns(found[0], planted), (trial, planted)
        assert max(np.abs(other - found[0]).max() for other in found[1:]) < 1e-9


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5])
def test_no_chained_basis_is_sparser_than_the_one_found_and_the_input_does_not_matter(
    count: int, rng: np.random.Generator
) -> None:
    for _ in range(EACH):
        planted = chained(rng, count)
        found = [readable_basis(planted @ random_rotation(rng, count)) for _ in range(3)]
        assert entries(found[0]) <= entries(planted)
        assert max(np.abs(other - found[0]).max() for other in found[1:]) < 1e-9


@pytest.mark.parametrize("count", [2, 3, 4, 5])
def test_tied_optima_are_chosen_alike_from_every_input(count: int, rng: np.random.Generator) -> None:
    """The hyperplanes normal to (1, …, 1) have as many sparsest bases as rows can be permuted."""
    normal = np.zeros(6)
    normal[: count + 1] = 1.0
    tied = np.linalg.svd(normal[None, : count + 1])[2][1:].T
    basis = np.vstack([tied, np.zeros((5 - count, count))])
    want = readable_basis(basis)
    assert entries(want) < basis.size
    for _ in range(40):
        assert np.abs(readable_basis(basis @ random_rotation(rng, count)) - want).max() < 1e-9


@pytest.mark.by_hand
@pytest.mark.slow_at("generic-5-3")
@pytest.mark.parametrize(("count", "trials"), [(1, 60), (2, 60), (3, 30), (4, 8), (5, 3)])
@pytest.mark.parametrize("kind", ["generic", "chained", "blocks"])
def test_the_core_chooses_what_the_plain_search_chooses(
    count: int, trials: int, kind: str, rng: np.random.Generator
) -> None:
    make = {"generic": lambda: random_rotation(rng, 6)[:, :count], "chained": lambda: chained(rng, count),
            "blocks": lambda: block_columns(rng, count)}[kind]  # fmt: skip
    bases = np.stack([make() @ random_rotation(rng, count) for _ in range(trials)])
    want = np.stack([plain(basis) for basis in bases])
    assert np.abs(readable_bases(bases) - want).max() < 1e-9


@pytest.mark.parametrize(("rows", "count"), [(3, 2), (4, 4), (8, 3), (9, 2)])
def test_other_numbers_of_rows_are_served_too(rows: int, count: int, rng: np.random.Generator) -> None:
    basis = random_rotation(rng, rows)[:, :count]
    assert np.abs(readable_basis(basis) - plain(basis)).max() < 1e-9


def test_the_best_of_a_plane_is_the_best_of_all_angles(rng: np.random.Generator) -> None:
    """k = 2 is exact: no angle of a fine grid gives a smaller sum (all have as many entries in a generic plane)."""
    angles = np.linspace(0.0, np.pi, 2001)
    for _ in range(20):
        basis = random_rotation(rng, 6)[:, :2]
        c, s = np.cos(angles), np.sin(angles)
        turned = basis @ np.array([[c, -s], [s, c]]).transpose(2, 0, 1)
        assert np.abs(readable_basis(basis)).sum() <= np.abs(turned).sum(axis=(1, 2)).min() + 1e-9


def test_many_subspaces_at_once_are_each_as_alone(rng: np.random.Generator) -> None:
    bases = np.stack([random_rotation(rng, 6)[:, :3] for _ in range(9)])
    assert np.abs(readable_bases(bases) - np.stack([readable_basis(basis) for basis in bases])).max() < 1e-12
    assert readable_bases(np.zeros((0, 6, 2))).shape == (0, 6, 2)
