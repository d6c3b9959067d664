"""Poses of the tip from files, what a Cartesian program says.

Columns of a table, objects in JSON and YAML, or matrices in NumPy's files.
"""

from __future__ import annotations

import re
import reprlib
from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from enum import StrEnum
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rankdrop.errors import RankdropError
from rankdrop.path.read.arrays import ARRAY_ENDINGS, pose_shape, read_pose_array
from rankdrop.path.read.csv_file import (
    UNITS,
    Known,
    Table,
    bare_names,
    find_columns,
    gives_every_joint,
    has_underscored_unit,
    is_number,
    name_and_unit,
    names_of,
    read_table,
    with_commas,
)
from rankdrop.path.read.files import text_of_file
from rankdrop.path.read.joint_columns import other_names
from rankdrop.path.read.makers import (
    ABB,
    ANGLES,
    QUATERNION,
    ROTATION_VECTOR,
    WRITINGS,
    Writing,
    common_turns,
    raised_by,
    sizes_of,
    writing_of,
)
from rankdrop.path.read.matrices import ENTRIES, TRANSLATION, as_stack, matrix_entries, poses_of
from rankdrop.path.read.messages import OBJECTS, all_or_none, documents, is_double
from rankdrop.path.read.named_poses import named_rows, table_of
from rankdrop.path.read.trajectory import BAGS, TrajectoryError, check_times
from rankdrop.robot.files import MOST_ROWS, RANGE, allowed_range, read_text
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.transform import from_xyz_rpy
from rankdrop.text.path_files import (
    DEGREES_STATED,
    MAKERS_UNITS,
    MILLIMETRES,
    MILLIMETRES_STATED,
    POSE_COLUMNS,
    RAISED,
    ROTATION_VECTORS,
    TWO_TURNS,
    UNIT_IN_DOUBT,
    makers_note,
    state_units,
)
from rankdrop.text.words import MOST_TURNS

_LENGTHS = {"x", "y", "z"}
_OTHER = {
    **{f"{long}{letter}": f"q{letter}" for long in ("q_", "quat_", "orientation_", "orientation.")
       for letter in "xyzw"},
    **{f"{long}{letter}": letter for long in ("p", "p_", "pos_", "position_", "position.", "t") for letter in "xyz"},
    **{f"actual_tcp_pose_{place}": name for place, name in enumerate(("x", "y", "z", *ROTATION_VECTOR))},
}  # fmt: skip
"""Other names of columns."""
TURNS = (QUATERNION, ANGLES, *(writing.turn for writing in WRITINGS))
"""Names of what turns, of every form."""
_TURNS = {"orientation": QUATERNION, "rpy": ANGLES}
_AXES = {"orientation": tuple("xyzw")}  # names of the numbers in an object
_MEASURE: dict[tuple[str, ...], str] = {("x", "y", "z"): "length"}
_UNIT_LENGTH = 1e-3  # a quaternion's length may be off by this: digits of a file
_FAR = 20.0  # reaches: positions beyond it look like millimetres
_UPPER, _WHOLE = ENTRIES[:12], ENTRIES
"""Columns of matrices without and with their last row."""
_IN_MESSAGE = re.compile(r".*[./](position|orientation)[./]([xyzw])", re.IGNORECASE)  # "field.pose.position.x"
_FEW = 9  # columns of entries by which a table is meant to hold matrices; it may lack some


