"""Two methods by vectors that vanish against J: reciprocity, and the singular vector.

Reciprocity: in a singular configuration some screw is reciprocal to every joint screw. To one less of the joint screws
than the task has rows, five of six, one screw w is reciprocal: its components are the cofactors of these columns. Where
w ≠ 0 they are independent, and the configuration is singular where the remaining joint screws are reciprocal to w, too:
their reciprocal products with it are maximal minors of J. Where every component of w vanishes the expression says
nothing (KG section 1): the five are dependent, which for a redundant arm need not be a singularity. This exceptional
locus is treated apart, by another choice of five.

The singular vector: Jᵀ u = 0 solved by elimination, without fractions, in every case of a pivot. After k steps the
entries that are left are, up to the pivots before, minors of order k + 1 that border the pivot's minor: they are
computed as such, which is elimination without fractions and without growth. A pivot that may vanish parts the case.
After m − 1 pivots (m rows of the task) u is known up to its length: its components are the cofactors of the pivots'
columns, and J is singular where the equations that are left hold, too: where all minors bordering the last pivot vanish
(Kronecker).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from rankdrop.errors import OptionError
from rankdrop.exact.algebra.polynomial import Atom, Equality, Polynomial, order
from rankdrop.exact.algebra.work import OutOfTime
from rankdrop.exact.methods.builder import Atoms, Case, Columns, DerivationBuilder, branches, conjunctions, size
from rankdrop.exact.methods.derivation import Conjunction, Words
from rankdrop.exact.writing.value import text_of

DEEPEST = 3
"""Factors that are followed one after the other; what is left then is told as equations that hold together."""


def vanishing(builder: DerivationBuilder, case: Case, screw: Sequence[Polynomial], words: Words) -> list[str]:
    """The sets within a case on which every element of a screw vanishes, in words; none where it never does.

    Args:
        builder: of the method.
        case: where.
        screw: its elements, with the pinned joints of the case put in.
        words: of the ring.

    Raises:
        OutOfTime: no time is left.
    """
    found = _merged(_sets(builder, case, screw, DEEPEST))
    return list(dict.fromkeys(words.conjunction(Conjunction(one)) for one in found))


def _sets(
    builder: DerivationBuilder, case: Case, screw: Sequence[Polynomial], deepest: int
) -> list[tuple[Equality, ...]]:
    """Conjunctions of equalities, beside those of the case."""
    pins = dict(case.pins)
    here = [builder.ring.at(x, pins) for x in screw]
    known = [found for found in (case.factors(builder, w) for w in here if w != 0) if found is not None]
    if not known:
        return [()]
    if frozenset() in known:
        return []
    simple = [factors for factors in known if any(atom.pinned for atom in factors)]
    first = min(simple, key=lambda factors: (sum(not atom.pinned for atom in factors), len(factors)), default=None)
    if deepest == 0 or first is None:
        equalities = (Equality(tuple(sorted(factors, key=lambda atom: atom.key))) for factors in known)
        return [piece.equal for piece in conjunctions(equalities)]
    found = []
    for atom in sorted(first, key=lambda atom: atom.key):
        part = case.with_zero(builder, atom)
        if part is not None:
            for more in _sets(builder, part, screw, deepest - 1):
                found.append(more if _follows(builder, atom, more) else (Equality((atom,)), *more))
    return found


def _follows(builder: DerivationBuilder, atom: Atom, more: Sequence[Equality]) -> bool:
    """Whether an atom vanishes once the joints that are pinned after it stand where they do."""
    pins = {one.atoms[0].joint: one.atoms[0].value for one in more if len(one.atoms) == 1 and one.atoms[0].pinned}
    return not atom.pinned and bool(builder.ring.form(atom.f).at(pins).f == 0)


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


TOLD = 1
"""Pinned joints of a case up to which its screw, and where that vanishes, is told."""
WRITTEN = 40
"""Terms of a screw up to which its elements are written."""
Pins = tuple[tuple[int, str], ...]
"""Pinned joints of a case: its columns depend on nothing else."""


_Choice = tuple[tuple[int, ...], tuple[Polynomial, ...]]
"""Joints (from 0), and the screw that is reciprocal to theirs: one component per row of the task."""


def reciprocity(builder: DerivationBuilder) -> None:
    """Conditions case by case: a choice of five with its screw w ≠ 0, then the locus where w vanishes.

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
    builder.sizes |= {"cases": 0, "choices": 0, "terms": 0}
    builder.generic = True
    if builder.basic is not None:
        builder.notes.append(f"joints {', '.join(map(str, builder.basic))} are taken first, as asked for")
    waiting = [Case()]
    made: set[tuple[int, ...]] = set()
    choices: dict[Pins, list[_Choice]] = {}
    while waiting:
        case = waiting.pop(0)
        try:
            builder.check(f"{len(waiting) + 1} exceptional cases")
            waiting += _one_case(builder, case, made, choices)
        except OutOfTime as error:
            raise OutOfTime(f"{error}; {len(waiting) + 1} exceptional cases") from error
    builder.generic = False
    if builder.sizes["choices"] > 1:
        builder.notes.append(
            f"the exceptional loci are treated apart, by {builder.sizes['choices'] - 1} further choices of joints, "
            f"{len(made)} different ones in all"
        )


