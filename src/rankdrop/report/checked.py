"""How a report's numbers were checked, in sentences with counts, seeds and tolerances."""

from __future__ import annotations

from collections.abc import Iterator

from rankdrop.report.content import Content
from rankdrop.results import sampled, unseen


def checks(content: Content) -> Iterator[str]:
    """One sentence for each check; the residuals are evaluated anew while the report is made."""
    analysis = content.analysis
    settings, again = analysis.settings, analysis.residual()
    where = "within the joint limits" if settings.limits else "in the whole joint space, joint limits ignored"
    yield f"Search: {settings.starts:,} random starts for each corank {where}; seed {settings.seed}."
    if analysis.families:
        yield sampled(analysis)
        yield (
            f"Evaluated again for this report: at the witnesses the equations leave {again.equation:.1e} at most, the "
            f"singular values that have to vanish {again.sigma:.1e} at most."
        )
    if missed := unseen(analysis):
        yield missed
    last = analysis.coranks[-1] if analysis.coranks else None
    if last is not None and not last.converged:
        met = "" if last.smallest_near_miss is None else f"; the smallest σ met was {last.smallest_near_miss:.4g}"
        yield f"Corank {last.corank}: none found of {last.starts:,} starts{met}. That is no proof of absence."
    yield from _drawn(content)
    yield f"Singular values have no unit: translations are divided by {settings.length_scale:.4g} m."


def _drawn(content: Content) -> Iterator[str]:
    curves = sum(len(line) for plane in content.slices for trace in plane.traces for line in trace.curves)
    points = sum(len(trace.points) for plane in content.slices for trace in plane.traces)
    solid = sum(len(one.vertices) + sum(map(len, one.curves)) for one in content.solids)
    images = sum(len(points) for _, points in content.workspace.images)
    singular = content.analysis.settings.tolerances.singular
    yield (
        f"Drawn: {curves + points:,} points of slices, {solid:,} of sets in three joints and {images:,} members of "
        f"families in the workspace, each with σ ≤ {singular:g} in the Jacobian (seed {content.workspace.seed})."
    )
    if content.exact is not None and content.exact.families:
        ranks = [family.rank_check for family in content.exact.families]
        agree, tested = sum(one.agree for one in ranks), sum(one.tested for one in ranks)
        word = "nothing was left unfinished" if content.exact.complete else "not finished within its time limit"
        yield (
            f"Exact conditions: the rank modulo a prime is as claimed at {agree:,} of {tested:,} random points, and "
            f"{content.exact.explained.agree:,} of {content.exact.explained.tested:,} singular configurations lie on a "
            f"family; {word}."
        )
