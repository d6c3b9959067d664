"""Singularities of corank k by reciprocal screws (Nokleby and Podhorodeski 2004): k screws reciprocal to m − k joints.

A task of m rows has rank m − k or less where k independent screws are reciprocal to every joint screw. Choose m − k
joints and as many rows: where their minor does not vanish the joint screws are independent, and Cramer's rule gives k
independent screws w₁ … w_k reciprocal to them. For each row q that was not chosen, the components of one screw are the
minors of the chosen joints in the chosen rows and q, without one of these rows; its component q is the minor itself.

The corank is k where the remaining joints are reciprocal to all k screws, too. Their products with w_q are the minors
of order m − k + 1 that border the chosen one: Kronecker's condition for rank m − k.

Where the chosen minor vanishes nothing follows. There another minor is taken, of the same joints or of others, case by
case and disjointly. Where all minors of order m − k vanish the corank is above k: the case is a condition by itself.

    >>> from rankdrop.exact.arm.chain import exact_chain
    >>> from rankdrop.robot.open import open_robot
    >>> builder = SetDerivation(exact_chain(open_robot("puma560")), "reciprocity", 30.0, corank=2)
    >>> reciprocal_screws(builder)
    >>> builder.sizes["cases"] > 1
    True
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, product
from operator import mul
from typing import NamedTuple

from rankdrop.algebra.polynomial import Polynomial
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact.conjunctions import (
    TOLD,
    Atoms,
    Columns,
    Conjunction,
    Pins,
    SetDerivation,
    columns_on,
    condition_within,
    conjunctions,
    equality_of,
)

_SHORT = 4  # times the terms of the best minor so far up to which another one may be better
Screw = tuple[Polynomial, ...]
"""One component per row of the task."""


class _ScrewMinor(NamedTuple):
    """Joints and rows (from 0), and their minor."""

    joints: tuple[int, ...]
    rows: tuple[int, ...]
    value: Polynomial


def reciprocal_screws(builder: SetDerivation) -> None:
    """Conditions case by case: a minor that does not vanish, with its k screws; then the cases where it vanishes.

    Args:
        builder: filled in. Sizes: "cases", "choices" of joints that were made, "minors" of order m − k that do not
            vanish everywhere, "terms" of the longest screw.

    Raises:
        OutOfTime: no time is left; what was found until then is in the builder.
    """
    builder.sizes |= {"cases": 0, "choices": 0, "minors": 0, "terms": 0}
    known: dict[Pins, list[_ScrewMinor]] = {}
    used_joints: set[tuple[int, ...]] = set()
    builder.case_by_case(lambda case: _one_case(builder, case, known, used_joints))
    builder.sizes["choices"] = len(used_joints)
    if builder.sizes["cases"] > 1:
        builder.note("cases", further=builder.sizes["cases"] - 1, different=len(used_joints))


def _one_case(
    builder: SetDerivation, case: ZeroSet, known: dict[Pins, list[_ScrewMinor]], used_joints: set[tuple[int, ...]]
) -> list[ZeroSet]:
    """Conditions of one case where the minor chosen there does not vanish; the cases where it does."""
    columns, pins = columns_on(case, builder.columns), tuple(sorted(case.pins.items()))
    builder.sizes["cases"] += 1
    if pins not in known:
        known[pins] = _minors(builder, columns)
    if not pins:
        builder.sizes["minors"] = len(known[pins])
    chosen = _chosen(builder, case, known[pins])
    if chosen is None:  # every minor vanishes in all of this case: the rank is lower still
        builder.conditions.append(condition_within(case, Conjunction(())))
        return []
    minor, factors = chosen
    used_joints.add(minor.joints)
    screws = _screws(builder, columns, minor)
    builder.sizes["terms"] = max(builder.sizes["terms"], max(map(_terms, screws)))
    if len(case.pins) <= TOLD and not case.equations:
        _note(builder, case, minor, screws)
    builder.conditions += _products_vanish(builder, case.remove_zeros(*factors), columns, minor, screws)
    return builder.branches(case, factors)


def _terms(screw: Screw) -> int:
    return sum(map(len, screw))


def _products_vanish(
    builder: SetDerivation, piece_of_case: ZeroSet, columns: Columns, minor: _ScrewMinor, screws: Sequence[Screw]
) -> list[Conjunction]:
    """Conditions that the remaining joints are reciprocal to every screw."""
    others = [column for j, column in enumerate(columns) if j not in minor.joints]
    zeros = []
    for screw, column in product(screws, others):
        atoms = builder.factors(piece_of_case, _reciprocal_product(builder, screw, column))
        if atoms is not None:
            zeros.append(equality_of(atoms))
    return [condition_within(piece_of_case, piece) for piece in conjunctions(zeros) if not _impossible(piece)]


def _minors(builder: SetDerivation, columns: Columns) -> list[_ScrewMinor]:
    """The minors of order m − k that are not zero, those of basic joints and short ones first."""
    count = len(columns[0])
    size = count - builder.corank
    minors = []
    for joints in combinations(range(len(columns)), size):
        chosen = [columns[j] for j in joints]
        for rows in combinations(range(count), size):
            value = builder.minor(chosen, rows)
            if value != 0:
                minors.append(_ScrewMinor(joints, rows, value))
    if builder.basic is not None:
        wished = {j - 1 for j in builder.basic}
    else:
        wished = set(range(len(columns)))

    def order(minor: _ScrewMinor) -> tuple[bool, int, tuple[int, ...], tuple[int, ...]]:
        return not wished.issuperset(minor.joints), len(minor.value), minor.joints, minor.rows

    return sorted(minors, key=order)


def _chosen(builder: SetDerivation, case: ZeroSet, minors: Sequence[_ScrewMinor]) -> tuple[_ScrewMinor, Atoms] | None:
    """The minor with the fewest and shortest atoms under which it may vanish, and these; None where all vanish."""
    best: tuple[_ScrewMinor, Atoms] | None = None
    least = (0, 0)
    for minor in minors:
        if best is not None and len(minor.value) > _SHORT * len(best[0].value):
            break
        factors = builder.factors(case, minor.value)
        if factors is None:
            continue
        weight = (sum(not atom.is_pin for atom in factors), len(factors))
        if best is None or weight < least:
            best, least = (minor, factors), weight
        if not factors:
            break
    return best


def _screws(builder: SetDerivation, columns: Columns, minor: _ScrewMinor) -> list[Screw]:
    """k screws reciprocal to the chosen joints, independent where the minor does not vanish (Cramer's rule)."""
    chosen = [columns[j] for j in minor.joints]
    count = len(columns[0])
    screws = []
    for row in sorted({*range(count)}.difference(minor.rows)):
        rows = sorted((*minor.rows, row))
        screw = [builder.ring.zero] * count
        for place, left_out in enumerate(rows):
            value = builder.minor(chosen, [i for i in rows if i != left_out])
            screw[left_out] = (-1) ** place * value
        screws.append(tuple(screw))
    return screws


def _reciprocal_product(builder: SetDerivation, screw: Screw, column: Sequence[Polynomial]) -> Polynomial:
    """The reciprocal product of a screw and a joint screw: a minor that borders the chosen one, up to its sign."""
    return builder.ring.reduce(sum(map(mul, screw, column), builder.ring.zero))


def _impossible(piece: Conjunction) -> bool:
    """Whether it puts a joint at two simple angles: θ4 = 0 or π, and θ4 = ±π/2."""
    allowed: dict[int, set[str]] = {}
    for equality in piece.equal:
        joint = equality.atoms[0].joint
        values = {atom.value for atom in equality.atoms if atom.is_pin and atom.joint == joint}
        if len(values) == len(equality.atoms):
            allowed[joint] = values & allowed.get(joint, values)
    return not all(allowed.values())


def _note(builder: SetDerivation, case: ZeroSet, minor: _ScrewMinor, screws: Sequence[Screw]) -> None:
    """The screws that a case rests on, and the minor that makes them independent."""
    joints = [j + 1 for j in minor.joints]
    rows = [builder.chain.task.rows[i] for i in minor.rows]
    builder.note("screws", case=case, joints=joints, rows=rows, minor=minor.value, screws=screws)
