"""The methods that KG lists besides its own, for comparison: each derives the whole singular set in its own way.

| method | idea | what stands in the way |
|---|---|---|
| determinant | det J, or det(J Jᵀ) | a redundant arm's is one long sum of squares: its minors vanish together |
| cofactors | all maximal minors vanish | their common solution is still to be found |
| decomposition | arm and wrist apart, from the wrist centre | spherical wrists only |
| reciprocity | a screw reciprocal to all joint screws | it vanishes somewhere itself |
| singular_vector | Jᵀ u = 0 by elimination | pivots vanish: many cases, some empty |
| elementary | rows and columns cleared by numbers, then blocks | of a redundant arm minors are left, but smaller ones |

    >>> from rankdrop.exact.arm.chain import exact_chain
    >>> from rankdrop.robot.open import open_robot
    >>> found = derive(exact_chain(open_robot("scara")), "determinant")
    >>> [[atom.key for equality in c.equal for atom in equality.atoms] for c in found.conditions]
    [['θ2=0'], ['θ2=pi']]

Determinant (KG eq. 1): of J where it is square, of J Jᵀ where the arm has joints to spare.

Cofactors (KG eq. 2): the rank drops where every maximal minor vanishes.

Decomposition: with the reference point at the centre of a spherical wrist the Jacobian is block triangular.

    J = [[J₁₁, 0], [J₂₁, J₂₂]]     rows v of the wrist centre, then ω;  J₁₁ is 3 × (n − 3),  J₂₂ is 3 × 3

The wrist does not move its centre. With N a basis of the null space of J₁₁, rank J = rank J₁₁ + rank [J₂₁ N, J₂₂].
Hence J is singular where

    rank J₁₁ < 3                   the arm cannot move the wrist centre; the wrist adds 3 at most: rank J ≤ 5
    rank [J₂₁ N, J₂₂] < 3          the wrist's axes are dependent, and motions of the arm about the centre do not help

Where rank J₁₁ = 3, its null space is spanned by the cofactors of its 3 × 4 submatrices, so that N is polynomial.
Elsewhere all of them vanish, and the second line may hold or not: the first one does.

Reciprocity: in a singular configuration some screw is reciprocal to every joint screw. To one less of the joint screws
than the task has rows, five of six, one screw w is reciprocal: its components are the cofactors of these columns. Where
w ≠ 0 they are independent, and the configuration is singular where the remaining joint screws are reciprocal to w, too:
their reciprocal products with it are maximal minors of J. Where every component of w vanishes the expression says
nothing (KG section 1): the five are dependent, which for a redundant arm need not be a singularity. This exceptional
locus is treated apart, by another choice of five. For coranks above 1 see `rankdrop.exact.reciprocal`.

The singular vector: Jᵀ u = 0 solved by elimination, without fractions, in every case of a pivot. After k steps the
entries that are left are, up to the pivots before, minors of order k + 1 that border the pivot's minor: they are
computed as such, which is elimination without fractions and without growth. A pivot that may vanish parts the case.
After m − 1 pivots (m rows of the task) u is known up to its length: its components are the cofactors of the pivots'
columns, and J is singular where the equations that are left hold, too: where all minors bordering the last pivot vanish
(Kronecker).

Elementary transformations (Xu et al. 2013, 2016): seen from a link in the middle many entries of the Jacobian are
numbers. Row and column operations clear the row and the column of one after another; none of these pivots ever
vanishes, so that the rank of the smaller matrix is lower by their number everywhere. Permutations make it block
triangular: where k rows are zero outside k columns, J is singular where the determinant of these k × k entries
vanishes, or where the matrix without them loses rank.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import combinations
from math import prod
from operator import mul

import numpy as np

from rankdrop.algebra.halt import Halt, HaltKind, OutOfTime
from rankdrop.algebra.polynomial import Atom, Equality, Polynomial
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.errors import OptionError
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.parts import whole_angles
from rankdrop.exact.arm.structure import check_basic
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
    values_of,
)
from rankdrop.exact.determinants import MinorChoice, maximal_minors
from rankdrop.exact.reciprocal import reciprocal_screws
from rankdrop.exact.rows import merge_pairs
from rankdrop.exact.stratum import meet
from rankdrop.lists import flat_map, smallest_sets
from rankdrop.local.block import sample
from rankdrop.robot.model import JointKind
from rankdrop.units import out_of_units

_ZEROS = 256  # random configurations between which a zero of a polynomial is looked for
_PARTS, _ROUNDS = 65, 9  # of the way between two of them, and of a part of it: to the last digit

_MinorOfAll = tuple[MinorChoice, Polynomial]
"""Rows and columns, and the minor that they make."""

_Choice = tuple[tuple[int, ...], tuple[Polynomial, ...]]
"""Joints (from 0), and the screw that is reciprocal to theirs: one component per row of the task."""

_Pivots = tuple[ZeroSet, tuple[int, ...], tuple[int, ...]]
"""A case in the middle of elimination: the minor of these rows and columns (from 0) does not vanish in it."""

__all__ = ["METHODS", "Conjunction", "SetDerivation", "derive"]


def determinant(builder: SetDerivation) -> None:
    """det J = 0, one condition per factor; else det(J Jᵀ) = 0, as the minors that vanish together.

    det(J Jᵀ) = Σ minor²  (Cauchy and Binet) is never negative, so that it vanishes without a change of sign, and over
    the reals it vanishes where all minors do. It is not multiplied out, nor factored: of a general arm of seven joints
    it has 169,524 terms, its minors 154 to 520. An arm of fewer joints than the task has rows has det(Jᵀ J), which is
    the same sum.

    Args:
        builder: filled in. Sizes: "terms" of the trigonometric polynomial; or "minors" that are not zero everywhere,
            "terms" of all of them, "longest".

    Raises:
        OptionError: the rank is not full anywhere.
        OutOfTime: no time is left.
    """
    columns = builder.chain.columns
    if len(columns) == len(columns[0]):
        builder.full_rank()
        minor = builder.minor(columns, range(len(columns)))
        builder.sizes["terms"] = len(minor)
        parts = _factor_by_factor(builder.equality(minor))
        builder.conditions += parts
        builder.note("factors", terms=len(minor), factors=len(parts))
        return
    minors = _minors(builder)
    if len(columns) > len(columns[0]):
        product = "J Jᵀ"
    else:
        product = "Jᵀ J"
    builder.note("squares", product=product, minors=len(minors))
    _vanish_together(builder, minors)


def _minors(builder: SetDerivation) -> list[_MinorOfAll]:
    """The maximal minors that do not vanish everywhere; their sizes are kept."""
    minors = builder.minors(builder.chain.columns, builder.full_rank())
    pairs = [pair for pair in zip(maximal_minors(builder.chain), minors, strict=True) if pair[1] != 0]
    terms = [len(minor) for _, minor in pairs]
    builder.sizes |= {"minors": len(pairs), "terms": sum(terms), "longest": max(terms)}
    return pairs


def _vanish_together(builder: SetDerivation, minors: Sequence[_MinorOfAll]) -> None:
    """Conditions that all minors vanish. A minor that is not factored in time stands as it is, and is noted: the
    conditions hold where the rank drops and nowhere else, whether it has factors or not.
    """
    zero_sets = []
    for choice, minor in minors:
        equality = builder.factored_equality(minor)
        zero_sets.append(equality)
        if equality.whole is not None:
            where = zero_of(builder.chain, minor)
            builder.note("unfactored", choice=choice, terms=len(minor), degree=_degree(builder, minor), zero=where)
    conditions = conjunctions(zero_sets)
    builder.conditions += conditions
    rest = [condition for condition in conditions if len(condition.equal) > 1]
    builder.note("common", factors=len(conditions) - len(rest))
    for condition in rest:
        ways = prod(max(1, len(equality.atoms)) for equality in condition.equal)
        builder.note("together", equations=len(condition.equal), ways=ways)


def _degree(builder: SetDerivation, p: Polynomial) -> int:
    """Degree of a trigonometric polynomial in the sines, cosines and slides."""
    moving = 2 * builder.ring.angles + len(builder.ring.prismatic)
    return max(sum(map(int, powers[:moving])) for powers in p.monoms())


def zero_of(chain: Chain, p: Polynomial) -> tuple[float, ...] | None:
    """A real configuration at which a trigonometric polynomial vanishes, to rounding.

    On the straight way between two random configurations at which its signs differ, part by part; None where all have
    one sign.

    Returns:
        (n,) in joint variables [rad, m].
    """
    theta = sample(chain.own, chain.own_task, _ZEROS, 0) + chain.shifts
    values, _ = values_of(chain, p, theta)
    if values.min() >= 0 or values.max() <= 0:
        return None
    low, high = theta[values.argmin()], theta[values.argmax()]
    for _ in range(_ROUNDS):
        way = np.linspace(low, high, _PARTS)
        values, _ = values_of(chain, p, way)
        first = max(1, int(np.argmax(values >= 0.0)))
        low, high = way[first - 1], way[first]
    zero = out_of_units(chain.robot, (low + high)[None] / 2 - chain.shifts)[0]
    return tuple(map(float, whole_angles(chain.robot, zero)))


def cofactors(builder: SetDerivation) -> None:
    """All maximal minors of J, factored; their common factors, and the conjunction of what is left.

    Nothing is wrong with the answer, but what is left is as many equations as there are minors, whose solution is
    still to be found: their factors could be combined in as many ways as the note says.

    Args:
        builder: filled in. Sizes: "minors" that are not zero everywhere, "terms" of all of them, "longest".

    Raises:
        OptionError: the rank is not full anywhere.
        OutOfTime: no time is left.
    """
    minors = _minors(builder)
    builder.note("cofactors", minors=len(minors), terms=builder.sizes["terms"])
    _vanish_together(builder, minors)


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
        vector = dict(zip(four, _alternating(minors), strict=True))
        if any(x != 0 for x in minors):
            basis.append([vector.get(i, builder.ring.zero) for i in range(len(arm))])
    return basis


def _alternating(minors: Sequence[Polynomial]) -> list[Polynomial]:
    """The cofactors that these minors are, in order."""
    return [-minor if place % 2 else minor for place, minor in enumerate(minors)]


def _weighted_rotations(builder: SetDerivation, columns: Columns, weights: list[Polynomial]) -> list[Polynomial]:
    """Σ w_j column_j, the rotations only."""
    return [
        builder.ring.reduce(sum((column[i] * w for column, w in zip(columns, weights, strict=True)), builder.ring.zero))
        for i in range(3)
    ]


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
        choices[pins] = _choices(builder, columns)
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


def _choices(builder: SetDerivation, columns: Columns) -> list[_Choice]:
    """Every choice of joints with its screw, those among the basic ones and short ones first; those that are dependent
    everywhere left out.
    """
    m = len(columns[0])
    choices = []
    for joints in combinations(range(len(columns)), m - 1):
        chosen = [columns[j] for j in joints]
        screw = _alternating([builder.minor(chosen, [i for i in range(m) if i != row]) for row in range(m)])
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


def singular_vector(builder: SetDerivation) -> None:
    """Conditions case by case: which pivots do not vanish, and what is left of Jᵀ u = 0.

    Args:
        builder: filled in. Sizes: "cases", "longest" equation of a case in terms.

    Raises:
        OptionError: the rank is not full anywhere.
        OutOfTime: no time is left; what was found until then is in the builder.
    """
    builder.full_rank()
    builder.sizes |= {"cases": 0, "longest": 0}
    waiting: list[_Pivots] = [(ZeroSet.whole(builder.ring), (), ())]
    while waiting:
        step = waiting.pop(0)
        try:
            waiting[:0] = _eliminate_pivot(builder, step)  # pivots that do not vanish first: that case holds most
        except OutOfTime as error:
            builder.generic = True
            cases = Halt(HaltKind.CASES, number=len(waiting) + 1)
            raise OutOfTime(replace(error.halt, waiting=cases)) from error
    builder.note("pivots", cases=builder.sizes["cases"], conditions=len(builder.conditions))


def _eliminate_pivot(builder: SetDerivation, step: _Pivots) -> list[_Pivots]:
    """One step of elimination; the cases that follow from it."""
    builder.check(Halt(HaltKind.ELIMINATION))
    case, rows, chosen = step
    columns = columns_on(case, builder.chain.columns)
    size = min(len(columns), len(columns[0]))
    left: list[tuple[int, int, Polynomial]] = []
    while len(rows) < size:
        left = _bordering(builder, columns, rows, chosen)
        if len(rows) == size - 1:
            break
        pivot = _pivot(builder, case, left)
        if pivot is None:  # everything that is left vanishes: the rank is lower still
            left = []
            break
        row, column, factors = pivot
        following = (case.remove_zeros(*factors), (*rows, row), (*chosen, column))
        if factors:
            return [following, *((part, rows, chosen) for part in builder.branches(case, factors))]
        case, rows, chosen = following
    builder.sizes["cases"] += 1
    entries = [builder.factors(case, entry) for _, _, entry in left]
    met = conjunctions(equality_of(factors) for factors in entries if factors is not None)
    builder.conditions += [condition_within(case, piece) for piece in met]
    longest = max((condition.terms for condition in flat_map(lambda piece: piece.equal, met)), default=0)
    builder.sizes["longest"] = max(builder.sizes["longest"], longest)
    return []


def _bordering(
    builder: SetDerivation, columns: Columns, rows: Sequence[int], chosen: Sequence[int]
) -> list[tuple[int, int, Polynomial]]:
    """(row, column, minor) for each row and column besides the pivots', minors that are not zero."""
    others = [column for column in range(len(columns)) if column not in chosen]
    places = [(row, column) for column in others for row in range(len(columns[0])) if row not in rows]
    bordering = [(r, c, builder.minor([columns[k] for k in (*chosen, c)], (*rows, r))) for r, c in places]
    return [entry for entry in bordering if entry[2] != 0]


