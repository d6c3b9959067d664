"""A robot program as data: moves with literal targets, and lines that were not read."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path
from typing import Literal

import numpy as np

from rankdrop.path.read.program_scan import number, shorten_line
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.robot.model import Array

MOST_MOVES = 20_000
SYSTEM_PROGRAMS = (".sub", ".sys", ".sysx")
"""Endings of programs that run next to others, and of modules of the controller; most have no moves."""
PROGRAMS = (".src", ".mod", ".modx", ".prg", ".script", ".urscript", ".ls", ".jbi", *SYSTEM_PROGRAMS)
"""Endings of robot programs."""

Kind = Literal["joint", "line", "arc"]
"""How a move goes."""


class Language(StrEnum):
    """Of a program."""

    KRL = "KRL"
    RAPID = "RAPID"
    URSCRIPT = "URScript"
    TP = "FANUC TP"
    INFORM = "INFORM"


class Reason(StrEnum):
    """Why a line was not read."""

    VARIABLE = "variable"
    CHANGED = "changed"
    EXPRESSION = "expression"
    INCOMPLETE = "incomplete"
    PULSES = "pulses"
    CIRCLE = "circle"
    SPLINE = "spline"
    RELATIVE = "relative"
    RELATIVE_TO_JOINTS = "after joint values"
    RELATIVE_TO_POSE = "after a pose"
    RELATIVE_TURN = "relative turn"
    OFFSET = "offset"
    ENDS_EARLY = "ends early"
    SHIFTED = "shifted"
    OTHER_MOVE = "other move"
    BASE = "base frame"
    ROUTINE = "routine"
    BRANCH = "branch"
    LOOP = "loop"
    CALL = "call"
    TOOL = "tool frame"
    OVERRIDE = "override"
    OTHER = "other"


class MoveAssumption(StrEnum):
    """An assumption on a move: its file, or this reader, does not tell what its controller does."""

    TOOL = "tool"
    EXTERNAL = "external axes"
    TURNS = "turns"
    WRIST = "wrist"
    CONFIGURATION = "configuration"
    ARRIVAL = "arrival"
    HALF_TURN = "half a turn"


LASTING = frozenset((MoveAssumption.TOOL, MoveAssumption.EXTERNAL, MoveAssumption.CONFIGURATION))
"""Assumptions after which the arm may be elsewhere than it was followed to, up to the next joint values."""
MOVES = frozenset((Reason.VARIABLE, Reason.CHANGED, Reason.EXPRESSION, Reason.INCOMPLETE, Reason.PULSES, Reason.CIRCLE,
                   Reason.SPLINE, Reason.RELATIVE, Reason.RELATIVE_TO_JOINTS,
                   Reason.RELATIVE_TO_POSE, Reason.RELATIVE_TURN, Reason.OFFSET, Reason.ENDS_EARLY,
                   Reason.SHIFTED, Reason.OTHER_MOVE, Reason.BASE))  # fmt: skip
"""Reasons of lines that move the arm: what they do was not read."""
BREAKS = MOVES | {Reason.ROUTINE, Reason.BRANCH}
"""Reasons after which nobody knows from this file where the arm is."""


@dataclass(frozen=True)
class Speed:
    """What a program states of the speed of a move; None: nothing.

    Attributes:
        linear: of the tip [m/s].
        angular: of the turn of the tool [rad/s].
        joint: of the joint that leads [rad/s].
        share: of the largest joint rates, 0 … 1.
        time: of the whole move [s].
    """

    linear: float | None = None
    angular: float | None = None
    joint: float | None = None
    share: float | None = None
    time: float | None = None


@dataclass(frozen=True)
class Posture:
    """What a target states of the solution of the inverse; None: nothing.

    Attributes:
        signs: bits of KRL's T, the first of joint 1: the joint is negative.
        quarters: RAPID's cf1, cf4, cf6: quarter turns, rounded down, of joints 1, 4 and 6.
        near: joint values to which the solution is nearest (qnear of URScript), as the language has them.
    """

    signs: int | None = None
    quarters: tuple[int, int, int] | None = None
    near: tuple[float, ...] | None = None


@dataclass(frozen=True, eq=False)
class Target:
    """Where a move ends: joint values, or a pose.

    Attributes:
        joints: as the language has them: degrees and mm, or rad and m of URScript; None for a pose.
        pose: (4, 4) in the frame of the program [m]; None for joint values.
        posture: which solution of the inverse is meant.
        external: values of external axes or of other groups of joints, as they are written; None: none.
        assumed: assumptions with which it is read.
    """

    joints: tuple[float, ...] | None = None
    pose: Array | None = None
    posture: Posture = Posture()
    external: tuple[float | str | None, ...] = ()
    assumed: frozenset[MoveAssumption] = frozenset()


@dataclass(frozen=True, eq=False)
class Move:
    """A move that was read.

    Attributes:
        line: number in the file, from 1.
        text: of the line, its beginning.
        kind: "joint": joints go in proportion; "line": the tip goes straight and turns about one axis; "arc": it goes
            on a circle, and turns as on a line.
        target: where it ends.
        speed: what is stated.
        blend: the corner at its end is rounded by the controller.
        tool: (4, 4) the tool frame at the flange in which it is programmed [m]; None: not known.
        via: (3,) the place of an arc between its ends, in the frame of the program [m]; None for other moves.
        checks_arrival: a line has to end in the configuration that its target states.
        keeps_turn: the tool keeps the orientation that it has at the beginning, whatever its target states.
        assumed: assumptions with which it is read.
    """

    line: int
    text: str
    kind: Kind
    target: Target
    speed: Speed = Speed()
    blend: bool = False
    tool: Array | None = None
    via: Array | None = None
    keeps_turn: bool = False
    checks_arrival: bool = False
    assumed: frozenset[MoveAssumption] = frozenset()

    @property
    def needs_tool(self) -> bool:
        """Where the arm goes depends on the tool: it ends at a pose, or the tip goes straight."""
        return self.target.pose is not None or self.kind != "joint"


@dataclass(frozen=True)
class Skipped:
    """A line that was not read: number in the file, its beginning, and why."""

    line: int
    text: str
    reason: Reason

    @property
    def moves(self) -> bool:
        """The line moves the arm."""
        return self.reason in MOVES


@dataclass(frozen=True, eq=False)
class Program:
    """What was read of a program.

    Attributes:
        name: of the file.
        language: of it.
        items: moves, and lines that were not read, in the order of the file.
        degrees: joint values are in degrees and mm; else in rad and m.
        raised: the maker's base frame is at the height of axis 2, not at the foot of the arm.
        level: the maker counts joint 3 from the horizontal.
        tool: (4, 4) the tool frame at the flange in which all moves that depend on it are programmed [m]; None: it is
            not known, or there are several, each with its moves.
    """

    name: str
    language: Language
    items: tuple[Move | Skipped, ...]
    degrees: bool = True
    raised: bool = False
    level: bool = False
    tool: Array | None = None

    @property
    def moves(self) -> tuple[Move, ...]:
        """The moves that were read."""
        return tuple(item for item in self.items if isinstance(item, Move))

    @property
    def skipped(self) -> tuple[Skipped, ...]:
        """The lines that were not."""
        return tuple(item for item in self.items if isinstance(item, Skipped))


@dataclass
class Listing:
    """Moves and skipped lines while a program is read; `where` is the file, `tool` the tool frame of the next move,
    `stated` the lines that state one, `label` what stands in front of a line: its number in the program, `last` the
    target of the move before, None where that was not read, `assumed` what the moves that follow are read with,
    `external` the values of external axes before, `checks_arrival` a line has to end in the configuration that its
    target states.
    """

    where: str
    items: list[Move | Skipped] = field(default_factory=list)
    moves: int = 0
    tool: Array | None = field(default_factory=lambda: np.eye(4))
    stated: list[Move | Skipped] = field(default_factory=list)
    label: str = ""
    last: Target | None = None
    assumed: set[MoveAssumption] = field(default_factory=set)
    external: tuple[float | str | None, ...] = ()
    checks_arrival: bool = False

    def set_tool(self, line: int, text: str, tool: Array | None) -> None:
        """Take the tool frame (4, 4) of the moves that follow; None: a tool that is not known.

        The line is kept until it is clear that one tool is that of all moves.
        """
        if tool is None or self.tool is None or not np.array_equal(tool, self.tool):
            self.last = None  # where the arm is is a target of another tool
        self.tool = tool
        if tool is not None and np.array_equal(tool, np.eye(4)):
            return
        self.skip(line, text, Reason.TOOL)
        if tool is not None:
            self.stated.append(self.items[-1])

    def program(
        self, language: Language, *, degrees: bool = True, raised: bool = False, level: bool = False
    ) -> Program:
        """What was read; lines that state a tool by its numbers count as read."""
        read = set(map(id, self.stated))
        items = [self._with_tool_known(item) for item in self.items if id(item) not in read]
        return Program(self.where, language, tuple(items), degrees, raised, level, self._tool_of_all_moves())

    def _with_tool_known(self, item: Move | Skipped) -> Move | Skipped:
        """A move of a tool that is not in the file assumes one."""
        if isinstance(item, Move) and item.needs_tool and item.tool is None:
            return replace(item, assumed=item.assumed | {MoveAssumption.TOOL})
        return item

    def _tool_of_all_moves(self) -> Array | None:
        """(4, 4) the tool of the moves that depend on it; None where one is not known, or they are several."""
        tools = [item.tool for item in self.items if isinstance(item, Move) and item.needs_tool]
        if not tools:
            return self.tool
        first = tools[0]
        if first is None or any(tool is None or not np.array_equal(tool, first) for tool in tools):
            return None
        return first

    def skip(self, line: int, text: str, reason: Reason) -> None:
        """Keep a line that was not read."""
        if reason in BREAKS or reason in (Reason.CALL, Reason.LOOP):
            self.last = None
        self.items.append(Skipped(line, shorten_line(f"{self.label}{text}"), reason))

    def move(
        self, line: int, text: str, kind: Kind, target: Target | Reason, speed: Speed, *, blend: bool,
        via: Array | None = None, keeps_turn: bool = False, assumed: Iterable[MoveAssumption] = (),
    ) -> None:  # fmt: skip
        """Keep a move, or why its target was not read.

        Raises:
            TrajectoryError: there are too many.
        """
        if isinstance(target, Reason):
            self.skip(line, text, target)
            return
        self.last = target
        self.moves += 1
        if self.moves > MOST_MOVES:
            raise TrajectoryError("the program has too many moves", where=f"{self.where}, line {line}",
                                  allowed=f"at most {MOST_MOVES:,}")  # fmt: skip
        every = target.assumed.union(assumed)
        if kind != "joint":
            every |= self.assumed
        if self._external_axes_matter(kind, target):
            every |= {MoveAssumption.EXTERNAL}
        self.items.append(Move(line, shorten_line(f"{self.label}{text}"), kind, target, speed, blend, self.tool, via,
                               keeps_turn, self.checks_arrival and kind != "joint", every))  # fmt: skip

    def _external_axes_matter(self, kind: Kind, target: Target) -> bool:
        """Whether external axes may carry the arm: a pose is reached with them away from zero, or a line while they
        move. Where only joints are programmed, the arm moves in itself as it does without.
        """
        pairs = zip(target.external, self.external, strict=False)
        moved = any(now != before and None not in (now, before) for now, before in pairs)
        self._move_external_axes(target.external)
        away = any(value not in (0.0, None) for value in self.external)
        if target.pose is not None:
            return moved or away
        return moved and kind != "joint"

    def _move_external_axes(self, values: Sequence[float | str | None]) -> None:
        """Take values of external axes; one that is not stated stays where it is."""
        before = self.external + (None,) * (len(values) - len(self.external))
        stated = tuple(values) + (None,) * (len(before) - len(values))
        self.external = tuple(last if now is None else now for now, last in zip(stated, before, strict=True))


@dataclass
class Names:
    """Names of targets and numbers: a name counts where it has one literal in the file, and nothing else."""

    literals: dict[str, object] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)
    changed: set[str] = field(default_factory=set)

    def assign(self, name: str, text: str, literal: object | None) -> None:
        """An assignment: its text, and the literal, None where it is none."""
        plain = "".join(text.split())
        if literal is None or (name in self.texts and self.texts[name] != plain):
            self.changed.add(name)
            return
        self.texts[name], self.literals[name] = plain, literal

    def target(self, name: str) -> Target | Reason:
        """The target of a name, or why there is none."""
        literal = self.literals.get(name)
        if name in self.changed:
            return Reason.CHANGED
        if isinstance(literal, Target | Reason):
            return literal
        return Reason.VARIABLE

    def number(self, text: str) -> float | None:
        """A number, or that of a name; None for everything else."""
        if text in self.changed:
            literal = None
        else:
            literal = self.literals.get(text)
        if isinstance(literal, float):
            return literal
        return number(text)


def is_program(path: str | Path) -> bool:
    """Whether a file is a robot program, by its ending."""
    return Path(path).suffix.lower() in PROGRAMS


Reader = Callable[[str, str], Program]
"""read(text, name) -> what was read."""
