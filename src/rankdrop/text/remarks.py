"""Remarks on an exact derivation in words: what was rounded, what the arm is near to, how lengths became numbers."""

from __future__ import annotations

from math import degrees

from rankdrop.exact.arm.geometry import Deviation
from rankdrop.exact.arm.structure import joint_list
from rankdrop.exact.family import EqualLengths
from rankdrop.exact.remark import DerivationRemark, RemarkOn
from rankdrop.families.descent import DIGITS
from rankdrop.robot.quantities import count

_WITH_NUMBERS = "derived with numbers"
_REMARKS = {
    RemarkOn.UNUSED_LETTER: "the letter {letter} of the robot stands for no length that conditions depend on: none is "
    "{length:.12g} m",
    RemarkOn.FOLLOWER: "joint {part} follows joint {leader}: column {column} of the Jacobian contains {factor} times "
    "the screw of {part}",
    RemarkOn.NUMBERS_OF_VARIABLES: "joint numbers count the variables; decoupling and suppression, which need one "
    "screw for each column, are left out",
    RemarkOn.DEPENDENT: f"conditions that are independent for general lengths are not for these: {_WITH_NUMBERS}",
    RemarkOn.RULED_OUT: f"{{polynomial}} = 0 for these lengths, which letters rule out: {_WITH_NUMBERS}",
    RemarkOn.SEVERAL_FACTORS: f"a condition has several factors for these lengths: {_WITH_NUMBERS}",
    RemarkOn.ONE_LETTER: "{pairs} for this arm: derived with one letter for both",
    RemarkOn.LONGER_WITH_LETTERS: "lengths are numbers: with letters the derivation takes longer than it may",
    RemarkOn.UNDIVIDED_WITH_LETTERS: "lengths are numbers: with letters {systems} could not be taken apart",
    RemarkOn.MISSED_BY_LETTERS: "lengths are numbers: conditions for general lengths miss singular configurations of "
    "these",
    RemarkOn.NEAR_MISSES: "corank {corank}: {configurations} with a small σ on no family left out: {which}followed "
    "with {digits} digits, the rank does not drop there{least}",
    RemarkOn.STORED: "{text}",
}
"""Remarks; those on a number of the arm are made of the deviation."""


def remark_words(remark: DerivationRemark) -> str:
    """One remark on an exact derivation.

    Example:
        >>> remark_words(DerivationRemark(RemarkOn.UNDIVIDED_WITH_LETTERS, number=2))
        'lengths are numbers: with letters 2 systems of conditions could not be taken apart'
    """
    if remark.deviation is not None:
        return deviation_words(remark.deviation, remark.part or "the tip")
    number = remark.number
    return _REMARKS[remark.kind].format(
        part=remark.part, leader=remark.leader, column=remark.column, factor=f"{remark.factor:.6g}".replace("-", "−"),
        letter=remark.letter, length=remark.length, polynomial=remark.polynomial, corank=remark.corank,
        pairs=", ".join(map(_equal, remark.equal)), text=remark.text, digits=DIGITS, which=_followed_words(remark),
        least=_least(remark), systems=count(number, "system of conditions", "systems of conditions"),
        configurations=count(number, "configuration"),
    )  # fmt: skip


def _equal(equal: EqualLengths) -> str:
    """ "d4 = −a2"."""
    sign = ""
    if equal.sign < 0:
        sign = "−"
    return f"{equal.length} = {sign}{equal.other}"


def _followed_words(remark: DerivationRemark) -> str:
    """Which of the configurations were followed with many digits; "" where all were."""
    if remark.followed == remark.number:
        return ""
    return f"{remark.followed} of them, spread over all their σ, "


def _least(remark: DerivationRemark) -> str:
    if remark.sigma is None:
        return ""
    return f" (smallest σ {remark.sigma:.2g})"


def deviation_words(deviation: Deviation, part: str) -> str:
    """A number of the arm that is not quite another one: which, what it is, and by how much.

    Args:
        deviation: of the number.
        part: name of the joint that has it.
    """
    joints, miss = deviation.joints, abs(deviation.miss)
    if deviation.kind == "point":
        return f"the axes of joints {joint_list(joints)} miss a common point by {_length(miss, deviation.counted)}"
    if deviation.kind == "parallel":
        return f"axes {joints[0]} and {joints[1]} are {degrees(miss):.2g}° from parallel"
    if deviation.kind == "twist":
        return f"twist after {part}: {degrees(deviation.given):.12g}° is rounded by {miss:.1e} rad"
    if deviation.kind == "angle":
        return f"angle of {part}: {degrees(deviation.given):.12g}° is rounded by {miss:.1e} rad"
    return f"length {deviation.kind} of {part}: {deviation.given:.12g} m is rounded by {miss:.1e} m"


def _length(length: float, counted: float) -> str:
    """In thousandths of the unit that was given; of an arm given in metres, in mm."""
    if counted == 1.0:
        return f"{length * 1000:.4g} mm"
    return f"{length:.4g} m"