class PoseForm(StrEnum):
    """How a file writes poses."""

    COLUMNS = "columns"
    MATRIX_COLUMNS = "matrix columns"
    OBJECTS = "objects"
    ARRAYS = "arrays"


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses of the tip, in order.

    Attributes:
        name: of the file.
        matrices: (P, 4, 4) in the base frame [m].
        times: (P,) increasing [s]; None where the file has none.
        turned: the file gives orientations; else only positions are meant.
        unused: columns that were passed over.
        notes: what a reader should know of how the file was read.
        form: how the file writes them.
    """

    name: str
    matrices: Array
    times: Array | None
    turned: bool
    unused: tuple[str, ...]
    notes: tuple[str, ...] = ()
    form: PoseForm = PoseForm.COLUMNS


def holds_poses(path: Path, robot: Robot) -> bool:
    """Whether a file holds poses: columns x, y, z or of matrices and not every joint, an object with `poses`, or an
    array of matrices.

    A file that cannot be read holds none; whoever reads it then says why.
    """
    ending = path.suffix.lower()
    if not path.is_file() or ending in BAGS:
        return False
    try:
        if ending in ARRAY_ENDINGS:
            return _is_pose_array(pose_shape(path), robot)
        text = read_text(path)
        if ending in OBJECTS:
            return loaded_poses(text, str(path), yaml=ending != ".json") is not None
        words = names_of(with_commas(text), str(path))
        joints = [joint.name for joint in robot.variables]
        named = set(words).issuperset(joints) or other_names(bare_names(words), joints, str(path)) is not None
    except RankdropError:
        return False
    if len(_entries(words)) >= _FEW:
        return not named and not gives_every_joint(words, robot)
    if not {_column_name(word) for word in words} >= _LENGTHS or named:
        return False
    return _plain_lengths(words) or not gives_every_joint(words, robot)


def _is_pose_array(shape: tuple[int, ...] | None, robot: Robot) -> bool:
    """Whether an array is one of poses: never a table, but one matrix where no row of it can be joint values."""
    if shape is None:
        return False
    return len(shape) == 3 or (shape in ((4, 4), (3, 4)) and robot.n not in (3, 4))


def _plain_lengths(words: list[str]) -> bool:
    """Whether x, y and z are columns by themselves or with a unit in brackets, not as "x_mm", without q1 … q4."""
    keys = {_column_name(word) for word in words if not has_underscored_unit(word)}
    return keys >= _LENGTHS and not keys >= set(ABB)


def read_poses(path: str | Path, *, deg: bool = False, robot: Robot | None = None) -> Poses:
    """Poses from a file.

    CSV: a line of names, x, y, z, and either qx, qy, qz, qw or roll, pitch, yaw (R = Rz·Ry·Rx, as in URDF), or the
    entries m00 … m23 or m00 … m33 of matrices, or what makers write (`makers`: rx, ry, rz; A, B, C; W, P, R;
    q1 … q4); a time column if there is one; units behind a name ("x [mm]",
    "roll [deg]", "m03 [mm]"), else metres and radians. JSON or YAML: a list, or an object with `poses` (a PoseArray, a
    Path), of objects with `position` ([x, y, z], or by name), `orientation` (the quaternion [x, y, z, w], or by name)
    or `rpy`, and `time`; `length`: "mm" and `angle`: "deg" beside `poses`; or of objects with the names of columns
    ({"x": 100, "y": 0, "z": 500, "a": 0, "b": 90, "c": 0}). NumPy's files: matrices (N, 4, 4) or
    (N, 3, 4) [m]; of an archive the array `poses` and, where there is one, `t` [s].

    Args:
        path: the file.
        deg: angles without a unit are in degrees.
        robot: FANUC's Z counts from the height of its axis 2; None: from the base.

    Raises:
        TrajectoryError: with file, row or line, and column.
        MissingExtraError: YAML, and PyYAML is not installed.
    """
    file, name = Path(path), str(path)
    ending = file.suffix.lower()
    if ending in ARRAY_ENDINGS:
        return _poses_of_arrays(file)
    text = text_of_file(file)
    if ending in OBJECTS:
        return _poses_of_document(loaded_poses(text, name, yaml=ending != ".json"), name, deg=deg, robot=robot)
    return _poses_of_rows(text, name, deg=deg, robot=robot)


def length_hint(poses: Poses, reach: float) -> str | None:
    """A line of warning where positions look like millimetres; None where they do not."""
    most = float(np.abs(poses.matrices[:, :3, 3]).max())
    if most <= _FAR * reach:
        return None
    return MILLIMETRES.format(most, MILLIMETRES_STATED[poses.form])


def turned_by(quaternion: Array, where: Callable[[int], str]) -> NDArray[np.float64]:
    """(N, 3, 3) rotations of quaternions (N, 4) x, y, z, w.

    Raises:
        TrajectoryError: one is not of length one, to 1e-3.
    """
    size = np.linalg.norm(quaternion, axis=1)
    for i in np.flatnonzero(np.abs(size - 1.0) > _UNIT_LENGTH)[:1].tolist():
        raise TrajectoryError("the quaternion is not of length one", where=where(i), got=f"length {size[i]:.6g}",
                              allowed="x, y, z, w of length 1")  # fmt: skip
    x, y, z, w = (quaternion / size[:, None]).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.asarray(np.moveaxis(np.array(rows), 2, 0))


def _column_name(word: str) -> str:
    """A column's name, without its unit, as it is known here."""
    return _pose_key(name_and_unit(word.strip())[0])


