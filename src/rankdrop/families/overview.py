"""Tables of families, and of the outcome of a search, as sections of text: what a notebook shows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import degrees

from rankdrop.families.cells import (
    COUPLED,
    coupled_conditions,
    joint_cell,
    joint_symbol,
    rounded_share,
    share_text,
)
from rankdrop.families.share import Near, NearShare
from rankdrop.family.record import CorankSummary, Family
from rankdrop.robot.model import Robot
from rankdrop.sections import Section

AT_LEAST = "≥"
_MANY, _LARGEST = 24, 8  # of more rows, those of calibrated arms, so many are told


def overview(
    robot: Robot, generic_rank: int, coranks: Sequence[CorankSummary], families: Sequence[Family]
) -> Iterator[Section]:
    """One section per corank: its rows as a table, conditions of coupled joints and lost motions under it."""
    about = f": {robot.about}" if robot.about else ""
    yield Section(f"{robot.name}{about}", f"rank {generic_rank} almost everywhere")
    kinds = [str(joint.kind) for joint in robot.variables]
    symbols = [joint_symbol(number, kind) for number, kind in enumerate(kinds, start=1)]
    for summary in coranks:
        rows = [family for family in families if family.corank == summary.corank]
        title = f"Corank {summary.corank} (rank {summary.rank} of {generic_rank})"
        if not rows:
            yield Section(title, f"none found of {summary.starts:,} starts; absence of a find is not a proof")
            continue
        share = summary.completeness
        yield Section(
            title,
            f"completeness {share_text(share.explained, share.tested)} ({share.explained:,} of {share.tested:,})",
            columns=("", "family", *symbols, "dim", "sound", "share"),
            rows=tuple(_row(family, kinds) for family in rows),
            texts=(0, 1),
            after=tuple(line for family in rows for line in _under(family)),
        )


def _row(family: Family, kinds: Sequence[str]) -> tuple[str, ...]:
    joints = (" ".join(joint_cell(family, number, kind).split()) for number, kind in enumerate(kinds, start=1))
    sound = share_text(family.soundness.singular, family.soundness.tested)
    return family.id, family.name, *joints, str(family.dimension), sound, rounded_share(family.explained)


def _under(family: Family) -> Iterator[str]:
    if family.coupled or not family.named:
        yield from (f"{family.id} {COUPLED}: {text}" for text in coupled_conditions(family))
    yield from (f"{family.id} lost: {text}" for text in family.lost_words)


def near_overview(near: Near, families: Sequence[Family]) -> Section:
    """Shares of the joint space near the families."""
    names = {family.id: family.name for family in families}
    where = "the joint space inside the limits" if near.limits else "the joint space"
    told = sorted(near.families, key=lambda one: -one.near)[:_LARGEST] if len(near.families) > _MANY else near.families
    rows = [*((one.id, names.get(one.id, ""), one) for one in told), ("any", "", near.any)]
    notes = [f"{near.samples:,} random configurations, seed {near.seed}; ± standard error; 95 % by Wilson's rule"]
    if len(told) < len(near.families):
        notes.append(f"the {_LARGEST} largest of {len(near.families)}; all of them in the JSON")
    if near.any.bound:
        notes.append(f"{AT_LEAST}: coupled joints, whose nearest point may be missed, or a row without conditions")
    return Section(
        f"Within {degrees(near.within):.4g}° of singularities", f"share of {where}, distance over all joints",
        columns=("", "family", "share", "±", "95 %"),
        rows=tuple((id, name, _percent(one), f"{100 * one.error:.2g} %", _between(one)) for id, name, one in rows),
        texts=(0, 1), notes=tuple(notes),
    )  # fmt: skip


def _percent(one: NearShare) -> str:
    return f"{AT_LEAST if one.bound else ''} {100 * one.share:.3g} %".strip()


def _between(one: NearShare) -> str:
    low, high = (100 * end for end in one.interval)
    return f"{low:.2g} … {high:.2g} %"


def search_overview(
    robot: Robot, corank: int, counts: Sequence[tuple[str, int]], smallest: float | None, method: str, seed: int
) -> Section:
    """What became of the starts of one search.

    Args:
        robot: the arm.
        corank: what was searched for.
        counts: (outcome, how many starts).
        smallest: smallest σ of a nonzero local minimum; None where there was none.
        method, seed: how.
    """
    near = "" if smallest is None else f"smallest near miss σ = {smallest:.4g}, not singular"
    return Section(
        f"{robot.name}: search for corank {corank}",
        f"method {method}, seed {seed}",
        columns=("outcome", "starts"),
        rows=tuple((name, f"{count:,}") for name, count in counts if count),
        after=(near,) if near else (),
    )
