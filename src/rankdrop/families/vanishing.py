"""The equation of a set of values: what a pinned joint, or a relation between joints, satisfies."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np

from rankdrop.errors import OptionError
from rankdrop.family.equation import Equation, Term, normalised


def vanishing_on(covector: Sequence[int], values: Sequence[float], *, periodic: bool) -> Equation:
    """The simplest equation that holds exactly where covector·q takes one of `values`.

    {0, π} gives sin u, {±π/2} cos u, {v} sin((u − v)/2), {v, v + π} sin(u − v), any other set the product of the
    sin((u − v)/2) written as a sum; a variable that is not periodic gives Π (u − v).

    Args:
        covector: (n,) whole numbers; u = covector·q. One ±1 entry for a pinned joint.
        values: [rad], or [m] where not periodic.
        periodic: whether u is an angle.

    Raises:
        OptionError: no value, or a relation between joints that are not angles with more than one value.
    """
    n, zero = len(covector), (0,) * len(covector)
    if not values:
        raise OptionError("a condition needs at least one value")
    if not periodic:
        return _polynomial(covector, values)
    half = tuple(int(m) for m in covector)
    whole = tuple(2 * m for m in half)
    if len(values) == 1:
        v = float(values[0])
        if abs(v) < 1e-15:
            return Equation((Term(1.0, "sin", half, zero),))
        if abs(abs(v) - pi) < 1e-15:
            return Equation((Term(1.0, "cos", half, zero),))
        return Equation((Term(1.0, "sin", half, zero, v / 2),))
    if len(values) == 2 and abs(np.cos(values[0] - values[1]) + 1) < 1e-15:
        v = float(values[0])
        if abs(np.sin(v)) < 1e-15:
            return Equation((Term(1.0, "sin", whole, zero),))
        if abs(np.cos(v)) < 1e-15:
            return Equation((Term(1.0, "cos", whole, zero),))
        low = v if -pi / 2 < v < pi / 2 else float(values[1])
        return Equation((Term(1.0, "sin", whole, zero, low),))
    return _product_of_sines(half, values, n)


def _product_of_sines(half: tuple[int, ...], values: Sequence[float], n: int) -> Equation:
    """Π sin((u − v)/2) over N values is z^(−N/2)·Π(z − e^{iv}) up to a constant, z = e^{iu}: read off its harmonics."""
    count = len(values)
    coefficients = np.poly(np.exp(1j * np.asarray(values)))  # of z^count … z^0
    coefficients = coefficients * np.exp(-0.5j * (np.angle(coefficients[-1])))  # makes it c_k = conj(c_{count−k})
    terms = []
    for k in range(count // 2 + 1):
        order = count - 2 * k  # twice the harmonic
        c = coefficients[k] * (1.0 if order == 0 else 2.0)
        harmonics = tuple(order * m for m in half)
        terms.append(Term(float(c.real), "cos", harmonics, (0,) * n))
        if order:
            terms.append(Term(float(-c.imag), "sin", harmonics, (0,) * n))
    return normalised(terms, threshold=1e-13)


def _polynomial(covector: Sequence[int], values: Sequence[float]) -> Equation:
    n, zero = len(covector), (0,) * len(covector)
    if sum(abs(m) for m in covector) == 1:
        j = next(i for i, m in enumerate(covector) if m)
        coefficients = np.poly(np.asarray(values, dtype=np.float64) * covector[j])
        degree = len(coefficients) - 1
        terms = [
            Term(float(c), "cos", zero, tuple(degree - k if i == j else 0 for i in range(n)))
            for k, c in enumerate(coefficients)
            if c != 0.0
        ]
        return Equation(tuple(terms))
    if len(values) > 1:
        raise OptionError("a relation between joints that are not angles takes one value", got=len(values))
    terms = [Term(float(m), "cos", zero, tuple(int(i == j) for i in range(n))) for j, m in enumerate(covector) if m]
    return Equation((*terms, Term(-float(values[0]), "cos", zero, zero)) if values[0] else tuple(terms))
