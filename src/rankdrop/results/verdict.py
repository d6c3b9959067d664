"""What a run may claim, in one sentence: printed first and last, written to the JSON, and followed by the exit code.

A verdict is *verified* where every check that was made holds; then it says which were made: families sampled, derived
exactly, or both. Where one fails it says which, with counts, and nothing is called verified.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rankdrop.exact.arm.chain import Chain, exact_chain

if TYPE_CHECKING:
    from rankdrop.results.analysis import Analysis
    from rankdrop.results.conditions import Conditions

VERIFIED, UNCHECKED, CONTRADICTED, UNSOUND, INCOMPLETE, INEXACT, INTERRUPTED = (
    "verified", "unchecked", "contradicted", "unsound", "incomplete", "not exact", "interrupted",
)  # fmt: skip
SAMPLED, EXACT = "sampled", "derived exactly"
_BOTH = "too small and too large"
_SAID = {CONTRADICTED: "Contradicted", UNSOUND: "A test failed", INCOMPLETE: "Incomplete", INEXACT: "Not exact"}
_BROKEN = tuple(_SAID)  # worst first


@dataclass(frozen=True, slots=True)
class Verdict:
    """What may be claimed.

    Attributes:
        word: "verified"; "unchecked", derived completely and tried on nothing; "contradicted", two ways differ;
            "unsound", a row's conditions hold elsewhere too; "incomplete"; "not exact", the condition that was asked
            about; "interrupted".
        claims: of "sampled" and "derived exactly", what was done and holds.
        sentence: for people.
    """

    word: str
    claims: tuple[str, ...]
    sentence: str

    @property
    def holds(self) -> bool:
        """Whether nothing speaks against what is claimed: exit code 0."""
        return self.word in (VERIFIED, UNCHECKED)

    def to_dict(self) -> dict[str, object]:
        """The entries of a JSON file."""
        return {"verdict": self.word, "claims": list(self.claims), "sentence": self.sentence}


def of_analysis(analysis: Analysis, derived: Conditions | None = None) -> Verdict:
    """The verdict on an analysis.

    Args:
        analysis: sampled, with or without exact conditions beside it.
        derived: exact conditions derived later, for a report; what they contradict is contradicted.
    """
    exact = _agrees(analysis, derived) and not exact_chain(analysis.robot, analysis.task).rounded
    claims = ((SAMPLED,) if analysis.sound_and_complete else ()) + ((EXACT,) if exact else ())
    if not analysis.complete:
        text = f"Interrupted: corank {analysis.unfinished} is unfinished; nothing is said about it and higher ones."
        return Verdict(INTERRUPTED, claims, text)
    wrong = list(_wrong(analysis))
    if derived is not None and derived.complete:  # of an unfinished one it says nothing that a point is on no family
        wrong += [(CONTRADICTED, text) for text in derived.disagreements]
    sentence = f"Verified, {' and '.join(claims)}: {_all(analysis, derived)}."
    return _failed(wrong, claims) or Verdict(VERIFIED, claims, sentence)


def of_conditions(derived: Conditions, tested: str = "exact") -> Verdict:
    """The verdict on an exact derivation.

    Args:
        derived: exactly.
        tested: what was found of a condition that was held against it: "exact", "too small", … "not tested".
    """
    ranks = sum(family.rank_check.tested for family in derived.families)
    exactly, rounded = _exactness(derived.chain)
    sampled = derived.explained.tested > 0 and _explains_all(derived)
    claims = ((EXACT,) if derived.complete and not rounded else ()) + ((SAMPLED,) if sampled else ())
    if derived.interrupted:
        return Verdict(INTERRUPTED, claims, "Interrupted: what was derived by then is shown, and what is left is told.")
    wrong = [(CONTRADICTED, text) for text in derived.disagreements]
    if not _explains_all(derived) and not wrong and derived.complete:
        left = derived.explained.tested - derived.explained.agree
        wrong.append((CONTRADICTED, f"{left:,} configurations found numerically lie on no family"))
    wrong += [(INCOMPLETE, f"no rank was tried on {row.id}") for row in derived.families if not row.rank_check.tested]
    if not derived.complete:
        things = derived.left
        told = things[0] if len(things) == 1 else f"{len(things)} things were left unfinished, told at the end"
        wrong.append((INCOMPLETE, told))
    if tested != "exact":
        how = f"is {_BOTH if tested == 'both' else tested}"
        wrong.append((INEXACT, f"the condition asked about {how}"))
    failed = _failed(wrong, claims)
    if failed is not None:
        return failed
    count = _families(len(derived.families))
    tail = "not tried on configurations found numerically"
    asked = f"; coranks above {derived.generic_rank - derived.lowest} were not asked for" if derived.lowest else ""
    if derived.explained.tested:
        on = f"{derived.explained.tested:,} of {derived.explained.tested:,} singular configurations found numerically"
        return Verdict(VERIFIED, claims, f"Verified, {exactly} and sampled: {on} lie on {_the(count)}{asked}{rounded}.")
    if ranks:
        on = f"the rank is as claimed at {ranks:,} random points of {_the(count)}"
        return Verdict(VERIFIED, claims, f"Verified, {exactly}: {on}; {tail}{asked}{rounded}.")
    return Verdict(UNCHECKED, claims, f"{exactly.capitalize()}: {count}; {tail}{asked}{rounded}.")


def _exactness(chain: Chain) -> tuple[str, str]:
    """How a derivation was made, and what was rounded for it: "" where nothing was."""
    if not chain.rounded:
        return EXACT, ""
    texts = [one.text for one in chain.rounded]
    more = f" (and {len(texts) - 1} more)" if len(texts) > 1 else ""
    return "derived for rounded numbers", f"; {texts[0]}{more}: the conditions are those of the rounded arm"


def _failed(wrong: list[tuple[str, str]], claims: tuple[str, ...]) -> Verdict | None:
    """The worst of what is wrong gives the word; the first of each kind is told, with the number of the others."""
    if not wrong:
        return None
    word = min((word for word, _ in wrong), key=_BROKEN.index)
    texts = []
    for kind in _BROKEN:
        mine = [text for one, text in wrong if one == kind]
        more = f" (and {len(mine) - 1} more)" if len(mine) > 1 else ""
        texts += [f"{mine[0].rstrip('.')}{more}"] if mine else []
    return Verdict(word, claims, f"{_SAID[word]}: {'; '.join(texts)}.")


def _agrees(analysis: Analysis, derived: Conditions | None = None) -> bool:
    beside = analysis.exact is not None and analysis.exact.agrees
    return beside or (derived is not None and of_conditions(derived).holds)


def _wrong(analysis: Analysis) -> Iterator[tuple[str, str]]:
    comparison = analysis.exact
    if comparison is not None and comparison.derived and not comparison.agrees:
        for text in comparison.disagreements:
            yield CONTRADICTED, f"a test contradicts the derivation, {text}"
    for row in analysis.families:
        if row.named and row.soundness.agree < row.soundness.tested:
            regular = row.soundness.tested - row.soundness.agree
            yield UNSOUND, f"{row.id} also holds at {regular:,} of {row.soundness.tested:,} solutions that are regular"
    for one in analysis.coranks:
        share = one.completeness
        if share.agree < share.tested:
            missed = share.tested - share.agree
            yield INCOMPLETE, f"corank {one.corank}, {missed:,} of {share.tested:,} fresh singular points on no row"
    for row in analysis.families:
        if not row.named:
            yield INCOMPLETE, f"no conditions were found for {row.id}"
    if comparison is not None and not comparison.derived and not comparison.holds:
        yield INCOMPLETE, f"exact conditions were asked for and not derived, {comparison.reason}"


def _all(analysis: Analysis, derived: Conditions | None) -> str:
    comparison = analysis.exact
    if _agrees(analysis):
        exactly = "all conditions are exact" if analysis.families else "the exact derivation has none either"
    elif derived is not None:
        done = _agrees(analysis, derived)
        on = f"{derived.explained.agree:,} of {derived.explained.tested:,} configurations found lie on exact families"
        exactly = on if done else "the exact conditions are not complete"
    else:
        exactly = "exact conditions were not " + ("asked for" if comparison is None else "derived")
    if not analysis.families:
        starts = sum(one.starts for one in analysis.coranks)
        return f"no singular configuration met from {starts:,} starts, which is no proof of absence; {exactly}"
    fresh = sum(one.completeness.tested for one in analysis.coranks)
    rows = _families(len(analysis.families))
    explain = "explains" if len(analysis.families) == 1 else "explain"
    return f"{rows} {explain} {fresh:,} of {fresh:,} fresh singular points; {exactly}"


def _explains_all(derived: Conditions) -> bool:
    return derived.explained.tested == derived.explained.agree


def _families(count: int) -> str:
    return "no family" if not count else "1 family" if count == 1 else f"{count} families"


def _the(count: str) -> str:
    return {"no family": count, "1 family": "the family"}.get(count, f"the {count}")
