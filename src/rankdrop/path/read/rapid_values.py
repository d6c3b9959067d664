"""Values of RAPID: robtarget, jointtarget, speeddata, tooldata, wobjdata; Offs and RelTool; switches of arguments.

Lengths in mm, angles in degrees; quaternions have the real part first.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from math import radians

import numpy as np

from rankdrop.path.read.poses import turned_by
from rankdrop.path.read.program_record import Names, Posture, Reason, Speed, Target
from rankdrop.path.read.program_scan import flat, number, numbers_of, parts_of, positive, split_bracket
from rankdrop.path.read.program_targets import MILLIMETRE, angle_target, joint_target, turned_target
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.robot.model import Array

WORD = re.compile(r"[A-Za-z_]\w*")
_UNIT_LENGTH = 1e-3
_UNUSED = 8.9e9  # of an external axis, and above
_FUNCTION = re.compile(r"(Offs|RelTool)\s*(?=\()", re.IGNORECASE)
_DEEPEST = 4  # functions inside functions
_TURNS = ("rx", "ry", "rz")
_FIXED_FRAME = ["FALSE", "TRUE"]  # the object is not held by the robot, and its user frame does not move


def literal(text: str, where: str) -> object | None:
    """A robtarget or jointtarget as a target, a speed, a tool, a work object as (4, 4), a number; None for all else."""
    if not text.startswith("["):
        return number(text)
    values = numbers_of(text)
    if values is None:
        return _tool_data(text, where) or _work_object(text, where)
    speed = flat(values, 4)
    if speed is not None:
        return Speed(linear=positive(speed[0], MILLIMETRE), angular=positive(speed[1], radians(1.0)))
    return _target(values, where)


def _target(values: list[object], where: str) -> Target | Reason:
    """A target of the numbers in its brackets."""
    external = _external_axes(values[-1])
    if len(values) == 2 and (joints := flat(values[0], 6)) is not None:
        return replace(joint_target(joints, where), external=external)
    if len(values) != 4:
        return Reason.EXPRESSION
    place, turn, posture = flat(values[0], 3), flat(values[1], 4), flat(values[2], 4)
    if place is None or turn is None or posture is None:
        return Reason.EXPRESSION
    rotation = _rotation(turn, where)
    metres = [MILLIMETRE * coordinate for coordinate in place]
    target = turned_target(metres, rotation, where, Posture(quarters=_quarters(posture)))
    return replace(target, external=external)


def _external_axes(values: object) -> tuple[float | None, ...]:
    """The values of external axes; None: not used, 9E9."""
    axes: list[float | None] = []
    for value in flat(values, 6) or []:
        if value < _UNUSED:
            axes.append(value)
        else:
            axes.append(None)
    return tuple(axes)


def _rotation(turn: list[float], where: str) -> Array:
    """(3, 3) of a quaternion, the real part first.

    Raises:
        TrajectoryError: it is not of length one.
    """
    w, x, y, z = turn
    if abs(float(np.linalg.norm(turn)) - 1.0) > _UNIT_LENGTH:
        raise TrajectoryError("the quaternion is not of length one", where=where, got=f"{turn}",
                              allowed="q1, q2, q3, q4 of length 1, the real part first")  # fmt: skip
    return np.asarray(turned_by(np.array([[x, y, z, w]]), lambda row: where)[0])


def _work_object(text: str, where: str) -> Array | None:
    """(4, 4) the object frame of wobjdata [robhold, ufprog, ufmec, uframe, oframe] in the base; None: it is none, or it
    moves.
    """
    parts = _parts_in_bracket(text)
    if len(parts) != 5 or [part.upper() for part in parts[:2]] != _FIXED_FRAME:
        return None
    user, object_frame = (_frame(part, where) for part in parts[3:])
    if user is None or object_frame is None:
        return None
    return user @ object_frame


def _parts_in_bracket(text: str) -> list[str]:
    """What stands between commas in a bracket […]; nothing where there is none."""
    bracket = split_bracket(text, "[")
    if bracket is None:
        return []
    return parts_of(bracket[0])


@dataclass(frozen=True, eq=False)
class ToolData:
    """The frame (4, 4) of a tool that the robot holds, at the flange [m]."""

    frame: Array


def _tool_data(text: str, where: str) -> ToolData | None:
    """tooldata [robhold, tframe, tload]; None: it is none, or the robot does not hold it."""
    parts = _parts_in_bracket(text)
    if len(parts) != 3 or parts[0].upper() != "TRUE":
        return None
    frame = _frame(parts[1], where)
    if frame is None:
        return None
    return ToolData(frame)


def tool_frame(name: str, names: Names) -> Array | None:
    """(4, 4) the frame of a tool at the flange; None: not known."""
    plain = name.lower()
    if plain == "tool0":
        return np.eye(4)
    found = names.literals.get(plain)
    if isinstance(found, ToolData) and plain not in names.changed:
        return found.frame
    return None


def _frame(text: str, where: str) -> Array | None:
    """(4, 4) of [[x, y, z], [q1, q2, q3, q4]]; None where it is none."""
    values = numbers_of(text) or []
    if len(values) < 2:
        return None
    place, turn = flat(values[0], 3), flat(values[1], 4)
    if place is None or turn is None:
        return None
    return turned_target([MILLIMETRE * value for value in place], _rotation(turn, where), where).pose


def work_object(name: str, names: Names) -> Array | None:
    """(4, 4) the frame of a work object in the base of the arm; None: not known."""
    plain = name.lower()
    if plain == "wobj0":
        return np.eye(4)
    found = names.literals.get(plain)
    if isinstance(found, np.ndarray) and plain not in names.changed:
        return found
    return None


def _quarters(configuration: list[float]) -> tuple[int, int, int] | None:
    """Quarters of a turn of axes 1, 4 and 6, the first three of a confdata; None where one is no such number (9E9)."""
    first, fourth, sixth = configuration[:3]
    if all(abs(quarters) < 100 and quarters == int(quarters) for quarters in (first, fourth, sixth)):
        return int(first), int(fourth), int(sixth)
    return None


def goal_of(text: str, names: Names, where: str, depth: int = 0) -> Target | Reason:
    """The target of a move: a literal, the name of one, or Offs or RelTool of these."""
    if text.startswith("["):
        values = numbers_of(text)
        if values is None:
            return Reason.EXPRESSION
        return _target(values, where)
    function = _FUNCTION.match(text)
    if function is not None:
        if depth == _DEEPEST:
            return Reason.EXPRESSION
        return _moved_target(function[1].lower(), text[function.end() :], names, where, depth + 1)
    if text == "*":
        return Reason.VARIABLE
    if WORD.fullmatch(text):
        return names.target(text.lower())
    return Reason.EXPRESSION


def _moved_target(function: str, text: str, names: Names, where: str, depth: int) -> Target | Reason:
    """Offs(p, x, y, z): p + (x, y, z) in the axes of the object; RelTool(p, x, y, z\\Rx\\Ry\\Rz): T ΔT in those of
    the tool, ΔT = Trans(x, y, z) Rx Ry Rz.
    """
    bracket = split_bracket(text)
    if bracket is None or bracket[1].strip():
        return Reason.EXPRESSION
    first, *shift = (split_switches(part) for part in parts_of(bracket[0]))
    target = goal_of(first[0], names, where, depth)
    if isinstance(target, Reason):
        return target
    if target.pose is None or len(shift) != len(_TURNS):
        return Reason.OFFSET
    keys = shift[-1][1]  # switches stand behind the last length
    written = [*(value for value, _ in shift), *(keys.get(key, "0") for key in _TURNS)]
    known = [value for text in written if (value := names.number(text.lower())) is not None]
    if len(known) < len(written):
        return Reason.OFFSET
    moved = target.pose.copy()
    if function == "offs":
        moved[:3, 3] += MILLIMETRE * np.array(known[:3])
    else:
        moved = moved @ _in_tool(known, where)
    made = turned_target(moved[:3, 3].tolist(), moved[:3, :3], where, target.posture)
    return replace(made, external=target.external)


def _in_tool(values: list[float], where: str) -> Array:
    """(4, 4) Trans(x, y, z) Rx Ry Rz of lengths [mm] and angles [deg]."""
    parts = np.zeros((4, 6))
    parts[0, :3] = values[:3]
    parts[1:, 3:] = np.diag(values[3:])
    step = np.eye(4)
    for part in parts.tolist():
        step = step @ np.asarray(angle_target(part, where).pose)
    return step


def split_switches(part: str) -> tuple[str, dict[str, str]]:
    """An argument, and the optional ones behind it: v100\\V:=50 -> ("v100", {"v": "50"})."""
    value, *switches = parts_of(part, "\\")
    keys = (switch.partition(":=") for switch in switches)
    return value.strip(), {key.strip().lower(): text.strip() for key, _, text in keys}
