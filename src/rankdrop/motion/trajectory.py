"""A joint trajectory as data: what every reader makes, and every check takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rankdrop.errors import ConfigurationError
from rankdrop.motion.curve import Curve, curve
from rankdrop.results.explanation.words import degrees_hint
from rankdrop.robot.files import LARGEST_ANGLE, LARGEST_LENGTH, LARGEST_TIME, MOST_ROWS, allowed_range
from rankdrop.robot.model import Array, Joint, Robot

ROW_SECONDS = 0.1  # between rows of a file without times


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
    """

    name: str
    times: Array
    q: Array
    timed: bool
    unused: tuple[str, ...]
    velocities: Array | None = None
    accelerations: Array | None = None
    notes: tuple[str, ...] = ()

    def curve(self, interpolate: str) -> Curve:
        """The curve that a controller makes of the rows."""
        return curve(self.q, self.times, self.velocities, self.accelerations, interpolate)

    def at(self, time: float) -> Array:
        """(n,) joint values at a time [s], straight between rows, held before the first and after the last."""
        return np.array([np.interp(time, self.times, column) for column in self.q.T])


def csv_text(names: Sequence[str], q: Array, times: Array | None = None) -> str:
    """Rows of joint values as CSV, to the last bit, with a column of times in front where there are any."""
    rows = q if times is None else np.column_stack([times, q])
    head = names if times is None else ("time", *names)
    return "\n".join([",".join(head), *(",".join(map(repr, row)) for row in rows.tolist())]) + "\n"


def joint_names(robot: Robot) -> str:
    """Every name that a joint may be given by, for an error."""
    return ", ".join(joint.name for joint in robot.variables) + f" (or q1 … q{robot.n})"


def turning(robot: Robot) -> Array:
    """(n,) which variables are angles."""
    return np.array([joint.unit == "rad" for joint in robot.variables])


def too_large(values: Array, robot: Robot) -> NDArray[np.intp]:
    """(k, 2) rows and joints of the values (T, n) that are beyond the range of angles and lengths [rad, m]."""
    most = np.where(turning(robot), LARGEST_ANGLE, LARGEST_LENGTH)
    return np.argwhere(~(np.abs(values) <= most))


def checked(values: Array, where: str, robot: Robot, what: str = "the value", *, factors: Array | None = None) -> Array:
    """Values (T, n), all finite and, times the factors, in the range of angles and lengths.

    Args:
        values: as they are in the file.
        where: the file, for an error.
        robot: the arm.
        what: they are, in words.
        factors: (n,) to rad and m.

    Raises:
        TrajectoryError: one is not; names its row, from 1, and its joint.
    """
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        row, joint = (int(i) for i in bad[0])
        raise TrajectoryError(
            f"{what} is not finite", where=f"{where}, row {row + 1}, joint {robot.variables[joint].name!r}",
            got=values[row, joint],
        )  # fmt: skip
    made = values if factors is None else values * factors
    for row, joint in too_large(made, robot)[:1]:
        raise TrajectoryError(
            f"{what} is too large", where=f"{where}, row {row + 1}, joint {robot.variables[joint].name!r}",
            got=values[row, joint], allowed=joint_range(robot.variables[joint]),
        )  # fmt: skip
    return made


def joint_range(joint: Joint) -> str:
    """The range of a joint's values, in words."""
    return allowed_range("angle" if joint.unit == "rad" else "length")


def checked_times(times: Array, where: list[str]) -> Array:
    """Times (T,), finite, in their range, and increasing.

    Args:
        times: [s].
        where: of each row, for an error.

    Raises:
        TrajectoryError: one is not finite, too large, or not after the one before it.
    """
    for i in np.flatnonzero(~np.isfinite(times))[:1]:
        raise TrajectoryError("the time is not finite", where=where[i], got=times[i])
    for i in np.flatnonzero(np.abs(times) > LARGEST_TIME)[:1]:
        raise TrajectoryError("the time is too large", where=where[i], got=times[i],
                              allowed=f"-{LARGEST_TIME:g} … {LARGEST_TIME:g} s")  # fmt: skip
    for i in np.flatnonzero(np.diff(times) <= 0)[:1]:
        raise TrajectoryError("time does not go on", where=where[i + 1], got=f"{times[i + 1]:g} after {times[i]:g}",
                              allowed="times that increase")  # fmt: skip
    return times


def arranged(
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
    wanted = [joint.name for joint in robot.variables]
    width = robot.n if names is None else len(names)
    q, times = columns["q"], columns.get("t")
    if q is None or q.ndim != 2 or not len(q) or q.shape[1] != width:
        raise TrajectoryError("the positions have another shape than the arm", where=where,
                              got="none" if q is None else f"shape {q.shape}",
                              allowed=f"one row for each sample, {width} columns: {joint_names(robot)}")  # fmt: skip
    if len(q) > MOST_ROWS:
        raise TrajectoryError("there are too many rows", where=where, got=len(q), allowed=f"at most {MOST_ROWS}")
    chosen = list(range(robot.n))
    if names is not None:
        twice = sorted({name for name in names if names.count(name) > 1})
        missing = [name for name in wanted if name not in names]
        if twice or missing:
            raise TrajectoryError(
                "a joint is named twice" if twice else "joints are missing", where=where, got=", ".join(names),
                allowed=", ".join(wanted),
                mend=f"name {', '.join(twice)} once" if twice else f"add {', '.join(missing)}",
            )  # fmt: skip
        chosen = [names.index(name) for name in wanted]
    factors = np.where(turning(robot), np.pi / 180 if deg else 1.0, 1.0)
    parts = []
    for key, what in (("q", "the position"), ("qd", "the velocity"), ("qdd", "the acceleration")):
        part = columns.get(key)
        if part is not None and part.shape != q.shape:
            raise TrajectoryError(f"{what} has another shape than the positions", where=where,
                                  got=f"shape {part.shape}", allowed=f"shape {q.shape}")  # fmt: skip
        parts.append(None if part is None else checked(part[:, chosen], where, robot, what, factors=factors))
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


def unit_hint(q: Array, robot: Robot, *, deg: bool = False) -> str | None:
    """A line of warning where angles look as if they were in the other unit; None where they do not.

    Args:
        q: (T, n) [rad, m].
        robot: whose joints they are.
        deg: the angles were read as degrees.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> unit_hint(np.array([[0.0, 90.0]]), open_robot("planar2r"))
        'angles up to 90 look like degrees and are taken as radians'
    """
    if not deg:
        return degrees_hint(q, robot)
    angles = q[:, turning(robot)]
    if not angles.size:
        return None
    typed = float(np.degrees(np.abs(angles).max()))
    moves = float(np.ptp(angles, axis=0).max()) > 0.0
    return f"angles up to {typed:.4g} look like radians and are taken as degrees" if moves and typed <= pi else None
