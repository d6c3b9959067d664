"""A session with GR's instructions: each prints what theirs prints, on any ordered screw set."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rankdrop.errors import OptionError
from rankdrop.local.ordered import OrderedScrewSet, OrderedSubset
from rankdrop.robot.model import Array

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

GREATEST_RUN = 6
"""GR section 2.2: a run has at most six screws."""


@dataclass(frozen=True, slots=True)
class Step:
    """One instruction of a session and the lines it prints."""

    instruction: str
    lines: tuple[str, ...]


def session(screws: OrderedScrewSet, instructions: Sequence[Instruction] = PRINTED_IN_GR) -> tuple[Step, ...]:
    """Run GR's instructions, each printing what theirs print; `newscrews` changes the set until `readoss` restores it.

    Raises:
        OptionError: an instruction or a run that does not exist.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> steps = session(OrderedScrewSet.of(open_robot("rcrrrr"), [0.0] * 7))
        >>> [step.lines for step in steps if step.instruction.startswith("newscrews")]
        [('S(5) = [1, 0, -1, 0, 5, 0]',), ('S(4) = [0, 1, 0, 5, 0, 5]', 'S(5) = [1, 0, -1, 0, 0, 0]')]
    """
    current, steps = screws, []
    for name, first, last in instructions:
        lines: tuple[str, ...]
        if name == "readoss":
            rows = current.screws.copy()
            rows[first - 1 : last] = screws.readoss(first, last)
            current = OrderedScrewSet(rows, screws.tolerance)
            lines = tuple(_row(row) for row in screws.readoss(first, last))
        elif name == "newscrews":
            current = current.newscrews(first, last)
            lines = tuple(f"S({k}) = {_row(current.screws[k - 1])}" for k in range(first + 1, last + 1))
        elif name == "dimension":
            lines = (str(current.dimension(first, last)),)
        elif name == "msos":
            lines = _msos_lines(current.msos(first, last))
        elif name == "subspace":
            found = current.subspace(first, last)
            lines = tuple(f"[{u}, {v}] {'yes' if inside else 'no'}" for u, v, inside in found.entries)
            lines += tuple(f"actuating screw {u} can restore ({first}, {last})" for u in found.actuators)
        else:
            allowed = "readoss, msos, subspace, newscrews, dimension"
            raise OptionError("there is no such instruction", got=repr(name), allowed=allowed)
        steps.append(Step(f"{name}({first}, {last})", lines))
    return tuple(steps)


def _msos_lines(found: OrderedSubset) -> tuple[str, ...]:
    if found.last - found.first > GREATEST_RUN:  # the guard as printed: 6 < j − i
        return ("more than seven screws: take a shorter run",)
    end = "a minimal singular ordered subset" if found.msos else "not a minimal singular ordered subset"
    return (f"dimension = {found.dimension}", f"lost freedoms = {found.loss}", end)


def _row(screw: Array) -> str:
    return f"[{', '.join(f'{x + 0.0:.6g}' for x in np.where(np.abs(screw) < 1e-12, 0.0, screw))}]"
