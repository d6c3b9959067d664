"""What two methods, or a derivation and a test of it, find differently, in words."""

from __future__ import annotations

from rankdrop.families.contradiction import TREE, Contradiction, ContradictionKind
from rankdrop.families.descent import DIGITS
from rankdrop.robot.quantities import count

_NOT_SINGULAR = (
    "σ{number} does not vanish at {wrong} of {tested} real configurations that satisfy its conditions, with {digits} "
    "digits"
)
_HIGHER = "the conditions of the method {method} for corank {corank} are wrong "
_CONTRADICTIONS = {
    ContradictionKind.SETS: "{method} has {sets} that {other} has not: {where}",
    ContradictionKind.WITNESS: "the witness of {family} does not satisfy the conditions of the method {method}",
    ContradictionKind.REGULAR: "the conditions of the method {method} hold at {wrong} regular configurations",
    ContradictionKind.HIGHER_SETS: f"{_HIGHER}on {{wrong}} of {{tested}} sets of the rank tree",
    ContradictionKind.HIGHER_SINGULAR: f"{_HIGHER}at {{wrong}} of {{tested}} configurations of this corank found "
    "numerically, where they do not hold",
    ContradictionKind.HIGHER_REGULAR: f"{_HIGHER}at {{wrong}} of {{tested}} configurations of a lower corank, where "
    "they hold",
    ContradictionKind.RANK: "{family}: the rank modulo a prime is not {rank} at {wrong} of {tested} random points",
    ContradictionKind.NOT_SINGULAR: f"{{family}}: {_NOT_SINGULAR}",
    ContradictionKind.CASE_NOT_SINGULAR: f"case {{family}}: {_NOT_SINGULAR}",
    ContradictionKind.OFF_FAMILIES: "corank {corank}: {wrong:,} of {tested:,} configurations found numerically lie on "
    "no family, q = ({q}) is one",
    ContradictionKind.GENERIC_RANK: "the rank is {full_rank} almost everywhere exactly, {rank} numerically",
    ContradictionKind.NOT_LISTED: "derived {family} ({called}) is not listed: its corank is {corank}, and the rank "
    "found is {rank}",
    ContradictionKind.NO_POINT: "derived {family} ({called}): no configuration that satisfies its conditions has its "
    "corank, its witness included",
    ContradictionKind.DIMENSION: "derived {family} ({called}): its dimension is at most {dimension} at configurations "
    "that satisfy its conditions",
    ContradictionKind.STORED: "{text}",
}
"""Kind of a contradiction -> its sentence."""


def contradiction_words(one: Contradiction) -> str:
    """One result that another one contradicts.

    Example:
        >>> contradiction_words(Contradiction(ContradictionKind.GENERIC_RANK, full_rank=3, rank=4))
        'the rank is 3 almost everywhere exactly, 4 numerically'
    """
    return _CONTRADICTIONS[one.kind].format(
        family=one.family, called=one.called, method=_method(one.method), other=_method(one.other), corank=one.corank,
        rank=one.rank, full_rank=one.full_rank, number=one.number, wrong=one.wrong, tested=one.tested,
        dimension=one.dimension, text=one.text, digits=DIGITS, sets=count(one.number, "set"),
        where=_configuration_words(one), q=", ".join(_number(round(value, 9)) for value in one.q),
    )  # fmt: skip


def _method(method: str) -> str:
    """A method as the subject of a sentence."""
    if method == TREE:
        return "the rank tree"
    return method


def _configuration_words(one: Contradiction) -> str:
    """A configuration on a set of one method only, and the rank there."""
    if not one.q:
        return f"no real configuration of rank {one.full_rank - 1} or {one.full_rank} was found on them"
    q = ", ".join(map(_number, one.q))
    return f"at q = ({q}), which is on one, the rank is {one.rank} of {one.full_rank}"


def _number(value: float) -> str:
    return f"{value + 0.0:.6g}".replace("-", "−")
