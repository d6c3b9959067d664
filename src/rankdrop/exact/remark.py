"""Remarks on an exact derivation as facts: numbers of the arm, joints, lengths, configurations that were found.

`rankdrop.text.remarks` has the words.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.geometry import Deviation
from rankdrop.exact.arm.structure import structure_of
from rankdrop.exact.family import EqualLengths
from rankdrop.robot.model import Robot
from rankdrop.sections import words_of


class RemarkOn(StrEnum):
    """What a remark is about: numbers of the arm, its joints, letters for lengths, or configurations found."""

    ROUNDED = "rounded number"
    NEAR = "near structure"
    UNUSED_LETTER = "unused letter"
    FOLLOWER = "joint follows another"
    NUMBERS_OF_VARIABLES = "numbers of variables"
    DEPENDENT = "dependent for these lengths"
    RULED_OUT = "lengths ruled out"
    SEVERAL_FACTORS = "several factors"
    ONE_LETTER = "one letter for two lengths"
    LONGER_WITH_LETTERS = "longer with letters"
    UNDIVIDED_WITH_LETTERS = "undivided with letters"
    MISSED_BY_LETTERS = "missed by letters"
    NEAR_MISSES = "near misses"
    STORED = "old sentence"


@dataclass(frozen=True)
class DerivationRemark:
    """One remark on an exact derivation.

    Attributes:
        kind: what it is about.
        deviation: of a number of the arm from an exact one.
        part: name of the joint that the number belongs to; "" for the tip; name of the joint that follows.
        leader: name of the joint that it follows.
        column: of the Jacobian to which the joint that follows adds, from 1.
        factor: of the screw of the joint that follows.
        letter: that stands for no length.
        length: value of that letter [m].
        polynomial: in lengths, that is zero for this arm.
        equal: lengths that have one letter.
        corank: of the configurations.
        number: of systems of conditions, or of configurations.
        followed: configurations that were followed with many digits.
        sigma: smallest singular value next to them; None where it has no minimum.
        text: of the kind STORED, the sentence.
    """

    kind: RemarkOn
    deviation: Deviation | None = None
    part: str = ""
    leader: str = ""
    column: int = 0
    factor: float = 1.0
    letter: str = ""
    length: float = 0.0
    polynomial: str = ""
    equal: tuple[EqualLengths, ...] = ()
    corank: int = 0
    number: int = 0
    followed: int = 0
    sigma: float | None = None
    text: str = ""

    def __str__(self) -> str:
        """In words: "d4 = −a2 for this arm: derived with one letter for both"."""
        words: str = words_of(self).remark_words(self)
        return words


def chain_remarks(chain: Chain) -> tuple[DerivationRemark, ...]:
    """What was rounded to make the arm exact, and letters of the robot that stand for no length."""
    rounded = (rounded_number(chain.robot, deviation) for deviation in chain.effective_roundings)
    unused = (
        DerivationRemark(RemarkOn.UNUSED_LETTER, letter=letter, length=float(length))
        for letter, length in chain.unused
    )
    return (*rounded, *unused)


def rounded_number(robot: Robot, deviation: Deviation) -> DerivationRemark:
    """A number of the arm that was rounded, with the name of its joint; "" for the tip."""
    number = deviation.joints[0]
    if number > len(robot.joints):
        name = ""
    else:
        name = robot.joints[number - 1].name
    return DerivationRemark(RemarkOn.ROUNDED, deviation=deviation, part=name)


def near_structure(chain: Chain) -> tuple[DerivationRemark, ...]:
    """Special structures that the arm is near to."""
    return tuple(DerivationRemark(RemarkOn.NEAR, deviation=near) for near in structure_of(chain).near)


def followers(robot: Robot) -> tuple[DerivationRemark, ...]:
    """A remark for each joint that follows another one; the last one is on the methods that this rules out."""
    remarks = []
    for joint, place in zip(robot.joints, robot.drivers, strict=True):
        if joint.mimic is not None:
            remarks.append(
                DerivationRemark(
                    RemarkOn.FOLLOWER, part=joint.name, leader=joint.mimic.leader, column=place + 1,
                    factor=float(joint.multiplier),
                )
            )  # fmt: skip
    if remarks:
        remarks.append(DerivationRemark(RemarkOn.NUMBERS_OF_VARIABLES))
    return tuple(remarks)
