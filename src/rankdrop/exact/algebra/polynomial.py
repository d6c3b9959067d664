"""Polynomials over the rationals, whatever their ring: variables, coefficients, primitive form."""

from __future__ import annotations

from math import gcd, lcm
from typing import Any

from rankdrop.exact.algebra.flint import Polynomial, flint


def used(f: Polynomial) -> list[int]:
    """Places of the variables that occur in f."""
    return [place for place, degree in enumerate(f.degrees()) if degree > 0]


def coefficients(f: Polynomial, place: int) -> list[Polynomial]:
    """f as a polynomial in one variable: coefficients from power 0 up."""
    context = f.context()
    parts: dict[int, dict[tuple[int, ...], Any]] = {}
    for e, value in f.terms():
        parts.setdefault(e[place], {})[(*e[:place], 0, *e[place + 1 :])] = value
    return [context.from_dict(parts.get(power, {})) for power in range(max(parts, default=0) + 1)]


def primitive(f: Polynomial) -> Polynomial:
    """f with whole coprime coefficients, the first one positive."""
    values = f.coeffs()
    if not values:
        return f
    top, bottom = 0, 1
    for value in values:
        top, bottom = gcd(top, int(value.p)), lcm(bottom, int(value.q))
    if values[0] < 0:
        top = -top
    return f * flint().fmpq(bottom, top)
