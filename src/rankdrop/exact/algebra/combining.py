"""Two conditions combined: into one of a lower degree, or into one with a variable less."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, permutations
from math import prod

from rankdrop.exact.algebra.effort import tick
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.polynomial import coefficients, used
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.algebra.solving import Form, form, unit

_LARGE = 1500  # product of the numbers of terms beyond which a variable is not eliminated: the result would fill pages
_DEGREE = 64  # product of two degrees beyond which their resultant takes seconds
_POWERS = 200_000  # and so it does where its degrees allow for more terms than this


def divisions(ring: Ring, system: list[Polynomial]) -> Iterator[tuple[Polynomial, Polynomial, int]]:
    """(divisor, condition, place): a condition whose degree in a variable falls when it is divided by another one.

    The divisor has no joint of its own and a leading coefficient without joints, so that nothing is lost. What is left
    may factor where the condition itself did not.
    """
    for f, g in permutations(system, 2):
        joints = {place for place in used(f) if place < ring.moving}
        if joints < {place for place in used(g) if place < ring.moving}:
            for k in joints:
                if f.degrees()[k] <= g.degrees()[k] and unit(ring, coefficients(f, k)[-1]):
                    yield f, g, k


def remainder(ring: Ring, g: Polynomial, f: Polynomial, k: int) -> Form:
    """The pseudo-remainder of g divided by f in one variable; it counts for the degrees of g in the others."""
    degree = list(form(g, ring)[1])
    divisor = coefficients(f, k)
    t = f.context().gens()[k]
    while g != 0 and g.degrees()[k] >= len(divisor) - 1:
        top = coefficients(g, k)[-1]
        tick(20 + len(f) * len(top) + len(g) * len(divisor[-1]))
        g = g * divisor[-1] - f * top * t ** (g.degrees()[k] - len(divisor) + 1)
    if k < ring.angles:
        degree[k] = int(g.degrees()[k]) if g != 0 else 0
    return g, tuple(degree)


def eliminable(f: Polynomial, g: Polynomial, k: int) -> bool:
    """Whether the resultant is worth its time: it cannot be interrupted."""
    one, two = f.degrees(), g.degrees()
    if len(f) * len(g) > _LARGE or int(one[k]) * int(two[k]) > _DEGREE:
        return False
    powers = (1 + a * two[k] + b * one[k] for place, (a, b) in enumerate(zip(one, two, strict=True)) if place != k)
    return prod(map(int, powers)) <= _POWERS


def pairs(ring: Ring, system: list[Polynomial]) -> list[tuple[Polynomial, Polynomial, int]]:
    """Two conditions and a variable that both contain, low degrees first."""
    found = [
        (f, g, k)
        for f, g in combinations(system, 2)
        for k in range(ring.moving)
        if f.degrees()[k] and g.degrees()[k]
    ]
    return sorted(found, key=lambda one: _cost(*one))


def _cost(f: Polynomial, g: Polynomial, k: int) -> tuple[int, int, int]:
    """Sort key: variables, degree and terms of what the two would be combined into."""
    return len({*used(f), *used(g)}), f.degrees()[k] * g.degrees()[k], len(f) * len(g)


def combined(ring: Ring, f: Polynomial, g: Polynomial, k: int) -> Polynomial:
    """Two conditions of degree 2 in a variable combined into one of degree 1; others into one without the variable."""
    if f.degrees()[k] == g.degrees()[k] == 2:
        return f * coefficients(g, k)[2] - g * coefficients(f, k)[2]
    found = f.resultant(g, ring.names[k])
    tick(100 + 5 * len(f) * len(g) + 50 * len(found))
    return found