def _pose_key(name: str) -> str:
    """The name of a column, without a unit, as it is known here."""
    plain = name.strip().lower()
    inside = _IN_MESSAGE.fullmatch(plain)
    if inside is not None:
        plain = f"{inside[1]}.{inside[2]}"
    return _OTHER.get(plain, plain)


def _entries(words: list[str]) -> dict[str, str]:
    """Which entry of a matrix each column is, by its name without the unit."""
    return matrix_entries([name_and_unit(word.strip())[0] for word in words])


def _measures(head: list[str]) -> Known:
    """What a column of a pose is, by its name without a unit, and what it measures."""
    entries = _entries(head)
    if len(entries) < _FEW:
        entries = {}
    kinds = {**dict.fromkeys(_LENGTHS, "length"), **dict.fromkeys(ANGLES, "angle"),
             **dict.fromkeys(QUATERNION, "number")}  # fmt: skip
    writing = writing_of({_column_name(word) for word in head})
    if writing is not None:
        kinds |= dict.fromkeys(writing.turn, writing.measure)

    def measure(name: str) -> tuple[str, str] | None:
        if name.strip() in entries:
            entry = entries[name.strip()]
            return (entry, "length" if entry in TRANSLATION else "number")
        key = _pose_key(name)
        if not entries and key in kinds:
            return (key, kinds[key])
        return None

    return measure


def pose_table(
    text: str, name: str, *, deg: bool
) -> tuple[Table, dict[Hashable, tuple[int, float]], int | None, tuple[str, ...]]:
    """A table of poses; place and factor (to rad and m) of each of its columns; that of the time; keys in their order.

    The keys are x, y, z and what turns, or the entries of matrices.

    Raises:
        TrajectoryError: these are no columns of poses.
    """
    table = read_table(with_commas(text), name)
    if all(map(is_number, table.head)):
        raise TrajectoryError("the columns have no names", where=table.head_place,
                              allowed="x, y, z and qx, qy, qz, qw or roll, pitch, yaw")  # fmt: skip
    columns, time, _ = find_columns(table.head, table.head_place, _measures(table.head), deg=deg)
    if columns.keys() & set(ENTRIES):
        return table, columns, time, _matrix_keys(table, columns)
    turn: tuple[str, ...] = next((keys for keys in TURNS if columns.keys() >= set(keys)), ())
    if columns.keys() != {*_LENGTHS, *turn}:
        raise TrajectoryError("poses need other columns", where=table.head_place, got=", ".join(table.head),
                              allowed=POSE_COLUMNS)  # fmt: skip
    for writing in WRITINGS:
        if writing.turn == turn:
            _take_makers_units(table, columns, writing, deg=deg)
    return table, columns, time, ("x", "y", "z", *turn)


