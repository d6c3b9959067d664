"""The determinants of an arm as lines of text, and those that were not computed."""

from __future__ import annotations

from rankdrop.exact.determinants import Determinants, Minor, MinorOf, MinorsLeft, minor_name
from rankdrop.sections import Formula


def lines(determinants: Determinants, most: int | None) -> tuple[str, ...]:
    """The meaning of the minors, each of them as a formula, and what was not done.

    Args:
        determinants: of an arm.
        most: factors of more characters are given by their size; None for none.
    """
    found = [determinants.meaning]
    for minor in determinants.minors:
        if minor.about:
            found.append(minor.about)
        found.append(Formula(f"{_name(determinants, minor)} = {minor.value.text(most)}"))
    found += (f"not done: {left}" for left in determinants.left)
    return tuple(found)


def minors_left_words(left: MinorsLeft) -> str:
    """Minors that were not computed.

    Example:
        >>> minors_left_words(MinorsLeft(number=3))
        '3 more minors'
        >>> minors_left_words(MinorsLeft(MinorOf.COLUMNS, (1, 3)))
        '|J1 J3|'
    """
    if left.of is None:
        return f"{left.number} more minors"
    return minor_name(left.of, left.joints, left.rows)


def _name(determinants: Determinants, minor: Minor) -> str:
    """A minor in formulas; det J is the product of the blocks where it has some."""
    if determinants.product and minor.of is MinorOf.BLOCK and minor.matrix == "J":
        return determinants.product
    return minor.name
