"""A pose of the tip as engineers copy it from a program or a teach pendant.

- URScript: p[x, y, z, rx, ry, rz]; m and the rotation vector in rad.
- KRL: {X 100, Y 0, Z 500, A 0, B 90, C 0}, also with E6POS: and with S and T.
- RAPID: [[x, y, z], [q1, q2, q3, q4], …]; mm, the real part first.
- DRL: posx(x, y, z, A, B, C); mm, degrees, R = Rz(A) Ry(B) Rz(C).
- Names and values: X = 100 mm, Y = 0 mm, …, W = 180 deg, P = 0 deg, R = 0 deg; x 0.1, …, qw 1, qx 0, qy 0, qz 0.
- Seven numbers with the order of the quaternion behind them: 0.1,0,0.5,1,0,0,0 wxyz.
- A homogeneous matrix (`matrix_text`), and a message of ROS (`message_text`).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rankdrop.errors import OptionError, RankdropError
from rankdrop.local.orientation import orientation_coordinates
from rankdrop.path.read.csv_file import UNITS
from rankdrop.path.read.makers import (
    ABB,
    ANGLES,
    EULER_ZYZ,
    QUATERNION,
    ROTATION_VECTOR,
    WRITINGS,
    Writing,
    common_turns,
    raised_by,
    sizes_of,
    writing_of,
)
from rankdrop.path.read.matrix_text import matrix_of_text
from rankdrop.path.read.message_text import message_of_text
from rankdrop.path.read.program_scan import flat, numbers_of
from rankdrop.robot.joint_text import with_plain_constants
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.quantities import quantity
from rankdrop.text.path_files import (
    MAKERS_UNITS,
    NAMED_UNITS,
    ORDER_IN_DOUBT,
    POSE_TEXTS,
    RAISED,
    ROTATION_VECTORS,
    STATE_POSE_UNITS,
    TWO_TURNS,
    UNIT_IN_DOUBT,
    makers_note,
    passed_over_notes,
)
from rankdrop.text.words import MOST_TURNS

_PLACE: tuple[str, ...] = ("x", "y", "z")
_ITEM = re.compile(
    r"(?P<name>[A-Za-z]\w*)(?:\s*[=:]\s*|\s+)(?P<value>[-+]?(?:[\d.(]|pi)[^\s,;=:]*)(?:\s*(?P<unit>mm|m|deg|°|rad)\b°?)?[\s,;]*"
)
_TYPE = re.compile(r"^(?:(?:E6)?POS|FRAME)\s*:", re.IGNORECASE)
_ORDER = re.compile(r"\b(wxyz|xyzw)\b", re.IGNORECASE)
_BEFORE_ORDER, _AFTER_ORDER = " \t\r\n,;:([", " \t\r\n)]"
_POSX = re.compile(r"posx\s*\(([^()]*)\)")
_UNIT = re.compile(r"(?:mm|m|deg|°|rad)$")
_POSTURE = frozenset(("s", "t", "f", "cf1", "cf4", "cf6", "cfx", "config", *(f"e{number}" for number in range(1, 7))))
"""Names of parts of a target that say nothing of where the tip is."""
_DECLARED = re.compile(
    r"(?:[A-Za-z_]\w{0,40}\s{1,10}){0,4}[A-Za-z_$][\w.]{0,40}(?:\[\d{1,4}\])?\s{0,10}:?=\s{0,10}"
    r"(?=[\[({]|p\s?\[|[A-Za-z_][\w.]{0,40}\s?\()"
)
_JOINTS_OF_CONF, _EXTERNAL_AXES = 4, 6  # numbers of a robtarget behind place and quaternion
_AS_TYPED = str.maketrans("−–", "--")


@dataclass(frozen=True)
class PoseText:
    """A pose that was read.

    Attributes:
        numbers: x, y, z [m], then nothing, roll, pitch, yaw [rad], or a quaternion x, y, z, w.
        notes: how it was read.
    """

    numbers: list[float]
    notes: tuple[str, ...]


def target_of_text(text: str) -> str:
    """A target with plain signs, without the name that it is given: "CONST robtarget p:=[[…]]", "start = p[…]".

    Example:
        >>> target_of_text("home = [0.3, 0, 0.4, -math.pi, 0, 0];")
        '[0.3, 0, 0.4, -pi, 0, 0]'
    """
    plain = with_plain_constants(text.translate(_AS_TYPED).replace("π", "pi"))
    declared = _DECLARED.match(plain)
    if declared is None:
        return plain
    return plain[declared.end() :]


def pose_of_text(text: str, where: str, *, deg: bool = False, robot: Robot | None = None) -> PoseText | None:
    """A pose from a text of a maker's form or with names; None for a plain list of numbers.

    Args:
        text: as typed.
        where: the option, for errors.
        deg: angles without a unit are in degrees.
        robot: FANUC's Z counts from the height of its axis 2; None: from the base.

    Raises:
        OptionError: names, units or the order of a quaternion are in doubt.

    Example:
        >>> pose_of_text("{X 100, Y 0, Z 500, A 0, B 90, C 0}", "--pose").numbers[:3]
        [0.1, 0.0, 0.5]
    """
    plain = target_of_text(text)
    pasted = _of_matrix(plain, where) or _of_message(plain, where)
    if pasted is not None:
        return pasted
    if re.match(r"p\s*\[", plain):
        return _of_urscript(plain[1:].strip(), where, deg=deg)
    posx = _POSX.fullmatch(plain)
    if posx is not None:
        return _of_posx(posx[1].strip(), where)
    if plain.startswith("[") and plain[1:].lstrip().startswith("["):
        return _of_rapid(plain, where)
    order = _ORDER.search(plain)
    if order is not None and not plain[order.end() :].strip(_AFTER_ORDER):
        return _of_quaternion(plain[: order.start()].rstrip(_BEFORE_ORDER), order[1].lower(), where)
    return _of_named_values(plain, where, deg=deg, robot=robot)


def _of_matrix(text: str, where: str) -> PoseText | None:
    """The place and the quaternion of a matrix; None where the text is none."""
    matrix = matrix_of_text(text, where)
    if matrix is None:
        return None
    w, x, y, z = map(float, orientation_coordinates(matrix.pose[:3, :3], "quaternion"))
    return PoseText([*map(float, matrix.pose[:3, 3]), x, y, z, w], matrix.notes)


def _of_message(text: str, where: str) -> PoseText | None:
    """The pose in a message of ROS; None where the text is none."""
    numbers = message_of_text(text, where)
    if numbers is None:
        return None
    return PoseText(numbers, ())


def _of_urscript(text: str, where: str, *, deg: bool) -> PoseText:
    values = flat(numbers_of(text), 6) or _with_pi(text)
    if values is None:
        raise OptionError("a pose of URScript has six numbers", where=where, got=repr(f"p{text}"),
                          allowed="p[x, y, z, rx, ry, rz]")  # fmt: skip
    if deg:
        raise OptionError("rx, ry, rz of p[…] are a rotation vector in radians", where=where, got="degrees",
                          mend="deg=False", typed="leave --deg out")  # fmt: skip
    row = np.array([values])
    for keys, numbers in ((_PLACE, row[:, :3]), (ROTATION_VECTOR, row[:, 3:])):
        _confirmed_unit(WRITINGS[0], keys, numbers, where, NAMED_UNITS)
    return _pose_text(WRITINGS[0], row, "m", "rad")


def _with_pi(text: str) -> list[float] | None:
    """The numbers of [x, y, z, rx, ry, rz] where some are arithmetic or d2r(180); None where they are not six."""
    words = text.strip("[] \t\r\n").split(",")
    if len(words) != 6:
        return None
    try:
        numbers = [quantity(word.strip(), "number", where="") for word in words[:3]]
        return numbers + [quantity(word.strip(), "angle", where="") for word in words[3:]]
    except RankdropError:
        return None


def _of_posx(text: str, where: str) -> PoseText:
    values = flat(numbers_of(f"[{text.removeprefix('[').removesuffix(']')}]"), 6)
    if values is None:
        raise OptionError("a pose of DRL has six numbers", where=where, got=repr(f"posx({text})"),
                          allowed="posx(x, y, z, A, B, C)")  # fmt: skip
    writing = next(writing for writing in WRITINGS if writing.turn == EULER_ZYZ)
    row = np.array([values])
    for keys, numbers in ((_PLACE, row[:, :3]), (EULER_ZYZ, row[:, 3:])):
        _confirmed_unit(writing, keys, numbers, where, NAMED_UNITS)
    row[:, :3] *= UNITS["length"]["mm"]
    row[:, 3:] *= UNITS["angle"]["deg"]
    return _pose_text(writing, row, "mm", "deg")


def _of_rapid(text: str, where: str) -> PoseText:
    """A robtarget, or its first two groups.

    Raises:
        OptionError: it is none; the first groups alone, in metres: nobody knows which number of the quaternion is its
            real part.
    """
    groups = numbers_of(text) or []
    place, turn = (flat(group, count) for group, count in zip([*groups, None, None][:2], (3, 4), strict=True))
    if place is None or turn is None:
        raise OptionError("this is no robtarget", where=where, got=repr(text),
                          allowed="[[x, y, z], [q1, q2, q3, q4], …]")  # fmt: skip
    writing = next(writing for writing in WRITINGS if writing.turn == ABB)
    if not _is_whole(groups) and writing.unit_of("length", float(np.abs(place).max())) != "mm":
        raise OptionError(ORDER_IN_DOUBT, where=where, got=repr(text), allowed="lengths in mm, as RAPID has them",
                          mend="write x,y,z and the quaternion, then wxyz or xyzw; or the whole robtarget")  # fmt: skip
    row = np.array([[*place, *turn]])
    row[:, :3] *= UNITS["length"]["mm"]
    return _pose_text(writing, row, "mm", "")


def _is_whole(groups: Sequence[object]) -> bool:
    """Whether a robtarget has its configuration and its external axes too: nothing else is written so."""
    if len(groups) != 4:
        return False
    behind = zip(groups[2:], (_JOINTS_OF_CONF, _EXTERNAL_AXES), strict=True)
    return all(flat(group, count) is not None for group, count in behind)


def _of_quaternion(numbers: str, order: str, where: str) -> PoseText:
    """Three lengths and a quaternion; the order of its numbers is stated."""
    words = [word for word in re.split(r"[\s,;\[\]()]+", numbers) if word]
    if len(words) != 7:
        raise OptionError("three lengths and a quaternion are seven numbers", where=where, got=f"{len(words)} numbers",
                          allowed="x,y,z,qw,qx,qy,qz wxyz, or x,y,z,qx,qy,qz,qw xyzw")  # fmt: skip
    values = [_value(word, "length", where) for word in words[:3]]
    turn = dict(zip(order, (_value(word, "number", where) for word in words[3:]), strict=True))
    return PoseText([*values, *(turn[key] for key in "xyzw")], ())


def _of_named_values(text: str, where: str, *, deg: bool, robot: Robot | None) -> PoseText | None:
    """A pose of names and values; angles of KRL are in degrees. None where the text is none."""
    named = _named_values(text)
    if named is None:
        return None
    default = ""
    if deg or re.match(r"\{[^{}]*\bA[\s=:]", text):  # KRL
        default = "deg"
    return _of_names(named, where, default=default, deg=deg, robot=robot)


def _named_values(text: str) -> list[tuple[str, str]] | None:
    """Names in small letters and values with their units; None where the text is anything else."""
    body = _TYPE.sub("", text.strip("{}").strip()).strip()
    found, at = [], 0
    while at < len(body):
        item = _ITEM.match(body, at)
        if item is None:
            return None
        found.append((item["name"].lower(), f"{item['value']} {item['unit'] or ''}".strip()))
        at = item.end()
    return found or None


def _of_names(items: list[tuple[str, str]], where: str, *, default: str, deg: bool, robot: Robot | None) -> PoseText:
    values = dict(items)
    if len(values) < len(items):
        raise OptionError("a name is given twice", where=where, got=", ".join(name for name, _ in items).upper())
    writing = writing_of(set(values))
    if writing is None:
        return _of_common_names(values, where, deg=deg)
    notes = _others(values, writing.turn, where)
    place, length = _in_units(writing, "length", [values[key] for key in _PLACE], where)
    if writing.measure == "number":
        return _pose_text(writing, np.hstack([place, [[_value(values[key], "number", where) for key in writing.turn]]]),
                     length, "", notes, robot)  # fmt: skip
    turns, angle = _in_units(writing, "angle", [values[key] for key in writing.turn], where, default)
    return _pose_text(writing, np.hstack([place, turns]), length, angle, notes, robot)


def _of_common_names(values: dict[str, str], where: str, *, deg: bool) -> PoseText:
    """x, y, z [m] and roll, pitch, yaw [rad], a quaternion, or nothing."""
    turn: tuple[str, ...] = next((keys for keys in (QUATERNION, ANGLES) if values.keys() >= set(keys)), ())
    measure = "angle"
    if turn == QUATERNION:
        measure = "number"
    notes = _others(values, turn, where)
    place = [_value(values[key], "length", where) for key in _PLACE]
    turns = [_value(values[key], measure, where, deg=deg) for key in turn]
    if measure == "angle" and not deg:
        refuse_bare_degrees([values[key] for key in turn], turns, where)
    return PoseText([*place, *turns], notes)


def refuse_bare_degrees(words: Sequence[str], angles: Sequence[float], where: str) -> None:
    """Refuse roll, pitch and yaw that look like degrees and have no unit.

    Args:
        words: as they are written.
        angles: what they are read as [rad].
        where: the option, for errors.

    Raises:
        OptionError: an angle without a unit is above two turns.
    """
    for word, angle in zip(words, angles, strict=True):
        if abs(angle) > MOST_TURNS and not _UNIT.search(word):
            raise OptionError("angles look like degrees", where=where, got=word, allowed=TWO_TURNS,
                              mend=f"deg=True, or {STATE_POSE_UNITS['angle']}",
                              typed=f"add --deg, or {STATE_POSE_UNITS['angle']}")  # fmt: skip


def _others(values: dict[str, str], turn: tuple[str, ...], where: str) -> tuple[str, ...]:
    """A note on values that say nothing of where the tip is: of posture and external axes.

    Raises:
        OptionError: there are others, or a length is missing.
    """
    others = [name for name in values if name not in (*_PLACE, *turn)]
    if not values.keys() >= set(_PLACE) or not set(others) <= _POSTURE:
        raise OptionError("the names are not those of one pose", where=where, got=", ".join(values).upper(),
                          allowed=POSE_TEXTS)  # fmt: skip
    return passed_over_notes([name.upper() for name in others])


def _in_units(writing: Writing, measure: str, words: list[str], where: str, default: str = "") -> tuple[Array, str]:
    """(1, k) numbers in m or rad of quantities of a maker's pose, and their unit.

    Args:
        writing: the maker's form.
        measure: "length" or "angle".
        words: the quantities, with or without a unit.
        where: for errors.
        default: the unit of those without one; "": that of the maker, where the numbers confirm it.

    Raises:
        OptionError: the unit is in doubt.
    """
    keys = {"length": _PLACE}.get(measure, writing.turn)
    units = [_UNIT.findall(word) or [default] for word in words]
    stated = [unit[0] for unit in units]
    if keys == ROTATION_VECTOR and {"deg", "°"} & set(stated):
        raise OptionError("rx, ry, rz in degrees can be a rotation vector or angles about three axes", where=where,
                          got=", ".join(words), allowed=ROTATION_VECTORS)  # fmt: skip
    numbers = np.array([[_value(_UNIT.sub("", word).strip(), "number", where) for word in words]])
    if not any(stated):
        stated = [_confirmed_unit(writing, keys, numbers, where)] * len(words)
    if not all(stated):
        raise OptionError(UNIT_IN_DOUBT[measure], where=where, got=", ".join(words),
                          mend=STATE_POSE_UNITS[measure])  # fmt: skip
    return numbers * np.array([UNITS[measure][unit] for unit in stated]), " and ".join(dict.fromkeys(stated))


def _confirmed_unit(writing: Writing, keys: tuple[str, ...], numbers: Array, where: str, mend: str = "") -> str:
    """The unit of the maker, where the numbers (1, k) confirm it.

    Raises:
        OptionError: they do not.
    """
    measure = {_PLACE: "length"}.get(keys, "angle")
    size = float(sizes_of(keys, numbers)[0])
    unit = writing.unit_of(measure, size)
    if not unit:
        raise OptionError(UNIT_IN_DOUBT[measure], where=where, got=f"{size:.6g} in {', '.join(keys)}",
                          allowed=MAKERS_UNITS[writing.turn], mend=mend or STATE_POSE_UNITS[measure])  # fmt: skip
    return unit


def _pose_text(
    writing: Writing, values: Array, length: str, angle: str, notes: tuple[str, ...] = (), robot: Robot | None = None
) -> PoseText:
    """The pose of numbers (1, 3 + k) [m, rad]."""
    _, turns = common_turns(writing.turn, values[:, 3:])
    place = values[0, :3].copy()
    raised = raised_by(writing.turn, robot)
    place[2] += raised
    said = [makers_note(writing.maker, writing.turn, length, angle), *notes]
    if raised:
        said.append(RAISED.format(1e3 * raised))
    return PoseText([*map(float, place), *map(float, turns[0])], tuple(said))


def _value(word: str, measure: str, where: str, *, deg: bool = False) -> float:
    """One quantity; an angle without a unit is in degrees with `deg`."""
    if deg and measure == "angle" and not _UNIT.search(word):
        return UNITS["angle"]["deg"] * _value(word, "number", where)
    try:
        return quantity(word, measure, where=where)
    except RankdropError as error:
        raise OptionError(**error.parts) from error
