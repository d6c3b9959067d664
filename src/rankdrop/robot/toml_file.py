"""The DH file and the screw file: a robot in TOML. The keys are described in docs/robot-files.md.

`lines_of` says on which line of a text a key stands: `tomllib` does not.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from rankdrop.errors import RobotError
from rankdrop.robot.dh import CONVENTIONS, Where, check_keys, dh_row, from_dh, joint_kind, joint_name, limits, relocate
from rankdrop.robot.files import DOTS, LARGEST_TABLE
from rankdrop.robot.model import Array, JointKind, Robot, Source, check_joints
from rankdrop.robot.quantities import Angles, Written, checked_lengths, quantity
from rankdrop.robot.screws import ORDERS, cylindrical, from_screws, helical, prismatic, spherical
from rankdrop.robot.square_up import as_intended
from rankdrop.robot.transform import from_xyz_rpy

_HEADER = re.compile(r"\s*(\[\[?)\s*([\w.-]+)\s*\]\]?\s*(?:#.*)?")
_KEY = re.compile(r"""\s*(?:"([^"]*)"|'([^']*)'|([\w-]+))\s*[.=]""")


Lines = Mapping[tuple[str, int | None, str], int]
"""The line, from 1, of a table, of which [[table]] of that name (from 0; None for a [table]), of a key in it or ""."""

_HEAD = ("name", "maker", "aliases", "task", "about", "source", "notes", "lengths")
_DH_FILE_KEYS = (*_HEAD, "convention", "base", "tool", "joints")
_SCREW_FILE_KEYS = (*_HEAD, "order", "home", "joints")
_SCREW_KEYS = ("kind", "screw", "axis", "point", "pitch", "axes", "name", "lower", "upper", "velocity")
_KEYS_OF = {
    "prismatic": ("axis",),
    "revolute": ("axis", "point"),
    "cylindrical": ("axis", "point"),
    "helical": ("axis", "point", "pitch"),
    "spherical": ("point", "axes"),
}

Place = Callable[[str, int | None], Where]

_Simple = tuple[JointKind, Array, str]
"""Kind, (6,) linear-first screw and ending of the name of a simple joint."""


def lines_of(text: str) -> Lines:
    """First lines of the tables and keys of a TOML text, found by reading it line by line."""
    lines: dict[tuple[str, int | None, str], int] = {}
    table: tuple[str, int | None] = ("", None)
    counts: dict[str, int] = {}
    closing = ""
    for number, line in enumerate(text.splitlines(), 1):
        if closing:  # inside a text of several lines
            closing = "" if closing in line else closing
            continue
        header = _HEADER.fullmatch(line)
        if header is not None:
            name = header[2]
            if header[1] == "[[":
                counts[name] = counts.get(name, -1) + 1
            table = (name, counts.get(name))
            lines.setdefault((*table, ""), number)
            continue
        key = _KEY.match(line)
        if key is not None:
            lines.setdefault((*table, key[1] or key[2] or key[3]), number)
        closing = next((mark for mark in ('"""', "'''") if line.count(mark) % 2), "")
    return lines


def line_of(lines: Lines, table: str, index: int | None, key: str) -> int:
    """The line of a key, else of its table, else 1.

    Example:
        >>> line_of(lines_of('name = "x"\\n[[joints]]\\na = 1\\n[[joints]]\\na = 2'), "joints", 1, "a")
        5
    """
    places = ((table, index, key), (table, index, ""), ("", None, table))
    return next((lines[place] for place in places if place in lines), 1)


