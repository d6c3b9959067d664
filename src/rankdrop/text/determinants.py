"""The determinants of an arm as lines of text: what the minors are, each minor, and those that were not computed."""

from __future__ import annotations

from rankdrop.exact.arm.structure import joint_list
from rankdrop.exact.determinants import Determinants, Minor, MinorOf, MinorsLeft, RowAxes, minor_name
from rankdrop.sections import Formula
from rankdrop.text.structure import point_text

_AXES = {
    RowAxes.EVERY_LINK: "the same number in the axes of every link",
    RowAxes.TASK: "in the axes of the task",
    RowAxes.LINK: "rows in the frame of link {link}",
    RowAxes.SHORT: "rows in axes in which they are short",
}
_MEANINGS = {
    MinorOf.BLOCK: "rows {rows}, joints 1 to {joints}: {axes}",
    MinorOf.SCREWS: "$j = (v; ω) is the screw of joint j: the rank drops where all of these minors vanish; {axes}",
    MinorOf.COLUMNS: "Jj is column j of J, rows {rows}: the rank drops where all of these minors vanish; {axes}",
    MinorOf.ROWS: "each minor is made of as many rows as there are joints, {axes}: the rank drops where all of them "
    "vanish",
}
"""What the minors are, and where the rank drops."""


def lines(determinants: Determinants, most: int | None) -> tuple[str, ...]:
    """The meaning of the minors, each of them as a formula, and what was not done.

    Args:
        determinants: of an arm.
        most: factors of more characters are given by their size; None for none.
    """
    sentences = [determinants.meaning]
    for minor in determinants.minors:
        if minor.about:
            sentences.append(minor.about)
        sentences.append(Formula(f"{_name(determinants, minor)} = {minor.value.text(most)}"))
    sentences += (f"not done: {left}" for left in determinants.left)
    return tuple(sentences)


def meaning_of_minors(determinants: Determinants) -> str:
    """What the minors are, in which axes, and where the rank drops.

    Example:
        >>> meaning_of_minors(Determinants(MinorOf.BLOCK, ("vx", "vy"), 2, RowAxes.TASK, ()))
        'rows vx, vy, joints 1 to 2: in the axes of the task'
    """
    rows, form = ", ".join(determinants.rows), determinants.form
    if form is not None:
        return (
            f"rows {rows}, joints 1 to {determinants.joints}, reference point: {point_text(form)}; the determinant is "
            "the same at the tip"
        )
    axes = _AXES[determinants.axes].format(link=determinants.link)
    return _MEANINGS[determinants.of].format(rows=rows, joints=determinants.joints, axes=axes)


def about_minor(minor: Minor) -> str:
    """Rows and joints of a block: "J11, arm: rows vx, vy, vz of joints 1, 2, 3"; "" of another minor."""
    if not minor.block:
        return ""
    return f"{minor.matrix}, {minor.block}: rows {', '.join(minor.rows)} of joints {joint_list(minor.joints)}"


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
