"""Decomposition: with the reference point at the centre of a spherical wrist the Jacobian is block triangular.

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
from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.methods.derivation import Conjunction, Equality
from rankdrop.exact.methods.draft import Columns, Draft, pieces
from rankdrop.robot.model import JointKind


def decomposition(draft: Draft) -> None:
    """Conditions of the arm, rank J₁₁ < 3, and of the wrist, at each angle where its axes are dependent.

    Args:
        draft: filled in. Sizes: "arm minors", "wrist minors" at each such angle together.

    Raises:
        OptionError: no spherical wrist, or another task than all six rows.
        OutOfTime: no time is left.
    """
    chain = draft.chain
    check_wrist(chain)
    draft.full_rank()
    n = chain.n
    screws = chain.screws(n - 2)  # the origin of this frame is where the wrist's axes meet
    arm = [column[:3] for column in screws[: n - 3]]
    found = [minor for minor in draft.minors(arm, 3) if minor != 0]
    draft.sizes["arm minors"] = len(found)
    draft.conditions += pieces([draft.equality(minor) for minor in found])
    draft.notes.append(f"arm: rank J11 < 3, {len(found)} minors in {len(draft.conditions)} conditions")
    determinant = draft.minor([column[3:] for column in screws[n - 3 :]], range(3))
    turns = [column[3:] for column in screws[: n - 3]]
    before, draft.sizes["wrist minors"] = len(draft.conditions), 0
    for atom in draft.atoms(determinant) or ():  # the sine or cosine of θ_{n−1} and a number
        pins = {atom.joint: atom.value}
        at = [[draft.ring.at(x, pins) for x in column] for column in (*turns, *(c[3:] for c in screws[n - 3 :]))]
        moved = [[draft.ring.at(x, pins) for x in column] for column in arm]
        beside = [_combined(draft, at[: n - 3], null) for null in _null_space(draft, moved)]
        minors = [minor for minor in draft.minors([*beside, *at[n - 3 :]], 3) if minor != 0]
        draft.sizes["wrist minors"] += len(minors)
        pinned = Equality((atom,))
        for piece in pieces([draft.equality(minor) for minor in minors]):
            draft.conditions.append(Conjunction((pinned, *piece.equal)))
    draft.notes.append(
        f"wrist: rank [J21 N, J22] < 3, only where det J22 = 0, at two angles of joint {n - 1}: "
        f"{len(draft.conditions) - before} conditions"
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


def _null_space(draft: Draft, arm: Columns) -> list[list[Polynomial]]:
    """Vectors that span the null space of J₁₁ wherever its rank is 3: cofactors of each four of its columns."""
    found = []
    for four in combinations(range(len(arm)), 4):
        vector = [draft.ring.zero] * len(arm)
        for place, left_out in enumerate(four):
            minor = draft.minor([arm[i] for i in four if i != left_out], range(3))
            vector[left_out] = -minor if place % 2 else minor
        if any(x != 0 for x in vector):
            found.append(vector)
    return found


def _combined(draft: Draft, columns: Columns, weights: list[Polynomial]) -> list[Polynomial]:
    return [
        draft.ring.reduce(sum((column[i] * w for column, w in zip(columns, weights, strict=True)), draft.ring.zero))
        for i in range(3)
    ]
