"""Real common zeros of three polynomials in two half-angle tangents; that there are none is a proof.

Two of the three are eliminated against the first, by either variable. Real roots of the two univariate polynomials
that are left hold every common zero; they are isolated in balls, and a pair of balls on which one of the three cannot
be zero is thrown out. What stays is zero to the precision of the balls, which is not a proof that it is one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rankdrop.exact.algebra.polynomial import Polynomial, coefficients, flint, primitive, used
from rankdrop.exact.algebra.work import tick

BITS = 600
"""Of the balls that the three are evaluated on: roots of degree 48 are told apart at a third of them."""
_MIX = (3, -7)


class Unbounded(Exception):
    """The three vanish together on a curve, or where one of the variables is infinite."""


def common_zeros(first: Polynomial, second: Polynomial, third: Polynomial) -> tuple[tuple[float, float], ...]:
    """Real (x, y) where all three polynomials in x and y vanish.

    Args:
        first, second, third: of one ring, in its first two variables only; the first has no factor of one variable
            that the others share.

    Returns:
        The candidates that no ball throws out, in order; empty: proven that there is none with x and y finite.

    Raises:
        Unbounded: they are zero together on a curve.

    Example:
        >>> from rankdrop.exact.algebra.ring import Ring
        >>> x, y = Ring([1, 2]).half.gens()
        >>> common_zeros(x**2 + y**2 - 2, x - y, x * y - 1)
        ((-1.0, -1.0), (1.0, 1.0))
        >>> common_zeros(x**2 + y**2 - 2, x - y, x * y + 1)
        ()
    """
    mixed = [second + factor * third for factor in _MIX]
    eliminated = []
    for place in (0, 1):  # what is left depends on this variable
        left = [_resultant(first, other, 1 - place) for other in mixed]
        found = left[0].gcd(left[1])
        if found == 0:
            raise Unbounded
        eliminated.append(found)
    return _pairs((first, second, third), eliminated)


def _pairs(system: Sequence[Polynomial], eliminated: Sequence[Polynomial]) -> tuple[tuple[float, float], ...]:
    module = flint()
    kept, module.ctx.prec = module.ctx.prec, BITS
    try:
        xs, ys = (_real_roots(f, place) for place, f in enumerate(eliminated))
        tick(40 * len(xs) * len(ys))
        found = [(float(x.mid()), float(y.mid())) for x in xs for y in ys
                 if all(_at(f, x, y).contains(0) for f in system)]  # fmt: skip
    finally:
        module.ctx.prec = kept
    return tuple(sorted(found))


def real_zeros(f: Polynomial, place: int) -> tuple[float, ...]:
    """Real zeros of a polynomial in one variable; none in the list: proven that there is none."""
    module = flint()
    kept, module.ctx.prec = module.ctx.prec, BITS
    try:
        return tuple(sorted(float(x.mid()) for x in _real_roots(f, place)))
    finally:
        module.ctx.prec = kept


def _resultant(one: Polynomial, other: Polynomial, place: int) -> Polynomial:
    if other == 0:
        return other
    if place not in used(one):
        return one**0 if other == 0 else one
    tick(2_000 * (len(one) + len(other)))
    return one.resultant(other, place)


def _real_roots(f: Polynomial, place: int) -> list[Any]:
    """Balls around the roots that may be real: all that are, and none twice."""
    if not used(f):
        return []
    module = flint()
    numbers = [int(c.leading_coefficient().p) if c != 0 else 0 for c in coefficients(primitive(f), place)]
    whole = module.fmpz_poly(numbers)
    tick(50 * len(numbers) ** 2)
    roots = []
    for factor, _ in whole.factor_squarefree()[1]:
        roots += [root.real for root, _ in factor.complex_roots() if root.imag.contains(0)]
    return roots


def _at(f: Polynomial, x: Any, y: Any) -> Any:
    arb = flint().arb
    powers = [[arb(1)], [arb(1)]]
    for known, value, degree in zip(powers, (x, y), f.degrees(), strict=False):
        for _ in range(degree):
            known.append(known[-1] * value)
    total = arb(0)
    for exponents, c in f.terms():
        total += arb(c) * powers[0][exponents[0]] * powers[1][exponents[1]]
    return total
