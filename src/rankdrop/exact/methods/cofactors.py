"""Cofactors (KG eq. 2): the rank drops where every maximal minor vanishes."""

from __future__ import annotations

from rankdrop.exact.methods.draft import Draft, pieces


def cofactors(draft: Draft) -> None:
    """All maximal minors of J, factored; their common factors, and the conjunction of what is left.

    Nothing is wrong with the answer, but what is left is as many equations as there are minors, whose solution is
    still to be found: their factors could be combined in as many ways as the note says.

    Args:
        draft: filled in. Sizes: "minors" that are not zero everywhere, "terms" of all of them, "longest".

    Raises:
        OptionError: the rank is not full anywhere.
        OutOfTime: no time is left.
    """
    rank = draft.full_rank()
    found = [minor for minor in draft.minors(draft.chain.columns, rank) if minor != 0]
    terms = [len(minor) for minor in found]
    draft.sizes |= {"minors": len(found), "terms": sum(terms), "longest": max(terms)}
    equalities = [draft.equality(minor) for minor in found]
    draft.conditions += pieces(equalities)
    common = [c for c in draft.conditions if len(c.equal) == 1]
    draft.notes.append(f"{len(found)} minors, {sum(terms)} terms together, {len(common)} common factors")
    rest = [c for c in draft.conditions if len(c.equal) > 1]
    for conjunction in rest:
        ways = 1
        for equality in conjunction.equal:
            ways *= max(1, len(equality.atoms))
        draft.notes.append(
            f"besides them {len(conjunction.equal)} equations hold together; their factors combine in {ways} ways"
        )