def _take_makers_units(
    table: Table, columns: dict[Hashable, tuple[int, float]], writing: Writing, *, deg: bool
) -> None:
    """Give the columns of a maker's poses their factors, and note how they are read.

    Units behind the names, or of angles `deg`, count; else those of the maker, where the numbers confirm them.

    Raises:
        TrajectoryError: a unit is in doubt.
    """
    length = _makers_unit(table, columns, ("x", "y", "z"), writing, deg=deg)
    angle = ""
    if writing.angle:
        angle = _makers_unit(table, columns, writing.turn, writing, deg=deg)
    table.notes += (makers_note(writing.maker, writing.turn, length, angle),)


def _makers_unit(
    table: Table, columns: dict[Hashable, tuple[int, float]], keys: tuple[str, ...], writing: Writing, *, deg: bool
) -> str:
    """The unit of three columns; their factors are set where the file does not state it.

    Raises:
        TrajectoryError: it is in doubt.
    """
    measure = _MEASURE.get(keys, "angle")
    places = [columns[key][0] for key in keys]
    names = ", ".join(table.head[place] for place in places)
    stated = _stated_units(table, places, measure, deg=deg)
    if keys == ROTATION_VECTOR and {"deg", "°"} & set(stated):
        raise TrajectoryError("rx, ry, rz in degrees can be a rotation vector or angles about three axes",
                              where=table.head_place, got=names, allowed=ROTATION_VECTORS)  # fmt: skip
    if all(stated):
        return " and ".join(dict.fromkeys(stated))
    sizes = sizes_of(keys, table.block(places))
    row = int(sizes.argmax())
    unit = writing.unit_of(measure, float(sizes[row]))
    if any(stated) or not unit:
        raise TrajectoryError(UNIT_IN_DOUBT[measure], where=table.place(row), got=f"{sizes[row]:.6g} in {names}",
                              allowed=MAKERS_UNITS[writing.turn], mend=state_units(keys))  # fmt: skip
    for key in keys:
        columns[key] = columns[key][0], UNITS[measure][unit]
    return unit


def _stated_units(table: Table, places: list[int], measure: str, *, deg: bool) -> list[str]:
    """The units behind the names of columns, "" where there is none; of angles degrees with `deg`."""
    default = ""
    if deg and measure == "angle":
        default = "deg"
    return [name_and_unit(table.head[place])[1] or default for place in places]


def _matrix_keys(table: Table, columns: dict[Hashable, tuple[int, float]]) -> tuple[str, ...]:
    """The entries of matrices with or without their last row.

    Raises:
        TrajectoryError: some are missing.
    """
    keys = _WHOLE if columns.keys() & set(_WHOLE[12:]) else _UPPER
    missing = [key for key in keys if key not in columns]
    if missing:
        raise TrajectoryError("entries of the matrices have no column", where=table.head_place,
                              got=", ".join(table.head), allowed="m00 … m23 or m00 … m33, row by row",
                              mend=f"add {', '.join(missing)}")  # fmt: skip
    return keys


def _poses_of_rows(text: str, name: str, *, deg: bool, robot: Robot | None) -> Poses:
    table, columns, time, keys = pose_table(text, name, deg=deg)
    places, factors = zip(*(columns[key] for key in keys), strict=True)
    values = table.block(places) * np.array(factors)
    used = {place for place, _ in columns.values()} | {time}
    unused = tuple(word for place, word in enumerate(table.head) if word and place not in used)
    if keys[0] == ENTRIES[0]:
        matrices, notes = poses_of(values.reshape(len(values), -1, 4), table.place)
        return Poses(Path(name).name, matrices, table.times(time), True, unused, (*table.notes, *notes),
                     PoseForm.MATRIX_COLUMNS)  # fmt: skip
    turn, turns = common_turns(keys[3:], values[:, 3:])
    matrices = _matrices(np.hstack([values[:, :3], turns]), turn, table.place)
    raised = raised_by(keys[3:], robot)
    matrices[:, 2, 3] += raised
    if raised:
        table.notes += (RAISED.format(1e3 * raised),)
    if keys[3:] == ANGLES:
        stated = [deg or name_and_unit(table.head[place])[1] is not None for place in places[3:]]
        _refuse_degrees(values, table.place, PoseForm.COLUMNS, stated)
    return Poses(Path(name).name, matrices, table.times(time), len(keys) > 3, unused, table.notes)


