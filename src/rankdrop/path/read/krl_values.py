"""Values of KRL: aggregates {X 100, …}, declarations, targets by name, frames, and what stands behind WITH.

Lengths in mm, angles in degrees. A, B, C turn about Z, then the new Y, then the new X: R = Rz(A) Ry(B) Rx(C).
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np

from rankdrop.path.read.program_record import Names, Posture, Reason, Target
from rankdrop.path.read.program_scan import number, parts_of, split_bracket
from rankdrop.path.read.program_targets import angle_target, joint_target
from rankdrop.robot.model import Array

NAME = re.compile(r"[A-Za-z_$][\w$]*")
AXES, MORE_AXES = tuple(f"A{k}" for k in range(1, 7)), tuple(f"A{k}" for k in range(7, 10))
EXTERNAL = tuple(f"E{k}" for k in range(1, 7))
PLACE, TURN = ("X", "Y", "Z"), ("C", "B", "A")
_TYPES = {"DECL", "GLOBAL", "CONST", "E6POS", "E6AXIS", "POS", "AXIS", "FRAME", "FDAT", "LDAT", "PDAT", "REAL", "INT"}
_ORIENTATION = re.compile(r"\bORI_TYPE?\s+#(\w+)", re.IGNORECASE)
_LINE_DATA = re.compile(r"\s*(?:(?:DECL|GLOBAL|CONST)\s+)*LDAT\b", re.IGNORECASE)
_ELEMENT = re.compile(r"([A-Za-z_$][\w$]*)\[\s*(\d{1,6})\s*\]")
_BITS = re.compile(r"'\s*([BHbh])\s*([0-9A-Fa-f]{1,8})\s*'")
_OF_FDAT = re.compile(r"S(?:BASE|TOOL2?)\(([A-Z_$][\w$]*)(?:\.\w+)?\)")
_NULL_FRAMES = ("$NULLFRAME", "$WORLD")


@dataclass(frozen=True)
class FrameNumbers:
    """TOOL_NO and BASE_NO of the FDAT of an inline form; None: not a number; 0: the null frame."""

    tool: int | None
    base: int | None


@dataclass(frozen=True)
class LineData:
    """The LDAT of an inline form: how the tool turns, "VAR" where it does not say."""

    turns: str


def declare(names: Names, line: str, where: str) -> None:
    """Take in an assignment to a name or to an element P[1]; one to a component or to an element P[i] changes it."""
    assignment = _assignment(line)
    if assignment is None:
        return
    name, right = assignment
    base = name.partition(".")[0].partition("[")[0]
    if not NAME.fullmatch(base) or base.startswith("$"):
        return
    if base != name and not _ELEMENT.fullmatch(name):
        names.changed.add(base)
        return
    value: object | None
    turns = _ORIENTATION.search(right)
    if "TOOL_NO" in right.upper():
        value = _frame_numbers(right)
    elif turns is not None:
        value = LineData(turns[1].upper())
    elif _LINE_DATA.match(line):
        value = LineData("VAR")
    elif right.startswith("{"):
        value = literal(right, where)
    else:
        value = number(right)
    names.assign(name, right, value)


def is_read_assignment(line: str, names: Names) -> bool:
    """Whether a line gives a name the literal under which it is known everywhere in the program."""
    assignment = _assignment(line)
    if assignment is None:
        return False
    name = assignment[0]
    return name in names.literals and not {name, name.partition("[")[0]} & names.changed


def _assignment(line: str) -> tuple[str, str] | None:
    """What stands left of the equals sign, without types and in capitals, and right of it; None for other lines."""
    if "=" not in line or line.lstrip()[:1] in ("", "&"):
        return None
    left, _, right = line.partition("=")
    words = left.split()
    while words and words[0].upper() in _TYPES:
        words.pop(0)
    if not words or (len(words) > 1 and not words[1].startswith(("[", ".")) and "[" not in words[0]):
        return None
    return "".join(words).upper(), right.strip()


def _frame_numbers(text: str) -> FrameNumbers:
    """The numbers of an FDAT: {TOOL_NO 1,BASE_NO 0,IPO_FRAME #BASE,POINT2[] " "}."""
    bracket = split_bracket(text, "{")
    found: dict[str, int | None] = {"TOOL_NO": None, "BASE_NO": None}
    within, _ = bracket or ("", "")
    for part in parts_of(within):
        key, *word = part.upper().split()
        if key in found and len(word) == 1 and word[0].isdecimal():
            found[key] = int(word[0])
    return FrameNumbers(found["TOOL_NO"], found["BASE_NO"])


def target_of(rest: str, names: Names, where: str) -> tuple[Target | Reason, str]:
    """The target that a text begins with, and what follows it."""
    if rest.startswith("{"):
        bracket = split_bracket(rest, "{")
        if bracket is None:
            return Reason.EXPRESSION, ""
        after = bracket[1].strip()
        if after.startswith(":"):
            return Reason.EXPRESSION, after
        return literal(rest, where), after
    element = _ELEMENT.match(rest)
    name = element or NAME.match(rest)
    if name is None:
        return Reason.EXPRESSION, rest
    after = rest[name.end() :].strip()
    if after.startswith("["):
        return Reason.VARIABLE, after
    if after.startswith((":", "(", ".")):
        return Reason.EXPRESSION, after
    if element is None:
        return names.target(name[0].upper()), after
    return names.target(_element_name(element, names)), after


def place_of(rest: str, names: Names, where: str) -> tuple[Array | None, str]:
    """The place (3,) [m] that a text begins with, in its base frame, and what follows it; None: not known.

    The place of an arc between its ends may lack the angles.
    """
    target, after = target_of(rest, names, where)
    if isinstance(target, Target) and target.pose is not None:
        return target.pose[:3, 3], after
    bracket = split_bracket(rest, "{")
    values = components(rest)
    if bracket is None or values is None or not all(key in values for key in PLACE):
        return None, after
    return 1e-3 * np.array([values[key] for key in PLACE]), bracket[1].strip()


def _element_name(element: re.Match[str], names: Names) -> str:
    """P[1] as it is kept; the name of the whole array where an element was changed that is not known."""
    array = element[1].upper()
    if array in names.changed:
        return array
    return f"{array}[{int(element[2])}]"


def literal(text: str, where: str) -> Target | Reason:
    """{A1 …} or {X …, Y …, Z …, A …, B …, C …}; also with the name of the type in front of the colon."""
    values = components(text)
    if values is None:
        return Reason.EXPRESSION
    axes = [key for key in AXES if key in values]
    external = tuple(values.get(key) for key in EXTERNAL)
    if len(axes) == len(AXES):
        joints = joint_target([values[key] for key in AXES + MORE_AXES if key in values], where)
        return replace(joints, external=external)
    if axes or not all(key in values for key in PLACE + TURN):
        return Reason.INCOMPLETE
    return replace(angle_target([values[key] for key in PLACE + TURN], where, _posture(values)), external=external)


def _posture(values: dict[str, float]) -> Posture:
    """The posture that the bits of T state."""
    signs = values.get("T")
    if signs is not None and 0 <= signs < 64:
        return Posture(signs=int(signs))
    return Posture()


def completed(text: str, last: Target | None, base: Array | None, where: str) -> Target | Reason:
    """A literal with some of its values; the others are those of the move before.

    Args:
        text: the literal.
        last: where the move before ended, its pose in the base frame of the arm; None: not known.
        base: (4, 4) the base frame in which both moves are programmed; None: not known.
        where: for errors.
    """
    values = components(text)
    if not values or last is None:
        return Reason.INCOMPLETE
    if not values.keys().isdisjoint(AXES + MORE_AXES):
        return _completed_joints(values, last.joints, where)
    if last.pose is None or base is None:
        return Reason.INCOMPLETE
    return _completed_pose(values, np.asarray(np.linalg.solve(base, last.pose)), where)


def _completed_joints(values: dict[str, float], before: tuple[float, ...] | None, where: str) -> Target | Reason:
    """Joint values, those that are left out from the target before."""
    if before is None:
        return Reason.INCOMPLETE
    joints = zip(AXES + MORE_AXES, before, strict=False)
    return joint_target([values.get(key, joint) for key, joint in joints], where)


def _completed_pose(values: dict[str, float], before: Array, where: str) -> Target | Reason:
    """A pose, the others from the pose (4, 4) before; of the angles all or none are given."""
    turns = [key in values for key in TURN]
    if any(turns) != all(turns):
        return Reason.INCOMPLETE
    place = [values.get(key, 1e3 * length) for key, length in zip(PLACE, before[:3, 3].tolist(), strict=True)]
    target = angle_target([*place, *(values.get(key, 0.0) for key in TURN)], where, _posture(values))
    if not any(turns) and target.pose is not None:
        target.pose[:3, :3] = before[:3, :3]
    return target


def components(text: str) -> dict[str, float] | None:
    """The components of a literal {…} by their names; None where it is none, or a value is no number."""
    bracket = split_bracket(text, "{")
    if bracket is None:
        return None
    within = bracket[0]
    head, colon, rest = within.partition(":")
    if colon and NAME.fullmatch(head.strip()):
        within = rest
    values: dict[str, float] = {}
    for part in parts_of(within):
        key, *words = part.split(maxsplit=1) or [""]
        value = _number("".join(words))
        if value is None:
            return None
        values[key.upper()] = value
    return values


def _number(text: str) -> float | None:
    """A number, or bits: 'B010', 'H1B'."""
    bits = _BITS.fullmatch(text.strip())
    if bits is None:
        return number(text)
    base = {"B": 2, "H": 16}[bits[1].upper()]
    try:
        return float(int(bits[2], base))
    except ValueError:
        return None


def frame_of(text: str, names: Names, where: str) -> Array | None:
    """(4, 4) a frame: $NULLFRAME, a literal, a name, BASE_DATA[n], SBASE(FP1.BASE_NO); None: not known."""
    plain = text.strip()
    if plain.upper() in _NULL_FRAMES:
        return np.eye(4)
    if _OF_FDAT.fullmatch("".join(plain.upper().split())):
        return base_frame(numbers_of_fdat(plain, names).base, names, where)
    element = _ELEMENT.fullmatch(plain)
    if element is not None and element[1].upper() == "BASE_DATA":
        return base_frame(int(element[2]), names, where)
    target, after = target_of(plain, names, where)
    if isinstance(target, Target) and not after:
        return target.pose
    return None


def tool_of(text: str, names: Names, where: str) -> Array | None:
    """(4, 4) a tool frame: $NULLFRAME, a literal, a name, TOOL_DATA[n], STOOL2(FP1); None: not known."""
    plain = text.strip()
    if plain.upper() == "$NULLFRAME":
        return np.eye(4)
    if _OF_FDAT.fullmatch("".join(plain.upper().split())):
        return tool_data(numbers_of_fdat(plain, names).tool, names, where)
    element = _ELEMENT.fullmatch(plain)
    if element is not None and element[1].upper() == "TOOL_DATA":
        return tool_data(int(element[2]), names, where)
    target, after = target_of(plain, names, where)
    if isinstance(target, Target) and not after:
        return target.pose
    return None


def tool_data(tool: int | None, names: Names, where: str) -> Array | None:
    """(4, 4) TOOL_DATA[n]; [0] is the flange; None where it is not in the file."""
    return _data("TOOL_DATA", tool, names, where)


def numbers_of_fdat(text: str, names: Names) -> FrameNumbers:
    """The numbers of the FDAT that SBASE(FP1.BASE_NO), STOOL2(FP1) or a name refers to; None for those not known."""
    name = _OF_FDAT.sub(r"\1", "".join(text.upper().split()))
    found = names.literals.get(name)
    if isinstance(found, FrameNumbers) and name not in names.changed:
        return found
    return FrameNumbers(None, None)


def turns_of_ldat(name: str, names: Names) -> str:
    """How the tool turns by the LDAT of a name; "" where it is not known."""
    found = names.literals.get(name)
    if isinstance(found, LineData) and name not in names.changed:
        return found.turns
    return ""


def base_frame(base: int | None, names: Names, where: str) -> Array | None:
    """(4, 4) BASE_DATA[n]; [0] is the null frame; None where it is not in the file."""
    return _data("BASE_DATA", base, names, where)


def _data(array: str, number: int | None, names: Names, where: str) -> Array | None:
    """(4, 4) the frame of an element; that of 0 is the null frame; None where it is not in the file."""
    if number is None:
        return None
    if number == 0:
        return np.eye(4)
    target, _ = target_of(f"{array}[{number}]", names, where)
    if isinstance(target, Target):
        return target.pose
    return None


def settings_of(after: str) -> dict[str, str]:
    """What stands behind WITH, by name in capitals without spaces: {"$VEL.CP": "0.2"}."""
    match = re.search(r"\bWITH\b", after, re.IGNORECASE)
    if match is None:
        return {}
    pairs = (part.partition("=") for part in parts_of(after[match.end() :]))
    return {"".join(key.upper().split()): value.strip() for key, _, value in pairs}
