"""KUKA KRL (.src, and declarations in the .dat file of the same name). A statement is one line, or goes on over the
next lines while a bracket is open.

Lengths in mm, speeds of the tip in m/s, angles in degrees. A, B, C turn about Z, then the new Y, then the new X:
R = Rz(A) Ry(B) Rx(C). The bits of T say which joints are negative; S is not evaluated, T and the arm's own solutions
decide. The FDAT of an inline form says in which base its target is.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from math import radians
from typing import Literal

import numpy as np

from rankdrop.path.read.krl_values import (
    AXES,
    MORE_AXES,
    PLACE,
    TURN,
    base_frame,
    completed,
    components,
    declare,
    frame_of,
    is_read_assignment,
    numbers_of_fdat,
    place_of,
    settings_of,
    target_of,
    tool_data,
    tool_of,
    turns_of_ldat,
)
from rankdrop.path.read.program_record import (
    BREAKS,
    Kind,
    Language,
    Listing,
    MoveAssumption,
    Names,
    Program,
    Reason,
    Speed,
    Target,
)
from rankdrop.path.read.program_scan import positive, split_bracket, statements_of
from rankdrop.path.read.program_targets import angle_target, in_base, joint_target
from rankdrop.robot.model import Array

_MOVES: dict[str, Literal["joint", "line"]] = {"PTP": "joint", "SPTP": "joint", "LIN": "line", "SLIN": "line"}
_RELATIVE: dict[str, Literal["joint", "line"]] = {
    "PTP_REL": "joint", "SPTP_REL": "joint", "LIN_REL": "line", "SLIN_REL": "line",
}  # fmt: skip
_OTHER_MOVES = {
    "SPL": Reason.SPLINE,
    **dict.fromkeys(("CIRC_REL", "SPL_REL", "SCIRC_REL"), Reason.RELATIVE),
    **dict.fromkeys(("ASYPTP", "MOVE_EMI"), Reason.OTHER_MOVE),
}  # fmt: skip
_ARCS = ("CIRC", "SCIRC")
_BLOCKS = ("SPLINE", "PTP_SPLINE", "ENDSPLINE")
_FLOW = {
    **dict.fromkeys(("IF", "ELSE", "ENDIF", "SWITCH", "CASE", "DEFAULT", "ENDSWITCH", "GOTO", "RETURN"), Reason.BRANCH),
    **dict.fromkeys(("FOR", "ENDFOR", "WHILE", "ENDWHILE", "REPEAT", "UNTIL", "LOOP", "ENDLOOP", "EXIT"), Reason.LOOP),
}  # fmt: skip
_QUIET = {"END", "ENDFCT", "DECL", "GLOBAL", "EXT", "EXTFCT", "SIGNAL", "ENUM", "STRUC", "ENDDAT", "DEFDAT", "CONST",
          "INT", "REAL", "BOOL", "CHAR", "E6POS", "E6AXIS", "POS", "AXIS", "FRAME"}  # fmt: skip
_SETTINGS = {"$ACC", "$ACC_AXIS", "$APO", "$BWDSTART", "$ADVANCE", "INI", "PDAT_ACT", "BAS"}
_BEGINS = {*_MOVES, *_ARCS, *_RELATIVE, *_OTHER_MOVES, *_BLOCKS, *_FLOW, *_QUIET, "DEF", "DEFFCT", "DEFDAT", "WAIT",
           "HALT", "INTERRUPT", "TRIGGER"}  # fmt: skip
"""Words that begin a statement and stand in no bracket."""
_FOLLOWED_TURNS = ("VAR", "CONSTANT")
_MODE = re.compile(r"#(\w+)")
_WHERE_IT_IS = ("$AXIS_ACT", "$POS_ACT", "$AXIS_ACT_MEAS")
_WORD = re.compile(r"\s*([A-Za-z_$][\w$]*)")
_CIRCULAR_ANGLE = re.compile(r"\s*,\s*CA\b", re.IGNORECASE)
_IN_CALL = re.compile(r"SVEL_(?:CP|JOINT)\(\s*([^,)]*).*", re.IGNORECASE)
_DEGREE = radians(1.0)
_BLENDS = ("C_PTP", "C_DIS", "C_VEL", "C_ORI", "C_SPL")

_Tool = tuple[str, Array | None]
"""The text that set a tool, and its frame (4, 4); None: not known."""


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
    for _, line in _statements(declarations, f"{name} (.dat)"):
        declare(names, line, f"{name} (.dat)")
    lines = list(_statements(text, name))
    for count, line in lines:
        declare(names, line, f"{name}, line {count}")
    reader = _KrlReader(name, names, listing)
    for count, line in lines:
        if not line.lstrip().startswith("&"):
            reader.take(count, line)
    return listing.program(Language.KRL)


def _statements(text: str, name: str) -> Iterator[tuple[int, str]]:
    """Statements without comments, with the number of the line on which each begins."""
    return statements_of(text, name, ";", _begins_statement)


def _begins_statement(line: str) -> bool:
    """Whether a line begins with a word that stands in no bracket."""
    first = _WORD.match(line)
    return first is not None and first[1].upper() in _BEGINS


class _KrlReader:
    """Takes statements in the order of the program, and lists the moves and what was not read."""

    def __init__(self, name: str, names: Names, listing: Listing) -> None:
        self.name, self.names, self.listing = name, names, listing
        self.state, self.routines = _State(), 0
        self.outside = self.outside_block = self._tool_now()  # the tools outside WITH of a move, and of a block
        self.last: Target | None = None  # of the move before, its pose in the base frame of the arm; None: not known
        self.frames: tuple[Array | None, str] = (None, "")  # the base and the tool in which it is programmed

    def take(self, count: int, line: str) -> None:
        """Read one statement, which has a line number."""
        first = _WORD.match(line)
        if first is None:
            return
        word, rest = first[1].upper(), line[first.end() :].strip()
        if _begins_routine(word, rest):
            self.routines += 1
            if self.routines > 1:
                self._skip(count, line, Reason.ROUTINE)
        elif word in _MOVES:
            self._move(count, line, word, rest)
        elif word in _ARCS:
            self._arc(count, line, rest)
        elif word in _RELATIVE:
            self._relative_move(count, line, word, rest)
        elif word in _BLOCKS:
            self._block(count, line, word, rest)
        elif _sets_frames(word, rest):
            self._set_frames(count, line, word, rest)
        elif not is_read_assignment(line, self.names):
            self._skip(count, line, self._why_skipped(word, rest))

    def _set_frames(self, count: int, line: str, word: str, rest: str) -> None:
        """A statement that sets frames: $BASE = …, $TOOL = …, BAS(#TOOL, 1), FDAT_ACT = FP1, $IPO_MODE = #TCP."""
        _, mark, value = rest.partition("=")
        where = f"{self.name}, line {count}"
        if word == "$IPO_MODE":
            self.state.fixed_tool = "#TCP" in value.upper()
        elif word == "BAS":
            self._set_tool_by_number(count, line, rest)
        elif word == "$TOOL":
            tool = None
            if rest.startswith("="):
                tool = tool_of(value, self.names, where)
            self._set_tool(count, line, rest, tool)
        elif word == "$BASE":
            self.state.base = None
            if mark and rest.startswith("="):
                self.state.base = frame_of(value, self.names, where)
        else:
            numbers = numbers_of_fdat(value, self.names)
            self.state.inline = True
            self.state.base = base_frame(numbers.base, self.names, where)
            self._set_tool(count, line, value, tool_data(numbers.tool, self.names, where))

    def _set_tool(self, count: int, line: str, text: str, tool: Array | None) -> None:
        """Take another tool than the one before, by the text that sets it."""
        plain = _without_spaces(text)
        if tool is not None and np.array_equal(tool, np.eye(4)):
            plain = ""
        if plain != self.state.tool:
            self.state.tool = plain
            self.listing.set_tool(count, line, tool)

    def _set_tool_by_number(self, count: int, line: str, rest: str) -> None:
        """BAS(#TOOL, n)."""
        number = self.names.number(_without_spaces(rest)[len("(#TOOL,") :].rstrip(")"))
        whole = None if number is None else int(number)
        self._set_tool(count, line, rest, tool_data(whole, self.names, f"{self.name}, line {count}"))

    def _move(self, count: int, line: str, word: str, rest: str) -> None:
        """A move to a target, which lacks values where those of the move before are kept."""
        where = f"{self.name}, line {count}"
        target, after = target_of(rest, self.names, where)
        if rest.upper().startswith(_WHERE_IT_IS) and target is Reason.VARIABLE:
            return
        base = self._base_of(count, line, after)
        if target is Reason.INCOMPLETE and rest.startswith("{"):
            target = completed(rest, self._last_in(base), base, where)
        if self.state.block == "PTP_SPLINE":
            target = Reason.SPLINE
        self._keep(count, line, _MOVES[word], in_base(target, base), after, base)

    def _arc(self, count: int, line: str, rest: str) -> None:
        """CIRC via, target: by default the tool turns about one axis from where it is to the target."""
        where = f"{self.name}, line {count}"
        via, after = place_of(rest, self.names, where)
        target, behind = target_of(after.removeprefix(",").strip(), self.names, where)
        base = self._base_of(count, line, behind)
        if target is Reason.INCOMPLETE:
            target = completed(after.removeprefix(",").strip(), self._last_in(base), base, where)
        usual = self.state.turns_behind(behind) == "CONSTANT" or self.state.turns_as_on_a_line(behind)
        if via is None or not after.startswith(",") or _CIRCULAR_ANGLE.match(behind) or not usual:
            target = Reason.CIRCLE
        if via is not None and base is not None:
            via = base[:3, :3] @ via + base[:3, 3]
        self._keep(count, line, "arc", in_base(target, base), behind, base, via)

    def _relative_move(self, count: int, line: str, word: str, rest: str) -> None:
        """A move from the target before it."""
        base = self._base_of(count, line, rest)
        last = self.last
        if last is not None and last.joints is None and self.frames[1] != self.state.tool:
            last = None  # a pose of another tool
        target, after = _relative_target(rest, last, base, f"{self.name}, line {count}")
        self._keep(count, line, _RELATIVE[word], target, after, base)

    def _base_of(self, count: int, line: str, after: str) -> Array | None:
        """The base frame of a move, which WITH may set; a tool behind WITH is taken until the move is kept."""
        settings, where = settings_of(after), f"{self.name}, line {count}"
        self.outside = self._tool_now()
        self._set_tool_behind_with(count, line, settings)
        if self.state.fixed_tool or "#TCP" in settings.get("$IPO_MODE", "").upper():
            return None
        if "$BASE" in settings:
            return frame_of(settings["$BASE"], self.names, where)
        return self.state.base

    def _last_in(self, base: Array | None) -> Target | None:
        """Where the move before ended, if it has the same base and tool."""
        before, tool = self.frames
        if self.last is None or tool != self.state.tool:
            return None
        if self.last.joints is None and (base is None or before is None or not np.array_equal(base, before)):
            return None
        return self.last

    def _keep(
        self, count: int, line: str, kind: Kind, target: Target | Reason, after: str, base: Array | None,
        via: Array | None = None,
    ) -> None:  # fmt: skip
        """Keep a move, with what stands behind its target."""
        speed = self.state.speed_of(kind, after, self.names)
        blend = any(word in after.upper() for word in _BLENDS)
        turns = self.state.turns_behind(after)
        keeps_turn = kind != "joint" and turns == "CONSTANT"
        assumed = [MoveAssumption.TURNS] * (kind != "joint" and turns not in _FOLLOWED_TURNS)
        self.listing.move(count, line, kind, target, speed, blend=blend, via=via, keeps_turn=keeps_turn,
                          assumed=assumed)  # fmt: skip
        self.last, self.frames = None, (base, self.state.tool)
        if isinstance(target, Target) and not keeps_turn:
            self.last = target
        self._back_to_tool(self.outside)

    def _tool_now(self) -> _Tool:
        return self.state.tool, self.listing.tool

    def _set_tool_behind_with(self, count: int, line: str, settings: dict[str, str]) -> None:
        """The tool behind WITH, which counts for its move or block alone."""
        text = settings.get("$TOOL")
        if text is not None:
            self._set_tool(count, line, text, tool_of(text, self.names, f"{self.name}, line {count}"))

    def _back_to_tool(self, tool: _Tool) -> None:
        """The tool that counted before a move or a block."""
        if tool[0] != self.state.tool:
            self.state.tool, self.listing.tool = tool
            self.listing.last = None

    def _block(self, count: int, line: str, word: str, rest: str) -> None:
        """SPLINE WITH …, PTP_SPLINE, ENDSPLINE: settings of a block count in it alone."""
        if word == "ENDSPLINE":
            self._back_to_tool(self.outside_block)
        self.state.begin_or_end_block(word, rest, self.names)
        if word != "ENDSPLINE":
            self.outside_block = self._tool_now()
            self._set_tool_behind_with(count, line, settings_of(rest))

    def _skip(self, count: int, line: str, reason: Reason | None) -> None:
        """Keep a line that was not read, with the reason; after some of them nobody knows where the arm is."""
        if reason is None:
            return
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
        if word in ("$OV_PRO", "$OV_ROB"):
            return Reason.OVERRIDE
        if rest.startswith("("):
            return Reason.CALL
        return Reason.OTHER


def _begins_routine(word: str, rest: str) -> bool:
    """DEF or DEFFCT, GLOBAL or not."""
    return word in ("DEF", "DEFFCT") or (word == "GLOBAL" and rest.upper().startswith("DEF"))


def _sets_frames(word: str, rest: str) -> bool:
    """Whether a statement sets the base or the tool."""
    if word == "BAS":
        return _without_spaces(rest).startswith("(#TOOL,")
    return word in ("$BASE", "FDAT_ACT", "$IPO_MODE", "$TOOL") and not _is_label(rest)


def _is_label(rest: str) -> bool:
    """Whether the first word of a line is the label of a jump: what follows it."""
    return rest.startswith(":") and not rest.startswith(":=")


def _without_spaces(text: str) -> str:
    return "".join(text.upper().split())


class _State:
    """Speeds and frames that are set for the moves that follow; a base frame that is not known is None.

    Attributes:
        line, joint: speeds.
        base: (4, 4), in the base frame of the arm.
        fixed_tool: poses are in the frame of the tool: the robot moves the part past a fixed tool.
        tool: the text that set the tool.
        block: SPLINE or PTP_SPLINE while one is open.
        inline: FDAT_ACT has set the base.
        turns: how the tool turns on lines and arcs: "VAR", about one axis to the orientation of the target, "CONSTANT",
            or "JOINT"; "" where it is not known.
        arcs: "BASE", or "PATH": the tool turns with the arc.
    """

    def __init__(self) -> None:
        self.line, self.joint = Speed(), Speed()
        self.base: Array | None = np.eye(4)
        self.fixed_tool, self.inline, self.tool, self.block = False, False, "", ""
        self.turns, self.arcs = "VAR", "BASE"
        self.axes: dict[str, float | None] = {}
        self.before: tuple[Speed, Array | None] = (self.line, self.base)

    def begin_or_end_block(self, word: str, rest: str, names: Names) -> None:
        """SPLINE WITH …, PTP_SPLINE, ENDSPLINE: settings of a block count in it alone."""
        if word == "ENDSPLINE":
            if self.block:
                self.line, self.base = self.before
            self.block = ""
            return
        self.block, self.before = word, (self.line, self.base)
        self.line = self.speed_of("line", rest, names)
        settings = settings_of(rest)
        if "$BASE" in settings:
            self.base = frame_of(settings["$BASE"], names, word)

    def takes(self, word: str, rest: str, names: Names) -> bool:
        """Whether a line sets a speed or a base: $VEL.CP = 0.1, BAS(#VEL_CP, 0.1), BAS(#BASE, 0), BAS(#INITMOV, 0)."""
        plain = _without_spaces(rest)
        if word in ("$ORI_TYPE", "$CIRC_TYPE"):
            self._set_mode(word, plain)
            return True
        if word == "LDAT_ACT":
            self.turns = turns_of_ldat(plain.removeprefix("=").upper(), names)
            return True
        if word == "$VEL":
            self._set_velocity(rest, plain, names)
            return True
        if word == "$VEL_AXIS":
            self._set_axis(plain, names)
            return True
        if word == "BAS" and plain.startswith("(#"):
            what, _, value = plain[2:].rstrip(")").partition(",")
            self._initialize(what, value, names)
            return True
        return word in _SETTINGS

    def _set_mode(self, word: str, plain: str) -> None:
        """$ORI_TYPE = #VAR, #CONSTANT or #JOINT; $CIRC_TYPE = #BASE or #PATH; another value is kept as it is."""
        value = plain.removeprefix("=").removeprefix("#")
        if word == "$ORI_TYPE":
            self.turns = value
        else:
            self.arcs = value

    def turns_behind(self, after: str) -> str:
        """How the tool turns on a move, which WITH $ORI_TYPE = … may set for it alone."""
        stated = settings_of(after).get("$ORI_TYPE")
        if stated is None:
            return self.turns
        mode = _MODE.search(stated)
        if mode is None:
            return ""
        return mode[1].upper()

    def turns_as_on_a_line(self, after: str) -> bool:
        """On an arc the tool turns about one axis from where it is to its target."""
        stated = settings_of(after).get("$CIRC_TYPE", "")
        return self.turns_behind(after) == "VAR" and self.arcs == "BASE" and "#PATH" not in stated.upper()

    def _set_velocity(self, rest: str, plain: str, names: Names) -> None:
        """$VEL.CP, of the tip, $VEL.ORI1, of the swivel, or $VEL = {CP …, ORI1 …}: what follows $VEL."""
        if plain.startswith(".CP="):
            self.line = replace(self.line, linear=positive(names.number(plain[4:])))
        elif plain.startswith(".ORI1="):
            self.line = replace(self.line, angular=positive(names.number(plain[6:]), _DEGREE))
        elif plain.startswith("="):
            values = components(rest[1:]) or {}
            self.line = Speed(linear=positive(values.get("CP")), angular=positive(values.get("ORI1"), _DEGREE))

    def _set_axis(self, plain: str, names: Names) -> None:
        """$VEL_AXIS[n] = share: known where all axes have the same."""
        element, _, value = plain.partition("=")
        self.axes[element] = names.number(value)
        shares = {self.axes.get(f"[{axis}]") for axis in range(1, 1 + len(AXES))}
        self.joint = Speed()
        if len(shares) == 1:
            self.joint = Speed(share=positive(shares.pop(), 0.01))

    def _initialize(self, what: str, value: str, names: Names) -> None:
        """BAS(#what, value)."""
        if what == "INITMOV":
            self.turns, self.arcs = "VAR", "BASE"
        if what in ("VEL_CP", "CP_PARAMS"):
            self.line = replace(self.line, linear=positive(names.number(value)))
        elif what in ("VEL_PTP", "PTP_PARAMS"):
            self.joint = Speed(share=positive(names.number(value), 0.01))
        elif what == "BASE" or (what == "FRAMES" and not self.inline):
            self.base = np.eye(4) if value == "0" else None

    def speed_of(self, kind: str, after: str, names: Names) -> Speed:
        """The speed of a move; what stands behind its target may set it: WITH $VEL.CP = 0.2, $VEL = SVEL_CP(0.2, …)."""
        speed = {"joint": self.joint}.get(kind, self.line)
        for key, value in settings_of(after).items():
            plain = _without_spaces(_IN_CALL.sub(r"\1", value).split("C_")[0])
            if kind != "joint" and key in ("$VEL.CP", "$VEL"):
                speed = replace(speed, linear=positive(names.number(plain)))
            elif kind == "joint" and key.startswith("$VEL_AXIS"):
                speed = Speed(share=positive(names.number(plain), 0.01))
        return speed


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
    values = components(rest)
    if found is None or values is None:
        return Reason.EXPRESSION, rest
    after = found[1].strip()
    if last is None:
        return Reason.RELATIVE, after
    if any(key in values for key in AXES):
        return _joints_added(values, last, where), after
    return _frame_added(values, last, base, where, in_tool="#TOOL" in after.upper()), after


def _frame_added(
    values: dict[str, float], last: Target, base: Array | None, where: str, *, in_tool: bool
) -> Target | Reason:  # fmt: skip
    """The pose that a relative move ends at; arguments as of `_relative_target`."""
    if last.pose is None:
        return Reason.RELATIVE_TO_JOINTS
    step = angle_target([values.get(key, 0.0) for key in PLACE + TURN], where).pose
    assert step is not None
    if in_tool:
        return Target(pose=last.pose @ step)
    if any(values.get(key, 0.0) for key in TURN):
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
    steps = [values.get(key, 0.0) for key in AXES + MORE_AXES]
    return joint_target([joint + step for joint, step in zip(last.joints, steps, strict=False)], where)