def _pivot(
    builder: SetDerivation, case: ZeroSet, left: list[tuple[int, int, Polynomial]]
) -> tuple[int, int, Atoms] | None:
    """The entry with the fewest and shortest atoms that may vanish; None where all entries vanish in the case."""
    best = None
    for row, column, entry in sorted(left, key=lambda item: len(item[2])):
        if best is not None and len(entry) > 4 * best[0]:
            break
        factors = builder.factors(case, entry)
        if factors is None:
            continue
        weight = (len(factors), sum(atom.weight for atom in factors))
        if best is None or weight < best[1]:
            best = (len(entry), weight, (row, column, factors))
        if not factors:
            break
    return None if best is None else best[2]


def elementary(builder: SetDerivation) -> None:
    """Conditions of the blocks that remain when rows and columns have been cleared by numbers.

    Args:
        builder: filled in. Sizes: "blocks" with a determinant of their own, "terms" of all determinants, "minors" of
            the rest, where the arm has joints to spare.

    Raises:
        OptionError: the rank is not full anywhere.
        OutOfTime: no time is left.
    """
    builder.full_rank()
    columns, _ = builder.chain.cleared_columns
    builder.note("cleared", rows=len(columns[0]), columns=len(columns))
    if len(columns) < len(columns[0]):
        columns = [list(row) for row in zip(*columns, strict=True)]  # the rank is that of the transpose
    blocks, rest = _blocks(columns)
    builder.sizes |= {"blocks": len(blocks), "terms": 0, "minors": 0}
    for block in blocks:
        determinant = builder.minor(block, range(len(block)))
        builder.sizes["terms"] += len(determinant)
        builder.note("block", order=len(block), terms=len(determinant))
        builder.conditions += _factor_by_factor(builder.equality(determinant))
    if rest:
        minors = [minor for minor in builder.minors(rest, len(rest[0])) if minor != 0]
        builder.sizes["minors"] = len(minors)
        builder.sizes["terms"] += sum(map(len, minors))
        builder.note("rest", rows=len(rest[0]), columns=len(rest), minors=len(minors))
        builder.conditions += conjunctions(map(builder.equality, minors))


