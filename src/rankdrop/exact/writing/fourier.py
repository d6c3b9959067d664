"""A half-angle polynomial as a sum of sines and cosines of half-integer combinations of the angles.

t^k of degree D stands for sin^k(θ/2) cos^(D−k)(θ/2). With z = exp(iθ/2) that is

    (−i)^k 2^(−D) (z − 1/z)^k (z + 1/z)^(D−k),

so that the whole polynomial is multiplied out joint by joint. A combination comes out whole wherever it can: a2 c2 +
a3 c23 has two terms here and three in sines and cosines of single angles.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import comb, lcm

from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.writing.form import Factor, Product, Symbol, product, total, wave

Pair = tuple[int, int]
"""Real and imaginary part, times a number that all have in common: whole numbers are faster than fractions."""


def fourier(f: Polynomial, degrees: Sequence[int], ring: Ring) -> Product:
    """f / Π (1 + t_j²)^(D_j / 2) as a sum of waves times monomials in lengths and slides.

    Args:
        f: of `ring.half`.
        degrees: D_j of each revolute joint, at least the degree of f in t_j.
        ring: of f.

    Returns:
        number · (sum of terms), equal to it exactly.
    """
    n = ring.angles
    terms = [(tuple(int(e) for e in powers), int(value.p), int(value.q)) for powers, value in f.terms()]
    bottom = lcm(*(q for _, _, q in terms))
    state: dict[tuple[int, ...], Pair] = {powers: (p * (bottom // q), 0) for powers, p, q in terms}
    for k in range(n):
        if degrees[k]:
            state = _expanded(state, k, int(degrees[k]))
            bottom <<= int(degrees[k])
    parts = []
    for key, (real, imaginary) in state.items():
        turns = key[:n]
        first = next((m for m in turns if m), 0)
        if first < 0:
            continue
        twice = 2 if first else 1
        monomial = symbols(key[n:], ring)
        for kind, value in (("cos", twice * real), ("sin", -twice * imaginary)):
            sign, one = wave(kind, dict(zip(ring.revolute, turns, strict=True)))
            if value and sign:
                factors = monomial if one is None else [*monomial, (one, 1)]
                parts.append(product(Fraction(value * sign, bottom), factors))
    return total(parts)


def symbols(powers: Sequence[int], ring: Ring) -> list[tuple[Factor, int]]:
    """The monomial in slides and lengths with these powers."""
    names = [Symbol(f"q{j}", j) for j in ring.prismatic] + [Symbol(name) for name in ring.letters]
    return [(symbol, int(power)) for symbol, power in zip(names, powers, strict=True) if power]


def _expanded(state: dict[tuple[int, ...], Pair], k: int, degree: int) -> dict[tuple[int, ...], Pair]:
    """The power of t_k in every key replaced by the power of z_k, all times 2^degree."""
    tables = {power: _table(power, degree) for power in {key[k] for key in state}}
    found: dict[tuple[int, ...], Pair] = {}
    for key, (real, imaginary) in state.items():
        power = key[k]
        for _ in range(power % 4):  # times −i
            real, imaginary = imaginary, -real
        for z, value in tables[power].items():
            new = (*key[:k], z, *key[k + 1 :])
            one, two = found.get(new, (0, 0))
            found[new] = (one + value * real, two + value * imaginary)
    return {key: pair for key, pair in found.items() if any(pair)}


def _table(power: int, degree: int) -> dict[int, int]:
    """(z − 1/z)^k (z + 1/z)^(D−k) by powers of z."""
    found: dict[int, int] = {}
    for i in range(power + 1):
        for j in range(degree - power + 1):
            z = degree - 2 * i - 2 * j
            found[z] = found.get(z, 0) + (-1) ** i * comb(power, i) * comb(degree - power, j)
    return {z: value for z, value in found.items() if value}