def _one_case(
    builder: DerivationBuilder, case: Case, made: set[tuple[int, ...]], choices: dict[Pins, list[_Choice]]
) -> list[Case]:
    """Conditions of one case where the screw chosen there does not vanish; the cases where it does."""
    ring, columns = builder.ring, case.columns(builder.ring, builder.columns)
    builder.sizes["cases"] += 1
    if case.pins not in choices:
        choices[case.pins] = _choices(builder, columns)
    for choice in choices[case.pins]:
        joints, screw = choice
        components = [case.factors(builder, w) for w in screw if w != 0]
        known = [found for found in components if found is not None]
        if not known:  # the screw vanishes in all of this case
            continue
        made.add(joints)
        builder.sizes["choices"] += 1
        builder.sizes["terms"] = max(builder.sizes["terms"], size(screw))
        if len(case.pins) <= TOLD and not case.zero and not case.product:
            _note(builder, case, choice)
        redundant = len(columns) > len(columns[0])
        nowhere = () if frozenset() in known else (tuple(_equality(found) for found in known),)
        products = [_product(builder, columns[j], screw) for j in range(len(columns)) if j not in joints]
        factors = [case.factors(builder, p) for p in products]
        met = conjunctions([_equality(found) for found in factors if found is not None])
        always = frozenset.intersection(*known)  # where one of these vanishes, w does
        for piece in met:
            if redundant and len(piece.equal) == 1 and always.issuperset(piece.equal[0].atoms):
                continue
            builder.conditions.append(case.conjunction(ring, piece, nowhere if redundant else ()))
        if frozenset() in known:
            return []
        if not redundant:  # its one product is det J
            builder.notes.append("where it vanishes det J does, too: nothing is left out")
            return []
        return branches(builder, case, min(known, key=lambda found: (sum(not a.pinned for a in found), len(found))))
    builder.conditions += [case.conjunction(ring, part) for part in conjunctions([])]
    return []


def _choices(builder: DerivationBuilder, columns: Columns) -> list[_Choice]:
    """Every choice of joints with its screw, those among the basic ones and short ones first; those that are dependent
    everywhere left out.
    """
    m = len(columns[0])
    found = []
    for joints in combinations(range(len(columns)), m - 1):
        chosen = [columns[j] for j in joints]
        screw = []
        for row in range(m):
            minor = builder.minor(chosen, [i for i in range(m) if i != row])
            screw.append(-minor if row % 2 else minor)
        if any(w != 0 for w in screw):
            found.append((joints, tuple(screw)))
    wished = {j - 1 for j in builder.basic} if builder.basic is not None else set(range(len(columns)))
    return sorted(
        found, key=lambda choice: (not wished.issuperset(choice[0]), size(choice[1]), choice[0])
    )


def _product(builder: DerivationBuilder, column: Sequence[Polynomial], screw: Sequence[Polynomial]) -> Polynomial:
    """Reciprocal product of a screw with a joint's."""
    return builder.ring.reduce(sum((w * x for w, x in zip(screw, column, strict=True)), builder.ring.zero))


