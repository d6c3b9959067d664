"""In words: why the trace of a self-motion ends, and the bases of range and null space for notebooks."""

from __future__ import annotations

from collections.abc import Iterator

from rankdrop.local.redundant import Redundancy
from rankdrop.local.self_motions import End, Ending
from rankdrop.robot.model import Array
from rankdrop.sections import Section

_ENDINGS = {
    Ending.NO_NULL_SPACE: "nothing can move without the task: the null space is empty",
    Ending.BENDS_AWAY: "the start is singular, and along this null motion the task leaves at second order ({bend} per "
    "rad²): it is not part of a self-motion",
    Ending.DEFINITE: "the start is singular, and every null motion leaves the task at second order: no self-motion "
    "exists",
    Ending.NO_TANGENT: "the start is singular, and no null motion was found that belongs to a self-motion; that is no "
    "proof",
    Ending.NO_START: "no curve starts along this null motion: it is not part of a self-motion",
    Ending.STARTS_BEYOND: "joint {number} ({joint}) starts beyond its limit",
    Ending.AT_LIMIT: "joint {number} ({joint}) reaches its limit",
    Ending.LONG_ENOUGH: "length {travelled} rad reached",
    Ending.CLOSED: "closed after {travelled} rad",
    Ending.CROSSING: "the curve runs into a singular configuration, where branches meet",
    Ending.NARROW_BEND: "the curve bends without end near a singular configuration",
    Ending.NOT_CONVERGED: "the corrector does not converge",
}
_TINY = 1e-12  # an entry below it is printed as 0


def end_sentence(end: End) -> str:
    """Why the trace of a self-motion ends, or does not begin.

    Example:
        >>> end_sentence(End(Ending.AT_LIMIT, number=2, joint="shoulder"))
        'joint 2 (shoulder) reaches its limit'
    """
    return _ENDINGS[end.reason].format(
        number=end.number, joint=end.joint, travelled=f"{end.travelled:.3g}", bend=f"{end.bend:.3g}"
    )


def redundancy_sections(redundancy: Redundancy) -> Iterator[Section]:
    """Range, null space and projector, with the checks of the projector."""
    n = redundancy.projector.shape[0]
    joints = tuple(f"joint {number}" for number in range(1, n + 1))
    rank = redundancy.rank
    yield Section("Redundancy", f"rank {rank.rank}, nullity {rank.nullity}, corank {rank.corank}")
    twist = ("vx", "vy", "vz", "wx", "wy", "wz")
    yield Section(
        "Twists that can be made", "rows (v; ω)", columns=twist, rows=_cells(redundancy.range_basis), texts=(),
    )  # fmt: skip
    yield Section("Joint rates that leave the task still", columns=joints, rows=_cells(redundancy.null_basis), texts=())
    checks = (
        f"largest entry of PP − P {redundancy.idempotent:.1g}, of JP {redundancy.annihilates:.1g}, of P less its "
        f"closed form {redundancy.difference:.1g}"
    )
    yield Section(
        "Projector P = I − J⁺J", columns=joints, rows=_cells(redundancy.projector), texts=(), notes=(checks,),
    )  # fmt: skip


def _cells(matrix: Array) -> tuple[tuple[str, ...], ...]:
    return tuple(map(_row, matrix))


def _row(values: Array) -> tuple[str, ...]:
    return tuple(map(_cell, values))


def _cell(value: float) -> str:
    if abs(value) <= _TINY:
        return "0"
    return f"{value + 0.0:.4g}"
