"""Real configurations on which one atom holds, in floating point: to look at its geometry, not to prove anything."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rankdrop.exact.algebra.atom import Atom
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.signs.signs import numeric_terms
from rankdrop.exact.writing.pins import RADIANS
from rankdrop.reach import reach
from rankdrop.robot.model import Array

_TRIES = 8  # random settings of the other joints per point wanted
_REAL = 1e-9  # imaginary part of a root below this: real


def real_points(chain: Chain, atoms: Sequence[Atom], count: int, seed: int = 0) -> Array:
    """(N, n) configurations q of `Chain.own`, N ≤ count, on each of which one of the atoms holds, in turn.

    The joints that an atom does not fix stand at random tenths. Fewer than `count` where no real zeros were found.
    """
    rng = np.random.default_rng(seed)
    found: list[Array] = []
    for attempt in range(_TRIES * count):
        theta = _random(chain, rng)
        solved = _solve(chain, atoms[attempt % len(atoms)], theta, rng)
        if solved is not None:
            found.append(solved - chain.shifts)
        if len(found) == count:
            break
    return np.array(found).reshape(-1, chain.n)


def _random(chain: Chain, rng: np.random.Generator) -> Array:
    theta = np.round(rng.uniform(-np.pi, np.pi, chain.n), 1)
    for j in chain.ring.prismatic:
        theta[j - 1] = np.round(rng.uniform(0.3, 1.0), 1) * reach(chain.own)
    return theta


def _solve(chain: Chain, atom: Atom, theta: Array, rng: np.random.Generator) -> Array | None:
    """θ with one joint of the atom, chosen at random, moved to a zero; None where it has no real one."""
    theta = theta.copy()
    if atom.pinned:
        theta[atom.joint - 1] = RADIANS[atom.value]
        return theta
    ring = chain.ring
    moving = [*ring.revolute, *ring.prismatic]
    degrees = [int(degree) for degree in atom.f.degrees()]
    place = int(rng.choice([i for i in range(ring.moving) if degrees[i]]))
    coefficients = np.zeros(degrees[place] + 1)  # highest power first
    for coefficient, powers in numeric_terms(ring, atom.f, chain.numbers, chain.power):
        for i, j in enumerate(moving):
            if i == place:
                continue
            x = theta[j - 1]
            if i < ring.angles:
                coefficient *= np.sin(x / 2) ** powers[i] * np.cos(x / 2) ** (degrees[i] - powers[i])
            else:
                coefficient *= x ** powers[i]
        coefficients[degrees[place] - powers[place]] += coefficient
    roots = np.roots(coefficients) if np.isfinite(coefficients).all() and coefficients.any() else np.zeros(0)
    real = roots[np.abs(roots.imag) < _REAL].real
    if not len(real):
        return None
    root = float(rng.choice(real))
    theta[moving[place] - 1] = 2 * np.arctan(root) if place < ring.angles else root
    return theta
