"""Instructions that GR print for an ordered screw set: `executed` runs them, `session` gives what theirs print."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rankdrop.errors import OptionError
from rankdrop.local.ordered import OrderedScrewSet, OrderedSubset, Products
from rankdrop.robot.model import Array
from rankdrop.sections import words_of

Instruction = tuple[str, int, int]

PRINTED_IN_GR: tuple[Instruction, ...] = (
    ("readoss", 1, 7),
    ("msos", 1, 5),
    ("subspace", 1, 5),
    ("newscrews", 4, 5),
    ("dimension", 1, 5),
    ("dimension", 1, 6),
    ("readoss", 4, 5),
    ("newscrews", 3, 5),
    ("dimension", 1, 5),
    ("dimension", 1, 6),
    ("dimension", 2, 7),
)
"""The instructions of GR's section 5, in their order."""

_INSTRUCTIONS = ("readoss", "msos", "subspace", "newscrews", "dimension")


@dataclass(frozen=True, eq=False)
class Executed:
    """One instruction of a session, and what it finds.

    Attributes:
        name, first, last: the instruction and its arguments.
        found: screws (k, 6) of `readoss` (first … last) and of `newscrews` (those after first, to last); the run of
            `msos`; the Lie products of `subspace`; the number of `dimension`.
    """

    name: str
    first: int
    last: int
    found: Array | OrderedSubset | Products | int

    @property
    def text(self) -> tuple[str, tuple[str, ...]]:
        """The instruction as it is typed, and the lines that it prints."""
        text: tuple[str, tuple[str, ...]] = words_of(self).step_text(self)
        return text

    def __json__(self) -> list[object]:
        instruction, lines = self.text
        return [instruction, list(lines)]


def session(
    screws: OrderedScrewSet, instructions: Sequence[Instruction] = PRINTED_IN_GR
) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Run GR's instructions: each as it is typed, with the lines that it prints. `executed` has them as numbers.

    Raises:
        OptionError: an instruction or a run that does not exist.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> steps = session(OrderedScrewSet.of(open_robot("rcrrrr"), [0.0] * 7))
        >>> [lines for instruction, lines in steps if instruction.startswith("newscrews")]
        [('S(5) = [1, 0, -1, 0, 5, 0]',), ('S(4) = [0, 1, 0, 5, 0, 5]', 'S(5) = [1, 0, -1, 0, 0, 0]')]
    """
    return tuple(step.text for step in executed(screws, instructions))


def executed(
    screws: OrderedScrewSet, instructions: Sequence[Instruction] = PRINTED_IN_GR
) -> tuple[Executed, ...]:
    """Run GR's instructions; `newscrews` changes the set until `readoss` restores it.

    Args:
        screws: the set that the first instruction works on.
        instructions: (name, first, last) of each, `PRINTED_IN_GR` those of section 5.

    Raises:
        OptionError: an instruction or a run that does not exist.
    """
    current, steps = screws, list[Executed]()
    for name, first, last in instructions:
        outcome: Array | OrderedSubset | Products | int
        match name:
            case "newscrews":
                current = current.newscrews(first, last)
                outcome = current.screws[first:last]
            case "readoss":
                rows = current.screws.copy()
                rows[first - 1 : last] = screws.readoss(first, last)
                current = OrderedScrewSet(rows, screws.tolerance)
                outcome = current.readoss(first, last)
            case "msos":
                outcome = current.msos(first, last)
            case "subspace":
                outcome = current.subspace(first, last)
            case "dimension":
                outcome = current.dimension(first, last)
            case _:
                raise OptionError("there is no such instruction", got=repr(name), allowed=", ".join(_INSTRUCTIONS))
        steps.append(Executed(name, first, last, outcome))
    return tuple(steps)
