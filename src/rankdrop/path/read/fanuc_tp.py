"""FANUC TP programs as listings (.ls): instructions under /MN, positions under /POS.

Lengths in mm, joint values in degrees. W, P, R turn about the fixed axes X, Y, Z in this order: R = Rz(R) Ry(P) Rx(W).
The world frame is at the height of axis 2, and J3 is counted from the horizontal. CONFIG is not evaluated.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from math import radians
from typing import Literal

import numpy as np

from rankdrop.path.read.arc import place_between, same_turn
from rankdrop.path.read.program_record import BREAKS, Language, Listing, MoveAssumption, Program, Reason, Speed, Target
from rankdrop.path.read.program_scan import check_length, lines_of, number, positive
from rankdrop.path.read.program_targets import MILLIMETRE, angle_target, in_base, joint_target
from rankdrop.robot.model import Array

_MOVES: dict[str, Literal["joint", "line"]] = {"J": "joint", "L": "line"}
_MOVE = re.compile(r"([JLCAS])\s+(@?)(P|PR)\[\s*(\d{1,6})[^\]]*\]\s*(.*)")
_ARC = re.compile(r"C\s+@?P\[\s*(\d{1,6})[^\]]*\]\s*:?\s*@?P\[\s*(\d{1,6})[^\]]*\]\s*(.*)")
_POSITION = re.compile(r"\s*P\[\s*(\d{1,6})[^\]]*\]\s*\{")
_VALUE = re.compile(r"\b([XYZWPR]|J[1-9])\s*=\s*([-+.\deE*]+)\s*(mm|deg)?")
_EXTERNAL = re.compile(r"\bE[1-6]\s*=\s*([-+.\deE*]+)")
_CONFIGURATION = re.compile(r"\bCONFIG\s*:\s*'([A-Z ]*)")
_USUAL = {"N", "U", "T"}
_FRAME = re.compile(r"\bU([FT])\s*:\s*([\dF]+)")
_SPEED = re.compile(r"\s*([\d.]+)\s*(%|mm/sec|cm/min|inch/min|deg/sec|sec|msec)")
_UNITS = {"mm/sec": MILLIMETRE, "cm/min": 1e-2 / 60.0, "inch/min": 0.0254 / 60.0, "sec": 1.0, "msec": 1e-3}
_WORDS = {**dict.fromkeys(("OFFSET", "TOOL_OFFSET", "VOFFSET", "TA_REF"), Reason.OFFSET),
          **dict.fromkeys(("SKIP", "SKIPJUMP", "TOUCHSKIP"), Reason.ENDS_EARLY),
          **dict.fromkeys(("WJNT", "RTCP", "COORD"), Reason.OTHER_MOVE)}  # fmt: skip
"""Words behind a target that say that the arm goes elsewhere: offsets, skips, wrist joint motion, a fixed tool, …"""
_FLOW = {**dict.fromkeys(("IF", "ELSE", "ENDIF", "SELECT", "JMP", "LBL"), Reason.BRANCH),
         **dict.fromkeys(("FOR", "ENDFOR"), Reason.LOOP)}  # fmt: skip
_SKIPPED = {**_FLOW, **dict.fromkeys(("CALL", "RUN"), Reason.CALL), **dict.fromkeys(("C", "A"), Reason.CIRCLE),
            "S": Reason.SPLINE, **dict.fromkeys(("J", "L"), Reason.EXPRESSION)}  # fmt: skip
_WORD = re.compile(r"[A-Za-z_]+")
_PLACE, _JOINTS = ("X", "Y", "Z", "W", "P", "R"), tuple(f"J{k}" for k in range(1, 10))
_NO_TURN = 1e-9
_REMARKS = ("!", "//", "--")


def read(text: str, name: str) -> Program:
    """A program from its listing.

    Raises:
        TrajectoryError: too large, or a value out of range.
    """
    lines = list(lines_of(text, name))
    positions, tools = _positions(lines, name)
    listing = Listing(name)
    last: Target | None = None
    for count, number_in_program, text in _instructions(lines, name):
        if text and not text.startswith(_REMARKS):
            listing.label = f"{number_in_program}:"
            last = _instruction(listing, positions, tools, count, text, last)
    return listing.program(Language.TP, raised=True, level=True)


def _instructions(lines: list[tuple[int, str]], name: str) -> Iterator[tuple[int, str, str]]:
    """The line on which each instruction begins, its number in the program, and the instruction without it.

    A line that goes on has no number.
    """
    begun, number_in_program, size, section = 0, "", 0, ""
    kept: list[str] = []
    for count, line in lines:
        if line.startswith("/"):
            section = line.split()[0].upper()
            continue
        label, colon, rest = line.partition(":")
        if section != "/MN" or not colon or label.strip(" 0123456789"):
            continue
        text = rest.strip().rstrip(";").rstrip()
        if label.strip():
            if kept:
                yield begun, number_in_program, " ".join(kept)
            begun, number_in_program, size, kept = count, label.strip(), len(text), [text]
        elif kept:
            size += len(text) + 1
            kept.append(text)
        check_length(size, f"{name}, line {begun}")
    if kept:
        yield begun, number_in_program, " ".join(kept)


def _positions(lines: list[tuple[int, str]], name: str) -> tuple[dict[str, Target | Reason], set[str]]:
    """Positions of group 1 by number, and those with a tool; poses in user frames are not read."""
    positions: dict[str, Target | Reason] = {}
    tools: set[str] = set()
    open_position: _Position | None = None
    section = ""
    for count, line in lines:
        if line.startswith("/"):
            section = line.split()[0].upper()
        if section != "/POS":
            continue
        begin = _POSITION.match(line)
        if begin:
            open_position = _Position(begin[1])
            line = line[begin.end() :]
        if open_position is None:
            continue
        open_position.take(line)
        if open_position.tool:
            tools.add(open_position.name)
        if "}" in line:
            positions[open_position.name] = open_position.target(f"{name}, line {count}")
            open_position = None
    return positions, tools


@dataclass
class _Position:
    """A position while its lines are read.

    Attributes:
        name: its number.
        group: of the joints that the lines are about.
        values: numbers of group 1 by name; None where a value is no number.
        based: it is in the base frame, not in a user frame.
        tool: it is that of a tool.
        external: values of external axes and of other groups.
        unusual: its CONFIG states another posture than N U T: not flipped, elbow up, in front.
    """

    name: str
    group: str = "1"
    values: dict[str, float | None] = field(default_factory=dict)
    based: bool = True
    tool: bool = False
    external: list[float | None] = field(default_factory=list)
    unusual: bool = False

    def take(self, line: str) -> None:
        """Read one line of the position."""
        if "GP" in line:
            self.group = line.partition("GP")[2][:1]
        if self.group != "1":
            self.external += [number(value) for _, value, _ in _VALUE.findall(line)]
            return
        self.external += [number(value) for value in _EXTERNAL.findall(line)]
        self._take_frames(line)
        self.values.update({key: number(value) for key, value, _ in _VALUE.findall(line)})

    def _take_frames(self, line: str) -> None:
        """The frames and the posture that a line states."""
        configuration = _CONFIGURATION.search(line)
        if configuration is not None:
            self.unusual = not set(configuration[1].upper().split()) <= _USUAL
        for key, value in _FRAME.findall(line):
            if key == "F" and value != "0":
                self.based = False
            if key == "T" and value != "0":
                self.tool = True

    def target(self, where: str) -> Target | Reason:
        """The target of the position; a pose in a user frame is not known."""
        made = _target(self.values, where)
        if not self.based:
            made = in_base(made, None)
        if isinstance(made, Reason):
            return made
        assumed = [MoveAssumption.CONFIGURATION] * self.unusual
        return replace(made, external=tuple(self.external), assumed=frozenset(assumed))


def _target(values: dict[str, float | None], where: str) -> Target | Reason:
    joints = [values[key] for key in _JOINTS if key in values]
    known = [value for value in joints if value is not None]
    if joints:
        if len(known) == len(joints):
            return joint_target(known, where)
        return Reason.INCOMPLETE
    place = [values.get(key) for key in _PLACE]
    numbers = [value for value in place if value is not None]
    if len(numbers) == len(_PLACE):
        return angle_target(numbers, where)
    return Reason.INCOMPLETE


def _instruction(
    listing: Listing, positions: dict[str, Target | Reason], tools: set[str], count: int, text: str,
    last: Target | None,
) -> Target | None:  # fmt: skip
    """One instruction of the program; returns where the arm is after it, None where that is not known."""
    arc = _ARC.match(text)
    if arc is not None:
        return _arc(listing, positions, tools, count, text, last, arc)
    match = _MOVE.match(text)
    if match is None:
        return _other_instruction(listing, count, text, last)
    letter, _, register, key, rest = match.groups()
    words = {word.upper() for word in re.split(r"[\s,\[(]+", rest) if word}
    target = _why_unread(letter, words) or _position(register, key, positions)
    if "INC" in words:
        target = _increased(target, last)
    kept = listing.tool
    if isinstance(target, Target) and target.pose is not None and key in tools:
        listing.set_tool(count, text, None)
    listing.move(count, text, _MOVES.get(letter, "line"), target, _speed(rest), blend="FINE" not in words)
    listing.tool = kept
    if isinstance(target, Reason):
        return None
    return target


def _arc(
    listing: Listing, positions: dict[str, Target | Reason], tools: set[str], count: int, text: str,
    last: Target | None, match: re.Match[str],
) -> Target | None:  # fmt: skip
    """C P[1] P[2] speed: read where all three positions have one orientation, on half a turn at most; returns where the
    arm is after it, None where that is not known.
    """
    between, key, rest = match.groups()
    words = {word.upper() for word in re.split(r"[\s,\[(]+", rest) if word}
    if "INC" in words:
        unread: Reason | None = Reason.RELATIVE
    else:
        unread = _why_unread("L", words)
    via = unread or positions.get(between, Reason.VARIABLE)
    target = unread or positions.get(key, Reason.VARIABLE)
    place = None
    if isinstance(target, Target):
        place = _place_on_arc(last, via, target)
        if place is None:
            target = Reason.CIRCLE
    kept = listing.tool
    if isinstance(target, Target) and key in tools:
        listing.set_tool(count, text, None)
    listing.move(count, text, "arc", target, _speed(rest), blend="FINE" not in words, via=place)
    listing.tool = kept
    if isinstance(target, Reason):
        return None
    return target


def _place_on_arc(last: Target | None, via: Target | Reason, target: Target) -> Array | None:
    """The place (3,) on the way, where the tool has one orientation in all three positions; else None."""
    if last is None or last.pose is None or target.pose is None or isinstance(via, Reason) or via.pose is None:
        return None
    if not same_turn(via.pose, target.pose):
        return None
    return place_between(last.pose, via.pose[:3, 3], target.pose)


def _other_instruction(listing: Listing, count: int, text: str, last: Target | None) -> Target | None:
    """An instruction that is no move; returns where the arm is after it, None where that is not known."""
    reason = _why_skipped(text)
    if reason is None:
        return last
    if reason is Reason.TOOL:
        listing.tool = None
    listing.skip(count, text, reason)
    if reason in BREAKS or reason is Reason.LOOP:
        return None
    return last


def _position(register: str, key: str, positions: dict[str, Target | Reason]) -> Target | Reason:
    """The target P[n]; the values of PR[n] are not in the file."""
    if register == "PR":
        return Reason.VARIABLE
    return positions.get(key, Reason.VARIABLE)


def _increased(step: Target | Reason, last: Target | None) -> Target | Reason:
    """The target of an incremental move: joint values or a shift, added to the target before."""
    if isinstance(step, Reason):
        return step
    if last is None:
        return Reason.RELATIVE
    if step.joints is not None:
        if last.joints is None or len(last.joints) != len(step.joints):
            return Reason.RELATIVE_TO_POSE
        return Target(joints=tuple(before + more for before, more in zip(last.joints, step.joints, strict=True)))
    if last.pose is None or step.pose is None:
        return Reason.RELATIVE_TO_JOINTS
    if not np.allclose(step.pose[:3, :3], np.eye(3), atol=_NO_TURN):
        return Reason.RELATIVE_TURN
    pose = last.pose.copy()
    pose[:3, 3] += step.pose[:3, 3]
    return Target(pose=pose)


def _why_unread(letter: str, words: set[str]) -> Reason | None:
    """Why the target of a move is not read: an arc, a spline, a shift of its position; None where it is."""
    if letter in ("C", "A"):
        return Reason.CIRCLE
    if letter == "S":
        return Reason.SPLINE
    return next((_WORDS[word] for word in sorted(words) if word in _WORDS), None)


def _why_skipped(text: str) -> Reason | None:
    """Why an instruction that is no move is not read; None where it means nothing for the moves."""
    word = _WORD.match(text)
    first = word[0].upper() if word else ""
    if first in ("UTOOL", "UTOOL_NUM"):
        if text.partition("=")[2].strip() == "0":
            return None
        return Reason.TOOL
    if first in ("UFRAME", "UFRAME_NUM"):
        return None
    if first == "OVERRIDE":
        return Reason.OVERRIDE
    return _SKIPPED.get(first, Reason.OTHER)


def _speed(rest: str) -> Speed:
    """100%, 250mm/sec, 4000cm/min, 2.5sec, 90deg/sec."""
    match = _SPEED.match(rest)
    if match is None:
        value = None
    else:
        value = number(match[1])
    if match is None or value is None:
        return Speed()
    unit = match[2]
    if unit == "%":
        return Speed(share=positive(value, 0.01))
    if unit == "deg/sec":
        return Speed(angular=positive(value, radians(1.0)))
    made = positive(value, _UNITS[unit])
    if unit in ("sec", "msec"):
        return Speed(time=made)
    return Speed(linear=made)
