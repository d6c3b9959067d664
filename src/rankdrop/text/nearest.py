"""The nearest singular configuration, in words for notebooks."""

from __future__ import annotations

from rankdrop.local.nearest import Nearest
from rankdrop.sections import Section


def nearest_sections(nearest: Nearest) -> tuple[Section]:
    """The configuration, its distance, and how it was checked."""
    rows = tuple(
        (str(number), f"{there:.6g}", f"{way:+.6g}")
        for number, (there, way) in enumerate(zip(nearest.q, nearest.delta, strict=True), 1)
    )
    notes = (
        f"largest σ that has to vanish there: {nearest.sigma:.2g}; {nearest.agreeing} of {nearest.starts} starts ended "
        f"at this distance; stationarity {nearest.stationarity:.2g}",
        "found by search: that nothing is nearer is not proven",
    )
    summary = f"{nearest.distance:.6g} rad away (slides per length scale), corank {nearest.corank}"
    columns = ("joint", "q* [rad, m]", "q* − q [rad, m]")
    return (Section("Nearest singular configuration", summary, columns=columns, rows=rows, texts=(), notes=notes),)
