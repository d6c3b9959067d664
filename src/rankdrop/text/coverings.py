"""Coverings of the joint space in words: what they prove, their boxes, and places to look at."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees
from typing import Any

import numpy as np

from rankdrop.cover.covering import CoveringEnd
from rankdrop.robot.quantities import count
from rankdrop.sections import Section
from rankdrop.text.words import numbers

_PLACES = 20  # that are printed

_COVERING_ENDS = {
    CoveringEnd.INTERRUPTED: "interrupted",
    CoveringEnd.BUDGET_SPENT: "the budget is spent",
    CoveringEnd.BUDGET_TOO_SMALL: "budget too small",
}


def cover_sentence(covered: Any) -> str:
    """What may be said of a covering, in one sentence."""
    tree, plan, account = covered.covering.tree, covered.covering.plan, covered.account
    what = f"{_covered_what(plan.corank)} of {covered.robot.name}{' inside the joint limits' * plan.limits}"
    if not covered.complete:
        share = 100 * float(tree.finished.mean())
        why = _why_not_complete(covered.covering.stopped, covered.covering.needed)
        return f"Not complete{why}: {share:.1f} % of the joint space was covered; the rest was not searched."
    if not tree.leaves:
        return f"There is no {what} (proven)."
    if account is None:
        return f"Every {what} lies in one of {count(tree.leaves, 'box', 'boxes')} (proven)."
    if not account.spots:
        return f"Every {what} is within {account.diagonal:.3g} rad of a known family (proven)."
    boxes, proven = (sum(getattr(spot, name) for spot in account.spots) for name in ("boxes", "proven"))
    return (
        f"{count(len(account.spots), 'place')} may hold a {what} on no known family: {count(boxes, 'box', 'boxes')}, "
        f"{proven:,} of them proven to hold one."
    )


def covering_label(needed: int) -> str:
    """What the progress of a covering counts, with all its enclosures where they were estimated."""
    if needed:
        return f"parts covered (about {needed:,} enclosures in all)"
    return "parts covered"


def covering_end_words(stopped: CoveringEnd | None) -> str:
    """Why a covering ended early: "the budget is spent"; "" where it is complete."""
    if stopped is None:
        return ""
    return _COVERING_ENDS[stopped]


def _why_not_complete(stopped: CoveringEnd | None, needed: int) -> str:
    """In brackets: why a covering ended early, and the work that all of it takes."""
    if stopped is None:
        return ""
    why = covering_end_words(stopped)
    if not needed or stopped is CoveringEnd.INTERRUPTED:
        return f" ({why})"
    return f" ({why}: about {needed:,} enclosures are needed at this width)"


def _covered_what(corank: int) -> str:
    if corank == 1:
        return "singular configuration"
    return f"configuration of corank {corank} or more"


def cover_sections(covered: Any, *, deg: bool = True) -> tuple[Section, ...]:
    """A covering: what may be said, boxes, families that explain them, places to look at; again what may be said."""
    covering, plan, tree = covered.covering, covered.covering.plan, covered.covering.tree
    units = covered.robot.units
    if covered.complete:
        whose = ""
    else:
        whose = " of the part done"
    if tree.leaves:
        inside = f"; every {_covered_what(plan.corank)}{whose} is in one"
    else:
        inside = whose
    rows = [
        ("joints that decide", ", ".join(f"{'θ' if units[j - 1] == 'rad' else 'q'}{j}" for j in plan.variables)),
        ("method", plan.method),
        ("boxes no wider than", f"{covered.width:.4g} rad"),
        ("proven free", f"{100 * covering.free_share:.2f} % of the joint space{' within the limits' * plan.limits}"),
        ("boxes left", f"{tree.leaves:,}{inside}"),
        ("boxes tested", f"{covering.tested:,}"),
    ]  # fmt: skip
    if tree.leaves:
        share = 100 * tree.proven_leaves / tree.leaves
        rows.insert(5, ("proven to hold one", f"{tree.proven_leaves:,} ({share:.1f} %)"))
    first, after = Section("", lines=(cover_sentence(covered),)), (f"sha256 {covered.sha256}",) * covered.complete
    account = () if covered.account is None else _account_sections(covered.account, plan.variables, deg=deg)
    boxes = Section(f"{covered.robot.name}: covering", columns=("what", "found"), rows=tuple(rows), texts=(0, 1),
                    after=after)  # fmt: skip
    return first, boxes, *account, first


def _account_sections(account: Any, joints: tuple[int, ...], *, deg: bool) -> Iterator[Section]:
    """Which families explain the boxes, and the places that none does."""
    pairs = zip(account.families, account.explained, strict=True)
    rows = [(family.id, family.name, f"{number:,}") for family, number in pairs if number]
    if account.freed:
        rows += [("", "no family, but proven free on a closer look", f"{account.freed:,}")]
    notes = ("A box counts for the first family that has a point within half a diagonal of its centre.",
             "A box that was halved on counts for a family from which nothing that is left of it is farther than a "
             "diagonal.")  # fmt: skip
    yield Section("Explained", f"by families from: {account.source}", columns=("family", "", "boxes"), rows=tuple(rows),
                  texts=(0, 1), notes=notes)  # fmt: skip
    if account.spots:
        if deg:
            factor, unit = (degrees(1.0), "°")
        else:
            factor, unit = (1.0, "rad")
        places = tuple(
            (f"{spot.boxes:,}", f"{spot.proven:,}", spot.kind, f"{spot.sigma:.2g}",
             ", ".join(f"{value * factor:.4g}" for value in spot.q[np.array(joints) - 1]))
            for spot in account.spots[:_PLACES]
        )  # fmt: skip
        more = len(account.spots) - _PLACES
        yield Section(
            "Places to look at", "no known family explains these boxes",
            columns=("boxes", "proven", "", "σ", f"joints {numbers(joints)} [{unit}]"), rows=places, texts=(2, 4),
            after=(f"and {more:,} more places",) if more > 0 else (),
        )  # fmt: skip
