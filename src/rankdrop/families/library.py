"""Spaces of trigonometric polynomials of given degree in each joint, and the polynomials in them that vanish on points.

In the half-angle variable t = tan(θ/2) a trigonometric polynomial is an ordinary one, and unique factorisation holds
there (it fails in cos and sin). Degree d in t means the harmonics −d/2, −d/2 + 1, …, d/2: d + 1 functions. So d = 1
holds sin(θ/2) and cos(θ/2), d = 2 the usual 1, cos, sin, and d = 4 is enough for every minor of a pose Jacobian. A
prismatic joint has powers 0 … d, a helical one both. Without helical joints a space of multidegree (d_1, …, d_b) has
Π(d_j + 1) functions. All terms of a space have one parity, so that every zero set is well defined on the torus.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rankdrop.family.equation import Equation, Term, normalised
from rankdrop.robot.model import Array
from rankdrop.tolerances import Tolerances


class Kind(IntEnum):
    """How a joint enters."""

    ANGLE = 0
    """Through harmonics."""
    LENGTH = 1
    """Through powers."""
    BOTH = 2
    """Through both: helical."""


NULL = 1e-9  # singular values of the library matrix below this share of the largest may be zero
WORSE = 3.0  # the residual may grow so much when small coefficients are dropped
Degrees = tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Library:
    """The functions of one multidegree in b variables, simplest first.

    Attributes:
        harmonics: (L, b) twice the multiples m.
        powers: (L, b) exponents of the variables that are not periodic.
        is_sin: (L,) sine rather than cosine.
    """

    harmonics: NDArray[np.int64]
    powers: NDArray[np.int64]
    is_sin: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.harmonics)

    def __call__(self, x: Array) -> Array:
        """(N, L) values at x (N, b)."""
        unique, inverse = np.unique(self.harmonics, axis=0, return_inverse=True)
        angle = x @ (unique.T / 2)
        waves = np.where(self.is_sin, np.sin(angle)[:, inverse.reshape(-1)], np.cos(angle)[:, inverse.reshape(-1)])
        for j in np.flatnonzero(self.powers.any(axis=0)):
            waves = waves * x[:, j : j + 1] ** self.powers[:, j]
        return np.asarray(waves)

    def equation(self, coefficients: Array, variables: tuple[int, ...], n: int) -> Equation:
        """Σ c_i·function_i as an equation in n joints, the b variables being the given joints (from 0)."""
        terms = []
        for c, h, p, is_sin in zip(coefficients, self.harmonics, self.powers, self.is_sin, strict=True):
            if c != 0.0:
                wide_h, wide_p = [0] * n, [0] * n
                for j, joint in enumerate(variables):
                    wide_h[joint], wide_p[joint] = int(h[j]), int(p[j])
                terms.append(Term(float(c), "sin" if is_sin else "cos", tuple(wide_h), tuple(wide_p)))
        return normalised(terms)


@lru_cache(maxsize=256)
def library(degrees: Degrees, kinds: tuple[Kind, ...]) -> Library:
    """The functions of multidegree `degrees` in joints of these kinds."""
    waves = [(0,) if k is Kind.LENGTH else range(-d, d + 1, 2) for d, k in zip(degrees, kinds, strict=True)]
    powers = [range(_power(d, k) + 1) for d, k in zip(degrees, kinds, strict=True)]
    rows: list[tuple[tuple[int, ...], tuple[int, ...], bool]] = []
    for m in product(*waves):
        leading = next((h for h in m if h), 0)
        if leading < 0:
            continue
        for is_sin in (False, True) if leading else (False,):
            rows.extend((m, p, is_sin) for p in product(*powers))
    rows.sort(key=lambda row: (sum(map(abs, row[0])) + 2 * sum(row[1]), sum(map(bool, row[0])), row))
    return Library(
        np.array([row[0] for row in rows], dtype=np.int64),
        np.array([row[1] for row in rows], dtype=np.int64),
        np.array([row[2] for row in rows], dtype=np.bool_),
    )


def size(degrees: Degrees, kinds: tuple[Kind, ...]) -> int:
    """Number of functions of a multidegree."""
    pairs = zip(degrees, kinds, strict=True)
    return int(np.prod([(1 if k is Kind.LENGTH else d + 1) * (_power(d, k) + 1) for d, k in pairs]))


def _power(degree: int, kind: Kind) -> int:
    """Largest power at a degree: none for angles; helical joints take one for every two half-angles."""
    return {Kind.ANGLE: 0, Kind.LENGTH: degree, Kind.BOTH: degree // 2}[kind]


def vanishing(values: Array, tolerances: Tolerances) -> Array:
    """Combinations of functions that are zero at all points.

    Args:
        values: (N, L) functions at points, N > L.
        tolerances: `fit_gap`.

    Returns:
        (L, d) orthonormal basis; d = 0 when no gap separates zero singular values from the rest.
    """
    r = np.linalg.qr(values, mode="r")
    _, s, vt = np.linalg.svd(r)
    inside = s <= NULL * s[0]
    count = int(inside.sum())
    if count == 0 or count == len(s):
        return np.zeros((values.shape[1], 0))
    first = len(s) - count
    if s[first] > tolerances.fit_gap * s[first - 1]:
        return np.zeros((values.shape[1], 0))
    return np.asarray(vt[first:].T)


def sparse_basis(null: Array) -> Array:
    """(L, d) basis of the same space with zeros where possible: each vector leads at another, late, function.

    Gauss–Jordan from the least simple function upwards, so that simple generators come out by themselves; sparse
    ones first.
    """
    rows = null.T[:, ::-1].copy()
    pivot = 0
    for column in range(rows.shape[1]):
        if pivot == len(rows):
            break
        best = pivot + int(np.argmax(np.abs(rows[pivot:, column])))
        if abs(rows[best, column]) < 1e-7:
            continue
        rows[[pivot, best]] = rows[[best, pivot]]
        rows[pivot] /= rows[pivot, column]
        others = np.arange(len(rows)) != pivot
        rows[others] -= rows[others, column : column + 1] * rows[pivot]
        pivot += 1
    rows = rows[:, ::-1]
    rows = rows / np.abs(rows).max(axis=1, keepdims=True)
    filled = np.abs(rows) > 1e-7
    last = rows.shape[1] - np.argmax(filled[:, ::-1], axis=1)  # the least simple function of each
    return np.asarray(rows[np.lexsort((last, filled.sum(axis=1)))].T)


def refit(values: Array, coefficients: Array, tolerances: Tolerances) -> Array:
    """Drop coefficients that are zero within noise and solve again on the support: right to the points' own accuracy.

    Args:
        values: (N, L) functions at points.
        coefficients: (L,) a combination that vanishes there.

    Returns:
        (L,) exact zeros outside the support; the largest entry has size one.
    """
    best = coefficients / np.abs(coefficients).max()
    noise = float(np.linalg.norm(values @ best) / np.linalg.norm(best))
    floor = 1e-15 * float(np.linalg.norm(values))
    for threshold in tolerances.coefficient * np.array([1e2, 1.0, 1e-2, 1e-4]):
        support = np.abs(best) > threshold
        _, s, vt = np.linalg.svd(np.linalg.qr(values[:, support], mode="r"))
        if s[-1] <= WORSE * noise + floor:  # a small coefficient that is real would show here
            result = np.zeros_like(best)
            result[support] = vt[-1]
            return np.asarray(result / np.abs(result).max())
    return np.asarray(best)
