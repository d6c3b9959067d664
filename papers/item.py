"""One printed thing beside what is computed, and the verdict, which is computed from the two.

| verdict | meaning |
|---|---|
| agrees | ours equals what is printed: within half a unit of the last printed digit,
or to the tolerance of the identity |
| rounding | off by a few units of the last printed digit |
| erratum | what is printed is not so; a reason is given, and a computation that shows it was made and holds |
| unreproducible | the document does not say enough to compute it; the reason says what is missing |
| differs | none of these: this package and the document contradict each other, and nobody knows why |
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike

FEW = 3.0
"""Units of the last printed digit up to which a difference is called rounding, unless an item says otherwise."""
_EXACT = 1e-9  # printed values without rounding: whole numbers in a matrix, π/2, √2


class Verdict(StrEnum):
    """See the table of this module."""

    AGREES = "agrees"
    ROUNDING = "rounding"
    ERRATUM = "erratum"
    UNREPRODUCIBLE = "unreproducible"
    DIFFERS = "differs"


@dataclass(frozen=True, slots=True)
class Item:
    """One table row, figure, equation, example or claim.

    Attributes:
        document: "AM", "ML", "GR", "KG" or "JL".
        item: where it stands: "Table 3, row 1", "eq. 9", "section 2.3".
        about: what is compared.
        printed: what the document has.
        ours: what this package computes, rounded for reading.
        verdict: see the table of this module.
        reason: why, where the two do not simply agree; or what has to be known to read the item.
        deviation: the largest difference, in units of `tolerance`'s kind; None for words.
        tolerance: up to which the verdict is `agrees`.
    """

    document: str
    item: str
    about: str
    printed: str
    ours: str
    verdict: Verdict
    reason: str = ""
    deviation: float | None = None
    tolerance: float | None = None


@dataclass(frozen=True, slots=True)
class Shown:
    """A computation that shows that what is printed is not so.

    Attributes:
        words: what was computed, with numbers.
        holds: whether it came out as the words say.
    """

    words: str
    holds: bool


def half_unit(printed: str) -> float:
    """Half a unit of the last printed digit; `_EXACT` for a number printed without a point.

        >>> half_unit("-0.27"), half_unit("7.07106")
        (0.005, 5e-06)
    """
    digits = re.fullmatch(r"[+−-]?\d*\.(\d*)", printed.strip())
    return 0.5 * 10.0 ** -len(digits.group(1)) if digits and digits.group(1) else _EXACT


def number_of(printed: str) -> float:
    """The value of a printed decimal number; a minus sign may be typographic."""
    return float(printed.strip().replace("−", "-"))


@dataclass(frozen=True, slots=True)
class Sheet:
    """Where the items of one document are collected.

    Attributes:
        document: its short name.
        items: those made so far, in order.
    """

    document: str
    items: list[Item]

    def numbers(
        self, item: str, about: str, printed: str, ours: ArrayLike, *, few: float = FEW, reason: str = "",
        shown: Shown | None = None, layout: str = "", half: float | None = None,
    ) -> None:  # fmt: skip
        """Numbers beside numbers, in the same order.

        Args:
            item, about: see `Item`.
            printed: the numbers as printed, separated by blanks, commas or semicolons.
            ours: as many.
            few: units of the last digit up to which a difference is rounding.
            reason, shown: see `Item` and `Shown`.
            layout: to be shown in place of `printed`.
            half: half a unit of what was printed, where zeros and ones stand without their digits.
        """
        words = [word for word in re.split(r"[\s,;\[\]()]+", printed) if word]
        theirs = np.array([number_of(word) for word in words])
        mine = np.asarray(ours, dtype=np.float64).ravel()
        halves = np.array([half_unit(word) if half is None else half for word in words])
        off = np.abs(theirs - mine) if theirs.shape == mine.shape else np.array([np.inf])
        halves = halves if theirs.shape == mine.shape else np.array([_EXACT])
        worst = int(np.argmax(off / halves))
        within = bool((off <= halves * (1 + 1e-6) + 1e-12).all())
        nearly = bool((off <= 2 * halves * few).all()) and bool((halves[off > halves] > _EXACT).all())
        digits = max((len(word.partition(".")[2]) for word in words), default=0) + 1
        self._add(item, about, layout or printed, listed(mine, max(4, digits)), within, nearly, reason, shown,
        off[worst], halves[worst])

    def identity(
        self, item: str, about: str, printed: str, error: float, *, ours: str = "", tolerance: float = 1e-9,
        reason: str = "", shown: Shown | None = None,
    ) -> None:  # fmt: skip
        """A printed formula evaluated beside the computed thing at random places; `error` is the largest difference."""
        same = ours or f"the same, within {tolerance:.0e} at random places"
        mine = same if error <= tolerance or ours else f"differs by up to {error:.2g}"
        self._add(item, about, printed, mine, error <= tolerance, False, reason, shown, error, tolerance)

    def claim(
        self, item: str, about: str, printed: str, ours: str, holds: bool, *, reason: str = "",
        shown: Shown | None = None,
    ) -> None:  # fmt: skip
        """A statement in words, and whether what was computed bears it out."""
        self._add(item, about, printed, ours, bool(holds), False, reason, shown, None, None)

    def same(
        self, item: str, about: str, printed: str, ours: str, *, reason: str = "", shown: Shown | None = None
    ) -> None:
        """Words, whole numbers or rows of a table that have to be equal but for blanks."""
        equal = " ".join(printed.split()) == " ".join(ours.split())
        self._add(item, about, printed, ours, equal, False, reason, shown, None, None)

    def cannot(self, item: str, about: str, printed: str, ours: str, reason: str) -> None:
        """What the document does not say enough about."""
        verdict = Verdict.UNREPRODUCIBLE if reason else Verdict.DIFFERS
        self.items.append(Item(self.document, item, about, printed, ours or "not computed", verdict, reason))

    def _add(
        self, item: str, about: str, printed: str, ours: str, agrees: bool, rounding: bool, reason: str,
        shown: Shown | None, deviation: float | None, tolerance: float | None,
    ) -> None:  # fmt: skip
        verdict = Verdict.AGREES if agrees else Verdict.ROUNDING if rounding else Verdict.DIFFERS
        if verdict is Verdict.DIFFERS and reason and shown is not None and shown.holds:
            verdict = Verdict.ERRATUM
        told = reason if shown is None else f"{reason} {shown.words}{'' if shown.holds else ' (this does not hold)'}"
        size = None if deviation is None or not np.isfinite(deviation) else float(deviation)
        self.items.append(
            Item(self.document, item, about, printed, ours, verdict, " ".join(told.split()), size, tolerance)
        )


def listed(values: ArrayLike, digits: int = 4) -> str:
    """Numbers for reading: rounded to so many digits after the point, without a sign on a zero."""
    return ", ".join(rounded(value, digits) for value in np.asarray(values, dtype=np.float64).ravel())


def rounded(value: float, digits: int = 4) -> str:
    """One number, zeros at its end left out.

        >>> rounded(-0.00001), rounded(2.50001), rounded(-3.0)
        ('0', '2.5', '−3')
    """
    text = f"{round(float(value), digits) + 0.0:.{digits}f}".rstrip("0").rstrip(".")
    return text.replace("-", "−") if text not in ("-0", "") else "0"


def count_words(counts: Sequence[tuple[str, int]]) -> str:
    """'12 agrees, 1 rounding', those that are zero left out."""
    return ", ".join(f"{count} {name}" for name, count in counts if count)
