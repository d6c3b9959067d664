"""Method "decomposition": arm and spherical wrist apart, seen from the wrist centre.

With the reference point at the centre of a spherical wrist the Jacobian is block triangular.

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

from rankdrop.algebra.polynomial import Atom, Equality, Polynomial
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.errors import OptionError
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.conjunctions import Columns, Conjunction, SetDerivation, columns_on, conjunctions
from rankdrop.exact.vanishing_minors import alternating
from rankdrop.robot.model import JointKind


def decomposition(builder: SetDerivation) -> None:
    """Conditions of the arm, rank J₁₁ < 3, and of the wrist, at each angle where its axes are dependent.

    Args:
        builder: filled in. Sizes: "arm minors", "wrist minors" at each such angle together.

    Raises:
        OptionError: no spherical wrist, or another task than all six rows.
        OutOfTime: no time is left.
    """
    chain, n = builder.chain, builder.chain.n
    check_wrist(chain)
    builder.full_rank()
    screws = chain.screws(n - 2)  # the origin of this frame is where the wrist's axes meet
    arm = [column[:3] for column in screws[: n - 3]]
    turns = [column[3:] for column in screws]
    turns, wrist = turns[: n - 3], turns[n - 3 :]
    minors = [minor for minor in builder.minors(arm, 3) if minor != 0]
    builder.sizes |= {"arm minors": len(minors), "wrist minors": 0}
    builder.conditions += conjunctions(map(builder.equality, minors))
    before = len(builder.conditions)
    builder.note("arm", minors=len(minors), conditions=before)
    determinant = builder.minor(wrist, range(3))
    for atom in builder.atoms(determinant) or ():  # the sine or cosine of θ_{n−1} and a number
        builder.conditions += _wrist_conditions(builder, atom, arm, turns, wrist)
    builder.note("wrist", joint=n - 1, conditions=len(builder.conditions) - before)


def _wrist_conditions(
    builder: SetDerivation, atom: Atom, arm: Columns, turns: Columns, wrist: Columns
) -> list[Conjunction]:
    """Where rank [J₂₁ N, J₂₂] < 3 with the middle joint at an angle where the wrist's axes are dependent."""
    at_angle = ZeroSet.where_atom(builder.ring, atom)
    arm, turns, wrist = (columns_on(at_angle, block) for block in (arm, turns, wrist))
    beside = [_weighted_rotations(builder, turns, null) for null in _null_space(builder, arm)]
    minors = [minor for minor in builder.minors([*beside, *wrist], 3) if minor != 0]
    builder.sizes["wrist minors"] += len(minors)
    pieces = conjunctions(map(builder.equality, minors))
    return [Conjunction((Equality((atom,)), *piece.equal)) for piece in pieces]


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
    if chain.has_mimics:
        missing = "mimic joints"
    else:
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
    if 0 in (first.twist.sin, second.twist.sin):
        return "parallel axes"
    return ""


def _null_space(builder: SetDerivation, arm: Columns) -> list[list[Polynomial]]:
    """Vectors that span the null space of J₁₁ wherever its rank is 3: cofactors of each four of its columns."""
    basis = []
    for four in combinations(range(len(arm)), 4):
        minors = [builder.minor([arm[i] for i in four if i != left_out], range(3)) for left_out in four]
        vector = dict(zip(four, alternating(minors), strict=True))
        if any(x != 0 for x in minors):
            basis.append([vector.get(i, builder.ring.zero) for i in range(len(arm))])
    return basis


def _weighted_rotations(builder: SetDerivation, columns: Columns, weights: list[Polynomial]) -> list[Polynomial]:
    """Σ w_j column_j, the rotations only."""
    return [
        builder.ring.reduce(sum((column[i] * w for column, w in zip(columns, weights, strict=True)), builder.ring.zero))
        for i in range(3)
    ]
