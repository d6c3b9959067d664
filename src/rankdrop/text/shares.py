"""Shares of the joint space: near each family, near any, and where the tool is slow; with their 95 % intervals."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees

from rankdrop.distance.share import JointSpaceShares, NearShare, SlowShare
from rankdrop.families.record import Family
from rankdrop.sections import Section
from rankdrop.text.families import MANY

_LARGEST = 8  # so many of the shares near families
AT_LEAST = "≥"


def near_overview(near: JointSpaceShares, families: Sequence[Family]) -> Section:
    """Shares of the joint space near the families."""
    names = {family.id: family.name for family in families}
    where = "the joint space inside the limits" if near.limits else "the joint space"
    many = len(near.families) > MANY
    shown = sorted(near.families, key=lambda share: -share.near)[:_LARGEST] if many else near.families
    rows = [*((share.id, names.get(share.id, ""), share) for share in shown), ("any", "", near.any)]
    if near.slow is not None:
        rows.append(("slow", "tool slower than 25 mm/s or 5°/s, inside the limits", near.slow))
    notes = [f"{near.samples:,} random configurations, seed {near.seed}; ± standard error; 95 % by Wilson's rule"]
    if len(shown) < len(near.families):
        notes.append(f"the {_LARGEST} largest of {len(near.families)}; all of them in the JSON")
    if near.any.bound:
        notes.append(f"{AT_LEAST}: coupled joints (their nearest point may be missed), or a row without conditions")
    return Section(
        f"Within {degrees(near.within):.4g}° of singularities", f"share of {where}, distance over all joints",
        columns=("", "family", "share", "±", "95 %"),
        rows=tuple(
            (id, name, share_cell(share), f"{100 * share.error:.2g} %", _interval_words(share))
            for id, name, share in rows
        ),
        texts=(0, 1), notes=tuple(notes),
    )  # fmt: skip


def slow_line(slow: SlowShare) -> str:
    """The share of the joint space in which the tool is slow, its interval and its samples."""
    share = slow.share
    return (
        f"At {share_cell(share)} of the configurations inside the joint limits the tool is slower than "
        f"{1000 * slow.tool_speed:.4g} mm/s in its worst direction (95 %: {_close_between(share)}): "
        f"{share.samples:,} random configurations, uniform in each joint, seed {slow.seed}."
    )


def slow_configurations(slow: NearShare | None, speed: float, turn_speed: float) -> str:
    """The share of slow configurations on a page, at speeds in m/s and rad/s; without it, what the file lacks."""
    if slow is None:
        return "unknown: too few joints have a rate limit (state `velocity` of the joints in the arm's file)"
    return (
        f"below {1000 * speed:.4g} mm/s or {degrees(turn_speed):.3g}°/s in some direction: {share_cell(slow)} of "
        f"configurations inside limits (95 %: {_close_between(slow)}; {slow.samples:,} random ones, uniform in each "
        "joint)"
    )


def _close_between(share: NearShare) -> str:
    """The 95 % interval to three digits."""
    low, high = (100 * end for end in share.interval)
    return f"{low:.3g} … {high:.3g} %"


def near_total(near: JointSpaceShares) -> str:
    """The share near any family, and the share where the tool is slow."""
    total = f"any: {share_cell(near.any)} ± {100 * near.any.error:.2g} %"
    if near.slow is None:
        return total
    return f"{total}; tool slower than 25 mm/s or 5°/s: {share_cell(near.slow)}"


def share_cell(share: NearShare) -> str:
    """A share of the joint space in a table: "7.75 %", "≥ 5.7 %"."""
    return f"{AT_LEAST if share.bound else ''} {100 * share.share:.3g} %".strip()


def _interval_words(share: NearShare) -> str:
    low, high = (100 * end for end in share.interval)
    return f"{low:.2g} … {high:.2g} %"
