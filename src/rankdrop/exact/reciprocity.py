"""Method "reciprocity": a screw reciprocal to one joint screw less than the task has rows, and to the others.

In a singular configuration some screw is reciprocal to every joint screw. To one less of the joint screws than the task
has rows, five of six, one screw w is reciprocal: its components are the cofactors of these columns. Where w ≠ 0 they
are independent, and the configuration is singular where the remaining joint screws are reciprocal to w, too: their
reciprocal products with it are maximal minors of J. Where every component of w vanishes the expression says nothing (KG
section 1): the five are dependent, which for a redundant arm need not be a singularity. This exceptional locus is
treated apart, by another choice of five. For coranks above 1 see `rankdrop.exact.reciprocal`.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from operator import mul

from rankdrop.algebra.polynomial import Equality, Polynomial
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.errors import OptionError
from rankdrop.exact.conjunctions import (
    TOLD,
    Atoms,
    Columns,
    Conjunction,
    Pins,
    SetDerivation,
    columns_on,
    condition_within,
    conditions_on,
    conjunctions,
    equality_of,
    place_of,
)
from rankdrop.exact.reciprocal import reciprocal_screws
from rankdrop.exact.rows import merge_pairs
from rankdrop.exact.stratum import meet
from rankdrop.exact.vanishing_minors import alternating
from rankdrop.lists import smallest_sets

_Choice = tuple[tuple[int, ...], tuple[Polynomial, ...]]
"""Joints (from 0), and the screw that is reciprocal to theirs: one component per row of the task."""


def _zeros(builder: SetDerivation, piece: ZeroSet, screw: Sequence[Polynomial]) -> list[tuple[Equality, ...]]:
    """Conjunctions of equalities, beside those of a set, where a screw vanishes."""
    known = _vanishing(builder, piece, screw)
    if frozenset() in known:
        return []
    simple = [atoms for atoms in known if any(atom.is_pin for atom in atoms)]
    if not simple:
        return [condition.equal for condition in conjunctions(map(equality_of, known))]
    of_piece, cases = conditions_on(piece), list[tuple[Equality, ...]]()
    first = min(simple, key=_simplest)
    for atom in sorted(first, key=lambda atom: atom.key):
        for part in meet(piece, atom, {}):
            new_conditions = tuple(condition for condition in conditions_on(part) if condition not in of_piece)
            more = _zeros(builder, part, [part.ring.at(x, part.pins) for x in screw])
            cases += [(*new_conditions, *conditions) for conditions in more]
    return cases


def _vanishing(builder: SetDerivation, piece: ZeroSet, screw: Sequence[Polynomial]) -> list[Atoms]:
    """Of each component that does not vanish on the whole set, the atoms under one of which it does."""
    factors = (builder.factors(piece, w) for w in screw if w != 0)
    return [atoms for atoms in factors if atoms is not None]


def _simplest(atoms: Atoms) -> tuple[int, int]:
    """Sort key: fewest polynomials, then fewest atoms."""
    return sum(not atom.is_pin for atom in atoms), len(atoms)


def _merge_opposite_angles(sets: Sequence[tuple[Equality, ...]]) -> list[tuple[Equality, ...]]:
    """Sets that differ in one angle of one joint alone as one; those inside another one left out."""
    kept = smallest_sets(dict.fromkeys(map(frozenset, sets)))
    return [tuple(sorted(atoms, key=place_of)) for atoms in merge_pairs(kept, _merge_equalities)]


def _merge_equalities(one: frozenset[Equality], other: frozenset[Equality]) -> frozenset[Equality] | None:
    mine, theirs = one - other, other - one
    if len(mine) != 1 or len(theirs) != 1:
        return None
    atoms = (*next(iter(mine)).atoms, *next(iter(theirs)).atoms)
    if not all(atom.is_pin for atom in atoms) or len({atom.joint for atom in atoms}) != 1:
        return None
    return (one & other) | {equality_of(frozenset(atoms))}


def reciprocity(builder: SetDerivation) -> None:
    """Conditions case by case: a choice of five with its screw w ≠ 0, then the locus where w vanishes.

    Of corank 1; of a higher one the conditions are those of `reciprocal_screws`.

    Args:
        builder: filled in. Sizes: "cases", "choices" of five that were made, "terms" of the longest screw,
            "exceptional" components that do not vanish everywhere for the first choice.

    Raises:
        OptionError: the rank is not full anywhere, or fewer joints than rows.
        OutOfTime: no time is left; what was found until then is in the builder.
    """
    builder.full_rank()
    if builder.chain.n < builder.chain.task.m:
        raise OptionError(
            "an arm of fewer joints than the task has rows has screws reciprocal to all of its own everywhere",
            where=f"robot {builder.chain.robot.name!r}", got=f"{builder.chain.n} joints, {builder.chain.task.m} rows",
            mend="use the method cofactors or singular_vector",
        )  # fmt: skip
    if builder.basic is not None:
        builder.note("basic", joints=", ".join(map(str, builder.basic)))
    if builder.corank > 1:
        reciprocal_screws(builder)
        return
    builder.sizes |= {"cases": 0, "choices": 0, "terms": 0}
    used_columns: set[tuple[int, ...]] = set()
    choices: dict[Pins, list[_Choice]] = {}
    builder.case_by_case(lambda case: _one_case(builder, case, used_columns, choices))
    if builder.sizes["choices"] > 1:
        builder.note("choices", further=builder.sizes["choices"] - 1, different=len(used_columns))


def _one_case(
    builder: SetDerivation, case: ZeroSet, used_columns: set[tuple[int, ...]], choices: dict[Pins, list[_Choice]]
) -> list[ZeroSet]:
    """Conditions of one case where the screw chosen there does not vanish; the cases where it does."""
    columns, pins = columns_on(case, builder.columns), tuple(sorted(case.pins.items()))
    builder.sizes["cases"] += 1
    if pins not in choices:
        choices[pins] = reciprocal_choices(builder, columns)
    for choice in choices[pins]:
        known = _vanishing(builder, case, choice[1])
        if known:
            used_columns.add(choice[0])
            return _by_choice(builder, case, columns, choice, known)
    builder.conditions.append(condition_within(case, Conjunction(())))  # every screw vanishes in all of this case
    return []


def _by_choice(
    builder: SetDerivation, case: ZeroSet, columns: Columns, choice: _Choice, known: list[Atoms]
) -> list[ZeroSet]:
    """`_one_case` by one choice of joints, whose screw vanishes where an atom of each component does."""
    joints, screw = choice
    builder.sizes["choices"] += 1
    builder.sizes["terms"] = max(builder.sizes["terms"], sum(map(len, screw)))
    if len(case.pins) <= TOLD and not case.equations:
        _note(builder, case, choice)
    redundant, never = len(columns) > len(columns[0]), frozenset() in known
    nowhere = (tuple(map(equality_of, known)),) if redundant and not never else ()
    others = [column for j, column in enumerate(columns) if j not in joints]
    products = [builder.ring.reduce(sum(map(mul, screw, column), builder.ring.zero)) for column in others]
    factors = [builder.factors(case, p) for p in products]
    always = frozenset.intersection(*known)  # where one of these vanishes, the screw does
    for piece in conjunctions(equality_of(atoms) for atoms in factors if atoms is not None):
        if not (redundant and len(piece.equal) == 1 and always.issuperset(piece.equal[0].atoms)):
            builder.conditions.append(condition_within(case, piece, nowhere))
    if never:
        return []
    if not redundant:  # its one product is det J
        builder.note("square")
        return []
    return builder.branches(case, min(known, key=_simplest))


def reciprocal_choices(builder: SetDerivation, columns: Columns) -> list[_Choice]:
    """Every choice of joints with its screw, those among the basic ones and short ones first; those that are dependent
    everywhere left out.
    """
    m = len(columns[0])
    choices = []
    for joints in combinations(range(len(columns)), m - 1):
        chosen = [columns[j] for j in joints]
        screw = alternating([builder.minor(chosen, [i for i in range(m) if i != row]) for row in range(m)])
        if any(w != 0 for w in screw):
            choices.append((joints, tuple(screw)))
    if builder.basic is not None:
        wished = {j - 1 for j in builder.basic}
    else:
        wished = set(range(len(columns)))
    return sorted(
        choices, key=lambda choice: (not wished.issuperset(choice[0]), sum(map(len, choice[1])), choice[0])
    )


def _note(builder: SetDerivation, case: ZeroSet, choice: _Choice) -> None:
    """The screw that a case rests on, and where it vanishes: nothing follows from it there."""
    chosen, elements = choice
    vanishes = list(map(Conjunction, _merge_opposite_angles(_zeros(builder, case, elements))))
    if builder.sizes["choices"] == 1:
        builder.sizes["exceptional"] = len(vanishes)
    builder.note("screw", case=case, joints=[j + 1 for j in chosen], elements=elements, vanishes=vanishes)
