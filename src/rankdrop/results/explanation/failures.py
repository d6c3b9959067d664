"""The failure of single joints in words and as data."""

from __future__ import annotations

from collections.abc import Iterator

from rankdrop.local.failures import Failures
from rankdrop.results.codec import Record
from rankdrop.results.explanation.data import ExplanationData
from rankdrop.results.explanation.words import numbers, short
from rankdrop.sections import Section


def failures_part(found: ExplanationData, full: bool) -> Iterator[Section]:
    """What each joint's failure leaves; of arms without a joint to spare only on demand: each costs a freedom."""
    if full or found.robot.n > found.rank.generic_rank:
        yield failures_table(found.failures, "If one joint fails")


def failures_table(found: Failures, title: str) -> Section:
    """One row per joint that stands still."""
    r, n = found.generic_rank, len(found.single)
    rows = tuple(
        (f"{one.number} {one.joint}", short(one.sigma_min), short(round(one.share, 6), 3), f"{one.rank} of {r}",
         "; ".join(one.lost_words) or "nothing")
        for one in found.single
    )  # fmt: skip
    least = found.worst
    after = [f"worst case: σ{r} = {short(least.sigma_min)} without joint {numbers(found.worst_numbers)}"]
    if found.bound is not None and n > r:
        after[0] += f"; no worst case is above √({n - r}/{n}) σ1 = {short(found.bound)} here"
    return Section(title, "it stands still: its column is gone from the Jacobian", (),
                   ("joint", f"σ{r} left", "ρ", "rank", "lost then"), rows, (0, 4), tuple(after),
                   ("ρ: what is left of √det(JJᵀ)",))  # fmt: skip


def failures_to_dict(found: Failures) -> Record:
    """Plain data of every failure at one configuration."""
    return {
        "failure_bound": found.bound,
        "failures": [
            {
                "number": one.number,
                "joint": one.joint,
                "sigma": one.sigma.tolist(),
                "sigma_min": one.sigma_min,
                "rank": one.rank,
                "share": one.share,
                "lost_directions": one.lost.tolist(),
                "lost_words": list(one.lost_words),
            }
            for one in found.single
        ],
    }
