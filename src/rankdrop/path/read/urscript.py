"""URScript (.script): movej, movel, movep, movec to joint lists [rad] or poses p[x, y, z, rx, ry, rz].

A statement goes on over the next lines while a bracket is open. Lengths in metres; rx, ry, rz is the rotation vector:
its direction is the axis, its length the angle in radians.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import radians

import numpy as np

from rankdrop.path.read.program_record import Kind, Language, Listing, Names, Posture, Program, Reason, Speed, Target
from rankdrop.path.read.program_scan import flat, number, numbers_of, parts_of, positive, split_bracket, statements_of
from rankdrop.path.read.program_targets import in_range, joint_target, turned_target
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.poses.inverse import rotation
from rankdrop.robot.files import LARGEST_ANGLE
from rankdrop.robot.model import Array
from rankdrop.text.path_files import TWO_TURNS
from rankdrop.text.words import MOST_TURNS

_MOVES: dict[str, Kind] = {"movej": "joint", "movel": "line", "movep": "line", "movec": "arc"}
_ORDER = {"movej": ("a", "v", "t", "r"), "movel": ("a", "v", "t", "r"), "movep": ("a", "v", "r"),
          "movec": ("a", "v", "r", "mode")}  # fmt: skip
_OTHER = ("servoj", "servoc", "speedj", "speedl", "force_mode", "freedrive_mode", "teach_mode", "path_offset_enable",
          "conveyor_pulse_decode", "optimovej", "optimovel")  # fmt: skip
_FLOW = {**dict.fromkeys(("if", "elif", "else", "return"), Reason.BRANCH),
         **dict.fromkeys(("while", "for", "break", "continue"), Reason.LOOP)}  # fmt: skip
_BEGINS = ("def", "sec", "thread", "end", "global", "local", *_MOVES, *_FLOW)
"""Words that begin a statement and stand in no bracket."""
_QUIET = ("end", "textmsg", "sleep", "sync", "stopj", "stopl")
_SKIPPED = {**dict.fromkeys(_OTHER, Reason.OTHER_MOVE), **_FLOW}
_BUILT_IN = ("set_", "popup", "write_", "rtde_", "modbus_", "socket_", "request_", "halt", "pause", "zero_ftsensor",
             "reset_", "step_back", "enter_critical", "exit_critical")  # fmt: skip
"""Beginnings of functions of the language that do not move the arm."""
_FUNCTION = re.compile(r"(pose_trans|get_inverse_kin)\s*(?=\()")
_TARGET_KEY = re.compile(r"\s*(?:q|x|qnear|pose|pose_via|pose_to)\s*=\s*")
_D2R = re.compile(r"\bd2r\(([^()]{1,60})\)")
_DEEPEST = 4  # functions inside functions
_FARTHEST = 10.0  # a length beyond it is in millimetres [m]
_ARGUMENTS = 3  # that are read: a third one makes the function one that is not known
_WORD = re.compile(r"\s*([A-Za-z_]\w*)")
_NAME = re.compile(r"[A-Za-z_]\w*")


def read(text: str, name: str) -> Program:
    """A script from its text.

    Raises:
        TrajectoryError: too large, or a value out of range.
    """
    names, listing = Names(), Listing(name)
    lines = list(_statements(text, name))
    for count, line in lines:
        _declare(names, line, f"{name}, line {count}")
    listing.tool = _tool_at_first(lines)
    routines = 0
    for count, line in lines:
        first = _WORD.match(line)
        if first is None:
            continue
        word, rest = first[1], line[first.end() :].strip()
        if word in ("def", "sec", "thread"):
            routines += 1
            if routines > 1:
                listing.skip(count, line, Reason.ROUTINE)
        elif word in _MOVES:
            _move(listing, names, count, line, word, rest)
        elif word == "set_tcp":
            listing.set_tool(count, line, _tool(rest, names, f"{name}, line {count}"))
        else:
            reason = _why_skipped(word, rest, names)
            if reason is not None:
                listing.skip(count, line, reason)
    return listing.program(Language.URSCRIPT, degrees=False)


def _tool_at_first(lines: list[tuple[int, str]]) -> Array | None:
    """(4, 4) the tool before the first set_tcp: that of the installation; None: another one is set later, so that it is
    none that everything is programmed in.
    """
    if any(line.lstrip().startswith("set_tcp") for _, line in lines):
        return None
    return np.eye(4)


def _tool(rest: str, names: Names, where: str) -> Array | None:
    """(4, 4) of set_tcp(pose), with a name for the tool behind it or not; None: not known."""
    bracket = split_bracket(rest)
    target = _target(parts_of((bracket or ("", ""))[0])[0], names, where)
    if isinstance(target, Target):
        return target.pose
    return None


def _statements(text: str, name: str) -> Iterator[tuple[int, str]]:
    """Statements without comments, with the number of the line on which each begins."""
    return statements_of(text, name, "#", _begins_statement)


def _begins_statement(line: str) -> bool:
    """Whether a line begins with a word that stands in no bracket."""
    first = _WORD.match(line)
    return first is not None and first[1] in _BEGINS


def _why_skipped(word: str, rest: str, names: Names) -> Reason | None:
    """Why a line that is no move is not read; None where it means nothing for the moves."""
    if word in _SKIPPED:
        return _SKIPPED[word]
    if word in _QUIET:
        return None
    if rest.startswith("("):
        return {True: Reason.OTHER}.get(word.startswith(_BUILT_IN), Reason.CALL)
    if "=" not in rest or word in ("global", "local"):
        return None
    if word in names.literals and word not in names.changed:
        return None
    return Reason.OTHER


def _declare(names: Names, line: str, where: str) -> None:
    """Take in an assignment; one to an element of a name changes it."""
    assignment = _assignment(line)
    if assignment is None:
        return
    name, right = assignment
    base = name.partition("[")[0]
    if not _NAME.fullmatch(base):
        return
    if base != name:
        names.changed.add(base)
        return
    literal: object | None = number(right)
    if right.startswith(("[", "p[")) or _FUNCTION.match(right):
        target = _target(right, names, where)
        if isinstance(target, Target):
            literal = target
        else:
            literal = None
    names.assign(name, right, literal)


def _assignment(line: str) -> tuple[str, str] | None:
    """What stands left of the equals sign, without global or local, and right of it; None for other lines."""
    words, mark, right = line.partition("=")
    left = words.split()
    if not mark or right.startswith("=") or not left or left[0] in _FLOW:
        return None
    *scope, name = left
    if scope not in ([], ["global"], ["local"]):
        return None
    return name, right.strip()


def _target(text: str, names: Names, where: str, depth: int = 0) -> Target | Reason:
    """A list of joints, a pose, the name of one, pose_trans of two poses, or get_inverse_kin of a pose."""
    if _NAME.fullmatch(text):
        return names.target(text)
    function = _FUNCTION.match(text)
    if function is not None and depth < _DEEPEST:
        return _of_function(function[1], text[function.end() :], names, where, depth + 1)
    posed = text.startswith("p[")
    values = numbers_of(_D2R.sub(_radians, text[1:] if posed else text))
    if values is None:
        return Reason.EXPRESSION
    if not posed:
        joints = flat(values, len(values))
        if joints is None:
            return Reason.EXPRESSION
        return joint_target(joints, where)
    numbers = flat(values, 6)
    if numbers is None:
        return Reason.EXPRESSION
    in_range(numbers[3:], LARGEST_ANGLE, where, "angle")
    return turned_target(numbers[:3], rotation(np.array([numbers[3:]]))[0], where)


def _radians(match: re.Match[str]) -> str:
    """d2r(90) as a number; as it is where its argument is none."""
    value = number(match[1])
    if value is None:
        return match[0]
    return repr(radians(value))


def _of_function(function: str, text: str, names: Names, where: str, depth: int) -> Target | Reason:
    """The target of a function of targets, with its arguments in brackets."""
    bracket = split_bracket(text)
    if bracket is None or bracket[1].strip():
        return Reason.EXPRESSION
    targets = [_target(_without_key(part), names, where, depth) for part in parts_of(bracket[0])[:_ARGUMENTS]]
    known = [target for target in targets if isinstance(target, Target)]
    if len(known) < len(targets):
        return next(target for target in targets if isinstance(target, Reason))
    if function == "pose_trans":
        return _chained(known, where)
    return _inverse(known)


def _chained(targets: list[Target], where: str) -> Target | Reason:
    """pose_trans(p1, p2): T = T1 T2."""
    poses = [target.pose for target in targets if target.pose is not None]
    if len(poses) != 2 or len(targets) != 2:
        return Reason.EXPRESSION
    chained = poses[0] @ poses[1]
    return turned_target(chained[:3, 3].tolist(), chained[:3, :3], where)


def _inverse(targets: list[Target]) -> Target | Reason:
    """get_inverse_kin(pose, qnear): a joint target, read as its pose and what its solution is nearest to."""
    goal, *near = targets
    if goal.pose is None or len(near) > 1 or any(target.joints is None for target in near):
        return Reason.EXPRESSION
    return Target(pose=goal.pose, posture=Posture(near=next((target.joints for target in near), None)))


def _move(listing: Listing, names: Names, count: int, line: str, word: str, rest: str) -> None:
    """movej(target, a = 1.4, v = 1.05, t = 0, r = 0), its settings in this order or by name; movec(via, target, …)."""
    bracket = split_bracket(rest)
    if bracket is None:
        listing.skip(count, line, Reason.EXPRESSION)
        return
    goal, *arguments = parts_of(bracket[0])
    where = f"{listing.where}, line {count}"
    via: Array | None = None
    if word == "movec":
        via = _place(_target(_without_key(goal), names, where))
        goal, *arguments = arguments or [""]
    keys = _settings(word, arguments, names)
    target = _target(_without_key(goal), names, where)
    if word == "movec" and (via is None or keys.get("mode", 0.0) != 0.0):
        target = Reason.CIRCLE
    if isinstance(target, Target):
        _check_units(target, where)
    rounded = keys.get("r", 0.0) != 0.0
    listing.move(count, line, _MOVES[word], target, _speed_of(word, keys), blend=rounded, via=via)


def _check_units(target: Target, where: str) -> None:
    """Refuse a target of a move that is in degrees or millimetres; the language has radians and metres.

    Raises:
        TrajectoryError: a joint value is above two turns, or a length above `_FARTHEST`.
    """
    far = [value for value in target.joints or () if abs(value) > MOST_TURNS]
    if far:
        raise TrajectoryError("joint values look like degrees", where=where, got=f"{far[0]:g}",
                              allowed=TWO_TURNS, mend=f"write them in radians: d2r({far[0]:g})")  # fmt: skip
    if target.pose is not None and np.abs(target.pose[:3, 3]).max() > _FARTHEST:
        length = float(np.abs(target.pose[:3, 3]).max())
        raise TrajectoryError("lengths look like millimetres", where=where, got=f"{length:g} m",
                              allowed=f"metres, at most {_FARTHEST:g}", mend="write them in metres")  # fmt: skip


def _settings(word: str, arguments: list[str], names: Names) -> dict[str, float | None]:
    """The settings of a move by name, in the order of the language or by name; None: not known."""
    settings: dict[str, str] = {}
    for place, argument in enumerate(arguments):
        key, mark, value = argument.partition("=")
        if mark:
            settings[key.strip()] = value.strip()
        else:
            settings[(*_ORDER[word], "", "", "", "")[min(place, 3)]] = argument
    return {key: names.number(value) for key, value in settings.items()}


def _speed_of(word: str, keys: dict[str, float | None]) -> Speed:
    """The speed of a move: of the joint that leads, or of the tip."""
    time, rate = positive(keys.get("t")), positive(keys.get("v"))
    if word == "movej":
        return Speed(time=time, joint=rate)
    return Speed(time=time, linear=rate)


def _without_key(goal: str) -> str:
    """A target without the name of its argument: q=, pose=, pose_via=, qnear=."""
    key = _TARGET_KEY.match(goal)
    if key is None:
        return goal
    return goal[key.end() :]


def _place(target: Target | Reason) -> Array | None:
    """The place (3,) of a pose [m]; None for all else."""
    if isinstance(target, Target) and target.pose is not None:
        return target.pose[:3, 3]
    return None
