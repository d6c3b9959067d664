"""KUKA KRL (.src, and declarations in the .dat file of the same name). A statement is one line.

Lengths in mm, speeds of the tip in m/s, angles in degrees. A, B, C turn about Z, then the new Y, then the new X:
R = Rz(A) Ry(B) Rx(C). The bits of T say which joints are negative; S is not evaluated, T and the arm's own solutions
decide.
"""

from __future__ import annotations

import re
from dataclasses import replace
from math import radians
from typing import Literal

import numpy as np

from rankdrop.path.read.program_record import (
    BREAKS,
    Language,
    Listing,
    Names,
    Posture,
    Program,
    Reason,
    Speed,
    Target,
    angle_target,
    in_base,
    joint_target,
    lines_of,
    number,
    parts_of,
    positive,
    split_bracket,
    without_comment,
)
from rankdrop.robot.model import Array

_MOVES: dict[str, Literal["joint", "line"]] = {"PTP": "joint", "SPTP": "joint", "LIN": "line", "SLIN": "line"}
_RELATIVE: dict[str, Literal["joint", "line"]] = {
    "PTP_REL": "joint", "SPTP_REL": "joint", "LIN_REL": "line", "SLIN_REL": "line",
}  # fmt: skip
_OTHER_MOVES = {
    **dict.fromkeys(("CIRC", "SCIRC"), Reason.CIRCLE),
    **dict.fromkeys(("SPL", "SPLINE", "ENDSPLINE", "PTP_SPLINE"), Reason.SPLINE),
    **dict.fromkeys(("CIRC_REL", "SPL_REL", "SCIRC_REL"), Reason.RELATIVE),
    **dict.fromkeys(("ASYPTP", "MOVE_EMI"), Reason.OTHER_MOVE),
}  # fmt: skip
_FLOW = {
    **dict.fromkeys(("IF", "ELSE", "ENDIF", "SWITCH", "CASE", "DEFAULT", "ENDSWITCH", "GOTO", "RETURN"), Reason.BRANCH),
    **dict.fromkeys(("FOR", "ENDFOR", "WHILE", "ENDWHILE", "REPEAT", "UNTIL", "LOOP", "ENDLOOP", "EXIT"), Reason.LOOP),
}  # fmt: skip
_QUIET = {"END", "ENDFCT", "DECL", "GLOBAL", "EXT", "EXTFCT", "SIGNAL", "ENUM", "STRUC", "ENDDAT", "DEFDAT", "CONST",
          "INT", "REAL", "BOOL", "CHAR", "E6POS", "E6AXIS", "POS", "AXIS", "FRAME"}  # fmt: skip
_TYPES = {"DECL", "GLOBAL", "CONST", "E6POS", "E6AXIS", "POS", "AXIS", "FRAME"}
_SETTINGS = {"$ACC", "$VEL_AXIS", "$ACC_AXIS", "$APO", "$BWDSTART", "$ADVANCE", "INI", "PDAT_ACT", "LDAT_ACT",
             "FDAT_ACT", "BAS"}  # fmt: skip
_WORD = re.compile(r"\s*([A-Za-z_$][\w$]*)")
_NAME = re.compile(r"[A-Za-z_$][\w$]*")
_DEGREE = radians(1.0)
_BLENDS = ("C_PTP", "C_DIS", "C_VEL", "C_ORI", "C_SPL")
_AXES, _MORE_AXES = tuple(f"A{k}" for k in range(1, 7)), tuple(f"A{k}" for k in range(7, 10))
_PLACE, _TURN = ("X", "Y", "Z"), ("C", "B", "A")


