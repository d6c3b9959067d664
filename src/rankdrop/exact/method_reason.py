"""Why corank 1 was derived by its method: how the Jacobian parts into two square blocks, or why it does not."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class PartingKind(StrEnum):
    """What parts a Jacobian into two square blocks (`POINT` to `LAST_AXIS`), or why nothing does."""

    POINT = "point"
    SLIDES = "slides"
    PLANE = "plane"
    PLANE_AND_SLIDE = "plane and slide"
    LAST_AXIS = "last axis"
    COUPLED = "joints follow others"
    NOT_SQUARE = "not square"
    ARM_NOT_SQUARE = "block of the arm not square"
    TOO_FEW_JOINTS = "too few joints"
    ALWAYS_SINGULAR = "always singular"
    ONE_PIECE = "one piece"


PARTS = frozenset(
    (PartingKind.POINT, PartingKind.SLIDES, PartingKind.PLANE, PartingKind.PLANE_AND_SLIDE, PartingKind.LAST_AXIS)
)
"""What parts a Jacobian: the kinds of motions of the first block's joints."""


@dataclass(frozen=True)
class Parting:
    """How a Jacobian parts into two square blocks, or why it does not.

    Attributes:
        kind: what parts it, or why nothing does.
        joints: of the first block, from 1; () where it does not part.
        part: of the arm that moves about a point: "wrist", "shoulder", or "".
        turns: whether no joint of the first block slides.
        columns, rows: of the Jacobian.
    """

    kind: PartingKind
    joints: tuple[int, ...] = ()
    part: str = ""
    turns: bool = True
    columns: int = 0
    rows: int = 0

    @property
    def parts_exactly(self) -> bool:
        """Whether the Jacobian parts."""
        return self.kind in PARTS


@dataclass(frozen=True)
class MethodReason:
    """Why corank 1 was derived by one method, and what was not tried.

    Attributes:
        parting: how the Jacobian parts, or why it does not; None where the method was asked for.
        terms: of the rank tree's longest condition, where that decided against methods by cases; else 0.
        not_run: these methods, which may end all the same.
        unfactored: minors that were not factored in time; where they vanish is known all the same.
        unfinished: the method that was tried and did not finish; "" where there was none.
        interrupted: whether the user stopped before a method was tried.
    """

    parting: Parting | None = None
    terms: int = 0
    not_run: tuple[str, ...] = ()
    unfactored: int = 0
    unfinished: str = ""
    interrupted: bool = False