def _note(builder: DerivationBuilder, case: Case, choice: _Choice) -> None:
    """The screw that a case rests on, and where it vanishes: nothing follows from it there."""
    words, ring = Words(builder.ring), builder.ring
    there = words.conjunction(Conjunction(case.equalities(ring))) if case.pins else "in general"
    chosen, elements = choice
    joints = ", ".join(str(j + 1) for j in chosen)
    terms = size(elements)
    written = [text_of(ring, x) for x in elements] if terms <= WRITTEN else []
    screw = f"({', '.join(written[:3])}; {', '.join(written[3:])})" if len(written) == 6 else f"of {terms} terms"
    builder.notes.append(f"{there}: the screw reciprocal to joints {joints} is {screw}")
    known = vanishing(builder, case, elements, words)
    if builder.sizes["choices"] == 1:
        builder.sizes["exceptional"] = len(known)
    count = {6: "six", 3: "three"}.get(len(elements), str(len(elements)))
    if not known:
        builder.notes.append("  it never vanishes there")
        return
    builder.notes.append(f"  all {count} elements vanish, and it says nothing, where " + ", or where ".join(known))


def _equality(found: Atoms) -> Equality:
    return Equality(tuple(sorted(found, key=order)))


_Pivots = tuple[Case, tuple[int, ...], tuple[int, ...]]
"""A case in the middle of elimination: the minor of these rows and columns (from 0) does not vanish in it."""


def singular_vector(builder: DerivationBuilder) -> None:
    """Conditions case by case: which pivots do not vanish, and what is left of Jᵀ u = 0.

    Args:
        builder: filled in. Sizes: "cases", "longest" equation of a case in terms.

    Raises:
        OptionError: the rank is not full anywhere.
        OutOfTime: no time is left; what was found until then is in the builder.
    """
    builder.full_rank()
    builder.sizes |= {"cases": 0, "longest": 0}
    waiting: list[_Pivots] = [(Case(), (), ())]
    while waiting:
        step = waiting.pop(0)
        try:
            waiting[:0] = _eliminated(builder, step)  # pivots that do not vanish first: that case holds most
        except OutOfTime as error:
            builder.generic = True
            raise OutOfTime(f"{error}; {len(waiting) + 1} cases") from error
    builder.notes.append(
        f"{builder.sizes['cases']} cases of pivots, {len(builder.conditions)} of them with singular configurations; "
        "some may be empty, and where a case holds no more than another one it is not left out"
    )


def _eliminated(builder: DerivationBuilder, step: _Pivots) -> list[_Pivots]:
    """One step of elimination; the cases that follow from it."""
    builder.check("elimination")
    case, rows, chosen = step
    ring, columns = builder.ring, case.columns(builder.ring, builder.chain.columns)
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
        following = (case.with_nonzero(*factors), (*rows, row), (*chosen, column))
        if factors:
            return [following, *((part, rows, chosen) for part in branches(builder, case, factors))]
        case, rows, chosen = following
    builder.sizes["cases"] += 1
    entries = [case.factors(builder, entry) for _, _, entry in left]
    met = conjunctions([Equality(tuple(sorted(factors, key=order))) for factors in entries if factors is not None])
    builder.conditions += [case.conjunction(ring, piece) for piece in met]
    longest = max((equality.terms for piece in met for equality in piece.equal), default=0)
    builder.sizes["longest"] = max(builder.sizes["longest"], longest)
    return []


def _bordering(
    builder: DerivationBuilder, columns: Columns, rows: Sequence[int], chosen: Sequence[int]
) -> list[tuple[int, int, Polynomial]]:
    """(row, column, minor) for each row and column besides the pivots', minors that are not zero."""
    found = []
    for column in range(len(columns)):
        for row in range(len(columns[0])):
            if row not in rows and column not in chosen:
                minor = builder.minor([columns[c] for c in (*chosen, column)], (*rows, row))
                if minor != 0:
                    found.append((row, column, minor))
    return found


def _pivot(
    builder: DerivationBuilder, case: Case, left: list[tuple[int, int, Polynomial]]
) -> tuple[int, int, Atoms] | None:
    """The entry with the fewest and shortest atoms that may vanish; None where all entries vanish in the case."""
    best = None
    for row, column, entry in sorted(left, key=lambda item: len(item[2])):
        if best is not None and len(entry) > 4 * best[0]:
            break
        factors = case.factors(builder, entry)
        if factors is None:
            continue
        weight = (len(factors), sum(atom.weight for atom in factors))
        if best is None or weight < best[1]:
            best = (len(entry), weight, (row, column, factors))
        if not factors:
            break
    return None if best is None else best[2]
