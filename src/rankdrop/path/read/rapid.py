"""ABB RAPID (.mod, .prg): robtarget [[x,y,z],[q1,q2,q3,q4],[cf1,cf4,cf6,cfx],[external]], jointtarget.

Lengths in mm, speeds in mm/s and degrees/s, joint values in degrees; quaternions have the real part first. cf1, cf4 and
cf6 are the quarter turns of joints 1, 4 and 6; cfx is not evaluated.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import radians
from typing import Literal

import numpy as np

from rankdrop.path.read.poses import turned_by
from rankdrop.path.read.program_record import (
    MILLIMETRE,
    Language,
    Listing,
    Names,
    Posture,
    Program,
    Reason,
    Speed,
    Target,
    check_length,
    flat,
    in_base,
    joint_target,
    lines_of,
    number,
    numbers_of,
    parts_of,
    positive,
    turned_target,
    without_comment,
)
from rankdrop.path.read.trajectory import TrajectoryError

_MOVES: dict[str, Literal["joint", "line"]] = {"MOVEJ": "joint", "MOVEABSJ": "joint", "MOVEL": "line"}
_SUFFIXED = ("DO", "AO", "GO", "SYNC")
_FLOW = {
    **dict.fromkeys(("IF", "ELSE", "ELSEIF", "ENDIF", "TEST", "CASE", "DEFAULT", "ENDTEST", "GOTO", "RETURN"),
                    Reason.BRANCH),
    **dict.fromkeys(("FOR", "ENDFOR", "WHILE", "ENDWHILE"), Reason.LOOP),
}  # fmt: skip
_BLOCKS = {"IF", "ELSE", "ELSEIF", "ENDIF", "TEST", "CASE", "DEFAULT", "ENDTEST", "FOR", "ENDFOR", "WHILE", "ENDWHILE",
           "PROC", "ENDPROC", "FUNC", "ENDFUNC", "TRAP", "ENDTRAP", "MODULE", "ENDMODULE", "ERROR", "LOCAL", "UNDO",
           "BACKWARD", "RECORD", "ENDRECORD"}  # fmt: skip
"""Words that begin a line without a semicolon at its end."""
_QUIET = {"ENDPROC", "ENDFUNC", "ENDTRAP", "MODULE", "ENDMODULE", "RECORD", "ENDRECORD", "CONST", "PERS", "VAR",
          "LOCAL", "TASK", "ALIAS", "CONFJ", "CONFL", "SINGAREA", "ACCSET", "VELSET"}  # fmt: skip
_ROUTINES = ("PROC", "FUNC", "TRAP")
_SPEED = re.compile(r"v(\d{1,5})", re.IGNORECASE)
_WORD = re.compile(r"[A-Za-z_]\w*")
_DECLARED = re.compile(r"(?:LOCAL\s|TASK\s)?\s*(?:CONST|PERS|VAR)\s+\w+\s+(\w+)\s*:=(.*)", re.IGNORECASE | re.DOTALL)
_REORIENTATION = 500.0  # degrees/s of the named speeds v5 … v7000
_UNIT_LENGTH = 1e-3


def read(text: str, name: str) -> Program:
    """A module from its text.

    Raises:
        TrajectoryError: too large, or a value out of range.
    """
    names, listing = Names(), Listing(name)
    statements = list(_statements(text, name))
    for count, statement in statements:
        _declare(names, statement, f"{name}, line {count}")
    routines = 0
    for count, statement in statements:
        word, rest = _first_word(statement)
        if word is None:
            continue
        move = _move_of(word)
        if word in _ROUTINES:
            routines += 1
            if routines > 1:
                listing.skip(count, statement, Reason.ROUTINE)
        elif move is not None:
            _move(listing, names, count, statement, rest, absolute=move == "MOVEABSJ", kind=_MOVES[move])
        else:
            reason = _why_skipped(word, statement)
            if reason is not None:
                listing.skip(count, statement, reason)
    return Program(name, Language.RAPID, tuple(listing.items))


def _first_word(statement: str) -> tuple[str | None, str]:
    """The first word of a statement after LOCAL, in capitals, and what follows it; None where it begins with none."""
    first = _WORD.match(statement)
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
    if word == "ERROR":
        return Reason.BRANCH
    if word in _FLOW:
        return _FLOW[word]
    if word.startswith("MOVEC"):
        return Reason.CIRCLE
    if word.startswith(("MOVE", "TRIGG", "SEARCH", "ARC", "PAINT")):
        return Reason.OTHER_MOVE
    if word in _QUIET:
        return None
    if ":=" in statement:
        return Reason.OTHER
    return Reason.CALL


def _move_of(word: str) -> str | None:
    """MoveJ, MoveL or MoveAbsJ, also with an output (MoveLDO); None for other instructions."""
    every = [word, *(word.removesuffix(end) for end in _SUFFIXED)]
    return next((instruction for instruction in every if instruction in _MOVES), None)


def _statements(text: str, name: str) -> Iterator[tuple[int, str]]:
    """Statements with the number of the line on which each begins; they end at a semicolon, or, of blocks, a line."""
    begun, size = 0, 0
    kept: list[str] = []
    for count, line in lines_of(text, name):
        plain = without_comment(line, "!").strip()
        if plain.startswith("%%%") or not plain:
            continue
        *whole, rest = parts_of(plain, ";", brackets=False)
        for statement in whole:
            yield begun if kept else count, " ".join([*kept, statement])
            kept, size = [], 0
        first = _WORD.match(rest)
        if first is not None and not kept and first[0].upper() in _BLOCKS:
            yield count, rest
        elif rest:
            begun, size = begun if kept else count, size + len(rest) + 1
            kept.append(rest)
        check_length(size, f"{name}, line {begun}")
    if kept:
        yield begun, " ".join(kept)


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
    if not _WORD.fullmatch(base) or len(left.split()) != 1:
        return
    if base != name:
        names.changed.add(base)
        return
    names.assign(name, right, _literal(right.strip(), where))


def _literal(text: str, where: str) -> object | None:
    """A robtarget or a jointtarget as a target, a speed, a number; None for everything else."""
    if not text.startswith("["):
        return number(text)
    values = numbers_of(text)
    if values is None:
        return None
    speed = flat(values, 4)
    if speed is not None:
        return Speed(linear=positive(speed[0], MILLIMETRE), angular=positive(speed[1], radians(1.0)))
    return _target(values, where)


def _target(values: list[object], where: str) -> Target | Reason:
    """A target of the numbers in its brackets."""
    if len(values) == 2 and (joints := flat(values[0], 6)) is not None:
        return joint_target(joints, where)
    if len(values) != 4:
        return Reason.EXPRESSION
    place, turn, posture = flat(values[0], 3), flat(values[1], 4), flat(values[2], 4)
    if place is None or turn is None or posture is None:
        return Reason.EXPRESSION
    w, x, y, z = turn
    if abs(float(np.linalg.norm(turn)) - 1.0) > _UNIT_LENGTH:
        raise TrajectoryError("the quaternion is not of length one", where=where, got=f"{turn}",
                              allowed="q1, q2, q3, q4 of length 1, the real part first")  # fmt: skip
    rotation = turned_by(np.array([[x, y, z, w]]), lambda row: where)[0]
    metres = [MILLIMETRE * coordinate for coordinate in place]
    return turned_target(metres, rotation, where, Posture(quarters=_quarters(posture)))


def _quarters(configuration: list[float]) -> tuple[int, int, int] | None:
    """Quarters of a turn of axes 1, 4 and 6, the first three of a confdata; None where one is no such number (9E9)."""
    first, fourth, sixth = configuration[:3]
    if all(abs(quarters) < 100 and quarters == int(quarters) for quarters in (first, fourth, sixth)):
        return int(first), int(fourth), int(sixth)
    return None


def _move(
    listing: Listing, names: Names, count: int, one: str, rest: str, *, absolute: bool, kind: Literal["joint", "line"]
) -> None:
    """A move: [\\Conc,] target [\\ID], speed [\\V | \\T], zone [\\Z], tool [\\WObj]."""
    arguments = _arguments(rest)
    if len(arguments) < 3:
        listing.skip(count, one, Reason.EXPRESSION)
        return
    (goal, _), speed, zone, *tools = arguments
    target = _goal(goal, names, f"{listing.where}, line {count}")
    if isinstance(target, Target) and (target.joints is not None) != absolute:
        target = Reason.EXPRESSION
    tool, keys = tools[0] if tools else ("tool0", {})
    if keys.get("wobj", "wobj0").lower() != "wobj0":
        target = in_base(target, None)
    if isinstance(target, Target) and target.pose is not None and tool.lower() != "tool0":
        listing.skip(count, one, Reason.TOOL)
    made = _speed(speed[0], speed[1] | zone[1], names, kind, f"{listing.where}, line {count}")
    listing.move(count, one, kind, target, made, blend=zone[0].lower() != "fine")


def _arguments(rest: str) -> list[tuple[str, dict[str, str]]]:
    """The arguments of a move with their switches, from the target on: switches alone in front of it are left out."""
    arguments = [_split_switches(part) for part in parts_of(rest) if part]
    while arguments and not arguments[0][0]:
        arguments.pop(0)
    return arguments


def _goal(text: str, names: Names, where: str) -> Target | Reason:
    """The target of a move: a literal, or the name of one."""
    if text.startswith("["):
        values = numbers_of(text)
        if values is None:
            return Reason.EXPRESSION
        return _target(values, where)
    if text == "*":
        return Reason.VARIABLE
    if _WORD.fullmatch(text):
        return names.target(text.lower())
    return Reason.EXPRESSION


def _split_switches(part: str) -> tuple[str, dict[str, str]]:
    """An argument, and the optional ones behind it: v100\\V:=50 -> ("v100", {"v": "50"})."""
    value, *switches = parts_of(part, "\\")
    keys = (switch.partition(":=") for switch in switches)
    return value.strip(), {key.strip().lower(): text.strip() for key, _, text in keys}


def _speed(text: str, keys: dict[str, str], names: Names, kind: str, where: str) -> Speed:
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
        speed = _literal(text, where)
    else:
        speed = names.literals.get(name)
    if speed is None and named is not None:
        speed = Speed(linear=positive(float(named[1]), MILLIMETRE), angular=radians(_REORIENTATION))
    if isinstance(speed, Speed) and name not in names.changed:
        made = speed
    else:
        made = Speed()
    if "v" in keys:
        return Speed(linear=positive(names.number(keys["v"].lower()), MILLIMETRE), angular=made.angular)
    return made
