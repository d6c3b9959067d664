"""Letters for the lengths of an arm: what is assumed of them, and what holds where the assumption fails.

Polynomials in lengths alone have a value and a sign for an arm, and a text. An arm derived with letters is held against
the same arm with numbers (`decided_by_numbers`). What an arm of special lengths adds comes of the derivation done again
where an assumption on the lengths fails (`assumptions`).
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from fractions import Fraction

from rankdrop.algebra.factoring import factor
from rankdrop.algebra.field import residue
from rankdrop.algebra.polynomial import Polynomial, flint, is_number, primitive, roots_in
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.roots import ROOTS, WRITTEN, approximation
from rankdrop.algebra.work import OutOfTime, Work
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.family import Assumption, EqualLengths, SpecialFamily
from rankdrop.exact.rows import merge
from rankdrop.exact.tidy import tidy
from rankdrop.exact.tree import Drop, RankTree, rank_tree
from rankdrop.tolerances import ROUNDED_LENGTHS

_LONG = 2000  # terms of a condition that is factored at the arm's own lengths

_LISTED = 3  # families of a special arm that its assumption lists


def value_of(chain: Chain, f: Polynomial) -> float:
    """f at the arm's own lengths, a float; f is of the half-angle ring and contains no joint."""
    return float(sum(_terms(chain, f)))


def sign_of(chain: Chain, f: Polynomial) -> int:
    """Sign of f at the arm's own lengths: −1, 0 or 1."""
    parts = _terms(chain, f)
    value, size = sum(parts, Fraction(0)), sum(map(abs, parts), Fraction(0))
    if abs(value) <= Fraction(ROUNDED_LENGTHS) * size:
        return 0
    if value > 0:
        return 1
    return -1


def _terms(chain: Chain, f: Polynomial) -> list[Fraction]:
    """Values of the terms at the arm's own lengths, exactly."""
    parts = []
    for powers, value in f.terms():
        part = Fraction(int(value.p), int(value.q))
        for name, power in zip(chain.ring.names, powers, strict=True):
            if power:
                part *= (approximation(name) if name in ROOTS else chain.letters[name]) ** int(power)
        parts.append(part)
    return parts


def never_zero(chain: Chain, f: Polynomial) -> bool:
    """Whether f cannot vanish while every length keeps its sign: all its terms have the same one."""
    signs = set()
    for powers, value in f.terms():
        negative = value < 0
        for name, power in zip(chain.ring.names, powers, strict=True):
            if power % 2 and chain.numbers[name] < 0:
                negative = not negative
        signs.add(negative)
    return len(signs) <= 1


def letters_text(ring: Ring, f: Polynomial) -> str:
    """A polynomial in lengths alone, factored: "(d3 − d5 − a6) (d3 − d5 + a6)"; "" for a positive number."""
    if roots_in(f):
        return sum_text(ring, f)
    content, factors = f.factor()
    negative = bool(content < 0)
    if len(factors) == 1 and factors[0][1] == 1:
        whole = primitive(factors[0][0])
        same = bool(factors[0][0].coeffs()[0] > 0) != negative
        return sum_text(ring, whole if same else -whole)
    parts = []
    for part, power in factors:
        kept = primitive(part)
        if power % 2 and part.coeffs()[0] < 0:
            negative = not negative
        text = sum_text(ring, kept)
        parts.append((f"({text})" if len(kept) > 1 and len(factors) + power > 2 else text) + _power(int(power)))
    text = " ".join(parts)
    if negative and text:
        return f"−{text}"
    return text


def sum_text(ring: Ring, f: Polynomial) -> str:
    """A polynomial in lengths alone as a sum: "d3² − 2 d3 d5"."""
    text = ""
    for powers, value in f.terms():
        number = abs(value)
        factors = [
            f"{WRITTEN.get(name, name)}{_power(int(e))}" for name, e in zip(ring.names, powers, strict=True) if e
        ]
        body = " ".join(([] if number == 1 and factors else [str(number)]) + factors)
        if text:
            text += f" {'−' if value < 0 else '+'} {body}"
        else:
            text = ("−" if value < 0 else "") + body
    return text or "0"


def _power(e: int) -> str:
    if e == 1:
        return ""
    return str(e).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))


def decided_by_numbers(chain: Chain, tree: RankTree, plain: RankTree) -> bool:
    """Whether what a tree with letters leaves open, or rules out, makes no difference for the arm's own lengths.

    So it is where the tree with numbers leaves nothing open and has nothing besides. A set that it could not look into
    is open as much as a system that it could not take apart: either may hold what the tree with letters has not.

    Args:
        chain: the arm, with letters.
        tree: of it, with letters; every system was looked into.
        plain: of the arm with numbers for its lengths.
    """
    return tree.complete and plain.is_finished and covered_by_numeric_tree(chain, tree, plain)