def _factor_by_factor(equality: Equality) -> list[Conjunction]:
    """A polynomial that vanishes as one condition for each of its factors."""
    if equality.whole is not None:
        return [Conjunction((equality,))]
    return [Conjunction((Equality((atom,)),)) for atom in equality.atoms]


def _blocks(columns: Columns) -> tuple[list[Columns], Columns]:
    """Square blocks of a matrix with no more rows than columns, and the rest: it has full rank where all of them have.

    A block are the fewest rows that are zero outside as many columns as there are of them; they and their columns are
    then left out. Of a square matrix there is no rest: its last block is all that remains.
    """
    blocks: list[Columns] = []
    rest = columns
    while rest:
        rows = _tight_rows(rest)
        if rows is None:
            return blocks, rest
        inside = [column for column in rest if _meets(column, rows)]
        outside = [column for column in rest if not _meets(column, rows)]
        others = [row for row in range(len(rest[0])) if row not in rows]
        blocks.append([_entries(column, rows) for column in inside])
        if not others:
            return blocks, []
        rest = [_entries(column, others) for column in outside]
    return blocks, rest


def _entries(column: Sequence[Polynomial], rows: Sequence[int]) -> list[Polynomial]:
    return [column[row] for row in rows]


def _meets(column: Sequence[Polynomial], rows: Sequence[int]) -> bool:
    """Whether a column has an entry besides zero in some rows."""
    return any(column[row] != 0 for row in rows)


