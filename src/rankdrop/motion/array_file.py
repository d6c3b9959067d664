"""A joint trajectory from NumPy's files: one array of samples, or an archive with times, velocities and names."""

from __future__ import annotations

import warnings
import zlib
from collections.abc import Mapping
from pathlib import Path
from tokenize import TokenError
from typing import Any
from zipfile import BadZipFile, ZipFile, is_zipfile

import numpy as np
from numpy.lib.format import MAGIC_PREFIX

from rankdrop.motion.trajectory import (
    ROW_SECONDS,
    Trajectory,
    TrajectoryError,
    checked,
    checked_times,
    joint_names,
    turning,
)
from rankdrop.robot.files import LARGEST_ARRAY, MOST_ROWS
from rankdrop.robot.model import Array, Robot

POSITIONS, TIMES, VELOCITIES, ACCELERATIONS, NAMES = (
    ("q", "positions", "position"), ("t", "time", "times"), ("qd", "velocities", "velocity"),
    ("qdd", "accelerations", "acceleration"), ("joint_names", "names", "joints"),
)  # fmt: skip
"""Names that an array may have in an archive."""
_DAMAGED = (ValueError, TypeError, EOFError, BadZipFile, NotImplementedError, MemoryError, OverflowError, SyntaxError,
            RecursionError, RuntimeError, TokenError, zlib.error)  # fmt: skip
"""What NumPy raises over a file that is none: its headers are parsed as Python's literals."""
_MOST = f"at most {LARGEST_ARRAY // 2**20} MB"


def read_arrays(path: Path, robot: Robot, *, deg: bool = False) -> Trajectory:
    """A trajectory from a .npy file (T, n), or (T, n + 1) with a rising time in front; or from an .npz archive.

    Args:
        path: the file.
        robot: whose joints they are; in the order of the arm unless the archive has `joint_names`.
        deg: angles are in degrees.

    Raises:
        TrajectoryError: with file and row.
    """
    where = str(path)
    loaded = _load(path)
    if isinstance(loaded, np.ndarray):
        q = _numbers(loaded, where)
        if q.ndim == 2 and q.shape[1] == robot.n + 1 and len(q) > 1 and bool((q[1:, 0] > q[:-1, 0]).all()):
            return arranged(where, robot, q[:, 1:], q[:, 0], deg=deg)
        return arranged(where, robot, q, deg=deg)
    parts = {kind[0]: _part(loaded, kind, where) for kind in (POSITIONS, TIMES, VELOCITIES, ACCELERATIONS)}
    names = _member(loaded, NAMES)
    if parts["q"] is None:
        raise TrajectoryError("the archive has no positions", where=where, got=", ".join(loaded) or "nothing",
                              allowed=" or ".join(POSITIONS))  # fmt: skip
    listed = None if names is None else [str(name) for name in np.asarray(names).reshape(-1)]
    return arranged(where, robot, parts["q"], parts["t"], parts["qd"], parts["qdd"], listed, deg=deg)


def _load(path: Path) -> Array | Mapping[str, Any]:
    """The array, or those of the archive that are read; an archive tells how large each of them is before it is."""
    try:
        if path.stat().st_size > LARGEST_ARRAY:
            raise TrajectoryError("the file is too large", where=str(path), allowed=_MOST)
        with path.open("rb") as file:
            begin = file.read(len(MAGIC_PREFIX))
        if begin == MAGIC_PREFIX:  # an array may hold the bytes of an archive, too
            with warnings.catch_warnings():  # a header of Python 2 is read as any other
                warnings.simplefilter("ignore", UserWarning)
                return np.asarray(np.load(path, allow_pickle=False))
        if not is_zipfile(path):
            raise TrajectoryError("this is not a file of NumPy's", where=str(path), got=repr(begin))
        wanted = {name for kind in (POSITIONS, TIMES, VELOCITIES, ACCELERATIONS, NAMES) for name in kind}
        with ZipFile(path) as archive:
            members = [(one.filename.removesuffix(".npy"), one.file_size) for one in archive.infolist()]
        names = [name for name, _ in members]
        for name in [name for name in names if names.count(name) > 1][:1]:  # NumPy would read the other one
            raise TrajectoryError("two arrays of the archive have the same name", where=f"{path}, {name}",
                                  mend="name each array once")  # fmt: skip
        if sum(size for name, size in members if name in wanted) > LARGEST_ARRAY:
            largest, _ = max(((name, size) for name, size in members if name in wanted), key=lambda one: one[1])
            raise TrajectoryError("the array is too large", where=f"{path}, {largest}", allowed=_MOST)
        with np.load(path, allow_pickle=False) as loaded:
            return {name: loaded[name] if name in wanted else None for name in loaded}
    except OSError as error:
        raise TrajectoryError(f"the file cannot be read: {error.strerror or error}", where=str(path)) from None
    except _DAMAGED as error:
        raise TrajectoryError("this is not a file of NumPy's", where=str(path), got=str(error)[:80]) from None