def read(text: str, name: str, declarations: str = "") -> Program:
    """A program from its text.

    Args:
        text: of the .src file.
        name: of the file, for errors.
        declarations: text of the .dat file of the same name.

    Raises:
        TrajectoryError: too large, or a value out of range.
    """
    names, listing = Names(), Listing(name)
    for _, line in lines_of(declarations, f"{name} (.dat)"):
        _declare(names, without_comment(line, ";"), f"{name} (.dat)")
    lines = [(count, without_comment(line, ";")) for count, line in lines_of(text, name)]
    for count, line in lines:
        _declare(names, line, f"{name}, line {count}")
    reader = _Reader(name, names, listing)
    for count, line in lines:
        if not line.lstrip().startswith("&"):
            reader.take(count, line)
    return Program(name, Language.KRL, tuple(listing.items))


class _Reader:
    """Takes lines in the order of the program, and lists the moves and what was not read."""

    def __init__(self, name: str, names: Names, listing: Listing) -> None:
        self.name, self.names, self.listing = name, names, listing
        self.state, self.routines = _State(), 0
        self.last: Target | None = None  # of the move before, its pose in the base frame of the arm; None: not known

    def take(self, count: int, line: str) -> None:
        """Read one line, which has a number."""
        first = _WORD.match(line)
        if first is None:
            return
        word, rest = first[1].upper(), line[first.end() :].strip()
        where = f"{self.name}, line {count}"
        if _begins_routine(word, rest):
            self.routines += 1
            if self.routines > 1:
                self._skip(count, line, Reason.ROUTINE)
        elif word in _MOVES:
            target, after = _target(rest, self.names, where)
            self._move(count, line, _MOVES[word], in_base(target, self.state.base), after)
        elif word in _RELATIVE:
            target, after = _relative_target(rest, self.last, self.state.base, where)
            self._move(count, line, _RELATIVE[word], target, after)
        elif word == "$BASE" and not _is_label(rest):
            self.state.base = _frame(rest, self.names, where)
        else:
            reason = self._why_skipped(word, rest)
            if reason is not None:
                self._skip(count, line, reason)

    def _move(
        self, count: int, line: str, kind: Literal["joint", "line"], target: Target | Reason, after: str
    ) -> None:  # fmt: skip
        """Keep a move, with what stands behind its target."""
        speed = self.state.speed_of(kind, after, self.names)
        blend = any(word in after.upper() for word in _BLENDS)
        self.listing.move(count, line, kind, target, speed, blend=blend)
        self.last = None
        if isinstance(target, Target):
            self.last = target

    def _skip(self, count: int, line: str, reason: Reason) -> None:
        """Keep a line that was not read; after some of them nobody knows where the arm is."""
        self.listing.skip(count, line, reason)
        if reason in BREAKS or reason is Reason.LOOP:  # a relative move ends elsewhere in each pass of a loop
            self.last = None

    def _why_skipped(self, word: str, rest: str) -> Reason | None:
        """Why a line that is no move is not read; None where it is, or means nothing for the moves."""
        if word in _OTHER_MOVES:
            return _OTHER_MOVES[word]
        if word in _FLOW:
            return _FLOW[word]
        if word in _QUIET or self.state.takes(word, rest, self.names):
            return None
        if _is_label(rest):
            return Reason.BRANCH
        if word == "$TOOL" and _without_spaces(rest) == "=$NULLFRAME":
            return None
        if word in ("BAS", "$TOOL"):
            return Reason.TOOL
        if rest.startswith("("):
            return Reason.CALL
        return Reason.OTHER


def _begins_routine(word: str, rest: str) -> bool:
    """DEF or DEFFCT, GLOBAL or not."""
    return word in ("DEF", "DEFFCT") or (word == "GLOBAL" and rest.upper().startswith("DEF"))


def _is_label(rest: str) -> bool:
    """Whether the first word of a line is the label of a jump: what follows it."""
    return rest.startswith(":") and not rest.startswith(":=")


def _without_spaces(text: str) -> str:
    return "".join(text.upper().split())


