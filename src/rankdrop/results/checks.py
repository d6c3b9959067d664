"""How an analysis was checked, in sentences that the terminal and the report share; every number is in the JSON too."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rankdrop.families.cells import share_text

if TYPE_CHECKING:
    from rankdrop.results.analysis import Analysis


def sampled(analysis: Analysis) -> str:
    """How many solutions of the rows' conditions are singular, how many fresh points the rows explain; "" for none."""
    if not analysis.families:
        return ""
    solved = sum(row.soundness.tested for row in analysis.families)
    singular = sum(row.soundness.singular for row in analysis.families)
    fresh = sum(row.completeness.tested for row in analysis.coranks)
    explained = sum(row.completeness.explained for row in analysis.coranks)
    return (
        f"Sampled: {singular:,} of {solved:,} points solved from the rows' conditions are singular "
        f"(σ ≤ {analysis.settings.tolerances.singular:g}), and the rows explain {explained:,} of {fresh:,} fresh "
        f"singular points, none of which made them ({share_text(explained, fresh)})."
    )


def unseen(analysis: Analysis) -> str:
    """What the searches may have missed, at the corank where that is most; "" where nothing converged."""
    found = [row for row in analysis.coranks if row.converged]
    if not found:
        return ""
    worst = max(found, key=lambda row: row.unseen.upper)
    share = f"an estimated {worst.unseen.estimate:.2%} of where searches end, {worst.unseen.upper:.2%} at most (95 %)"
    return f"Not seen by sampling: {share}, worst at corank {worst.corank} ({worst.unseen.how})."
