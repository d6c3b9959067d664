"""KG: a dependent-screw suppression approach to the singularity analysis of 7-DOF redundant manipulators, Canadarm2."""

from __future__ import annotations

from itertools import combinations
from math import comb

import numpy as np

from papers import kg_text as kg
from papers.formula import matrix, value
from papers.item import Sheet, Shown
from papers.kg_arm import (
    DAMAGED,
    SMALL,
    arm,
    derivation,
    determinant,
    on,
    places,
    screws,
    sigma6,
    singular,
    with_zero,
    worst,
)
from rankdrop import conditions
from rankdrop.exact import METHODS, ZeroDistances, derive, exact_chain, suppress
from rankdrop.kinematics import jacobian
from rankdrop.robot import Array, from_dh
from rankdrop.text import conditions_text, notes_of

LISTED = "determinant, cofactor, decomposition, reciprocity, singular vector"
"""The approaches of section 1."""
BOTH = "random points of the printed one have rank 5 and lie on ours, and singular points on ours lie on it."


def figure_1(sheet: Sheet) -> None:
    """The arm."""
    letters = {name: str(length) for name, length in kg.LENGTHS.items()}
    rows = [(*(letters.get(entry, entry) for entry in row), 0) for row in kg.DH]
    printed = from_dh(rows, convention="modified")
    q = places()
    text = "; ".join(" ".join(row) for row in kg.DH)
    sheet.identity("Figure 1(b)", "link parameters (a_{j−1}, α_{j−1}, d_j): Jacobian of the catalogue's Canadarm2",
                   text,
                   worst(jacobian(printed, q), jacobian(arm(), q)), tolerance=1e-12, reason=DAMAGED)  # fmt: skip
    z = jacobian(arm(), q)[:, 3:]
    sheet.identity("section 3.1", "axes of joints 3, 4, 5", "parallel: a planar joint",
                   float(max(np.abs(np.cross(z[:, :, 2], z[:, :, j])).max() for j in (3, 4))))  # fmt: skip


def listed_methods() -> str:
    """Our methods in KG's words; elementary transformations came later."""
    listed = [name for name in METHODS if name != "elementary"]
    return ", ".join(listed).replace("cofactors", "cofactor").replace("_", " ")


def methods(sheet: Sheet) -> None:
    """Section 1: the five approaches."""
    q = on(("s4", kg.EQ_15), 1, 20)
    J = jacobian(arm(), q)
    grams = np.linalg.det(J @ J.swapaxes(1, 2))
    sheet.identity("eq. 1", "|J Jᵀ| at singular configurations", "|J Jᵀ| = 0", float(np.abs(grams).max()),
                   tolerance=1e-6)
    minors = [np.linalg.det(np.delete(J, j, axis=2)) for j in range(7)]
    sheet.identity("eq. 2", "the seven sub-determinants there", "all are 0", float(np.abs(minors).max()),
                   tolerance=1e-6)
    chain = exact_chain(arm(), lengths=kg.LENGTHS)
    cofactors = derive(chain, "cofactors", 20.0)
    sheet.claim("section 1, (2)", "conditions of the cofactor approach", "difficult to use for the Canadarm2",
                f"{cofactors.sizes['minors']} equations with {cofactors.sizes['terms']} terms, to hold together",
                cofactors.sizes["minors"] == comb(7, 6))  # fmt: skip
    sheet.same("section 1", "the approaches it lists", LISTED, listed_methods(),
               reason="Each derives the singular set here (rankdrop.conditions, method=…); tests compare them.")
    vanishing_screw(sheet)
    basic = suppress(exact_chain(arm(), lengths=kg.LENGTHS)).basic
    sheet.same("section 2, 3.1", "basic screws that conditions (a) to (c) choose", "2 3 4 5 6 7",
               " ".join(map(str, basic)), reason="KG leave joints 1–6 and 2–7 to choose from, and take 2–7.")


