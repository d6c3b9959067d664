"""Three methods that begin with minors: determinant, cofactors, decomposition.

The determinant (KG eq. 1): of J where it is square, of J Jᵀ where the arm has joints to spare.

Cofactors (KG eq. 2): the rank drops where every maximal minor vanishes.

Decomposition: with the reference point at the centre of a spherical wrist the Jacobian is block triangular.

    J = [[J₁₁, 0], [J₂₁, J₂₂]]     rows v of the wrist centre, then ω;  J₁₁ is 3 × (n − 3),  J₂₂ is 3 × 3

The wrist does not move its centre. With N a basis of the null space of J₁₁, rank J = rank J₁₁ + rank [J₂₁ N, J₂₂].
Hence J is singular where

    rank J₁₁ < 3                   the arm cannot move the wrist centre; the wrist adds 3 at most: rank J ≤ 5
    rank [J₂₁ N, J₂₂] < 3          the wrist's axes are dependent, and motions of the arm about the centre do not help

Where rank J₁₁ = 3, its null space is spanned by the cofactors of its 3 × 4 submatrices, so that N is polynomial.
Elsewhere all of them vanish, and the second line may hold or not: the first one does.
"""

from __future__ import annotations

from itertools import combinations

from rankdrop.errors import OptionError
from rankdrop.exact.algebra.polynomial import Equality, Polynomial
from rankdrop.exact.algebra.work import OutOfTime
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.methods.builder import Columns, DerivationBuilder, conjunctions
from rankdrop.exact.methods.derivation import Conjunction
from rankdrop.robot.model import JointKind

LONGEST = 2000
"""Minors of more terms are not squared: that cannot be interrupted, and takes 0.2 s at this length."""


def determinant(builder: DerivationBuilder) -> None:
    """det J = 0, one condition per factor; else det(J Jᵀ) = 0, which is the sum of the squares of all maximal minors.

    That sum (Cauchy and Binet) is never negative, so that it vanishes without a change of sign, and over the reals it
    vanishes where all minors do; as a polynomial it hardly ever factors further than the minors' common factors.
    An arm of fewer joints than the task has rows has det(Jᵀ J), which is the same sum.

    Args:
        builder: filled in. Sizes: "terms" of the trigonometric polynomial, "half-angle terms" of its longest factor.

    Raises:
        OptionError: the rank is not full anywhere.
        OutOfTime: no time is left.
    """
    rank, columns = builder.full_rank(), builder.chain.columns
    minors = [minor for minor in builder.minors(columns, rank) if minor != 0]
    if len(columns) == len(columns[0]):
        builder.sizes["terms"] = len(minors[0])
        equality = builder.equality(minors[0])
        parts = [Equality((atom,)) for atom in equality.atoms] if equality.whole is None else [equality]
        builder.conditions += [Conjunction((part,)) for part in parts]
        builder.notes.append(f"terms of det J: {len(minors[0])}; different factors: {len(parts)}")
        return
    total = builder.ring.zero
    for minor in minors:
        builder.check("the sum of squares")
        if len(minor) > LONGEST:
            raise OutOfTime(f"the sum of squares: a minor has {len(minor)} terms")
        total = total + minor * minor
    total = builder.ring.reduce(total)
    builder.sizes |= {"minors": len(minors), "terms": len(total)}
    product = "J Jᵀ" if len(columns) > len(columns[0]) else "Jᵀ J"
    builder.notes.append(
        f"det({product}) is the sum of the squares of {len(minors)} minors, {len(total)} terms: never negative, "
        "it vanishes without a change of sign"
    )
    _factored(builder, Equality((), total))


def _factored(builder: DerivationBuilder, square: Equality) -> None:
    """Conditions of a sum of squares; the sum as it is where its factors are not found in time."""
    found = builder.atoms(square.whole)
    if found is None:
        builder.conditions.append(Conjunction((square,)))
        builder.left.append(f"whether the {square.terms} terms have factors")
        return
    lengths = {atom: 1 if atom.f is None else len(atom.f) for atom in found}
    builder.sizes["half-angle terms"] = max(lengths.values())
    for atom in found:
        alone = len(found) == 1  # then the sum itself is the shorter text
        builder.conditions.append(Conjunction((square if alone else Equality((atom,)),)))
    texts = ", ".join(atom.key if atom.pinned else f"{lengths[atom]} terms" for atom in found)
    builder.notes.append(
        f"it is one irreducible polynomial, of {texts} in half angles" if len(found) == 1
        else f"its factors in half angles: {texts}"
    )  # fmt: skip


