"""Methods "determinant" and "cofactors": the singular set as the common zeros of maximal minors.

Determinant (KG eq. 1): of J where it is square, of J Jᵀ where the arm has joints to spare.

Cofactors (KG eq. 2): the rank drops where every maximal minor vanishes.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import prod

import numpy as np

from rankdrop.algebra.polynomial import Equality, Polynomial
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.parts import whole_angles
from rankdrop.exact.conjunctions import Conjunction, SetDerivation, conjunctions, values_of
from rankdrop.exact.determinants import MinorChoice, maximal_minors
from rankdrop.local.block import sample
from rankdrop.units import out_of_units

_ZEROS = 256  # random configurations between which a zero of a polynomial is looked for
_PARTS, _ROUNDS = 65, 9  # of the way between two of them, and of a part of it: to the last digit
_MinorOfAll = tuple[MinorChoice, Polynomial]
"""Rows and columns, and the minor that they make."""


def determinant(builder: SetDerivation) -> None:
    """det J = 0, one condition per factor; else det(J Jᵀ) = 0, as the minors that vanish together.

    det(J Jᵀ) = Σ minor²  (Cauchy and Binet) is never negative, so that it vanishes without a change of sign, and over
    the reals it vanishes where all minors do. It is not multiplied out, nor factored: of a general arm of seven joints
    it has 169,524 terms, its minors 154 to 520. An arm of fewer joints than the task has rows has det(Jᵀ J), which is
    the same sum.

    Args:
        builder: filled in. Sizes: "terms" of the trigonometric polynomial; or "minors" that are not zero everywhere,
            "terms" of all of them, "longest".

    Raises:
        OptionError: the rank is not full anywhere.
        OutOfTime: no time is left.
    """
    columns = builder.chain.columns
    if len(columns) == len(columns[0]):
        builder.full_rank()
        minor = builder.minor(columns, range(len(columns)))
        builder.sizes["terms"] = len(minor)
        parts = factor_by_factor(builder.equality(minor))
        builder.conditions += parts
        builder.note("factors", terms=len(minor), factors=len(parts))
        return
    minors = _minors(builder)
    if len(columns) > len(columns[0]):
        product = "J Jᵀ"
    else:
        product = "Jᵀ J"
    builder.note("squares", product=product, minors=len(minors))
    _vanish_together(builder, minors)


def _minors(builder: SetDerivation) -> list[_MinorOfAll]:
    """The maximal minors that do not vanish everywhere; their sizes are kept."""
    minors = builder.minors(builder.chain.columns, builder.full_rank())
    pairs = [pair for pair in zip(maximal_minors(builder.chain), minors, strict=True) if pair[1] != 0]
    terms = [len(minor) for _, minor in pairs]
    builder.sizes |= {"minors": len(pairs), "terms": sum(terms), "longest": max(terms)}
    return pairs


def _vanish_together(builder: SetDerivation, minors: Sequence[_MinorOfAll]) -> None:
    """Conditions that all minors vanish. A minor that is not factored in time stands as it is, and is noted: the
    conditions hold where the rank drops and nowhere else, whether it has factors or not.
    """
    zero_sets = []
    for choice, minor in minors:
        equality = builder.factored_equality(minor)
        zero_sets.append(equality)
        if equality.whole is not None:
            where = zero_of(builder.chain, minor)
            builder.note("unfactored", choice=choice, terms=len(minor), degree=_degree(builder, minor), zero=where)
    conditions = conjunctions(zero_sets)
    builder.conditions += conditions
    rest = [condition for condition in conditions if len(condition.equal) > 1]
    builder.note("common", factors=len(conditions) - len(rest))
    for condition in rest:
        ways = prod(max(1, len(equality.atoms)) for equality in condition.equal)
        builder.note("together", equations=len(condition.equal), ways=ways)


def _degree(builder: SetDerivation, p: Polynomial) -> int:
    """Degree of a trigonometric polynomial in the sines, cosines and slides."""
    moving = 2 * builder.ring.angles + len(builder.ring.prismatic)
    return max(sum(map(int, powers[:moving])) for powers in p.monoms())


def zero_of(chain: Chain, p: Polynomial) -> tuple[float, ...] | None:
    """A real configuration at which a trigonometric polynomial vanishes, to rounding.

    On the straight way between two random configurations at which its signs differ, part by part; None where all have
    one sign.

    Returns:
        (n,) in joint variables [rad, m].
    """
    theta = sample(chain.own, chain.own_task, _ZEROS, 0) + chain.shifts
    values, _ = values_of(chain, p, theta)
    if values.min() >= 0 or values.max() <= 0:
        return None
    low, high = theta[values.argmin()], theta[values.argmax()]
    for _ in range(_ROUNDS):
        way = np.linspace(low, high, _PARTS)
        values, _ = values_of(chain, p, way)
        first = max(1, int(np.argmax(values >= 0.0)))
        low, high = way[first - 1], way[first]
    zero = out_of_units(chain.robot, (low + high)[None] / 2 - chain.shifts)[0]
    return tuple(map(float, whole_angles(chain.robot, zero)))


def cofactors(builder: SetDerivation) -> None:
    """All maximal minors of J, factored; their common factors, and the conjunction of what is left.

    Nothing is wrong with the answer, but what is left is as many equations as there are minors, whose solution is
    still to be found: their factors could be combined in as many ways as the note says.

    Args:
        builder: filled in. Sizes: "minors" that are not zero everywhere, "terms" of all of them, "longest".

    Raises:
        OptionError: the rank is not full anywhere.
        OutOfTime: no time is left.
    """
    minors = _minors(builder)
    builder.note("cofactors", minors=len(minors), terms=builder.sizes["terms"])
    _vanish_together(builder, minors)


def alternating(minors: Sequence[Polynomial]) -> list[Polynomial]:
    """The cofactors that these minors are, in order."""
    return [-minor if place % 2 else minor for place, minor in enumerate(minors)]


def factor_by_factor(equality: Equality) -> list[Conjunction]:
    """A polynomial that vanishes as one condition for each of its factors."""
    if equality.whole is not None:
        return [Conjunction((equality,))]
    return [Conjunction((Equality((atom,)),)) for atom in equality.atoms]
