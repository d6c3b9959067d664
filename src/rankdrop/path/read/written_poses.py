"""Files of poses written again with some poses moved, put in or at other times: all other rows stay as they are.

Lines of a CSV file that stay are copied byte for byte, comments above them too; a line that is only at another time has
another number in the column of the time. New rows have the columns, units, delimiter and decimal sign of the file, and
their other columns are copied from the row of the file before them. Of JSON (and YAML, which is written as JSON)
entries stay as they are, and new ones have the form of the entry before them. NumPy's files become archives with
`poses` and, where the file has times, `t`.
"""

from __future__ import annotations

import copy
import io
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, hypot, pi
from pathlib import Path
from typing import Any

import numpy as np

from rankdrop.errors import OptionError
from rankdrop.path.curve import Index
from rankdrop.path.read.arrays import ARRAY_ENDINGS, read_pose_array
from rankdrop.path.read.csv_file import UNITS, delimiter_of, per_second
from rankdrop.path.read.makers import ANGLES, QUATERNION, common_turns, makers_turn, raised_by
from rankdrop.path.read.matrices import ENTRIES, as_stack
from rankdrop.path.read.messages import OBJECTS
from rankdrop.path.read.poses import list_in, loaded_poses, pose_in, pose_table, unit_of
from rankdrop.robot.files import read_text
from rankdrop.robot.model import Array, Robot
from rankdrop.text.path_files import DECIMAL_COMMAS

_LINE = re.compile(r"[^\r\n]*(?:\r\n|\n|\r)|[^\r\n]+")
_UPRIGHT = 1e-12  # cosine of the pitch below which roll and yaw turn about one axis


def check_pose_target(source: Path, target: str) -> None:
    """Refuse a target that is not of the kind of a file of poses.

    Raises:
        OptionError: its ending is that of another kind.
    """
    ending = source.suffix.lower()
    if ending in ARRAY_ENDINGS:
        allowed = ".npz"
    elif ending in OBJECTS:
        allowed = ".json"
        if list_in(loaded_poses(read_text(source), str(source), yaml=ending != ".json")) is None:
            raise OptionError("objects with one number for each name are not written again", where=target,
                              got=source.name, mend="fixed_as='joints' writes joint values",
                              typed="--fixed-as joints writes joint values, or give the poses as .csv")  # fmt: skip
    else:
        allowed = ".csv"
    if Path(target).suffix.lower() != allowed:
        raise OptionError("poses are written in the form in which they were read", where=target, got=source.name,
                          allowed=allowed, mend="fixed_as='joints' writes joint values",
                          typed="--fixed-as joints writes joint values")  # fmt: skip


def poses_bytes(
    source: Path, matrices: Array, times: Array | None, given: Index, *, deg: bool = False, robot: Robot | None = None
) -> bytes:
    """The content of a file of poses with other rows.

    Args:
        source: the file that the poses are from, .csv or .json, .yaml or .npy, .npz.
        matrices: (K, 4, 4) [m].
        times: (K,) [s]; None where the file has none.
        given: (K,) which row of the file each is, from 0; −1: a new one.
        deg: angles without a unit are in degrees.
        robot: as of `read_poses`.
    """
    before = np.maximum.accumulate(np.where(given >= 0, given, 0))  # the row of the file before each
    if source.suffix.lower() in ARRAY_ENDINGS:
        return _arrays(source, matrices, times, given)
    if source.suffix.lower() in OBJECTS:
        return _objects(source, matrices, times, given, before, deg=deg)
    return _table(source, matrices, times, given, before, deg=deg, robot=robot)


@dataclass(frozen=True)
class _Columns:
    """Where the numbers of a pose are in a line, and how they are written."""

    places: tuple[int, ...]
    factors: tuple[float, ...]
    keys: tuple[str, ...]
    time: int | None
    delimiter: str
    commas: bool

    def word(self, value: float) -> str:
        """A number with all of its digits."""
        text = repr(value)
        return text.replace(".", ",") if self.commas else text

    def cells(self, line: str) -> list[str]:
        """Of a line without its end."""
        cells = [*map(str.strip, line.split(self.delimiter))]
        if '"' in line:
            return [cell.strip('"') for cell in cells]
        return cells


