"""Where a screw that was computed as reciprocal to others vanishes itself, in all of its elements: there it says
nothing (KG section 1).
"""

from __future__ import annotations

from collections.abc import Sequence

from rankdrop.exact.algebra.atom import Atom
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.methods.case import Case
from rankdrop.exact.methods.derivation import Conjunction, Equality
from rankdrop.exact.methods.draft import Draft, pieces
from rankdrop.exact.methods.words import Words

DEEPEST = 3
"""Factors that are followed one after the other; what is left then is told as equations that hold together."""


def vanishing(draft: Draft, case: Case, screw: Sequence[Polynomial], words: Words) -> list[str]:
    """The sets within a case on which every element of a screw vanishes, in words; none where it never does.

    Args:
        draft: of the method.
        case: where.
        screw: its elements, with the pinned joints of the case put in.
        words: of the ring.

    Raises:
        OutOfTime: no time is left.
    """
    found = _merged(_sets(draft, case, screw, DEEPEST))
    return list(dict.fromkeys(words.conjunction(Conjunction(one)) for one in found))


def _sets(draft: Draft, case: Case, screw: Sequence[Polynomial], deepest: int) -> list[tuple[Equality, ...]]:
    """Conjunctions of equalities, beside those of the case."""
    pins = dict(case.pins)
    here = [draft.ring.at(x, pins) for x in screw]
    known = [found for found in (case.factors(draft, w) for w in here if w != 0) if found is not None]
    if not known:
        return [()]
    if frozenset() in known:
        return []
    simple = [factors for factors in known if any(atom.pinned for atom in factors)]
    first = min(simple, key=lambda factors: (sum(not atom.pinned for atom in factors), len(factors)), default=None)
    if deepest == 0 or first is None:
        equalities = (Equality(tuple(sorted(factors, key=lambda atom: atom.key))) for factors in known)
        return [piece.equal for piece in pieces(equalities)]
    found = []
    for atom in sorted(first, key=lambda atom: atom.key):
        part = case.with_zero(draft, atom)
        if part is not None:
            for more in _sets(draft, part, screw, deepest - 1):
                found.append(more if _follows(draft, atom, more) else (Equality((atom,)), *more))
    return found


def _follows(draft: Draft, atom: Atom, more: Sequence[Equality]) -> bool:
    """Whether an atom vanishes once the joints that are pinned after it stand where they do."""
    pins = {one.atoms[0].joint: one.atoms[0].value for one in more if len(one.atoms) == 1 and one.atoms[0].pinned}
    return not atom.pinned and bool(draft.ring.half_at(atom.f, pins) == 0)


def _merged(sets: Sequence[tuple[Equality, ...]]) -> list[tuple[Equality, ...]]:
    """Sets that differ in one angle of one joint alone as one; those inside another one left out."""
    kept = [frozenset(one) for one in sets]
    kept = [one for i, one in enumerate(kept) if not any(other < one or (other == one and j < i)
                                                         for j, other in enumerate(kept))]  # fmt: skip
    joined = True
    while joined:
        joined = False
        for i, one in enumerate(kept):
            for other in kept[i + 1 :]:
                both = _joined(one, other)
                if both is not None:
                    kept = [both if x is one else x for x in kept if x is not other]
                    joined = True
                    break
            if joined:
                break
    return [tuple(sorted(one, key=lambda equality: (equality.terms, [a.key for a in equality.atoms]))) for one in kept]


def _joined(one: frozenset[Equality], other: frozenset[Equality]) -> frozenset[Equality] | None:
    """Two sets that are the same but for the angles of one joint."""
    mine, theirs = one - other, other - one
    if len(mine) != 1 or len(theirs) != 1:
        return None
    atoms = (*next(iter(mine)).atoms, *next(iter(theirs)).atoms)
    if not all(atom.pinned for atom in atoms) or len({atom.joint for atom in atoms}) != 1:
        return None
    return (one & other) | {Equality(tuple(sorted(atoms, key=lambda atom: atom.key)))}