def vanishing_screw(sheet: Sheet) -> None:
    """Section 1: where a reciprocal screw says nothing in the case s4 = 0.

    The screw reciprocal to five joint screws is made of their minors of order 5, and vanishes where these five are
    dependent.
    """
    there, elsewhere = with_zero(4), with_zero(4)
    turn = np.arange(len(there))
    there[:, 4] = np.where(turn % 4 < 2, np.pi / 2, -np.pi / 2)
    there[:, 5] = np.where(turn % 8 < 4, 0.0, np.pi)
    fives = [list(five) for five in combinations(range(1, 7), 5)]
    vanish = max(float(np.linalg.svd(screws(there)[..., five], compute_uv=False)[:, 4].max()) for five in fives)
    remain = [float(np.median(np.linalg.svd(screws(elsewhere)[..., five], compute_uv=False)[:, 4])) for five in fives]
    some = sum(size > 1e-3 for size in remain)
    chain = exact_chain(arm(), lengths=kg.LENGTHS)
    notes = notes_of(derive(chain, "reciprocity", 20.0, frame=5, basic=tuple(range(2, 8))))
    told = sum(note.startswith("  all six") and "θ5 = ±π/2 and (θ6 = 0 or π)" in note for note in notes)
    sheet.claim(
        "section 1", "where s4 = 0, the screw reciprocal to five of $2 … $7, at s6 = 0 and c5 = 0",
        "all the six elements vanish (of the expression in row 1 of Table 3 in [10])",
        f"all six vanish, whichever five are taken; where s4 = 0 alone they do not for {some} of the {len(fives)}",
        vanish < SMALL and some > 0 and told == 2,
        reason="The expression of [10] is not printed here; ours, in frame 5, says the same of itself at θ4 = 0 and at "
        "θ4 = π (rankdrop conditions canadarm2 --method reciprocity --basic 2-7 --frame 5 --steps).",
    )  # fmt: skip


def matrices(sheet: Sheet) -> None:
    """Equations 5 to 7 and the three cases."""
    q = places()
    sheet.identity("eq. 5", "screw 1 in frame 5 (ω; v)", kg.EQ_5_FIRST.replace("\n", "; "),
                   worst(matrix(kg.EQ_5_FIRST, q, kg.LENGTHS)[..., 0], screws(q)[..., 0]), reason=DAMAGED)  # fmt: skip
    sheet.identity("eqs 5, 6", "screws 2 to 7 in frame 5", kg.EQ_6.replace("\n", "; "),
                   worst(matrix(kg.EQ_6, q, kg.LENGTHS), screws(q)[..., 1:]), reason=DAMAGED)  # fmt: skip
    sheet.identity("eq. 7", "|$2 … $7|", kg.EQ_7, worst(value(kg.EQ_7, q, kg.LENGTHS), determinant(q, (2, 3, 4, 5, 6,
                   7))),
                   reason=f"{DAMAGED} Derived exactly as {derivation().determinant}, rows (v; ω).")  # fmt: skip
    cases = [conditions_text(case.stratum) for case in derivation().start.cases]
    printed = ("s4 = 0", "s6 = 0, s4 ≠ 0", "a s345 + d c3 + d c34 = 0, s4 ≠ 0, s6 ≠ 0")
    for number, (text, ours) in enumerate(zip(printed, cases, strict=True), start=1):
        sheet.same(f"eq. {7 + number}", f"case {number}", text, ours, reason=DAMAGED if number == 3 else "")