def _table(
    source: Path, matrices: Array, times: Array | None, given: Index, before: Index, *, deg: bool, robot: Robot | None
) -> bytes:
    text = read_text(source)
    table, columns, time, keys = pose_table(text, str(source), deg=deg)
    matrices = matrices.copy()
    matrices[:, 2, 3] -= raised_by(keys[3:], robot)
    places, factors = zip(*(columns[key] for key in keys), strict=True)
    lines = _LINE.findall(text)
    rows = [number - 1 for number in table.lines]
    head = lines[: rows[0]]
    form = _Columns(places, factors, keys, time, delimiter_of(lines[table.line - 1]), DECIMAL_COMMAS in table.notes)
    end = "\r\n" if lines[0].endswith("\r\n") else lines[0][-1]
    known = None if time is None else table.times(time)
    values = table.block(places) * np.array(factors)
    out = list(head)
    when = None
    later = [False] * len(given)
    if known is not None and times is not None:
        when = times.tolist()
        later = (times != known[before]).tolist()
    for k, (number, last) in enumerate(zip(given.tolist(), before.tolist(), strict=True)):
        line = lines[rows[last]]
        if number > 0:
            out += lines[rows[number - 1] + 1 : rows[number]]  # comments
        if number >= 0 and not later[k]:
            out.append(line if line.endswith(("\n", "\r")) else line + end)
            continue
        cells = form.cells(line.rstrip("\r\n"))
        if number < 0:
            pose = _numbers_of_row(matrices[k], form.keys, values[last])
            for place, factor, value in zip(form.places, form.factors, pose, strict=True):
                cells[place] = form.word(value / factor)
        if time is not None and when is not None:
            cells[time] = form.word(when[k] * per_second(table.head[time]))
        out.append(form.delimiter.join(cells) + end)
    return "".join([*out, *lines[rows[-1] + 1 :]]).encode()


def _numbers_of_row(matrix: Array, keys: tuple[str, ...], near: Array) -> list[float]:
    """The numbers of a row [m, rad] for a pose (4, 4): entries of the matrix, or x, y, z and what turns."""
    if keys[0] == ENTRIES[0]:
        return [float(x) for x in matrix.ravel()[: len(keys)]]
    common, turns = common_turns(keys[3:], near[None, 3:])
    numbers = np.array(_numbers(matrix, common, turns[0]))
    return [*map(float, numbers[:3]), *map(float, makers_turn(keys[3:], numbers[3:], near[3:]))]


def _arrays(source: Path, matrices: Array, times: Array | None, given: Index) -> bytes:
    """An archive with `poses`, and `t` where the file has times; poses of the file are those of its array."""
    values, _, place = read_pose_array(source)
    old = as_stack(values, place)
    poses = matrices[:, : old.shape[1]].copy()
    poses[given >= 0] = old[given[given >= 0]]
    buffer = io.BytesIO()
    if times is None:
        np.savez(buffer, poses=poses)
    else:
        np.savez(buffer, poses=poses, t=times)
    return buffer.getvalue()


def _objects(source: Path, matrices: Array, times: Array | None, given: Index, before: Index, *, deg: bool) -> bytes:
    loaded = loaded_poses(read_text(source), str(source), yaml=source.suffix.lower() != ".json")
    entries = list_in(loaded) or []
    about = loaded if isinstance(loaded, dict) else {}
    length = unit_of(about, "length", "m", ("m", "mm"), str(source))
    angle = unit_of(about, "angle", "deg" if deg else "rad", tuple(UNITS["angle"]), str(source))
    out = []
    for k, (number, last) in enumerate(zip(given.tolist(), before.tolist(), strict=True)):
        entry = entries[last]
        if number < 0:
            entry = copy.deepcopy(entry)
            _move(pose_in(entry) or {}, matrices[k], length, angle)
        if times is not None and float(entry["time"]) != float(times[k]):
            entry = dict(entry) | {"time": float(times[k])}
        out.append(entry)
    whole: Any = out
    if isinstance(loaded, dict):
        whole = loaded | {"poses": out}
    return (json.dumps(whole, indent=1) + "\n").encode()