def splits(chain: Chain, tree: RankTree) -> bool:
    """Whether a condition of a drop, irreducible with letters, has factors at the arm's own lengths, or is lost there.

    a5 − d3 sin θ5 has a square in it where a5 = d3: it touches zero only, and real points of it are met by chance. A
    condition with two factors holds on two families, and one whose degree in t_j is lower at θ_j = π too.
    """
    values = {name: flint().fmpq(x.numerator, x.denominator) for name, x in chain.letters.items()}
    distinct = {str(f): f for drop in tree.drops for f in drop.piece.equations if len(f) <= _LONG}
    try:
        return bool(values) and any(_splits(chain.ring, f, f.subs(values)) for f in distinct.values())
    except OutOfTime:  # not known: as if it had
        return True


def _splits(ring: Ring, f: Polynomial, own: Polynomial) -> bool:
    """Whether a condition f that is `own` at the arm's lengths has not one factor there, as f has."""
    if own == 0 or own.degrees()[: ring.angles] != f.degrees()[: ring.angles]:
        return True
    powers = [power for part, power in factor(own) if not is_number(part) and not ring.is_unit(part)]
    return powers != [1]


def with_equal_lengths(chain: Chain) -> Chain | None:
    """The arm with one letter for lengths that are equal or opposite; None where no two letters are."""
    changed: dict[str, tuple[int, str]] = {}
    kept: dict[Fraction, str] = {}
    for name, value in chain.letters.items():
        other = kept.setdefault(abs(value), name)
        if other != name:
            changed[name] = (1 if value == chain.letters[other] else -1, other)
    if changed:
        return chain.with_letters(changed)
    return None


def covered_by_numeric_tree(chain: Chain, tree: RankTree, plain: RankTree) -> bool:
    """Whether every drop of the arm with numbers lies in one that was derived with letters.

    Args:
        chain: the arm, with letters.
        tree: of it.
        plain: of the arm with numbers for its lengths.
    """
    for drop in plain.drops:
        points = [
            point.replace_values({name: residue(value, point.prime) for name, value in chain.letters.items()})
            for point in drop.piece.samples
        ]
        if not any(other.piece.holds_at(points) for other in tree.drops if other.rank <= drop.rank):
            return False
    return True


def assumptions(
    chain: Chain, drops: Sequence[Drop], lowest: int, work: Work, *, derive: bool
) -> list[Assumption]:
    """The factors in lengths alone that were divided by, and what happens where they vanish.

    Factors that no lengths of these signs can make zero are left out. Where a factor says that two lengths are equal
    or opposite, the arm with such lengths can be derived too: then the families that it has besides are reported, and
    an assumption without any is left out.

    Args:
        chain: the arm.
        drops: of its rank.
        lowest: rank down to which drops were looked for.
        work: the derivation: its deadline, and what it assumed.
        derive: whether arms of special lengths are derived.
    """
    assumed = []
    for f in list(work.assumed.values()):
        if never_zero(chain, f):
            continue
        equal = _equal(chain, f)
        special = None
        if derive and equal is not None:
            with suppress(OutOfTime):
                special = _special_families(chain, equal, drops, lowest, work)
        if special == []:
            continue
        listed = special or []
        assumed.append(
            Assumption(
                text=_unequal(chain, f, equal), holds=sign_of(chain, f) != 0, derived=special is not None, equal=equal,
                families=tuple(listed[:_LISTED]), more=len(listed[_LISTED:]),
            )
        )  # fmt: skip
    return assumed


def _unequal(chain: Chain, f: Polynomial, equal: EqualLengths | None) -> str:
    """What is assumed, as a formula."""
    if equal is not None:
        return f"{equal.length} ≠ {'−' if equal.sign < 0 else ''}{equal.other}"
    return f"{sum_text(chain.ring, f)} ≠ 0"


def _equal(chain: Chain, f: Polynomial) -> EqualLengths | None:
    """f = x ∓ y for two lengths; None for another factor."""
    names = chain.ring.names
    terms = list(primitive(f).terms())
    if len(terms) != 2 or f.total_degree() != 1 or any(abs(value) != 1 for _, value in terms):
        return None
    (first_name, first), (second_name, second) = ((names[list(powers).index(1)], value) for powers, value in terms)
    return EqualLengths(first_name, 1 if first != second else -1, second_name)


def _special_families(
    chain: Chain, equal: EqualLengths, drops: Sequence[Drop], lowest: int, work: Work
) -> list[SpecialFamily]:
    """The families that the special arm has besides."""
    special = chain.with_letters({equal.other: (equal.sign, equal.length)})
    inner = Work(work.remaining)
    tree = rank_tree(special, inner, lowest=lowest)
    if not tree.is_finished:
        raise OutOfTime  # what else there is for such lengths is not known
    fresh = [drop for drop in tree.drops if not _is_general(drop, drops, equal)]
    rows = []
    for rank in sorted({drop.rank for drop in fresh}, reverse=True):
        pieces = [tidy(drop.piece, inner) for drop in fresh if drop.rank == rank]
        rows += [SpecialFamily(row.texts, tree.generic_rank - rank) for row in merge(pieces)]
    return rows


def _is_general(drop: Drop, drops: Sequence[Drop], equal: EqualLengths) -> bool:
    """Whether a set of the special arm lies in one of the general arm's, of the same or a lower rank."""
    points = [
        point.replace_values({equal.other: equal.sign * point[equal.length] % point.prime})
        for point in drop.piece.samples
    ]
    return any(other.piece.holds_at(points) for other in drops if other.rank <= drop.rank)