def _member(archive: Mapping[str, Any], names: tuple[str, ...]) -> Any:
    return next((archive[name] for name in names if name in archive), None)


def _part(archive: Mapping[str, Any], names: tuple[str, ...], where: str) -> Array | None:
    value = _member(archive, names)
    return None if value is None else _numbers(value, f"{where}, {names[0]}")


def _numbers(value: Any, where: str) -> Array:
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        kind = np.asarray(value).dtype
        raise TrajectoryError("these are no numbers", where=where, got=f"an array of {kind}") from None


def arranged(
    where: str,
    robot: Robot,
    q: Array,
    times: Array | None = None,
    velocities: Array | None = None,
    accelerations: Array | None = None,
    names: list[str] | None = None,
    *,
    deg: bool = False,
) -> Trajectory:
    """A trajectory of an arm from arrays: shapes, names, values and times checked, joints in the arm's order.

    Args:
        where: the file, for errors.
        robot: the arm.
        q, velocities, accelerations: (T, columns) each.
        times: (T,) [s].
        names: of the columns; None: the arm's joints in order.
        deg: angles are in degrees.

    Raises:
        TrajectoryError: with file and row.
    """
    wanted = [joint.name for joint in robot.variables]
    width = robot.n if names is None else len(names)
    if len(q) > MOST_ROWS:
        raise TrajectoryError("there are too many rows", where=where, got=len(q), allowed=f"at most {MOST_ROWS}")
    if q.ndim != 2 or not len(q) or q.shape[1] != width:
        raise TrajectoryError("the positions have another shape than the arm", where=where, got=f"shape {q.shape}",
                              allowed=f"one row for each sample, {width} columns: {joint_names(robot)}")  # fmt: skip
    columns = list(range(robot.n))
    if names is not None:
        twice = sorted({name for name in names if names.count(name) > 1})
        missing = [name for name in wanted if name not in names]
        if twice or missing:
            raise TrajectoryError(
                "a joint is named twice" if twice else "joints are missing", where=where, got=", ".join(names),
                allowed=", ".join(wanted),
                mend=f"name {', '.join(twice)} once" if twice else f"add {', '.join(missing)}",
            )  # fmt: skip
        columns = [names.index(name) for name in wanted]
    factors = np.where(turning(robot), np.pi / 180 if deg else 1.0, 1.0)
    parts = []
    for part, what in ((q, "the position"), (velocities, "the velocity"), (accelerations, "the acceleration")):
        if part is not None and part.shape != q.shape:
            raise TrajectoryError(f"{what} has another shape than the positions", where=where,
                                  got=f"shape {part.shape}", allowed=f"shape {q.shape}")  # fmt: skip
        parts.append(None if part is None else checked(part[:, columns], where, robot, what, factors=factors))
    timed = times is not None
    if times is None:
        times = np.arange(len(q), dtype=np.float64) * ROW_SECONDS
    if times.shape != (len(q),):
        raise TrajectoryError("there is one time for each row", where=where, got=f"shape {times.shape}",
                              allowed=f"shape ({len(q)},)")  # fmt: skip
    checked_times(times, [f"{where}, row {row + 1}" for row in range(len(q))] if timed else [])
    unused = tuple(name for name in names or () if name not in wanted)
    positions = parts[0] if parts[0] is not None else q
    return Trajectory(Path(where).name, times, positions, timed, unused, parts[1], parts[2])
