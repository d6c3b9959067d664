"""A readable basis of a subspace in plain NumPy: what the core does, said once more, as the oracle."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import OptionError
from rankdrop.robot.model import Array

_TIE = 1e-6  # sums and entries closer than this are equal: far above rounding, far below two printed digits
_DEPENDENT = 1e-9  # columns of the input more dependent than this span nothing certain
_ROUNDING = 1e-13  # entries below this are zero: numbers of size 1 carry 1e-16 each
_SWEEPS = 50  # rounds over all planes; two or three are the rule
_SWEPT = 12  # starts that are swept


def readable_basis(B: ArrayLike) -> Array:
    """Orthonormal basis of span(B) with the fewest non-zero entries: see `rankdrop.local.directions`.

    Starts are bases that depend on the subspace only; for k ≥ 3 the most promising ones are swept, plane after plane.
    """
    columns = np.asarray(B, dtype=np.float64)
    if columns.ndim != 2 or not np.isfinite(columns).all():
        raise OptionError("a basis is a finite (m, k) matrix", got=columns.shape, allowed="shape (m, k), k ≤ m")
    rows, count = columns.shape
    if count == 0:
        return np.zeros((rows, 0))
    u, sigma, vt = np.linalg.svd(columns, full_matrices=False)
    if count > rows or sigma[-1] <= _DEPENDENT * sigma[0]:
        raise OptionError("the columns of a basis are independent", got=f"singular values {sigma.tolist()}")
    basis = u @ vt
    if count == rows:
        return np.eye(rows)
    starts = list(_starts(basis))
    swept = [] if count < 3 else [_sweep(start) for start in _most_promising(starts)]
    found = starts + swept
    if count > 2:
        fewest = min(_count(candidate) for candidate in found)
        found += [nested for nested in _nested(basis, fewest - 1) if _count(nested) < fewest]
    return _choose([_canonical(candidate) for candidate in found])


def _count(basis: Array) -> int:
    return int((np.abs(basis) > _TIE).sum())


def _nested(basis: Array, most: int) -> Iterator[Array]:
    """Bases of at most so many entries whose vectors, one after the other, vanish in as many rows as can be."""
    if basis.shape[1] == 2:
        yield from _plane_candidates(basis)
        return
    vectors = list(_vectors_with_zeros(basis))
    least = min(_count(vector) for vector in vectors)
    for first in vectors:
        if _count(first) + (basis.shape[1] - 1) * least <= most:
            for rest in _nested(_complement(basis, first), most - _count(first)):
                yield np.column_stack([first, rest])


def _starts(basis: Array) -> Iterator[Array]:
    """Bases that depend on the subspace only."""
    rows, count = basis.shape
    if count == 1:
        yield basis
        return
    if count == 2:
        yield from _plane_candidates(basis)
        return
    for chosen in combinations(range(rows), count):
        # the projector's columns belong to the subspace, not to its basis
        u, sigma, vt = np.linalg.svd(basis @ basis[list(chosen)].T, full_matrices=False)
        if sigma[-1] > 1e-3:
            yield u @ vt
    for first in _vectors_with_zeros(basis):
        yield np.column_stack([first, _greedy(_complement(basis, first))])


def _most_promising(starts: list[Array]) -> list[Array]:
    """The starts with the smallest sums (rounded, so that order decides among equals and not rounding)."""
    return sorted(starts, key=lambda start: round(float(np.abs(start).sum()), 9))[:_SWEPT]


def _greedy(basis: Array) -> Array:
    """Split off the vector with the smallest sum again and again; exact in the last plane."""
    if basis.shape[1] == 1:
        return basis
    if basis.shape[1] == 2:
        return _best_in_plane(basis)
    vectors = list(_vectors_with_zeros(basis))
    first = vectors[_first_smallest(np.abs(vectors).sum(axis=1))]
    return np.column_stack([first, _greedy(_complement(basis, first))])


def _vectors_with_zeros(basis: Array) -> Iterator[Array]:
    """Unit vectors of the span that vanish in k − 1 rows, one for each choice of independent rows."""
    rows, count = basis.shape
    for chosen in combinations(range(rows), count - 1):
        _, sigma, vt = np.linalg.svd(basis[list(chosen)])
        if sigma[-1] > _TIE:
            yield basis @ vt[-1]


def _complement(basis: Array, vector: Array) -> Array:
    """Basis of the part of span(basis) orthogonal to `vector`."""
    coefficients = basis.T @ vector
    _, _, vt = np.linalg.svd(coefficients[None, :])
    return np.asarray(basis @ vt[1:].T)


def _plane_candidates(pair: Array) -> Array:
    """(c, m, 2) the plane rotations of two columns that make an entry of the first one zero, a row in use each."""
    rows = pair[np.hypot(pair[:, 0], pair[:, 1]) > _TIE]
    x, y = (rows / np.hypot(rows[:, :1], rows[:, 1:])).T
    return np.asarray(pair @ np.array([[y, x], [-x, y]]).transpose(2, 0, 1))


def _best_in_plane(pair: Array) -> Array:
    candidates = _plane_candidates(pair)
    return np.asarray(candidates[_first_smallest(np.abs(candidates).sum(axis=(1, 2)))])


def _sweep(basis: Array) -> Array:
    """Best plane rotations, plane after plane, until none lowers the sum."""
    current = basis.copy()
    planes = list(combinations(range(basis.shape[1]), 2))
    for _ in range(_SWEEPS):
        improved = False
        for plane in planes:
            pair = current[:, plane]
            best = _best_in_plane(pair)
            if np.abs(best).sum() < np.abs(pair).sum() - 1e-12:
                current[:, plane] = best
                improved = True
        if not improved:
            break
    return current


def _first_smallest(sums: Array) -> int:
    """First of the smallest up to rounding, so that ties do not depend on it."""
    return int(np.argmax(sums <= sums.min() + 1e-9))


def _canonical(basis: Array) -> Array:
    """Signs and order fixed, rounding removed."""
    clean = np.where(np.abs(basis) < _ROUNDING, 0.0, basis)
    size = np.abs(clean)
    largest = np.argmax(size >= size.max(axis=0) - _TIE, axis=0)  # the first of the tied ones
    signs = np.where(clean[largest, np.arange(clean.shape[1])] < 0.0, -1.0, 1.0)
    clean = clean * signs + 0.0
    order = sorted(range(clean.shape[1]), key=lambda c: (int(largest[c]), _key(clean[:, c])))
    return clean[:, order]


def _key(values: Array) -> tuple[float, ...]:
    """Sorts larger entries first, in steps of the tie tolerance."""
    return tuple((-np.round(values / _TIE)).tolist())


def _choose(bases: list[Array]) -> Array:
    """Fewest entries; among those the smallest sum; among ties the larger |entries| in the earlier rows."""
    counts = np.array([(np.abs(basis) > _TIE).sum() for basis in bases])
    sums = np.where(counts == counts.min(), [np.abs(basis).sum() for basis in bases], np.inf)
    tied = [bases[i] for i in np.flatnonzero(sums <= sums.min() + _TIE)]
    return min(tied, key=lambda basis: (_key(np.abs(basis.T).ravel()), _key(basis.T.ravel())))


def entries(basis: Array) -> int:
    """How many entries are not zero: what a readable basis has few of."""
    return int((np.abs(basis) > 1e-6).sum())


def random_rotation(rng: np.random.Generator, size: int) -> Array:
    """(size, size) orthogonal."""
    q, r = np.linalg.qr(rng.normal(size=(size, size)))
    return np.asarray(q * np.sign(np.diag(r)))
