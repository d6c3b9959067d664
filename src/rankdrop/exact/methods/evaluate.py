"""Polynomials of both rings at configurations: how far off they vanish."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.exact.algebra.atom import Atom
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.writing.pins import RADIANS
from rankdrop.robot.model import Array
from rankdrop.units import into_units

STEP = 1e-5
"""Of central differences [rad, m]: rounding leaves 1e-11 of the gradient, the third derivative 1e-10."""


NOISE = 1e-10
"""Slopes below it, relative to the coefficients, may be rounding: ten times what `STEP` leaves of it."""


class Distances:
    """Distances of configurations from the zeros of polynomials, to first order: |f|/|∇f|, half the distance from the
    zeros of a sum of squares; where the slope may be rounding, the smaller of that and √|f|.

    What was asked for once is kept: the cases of a derivation speak of few different polynomials.

    Args:
        chain: the arm.
        q: (N, n) configurations [rad, m].
    """

    def __init__(self, chain: Chain, q: ArrayLike) -> None:
        self._chain = chain
        self._theta = into_units(chain.robot, np.atleast_2d(np.asarray(q, dtype=np.float64))) + chain.shifts
        self._known: dict[str, Array] = {}

    def __len__(self) -> int:
        return len(self._theta)

    def of(self, f: Polynomial | Atom) -> Array:
        """(N,) [rad; slides in the arm's own unit] of a trigonometric polynomial or an atom; f is divided by the size
        of its coefficients.
        """
        key = f.key if isinstance(f, Atom) else str(f)
        if key not in self._known:
            self._known[key] = self._computed(f)
        return self._known[key]

    def _computed(self, f: Polynomial | Atom) -> Array:
        chain, theta = self._chain, self._theta
        if isinstance(f, Atom) and f.f is None:
            return np.asarray(2 * np.abs(np.sin((theta[:, f.joint - 1] - RADIANS[f.value]) / 2)))
        value, scale = values_of(chain, f, theta)
        slope = np.zeros_like(theta)
        for j in range(chain.n):
            step = STEP * np.eye(chain.n)[j]
            slope[:, j] = (values_of(chain, f, theta + step)[0] - values_of(chain, f, theta - step)[0]) / (2 * STEP)
        size, steep = np.abs(value) / scale, np.linalg.norm(slope, axis=1) / scale
        ratio = size / np.maximum(steep, 1e-300)
        return np.asarray(np.where(steep > NOISE, ratio, np.minimum(ratio, np.sqrt(size))))


def values_of(chain: Chain, f: Polynomial | Atom, theta: Array) -> tuple[Array, Array]:
    """(value, size of the coefficients), both (N,), lengths in the arm's own unit, at θ (N, n); of an atom the
    homogeneous value, which is finite at θ = π, too: t^e of degree D stands for sin^e(θ/2) cos^(D−e)(θ/2).
    """
    ring = chain.ring
    angles = [theta[:, j - 1] for j in ring.revolute]
    if isinstance(f, Atom):
        factors = [
            (np.sin(angle / 2), np.cos(angle / 2), int(degree))
            for angle, degree in zip(angles, f.f.degrees(), strict=False)
        ]
        powers = [[s**e * c ** (d - e) for e in range(d + 1)] for s, c, d in factors]
        return _sum(chain, chain.own_polynomial(f.f), theta, powers)
    tables = []
    for angle, j in zip(angles, ring.revolute, strict=True):
        place = 2 * ring.revolute.index(j)
        for wave, degree in zip((np.sin(angle), np.cos(angle)), f.degrees()[place : place + 2], strict=True):
            tables.append([wave**e for e in range(int(degree) + 1)])
    return _sum(chain, chain.own_polynomial(f), theta, tables)


def _sum(chain: Chain, f: Polynomial, theta: Array, angles: list[list[Array]]) -> tuple[Array, Array]:
    """Σ of the terms with the powers of the first variables given in tables, and of their sizes.

    Angles enter sizes as 1, slides as 1 at least.
    """
    slides = [theta[:, j - 1] for j in chain.ring.prismatic]
    lengths = [chain.own_numbers[name] for name in chain.ring.letters]
    one = np.ones(len(theta))
    total, scale = 0 * one, 0 * one
    for powers, coefficient in f.terms():
        number = int(coefficient.p) / int(coefficient.q)
        for length, power in zip(lengths, powers[len(angles) + len(slides) :], strict=True):
            number *= length ** int(power)
        term, size = number * one, abs(number) * one
        for table, power in zip(angles, powers, strict=False):
            term = term * table[int(power)]
        for slide, power in zip(slides, powers[len(angles) :], strict=False):
            term, size = term * slide ** int(power), size * np.maximum(np.abs(slide), 1.0) ** int(power)
        total, scale = total + term, scale + size
    return total, scale
