"""A joint trajectory as data: what every reader makes and every check takes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rankdrop.errors import ConfigurationError
from rankdrop.path.curve import Curve, curve
from rankdrop.robot.files import LARGEST_ANGLE, LARGEST_LENGTH, LARGEST_TIME, MOST_ROWS, allowed_range
from rankdrop.robot.model import Array, Robot
from rankdrop.text.path_files import MATRIX_SHAPE, QUATERNIONS_AS_TEXT, radians_hint
from rankdrop.text.words import MOST_TURNS, degrees_hint

BAGS = (".bag", ".db3", ".mcap")
ROW_SECONDS = 0.1  # between rows of a file without times
_PARTS = {"q": "the position", "qd": "the velocity", "qdd": "the acceleration"}


def is_bag(path: Path) -> bool:
    """Whether it is a bag: a file by its ending, or the folder of a ROS 2 recording."""
    if path.is_dir():
        return (path / "metadata.yaml").is_file()
    return path.suffix.lower() in BAGS


class TrajectoryError(ConfigurationError):
    """A trajectory file that cannot be read: names file, row or line, and column."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Joint values over time.

    Attributes:
        name: of the file.
        times: (T,) increasing [s]; 0.1 s apart where the file has none (`timed` is False).
        q: (T, n) [rad, m].
        timed: whether the file gives times.
        unused: columns or joints of the file that this arm does not have.
        velocities, accelerations: (T, n) [rad/s, rad/s², m …]; None where the file has none.
        notes: what a reader should know of how the file was read.
        bare: whether neither the file nor its format states the unit of any angle.
    """

    name: str
    times: Array
    q: Array
    timed: bool
    unused: tuple[str, ...]
    velocities: Array | None = None
    accelerations: Array | None = None
    notes: tuple[str, ...] = ()
    bare: bool = False

    def curve(self, interpolate: str) -> Curve:
        """The curve that a controller makes of the rows."""
        return curve(self.q, self.times, self.velocities, self.accelerations, interpolate)

    def at(self, time: float) -> Array:
        """(n,) joint values at a time [s], straight between rows, held before the first and after the last."""
        return np.array([np.interp(time, self.times, column) for column in self.q.T])


def joint_names(robot: Robot) -> str:
    """Every name that a joint may be given by, for an error."""
    return ", ".join(joint.name for joint in robot.variables) + f" (or q1 … q{robot.n})"


def turning(robot: Robot) -> Array:
    """(n,) which variables are angles."""
    return np.array([joint.unit == "rad" for joint in robot.variables])


def rows_of(where: str, robot: Robot) -> Callable[[int, int], str]:
    """Names of rows and joints, counted from 0, for errors."""
    return lambda row, joint: f"{where}, row {row + 1}, joint {robot.variables[joint].name!r}"


def check_values(
    values: Array, robot: Robot, place: Callable[[int, int], str], what: str = "the value", *,
    factors: Array | None = None,
) -> Array:  # fmt: skip
    """Values (T, n), all finite and, times the factors, in the range of angles and lengths.

    Args:
        values: as they are in the file.
        robot: the arm.
        place: of a row and a joint, for an error.
        what: they are, in words.
        factors: (n,) to rad and m.

    Raises:
        TrajectoryError: one is not.
    """
    _refuse_first(values, ~np.isfinite(values), robot, place, f"{what} is not finite")
    if factors is None:
        made = values
    else:
        made = values * factors
    most = np.where(turning(robot), LARGEST_ANGLE, LARGEST_LENGTH)
    _refuse_first(values, np.abs(made) > most, robot, place, f"{what} is too large", ranged=True)
    return made


def _refuse_first(
    values: Array, wrong: NDArray[np.bool_], robot: Robot, place: Callable[[int, int], str], problem: str, *,
    ranged: bool = False,
) -> None:  # fmt: skip
    """Raise of the first value (T, n) that is wrong, if one is; with the range of its kind where `ranged`."""
    for row, joint in np.argwhere(wrong)[:1].tolist():
        if not ranged:
            allowed = None
        elif robot.variables[joint].unit == "rad":
            allowed = allowed_range("angle")
        else:
            allowed = allowed_range("length")
        raise TrajectoryError(problem, where=place(row, joint), got=f"{values[row, joint]:g}", allowed=allowed)


def check_times(times: Array, where: Callable[[int], str]) -> Array:
    """Times (T,), finite, in their range, and increasing.

    Args:
        times: [s].
        where: name of a row, counted from 0, for an error.

    Raises:
        TrajectoryError: one is not finite, too large, or not after the one before it.
    """
    for i in np.flatnonzero(~np.isfinite(times))[:1].tolist():
        raise TrajectoryError("the time is not finite", where=where(i), got=times[i])
    for i in np.flatnonzero(np.abs(times) > LARGEST_TIME)[:1].tolist():
        raise TrajectoryError("the time is too large", where=where(i), got=times[i],
                              allowed=f"-{LARGEST_TIME:g} … {LARGEST_TIME:g} s")  # fmt: skip
    for i in np.flatnonzero(np.diff(times) <= 0)[:1].tolist():
        raise TrajectoryError("time does not go on", where=where(i + 1), got=f"{times[i + 1]:g} after {times[i]:g}",
                              allowed="times that increase")  # fmt: skip
    return times


def increasing(values: Array) -> bool:
    """Whether values are finite, and each is larger than the one before it."""
    return bool(np.isfinite(values).all() and (np.diff(values) > 0).all())


def regular_times(count: int) -> Array:
    """(T,) times of rows that have none [s]."""
    return np.arange(count, dtype=np.float64) * ROW_SECONDS


def trajectory_from_arrays(
    where: str, robot: Robot, columns: Mapping[str, Array | None], names: list[str] | None = None, *, deg: bool = False
) -> Trajectory:
    """A trajectory of an arm from arrays: shapes, names, values and times checked, joints in the arm's order.

    Args:
        where: the file, for errors.
        robot: the arm.
        columns: q and, where there are any, qd and qdd, (T, columns) each, and t, (T,) times [s].
        names: of the joints of q, qd and qdd; None: the arm's joints in order.
        deg: angles are in degrees.

    Raises:
        TrajectoryError: with file and row.
    """
    q, times = columns["q"], columns.get("t")
    if names is None:
        q = _positions(where, robot, q, robot.n)
        order = list(range(robot.n))
    else:
        q = _positions(where, robot, q, len(names))
        order = _order_of_joints(where, robot, names)
    factors = np.where(turning(robot), np.pi / 180 if deg else 1.0, 1.0)
    parts: dict[str, Array] = {}
    for key, what in _PARTS.items():
        part = columns.get(key)
        if part is None:
            continue
        if part.shape != q.shape:
            raise TrajectoryError(f"{what} has another shape than the positions", where=where,
                                  got=f"shape {part.shape}", allowed=f"shape {q.shape}")  # fmt: skip
        parts[key] = check_values(part[:, order], robot, rows_of(where, robot), what, factors=factors)
    if times is None:
        when = regular_times(len(q))
    else:
        when = _one_for_each_row(times, len(q), where)
    wanted = {joint.name for joint in robot.variables}
    others = tuple(name for name in names or () if name not in wanted)
    return Trajectory(Path(where).name, when, parts["q"], times is not None, others, parts.get("qd"), parts.get("qdd"))


def _one_for_each_row(times: Array, rows: int, where: str) -> Array:
    """The times (T,), checked: one for each row, and increasing.

    Raises:
        TrajectoryError: with file and row.
    """
    if times.shape != (rows,):
        raise TrajectoryError("there is one time for each row", where=where, got=f"shape {times.shape}",
                              allowed=f"shape ({rows},)")  # fmt: skip
    check_times(times, lambda row: f"{where}, row {row + 1}")
    return times


def _positions(where: str, robot: Robot, q: Array | None, width: int) -> Array:
    """The positions, a row for each sample and as many columns as they are to have.

    Raises:
        TrajectoryError: none, of another shape, or too many.
    """
    if q is None or q.ndim != 2 or not len(q) or q.shape[1] != width:
        raise TrajectoryError("the positions have another shape than the arm", where=where,
                              got="none" if q is None else f"shape {q.shape}",
                              allowed=f"one row for each sample, {width} columns: {joint_names(robot)}",
                              mend=_matrix_shape(q))  # fmt: skip
    if len(q) > MOST_ROWS:
        raise TrajectoryError("there are too many rows", where=where, got=len(q), allowed=f"at most {MOST_ROWS}")
    return q


def _matrix_shape(q: Array | None) -> str:
    """What makes rows of twelve or sixteen numbers matrices of poses, and of seven poses; nothing for others."""
    if q is not None and q.ndim == 2 and q.shape[1] == 7:
        return QUATERNIONS_AS_TEXT
    if q is None or q.ndim != 2 or q.shape[1] not in (12, 16):
        return ""
    return MATRIX_SHAPE.format(q.shape[1] // 4)


def _order_of_joints(where: str, robot: Robot, names: list[str]) -> list[int]:
    """Columns of the arm's joints."""
    wanted = [joint.name for joint in robot.variables]
    counts = Counter(names)
    twice = sorted(name for name, count in counts.items() if count > 1)
    missing = [name for name in wanted if name not in counts]
    if twice or missing:
        raise TrajectoryError(
            "a joint is named twice" if twice else "joints are missing", where=where, got=", ".join(names),
            allowed=", ".join(wanted), mend=f"name {', '.join(twice)} once" if twice else f"add {', '.join(missing)}",
        )  # fmt: skip
    return [names.index(name) for name in wanted]