class _State:
    """Speeds and the base frame that are set for the moves that follow; a frame that is not known is None."""

    def __init__(self) -> None:
        self.line, self.joint = Speed(), Speed()
        self.base: Array | None = np.eye(4)

    def takes(self, word: str, rest: str, names: Names) -> bool:
        """Whether a line sets a speed or a base: $VEL.CP = 0.1, BAS(#VEL_CP, 0.1), BAS(#BASE, 0), BAS(#INITMOV, 0)."""
        plain = _without_spaces(rest)
        if word == "$VEL":
            self._set_velocity(plain, names)
            return True
        if word == "BAS" and plain.startswith("(#"):
            what, _, value = plain[2:].rstrip(")").partition(",")
            return self._initialize(what, value, names)
        return word in _SETTINGS

    def _set_velocity(self, plain: str, names: Names) -> None:
        """$VEL.CP, of the tip, and $VEL.ORI1, of the swivel: what follows $VEL, without spaces."""
        if plain.startswith(".CP="):
            self.line = replace(self.line, linear=positive(names.number(plain[4:])))
        elif plain.startswith(".ORI1="):
            self.line = replace(self.line, angular=positive(names.number(plain[6:]), _DEGREE))

    def _initialize(self, what: str, value: str, names: Names) -> bool:
        """BAS(#what, value); False where a tool is set that is not known."""
        if what in ("VEL_CP", "CP_PARAMS"):
            self.line = replace(self.line, linear=positive(names.number(value)))
        elif what in ("VEL_PTP", "PTP_PARAMS"):
            self.joint = Speed(share=positive(names.number(value), 0.01))
        elif what in ("BASE", "FRAMES"):
            self.base = np.eye(4) if value == "0" else None
        return what != "TOOL" or value == "0"

    def speed_of(self, kind: str, after: str, names: Names) -> Speed:
        """The speed of a move; what stands behind its target may set it: WITH $VEL.CP = 0.2."""
        if kind == "joint":
            speed = self.joint
        else:
            speed = self.line
        _, has_settings, settings = after.upper().partition("WITH ")
        for setting in parts_of(settings) if has_settings else []:
            key, _, value = ("".join(part.split()) for part in setting.partition("="))
            if key == "$VEL.CP":
                speed = replace(speed, linear=positive(names.number(value.split("C_")[0])))
        return speed


def _frame(rest: str, names: Names, where: str) -> Array | None:
    """The frame that is assigned to $BASE: $NULLFRAME, a literal, or the name of one; else it is not known."""
    plain = rest.removeprefix("=").strip()
    if plain == rest or plain.upper() == "$NULLFRAME":
        return np.eye(4) if plain != rest else None
    target, after = _target(plain, names, where)
    if isinstance(target, Target) and not after:
        return target.pose
    return None


def _declare(names: Names, line: str, where: str) -> None:
    """Take in an assignment to a name; one to a component of it changes it."""
    assignment = _assignment(line)
    if assignment is None:
        return
    name, right = assignment
    base = name.partition(".")[0].partition("[")[0]
    if not _NAME.fullmatch(base) or base.startswith("$"):
        return
    if base != name:
        names.changed.add(base)
        return
    value = _literal(right, where) if right.startswith("{") else number(right)
    names.assign(name, right, value)


def _assignment(line: str) -> tuple[str, str] | None:
    """What stands left of the equals sign, without types and in capitals, and right of it; None for other lines."""
    if "=" not in line or line.lstrip()[:1] in ("", "&"):
        return None
    left, _, right = line.partition("=")
    words = left.split()
    while words and words[0].upper() in _TYPES:
        words.pop(0)
    if len(words) != 1:
        return None
    return words[0].upper(), right.strip()


