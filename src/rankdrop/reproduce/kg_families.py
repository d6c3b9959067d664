"""KG sections 3.4 and 4: how many families, whether they meet, whether they are all."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from rankdrop import conditions
from rankdrop.exact import derive, exact_chain
from rankdrop.reproduce import kg_text as kg
from rankdrop.reproduce.formula import value
from rankdrop.reproduce.item import Sheet, Shown
from rankdrop.reproduce.kg_arm import SMALL, arm, found, on, sigma6, singular
from rankdrop.robot import Array


def families(sheet: Sheet) -> None:
    """Sections 3.4 and 4: how many, disjoint, complete, without denominators."""
    ours = found()
    sheet.numbers("section 3.4", "families of singular configurations", "5", len(ours.families),
                  layout="five families of singular configurations")  # fmt: skip
    whole = all(int(x.q) == 1 for f in ours.families for p in f.equalities + f.inequalities for x in p.coeffs())
    sheet.claim("section 3.4", "denominators in the equations", "no denominators",
                "all coefficients are whole numbers", whole)
    both = {pair: _meeting(*pair) for pair in combinations(kg.FAMILIES, 2)}
    meet = [f"{one} and {two}" for (one, two), q in both.items() if len(q)]
    top = max(float(sigma6(q).max()) for q in both.values() if len(q))
    apart = all(f.stratum.apart(g.stratum) is not None for f, g in combinations(ours.families, 2))
    sheet.claim(
        "abstract, section 3.4", "do the printed families meet",
        "no intersections between any two of the five families",
        f"eqs {', '.join(meet)} do; ours do not, with s2 ≠ 0 added to eqs 20 and 26", not meet,
        reason="Where s2 = 0 the conditions of eq. 20 and of eq. 21 can hold together, and so can those of 26 and 27.",
        shown=Shown(f"Configurations on both were solved for; σ6 ≤ {SMALL:.0e} there.",
                    meet == ["20 and 21", "26 and 27"] and top < SMALL and apart),
    )  # fmt: skip
    subsets(sheet)
    irreducible(sheet)
    q = singular()
    sheet.claim("section 3.4", "are the families complete", "the same as those presented in [10]",
                f"every one of {len(q)} singular configurations from random starts lies on one of them, within 1e-5",
                bool(_explained(q).all()), reason="[10] itself is not at hand.")  # fmt: skip
    efficiency(sheet)
    sheet.claim("section 4", "ranks lost on the families", "loses at least one DOF",
                "rank 5 at random points of each, exactly", all(f.ranks == (5,) for f in ours.families))  # fmt: skip


def efficiency(sheet: Sheet) -> None:
    """Section 4: what there is to read of each method's answer, in the same frame and with the same basic screws."""
    ours = found()
    chain = exact_chain(arm(), lengths=kg.LENGTHS)
    other = derive(chain, "reciprocity", 20.0, frame=5, basic=tuple(range(2, 8)))
    terms = sum(len(p) for family in ours.families for p in (*family.equalities, *family.inequalities))
    groups = [(*one.equal, *(e for group in one.unequal for e in group)) for one in other.conditions]
    read = sum(equality.terms for group in groups for equality in group)
    sheet.claim(
        "section 4", "efficiency: sets of conditions, and the terms in them", "as efficient as the reciprocity-based "
        "method", f"suppression {len(ours.families)} sets with {terms} terms, reciprocity {len(groups)} with {read}",
        other.complete and len(ours.families) <= len(groups) and terms <= read,
        reason="KG give no measure: this is what there is to read of two complete derivations. "
        "benchmarks/suppression.py has the time as well, and further arms.",
    )  # fmt: skip


def _meeting(one: int, two: int) -> Array:
    """(N, 7) configurations that lie on two printed families."""
    zeros = tuple(dict.fromkeys(kg.FAMILIES[one][0] + kg.FAMILIES[two][0]))
    others = tuple(dict.fromkeys(kg.FAMILIES[one][1] + kg.FAMILIES[two][1]))
    if set(zeros) & set(others):
        return np.zeros((0, 7))
    q = on(zeros, 7, 200)
    return np.asarray(q[np.min([np.abs(value(text, q, kg.LENGTHS)) for text in (*others, "1")], axis=0) > 1e-3])


def _explained(q: Array) -> Array:
    """Whether configurations lie on some printed family, its inequalities left away as in section 3.4."""
    distances = [
        np.max([np.abs(value(text, q, kg.LENGTHS)) for text in zeros], axis=0) for zeros, _ in kg.FAMILIES.values()
    ]
    return np.asarray(np.min(distances, axis=0) < 1e-5)


SUBSETS = (("(a)", 26, "s6", 20), ("(b)", 27, "s6", 21), ("(c)", 20, "s4", 15), ("(c)", 21, "s4", 15))
"""Part of section 3.4, equation, what becomes zero as well, the equation it then belongs to."""


def subsets(sheet: Sheet) -> None:
    """Section 3.4: what the families become when an inequality is dropped."""
    for part, equation, added, into in SUBSETS:
        q = on((*kg.FAMILIES[equation][0], added), 11, 300)
        left = max((float(np.abs(value(text, q, kg.LENGTHS)).max()) for text in kg.FAMILIES[into][0]), default=0.0)
        sheet.identity(f"section 3.4 {part}", f"eq. {equation} with {added} = 0 against eq. {into}",
                       f"a subset of eq. ({into})",
                       left if len(q) > 10 else np.inf, tolerance=1e-7)  # fmt: skip


def irreducible(sheet: Sheet) -> None:
    """What the five families consist of."""
    pieces = conditions(arm(), lengths=kg.LENGTHS, coranks=1, points=0, special=False).families
    straight = [f"{{{', '.join(piece.texts)}}}" for piece in pieces if piece.texts[0].startswith("θ4")]
    folded = [f"{{{', '.join(piece.texts)}}}" for piece in pieces if piece.texts[0].startswith("θ5")]
    covered = _explained(np.array([piece.witness for piece in pieces]))
    sheet.claim(
        "section 3.4", "irreducible families", "eqs (15), (20), (21), (26) and (27)",
        f"{len(pieces)}: eq. 15 is {', '.join(straight)}; eq. 26 is {', '.join(folded)}",
        bool(covered.all()) and len(straight) == 3 and len(folded) == 1,
        reason="The same set; KG do not say that theirs are irreducible.",
    )  # fmt: skip
