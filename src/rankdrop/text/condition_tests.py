"""In words: a user's condition held against the singular set, and the signs that part two configurations."""

from __future__ import annotations

from collections.abc import Iterator

from rankdrop.exact.lint import Example, LintResult
from rankdrop.exact.signs import Between, Flag, Flags
from rankdrop.sections import Formula

_ZERO = 1e-12  # σ below it is printed as 0
_VERDICTS = {
    "exact": "is exactly the singular set",
    "too small": "is too small: some singular configurations do not satisfy it",
    "too large": "is too large: some regular configurations satisfy it",
    "both": "is too small and too large",
}
_SIGNS = {1: "> 0", -1: "< 0", 0: "= 0: on the family"}
_ENDS = ("starts on", "ends on", "lies in")
"""Kinds of crossings that need no place."""


def lint_sentences(result: LintResult) -> tuple[str, ...]:
    """The verdict on a condition, a configuration for each difference, and remarks."""
    return (*_lint(result), *lint_remarks(result))


def _lint(result: LintResult) -> Iterator[str]:
    if result.complete:
        start = "The condition"
    else:
        start = "As far as could be decided, the condition"
    verdict = _VERDICTS[result.verdict]
    if result.real:
        yield f"{start} {verdict}."
    else:
        yield f"{start} has no real zero: it {verdict}."
    for case in result.missing:
        example = case.example
        value = f"{_example_place(example)} it is {_number(example.value)}, σ = {_sigma(example)}."
        yield Formula(f"Singular but left out: {case.conditions}; {value}")
    for case in result.extra:
        example = case.example
        yield f"Taken in but regular: {case.conditions}; {_example_place(example)} σ = {_number(example.sigma)}."
    if result.any_lengths is False and result.verdict == "exact":
        yield "That is so for the lengths of this arm, not for all lengths."


def lint_remarks(result: LintResult) -> tuple[str, ...]:
    """Sets that do not count, special lengths, and sets that could not be decided."""
    not_real = (f"No real configuration was found where {where}; it is not counted." for where in result.not_real)
    special = (f"For lengths with {factor} = 0 “{text}” always holds." for factor, text in result.special)
    undecided = (f"Not decided: {left}." for left in result.undecided)
    return (*not_real, *special, *undecided)


def _example_place(example: Example) -> str:
    return f"at q = ({', '.join(_number(value, 6) for value in example.degrees)}) [°, m]"


def _sigma(example: Example) -> str:
    if example.sigma < _ZERO:
        return "0"
    return _number(example.sigma, 2)


def _number(value: float, digits: int = 4) -> str:
    return f"{value + 0.0:.{digits}g}".replace("-", "−")


def flags_sentences(flags: Flags) -> tuple[str, ...]:
    """One for each flag of a configuration."""
    return tuple(map(_flag_sentence, flags.flags))


def _flag_sentence(flag: Flag) -> str:
    if flag.sign is None:
        return f"{_title(flag)} has no sign of its own: it changes sign over a full turn of a joint."
    return f"{flag.label}: {flag.factor} {_SIGNS[flag.sign]}"


def _title(flag: Flag) -> str:
    if flag.name:
        return f"{flag.name} ({flag.factor})"
    return flag.factor


def between_sentences(between: Between) -> tuple[str, ...]:
    """Two configurations: the families that part them, those that decide nothing, and those on the straight way."""
    return (*_parting(between), *_open(between), *_straight_way(between))


def _parting(between: Between) -> Iterator[str]:
    flags = between.first.flags
    for i in between.parting:
        yield f"Every path between them crosses {_title(flags[i])}: its sign differs."
    if not between.parting:
        yield (
            "No factor has opposite signs at the two. That does not prove that a path without singularity exists: "
            "configurations with equal signs may lie in different aspects."
        )


def _open(between: Between) -> Iterator[str]:
    for i in between.open:
        flag, other = between.first.flags[i], between.second.flags[i]
        if 0 in (flag.sign, other.sign):
            why = "it is zero at one of the two"
        else:
            why = "it has no sign of its own on the torus"
        yield f"{_title(flag)} decides nothing: {why}."


def _straight_way(between: Between) -> Iterator[str]:
    for crossing in between.crossings:
        if crossing.kind in _ENDS:
            where = ""
        else:
            where = f" at {crossing.at:.6g} of its length"
        yield f"The straight way {crossing.kind} {crossing.name or crossing.factor}{where}."
    if not between.crossings:
        yield "The straight way meets no singularity at its sample points, nor between them by a sign."