def _target(rest: str, names: Names, where: str) -> tuple[Target | Reason, str]:
    """The target that a text begins with, and what follows it."""
    if rest.startswith("{"):
        bracket = split_bracket(rest, "{")
        if bracket is None:
            return Reason.EXPRESSION, ""
        after = bracket[1].strip()
        if after.startswith(":"):
            return Reason.EXPRESSION, after
        return _literal(rest, where), after
    name = _NAME.match(rest)
    if name is None:
        return Reason.EXPRESSION, rest
    after = rest[name.end() :].strip()
    if after.startswith((":", "(", "[", ".")):
        return Reason.EXPRESSION if after[0] != "[" else Reason.VARIABLE, after
    return names.target(name[0].upper()), after


def _relative_target(rest: str, last: Target | None, base: Array | None, where: str) -> tuple[Target | Reason, str]:
    """The target of a relative move, and what follows it.

    Args:
        rest: {A1 …}, added to joint values, or {X …, A …}; others are zero. #TOOL behind it: T = T₀ ΔT,
            in the axes of the tool; else p = p₀ + R_base Δp. How a turn in the base frame is added is not known here.
        last: where the move before ended; None: not known.
        base: (4, 4) the base frame of the program; None: not known.
        where: for errors.
    """
    found = split_bracket(rest, "{")
    values = _components(rest)
    if found is None or values is None:
        return Reason.EXPRESSION, rest
    after = found[1].strip()
    if last is None:
        return Reason.RELATIVE, after
    if any(key in values for key in _AXES):
        return _joints_added(values, last, where), after
    return _frame_added(values, last, base, where, in_tool="#TOOL" in after.upper()), after


def _frame_added(
    values: dict[str, float], last: Target, base: Array | None, where: str, *, in_tool: bool
) -> Target | Reason:  # fmt: skip
    """The pose that a relative move ends at; arguments as of `_relative_target`."""
    if last.pose is None:
        return Reason.RELATIVE_TO_JOINTS
    step = angle_target([values.get(key, 0.0) for key in _PLACE + _TURN], where).pose
    assert step is not None
    if in_tool:
        return Target(pose=last.pose @ step)
    if any(values.get(key, 0.0) for key in _TURN):
        return Reason.RELATIVE_TURN
    if base is None:
        return Reason.BASE
    pose = last.pose.copy()
    pose[:3, 3] += base[:3, :3] @ step[:3, 3]
    return Target(pose=pose)


def _joints_added(values: dict[str, float], last: Target, where: str) -> Target | Reason:
    """Joint values that a relative move ends at [deg, mm]."""
    if last.joints is None:
        return Reason.RELATIVE_TO_POSE
    steps = [values.get(key, 0.0) for key in _AXES + _MORE_AXES]
    return joint_target([joint + step for joint, step in zip(last.joints, steps, strict=False)], where)


def _literal(text: str, where: str) -> Target | Reason:
    """{A1 …} or {X …, Y …, Z …, A …, B …, C …}; also with the name of the type in front of the colon."""
    values = _components(text)
    if values is None:
        return Reason.EXPRESSION
    axes = [key for key in _AXES if key in values]
    if len(axes) == len(_AXES):
        return joint_target([values[key] for key in _AXES + _MORE_AXES if key in values], where)
    if axes or not all(key in values for key in _PLACE + _TURN):
        return Reason.INCOMPLETE
    signs = values.get("T")
    if signs is not None and 0 <= signs < 64:
        posture = Posture(signs=int(signs))
    else:
        posture = Posture()
    return angle_target([values[key] for key in _PLACE + _TURN], where, posture)


def _components(text: str) -> dict[str, float] | None:
    """The components of a literal {…} by their names; None where it is none, or a value is no number."""
    bracket = split_bracket(text, "{")
    if bracket is None:
        return None
    within = bracket[0]
    head, colon, rest = within.partition(":")
    if colon and _NAME.fullmatch(head.strip()):
        within = rest
    values: dict[str, float] = {}
    for part in parts_of(within):
        key, _, word = part.strip().partition(" ")
        value = number(word)
        if value is None:
            return None
        values[key.upper()] = value
    return values