def _move(pose: dict[str, Any], matrix: Array, length: float, angle: float) -> None:
    """Give an entry another pose, in its own form."""
    pose["position"] = _like(pose["position"], "xyz", [float(x) / length for x in matrix[:3, 3]])
    if "orientation" in pose:
        near = pose["orientation"]
        known = [near[key] for key in "xyzw"] if isinstance(near, dict) else near
        pose["orientation"] = _like(near, "xyzw", _numbers(matrix, QUATERNION, np.array(known, dtype=np.float64))[3:])
    elif "rpy" in pose:
        near = pose["rpy"]
        known = [near[key] for key in ANGLES] if isinstance(near, dict) else near
        turned = _numbers(matrix, ANGLES, angle * np.array(known, dtype=np.float64))[3:]
        pose["rpy"] = _like(near, ANGLES, [x / angle for x in turned])


def _like(given: Any, keys: Sequence[str], numbers: list[float]) -> Any:
    """Numbers as a list or by name, as they were given."""
    if isinstance(given, dict):
        return dict(given) | dict(zip(keys, numbers, strict=True))
    return numbers


def _numbers(matrix: Array, turn: Sequence[str], near: Array) -> list[float]:
    """x, y, z [m] and what turns of a pose (4, 4), that nearest to others of the same turn."""
    place = [float(x) for x in matrix[:3, 3]]
    if tuple(turn) == tuple(QUATERNION):
        return [*place, *_quaternion(matrix[:3, :3], near)]
    if tuple(turn) == tuple(ANGLES):
        return [*place, *_roll_pitch_yaw(matrix[:3, :3], near)]
    return place


def _quaternion(turn: Array, near: Array) -> list[float]:
    """x, y, z, w of a rotation (3, 3), of both signs that nearer to another: the eigenvector of K (Bar-Itzhack)."""
    (a, b, c), (d, e, f), (g, h, i) = turn
    k = np.array([[a - e - i, b + d, c + g, h - f], [b + d, e - a - i, f + h, c - g], [c + g, f + h, i - a - e, d - b],
                  [h - f, c - g, d - b, a + e + i]]) / 3.0  # fmt: skip
    largest = np.linalg.eigh(k)[1][:, -1]
    return [float(x) for x in (largest if largest @ near >= 0.0 else -largest)]


def _roll_pitch_yaw(turn: Array, near: Array) -> list[float]:
    """R = Rz(yaw) Ry(pitch) Rx(roll) of a rotation (3, 3): of both solutions and whole turns those nearest to others.
    """
    level = hypot(turn[2, 1], turn[2, 2])  # cos(pitch)
    pitch = atan2(-turn[2, 0], level)
    if level < _UPRIGHT:  # roll and yaw turn about one axis: the yaw stays
        yaw, sign = float(near[2]), -float(np.sign(turn[2, 0]))
        roll = sign * yaw + atan2(sign * turn[0, 1], turn[1, 1])
        both = np.array([[roll, pitch, yaw]])
    else:
        roll, yaw = atan2(turn[2, 1], turn[2, 2]), atan2(turn[1, 0], turn[0, 0])
        both = np.array([[roll, pitch, yaw], [roll + pi, pi - pitch, yaw + pi]])
    both = both + 2 * pi * np.round((near - both) / (2 * pi))
    return [float(x) for x in both[np.abs(both - near).sum(axis=1).argmin()]]
