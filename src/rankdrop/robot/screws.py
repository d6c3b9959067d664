"""Robots from ordered screw sets of any pitch, also as a plain list, one screw a line; the screws of usual joints."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import RobotError
from rankdrop.robot.dh import described_robot, joint_kind
from rankdrop.robot.files import LARGEST_NUMBER, LARGEST_TABLE, name_of_file, read_text
from rankdrop.robot.model import Array, Joint, JointKind, Robot, Source, check_joints, screw_of
from rankdrop.robot.note import NoteOn, RobotNote
from rankdrop.robot.quantities import Angles, quantity
from rankdrop.robot.square_up import as_intended
from rankdrop.robot.transform import dot, frame_on_axis, norm, rigid, unmasked

Order = Literal["linear-first", "angular-first"]
ORDERS = ("linear-first", "angular-first")

_NO_PITCH = 1e-9  # share of |S| below which an angular part or a pitch is rounding
_SOME_PITCH = 1e-4  # share above which it is meant; between the two the kind must be given

_ENTRY = re.compile(r"[^\s,;\[\]]+")


def revolute(axis: ArrayLike, point: ArrayLike) -> Array:
    """(6,) screw (p × ω; ω) of a revolute joint about `axis` through `point` [m]."""
    return helical(axis, point, 0.0)


def prismatic(axis: ArrayLike) -> Array:
    """(6,) screw (v; 0) of a prismatic joint along `axis`."""
    return screw_of(JointKind.PRISMATIC, _unit(axis), np.zeros(3))


def helical(axis: ArrayLike, point: ArrayLike, pitch: float) -> Array:
    """(6,) screw (p × ω + hω; ω) of a helical joint of pitch h [m/rad]."""
    return screw_of(JointKind.HELICAL, _unit(axis), _vector(point, "point"), pitch)


def cylindrical(axis: ArrayLike, point: ArrayLike) -> Array:
    """(2, 6) a cylindrical joint as a prismatic and a revolute joint on one axis (they commute)."""
    return np.stack([prismatic(axis), revolute(axis, point)])


def spherical(centre: ArrayLike, axes: ArrayLike = ((1, 0, 0), (0, 1, 0), (0, 0, 1))) -> Array:
    """(3, 6) a spherical joint as three revolute joints that meet in `centre`.

    The three angles are one chart of the rotations: where turning the second joint makes the first and third axis
    parallel (±π/2 for axes at right angles) the chart is singular, although the joint itself is not.

    Raises:
        RobotError: the three axes lie in a plane.
    """
    turns = np.stack([revolute(axis, centre) for axis in np.asarray(axes, dtype=np.float64).reshape(-1, 3)])
    if turns.shape[0] != 3 or abs(float(np.linalg.det(turns[:, 3:]))) < 1e-6:
        raise RobotError("a spherical joint has three independent axes", got=np.asarray(axes).tolist())
    return turns


def from_screws(
    screws: ArrayLike,
    *,
    order: Order,
    kinds: str | Sequence[str] | None = None,
    names: Sequence[str] | None = None,
    lower: Sequence[float] | None = None,
    upper: Sequence[float] | None = None,
    velocity: Sequence[float] | None = None,
    home: ArrayLike | None = None,
    name: str = "robot",
    **described: Any,
) -> Robot:
    """A robot from its joint screws at q = 0, base to tip, in the base frame with the base origin as reference point.

    Each screw is brought to the form stated at `Joint.screw`: |ω| = 1 (|v| = 1 for a prismatic joint), linear part
    first. The moment of a revolute screw is v = p × ω (GR writes the same as ω × r with r from the axis to the origin).

    Args:
        screws: (N, 6) of any length and any pitch h = ω·v/|ω|².
        order: "linear-first" (v; ω) as in AM, or "angular-first" (ω; v) as in GR and KG. There is no default.
        kinds: "RPRRRR", or a list of "revolute", "prismatic", "helical"; without it, the kind is read off the screw.
        names, lower, upper, velocity: one per joint [rad or m]; "joint1" … and ±inf by default.
        home: (4, 4) pose of the tip at q = 0; without it the tip is taken at the base origin, and a note says so.
        name, described: name, task, source, notes, about, lengths, as in `Robot`.

    Raises:
        RobotError: wrong shape, values that are not finite, no length, a pitch that contradicts the kind or is too
            small to tell from rounding.

    Example:
        >>> robot = from_screws([[0, 0, 2, 0, 0, 0], [0, 0, 0, 0, 1, 0]], order="angular-first")
        >>> [str(joint.kind) for joint in robot.joints], robot.joints[0].screw
        (['revolute', 'prismatic'], array([0., 0., 0., 0., 0., 1.]))
    """
    rows = _rows(screws, order, name)
    count = len(rows)
    columns = {"kinds": kinds, "names": names, "lower": lower, "upper": upper, "velocity": velocity}
    for label, given in columns.items():
        if given is not None and len(given) != count:
            raise RobotError(f"{label} has one entry per screw", where=f"robot {name!r}", got=len(given), allowed=count)
    joints = []
    for i, row in enumerate(rows):
        if names is not None:
            label = names[i]
        else:
            label = f"joint{i + 1}"
        kind, screw = _normalise(row, None if kinds is None else kinds[i], f"screw {i + 1} ({label})")
        limits = _item(lower, i, -inf), _item(upper, i, inf), _item(velocity, i, inf)
        joint = Joint(label, kind, screw, *limits)
        joints.append(replace(joint, frame=frame_on_axis(joint.axis, joint.foot)))
    if home is None:
        pose = np.eye(4)
    else:
        pose = rigid(home, f"home pose of robot {name!r}")
    origin = Source("screws", f'from_screws(order="{order}")')
    robot = described_robot(name, joints, pose, described | {"source": described.get("source") or origin})
    if home is not None:
        return robot
    return replace(robot, notes=(*robot.notes, RobotNote(NoteOn.NO_HOME)))


def _rows(screws: ArrayLike, order: str, name: str) -> Array:
    if order not in ORDERS:
        raise RobotError(
            "the order of the screws must be named", where=f"robot {name!r}", got=repr(order),
            allowed='"linear-first" (v; ω) or "angular-first" (ω; v)',
        )
    try:
        rows = np.array(unmasked(screws, "screws"), dtype=np.float64)
    except (TypeError, ValueError):
        raise RobotError("the screws are not numbers", where=f"robot {name!r}", allowed="shape (N, 6)") from None
    if rows.ndim != 2 or rows.shape[1] != 6:
        raise RobotError("the screws have the wrong shape", where=f"robot {name!r}", got=rows.shape, allowed="(N, 6)")
    for number, row in enumerate(rows, 1):
        if not np.isfinite(row).all():
            raise RobotError("the screw has values that are not finite", where=f"screw {number}", got=row.tolist())
        if np.abs(row).max() > LARGEST_NUMBER:
            raise RobotError("the screw is too large", where=f"screw {number}", got=row.tolist())
    if order == "linear-first":
        return rows
    return np.roll(rows, 3, axis=1)


def _normalise(screw: Array, kind: Any, where: str) -> tuple[JointKind, Array]:
    v, omega = screw[:3], screw[3:]
    size, turn = norm(screw), norm(omega)
    if size < 1e-9:
        raise RobotError("the screw has no length", where=where, got=screw.tolist(), allowed="a non-zero screw")
    if kind is None:
        wanted = None
    else:
        wanted = joint_kind(kind, where)
    slides = _is_zero(turn / size, wanted is JointKind.PRISMATIC, where, "angular part")
    if wanted is not None and slides is not (wanted is JointKind.PRISMATIC):
        raise RobotError(f"the screw is not {wanted.value}", where=where, got=screw.tolist())
    if slides:
        return JointKind.PRISMATIC, np.concatenate([_unit(v), np.zeros(3)])
    omega, v = omega / turn, v / turn
    pitch = dot(omega, v)
    straight = wanted is not JointKind.HELICAL and _is_zero(
        abs(pitch) / max(1.0, norm(v)), wanted is JointKind.REVOLUTE, where, "pitch"
    )
    if wanted is JointKind.REVOLUTE and not straight:
        raise RobotError("a revolute screw has no pitch", where=where, got=f"{pitch} m/rad", mend='kind = "helical"')
    if straight and pitch != 0.0:
        v = v - pitch * omega
    return JointKind.REVOLUTE if straight else JointKind.HELICAL, np.concatenate([v, omega]) + 0.0


def _is_zero(share: float, told: bool, where: str, what: str) -> bool:
    """Is this part of the screw zero? Given the kind, printed digits are forgiven; else only rounding is."""
    if share <= _NO_PITCH or (told and share < _SOME_PITCH):
        return True
    if share < _SOME_PITCH:
        raise RobotError(
            f"the {what} is too small to tell from rounding", where=where, got=f"{share:.3g} of the whole",
            mend="give the kind of this joint",
        )
    return False


def _unit(axis: ArrayLike) -> Array:
    vector = _vector(axis, "axis")
    length = norm(vector)
    if length < 1e-9:
        raise RobotError("the axis has no length", got=vector.tolist(), allowed="a non-zero axis")
    if abs(length - 1.0) <= 1e-15:
        return vector
    return vector / length


def _vector(value: ArrayLike, what: str) -> Array:
    vector = np.array(unmasked(value, what), dtype=np.float64)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise RobotError(f"the {what} is three finite numbers", got=vector.tolist())
    return vector


def _item(values: Sequence[float] | None, i: int, default: float) -> float:
    if values is None:
        return default
    return float(values[i])


def read_screw_list(path: Path) -> Array:
    """(n, 6) the numbers of a text file, six a line, in the order of the file.

    Numbers are parted by blanks, commas or semicolons, square brackets do not count, # begins a comment, empty lines
    are skipped. A number may be arithmetic without blanks: 1/sqrt(2).

    Raises:
        RobotError: no screws, a line without six numbers, something that is not a number (line and column are told).
    """
    return _screws_with_lines(path)[0]


def _screws_with_lines(path: Path) -> tuple[Array, list[int]]:
    """The numbers, and the line each screw stands in."""
    rows, lines = [], []
    for number, line in enumerate(read_text(path, largest=LARGEST_TABLE).splitlines(), 1):
        text = line.split("#", 1)[0]
        entries = list(_ENTRY.finditer(text))
        if not entries:
            continue
        where = f"{path}, line {number}"
        values = [
            quantity(_number(entry[0]), "number", where=f"{where}, column {entry.start() + 1}") for entry in entries[:7]
        ]
        if len(values) != 6:
            if len(values) > 6:
                column = entries[6].start() + 1
            else:
                column = len(text.rstrip()) + 1
            raise RobotError(
                "a screw has six numbers (direction; moment)", where=f"{where}, column {column}", got=len(entries),
                mend={4: "rows of four numbers of a DH table need a heading: a, alpha, d, theta"}.get(len(entries)),
            )
        rows.append(values)
        lines.append(number)
        check_joints(len(rows), where)
    if not rows:
        raise RobotError("there are no screws in the file", where=str(path), allowed="six numbers a line")
    return np.array(rows), lines


def is_screw_list(text: str) -> bool:
    """Whether a text begins, after comments, as such a file does: with a number."""
    for line in text.splitlines():
        entries = _ENTRY.findall(line.split("#", 1)[0])
        if entries:
            try:
                quantity(_number(entries[0]), "number", where="")
            except RobotError:
                return False
            return "=" not in line and not line.lstrip().startswith("[[")
    return False


def from_screw_list(path: Path, *, name: str | None = None, as_written: bool = False) -> Robot:
    """The arm whose screws a plain file lists, base to tip, at the configuration they were written down at: q = 0.

    Args:
        path: six numbers a line, direction first: (s; s_o), s_o = p × s for a line through p, about the base origin.
        name: of the arm; None takes that of the file.
        as_written: keep noise of 2e-5 rad and 2 µm.

    Raises:
        RobotError: as `read_screw_list`; a screw that is no joint's (the line is told).
    """
    rows, lines = _screws_with_lines(path)
    for screw, line in zip(rows, lines, strict=True):
        try:
            from_screws(screw[None], order="angular-first")
        except RobotError as error:
            raise RobotError(**error.parts | {"where": f"{path}, line {line}"}) from error
    notes = (RobotNote(NoteOn.SCREW_LINES),)
    robot = from_screws(rows, order="angular-first", name=name or name_of_file(path), notes=notes)
    return as_intended(robot, Angles(as_written=as_written))


def _number(text: str) -> float | str:
    try:
        return float(text)  # also 1e-3 with a sign, which arithmetic would not take
    except ValueError:
        return text
