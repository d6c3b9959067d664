"""Trigonometric polynomials of a few joint angles as Fourier sums, and enclosures of them over cells of the torus.

    f(θ) = Σ_k c_k exp(i k·θ),    |∂f/∂θ_a| ≤ Σ |k_a| |c_k|,    |∂²f/∂θ_a∂θ_b| ≤ Σ |k_a k_b| |c_k|

A cell is a cube of half width r. With H the bound of the second derivatives, Taylor's formula around its middle m gives

    |f(θ) − f(m)| ≤ r Σ_a |∂f/∂θ_a(m)| + ½ r² Σ_ab H_ab,    |∂f/∂θ_a(θ) − ∂f/∂θ_a(m)| ≤ r Σ_b H_ab.

Both are widened by `ROUNDING` of the sum of the sizes of all terms, which is more than what double precision loses in a
sum of so few terms, those that cancel among them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from rankdrop.algebra.polynomial import Polynomial
from rankdrop.algebra.ring import Ring, numeric_terms
from rankdrop.robot.model import Array

ROUNDING = 1e-12
"""Share of the sizes of all terms by which an enclosure is widened."""


@dataclass(frozen=True)
class Interval:
    """Lower and upper ends of numbers, one per cell."""

    low: Array
    high: Array

    def __add__(self, other: Interval) -> Interval:
        return Interval(self.low + other.low, self.high + other.high)

    def __mul__(self, other: Interval) -> Interval:
        products = [a * b for a in (self.low, self.high) for b in (other.low, other.high)]
        return Interval(np.minimum.reduce(products), np.maximum.reduce(products))

    def times(self, factor: float) -> Interval:
        """Times a number."""
        ends = factor * self.low, factor * self.high
        if factor >= 0:
            return Interval(*ends)
        return Interval(ends[1], ends[0])

    def size(self) -> Interval:
        """Of the absolute value."""
        least = np.maximum(np.maximum(self.low, -self.high), 0.0)
        return Interval(least, np.maximum(np.abs(self.low), np.abs(self.high)))


@dataclass(frozen=True, eq=False)
class FourierSum:
    """A trigonometric polynomial as a Fourier sum.

    Attributes:
        joints: numbers (from 1) of the joints it depends on.
        frequencies: (K, number of joints) whole numbers.
        amplitudes: (K,) complex c_k.
        total: Σ of the sizes of all terms that were summed; at least Σ |c_k|, so that no value is larger.
    """

    joints: tuple[int, ...]
    frequencies: Array
    amplitudes: Array
    total: float

    @cached_property
    def _bends(self) -> Array:
        """(d, d) bounds of the second derivatives."""
        size = np.abs(self.amplitudes)
        steps = np.abs(self.frequencies)
        return np.asarray(np.einsum("k,ka,kb->ab", size, steps, steps))

    def _exponentials(self, middles: Mapping[int, Array]) -> Any:
        """(N, K) exp(i k·θ) at the middles of cells."""
        if middles:
            count = len(next(iter(middles.values())))
        else:
            count = 1
        phase = np.zeros((count, len(self.amplitudes)))
        for a, joint in enumerate(self.joints):
            phase += np.multiply.outer(middles[joint], self.frequencies[:, a])
        return np.asarray(np.exp(1j * phase))

    def jets(self, middles: Mapping[int, Array]) -> tuple[Array, Array]:
        """(N,) values and (N, d) derivatives at points, the angles by joint number [rad]."""
        terms = self._exponentials(middles) * self.amplitudes
        slopes = (1j * (terms @ self.frequencies)).real
        return np.asarray(terms.sum(axis=1).real), np.asarray(slopes)

    def over(self, middles: Mapping[int, Array], radius: float) -> Interval:
        """Enclosures of the values over cells."""
        values, slopes = self.jets(middles)
        reach = radius * np.abs(slopes).sum(axis=1) + 0.5 * radius**2 * float(self._bends.sum())
        reach = reach + ROUNDING * self.total
        return Interval(values - reach, values + reach)

    def slopes_over(self, middles: Mapping[int, Array], radius: float) -> dict[int, Interval]:
        """Enclosures of the derivative by each joint over cells."""
        _, slopes = self.jets(middles)
        highest = float(np.abs(self.frequencies).max(initial=0))
        widths = radius * self._bends.sum(axis=1) + ROUNDING * (1 + highest) * self.total
        return {joint: Interval(slopes[:, a] - widths[a], slopes[:, a] + widths[a])
                for a, joint in enumerate(self.joints)}  # fmt: skip


def wave_of(ring: Ring, p: Polynomial, numbers: Mapping[str, float], unit: float) -> FourierSum:
    """The Fourier sum of a trigonometric polynomial without slides.

    Args:
        ring: of p.
        p: reduced, of `ring.trig`; may be zero.
        numbers: values of the letters and roots that are in it.
        unit: what it is divided by, so that polynomials that are added stay comparable.
    """
    names = p.context().names()
    if p != 0:
        present = [j for j in ring.revolute if any(p.degrees()[names.index(f"{x}{j}")] for x in "sc")]
    else:
        present = []
    sums: dict[tuple[int, ...], complex] = {}
    total = 0.0
    for number, powers in numeric_terms(p, numbers, unit=unit) if p != 0 else ():
        total += abs(number)  # the amplitudes of sin^a θ cos^b θ have a sum of sizes of 1 at most
        parts: dict[tuple[int, ...], complex] = {(): complex(number)}
        for joint in present:
            power = _single(powers[names.index(f"s{joint}")], powers[names.index(f"c{joint}")])
            parts = {(*k, m): value * c for k, value in parts.items() for m, c in power.items()}
        for k, value in parts.items():
            sums[k] = sums.get(k, 0j) + value
    frequencies = np.array(list(sums), dtype=float).reshape(len(sums), len(present))
    return FourierSum(tuple(present), frequencies, np.array(list(sums.values()), dtype=complex), total)


def _single(sines: int, cosines: int) -> dict[int, complex]:
    """Fourier sum of sin^a θ cos^b θ."""
    sums: dict[int, complex] = {0: 1 + 0j}
    steps: Sequence[dict[int, complex]] = [{1: -0.5j, -1: 0.5j}] * sines + [{1: 0.5 + 0j, -1: 0.5 + 0j}] * cosines
    for step in steps:
        made: dict[int, complex] = {}
        for k, value in sums.items():
            for m, c in step.items():
                made[k + m] = made.get(k + m, 0j) + value * c
        sums = made
    return sums