def unit_hint(q: Array, robot: Robot, *, deg: bool = False) -> str | None:
    """A line of warning where angles look as if they were in the other unit; None where they do not.

    Args:
        q: (T, n) [rad, m].
        robot: whose joints they are.
        deg: the angles were read as degrees.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> unit_hint(np.array([[0.0, 90.0]]), open_robot("planar2r"))
        'angles up to 90 look like degrees and are read as radians'
    """
    if deg:
        return radians_hint(q[:, turning(robot)])
    return degrees_hint(q, robot)


def refuse_degrees(read: Trajectory, robot: Robot, file: Path) -> None:
    """Refuse angles that look like degrees and were read as radians, where the file states no unit.

    Arrays of joints without limits are not refused: such a joint may turn often, and an array has no place for a unit.

    Args:
        read: without `deg`.
        robot: the arm.
        file: it was read from.

    Raises:
        TrajectoryError: with the first row that has such an angle.
    """
    array = file.suffix.lower() in (".npy", ".npz")
    turns = np.array([variable.unit == "rad" for variable in robot.variables])
    if array:
        turns &= np.isfinite(robot.lower) | np.isfinite(robot.upper)
    beyond = (np.abs(read.q) > MOST_TURNS) & turns
    if not read.bare or not beyond.any():
        return
    row, joint = np.argwhere(beyond)[0]
    name, where, got = robot.variables[joint].name, f"{file}, row {row + 1}", f"{read.q[row, joint]:.6g}"
    if array:
        raise TrajectoryError("angles look like degrees", where=where, got=got, allowed="radians", mend="deg=True",
                              typed="add --deg")  # fmt: skip
    raise TrajectoryError("angles look like degrees", where=where, got=got, allowed="radians",
                          mend=f'deg=True, or name the column "{name} [rad]"',
                          typed=f'add --deg, or name the column "{name} [rad]"')  # fmt: skip
