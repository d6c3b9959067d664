"""Linear conditions of a family, m·q = c: pinned joints and whole-number relations, and the values c that they take.

A set of values has an equation, too: what the pinned joint, or the relation, satisfies.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from math import pi

import numpy as np
from numpy.typing import NDArray

from rankdrop.errors import OptionError
from rankdrop.families.inspection import Covector
from rankdrop.formula.equation import Equation, Mask, Term, normalised_equation
from rankdrop.problem import wrap
from rankdrop.robot.model import Array, Robot

SIMPLE = pi / 12  # values are taken for a multiple of this where they agree with one
Values = tuple[float, ...]


def _product_of_differences(covector: Sequence[int], values: Sequence[float]) -> Equation:
    """Π (u − v) over the values v of a joint that slides, written as a sum; u = covector·q."""
    n, count = len(covector), len(values)
    j = next(i for i, m in enumerate(covector) if m)
    coefficients = np.poly(np.asarray(values, dtype=np.float64) * covector[j])
    terms = []
    for k, coefficient in enumerate(coefficients):
        if coefficient:
            powers = [0] * n
            powers[j] = count - k
            terms.append(Term(float(coefficient), "cos", (0,) * n, tuple(powers)))
    return Equation(tuple(terms))


def vanishing_on(covector: Sequence[int], values: Sequence[float], *, periodic: bool) -> Equation:
    """The simplest equation that holds exactly where covector·q takes one of `values`.

    {0, π} gives sin u, {±π/2} cos u, {v} sin((u − v)/2), {v, v + π} sin(u − v), any other set the product of the
    sin((u − v)/2) written as a sum; a joint that is not periodic gives Π (u − v).

    Args:
        covector: (n,) whole numbers; u = covector·q. One ±1 entry for a pinned joint.
        values: [rad], or [m] where not periodic.
        periodic: whether u is an angle.

    Raises:
        OptionError: no value.
    """
    count = len(values)
    if not values:
        raise OptionError("a condition needs at least one value")
    if not periodic:
        return _product_of_differences(covector, values)
    half = [int(m) for m in covector]
    if count == 1:
        return _one_wave(half, float(values[0]) / 2)
    if count == 2 and abs(np.cos(values[0] - values[1]) + 1) < 1e-15:  # half a turn apart
        inner = values[0] if -pi / 2 < values[0] < pi / 2 else values[1]
        return _one_wave([2 * m for m in half], float(inner))
    return _product_of_sines(half, values)


def _one_wave(harmonics: Sequence[int], phase: float) -> Equation:
    """sin(u − phase), simplified where the phase is 0, π or ±π/2; harmonics in half angles."""
    zero, multiples = (0,) * len(harmonics), tuple(harmonics)
    if abs(np.cos(phase)) < 1e-15:
        return Equation((Term(1.0, "cos", multiples, zero),))
    if abs(np.sin(phase)) < 1e-15:
        return Equation((Term(1.0, "sin", multiples, zero),))
    return Equation((Term(1.0, "sin", multiples, zero, phase),))


def _product_of_sines(half: Sequence[int], values: Sequence[float]) -> Equation:
    """Π sin((u − v)/2) over N values is z^(−N/2)·Π(z − e^{iv}) up to a constant, z = e^{iu}: read off its harmonics."""
    zero, count = (0,) * len(half), len(values)
    waves = np.poly(np.exp(1j * np.asarray(values)))  # of z^count … z^0
    waves = waves * np.exp(-0.5j * (np.angle(waves[-1])))  # makes it c_k = conj(c_{count−k})
    terms = []
    for k in range(count // 2 + 1):
        order = count - 2 * k  # twice the harmonic
        c = waves[k] * (1.0 if order == 0 else 2.0)
        harmonics = tuple(order * m for m in half)
        terms.append(Term(float(c.real), "cos", harmonics, zero))
        if order:
            terms.append(Term(float(-c.imag), "sin", harmonics, zero))
    return normalised_equation(terms, threshold=1e-13)


@dataclass(frozen=True, eq=False)
class Linear:
    """Covectors m_1 … m_c, of which a family fixes the values m_i·q.

    Attributes:
        covectors: (c, n) whole numbers, independent.
        periodic: (c,) whether the value is an angle.
    """

    covectors: NDArray[np.int64]
    periodic: Mask

    @classmethod
    def of(cls, robot: Robot, covectors: Iterable[Covector]) -> Linear:
        """The linear conditions for an arm; an angle is what only periodic joints enter."""
        rows = np.array(list(covectors), dtype=np.int64).reshape(-1, robot.n)
        turning = robot.periodic
        return cls(rows, np.array([bool(turning[row != 0].all()) for row in rows], dtype=np.bool_))

    def __len__(self) -> int:
        return len(self.covectors)

    @cached_property
    def pivots(self) -> tuple[int, ...]:
        """Joints (from 0) that are solved for: the last ones whose minor is ±1, or as small as it gets."""
        best: tuple[float, tuple[int, ...]] = (np.inf, ())
        columns = [j for j in range(self.covectors.shape[1]) if self.covectors[:, j].any()]
        for choice in combinations(reversed(columns), len(self)):
            minor = abs(float(np.linalg.det(self.covectors[:, choice])))
            if 0.5 < minor < best[0] - 0.5:
                best = (minor, choice)
            if minor and best[0] < 1.5:
                break
        return tuple(best[1])

    @cached_property
    def kept_motions(self) -> Array:
        """(n, n − c) orthonormal basis of the motions that keep all values."""
        if not len(self):
            return np.eye(self.covectors.shape[1])
        return np.asarray(np.linalg.svd(self.covectors.astype(np.float64))[2][len(self) :].T)

    def values(self, q: Array) -> Array:
        """(N, c) values at q (N, n), angles in (−π, π]."""
        return self.deviation(q, np.zeros(len(self)))

    def deviation(self, q: Array, values: Array) -> Array:
        """(N, c) how far the values at q (N, n) are from others (c,) or (N, c), angles the short way round."""
        off = q @ self.covectors.T - values
        return np.where(self.periodic, wrap(off), off)

    def place(self, q: Array, values: Array, rng: np.random.Generator) -> Array:
        """Move the pivot joints of q (N, n) so that the covectors take `values` (N, c), on a branch by chance."""
        if not len(self):
            return q
        pivots = list(self.pivots)
        square = self.covectors[:, pivots].astype(np.float64)
        turns = round(abs(float(np.linalg.det(square))))  # how many branches the pivots have
        branch = rng.integers(0, max(turns, 1), size=values.shape) * 2 * pi * self.periodic
        rest = q.copy()
        rest[:, pivots] = 0.0
        placed = q.copy()
        placed[:, pivots] = np.linalg.solve(square, (values + branch - rest @ self.covectors.T).T).T
        return placed

    def equations(self, sets: Iterable[Values]) -> tuple[Equation, ...]:
        """One equation per covector, for the set of values it takes."""
        return tuple(
            vanishing_on([int(m) for m in row], values, periodic=bool(periodic))
            for row, values, periodic in zip(self.covectors, sets, self.periodic, strict=True)
        )

    def combinations(self, q: Array, weights: Array, tolerance: float) -> dict[Values, NDArray[np.int64]]:
        """The value combinations that points take, simple values exact, each with its points.

        Args:
            q: (N, n) points.
            weights: (N,) the larger, the better the point is known.
            tolerance: values closer than this are one.
        """
        pairs = zip(self.values(q).T, self.periodic.tolist(), strict=True)
        columns = [_snap_to_known_values(column, weights, tolerance, periodic=turns) for column, turns in pairs]
        points_of_values: dict[Values, list[int]] = {}
        for point, values in enumerate(np.reshape(columns, (len(self), len(q))).T.tolist()):
            points_of_values.setdefault(tuple(values), []).append(point)
        return {key: np.array(members) for key, members in points_of_values.items()}

    def neighbours(self, values: Values) -> list[Values]:
        """Combinations with one angle exchanged for v + π or −v: where symmetry puts further pieces."""
        result = []
        for i in range(len(self)):
            for other in (values[i] + pi, -values[i], pi - values[i]) if self.periodic[i] else ():
                v = canonical(other)
                if v != values[i]:
                    result.append((*values[:i], v, *values[i + 1 :]))
        return result


def canonical(angle: float, tolerance: float = 1e-12) -> float:
    """The angle in (−π, π], multiples of π/12 exact, other values rounded to 1e-13 so that equal ones compare equal.

    Args:
        angle: in rad.
        tolerance: an angle closer to a multiple of π/12 is that multiple [rad]; −π + 2e-12 and π − 2e-12 are one angle.
    """
    angle = float(wrap(np.array(angle)))
    whole = round(angle / SIMPLE)
    if abs(angle - whole * SIMPLE) < tolerance:
        if whole == -12:
            return pi
        return whole * SIMPLE
    return round(angle, 13)


def clusters(values: Array, width: float, *, periodic: bool) -> NDArray[np.int64]:
    """(N,) numbers of groups of values that lie closer together than `width`, −π and π being one value."""
    order = np.argsort(values, kind="stable")
    labels = np.empty(len(values), dtype=np.int64)
    labels[order] = np.concatenate([[0], np.cumsum(np.diff(values[order]) > width)])
    if periodic and values[order[0]] + 2 * pi - values[order[-1]] <= width:
        labels[labels == labels[order[-1]]] = 0
    return labels


def _snap_to_known_values(values: Array, weights: Array, tolerance: float, *, periodic: bool) -> Array:
    """Each value replaced by the best-known one of its cluster, or the multiple of π/12 there."""
    labels, result = clusters(values, tolerance, periodic=periodic), np.empty_like(values)
    for label in np.unique(labels):
        members = np.flatnonzero(labels == label)
        value = float(values[members[np.argmax(weights[members])]])
        if periodic:
            whole = round(value / SIMPLE) * SIMPLE
            value = canonical(whole if abs(value - whole) <= tolerance else value)
        if not periodic and abs(value) <= tolerance:
            result[members] = 0.0
        else:
            result[members] = value
    return result
