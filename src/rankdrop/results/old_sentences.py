"""Facts of the sentences in files: why there is no derivation, how unseen sets were estimated, and up to version 0.2
remarks and what contradicts a derivation.

A sentence that no reader here knows, or that its facts would word in another way, is kept as it is.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from math import radians

from rankdrop.exact.arm.geometry import Deviation
from rankdrop.exact.family import EqualLengths
from rankdrop.exact.remark import DerivationRemark, RemarkOn
from rankdrop.families.contradiction import Contradiction, ContradictionKind
from rankdrop.families.not_derived import NotDerived, NotDerivedKind
from rankdrop.results.old_files import name_of_words

_Groups = tuple[str, ...]

_FOR_THESE = "for these lengths"

_REASONS: Sequence[tuple[str, Callable[[_Groups], NotDerived]]] = (
    (r"the derivation takes more than (.+) s\Z",
     lambda groups: NotDerived(NotDerivedKind.TIME, seconds=float(groups[0]))),
    (r"interrupted\Z", lambda _: NotDerived(NotDerivedKind.INTERRUPTED)),
    (r"(\d+) cases? (?:was|were) not taken apart\Z",
     lambda groups: NotDerived(NotDerivedKind.UNDIVIDED, number=int(groups[0]))),
)  # fmt: skip
"""Reasons why nothing was derived, and what makes the facts of their parts."""


def remarks_of_sentences(sentences: Iterable[str]) -> tuple[DerivationRemark, ...]:
    """Remarks of their sentences.

    Example:
        >>> (remark,) = remarks_of_sentences(["d4 = −a2 for this arm: derived with one letter for both"])
        >>> remark.kind.name, remark.equal
        ('ONE_LETTER', (EqualLengths(length='d4', sign=-1, other='a2'),))
    """
    return tuple(map(_remark, sentences))


def contradictions_of_sentences(sentences: Iterable[str]) -> tuple[Contradiction, ...]:
    """Contradictions of their sentences.

    Example:
        >>> (found,) = contradictions_of_sentences(["the rank is 3 almost everywhere exactly, 4 numerically"])
        >>> found.kind.name, found.full_rank, found.rank
        ('GENERIC_RANK', 3, 4)
    """
    return tuple(map(_contradiction, sentences))


def reason_of_sentence(sentence: str) -> NotDerived | None:
    """Why nothing was derived, of its sentence; None for "", where the families were derived.

    Example:
        >>> reason_of_sentence("the derivation takes more than 30 s").seconds
        30.0
    """
    if not sentence:
        return None
    for pattern, make in _REASONS:
        match = re.match(pattern, sentence)
        if match is not None:
            reason = make(match.groups())
            if str(reason) == sentence:
                return reason
    return NotDerived(NotDerivedKind.STORED, text=sentence)


def _remark(sentence: str) -> DerivationRemark:
    for pattern, make in _REMARKS:
        match = re.match(pattern, sentence)
        if match is not None:
            remark = make(match.groups())
            if str(remark) == sentence:
                return remark
    return DerivationRemark(RemarkOn.STORED, text=sentence)


def _contradiction(sentence: str) -> Contradiction:
    for pattern, make in _CONTRADICTIONS:
        match = re.match(pattern, sentence)
        if match is not None:
            contradiction = make(match.groups())
            if str(contradiction) == sentence:
                return contradiction
    return Contradiction(ContradictionKind.STORED, text=sentence)


def _point(groups: _Groups) -> DerivationRemark:
    joints, miss = groups
    deviation = Deviation("point", tuple(map(int, joints.split(", "))), float(miss) / 1000)
    return DerivationRemark(RemarkOn.NEAR, deviation=deviation)


def _parallel(groups: _Groups) -> DerivationRemark:
    first, second, angle = groups
    deviation = Deviation("parallel", (int(first), int(second)), radians(float(angle)))
    return DerivationRemark(RemarkOn.NEAR, deviation=deviation)


def _one_letter(groups: _Groups) -> DerivationRemark:
    return DerivationRemark(RemarkOn.ONE_LETTER, equal=tuple(map(_equal, groups[0].split(", "))))


def _equal(pair: str) -> EqualLengths:
    length, _, other = pair.partition(" = ")
    if other[:1] == "−":
        return EqualLengths(length, -1, other[1:])
    return EqualLengths(length, 1, other)


def _follower(groups: _Groups) -> DerivationRemark:
    part, leader, column, factor, _ = groups
    return DerivationRemark(
        RemarkOn.FOLLOWER, part=part, leader=leader, column=int(column), factor=float(factor.replace("−", "-"))
    )


def _near_misses(groups: _Groups) -> DerivationRemark:
    corank, number, followed, sigma = groups
    many = int(number.replace(",", ""))
    least = None
    if sigma is not None:
        least = float(sigma)
    return DerivationRemark(
        RemarkOn.NEAR_MISSES, corank=int(corank), number=many, followed=int(followed or many), sigma=least
    )


def _always(kind: RemarkOn) -> Callable[[_Groups], DerivationRemark]:
    return lambda _: DerivationRemark(kind)


_REMARKS: Sequence[tuple[str, Callable[[_Groups], DerivationRemark]]] = (
    (r"the axes of joints ([\d, ]+) miss a common point by ([\d.e+-]+) mm\Z", _point),
    (r"axes (\d+) and (\d+) are ([\d.e+-]+)° from parallel\Z", _parallel),
    (r"(.+) for this arm: derived with one letter for both\Z", _one_letter),
    (rf"(.+) = 0 {_FOR_THESE}, which letters rule out: derived with numbers\Z",
     lambda groups: DerivationRemark(RemarkOn.RULED_OUT, polynomial=groups[0])),
    (rf"a condition has several factors {_FOR_THESE}: derived with numbers\Z", _always(RemarkOn.SEVERAL_FACTORS)),
    (r"conditions that are independent for general lengths .+\Z", _always(RemarkOn.DEPENDENT)),
    (r"lengths are numbers: with letters the derivation takes .+\Z", _always(RemarkOn.LONGER_WITH_LETTERS)),
    (r"lengths are numbers: with letters (\d+) systems? .+\Z",
     lambda groups: DerivationRemark(RemarkOn.UNDIVIDED_WITH_LETTERS, number=int(groups[0]))),
    (r"lengths are numbers: conditions for general lengths miss .+\Z", _always(RemarkOn.MISSED_BY_LETTERS)),
    (r"joint (.+) follows joint (.+): column (\d+) of the Jacobian contains (\S+) times the screw of (.+)\Z",
     _follower),
    (r"joint numbers count the variables; .+\Z", _always(RemarkOn.NUMBERS_OF_VARIABLES)),
    (r"corank (\d+): ([\d,]+) configurations? with a small σ on no family left out: (?:(\d+) of them, .+, )?followed "
     r"with 50 digits, the rank does not drop there(?: \(smallest σ (.+)\))?\Z", _near_misses),
)  # fmt: skip
"""Sentences of remarks, and what makes the facts of their parts."""


def _off_families(groups: _Groups) -> Contradiction:
    corank, wrong, tested, q = groups
    return Contradiction(
        ContradictionKind.OFF_FAMILIES, corank=int(corank), wrong=_whole(wrong), tested=_whole(tested),
        q=tuple(float(value.replace("−", "-")) for value in q.split(", ")),
    )  # fmt: skip


def _whole(number: str) -> int:
    return int(number.replace(",", ""))


def _rank(groups: _Groups) -> Contradiction:
    family, rank, wrong, tested = groups
    return Contradiction(ContradictionKind.RANK, family=family, rank=int(rank), wrong=int(wrong), tested=int(tested))


def _generic_rank(groups: _Groups) -> Contradiction:
    exact, numeric = groups
    return Contradiction(ContradictionKind.GENERIC_RANK, full_rank=int(exact), rank=int(numeric))


def _not_listed(groups: _Groups) -> Contradiction:
    family, name, corank, rank = groups
    return Contradiction(
        ContradictionKind.NOT_LISTED, family=family, called=name_of_words(name), corank=int(corank), rank=int(rank)
    )


def _no_point(groups: _Groups) -> Contradiction:
    family, name = groups
    return Contradiction(ContradictionKind.NO_POINT, family=family, called=name_of_words(name))


def _dimension(groups: _Groups) -> Contradiction:
    family, name, dimension = groups
    return Contradiction(
        ContradictionKind.DIMENSION, family=family, called=name_of_words(name), dimension=int(dimension)
    )


_CONTRADICTIONS: Sequence[tuple[str, Callable[[_Groups], Contradiction]]] = (
    (r"the rank is (\d+) almost everywhere exactly, (\d+) numerically\Z", _generic_rank),
    (r"(\S+): the rank modulo a prime is not (\d+) at (\d+) of (\d+) random points\Z", _rank),
    (r"corank (\d+): ([\d,]+) of ([\d,]+) configurations found numerically lie on no family, q = \((.+)\) is one\Z",
     _off_families),
    (r"derived (\S+) \((.+)\) is not listed: its corank is (\d+), and the rank found is (\d+)\Z", _not_listed),
    (r"derived (\S+) \((.+)\): no configuration that satisfies its conditions has its corank, .+\Z", _no_point),
    (r"derived (\S+) \((.+)\): its dimension is at most (\d+) at configurations .+\Z", _dimension),
)  # fmt: skip
"""Sentences on what contradicts a derivation, and what makes the facts of their parts."""
