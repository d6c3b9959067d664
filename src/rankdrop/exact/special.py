"""What an arm of special lengths adds: the derivation done again where an assumption on the lengths fails."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.polynomial import primitive
from rankdrop.exact.algebra.tidy import tidy
from rankdrop.exact.algebra.work import OutOfTime, Work
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.letters import never_zero, sign_of, sum_text
from rankdrop.exact.family import Assumption
from rankdrop.exact.merge import merge
from rankdrop.exact.tree import Drop, rank_tree

_NUMBERS = {1: "one freedom", 2: "two freedoms", 3: "three freedoms", 4: "four freedoms", 5: "five freedoms"}
_SHOWN = 3  # families of a special arm that are named in its sentence


@dataclass(frozen=True, slots=True)
class _Equal:
    """letter = sign · other."""

    letter: str
    sign: int
    other: str


def assumptions(chain: Chain, drops: Sequence[Drop], generic_rank: int, lowest: int, work: Work) -> list[Assumption]:
    """The factors in lengths alone that were divided by, and what happens where they vanish.

    Factors that no lengths of these signs can make zero are left out. Where a factor says that two lengths are equal
    or opposite, the arm with such lengths is derived too, and the families that it has besides are told.

    Args:
        chain: the arm.
        drops: of its rank.
        generic_rank: of the task Jacobian.
        lowest: rank down to which drops were looked for.
        work: the derivation: its deadline, and what it assumed.
    """
    found = []
    for f in list(work.assumed.values()):
        if never_zero(chain, f):
            continue
        equal = _equal(chain, f)
        words, derived = "", False
        if equal is not None:
            try:
                words, derived = _words(chain, equal, drops, generic_rank, lowest, work), True
            except OutOfTime:
                words = ""
        if derived and not words:
            continue  # the special arm has no further families: nothing was assumed
        found.append(Assumption(_unequal(chain, f, equal), sign_of(chain, f) != 0, words, derived))
    return found


def _unequal(chain: Chain, f: Polynomial, equal: _Equal | None) -> str:
    if equal is not None:
        return f"{equal.letter} ≠ {'−' if equal.sign < 0 else ''}{equal.other}"
    return f"{sum_text(chain.ring, f)} ≠ 0"


def _equal(chain: Chain, f: Polynomial) -> _Equal | None:
    """f = x ∓ y for two lengths; None for another factor."""
    names = chain.ring.names
    terms = list(primitive(f).terms())
    if len(terms) != 2 or f.total_degree() != 1 or any(abs(value) != 1 for _, value in terms):
        return None
    (one, first), (two, second) = ((names[list(powers).index(1)], value) for powers, value in terms)
    return _Equal(one, 1 if first != second else -1, two)


def _words(
    chain: Chain, equal: _Equal, drops: Sequence[Drop], generic_rank: int, lowest: int, work: Work
) -> str:
    """The families that the special arm has besides, in one sentence; "" for none."""
    special = chain.with_letters({equal.other: (equal.sign, equal.letter)})
    inner = Work(work.left)
    tree = rank_tree(special, inner, lowest=lowest)
    if not tree.finished:
        raise OutOfTime  # what else there is for such lengths is not known
    fresh = [drop for drop in tree.drops if not _known(drop, drops, equal)]
    rows = []
    for rank in range(generic_rank - 1, lowest - 1, -1):
        pieces = [tidy(drop.piece, inner) for drop in fresh if drop.rank == rank]
        rows += [(row.texts, generic_rank - rank) for row in merge(pieces)]
    if not rows:
        return ""
    told = [_sentence(texts, corank) for texts, corank in rows[:_SHOWN]]
    more = f", and {len(rows) - _SHOWN} more families" if len(rows) > _SHOWN else ""
    sign = "−" if equal.sign < 0 else ""
    return f"if {equal.letter} = {sign}{equal.other}, " + "; ".join(told) + more


def _sentence(texts: tuple[str, ...], corank: int) -> str:
    lost = _NUMBERS.get(corank, str(corank))
    return f"{texts[0]} alone loses {lost}" if len(texts) == 1 else f"{', '.join(texts)} together lose {lost}"


def _known(drop: Drop, drops: Sequence[Drop], equal: _Equal) -> bool:
    """Whether a set of the special arm lies in one of the general arm's, of the same or a lower rank."""
    points = [
        point.changed({equal.other: equal.sign * point[equal.letter] % point.prime}) for point in drop.piece.samples
    ]
    return any(other.piece.holds_at(points) for other in drops if other.rank <= drop.rank)