def robot_from_toml(
    text: str, *, file: str, default_name: str = "robot", kind: str | None = None, as_written: bool = False,
    edit: Callable[[dict[str, Any]], None] | None = None,
) -> Robot:
    """A robot from the text of a DH file or a screw file.

    A DH file has the key `convention`; a screw file has none. Angles that are rounded decimals of multiples of 15°, and
    structure that holds but for noise, are taken as exact, with a note (`as_intended`).

    Args:
        text: of the file.
        file: its name, for errors and for `Robot.source`.
        default_name: the robot's name where the file gives none.
        kind: `Source.kind` of the robot; "dh" or "screws" if None.
        as_written: take every number literally.
        edit: called with the parsed tables before anything is computed of them; may change their entries.

    Raises:
        RobotError: not TOML, a missing or unknown key, a value that cannot be used; names file, line and key.
    """
    document = parsed_toml(text, file, parse_float=Written)
    if edit is not None:
        edit(document)
    lines = lines_of(text)

    def place(table: str, index: int | None) -> Where:
        if index is not None:
            joint = f", joint {index + 1}"
        else:
            joint = ""
        if table and index is None:
            title = f", [{table}]"
        else:
            title = ""

        def place_of_key(key: str) -> str:
            line = line_of(lines, table, index, key)
            return f"{file}, line {line}{joint}{title}" + (f", {key}" if key else "")

        return place_of_key

    try:
        angles = Angles(as_written)
        return as_intended(_robot(document, place, file, default_name, kind, angles), angles)
    except RobotError as error:
        if error.where is not None and error.where.startswith(file):
            raise
        raise relocate(error, file + (f", {error.where}" if error.where else "")) from None


class NotTomlError(RobotError):
    """A text is no TOML."""


def parsed_toml(text: str, file: str, *, parse_float: Callable[[str], Any] = float) -> dict[str, Any]:
    """The tables of a TOML text whose keys have no more dots than the parser bears.

    `tomllib` keeps every beginning of a dotted key, so that a key of n parts costs n² steps and n² bytes.

    Raises:
        RobotError: too large, too many dots, or not TOML.
    """
    if len(text) > LARGEST_TABLE:
        raise RobotError("the file is too large", where=file, allowed=f"at most {LARGEST_TABLE / 2**20:g} MB")
    dots = 0
    for line, words in enumerate(text.splitlines(), 1):
        dots += words.count(".") ** 2
        if dots > DOTS:
            raise RobotError("the keys have too many dots", where=f"{file}, line {line}", got=words[:40],
                             allowed=f"{DOTS ** 0.5:.0f} in one line")  # fmt: skip
    try:
        return tomllib.loads(text, parse_float=parse_float)
    except (ValueError, RecursionError) as error:  # also of a number of more digits than Python reads
        if "digits" in str(error):
            raise NotTomlError("this is not TOML: a number has too many digits", where=file) from None
        raise NotTomlError(f"this is not TOML: {str(error) or 'nested too deeply'}", where=file) from None


def _robot(
    document: dict[str, Any], place: Place, file: str, default_name: str, kind: str | None, angles: Angles
) -> Robot:
    where = place("", None)
    form = _form(document, where)
    check_keys(document, _DH_FILE_KEYS if form == "dh" else _SCREW_FILE_KEYS, where)
    joints, notes = _joint_tables(document, where), _notes(document, where)
    common: dict[str, Any] = {
        "name": _text(document, "name", where, default_name),
        "task": _text(document, "task", where, "pose"),
        "about": _text(document, "about", where, ""),
        "source": Source(kind or form, file, _text(document, "source", where, "")),
        "lengths": _lengths(document.get("lengths", {}), place("lengths", None)),
    }
    if form == "dh":
        rows = [dh_row(joint, i + 1, place("joints", i), angles) for i, joint in enumerate(joints)]
        for end in ("base", "tool"):
            if end in document:
                common[end] = _pose(document[end], place(end, None), angles)
        return from_dh(rows, convention=document["convention"], notes=notes, **common)
    if "home" in document:
        home = _pose(document["home"], place("home", None), angles)
    else:
        home = None
    columns = _screw_columns(joints, document.get("order"), place)
    return from_screws(order="linear-first", home=home, notes=notes, **columns, **common)