def cofactors(builder: DerivationBuilder) -> None:
    """All maximal minors of J, factored; their common factors, and the conjunction of what is left.

    Nothing is wrong with the answer, but what is left is as many equations as there are minors, whose solution is
    still to be found: their factors could be combined in as many ways as the note says.

    Args:
        builder: filled in. Sizes: "minors" that are not zero everywhere, "terms" of all of them, "longest".

    Raises:
        OptionError: the rank is not full anywhere.
        OutOfTime: no time is left.
    """
    rank = builder.full_rank()
    found = [minor for minor in builder.minors(builder.chain.columns, rank) if minor != 0]
    terms = [len(minor) for minor in found]
    builder.sizes |= {"minors": len(found), "terms": sum(terms), "longest": max(terms)}
    equalities = [builder.equality(minor) for minor in found]
    builder.conditions += conjunctions(equalities)
    common = [c for c in builder.conditions if len(c.equal) == 1]
    builder.notes.append(f"{len(found)} minors, {sum(terms)} terms together, {len(common)} common factors")
    rest = [c for c in builder.conditions if len(c.equal) > 1]
    for conjunction in rest:
        ways = 1
        for equality in conjunction.equal:
            ways *= max(1, len(equality.atoms))
        builder.notes.append(
            f"besides them {len(conjunction.equal)} equations hold together; their factors combine in {ways} ways"
        )


def decomposition(builder: DerivationBuilder) -> None:
    """Conditions of the arm, rank J₁₁ < 3, and of the wrist, at each angle where its axes are dependent.

    Args:
        builder: filled in. Sizes: "arm minors", "wrist minors" at each such angle together.

    Raises:
        OptionError: no spherical wrist, or another task than all six rows.
        OutOfTime: no time is left.
    """
    chain = builder.chain
    check_wrist(chain)
    builder.full_rank()
    n = chain.n
    screws = chain.screws(n - 2)  # the origin of this frame is where the wrist's axes meet
    arm = [column[:3] for column in screws[: n - 3]]
    found = [minor for minor in builder.minors(arm, 3) if minor != 0]
    builder.sizes["arm minors"] = len(found)
    builder.conditions += conjunctions([builder.equality(minor) for minor in found])
    builder.notes.append(f"arm: rank J11 < 3, {len(found)} minors in {len(builder.conditions)} conditions")
    determinant = builder.minor([column[3:] for column in screws[n - 3 :]], range(3))
    turns = [column[3:] for column in screws[: n - 3]]
    before, builder.sizes["wrist minors"] = len(builder.conditions), 0
    for atom in builder.atoms(determinant) or ():  # the sine or cosine of θ_{n−1} and a number
        pins = {atom.joint: atom.value}
        at = [[builder.ring.at(x, pins) for x in column] for column in (*turns, *(c[3:] for c in screws[n - 3 :]))]
        moved = [[builder.ring.at(x, pins) for x in column] for column in arm]
        beside = [_combined(builder, at[: n - 3], null) for null in _null_space(builder, moved)]
        minors = [minor for minor in builder.minors([*beside, *at[n - 3 :]], 3) if minor != 0]
        builder.sizes["wrist minors"] += len(minors)
        pinned = Equality((atom,))
        for piece in conjunctions([builder.equality(minor) for minor in minors]):
            builder.conditions.append(Conjunction((pinned, *piece.equal)))
    builder.notes.append(
        f"wrist: rank [J21 N, J22] < 3, only where det J22 = 0, at two angles of joint {n - 1}: "
        f"{len(builder.conditions) - before} conditions"
    )


def check_wrist(chain: Chain) -> None:
    """Refuse an arm without a spherical wrist.

    Raises:
        OptionError: says what is missing.
    """
    where = f"robot {chain.robot.name!r}, task {chain.task.name}"
    if chain.task.m < 6:
        raise OptionError(
            "decomposition needs a task of all six rows", where=where, got=f"{chain.task.m} rows",
            mend="use the method determinant or cofactors",
        )  # fmt: skip
    missing = _missing(chain)
    if missing:
        raise OptionError(
            "decomposition needs a spherical wrist: the last three axes meet in one point", where=where, got=missing,
            mend="use the method cofactors, reciprocity or singular_vector",
        )  # fmt: skip


def _missing(chain: Chain) -> str:
    """Why the last three joints are no spherical wrist; empty where they are one."""
    if chain.n < 6:
        return f"{chain.n} joints"
    first, second, third = chain.sections[-3:]
    if any(section.kind is not JointKind.REVOLUTE for section in (first, second, third)):
        return "a slide among them"
    gaps = {f"a{chain.n - 2}": first.a, f"d{chain.n - 1}": second.d, f"a{chain.n - 1}": second.a}
    apart = [f"{name} = {float(value):.6g} m" for name, value in gaps.items() if value != 0]
    if apart:
        return ", ".join(apart)
    return "parallel axes" if 0 in (first.twist.sin, second.twist.sin) else ""


def _null_space(builder: DerivationBuilder, arm: Columns) -> list[list[Polynomial]]:
    """Vectors that span the null space of J₁₁ wherever its rank is 3: cofactors of each four of its columns."""
    found = []
    for four in combinations(range(len(arm)), 4):
        vector = [builder.ring.zero] * len(arm)
        for place, left_out in enumerate(four):
            minor = builder.minor([arm[i] for i in four if i != left_out], range(3))
            vector[left_out] = -minor if place % 2 else minor
        if any(x != 0 for x in vector):
            found.append(vector)
    return found


def _combined(builder: DerivationBuilder, columns: Columns, weights: list[Polynomial]) -> list[Polynomial]:
    """Σ w_j column_j, the rotations only."""
    return [
        builder.ring.reduce(sum((column[i] * w for column, w in zip(columns, weights, strict=True)), builder.ring.zero))
        for i in range(3)
    ]
