"""The determinant (KG eq. 1): of J where it is square, of J Jᵀ where the arm has joints to spare."""

from __future__ import annotations

from rankdrop.exact.algebra.work import OutOfTime
from rankdrop.exact.methods.derivation import Conjunction, Equality
from rankdrop.exact.methods.draft import Draft

LONGEST = 2000
"""Minors of more terms are not squared: that cannot be interrupted, and takes 0.2 s at this length."""


def determinant(draft: Draft) -> None:
    """det J = 0, one condition per factor; else det(J Jᵀ) = 0, which is the sum of the squares of all maximal minors.

    That sum (Cauchy and Binet) is never negative, so that it vanishes without a change of sign, and over the reals it
    vanishes where all minors do; as a polynomial it hardly ever factors further than the minors' common factors.
    An arm of fewer joints than the task has rows has det(Jᵀ J), which is the same sum.

    Args:
        draft: filled in. Sizes: "terms" of the trigonometric polynomial, "half-angle terms" of its longest factor.

    Raises:
        OptionError: the rank is not full anywhere.
        OutOfTime: no time is left.
    """
    rank, columns = draft.full_rank(), draft.chain.columns
    minors = [minor for minor in draft.minors(columns, rank) if minor != 0]
    if len(columns) == len(columns[0]):
        draft.sizes["terms"] = len(minors[0])
        equality = draft.equality(minors[0])
        parts = [Equality((atom,)) for atom in equality.atoms] if equality.whole is None else [equality]
        draft.conditions += [Conjunction((part,)) for part in parts]
        draft.notes.append(f"terms of det J: {len(minors[0])}; different factors: {len(parts)}")
        return
    total = draft.ring.zero
    for minor in minors:
        draft.check("the sum of squares")
        if len(minor) > LONGEST:
            raise OutOfTime(f"the sum of squares: a minor has {len(minor)} terms")
        total = total + minor * minor
    total = draft.ring.reduce(total)
    draft.sizes |= {"minors": len(minors), "terms": len(total)}
    product = "J Jᵀ" if len(columns) > len(columns[0]) else "Jᵀ J"
    draft.notes.append(
        f"det({product}) is the sum of the squares of {len(minors)} minors, {len(total)} terms: never negative, "
        "it vanishes without a change of sign"
    )
    _factored(draft, Equality((), total))


def _factored(draft: Draft, square: Equality) -> None:
    """Conditions of a sum of squares; the sum as it is where its factors are not found in time."""
    found = draft.atoms(square.whole)
    if found is None:
        draft.conditions.append(Conjunction((square,)))
        draft.left.append(f"whether the {square.terms} terms have factors")
        return
    lengths = {atom: 1 if atom.f is None else len(atom.f) for atom in found}
    draft.sizes["half-angle terms"] = max(lengths.values())
    for atom in found:
        alone = len(found) == 1  # then the sum itself is the shorter text
        draft.conditions.append(Conjunction((square if alone else Equality((atom,)),)))
    texts = ", ".join(atom.key if atom.pinned else f"{lengths[atom]} terms" for atom in found)
    draft.notes.append(
        f"it is one irreducible polynomial, of {texts} in half angles" if len(found) == 1
        else f"its factors in half angles: {texts}"
    )  # fmt: skip