def case_1(sheet: Sheet) -> None:
    """Equations 11 to 15."""
    q = with_zero(4)
    sheet.identity("eq. 11", "screws 2 to 7 where s4 = 0", kg.EQ_11.replace("\n", "; "),
                   worst(matrix(kg.EQ_11, q, kg.LENGTHS), screws(q)[..., 1:]), reason=DAMAGED)  # fmt: skip
    sheet.identity("eq. 12", "screw 1 where s4 = 0", kg.EQ_12_FIRST.replace("\n", "; "),
                   worst(matrix(kg.EQ_12_FIRST, q, kg.LENGTHS)[..., 0], screws(q)[..., 0]), reason=DAMAGED)  # fmt: skip
    _dependent(sheet, "section 3.3.1", 1, "$3 of $4, $5")
    sheet.identity("eqs 13, 14", "|$1 $2 $4 $5 $6 $7| where s4 = 0", f"d c4 [{kg.EQ_15}]",
                   worst(value(f"d c4 ({kg.EQ_15})", q, kg.LENGTHS), determinant(q, (1, 2, 4, 5, 6, 7))),
                   reason=DAMAGED)
    texts = conditions_text(derivation().families[0].stratum)
    sheet.claim("eq. 15", "family 1", f"s4 = 0, {kg.EQ_15} = 0", texts, _same_family(15, 0),
                reason="The same set written otherwise: " + BOTH)


def _dependent(sheet: Sheet, item: str, number: int, printed: str) -> None:
    """Which screw is dependent in a case."""
    dependence = derivation().start.cases[number - 1].dependence
    assert dependence is not None
    ours = f"${dependence.screw} of {', '.join(f'${j}' for j in dependence.on)}"
    sheet.same(item, f"dependent screw of case {number}, and what it is a combination of", printed, ours)


def _same_family(equation: int, index: int) -> bool:
    """Whether random points of the printed family have rank 5 and satisfy ours, and those of ours the printed one.

    Points of the printed family are solved for; for the other way singular configurations from random starts are on
    both families or on neither.
    """
    zeros, others = kg.FAMILIES[equation]
    q = on(zeros, equation)
    q = q[np.min([np.abs(value(text, q, kg.LENGTHS)) for text in (*others, "1")], axis=0) > 1e-3]
    family, anywhere = derivation().families[index], singular()
    ours = np.max([ZeroDistances(derivation().chain, anywhere).of(p) for p in family.equalities], axis=0) < 1e-5
    printed = np.max([np.abs(value(text, anywhere, kg.LENGTHS)) for text in zeros], axis=0) < 1e-5
    distances = ZeroDistances(derivation().chain, q)
    return (
        len(q) > 20 and bool(sigma6(q).max() < SMALL) and int(ours.sum()) > 20 and bool((ours == printed).all())
        and all(float(distances.of(p).max()) < 1e-5 for p in family.equalities)
    )  # fmt: skip


def case_2(sheet: Sheet) -> None:
    """Equations 16 to 21."""
    q = with_zero(6)
    last = matrix(kg.EQ_16_LAST, q, kg.LENGTHS)[..., 0]
    sheet.identity("eq. 16", "screw 7 where s6 = 0", kg.EQ_16_LAST.replace("\n", "; "), worst(last, screws(q)[..., 6]),
                   reason=DAMAGED)  # fmt: skip
    put_in = matrix(kg.EQ_6, q, kg.LENGTHS)[..., 5]
    straight = matrix(kg.EQ_11, q, kg.LENGTHS)
    off = worst(straight, screws(q)[..., 1:])
    apart = {"Eq. (6)": worst(put_in, screws(q)[..., 6]), "Eq. (11)": off}
    sheet.claim(
        "section 3.3.2", "the equation into which s6 = 0 is put", "Eq. (11)",
        ", ".join(name for name, error in apart.items() if error < SMALL), off < SMALL,
        reason="Eq. 11 is eq. 6 with s4 = 0, and in this case s4 ≠ 0.",
        shown=Shown("Eq. 6 with s6 = 0 gives the screws of eq. 16, eq. 11 does not.",
                    worst(put_in, screws(q)[..., 6]) < SMALL and off > 0.01),
    )  # fmt: skip
    _dependent(sheet, "section 3.3.2", 2, "$7 of $3, $4, $5")
    sheet.identity("eqs 17 to 19", "|$1 … $6| (where s6 = 0, and elsewhere: it has no θ6)", kg.EQ_19,
                   worst(value(kg.EQ_19, q, kg.LENGTHS), determinant(q, (1, 2, 3, 4, 5, 6))), reason=DAMAGED)
    _family(sheet, 20, 2)
    _family(sheet, 21, 1)


