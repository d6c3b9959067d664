"""Result of checking a certificate."""

from __future__ import annotations

from rankdrop.cover.certificates import Verified
from rankdrop.sections import Section


def verified_sections(verified: Verified) -> tuple[Section, ...]:
    """What was checked, whether it holds, and the work that this took."""
    of = "certificate"
    if verified.kind:
        of = f"{verified.kind} of {verified.arm!r}"
    counted: tuple[str, ...] = ()
    if verified.enclosures:
        counted = (f"{verified.enclosures:,} enclosures of interval arithmetic",)
    if not verified.holds:
        lines = (f"{verified.reason}.", *verified.statement)
        return (Section("Not confirmed", of, lines, notes=counted, tone="bad"),)
    how = filter(None, (verified.how,))
    lines = (f"{verified.claim}.", *verified.statement)
    return (Section("Holds", of, lines, notes=(*how, *counted, *verified.assumed), tone="good"),)