def _joint_tables(document: dict[str, Any], where: Where) -> list[dict[str, Any]]:
    """The tables of the joints.

    Raises:
        RobotError: there are none, too many, or other things.
    """
    joints = document.get("joints")
    if not isinstance(joints, list) or not joints or not all(isinstance(joint, dict) for joint in joints):
        raise RobotError("there are no joints", where=where("joints"), allowed="one [[joints]] table per joint")
    check_joints(len(joints), where("joints"))
    return joints


def _notes(document: dict[str, Any], where: Where) -> list[str]:
    """The notes of a file.

    Raises:
        RobotError: they are no list of texts.
    """
    notes = document.get("notes", [])
    if not isinstance(notes, list) or not all(isinstance(note, str) for note in notes):
        raise RobotError("notes is a list of texts", where=where("notes"), got=repr(notes))
    return notes


def _form(document: dict[str, Any], where: Where) -> str:
    for key, allowed in (("convention", CONVENTIONS), ("order", ORDERS)):
        if key in document and document[key] not in allowed:
            raise RobotError(
                f"there is no such {key}", where=where(key), got=repr(document[key]),
                allowed=" or ".join(f'"{entry}"' for entry in allowed),
            )
    if "convention" in document:
        return "dh"
    joints = document.get("joints", [])
    if isinstance(joints, list) and joints and isinstance(joints[0], dict):
        first = joints[0]
    else:
        first = {}
    if "order" in document or {"screw", "axis", "point"} & set(first):
        return "screws"
    raise RobotError(
        "the kind of table is not said", where=where(""),
        allowed='convention = "standard" or "modified" (a DH file), order = "linear-first" or "angular-first" (screws)',
    )


def _screw_columns(joints: list[dict[str, Any]], order: str | None, place: Place) -> dict[str, Any]:
    columns: dict[str, list[Any]] = {key: [] for key in ("screws", "kinds", "names", "lower", "upper", "velocity")}
    for i, joint in enumerate(joints):
        where = place("joints", i)
        check_keys(joint, _SCREW_KEYS, where)
        if "screw" in joint:
            parts = _given_screw(joint, order, where)
        else:
            parts = _from_axis(joint, where)
        name = joint_name(joint, i + 1, where)
        for number, (kind, screw, ending) in enumerate(parts):
            entries = {"screws": screw, "kinds": kind, "names": name + ending}
            entries |= limits(_part(joint, number, len(parts), where), kind, where)
            for key, value in entries.items():
                columns[key].append(value)
    return columns


def _from_axis(joint: dict[str, Any], where: Where) -> list[_Simple]:
    word = _kind_word(joint, where)
    check_keys(joint, (*_KEYS_OF[word], "kind", "name", "lower", "upper", "velocity"), where)
    if word != "spherical":
        axis = _vector(joint, "axis", "number", where)
    else:
        axis = []
    if word != "prismatic":
        point = _vector(joint, "point", "length", where)
    else:
        point = []
    try:
        if word == "cylindrical":
            slide, turn = cylindrical(axis, point)
            return [(JointKind.PRISMATIC, slide, "_slide"), (JointKind.REVOLUTE, turn, "_turn")]
        if word == "spherical":
            turns = spherical(point, _axes(joint.get("axes", [[1, 0, 0], [0, 1, 0], [0, 0, 1]]), where))
            return [(JointKind.REVOLUTE, turn, f"_{number}") for number, turn in enumerate(turns, 1)]
        pitch = _pitch(joint, word, where)
        return [(JointKind(word), prismatic(axis) if word == "prismatic" else helical(axis, point, pitch), "")]
    except RobotError as error:
        raise (error if error.where is not None else relocate(error, where(""))) from None


def _kind_word(joint: dict[str, Any], where: Where) -> str:
    """The kind of a joint as a key of `_KEYS_OF`; revolute where it is not said.

    Raises:
        RobotError: there is no such kind.
    """
    word = joint.get("kind", "revolute")
    if word in ("Cylindrical", "Spherical"):
        word = word.lower()
    if word in _KEYS_OF:
        return str(word)
    joint_kind(word, where("kind"), ("cylindrical", "spherical"))
    return joint_kind(word, where("kind")).value