def case_3(sheet: Sheet) -> None:
    """Equations 22 to 27."""
    q = places()
    sheet.identity("eq. 22", "|$3 $4 $5 $6 $7|, rows 1 to 5", kg.EQ_22,
                   worst(value(kg.EQ_22, q, kg.LENGTHS), determinant(q, (3, 4, 5, 6, 7), 5)), reason=DAMAGED)
    dependence = derivation().start.cases[2].dependence
    assert dependence is not None
    sheet.claim(
        "section 3.3.3", "dependent screw of case 3, which is removed", "$5, of $3, $4, $5, $6 and $7",
        f"${dependence.screw}, of {', '.join(f'${j}' for j in dependence.on)}", dependence.screw == 5,
        reason="$3 to $7 are independent by eq. 22, so none of them is a combination of the others; eq. 23 lacks $2.",
        shown=Shown("", dependence.screw == 2 and dependence.on == (3, 4, 5, 6, 7)),
    )  # fmt: skip
    there = on((kg.EQ_10,), 25)
    sheet.identity("eqs 23 to 25", "|$1 $3 $4 $5 $6 $7| where eq. 10 holds", kg.EQ_25,
                   worst(value(kg.EQ_25, there, kg.LENGTHS), determinant(there, (1, 3, 4, 5, 6, 7))), reason=DAMAGED)
    _family(sheet, 26, 4)
    _family(sheet, 27, 3)


def _family(sheet: Sheet, equation: int, index: int) -> None:
    """One of KG's families beside ours."""
    zeros, others = kg.FAMILIES[equation]
    printed = ", ".join([*(f"{text} = 0" for text in zeros), *(f"{text} ≠ 0" for text in others)])
    sheet.claim(f"eq. {equation}", "a family of singular configurations", printed,
                conditions_text(derivation().families[index].stratum), _same_family(equation, index),
                reason="The same set: " + BOTH)  # fmt: skip


def families(sheet: Sheet) -> None:
    """Sections 3.4 and 4: how many, disjoint, complete, without denominators."""
    ours = derivation()
    sheet.numbers("section 3.4", "families of singular configurations", "5", len(ours.families),
                  layout="five families of singular configurations")  # fmt: skip
    coefficients = [x for f in ours.families for p in f.equalities + f.stratum.open for x in p.coeffs()]
    fractions = sum(int(x.q) != 1 for x in coefficients)
    sheet.claim("section 3.4", "denominators in the equations", "no denominators",
                f"{fractions} of {len(coefficients)} coefficients", fractions == 0)
    both = {pair: _meeting(*pair) for pair in combinations(kg.FAMILIES, 2)}
    meet = [f"{one} and {two}" for (one, two), q in both.items() if len(q)]
    top = max(float(sigma6(q).max()) for q in both.values() if len(q))
    apart = all(f.stratum.separating_polynomial(g.stratum) is not None for f, g in combinations(ours.families, 2))
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
    ranks = ", ".join(str(rank) for f in ours.families for rank in f.ranks)
    sheet.claim("section 4", "ranks lost on the families", "loses at least one DOF",
                f"ranks at random points of each, exactly: {ranks}",
                all(f.ranks == (5,) for f in ours.families))  # fmt: skip


def efficiency(sheet: Sheet) -> None:
    """Section 4: what there is to read of each method's answer, in the same frame and with the same basic screws."""
    ours = derivation()
    chain = exact_chain(arm(), lengths=kg.LENGTHS)
    other = derive(chain, "reciprocity", 20.0, frame=5, basic=tuple(range(2, 8)))
    terms = sum(len(p) for family in ours.families for p in (*family.equalities, *family.stratum.open))
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


SECTIONS = (
    ("Figure 1", figure_1), ("methods", methods), ("matrices", matrices), ("case 1", case_1), ("case 2", case_2),
    ("case 3", case_3), ("families", families),
)  # fmt: skip