def _tight_rows(columns: Columns) -> tuple[int, ...] | None:
    """The fewest rows that are zero outside as many columns as there are of them; None where there are none."""
    count = len(columns[0])
    for size in range(1, count + 1):
        for rows in combinations(range(count), size):
            if sum(_meets(column, rows) for column in columns) == size:
                return rows
    return None


_METHODS: dict[str, Callable[[SetDerivation], None]] = {
    "determinant": determinant,
    "cofactors": cofactors,
    "decomposition": decomposition,
    "reciprocity": reciprocity,
    "singular_vector": singular_vector,
    "elementary": elementary,
}
METHODS = tuple(_METHODS)
"""Names of the methods."""


def derive(
    chain: Chain,
    method: str,
    seconds: float = 30.0,
    *,
    frame: int | None = None,
    basic: tuple[int, ...] | None = None,
    corank: int = 1,
) -> SetDerivation:
    """Derive the singular set, or the set of a higher corank, by one of the methods.

    Args:
        chain: the arm and its task.
        method: one of `METHODS`.
        seconds: wall time that may be spent; what is not finished by then is in `Derivation.left`.
        frame: for reciprocity: link 1 … n − 1 in whose frame the screws are taken; None for the shortest one.
        basic: for reciprocity: the reciprocal screw is that of five of these joints, as far as that goes.
        corank: k of the configurations of rank m − k or less; above 1 for reciprocity alone.

    Returns:
        The conditions, and what they cost.

    Raises:
        OptionError: no such method; a rank that is not full anywhere; for decomposition no spherical wrist; a corank
            that the task or the method does not have.
    """
    if method not in _METHODS:
        raise OptionError("there is no such method", got=repr(method), allowed=", ".join(METHODS))
    if (frame is not None or basic is not None) and method != "reciprocity":
        raise OptionError("frame and basic screws are chosen for another method", got=method, allowed="reciprocity")
    if not 1 <= corank <= chain.task.m:
        raise OptionError(
            "the corank is no number of freedoms of the task", where="corank", got=corank, allowed=f"1 … {chain.task.m}"
        )
    if corank > 1 and method != "reciprocity":
        raise OptionError(
            "this method derives corank 1 only", where="corank", got=f"{corank}, {method}", allowed="reciprocity"
        )
    check_basic(chain, basic, frame)
    builder = SetDerivation(chain, method, seconds, frame=frame, basic=basic, corank=corank)
    try:
        _METHODS[method](builder)
    except OutOfTime as error:
        builder.halt(error.halt)
    builder.finish()
    return builder
