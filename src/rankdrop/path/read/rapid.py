"""ABB RAPID (.mod, .prg): robtarget [[x,y,z],[q1,q2,q3,q4],[cf1,cf4,cf6,cfx],[external]], jointtarget.

Lengths in mm, speeds in mm/s and degrees/s, joint values in degrees; quaternions have the real part first. cf1, cf4 and
cf6 are the quarter turns of joints 1, 4 and 6; cfx is not evaluated.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import radians

from rankdrop.path.read.arc import place_between
from rankdrop.path.read.program_record import (
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
from rankdrop.path.read.program_scan import check_length, lines_of, number, parts_of, positive, without_comment
from rankdrop.path.read.program_targets import MILLIMETRE, in_base
from rankdrop.path.read.rapid_values import WORD, goal_of, literal, split_switches, tool_frame, work_object
from rankdrop.robot.model import Array

_MOVES: dict[str, Kind] = {"MOVEJ": "joint", "MOVEABSJ": "joint", "MOVEL": "line", "MOVEC": "arc"}
_SUFFIXED = ("DO", "AO", "GO", "SYNC")
_FLOW = {
    **dict.fromkeys(("IF", "ELSE", "ELSEIF", "ENDIF", "TEST", "CASE", "DEFAULT", "ENDTEST", "GOTO", "RETURN", "ERROR"),
                    Reason.BRANCH),
    **dict.fromkeys(("FOR", "ENDFOR", "WHILE", "ENDWHILE"), Reason.LOOP),
}  # fmt: skip
_BLOCKS = {"IF", "ELSE", "ELSEIF", "ENDIF", "TEST", "CASE", "DEFAULT", "ENDTEST", "FOR", "ENDFOR", "WHILE", "ENDWHILE",
           "PROC", "ENDPROC", "FUNC", "ENDFUNC", "TRAP", "ENDTRAP", "MODULE", "ENDMODULE", "ERROR", "LOCAL", "UNDO",
           "BACKWARD", "RECORD", "ENDRECORD"}  # fmt: skip
"""Words that begin a line without a semicolon at its end."""
_QUIET = {"ENDPROC", "ENDFUNC", "ENDTRAP", "MODULE", "ENDMODULE", "RECORD", "ENDRECORD", "CONST", "PERS", "VAR",
          "LOCAL", "TASK", "ALIAS", "CONFJ", "ACCSET"}  # fmt: skip
_MODES = ("SINGAREA", "CONFL")
_DISPLACEMENTS = {"PDISPON": True, "PDISPSET": True, "PDISPOFF": False}
_INSTRUCTIONS = {"ADD", "CLEAR", "INCR", "DECR", "SET", "RESET", "SETDO", "SETGO", "SETAO", "INVERTDO", "PULSEDO",
                 "WAITTIME", "WAITDI", "WAITDO", "WAITGI", "WAITGO", "WAITAI", "WAITAO", "WAITUNTIL", "WAITROB",
                 "TPERASE", "TPWRITE", "TPREADNUM", "TPREADFK", "TPSHOW", "STOP", "EXIT", "EXITCYCLE", "BREAK",
                 "CLKSTART", "CLKSTOP", "CLKRESET", "OPEN", "CLOSE", "WRITE", "WRITEBIN", "ACTUNIT", "DEACTUNIT",
                 "SOFTACT", "SOFTDEACT", "MOTIONSUP", "GRIPLOAD", "PATHACCLIM", "WORLDACCLIM", "CONNECT", "ISIGNALDI",
                 "IDELETE", "IENABLE", "IDISABLE", "EOFFSON", "EOFFSOFF", "EOFFSSET", "PDISPON", "PDISPSET", "PDISPOFF",
                 "STOPMOVE", "STARTMOVE", "RESTOPATH", "STOREPATH", "CLEARPATH", "SPEEDREFRESH", "RAISE", "TRYNEXT",
                 "RETRY", "UIMSGBOX", "ERRWRITE"}  # fmt: skip
"""Instructions that are no calls of routines."""
_HEADER = re.compile(r"%%%|(?:VERSION|LANGUAGE)\s*:", re.IGNORECASE)
_MOVE_WORD = re.compile(
    r"\b(?:Move(?:[JLC]|AbsJ|ExtJ)|(?:Trigg|Search|Arc|Paint)[JLC])\w*\s+(?![-=<>:)+*/]|THEN\b|DO\b|AND\b|OR\b)",
    re.IGNORECASE,
)
_ROUTINES = ("PROC", "FUNC", "TRAP")
_SPEED = re.compile(r"v(\d{1,5})", re.IGNORECASE)
_DECLARED = re.compile(r"(?:LOCAL\s|TASK\s)?\s*(?:CONST|PERS|VAR)\s+\w+\s+(\w+)\s*:=(.*)", re.IGNORECASE | re.DOTALL)
_REORIENTATION = 500.0  # degrees/s of the named speeds v5 … v7000


def read(text: str, name: str) -> Program:
    """A module from its text.

    Raises:
        TrajectoryError: too large, or a value out of range.
    """
    names, listing = Names(), Listing(name, checks_arrival=True)
    statements = list(_statements(text, name))
    for count, statement in statements:
        _declare(names, statement, f"{name}, line {count}")
    routines, shifted = 0, False
    for count, statement in statements:
        word, rest = _first_word(statement)
        if word is None:
            if statement.startswith("%"):  # a routine by its name in a text
                listing.skip(count, statement, Reason.CALL)
            continue
        if word in _ROUTINES:
            routines += 1
            if routines > 1:
                listing.skip(count, statement, Reason.ROUTINE)
        elif _move_of(word) is not None:
            _any_move(listing, names, count, statement, word, rest, shifted=shifted)
        elif word in _MODES:
            _set_mode(listing, word, rest.upper())
        else:
            shifted = _DISPLACEMENTS.get(word, shifted)
            reason = _why_skipped(word, statement)
            if reason is not None:
                listing.skip(count, statement, reason)
    return listing.program(Language.RAPID)


def _set_mode(listing: Listing, word: str, switches: str) -> None:
    """SingArea \\Wrist, \\LockAxis4: near a singularity the tool turns off its line; \\Off: it does not. ConfL: lines
    have to end in the configurations of their targets; \\Off: they need not.
    """
    off = "\\OFF" in switches
    if word == "CONFL":
        listing.checks_arrival = not off
    elif off:
        listing.assumed.discard(MoveAssumption.WRIST)
    else:
        listing.assumed.add(MoveAssumption.WRIST)


def _first_word(statement: str) -> tuple[str | None, str]:
    """The first word of a statement after LOCAL, in capitals, and what follows it; None where it begins with none."""
    first = WORD.match(statement)
    if first is None:
        return None, ""
    word, rest = first[0].upper(), statement[first.end() :].strip()
    if word == "LOCAL":
        word, _, rest = rest.partition(" ")
        word = word.upper()
    return word, rest


def _why_skipped(word: str, statement: str) -> Reason | None:
    """Why a statement that is no move is not read; None where it says nothing about the path.

    Args:
        word: its first, in capitals.
        statement: the whole of it.
    """
    if statement[len(word) :].lstrip().startswith(":="):
        return Reason.OTHER
    if word in _FLOW:
        return _FLOW[word]
    if word.startswith(("MOVE", "TRIGG", "SEARCH", "ARC", "PAINT")):
        return Reason.OTHER_MOVE
    if word in _QUIET:
        return None
    if word == "VELSET":
        share = number(statement[len(word) :].partition(",")[0])
        return {100.0: None}.get(share or 0.0, Reason.OVERRIDE)
    if ":=" in statement or word in _INSTRUCTIONS:
        return Reason.OTHER
    return Reason.CALL


def _move_of(word: str) -> str | None:
    """MoveJ, MoveL, MoveC or MoveAbsJ, also with an output (MoveLDO); None for other instructions."""
    every = [word, *(word.removesuffix(end) for end in _SUFFIXED)]
    return next((instruction for instruction in every if instruction in _MOVES), None)


def _statements(text: str, name: str) -> Iterator[tuple[int, str]]:
    """Statements with the number of the line on which each begins; they end at a semicolon, or, of blocks, a line."""
    begun, size = 0, 0
    kept: list[str] = []
    for count, line in lines_of(text, name):
        plain = without_comment(line, "!").strip()
        if not plain or _HEADER.match(plain):
            continue
        *whole, rest = parts_of(plain, ";", brackets=False)
        for statement in whole:
            begun = begun * bool(kept) or count
            yield from ((begun, part) for part in _parts_of_block(" ".join([*kept, statement])))
            kept, size = [], 0
        first = WORD.match(rest)
        if first is not None and not kept and first[0].upper() in _BLOCKS:
            yield count, rest
        elif rest:
            begun, size = begun * bool(kept) or count, size + len(rest) + 1
            kept.append(rest)
        check_length(size, f"{name}, line {begun}")
    if kept:
        yield begun, " ".join(kept)


def _parts_of_block(statement: str) -> list[str]:
    """IF … THEN MoveL …, CASE 1: MoveL …: the beginning of the block and the move are two statements.

    A move behind IF without THEN is followed by the beginning again: the branch ends there.
    """
    first, move = WORD.match(statement), _MOVE_WORD.search(statement)
    if first is None or first[0].upper() not in _BLOCKS or move is None:
        return [statement]
    head = statement[: move.start()].strip()
    if head.count('"') % 2 or not head or first[0].upper() == "LOCAL":
        return [statement]
    if first[0].upper() == "IF" and not head.upper().endswith("THEN"):
        return [head, statement[move.start() :], head]
    return [head, statement[move.start() :]]


def _declare(names: Names, text: str, where: str) -> None:
    """Take in a declaration or an assignment; one to a component of a name changes it."""
    match = _DECLARED.fullmatch(text)
    if match:
        left, mark, right = (match[1], ":=", match[2])
    else:
        left, mark, right = text.partition(":=")
    if not mark:
        return
    name = left.strip().lower()
    base = name.partition(".")[0].partition("{")[0]
    if not WORD.fullmatch(base) or len(left.split()) != 1:
        return
    if base != name:
        names.changed.add(base)
        return
    names.assign(name, right, literal(right.strip(), where))


def _move(
    listing: Listing, names: Names, count: int, one: str, rest: str, *, absolute: bool, kind: Kind,
    shifted: bool,
) -> None:  # fmt: skip
    """A move: [\\Conc,] target [\\ID], speed [\\V | \\T], zone [\\Z], tool [\\WObj]."""
    arguments = _arguments(rest)
    if len(arguments) < 3:
        listing.skip(count, one, Reason.EXPRESSION)
        return
    (goal, _), speed, zone, *tools = arguments
    target = goal_of(goal, names, f"{listing.where}, line {count}")
    if isinstance(target, Target) and (target.joints is not None) != absolute:
        target = Reason.EXPRESSION
    tool, keys = (tools or [("tool0", {})])[0]
    target = in_base(target, work_object(keys.get("wobj", "wobj0"), names))
    if shifted and isinstance(target, Target) and target.pose is not None:
        target = Reason.SHIFTED
    if not absolute or kind == "line":
        listing.set_tool(count, one, tool_frame(tool, names))
    pace = _speed(speed[0], speed[1] | zone[1], names, kind, f"{listing.where}, line {count}")
    listing.move(count, one, kind, target, pace, blend=zone[0].lower() != "fine")


def _any_move(
    listing: Listing, names: Names, count: int, one: str, word: str, rest: str, *, shifted: bool
) -> None:  # fmt: skip
    """MoveJ, MoveAbsJ, MoveL or MoveC, by the first word."""
    instruction = _move_of(word) or word
    if instruction == "MOVEC":
        _arc(listing, names, count, one, rest, shifted=shifted)
        return
    absolute = instruction == "MOVEABSJ"
    _move(listing, names, count, one, rest, absolute=absolute, kind=_MOVES[instruction], shifted=shifted)


def _arc(listing: Listing, names: Names, count: int, one: str, rest: str, *, shifted: bool) -> None:
    """MoveC via, target, speed, zone, tool: read where the tool keeps its orientation, on half a turn at most.

    How the tool turns on an arc depends on settings; by all of them it does not where it is the same at both ends.
    """
    arguments = _arguments(rest)
    if len(arguments) < 4:
        listing.skip(count, one, Reason.EXPRESSION)
        return
    (between, _), (goal, _), speed, zone, *tools = arguments
    where = f"{listing.where}, line {count}"
    tool, keys = (tools or [("tool0", {})])[0]
    base = work_object(keys.get("wobj", "wobj0"), names)
    via, target = (in_base(goal_of(text, names, where), base) for text in (between, goal))
    listing.set_tool(count, one, tool_frame(tool, names))
    place = None
    if isinstance(target, Target):
        place = _arc_place(listing.last, via, target)
        if shifted:
            target = Reason.SHIFTED
        elif place is None:
            target = Reason.CIRCLE
    pace = _speed(speed[0], speed[1] | zone[1], names, "arc", where)
    listing.move(count, one, "arc", target, pace, blend=zone[0].lower() != "fine", via=place)


def _arc_place(last: Target | None, via: Target | Reason, target: Target) -> Array | None:
    """The place (3,) of an arc between its ends; None where the tool turns on it, or it is longer than half a turn."""
    if last is None or last.pose is None or target.pose is None or isinstance(via, Reason) or via.pose is None:
        return None
    return place_between(last.pose, via.pose[:3, 3], target.pose)


def _arguments(rest: str) -> list[tuple[str, dict[str, str]]]:
    """The arguments of a move with their switches, from the target on: switches alone in front of it are left out."""
    arguments = [split_switches(part) for part in parts_of(rest) if part]
    while arguments and not arguments[0][0]:
        arguments.pop(0)
    return arguments


def _speed(text: str, keys: dict[str, str], names: Names, kind: Kind, where: str) -> Speed:
    """The speed of a move: v100, [100, 500, 5000, 1000], a declared name; \\V and \\T in its place.

    A joint move is given the speed of its tip, which does not say how fast its joints turn.
    """
    if "t" in keys:
        return Speed(time=positive(names.number(keys["t"].lower())))
    if kind == "joint":
        return Speed()
    name = text.lower()
    named = _SPEED.fullmatch(name)
    if text.startswith("["):
        speed = literal(text, where)
    else:
        speed = names.literals.get(name)
    if speed is None and named is not None:
        speed = Speed(linear=positive(float(named[1]), MILLIMETRE), angular=radians(_REORIENTATION))
    if isinstance(speed, Speed) and name not in names.changed:
        pace = speed
    else:
        pace = Speed()
    if "v" in keys:
        return Speed(linear=positive(names.number(keys["v"].lower()), MILLIMETRE), angular=pace.angular)
    return pace
