"""What a search may have missed, and how conditions were obtained, read from the sentences that files hold."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from rankdrop.families.corank_families import Estimator, Unseen
from rankdrop.families.evidence import FamilyEvidence, ObtainedFrom

_ESTIMATORS: Sequence[tuple[str, Estimator]] = (
    (r"no point was found\Z", Estimator.NO_POINT),
    (r"Good–Turing: (?P<once>\d{1,18}) of (?P<pieces>\d{1,18}) pieces found once in (?P<number>\d{1,18}) points",
     Estimator.GOOD_TURING),
    (r"none of (?P<number>\d{1,18}) starts converged; rule of three on the starts\Z", Estimator.NO_START),
)  # fmt: skip
"""Sentences on how unseen sets were estimated, with the names of their counts."""

_WITHOUT_NUMBERS = (ObtainedFrom.EXACT, ObtainedFrom.VALUES, ObtainedFrom.FITTED, ObtainedFrom.SHARED_VALUES)
"""Kinds of evidence that are read again from their words in files."""


def unseen_of_sentence(sentence: str, estimate: float, upper: float) -> Unseen:
    """The estimate of unseen sets of a file, with the counts that its sentence gives.

    Args:
        sentence: how it was estimated.
        estimate, upper: the share, and its upper bound at 95 % confidence.

    Example:
        >>> unseen_of_sentence("none of 100 starts converged; rule of three on the starts", 0.0, 0.03).number
        100
    """
    for pattern, estimator in _ESTIMATORS:
        match = re.match(pattern, sentence)
        if match is not None:
            counts: dict[str, Any] = {name: int(value) for name, value in match.groupdict().items()}
            unseen = Unseen(estimate, upper, estimator, **counts)
            if unseen.how == sentence:
                return unseen
    return Unseen(estimate, upper, Estimator.STORED, text=sentence)


def evidence_of_sentence(sentence: str) -> FamilyEvidence:
    """How the conditions of a family of a file were obtained.

    Example:
        >>> evidence_of_sentence("exact condition").kind
        <ObtainedFrom.EXACT: 'exact'>
    """
    for kind in _WITHOUT_NUMBERS:
        evidence = FamilyEvidence(kind)
        if str(evidence) == sentence:
            return evidence
    return FamilyEvidence(ObtainedFrom.STORED, text=sentence)
