"""Poses of the tip from CSV, JSON or YAML: what a Cartesian program says."""

from __future__ import annotations

import reprlib
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rankdrop.errors import RankdropError
from rankdrop.motion.csv_file import UNITS, find_columns, is_number, name_and_unit, names_of, read_table
from rankdrop.motion.files import documents, is_double
from rankdrop.motion.trajectory import TrajectoryError, checked_times
from rankdrop.robot.files import MOST_ROWS, RANGE, allowed_range, read_text
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.transform import from_xyz_rpy

_QUATERNION, _ANGLES = ("qx", "qy", "qz", "qw"), ("roll", "pitch", "yaw")
_LENGTHS = {"x", "y", "z"}
_OTHER = {
    **{f"{long}{letter}": f"q{letter}" for long in ("q_", "quat_", "orientation_", "orientation.")
       for letter in "xyzw"},
    **{f"{long}{letter}": letter for long in ("p", "p_", "pos_", "position_", "position.", "t") for letter in "xyz"},
}  # fmt: skip
"""Other names of columns."""
_UNIT_LENGTH = 1e-3  # a quaternion's length may be off by this: digits of a file
_FAR = 20.0  # reaches: positions beyond it look like millimetres


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses of the tip, in order.

    Attributes:
        name: of the file.
        matrices: (P, 4, 4) in the base frame [m].
        times: (P,) increasing [s]; None where the file has none.
        turned: the file gives orientations; else only positions are meant.
        unused: columns that were passed over.
    """

    name: str
    matrices: Array
    times: Array | None
    turned: bool
    unused: tuple[str, ...]


def holds_poses(path: Path, robot: Robot) -> bool:
    """Whether a file holds poses: columns x, y, z and not every joint, or an object with `poses`.

    A file that cannot be read holds none; whoever reads it then says why.
    """
    ending = path.suffix.lower()
    if not path.is_file() or ending in (".npy", ".npz", ".bag", ".db3", ".mcap"):
        return False
    try:
        text = read_text(path)
        if ending in (".json", ".yaml", ".yml"):
            return _list_in(_loaded(text, str(path), yaml=ending != ".json")) is not None
        words = names_of(text)
    except RankdropError:
        return False
    joints = {joint.name for joint in robot.variables}
    return {_column_name(word) for word in words} >= _LENGTHS and not joints <= set(words)


def read_poses(path: str | Path, *, deg: bool = False) -> Poses:
    """Poses from a file.

    CSV: a line of names, x, y, z, and either qx, qy, qz, qw or roll, pitch, yaw (R = Rz·Ry·Rx, as in URDF); a time
    column if there is one; units behind a name ("x [mm]", "roll [deg]"), else metres and radians. JSON or YAML: a list,
    or an object with `poses` (a PoseArray, a Path), of objects with `position` ([x, y, z], or by name), `orientation`
    (the quaternion [x, y, z, w], or by name) or `rpy`, and `time`; `length`: "mm" and `angle`: "deg" beside `poses`.

    Args:
        path: the file.
        deg: angles without a unit are in degrees.

    Raises:
        TrajectoryError: with file, row or line, and column.
        MissingExtraError: YAML, and PyYAML is not installed.
    """
    file, name = Path(path), str(path)
    try:
        text = read_text(file)
    except RankdropError as error:
        raise TrajectoryError(error.what, where=error.where or name, got=error.got) from error
    ending = file.suffix.lower()
    if ending in (".json", ".yaml", ".yml"):
        return _from_objects(_loaded(text, name, yaml=ending != ".json"), name, deg=deg)
    return _from_rows(text, name, deg=deg)


def length_hint(poses: Poses, reach: float) -> str | None:
    """A line of warning where positions look like millimetres; None where they do not."""
    most = float(np.abs(poses.matrices[:, :3, 3]).max())
    if most <= _FAR * reach:
        return None
    return f"positions up to {most:.4g} look like millimetres and are taken as metres; write x [mm], y [mm], z [mm]"


def turned_by(quaternion: Array, where: list[str]) -> NDArray[np.float64]:
    """(N, 3, 3) rotations of quaternions (N, 4) x, y, z, w.

    Raises:
        TrajectoryError: one is not of length one, to 1e-3.
    """
    size = np.linalg.norm(quaternion, axis=1)
    for i in np.flatnonzero(np.abs(size - 1.0) > _UNIT_LENGTH)[:1]:
        raise TrajectoryError("the quaternion is not of length one", where=where[i], got=f"length {size[i]:.6g}",
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
    plain = name_and_unit(word.strip())[0].lower()
    return _OTHER.get(plain, plain)


def _measure(name: str) -> tuple[str, str] | None:
    """A column of a pose, and what it measures."""
    key = _column_name(name)
    kinds = {**dict.fromkeys(_LENGTHS, "length"), **dict.fromkeys(_ANGLES, "angle"),
             **dict.fromkeys(_QUATERNION, "number")}  # fmt: skip
    return (key, kinds[key]) if key in kinds else None


def _from_rows(text: str, name: str, *, deg: bool) -> Poses:
    table = read_table(text, name)
    if all(map(is_number, table.head)):
        raise TrajectoryError("the columns have no names", where=table.where,
                              allowed="x, y, z and qx, qy, qz, qw or roll, pitch, yaw")  # fmt: skip
    columns, time, unused = find_columns(table.head, table.where, _measure, deg=deg)
    turn = next((keys for keys in (_QUATERNION, _ANGLES) if columns.keys() >= set(keys)), ())
    if columns.keys() != {*_LENGTHS, *turn}:
        raise TrajectoryError(
            "poses need other columns", where=table.where, got=", ".join(table.head),
            allowed="x, y, z with qx, qy, qz, qw, with roll, pitch, yaw, or alone",
        )  # fmt: skip
    places, factors = zip(*(columns[key] for key in ("x", "y", "z", *turn)), strict=True)
    values = table.block(places) * np.array(factors)
    return Poses(Path(name).name, _matrices(values, turn, table.places()), table.times(time), bool(turn), unused)


def _matrices(values: Array, turn: tuple[str, ...], places: list[str]) -> Array:
    """(N, 4, 4) from rows of x, y, z and what turns.

    Raises:
        TrajectoryError: a length or an angle is beyond the range of all readers, a quaternion is not of length one.
    """
    measures = ["length"] * 3 + ["angle" if turn == _ANGLES else "number"] * len(turn)
    beyond = np.abs(values) > [RANGE[measure] for measure in measures]
    for i, column in np.argwhere(beyond)[:1]:
        raise TrajectoryError("the value is too large", where=places[i], got=f"{values[i, column]:g}",
                              allowed=allowed_range(measures[column]))  # fmt: skip
    made = np.tile(np.eye(4), (len(values), 1, 1))
    if turn == _QUATERNION:
        made[:, :3, :3] = turned_by(values[:, 3:], places)
    elif turn:
        made = np.array([from_xyz_rpy((0.0, 0.0, 0.0), row[3:].tolist()) for row in values])
    made[:, :3, 3] = values[:, :3]
    return made


def _loaded(text: str, name: str, *, yaml: bool) -> Any:
    """The first document with poses; None where there is none."""
    return next((one for one in documents(text, name, yaml=yaml) if _list_in(one) is not None), None)


def _list_in(found: Any) -> list[Any] | None:
    """The list of poses of an object, or the list itself; None where there is none."""
    rows = found.get("poses") if isinstance(found, dict) else found
    return rows if isinstance(rows, list) and rows and _pose(rows[0]) is not None else None


def _pose(row: Any) -> dict[str, Any] | None:
    """The object with the position: the entry itself, or its `pose` (PoseStamped); None where it is no pose."""
    inner = row.get("pose", row) if isinstance(row, dict) and "position" not in row else row
    return inner if isinstance(inner, dict) and "position" in inner else None


def _from_objects(found: Any, name: str, *, deg: bool) -> Poses:
    rows = _list_in(found)
    if rows is None:
        raise TrajectoryError("there are no poses in it", where=name, allowed="a list of objects with a position")
    if len(rows) > MOST_ROWS:
        raise TrajectoryError("there are too many poses", where=name, got=len(rows), allowed=f"at most {MOST_ROWS}")
    about = found if isinstance(found, dict) else {}
    length = _unit_of(about, "length", "m", ("m", "mm"), name)
    angle = _unit_of(about, "angle", "deg" if deg else "rad", tuple(UNITS["angle"]), name)
    values, kinds, times = [], [], []
    for number, entry in enumerate(rows, start=1):
        where = f"{name}, pose {number}"
        inner = _pose(entry)
        if inner is None:
            raise TrajectoryError("there is no position", where=where, got=reprlib.repr(entry))
        kind = "orientation" if "orientation" in inner else "rpy" if "rpy" in inner else ""
        row = [x * length for x in _numbers(inner["position"], "xyz", where, "position")]
        if kind == "orientation":
            row += _numbers(inner["orientation"], "xyzw", where, "orientation")
        elif kind:
            row += [x * angle for x in _numbers(inner["rpy"], _ANGLES, where, "rpy")]
        values.append(row)
        kinds.append(kind)
        times.append(_numbers([entry["time"]], "t", where, "time")[0] if "time" in entry else None)
    places = [f"{name}, pose {number}" for number in range(1, len(rows) + 1)]
    for i in [i for i, kind in enumerate(kinds) if kind != kinds[0]][:1]:
        raise TrajectoryError("the pose has another form than the first", where=places[i], got=kinds[i] or "none",
                              allowed=kinds[0] or "a position alone")  # fmt: skip
    without = [i for i, time in enumerate(times) if time is None]
    if without and len(without) < len(times):
        raise TrajectoryError("the pose has no time", where=places[without[0]])
    turn = {"orientation": _QUATERNION, "rpy": _ANGLES, "": ()}[kinds[0]]
    when = None if without else checked_times(np.array(times, dtype=np.float64), places)
    return Poses(Path(name).name, _matrices(np.array(values), turn, places), when, bool(turn), ())


def _unit_of(about: dict[str, Any], key: str, default: str, allowed: tuple[str, ...], name: str) -> float:
    unit = about.get(key, default)
    if unit not in allowed:
        raise TrajectoryError(f"there is no such unit of {key}", where=name, got=unit, allowed=", ".join(allowed))
    return next(fits[unit] for fits in UNITS.values() if unit in fits)


def _numbers(value: Any, keys: Any, where: str, what: str) -> list[float]:
    """Numbers from a list, or from an object by name."""
    listed = [value.get(key) for key in keys] if isinstance(value, dict) else value
    if not isinstance(listed, list) or len(listed) != len(keys):
        raise TrajectoryError(f"the {what} has not {len(keys)} numbers", where=where, got=reprlib.repr(value),
                              allowed=", ".join(keys))  # fmt: skip
    for one in listed:
        if not is_double(one) or not isfinite(one):
            raise TrajectoryError(f"the {what} has a value that is no finite number", where=where,
                                  got=reprlib.repr(one))  # fmt: skip
    return [float(one) for one in listed]