def _poses_of_arrays(file: Path) -> Poses:
    values, times, place = read_pose_array(file)

    def name(row: int) -> str:
        return f"{place}, pose {row + 1}"

    matrices, notes = poses_of(as_stack(values, place), name)
    if times is not None:
        if times.shape != (len(matrices),):
            raise TrajectoryError("there is one time for each pose", where=str(file), got=f"shape {times.shape}",
                                  allowed=f"shape ({len(matrices)},)")  # fmt: skip
        check_times(times, name)
    return Poses(file.name, matrices, times, True, (), notes, PoseForm.ARRAYS)


def _refuse_degrees(values: Array, place: Callable[[int], str], form: PoseForm, stated: list[bool]) -> None:
    """Refuse roll, pitch and yaw [rad] that look like degrees, where the file does not state their unit.

    Args:
        values: (N, 6) x, y, z, roll, pitch, yaw; other widths have no such angles.
        place: of a row, for an error.
        form: how the file writes poses.
        stated: whether the unit of each angle is stated.

    Raises:
        TrajectoryError: with the first row that has such an angle.
    """
    if values.shape[1] != 6:
        return
    angles = values[:, 3:]
    beyond = (np.abs(angles) > MOST_TURNS) & ~np.array(stated)
    for row, column in np.argwhere(beyond)[:1].tolist():
        raise TrajectoryError("angles look like degrees", where=place(row),
                              got=f"{ANGLES[column]} {angles[row, column]:.6g}", allowed=TWO_TURNS,
                              mend=f"deg=True, or {DEGREES_STATED[form]}",
                              typed=f"add --deg, or {DEGREES_STATED[form]}")  # fmt: skip


def _matrices(values: Array, turn: tuple[str, ...], place: Callable[[int], str]) -> Array:
    """(N, 4, 4) from rows of x, y, z and what turns.

    Raises:
        TrajectoryError: a length or an angle is beyond the range of all readers, a quaternion is not of length one.
    """
    measures = ["length"] * 3 + ["angle" if turn == ANGLES else "number"] * len(turn)
    beyond = np.abs(values) > [RANGE[measure] for measure in measures]
    for i, column in np.argwhere(beyond)[:1].tolist():
        raise TrajectoryError("the value is too large", where=place(i), got=f"{values[i, column]:g}",
                              allowed=allowed_range(measures[column]))  # fmt: skip
    made = np.tile(np.eye(4), (len(values), 1, 1))
    if turn == QUATERNION:
        made[:, :3, :3] = turned_by(values[:, 3:], place)
    elif turn:
        made = np.array([from_xyz_rpy((0.0, 0.0, 0.0), row[3:].tolist()) for row in values])
    made[:, :3, 3] = values[:, :3]
    return made


def loaded_poses(text: str, name: str, *, yaml: bool) -> Any:
    """The first document with poses; None where there is none."""
    every = documents(text, name, yaml=yaml)
    return next((document for document in every if list_in(document) or named_rows(document)), None)


def _poses_of_document(value: Any, name: str, *, deg: bool, robot: Robot | None) -> Poses:
    """Poses of objects with a position, or with one number for each name."""
    rows = named_rows(value)
    if rows is None or list_in(value) is not None:
        return _poses_of_objects(value, name, deg=deg)
    if len(rows) > MOST_ROWS:
        raise TrajectoryError("there are too many poses", where=name, got=len(rows), allowed=f"at most {MOST_ROWS}")
    found = _poses_of_rows(table_of(value, rows, name), f"{name}, poses as a table", deg=deg, robot=robot)
    return replace(found, name=Path(name).name, form=PoseForm.OBJECTS)


def list_in(value: Any) -> list[Any] | None:
    """The list of poses of an object, or the list itself; None where there is none."""
    if isinstance(value, dict):
        rows = value.get("poses")
    else:
        rows = value
    if isinstance(rows, list) and rows and pose_in(rows[0]) is not None:
        return rows
    return None


