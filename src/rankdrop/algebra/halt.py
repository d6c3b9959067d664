"""What ended a derivation, or a step of it, before its end: a limit, a polynomial that grows too long, or an error."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class HaltKind(StrEnum):
    """What ended a derivation: a limit, the step for which no time was left, or a failure."""

    WORK = "limit on work"
    PROCESSOR = "processor's time"
    INTERRUPTED = "interrupted"
    ERROR = "error"
    COEFFICIENTS = "long coefficients"
    NORM = "no squarefree norm"
    SUBSTITUTION = "long substitution"
    SINES = "long for sines"
    PRODUCT = "long product"
    FACTORING = "long for factoring"
    MINORS = "minors"
    FACTORS = "factors"
    ELIMINATION = "elimination"
    CASES = "cases"
    EXCEPTIONAL_CASES = "exceptional cases"


@dataclass(frozen=True)
class Halt:
    """What ended a derivation before its end.

    Attributes:
        kind: a limit, a step or a failure.
        terms: of the polynomial that is too long, or that was to be factored.
        others: terms of the polynomial that it is multiplied with, or of the solution that is put into it.
        number: of cases that were not finished, of the kinds CASES and EXCEPTIONAL_CASES.
        error, message: class and text of an error of Python, of the kind ERROR.
        waiting: the cases of a method that were not finished when it ended so; None where it has no cases.
    """

    kind: HaltKind
    terms: int = 0
    others: int = 0
    number: int = 0
    error: str = ""
    message: str = ""
    waiting: Halt | None = None


WORK = Halt(HaltKind.WORK)
"""The limit on work was reached."""
INTERRUPTED = Halt(HaltKind.INTERRUPTED)
"""The user has asked to stop."""


class OutOfTime(Exception):
    """A limit has passed; whoever catches it notes the unfinished work.

    Args:
        halt: which limit, or the step for which there was no time.
    """

    def __init__(self, halt: Halt = WORK) -> None:
        super().__init__(halt.kind.value)
        self.halt = halt


class TooLong(OutOfTime):
    """A polynomial would grow too long on the way that was tried; another way may do."""