def _pitch(joint: dict[str, Any], kind: str, where: Where) -> float:
    """The pitch of a joint [m/rad].

    Raises:
        RobotError: a helical joint has none.
    """
    if kind == "helical" and "pitch" not in joint:
        raise RobotError("a helical joint needs a pitch", where=where("pitch"), mend="pitch = … in m/rad")
    return quantity(joint.get("pitch", 0.0), "length", where=where("pitch"))


def _axes(given: Any, where: Where) -> list[list[float]]:
    if not isinstance(given, list) or len(given) != 3:
        raise RobotError("axes is three axes", where=where("axes"), got=repr(given), allowed="[[…], […], […]]")
    return [_vector({"axes": row}, "axes", "number", where) for row in given]


def _given_screw(joint: dict[str, Any], order: str | None, where: Where) -> list[_Simple]:
    check_keys(joint, ("kind", "screw", "name", "lower", "upper", "velocity"), where)
    if order is None:
        raise RobotError(
            "the order of the screws must be named", where=where("screw"),
            allowed='order = "linear-first" or "angular-first"',
        )
    screw = np.array(_vector(joint, "screw", "number", where, 6))
    if "kind" in joint:
        kinds = [joint_kind(joint["kind"], where("kind"))]
    else:
        kinds = None
    try:
        # `order` was read from the file as text; from_screws refuses what is no order
        only = from_screws(screw[None], order=order, kinds=kinds).joints[0]  # type: ignore[arg-type]
    except RobotError as error:
        raise relocate(error, where("screw")) from None
    return [(only.kind, only.screw, "")]


def _part(joint: dict[str, Any], part: int, count: int, where: Where) -> dict[str, Any]:
    """The limits of one simple joint of a compound one, which gives them as lists."""
    if count == 1:
        return joint
    limits_of_part: dict[str, Any] = {}
    for key in ("lower", "upper", "velocity"):
        if key in joint:
            if not isinstance(joint[key], list) or len(joint[key]) != count:
                raise RobotError(
                    f"{key} of a compound joint is a list", where=where(key), got=repr(joint[key]),
                    allowed=f"{count} values, one per simple joint",
                )
            limits_of_part[key] = joint[key][part]
    return limits_of_part


def _pose(table: Any, where: Where, angles: Angles) -> Array:
    if not isinstance(table, dict):
        raise RobotError("a pose is a table", where=where(""), got=repr(table), allowed="xyz = […], rpy = […]")
    check_keys(table, ("xyz", "rpy"), where)
    if "xyz" in table:
        xyz = _vector(table, "xyz", "length", where)
    else:
        xyz = [0.0, 0.0, 0.0]
    if "rpy" not in table:
        return from_xyz_rpy(xyz, [0.0, 0.0, 0.0])
    _vector(table, "rpy", "angle", where)
    return from_xyz_rpy(xyz, [angles.quantity(entry, where=where("rpy")) for entry in table["rpy"]])


def _lengths(table: Any, where: Where) -> dict[str, float]:
    if not isinstance(table, dict):
        raise RobotError(
            "lengths is a table of letters", where=where(""), got=repr(table), allowed="[lengths], then a = 0.635 …"
        )
    return dict(checked_lengths(table.items(), where))


def _vector(table: Mapping[str, Any], key: str, measure: str, where: Where, size: int = 3) -> list[float]:
    value = table.get(key)
    if not isinstance(value, list) or len(value) != size:
        raise RobotError(f"{key} is a list of {size} numbers", where=where(key), got=repr(value))
    return [quantity(entry, measure, where=where(key)) for entry in value]


def _text(document: dict[str, Any], key: str, where: Where, default: str) -> str:
    value = document.get(key, default)
    if not isinstance(value, str):
        raise RobotError(f"{key} is a text", where=where(key), got=repr(value))
    return value
