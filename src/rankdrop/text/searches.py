"""A search in words: what became of its starts, and how the share of sets that it has not seen was estimated."""

from __future__ import annotations

from rankdrop.families.corank_families import Estimator, Unseen
from rankdrop.families.searching import Outcome, Search
from rankdrop.sections import Section

_OUTCOMES = {
    Outcome.CONVERGED: "converged",
    Outcome.NEAR_MISS: "near miss",
    Outcome.SLOW: "slow",
    Outcome.NOT_RUN: "not run",
    Outcome.CREASE: "stuck on a crease",
}
_ESTIMATORS = {
    Estimator.NO_POINT: "no point was found",
    Estimator.GOOD_TURING: "Good–Turing: {once} of {pieces} pieces found once in {number} points{bound}",
    Estimator.NO_START: "none of {number} starts converged; rule of three on the starts",
    Estimator.STORED: "{text}",
}


def sections_of(search: Search) -> tuple[Section, ...]:
    """For notebooks: what became of the starts, and the smallest near miss."""
    counts = [(_OUTCOMES[outcome], search.count(outcome)) for outcome in Outcome]
    smallest = search.smallest_near_miss
    after: tuple[str, ...] = ()
    if smallest is not None:
        after = (f"smallest near miss σ = {smallest:.4g}, not singular",)
    section = Section(
        f"{search.robot.name}: search for corank {search.corank}",
        f"method {search.method}, seed {search.seed}",
        columns=("outcome", "starts"),
        rows=tuple((name, f"{number:,}") for name, number in counts if number),
        after=after,
    )
    return (section,)


def unseen_words(unseen: Unseen) -> str:
    """How the share of unseen sets was estimated, with the counts that were used.

    Example:
        >>> unseen_words(Unseen(0.0, 0.003, Estimator.GOOD_TURING, once=0, pieces=8, number=1000))
        'Good–Turing: 0 of 8 pieces found once in 1000 points; rule of three'
    """
    bound = ""
    if not unseen.once:
        bound = "; rule of three"
    return _ESTIMATORS[unseen.estimator].format(
        once=unseen.once, pieces=unseen.pieces, number=unseen.number, bound=bound, text=unseen.text
    )
