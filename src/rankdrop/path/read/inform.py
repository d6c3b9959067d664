"""Yaskawa INFORM jobs (.jbi): instructions under //INST, positions under //POS.

Positions of ///POSTYPE PULSE are encoder counts, whose number per degree is not in the file: they are not read.
Positions of BASE and ROBOT are x, y, z in mm and Rx, Ry, Rz in degrees about the fixed axes X, Y, Z in this order:
R = Rz Ry Rx. The base frame is at the height of axis 2 (L). V is taken in mm/s. RCONF is not evaluated.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import radians
from typing import Literal

import numpy as np

from rankdrop.path.read.program_record import Language, Listing, Program, Reason, Speed, Target
from rankdrop.path.read.program_scan import lines_of, number, positive
from rankdrop.path.read.program_targets import MILLIMETRE, angle_target, in_base

_MOVES: dict[str, Literal["joint", "line"]] = {"MOVJ": "joint", "MOVL": "line"}
_OTHER_MOVES = {"MOVC": Reason.CIRCLE, "MOVS": Reason.SPLINE, "IMOV": Reason.RELATIVE, "REFP": Reason.OTHER_MOVE,
                **dict.fromkeys(("SMOVL", "SMOVC", "SMOVJ", "MFRAME", "SREFP"), Reason.OTHER_MOVE)}  # fmt: skip
_COMMENT = "'"
_SHIFTS = {"SFTON": True, "SFTOF": False}
_FLOW = {**dict.fromkeys(("JUMP", "IFTHEN", "IFTHENEXP", "ELSE", "ELSEIF", "ENDIF", "RET", "SWITCH", "CASE"),
                         Reason.BRANCH),
         **dict.fromkeys(("FOR", "NEXT", "WHILE", "ENDWHILE"), Reason.LOOP)}  # fmt: skip
_POSITION = re.compile(r"\s*([BE]?C\d{1,6})\s*=\s*(.*)")
_EXTERNAL = ("BC", "EC")
"""Positions of a base axis and of a station axis."""
_FRAMED = ("BASE", "ROBOT", "USER")


@dataclass
class _Positions:
    """Positions of a job, by name; a heading holds for the lines after it.

    Attributes:
        targets: of the arm.
        external: values of base axes and of station axes.
        tools: positions with a tool other than 0.
    """

    where: str
    targets: dict[str, Target | Reason] = field(default_factory=dict)
    external: dict[str, tuple[float | str | None, ...]] = field(default_factory=dict)
    tools: set[str] = field(default_factory=set)
    kind: str = ""
    tool: str = "0"
    rectangular: bool = False

    def take_heading(self, line: str) -> None:
        """Read a heading: ///POSTYPE BASE, ///TOOL 1, ///RECTAN."""
        word, _, rest = line.removeprefix("///").partition(" ")
        if word == "POSTYPE":
            self.kind, self.rectangular = rest.strip().upper(), False
        elif word == "TOOL":
            self.tool = rest.strip()
        elif word in ("RECTAN", "PULSE"):
            self.rectangular = word == "RECTAN"

    def take(self, count: int, line: str) -> None:
        """Read a position."""
        position = _POSITION.match(line)
        if position is None:
            return
        name, text = position.groups()
        if name.startswith(_EXTERNAL):
            self.external[name] = tuple(number(part) for part in text.split(","))
            return
        target = _target(text, self.kind, f"{self.where}, line {count}", rectangular=self.rectangular)
        if self.kind == "USER":
            target = in_base(target, None)
        self.targets[name] = target
        if self.tool not in ("", "0"):
            self.tools.add(name)

    def external_of(self, tags: Sequence[str]) -> tuple[float | str | None, ...]:
        """Values of external axes at the positions that a move names; of one that is not in the file its name."""
        values: list[float | str | None] = []
        for tag in tags:
            if tag.startswith(_EXTERNAL):
                values += self.external.get(tag, (tag,))
        return tuple(values)


def read(text: str, name: str) -> Program:
    """A job from its text.

    Raises:
        TrajectoryError: too large, or a value out of range.
    """
    positions, listing = _Positions(name), Listing(name)
    section, shifted = "", False
    for count, line in lines_of(text, name):
        plain = line.strip()
        if plain.startswith("///"):
            positions.take_heading(plain)
        elif plain.startswith("/"):
            section = plain.split()[0].upper()
        elif section == "//POS":
            positions.take(count, line)
        elif section == "//INST" and plain and not plain.startswith(_COMMENT):
            shifted = _SHIFTS.get(plain.split()[0].upper(), shifted)
            _instruction(listing, positions, count, plain, shifted=shifted)
    return listing.program(Language.INFORM, raised=True)


def _target(text: str, kind: str, where: str, *, rectangular: bool) -> Target | Reason:
    if kind == "PULSE" or (not rectangular and kind in _FRAMED):
        return Reason.PULSES
    if kind not in _FRAMED:
        return Reason.EXPRESSION
    values = [number(part) for part in text.split(",")]
    known = [value for value in values[:6] if value is not None]
    if len(known) == 6:
        return angle_target(known, where)
    return Reason.INCOMPLETE


def _instruction(listing: Listing, positions: _Positions, count: int, text: str, *, shifted: bool) -> None:
    """One instruction of the job."""
    word, *tags = text.split()
    word = word.upper()
    if word not in _MOVES:
        if word not in ("NOP", "END"):
            listing.skip(count, text, _why_skipped(word))
        return
    goal = next((tag for tag in tags if tag in positions.targets), "")
    target = _reached(positions.targets.get(goal, Reason.VARIABLE), tags, shifted=shifted)
    listing.tool = np.eye(4)
    if isinstance(target, Target):
        target = replace(target, external=positions.external_of(tags))
        if goal in positions.tools:
            listing.set_tool(count, text, None)
    settings = _settings(tags)
    kind = _MOVES[word]
    listing.move(count, text, kind, target, _speed(kind, settings), blend=settings.get("PL") != 0.0)


def _why_skipped(word: str) -> Reason:
    """Why an instruction is not read: its first word, in capitals."""
    if word.startswith("+"):  # of another group of joints
        return Reason.OTHER_MOVE
    if word.startswith("*"):
        return Reason.BRANCH
    if word == "CALL":
        return Reason.CALL
    return (_OTHER_MOVES | _FLOW).get(word, Reason.OTHER)


def _reached(target: Target | Reason, tags: list[str], *, shifted: bool) -> Target | Reason:
    """A target, or why the move ends elsewhere."""
    if "UNTIL" in tags:
        return Reason.ENDS_EARLY
    if shifted and isinstance(target, Target):
        return Reason.SHIFTED
    return target


def _settings(tags: Iterable[str]) -> dict[str, float | None]:
    """The numbers of the tags of a move, by what stands before the equals sign: VJ, V, VR, PL."""
    settings = {}
    for tag in tags:
        key, mark, value = tag.partition("=")
        if mark:
            settings[key] = number(value)
    return settings


def _speed(kind: str, settings: Mapping[str, float | None]) -> Speed:
    """The speed of a move: a share of the joints' rates, or rates of the tool."""
    if kind == "joint":
        return Speed(share=positive(settings.get("VJ"), 0.01))
    linear = positive(settings.get("V"), MILLIMETRE)
    return Speed(linear=linear, angular=positive(settings.get("VR"), radians(1.0)))
