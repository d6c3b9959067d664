"""Whether a system of conditions binds more than so many freedoms: its points on random planes, modulo a prime.

A set of codimension c meets every plane of dimension c in general position. So a system without a common zero on random
lines (planes) has no piece of codimension 1 (2). Zeros count wherever they are, modulo the prime or in an extension of
its field, but for those with 1 + t² = 0 for a half-angle tangent: no configuration is there.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import reduce
from itertools import combinations

from rankdrop.exact.algebra.effort import tick
from rankdrop.exact.algebra.field import PRIMES, dense, reduced, residue, roots
from rankdrop.exact.algebra.flint import Polynomial, flint
from rankdrop.exact.algebra.polynomial import used

_SEED = 20
_SLICES = PRIMES[:12]  # a piece has no zero modulo a prime on a slice with a chance of 1/e: on all of them with 6e-6


def binds_more(
    system: Sequence[Polynomial], most: int, moving: int, lengths: Mapping[str, Fraction] | None = None
) -> bool:
    """Whether a system has no piece of codimension `most` or less that could be real.

    Only `most` of 1 and 2 are looked into; for more the answer is False.

    Args:
        system: polynomials of the half-angle ring.
        most: codimension.
        moving: so many of their first variables depend on the configuration; the others are lengths.
        lengths: that letters stand for; random numbers for those without.
    """
    if most < 1:
        return bool(system)
    lengths = lengths or {}
    if any(_apart(part, moving, lengths) for part in _in_two_variables(system, moving)):
        return True
    variables = {place for f in system for place in used(f) if place < moving}
    dimension = min(most, len(variables))  # a zero at all binds no more freedoms than there are variables
    if dimension > 2 or len(system) <= dimension:
        return False
    rng = random.Random(_SEED)
    for prime in _SLICES:
        found = _zeros(system, dimension, moving, rng, prime, lengths)
        if found is not None:
            return not found
    return False  # there are zeros, in extensions alone: real ones, for all that is known


def _in_two_variables(system: Sequence[Polynomial], moving: int) -> Iterator[list[Polynomial]]:
    """Three or more conditions of a system on the same two variables: they rarely have a zero, whatever the others."""
    places = [{place for place in used(f) if place < moving} for f in system]
    for pair in {tuple(sorted(one)) for one in places if len(one) == 2}:
        part = [f for f, here in zip(system, places, strict=True) if here <= {*pair}]
        if 2 < len(part) < len(system):
            yield part


def _apart(system: Sequence[Polynomial], moving: int, lengths: Mapping[str, Fraction]) -> bool:
    """Whether conditions on two variables have no common zero at all."""
    return _zeros(system, 2, moving, random.Random(_SEED), PRIMES[0], lengths) is False


def _without(f: Polynomial, g: Polynomial) -> Polynomial:
    """f without all factors that it shares with g."""
    while g != 0 and not f.is_constant():
        shared = f.gcd(g)
        if shared.is_constant():
            break
        f = divmod(f, shared)[0]
    return f


def _zeros(
    system: Sequence[Polynomial],
    dimension: int,
    moving: int,
    rng: random.Random,
    prime: int,
    lengths: Mapping[str, Fraction],
) -> bool | None:
    """Whether there is a common zero modulo a prime on one random slice; None where there may be others."""
    module = flint()
    context = module.nmod_mpoly_ctx.get(["x", "y"], prime, module.Ordering.lex)
    x, y = context.gens()
    variables = (x, y)[:dimension]
    names = system[0].context().names()
    tangents = {names[place] for f in system for place in used(f) if names[place][0] == "t" and place < moving}
    forms = []
    for place, name in enumerate(system[0].context().names()):
        start = residue(lengths[name], prime) if name in lengths else rng.randrange(prime)
        form = context.constant(start)
        forms.append(sum((rng.randrange(prime) * v for v in variables), form) if place < moving else form)
    circles = [1 + forms[place] ** 2 for place, name in enumerate(system[0].context().names()) if name in tangents]
    sliced = sorted(
        (reduced(f, prime).compose(*forms, ctx=context) for f in system), key=lambda f: int(f.total_degree())
    )
    tick(sum(20 + len(f) for f in system) + (dimension - 1) * len(sliced[0]) * sum(map(len, sliced)))
    if dimension == 1:
        common = reduce(lambda f, g: f.gcd(g), sliced)
        for circle in circles:
            common = _without(common, circle)
        return False if common.is_constant() else (True if roots(dense(common, 0), prime) else None)
    sliced = [f for f in sliced if f != 0]  # for special lengths a condition may always hold
    if len(sliced) < 2:
        return True
    common = reduce(lambda f, g: f.gcd(g), (sliced[0].resultant(f, "y") for f in sliced[1:]))
    if common == 0:
        return True
    for circle in circles:
        if not common.is_constant():
            common = _without(common, sliced[0].resultant(circle, "y"))
    if not common.is_constant():  # a zero of the first with each of the others need not be one of all
        for f, g in combinations(sliced[1:], 2):
            both = f.resultant(g, "y")
            common = common if both == 0 else common.gcd(both)
    if common.is_constant():
        return False
    for at in roots(dense(common, 0), prime):
        there = reduce(lambda f, g: f.gcd(g), (module.nmod_poly(dense(f.subs({"x": at}), 1), prime) for f in sliced))
        if there.degree() > 0 and roots([int(value) for value in there.coeffs()], prime):
            return True
    return None
