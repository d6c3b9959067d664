"""What a run may claim, in words. Records are those of `rankdrop.results`.

A verdict is *verified* where every check that was made holds; then it says which were made: families sampled, derived
exactly, or both. Where one fails it says which, with counts, and nothing is called verified. Failures are facts: a key
of `FAILURES` with what goes into its words.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.remark import rounded_number
from rankdrop.families.record import exact_of
from rankdrop.families.summary import (
    CONTRADICTED,
    INCOMPLETE,
    INEXACT,
    INTERRUPTED,
    UNCHECKED,
    UNSOUND,
    VERIFIED,
    Evidence,
    FamilySummary,
    RankSummary,
    Verdict,
    summarise_families,
)
from rankdrop.robot.quantities import count
from rankdrop.text.families import share_text
from rankdrop.text.special import family_label
from rankdrop.text.unfinished import cases_words, why_lowest

SAMPLED, EXACT = "sampled", "derived exactly"
_OPENING = {CONTRADICTED: "Contradicted", UNSOUND: "A test failed", INCOMPLETE: "Incomplete", INEXACT: "Not exact"}
"""First words of a verdict on failures, worst first."""
FAILURES = {
    "derivation": (CONTRADICTED, "a test contradicts the derivation, {0}"),
    "disagreement": (CONTRADICTED, "{0}"),
    "cloud": (CONTRADICTED, "{0:,} configurations found numerically lie on no family"),
    "regular": (UNSOUND, "{0} also holds at {1:,} of {2:,} solutions that are regular"),
    "unexplained": (INCOMPLETE, "corank {0}, {1:,} of {2:,} test points on no row"),
    "unnamed": (INCOMPLETE, "no conditions were found for {0}"),
    "not derived": (INCOMPLETE, "exact conditions were asked for and not derived, {0}"),
    "no rank": (INCOMPLETE, "no rank was tried on {0}"),
    "assumption": (INCOMPLETE, "{0} is assumed, which is not true of this arm"),
    "unfinished": (INCOMPLETE, "{0}"),
    "several unfinished": (INCOMPLETE, "{0} things were left unfinished; see the end"),
    "condition": (INEXACT, "the given condition is {0}"),
}
"""What speaks against a claim: word of the verdict, words of the sentence."""
Failure = tuple[Any, ...]
"""A key of `FAILURES` and what goes into its words."""
_NAMED = 6  # short names of families in the first line
_EXACTLY = "exact derivation"
_EVIDENCE: dict[tuple[str, ...], Evidence] = {
    (): Evidence.NONE, (SAMPLED,): Evidence.TESTED, (EXACT,): Evidence.DERIVED,
    (SAMPLED, EXACT): Evidence.DERIVED_AND_TESTED, (EXACT, SAMPLED): Evidence.DERIVED_AND_TESTED,
}  # fmt: skip
"""Claims of a verdict -> how the families were verified."""


def opening(summary: FamilySummary) -> str:
    """What an arm has: "ur5e has 9 families of singularities: shoulder, elbow, wrist (rank 5); 5 combinations (rank 4);
    1 (rank 3)."
    """
    if summary.generic_rank == 0:
        return f"{summary.arm} is singular everywhere: it moves no row of this task."
    if not summary.ranks:
        if summary.evidence is Evidence.NONE:
            so_far = " so far"
        else:
            so_far = ""
        return f"{summary.arm}: no family of singularities was found{so_far}."
    first, *others = summary.ranks
    parts = [f"{_names(first)} (rank {first.rank})"]
    for before, other in zip(summary.ranks, others, strict=False):
        if _alike(before, other, first):
            words = str(other.families)
        else:
            words = _count_combinations(other)
        parts.append(f"{words} (rank {other.rank})")
    return f"{summary.arm} has {count(summary.families, 'family', 'families')} of singularities: {'; '.join(parts)}."


def answer_of(conditions: Any) -> str:
    """What an arm has, with the cases that were not taken apart."""
    summary = conditions.summary
    cases = count(len(conditions.undivided), "case")
    if not conditions.undivided:
        return opening(summary)
    if not summary.ranks:
        return f"{summary.arm}: singular in {cases} not taken apart into families."
    return f"{opening(summary).rstrip('.')}; and {cases} not taken apart."


def _alike(before: RankSummary, other: RankSummary, first: RankSummary) -> bool:
    """Whether the noun of the rank before holds for this rank too: all are combinations, or none is."""
    alike = all(rank.combinations == rank.families for rank in (before, other))
    return before is not first and (alike or before.combinations == other.combinations == 0)


def _names(ranked: RankSummary) -> str:
    """Names of the families of one rank: "shoulder, elbow, wrist", "wrist (2 families), elbow"."""
    names = [name if many == 1 else f"{name} ({many} families)" for name, many in ranked.names.items()]
    if any("," in name for name in names):
        comma = "; "
    else:
        comma = ", "
    if len(names) <= _NAMED:
        return comma.join(names)
    left = ranked.families - sum(list(ranked.names.values())[:_NAMED])
    return f"{comma.join(names[:_NAMED])}{comma}{left} more"


def _count_combinations(ranked: RankSummary) -> str:
    """Families of a lower rank, counted: "5 combinations", "2 more", "1 combination and 3 more"."""
    others = ranked.families - ranked.combinations
    if ranked.combinations:
        parts = [count(ranked.combinations, "combination")]
    else:
        parts = []
    parts += [f"{others} more"] if others else []
    return " and ".join(parts)


def summary_of_analysis(analysis: Any) -> FamilySummary:
    """Facts of an analysis: families by rank, and how they were verified."""
    tests = sum(summary.completeness.tested for summary in analysis.coranks)
    evidence = _EVIDENCE[of_analysis(analysis).claims]
    label = partial(family_label, analysis.robot, analysis.task)
    return summarise_families(analysis.robot.name, analysis.generic_rank, analysis.families, evidence, tests, label)


def summary_of_conditions(derived: Any) -> FamilySummary:
    """Facts of an exact derivation: families by rank, and how they were verified."""
    tests, evidence = derived.explained.tested, _EVIDENCE[of_conditions(derived).claims]
    label = partial(family_label, derived.robot, derived.task)
    return summarise_families(derived.robot.name, derived.generic_rank, derived.families, evidence, tests, label)


def of_analysis(analysis: Any, derived: Any = None) -> Verdict:
    """The verdict on an analysis.

    Args:
        analysis: sampled, with or without exact conditions beside it.
        derived: exact conditions derived later, for a report; what they contradict is contradicted.
    """
    agrees = analysis.exact is not None and analysis.exact.agrees
    exact = agrees or _holds_in_families(derived)
    exact_claim = exact and not exact_chain(analysis.robot, analysis.task, parts=True).effective_roundings
    claims = _claims((analysis.sound_and_complete, SAMPLED), (exact_claim, EXACT))
    if not analysis.complete:
        text = f"Interrupted: corank {analysis.unfinished} is unfinished; nothing is said about it and higher ones."
        return Verdict(INTERRUPTED, claims, text)
    failures: list[Failure] = [*_failures(analysis)]
    if derived is not None and derived.in_families:  # of an unfinished one it says nothing that a point is on no family
        failures += [("disagreement", contradiction) for contradiction in derived.disagreements]
    if failures:
        return _failed_verdict(failures, claims)
    verified = _verification_words(analysis, derived=exact, exact=exact_claim)
    return Verdict(VERIFIED, claims, f"{verified}{_later_derivation(analysis, derived)}.")


def _holds_in_families(derived: Any) -> bool:
    """Whether every singular configuration is on a family of a derivation that nothing contradicts."""
    return derived is not None and derived.in_families and of_conditions(derived).holds


def _claims(*claims: tuple[bool, str]) -> tuple[str, ...]:
    """Those of the claims that hold."""
    return tuple(claim for holds, claim in claims if holds)


def _verification_words(analysis: Any, *, derived: bool, exact: bool) -> str:
    """How the families of an analysis were verified, in words without the full stop."""
    starts = sum(summary.starts for summary in analysis.coranks)
    tests = count(sum(summary.completeness.tested for summary in analysis.coranks), "random test")
    if exact:
        how = _EXACTLY
    else:
        how = "a derivation for rounded numbers"
    if analysis.families:
        if derived:
            return f"Verified by {how} and {tests}"
        return f"Verified by {tests}"
    if derived and not analysis.coranks:
        return f"Verified by {how}"
    if derived:
        return f"Verified by {how}; {count(starts, 'random search', 'random searches')} found no singularity"
    return f"Sampled: no singular configuration from {count(starts, 'start')}, which is no proof of absence"


def _later_derivation(analysis: Any, derived: Any) -> str:
    """What the verdict on an analysis adds about conditions that were derived later, or not derived."""
    if analysis.exact is not None and analysis.exact.agrees:
        return ""
    if derived is not None:
        on = derived.explained
        if _holds_in_families(derived):
            return f"; {on.agree:,} of {on.tested:,} configurations found lie on exact families"
        return "; the exact conditions are not complete"
    if analysis.exact is None:
        return "; exact conditions were not asked for"
    reason = str(analysis.exact.reason).rstrip(".")
    if analysis.exact.first_derived:
        return f"; exact conditions of corank 1 alone were derived, {reason}"
    return f"; exact conditions were not derived, {reason}"


def _failures(analysis: Any) -> Iterator[Failure]:
    exact = analysis.exact
    if exact is not None and exact.derived and not exact.agrees:
        yield from (("derivation", contradiction) for contradiction in exact.disagreements)
    yield from _sampled_failures(analysis)
    if exact is not None and not exact.derived and not exact.holds:
        yield "not derived", exact.reason


def _sampled_failures(analysis: Any) -> Iterator[Failure]:
    """Families that hold at regular configurations, coranks with points on no row, families without conditions."""
    for row in analysis.families:
        singular, solved = row.soundness.agree, row.soundness.tested
        if row.named and singular < solved:
            yield "regular", row.id, solved - singular, solved
    for summary in analysis.coranks:
        share = summary.completeness
        if share.agree < share.tested:
            yield "unexplained", summary.corank, share.tested - share.agree, share.tested
    yield from (("unnamed", row.id) for row in analysis.families if not row.named)


def of_conditions(derived: Any, tested: str = "exact") -> Verdict:
    """The verdict on an exact derivation.

    Args:
        derived: exactly.
        tested: what was found of a condition that was held against it: "exact", "too small", … "not tested".
    """
    _, rounded = _exactness(derived.chain)
    lie_on, points = derived.explained.agree, derived.explained.tested
    general = all(assumption.holds for assumption in derived.assumptions)
    exact = derived.complete and general and not rounded
    claims = _claims((exact, EXACT), (0 < points == lie_on, SAMPLED))
    if derived.interrupted:
        return Verdict(INTERRUPTED, claims, "Interrupted: finished families are shown, and unfinished sets listed.")
    failures = [*_contradictions(derived)]
    if tested != "exact":
        failures.append(("condition", "too small and too large" if tested == "both" else tested))
    if failures:
        return _failed_verdict(failures, claims)
    return _derivation_verdict(derived, claims)


def _derivation_verdict(derived: Any, claims: tuple[str, ...]) -> Verdict:
    """The verdict on an exact derivation that nothing contradicts: verified where something was tested."""
    exactly, rounded = _exactness(derived.chain)
    how = exactly if rounded else _EXACTLY
    points = derived.explained.tested
    end = f"{rounded}."
    if derived.lowest:
        end = f"; coranks above {derived.generic_rank - derived.lowest} {why_lowest(derived)}{rounded}."
    if derived.undivided:
        end = f"; {cases_words(len(derived.undivided))}{end}"
    if points:
        return Verdict(VERIFIED, claims, f"Verified by {how} and {count(points, 'random test')}{end}")
    return _untested_verdict(derived, claims, how, exactly, end)


def _untested_verdict(derived: Any, claims: tuple[str, ...], how: str, exactly: str, end: str) -> Verdict:
    """The verdict where no singular configuration was found numerically, or none was looked for."""
    if derived.settings.points and not (derived.families or derived.undivided):
        searched = "a search from random starts found no singular configuration either"
        return Verdict(VERIFIED, claims, f"Verified by {how}; {searched}{end}")
    untested = f"not tested on singular configurations found numerically{end}"
    ranks = sum(exact_of(family).rank_check.tested for family in derived.families)
    if ranks:
        on = f"the rank is as derived at {count(ranks, 'random point')} of the families"
        return Verdict(VERIFIED, claims, f"Verified by {how}: {on}; {untested}")
    return Verdict(UNCHECKED, claims, f"{exactly.capitalize()}: {untested}")


def _contradictions(derived: Any) -> Iterator[Failure]:
    lie_on, points = derived.explained.agree, derived.explained.tested
    yield from (("disagreement", contradiction) for contradiction in derived.disagreements)
    if lie_on < points and not derived.disagreements and derived.complete:
        yield "cloud", points - lie_on
    yield from (("no rank", row.id) for row in derived.families if not exact_of(row).rank_check.tested)
    if derived.complete:  # else what is left says so
        yield from (("assumption", assumption.text) for assumption in derived.assumptions if not assumption.holds)
    else:
        alone = len(derived.left) == 1
        yield ("unfinished", derived.left[0]) if alone else ("several unfinished", len(derived.left))


def _exactness(chain: Chain) -> tuple[str, str]:
    """How a derivation was made, and what was rounded for it: "" where nothing was."""
    if not chain.effective_roundings:
        return EXACT, ""
    texts = [str(rounded_number(chain.robot, deviation)) for deviation in chain.effective_roundings]
    if len(texts) > 1:
        more = f" (and {len(texts) - 1} more)"
    else:
        more = ""
    return "a derivation for rounded numbers", f"; {texts[0]}{more}: the conditions are those of the rounded arm"


def _failed_verdict(failures: Sequence[Failure], claims: tuple[str, ...]) -> Verdict:
    """The worst failure gives the word; the first of each kind is reported, with the number of the others."""
    texts: dict[str, list[str]] = {word: [] for word in _OPENING}
    for key, *facts in failures:
        word, words = FAILURES[key]
        texts[word].append(words.format(*facts))
    worst = next(word for word, mine in texts.items() if mine)
    told = [
        f"{mine[0].rstrip('.')}{f' (and {len(mine) - 1} more)' if len(mine) > 1 else ''}"
        for mine in texts.values() if mine
    ]  # fmt: skip
    return Verdict(worst, claims, f"{_OPENING[worst]}: {'; '.join(told)}.")


def sampled(analysis: Any) -> str:
    """How many solutions of the rows' conditions are singular, how many fresh points the rows explain; "" for none."""
    if not analysis.families:
        return ""
    solved = sum(row.soundness.tested for row in analysis.families)
    singular = sum(row.soundness.agree for row in analysis.families)
    fresh = sum(row.completeness.tested for row in analysis.coranks)
    explained = sum(row.completeness.agree for row in analysis.coranks)
    return (
        f"Tested: {singular:,} of {solved:,} points solved from the rows' conditions are singular "
        f"(σ ≤ {analysis.settings.tolerances.singular:g}). "
        f"Explained: {explained:,} of {fresh:,} test points ({share_text(explained, fresh)}), singular points "
        "that were not used to find the families."
    )


def unseen(analysis: Any) -> str:
    """What the searches may have missed, at the corank where that is most; "" where nothing converged."""
    searched = [row for row in analysis.coranks if row.converged]
    if not searched:
        return ""
    worst = max(searched, key=lambda row: row.unseen.upper)
    share = f"an estimated {100 * worst.unseen.estimate:.2f} %, at most {100 * worst.unseen.upper:.2f} % (95 %)"
    how = f"{worst.unseen.how[0].upper()}{worst.unseen.how[1:]}"
    return f"What sampling may have missed: {share} of its searches, worst at corank {worst.corank}. {how}."
