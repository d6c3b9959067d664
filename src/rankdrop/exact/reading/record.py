"""What lint says of a user's condition: verdict, counter-examples, sentences."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

_ZERO = 1e-12  # σ below it is printed as 0


@dataclass(frozen=True, slots=True)
class Example:
    """A configuration that shows the difference.

    Attributes:
        q: joint variables [rad, m].
        degrees: the same with angles in degrees, slides in m.
        value: of the user's condition there, the largest in size where there are several.
        sigma: the singular value that is zero at a singularity.
    """

    q: tuple[float, ...]
    degrees: tuple[float, ...]
    value: float
    sigma: float


@dataclass(frozen=True, slots=True)
class Difference:
    """A set of configurations about which the condition is wrong.

    Attributes:
        conditions: what the set is, in words.
        example: on it.
    """

    conditions: str
    example: Example


@dataclass(frozen=True, slots=True)
class LintResult:
    """A user's condition against the singular set.

    Attributes:
        text: the condition.
        verdict: "exact", "too small", "too large", or "both", for the arm's own lengths.
        missing: singular sets that the condition leaves out.
        extra: sets of regular configurations that it takes in.
        real: whether it holds at any real configuration.
        any_lengths: whether it is exact for all lengths that are symbols, special ones aside; None where none is.
        complete: whether everything could be decided; else the verdict speaks of the rest, and `remarks` tell what is
            left.
        remarks: what else is to be known.
    """

    text: str
    verdict: str
    missing: tuple[Difference, ...]
    extra: tuple[Difference, ...]
    real: bool
    any_lengths: bool | None
    complete: bool
    remarks: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)

    def sentences(self) -> tuple[str, ...]:
        """The result in words."""
        said = {
            "exact": "is exactly the singular set",
            "too small": "is too small: some singular configurations do not satisfy it",
            "too large": "is too large: some regular configurations satisfy it",
            "both": "is too small and too large",
        }[self.verdict]
        start = "The condition" if self.complete else "As far as could be decided, the condition"
        found = [f"{start} {said}." if self.real else f"{start} has no real zero: it {said}."]
        for one in self.missing:
            at = _at(one.example)
            found.append(
                f"Singular but left out: {one.conditions}; at {at} it is {_number(one.example.value)}, "
                f"σ = {0 if one.example.sigma < _ZERO else _number(one.example.sigma, 2)}."
            )
        for one in self.extra:
            at = _at(one.example)
            found.append(f"Taken in but regular: {one.conditions}; at {at} σ = {_number(one.example.sigma)}.")
        if self.any_lengths is False and self.verdict == "exact":
            found.append("That is so for the lengths of this arm, not for all lengths.")
        return (*found, *self.remarks)


def _at(example: Example) -> str:
    return f"q = ({', '.join(_number(value, 6) for value in example.degrees)}) [°, m]"


def _number(value: float, digits: int = 4) -> str:
    return f"{value + 0.0:.{digits}g}".replace("-", "−")