def pose_in(row: Any) -> dict[str, Any] | None:
    """The object with the position: the entry itself, or its `pose` (PoseStamped); None where it is no pose."""
    if isinstance(row, dict) and "position" not in row:
        inner = row.get("pose", row)
    else:
        inner = row
    if isinstance(inner, dict) and "position" in inner:
        return inner
    return None


def _poses_of_objects(value: Any, name: str, *, deg: bool) -> Poses:
    rows = list_in(value)
    if rows is None:
        raise TrajectoryError("there are no poses in it", where=name, allowed="a list of objects with a position")
    if len(rows) > MOST_ROWS:
        raise TrajectoryError("there are too many poses", where=name, got=len(rows), allowed=f"at most {MOST_ROWS}")
    about = value if isinstance(value, dict) else {}
    units = {
        "position": unit_of(about, "length", "m", ("m", "mm"), name), "orientation": 1.0,
        "rpy": unit_of(about, "angle", "deg" if deg else "rad", tuple(UNITS["angle"]), name),
    }  # fmt: skip

    def place(row: int) -> str:
        return f"{name}, pose {row + 1}"

    first = pose_in(rows[0]) or {}
    turn = next((key for key in _TURNS if key in first), "")
    values = np.array([_numbers_of_pose(entry, turn, units, place(row)) for row, entry in enumerate(rows)])
    listed = [_numbers([entry["time"]], "t", place(row), "time")[0] if "time" in entry else None
              for row, entry in enumerate(rows)]  # fmt: skip
    times = all_or_none(listed, "pose", "time", place)
    if times is None:
        when = None
    else:
        when = check_times(times, place)
    keys = _TURNS.get(turn, ())
    matrices = _matrices(values, keys, place)
    _refuse_degrees(values, place, PoseForm.OBJECTS, [deg or "angle" in about] * 3)
    return Poses(Path(name).name, matrices, when, bool(turn), (), form=PoseForm.OBJECTS)


def _numbers_of_pose(entry: Any, turn: str, units: dict[str, float], where: str) -> list[float]:
    """x, y, z [m] and what turns, of one pose."""
    inner = pose_in(entry)
    if inner is None:
        raise TrajectoryError("there is no position", where=where, got=reprlib.repr(entry))
    own = next((key for key in _TURNS if key in inner), "")
    if own != turn:
        raise TrajectoryError("the pose has another form than the first", where=where, got=own or "none",
                              allowed=turn or "a position alone")  # fmt: skip
    keys = {"position": tuple("xyz"), **({turn: _AXES.get(turn, ANGLES)} if turn else {})}
    return [number * units[key] for key, axes in keys.items() for number in _numbers(inner[key], axes, where, key)]


def unit_of(about: dict[str, Any], key: str, default: str, allowed: tuple[str, ...], name: str) -> float:
    """Metres or radians in the unit of length or angle that an object of poses states, or in its default."""
    unit = about.get(key, default)
    if unit not in allowed:
        raise TrajectoryError(f"there is no such unit of {key}", where=name, got=unit, allowed=", ".join(allowed))
    return next(fits[unit] for fits in UNITS.values() if unit in fits)


def _numbers(value: Any, keys: Any, where: str, what: str) -> list[float]:
    """Numbers from a list, or from an object by name."""
    if isinstance(value, dict):
        listed = [value.get(key) for key in keys]
    else:
        listed = value
    if not isinstance(listed, list) or len(listed) != len(keys):
        raise TrajectoryError(f"the {what} has not {len(keys)} numbers", where=where, got=reprlib.repr(value),
                              allowed=", ".join(keys))  # fmt: skip
    for value in listed:
        if not is_double(value) or not isfinite(value):
            raise TrajectoryError(f"the {what} has a value that is no finite number", where=where,
                                  got=reprlib.repr(value))  # fmt: skip
    return [float(value) for value in listed]
