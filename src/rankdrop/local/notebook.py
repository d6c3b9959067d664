"""Results at one configuration as tables for a notebook.

The records call these functions, so these cannot import the records: what is read of one stands in its docstring.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rankdrop.robot.model import Array
from rankdrop.sections import Section, html

_ANSWER = {True: "yes", False: "no", None: "not known"}


def escape_html(found: Any) -> str:
    """An `Escape`: per joint what it does alone, then the pair, the best direction and the self-motion in words."""
    rows = tuple(
        (
            f"{one.number} {one.joint}", "never" if one.order is None else str(one.order), str(one.gain),
            f"{one.rate:.4g}", f"{one.step:+.4g}", f"{one.sigma_after:.4g}", "yes" if one.within_limits else "no",
        )
        for one in found.single
    )  # fmt: skip
    columns = ("joint", "order", "rank gained", "σ grows by [1/rad, 1/m]", "step [rad, m]", "σ then", "within limits")
    direction = ", ".join(f"{x:+.4g}" for x in found.best_direction.delta)
    after = (
        f"best direction Δq = ({direction}) [rad, m]: σ = {found.best_direction.sigma_after:.4g}",
        f"with the tool held still: {_ANSWER[found.avoidable]} ({found.avoidable_reason})",
        f"at an edge of the reach: {_ANSWER[found.boundary]} ({found.boundary_reason})",
    )
    corank = f"corank {found.corank}"
    return html([Section("Ways out", corank, columns=columns, rows=rows, texts=(0, 1, 6), after=after)])


def nearest_html(found: Any) -> str:
    """A `Nearest`: the configuration, how far it is, and how it was checked."""
    rows = tuple(
        (str(number), f"{there:.6g}", f"{way:+.6g}")
        for number, (there, way) in enumerate(zip(found.q, found.delta, strict=True), 1)
    )
    notes = (
        f"largest σ that has to vanish there: {found.sigma:.2g}; {found.agreeing} of {found.starts} starts ended at "
        f"this distance; stationarity {found.stationarity:.2g}",
        "found by search: that nothing is nearer is not proven",
    )
    summary = f"{found.distance:.6g} rad away (slides per length scale), corank {found.corank}"
    columns = ("joint", "q* [rad, m]", "q* − q [rad, m]")
    return html([Section("Nearest singular configuration", summary, columns=columns, rows=rows, texts=(), notes=notes)])


def redundancy_html(found: Any) -> str:
    """A `Redundancy`: range, null space and projector with their checks."""
    n = found.projector.shape[0]
    joints = tuple(f"joint {number}" for number in range(1, n + 1))
    rank = found.rank
    checks = (
        f"largest entry of PP − P {found.idempotent:.1g}, of JP {found.annihilates:.1g}, of P less its closed form "
        f"{found.difference:.1g}",
    )
    return html(
        [
            Section("Redundancy", f"rank {rank.rank}, nullity {rank.nullity}, corank {rank.corank}"),
            Section(
                "Twists that can be made", "rows (v; ω)", columns=("vx", "vy", "vz", "wx", "wy", "wz"),
                rows=_cells(found.range_basis), texts=(),
            ),
            Section("Joint rates that leave the task still", columns=joints, rows=_cells(found.null_basis), texts=()),
            Section("Projector P = I − J⁺J", columns=joints, rows=_cells(found.projector), texts=(), notes=checks),
        ]
    )  # fmt: skip


def _cells(matrix: Array) -> tuple[tuple[str, ...], ...]:
    return tuple(_row(row) for row in matrix)


def _row(values: Iterable[float]) -> tuple[str, ...]:
    return tuple(f"{x + 0.0:.4g}" if abs(x) > 1e-12 else "0" for x in values)
