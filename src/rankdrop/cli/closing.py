"""The closing lines of an analysis: how it was verified, what sampling has not seen, how long it took."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rankdrop.atlas.cells import share_text

if TYPE_CHECKING:
    from rankdrop.result import Analysis


def closing_text(analysis: Analysis, seconds: float) -> str:
    """A few sentences; every number in them stands in the JSON as well, except the time."""
    sentences = [_unfinished(analysis), _verified(analysis), _unseen(analysis), f"Time taken: {seconds:.1f} s."]
    return " ".join(sentence for sentence in sentences if sentence)


def _unfinished(analysis: Analysis) -> str:
    if analysis.complete:
        return ""
    return f"Interrupted: corank {analysis.unfinished} is unfinished and not shown; nothing is said about higher ones."


def _verified(analysis: Analysis) -> str:
    if not analysis.families:
        return ""
    solved = sum(row.soundness.tested for row in analysis.families)
    singular = sum(row.soundness.singular for row in analysis.families)
    fresh = sum(row.completeness.tested for row in analysis.coranks)
    explained = sum(row.completeness.explained for row in analysis.coranks)
    verdict = "Verified" if analysis.sound_and_complete else "Not all verified"
    return (
        f"{verdict}: {singular:,} of {solved:,} points solved from the rows' conditions are singular "
        f"(σ ≤ {analysis.settings.tolerances.singular:g}), and the rows explain {explained:,} of {fresh:,} fresh "
        f"singular points ({share_text(explained, fresh)})."
    )


def _unseen(analysis: Analysis) -> str:
    found = [row for row in analysis.coranks if row.converged]
    if not found:
        return ""
    worst = max(found, key=lambda row: row.unseen.upper)
    share = f"an estimated {worst.unseen.estimate:.2%} of where searches end, {worst.unseen.upper:.2%} at most (95 %)"
    return f"Not seen by sampling: {share}, worst at corank {worst.corank} ({worst.unseen.how})."
