"""Robots from Denavit–Hartenberg tables, standard (distal) or modified (proximal).

First what an entry says about one joint, whatever the form of its table: keys, kind, limits, name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite, pi
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import RobotError
from rankdrop.robot.model import Array, Joint, JointKind, Robot, Source, screw_of
from rankdrop.robot.note import NoteOn, RobotNote, as_note
from rankdrop.robot.quantities import Angles, quantity
from rankdrop.robot.transform import rigid, rotation, times, translation

Where = Callable[[str], str]
"""Place of a key (or of the whole entry, for "") in words, for errors: "pa10.toml, line 12, joint 3, alpha"."""

_MANY_TURNS = 8 * pi  # [rad]; cables of real arms allow a few turns, and 30 deg is more than this
_LARGEST_DEGREES = 720.0
_LETTERS = {"R": JointKind.REVOLUTE, "P": JointKind.PRISMATIC, "H": JointKind.HELICAL}

Convention = Literal["standard", "modified"]
CONVENTIONS = ("standard", "modified")
DH_KEYS = ("a", "alpha", "d", "theta", "kind", "pitch", "name", "lower", "upper", "velocity")
_MEASURES = {"a": "length", "alpha": "angle", "d": "length", "theta": "angle", "pitch": "length"}


def check_keys(given: Iterable[str], allowed: Sequence[str], where: Where) -> None:
    """Refuse keys that nobody reads.

    Raises:
        RobotError: the first unknown key, with the allowed ones.
    """
    for key in given:
        if key not in allowed:
            raise RobotError("unknown key", where=where(key), got=repr(key), allowed=", ".join(allowed))


def joint_kind(kind: Any, where: str, more: Sequence[str] = ()) -> JointKind:
    """The `JointKind` named by a word, in capitals or not, or by its first letter in capitals (R, P, H).

    Raises:
        RobotError: there is no such kind; `more` lists what else the caller would have taken.
    """
    if isinstance(kind, str) and kind in _LETTERS:
        return _LETTERS[kind]
    try:
        return JointKind(kind.lower() if isinstance(kind, str) else kind)
    except (ValueError, TypeError):
        allowed = ", ".join([entry.value for entry in JointKind] + list(more))
        raise RobotError("there is no such kind of joint", where=where, got=repr(kind), allowed=allowed) from None


def limits(given: Mapping[str, Any], kind: JointKind, where: Where) -> dict[str, float]:
    """`lower`, `upper` and `velocity` of one joint as numbers [rad or m, per second]; ±inf where not given.

    Raises:
        RobotError: not a number, lower above upper, or a velocity that is not positive.
    """
    limits_read = {
        key: quantity(given.get(key, none), kind.measure, where=where(key), rate=key == "velocity", endless=True)
        for key, none in (("lower", -inf), ("upper", inf), ("velocity", inf))
    }
    if limits_read["lower"] > limits_read["upper"]:
        raise RobotError(
            "lower limit above upper limit", where=where("lower"), allowed="lower ≤ upper",
            got=f"lower {given['lower']}, upper {given['upper']}", mend="exchange or correct the two limits",
        )
    if limits_read["velocity"] <= 0.0:
        raise RobotError(
            "the largest velocity is not positive", where=where("velocity"), got=given["velocity"],
            allowed="a rate > 0", mend="leave the key out where it is not known",
        )
    return limits_read


def turn_notes(joints: Iterable[Joint], *, units: bool = True) -> list[RobotNote]:
    """Notes on revolute joints whose limits look like degrees taken for radians.

    Args:
        joints: of the arm.
        units: the file may say units; a URDF cannot, and its exporters write numbers above 720 where no limit is.
    """
    notes = []
    for joint in joints:
        most = max((abs(x) for x in (joint.lower, joint.upper) if isfinite(x)), default=0.0)
        if joint.kind is JointKind.REVOLUTE and _MANY_TURNS < most <= (inf if units else _LARGEST_DEGREES):
            kind = NoteOn.TURNS if units else NoteOn.TURNS_WITHOUT_UNITS
            notes.append(RobotNote(kind, joint.name, limits=(joint.lower, joint.upper)))
    return notes


def joint_name(given: Mapping[str, Any], number: int, where: Where) -> str:
    """The name of a joint, "joint3" for number 3 where it has none.

    Raises:
        RobotError: the name is not a text.
    """
    name = given.get("name")
    if name is None:
        return f"joint{number}"
    if not isinstance(name, str) or not name.strip():
        raise RobotError("the name of a joint is a text", where=where("name"), got=repr(name))
    return name


def relocate(error: RobotError, where: str) -> RobotError:
    """The same error at a place that its raiser could not know."""
    return RobotError(**error.parts | {"where": where})


@dataclass(frozen=True, slots=True)
class DHRow:
    """One row of a DH table and what is known about its joint.

    Attributes:
        a: link length [m]. alpha: link twist [rad]. In row i of a modified table these are a_{i−1} and α_{i−1}.
        d: joint distance [m]; of a prismatic joint the offset of its variable: the distance is d + q.
        theta: joint angle [rad]; of a revolute joint the offset of its variable: the angle is theta + q.
        kind: revolute, prismatic, or helical (angle theta + q, distance d + pitch · q).
        pitch: of a helical joint [m/rad].
        name: of the joint; "joint3" for row 3 if None.
        lower, upper: limits of q [rad or m].
        velocity: largest rate [rad/s or m/s].
    """

    a: float = 0.0
    alpha: float = 0.0
    d: float = 0.0
    theta: float = 0.0
    kind: JointKind = JointKind.REVOLUTE
    pitch: float = 0.0
    name: str | None = None
    lower: float = -inf
    upper: float = inf
    velocity: float = inf


def from_dh(
    rows: Sequence[DHRow | Mapping[str, Any] | Sequence[Any]],
    *,
    convention: Convention,
    kinds: str | Sequence[str] | None = None,
    base: ArrayLike | None = None,
    tool: ArrayLike | None = None,
    name: str = "robot",
    **described: Any,
) -> Robot:
    """A robot from its DH table.

    Pose of link i in link i − 1, with the offset form of the joint variable (see `DHRow`):

        standard:  Rz(θ_i) Tz(d_i) Tx(a_i) Rx(α_i)            joint i turns about z_{i−1}
        modified:  Rx(α_{i−1}) Tx(a_{i−1}) Rz(θ_i) Tz(d_i)    joint i turns about z_i

    `Joint.frame` is DH frame i at q = 0 in both conventions.

    Args:
        rows: one per joint: a `DHRow`, a mapping with its fields as keys, or (a, alpha, d, theta). Numbers in m and
            rad, or text such as "pi/2", "90 deg", "316 mm".
        convention: "standard" (as AM's tables) or "modified" (Craig; as KG's Figure 1). There is no default: the same
            numbers are another arm in the other convention.
        kinds: overrides the kinds of the rows: "RRPRRR", or a list of "revolute", "prismatic", "helical".
        base: (4, 4) pose of DH frame 0 in the base frame.
        tool: (4, 4) pose of the tip in the last DH frame.
        name, described: name, task, source, notes, about, lengths, as in `Robot`.

    Raises:
        RobotError: unknown convention, kind or key; a value that is not a finite number; a length beyond
            1000 km; a helical joint without pitch; lower above upper.

    Example:
        >>> from_dh([(1, 0, 0, 0), (1, 0, 0, "90 deg")], convention="standard").joints[1].screw
        array([ 0., -1.,  0.,  0.,  0.,  1.])
    """
    if convention not in CONVENTIONS:
        raise RobotError(
            "the DH convention must be named", where=f"robot {name!r}", got=repr(convention),
            allowed='"standard" (frame i at the far end of link i) or "modified" (frame i on joint i)',
        )
    joints = []
    if base is None:
        pose = np.eye(4)
    else:
        pose = rigid(base, f"base of robot {name!r}")
    for number, entry in enumerate(_rows(rows, kinds), 1):
        if convention == "modified":
            pose = times(pose, rotation("x", entry.alpha), translation(entry.a, 0.0, 0.0))
        axis, point = pose[:3, 2], pose[:3, 3]
        pose = times(pose, rotation("z", entry.theta), translation(0.0, 0.0, entry.d))
        if convention == "standard":
            pose = times(pose, translation(entry.a, 0.0, 0.0), rotation("x", entry.alpha))
        joints.append(
            Joint(
                entry.name or f"joint{number}", entry.kind, screw_of(entry.kind, axis, point, entry.pitch),
                entry.lower, entry.upper, entry.velocity, frame=pose,
            )
        )
    if tool is None:
        home = pose
    else:
        home = times(pose, rigid(tool, f"tool of robot {name!r}"))
    origin = Source("dh", f'from_dh(convention="{convention}")')
    return described_robot(name, joints, home, described | {"source": described.get("source") or origin})


def described_robot(name: str, joints: Sequence[Joint], home: Array, described: Mapping[str, Any]) -> Robot:
    """A robot with what its caller says about it: fields of `Robot`, lengths as a mapping, notes before those on limits

    Raises:
        TypeError: a field that a robot does not have.
    """
    notes, lengths = described.get("notes") or (), described.get("lengths") or {}
    given = {**described, "notes": (*map(as_note, notes), *turn_notes(joints)), "lengths": tuple(lengths.items())}
    return Robot(name, tuple(joints), home, **given)


def dh_row(given: Mapping[str, Any], number: int, where: Where, angles: Angles | None = None) -> DHRow:
    """Read one row from a mapping, with `where` naming the place of each key in errors.

    Args:
        given: keys of `DHRow`.
        number: of the row, from 1.
        where: place of a key.
        angles: reads alpha and theta; None takes them literally.

    Raises:
        RobotError: unknown key or kind, a value that is not a finite number, lower above upper.
    """
    check_keys(given, DH_KEYS, where)
    kind = joint_kind(given.get("kind", "revolute"), where("kind"))
    numbers = {key: quantity(given.get(key, 0.0), measure, where=where(key)) for key, measure in _MEASURES.items()}
    if angles is not None:
        numbers |= {key: angles.quantity(given.get(key, 0.0), where=where(key)) for key in ("alpha", "theta")}
    if numbers["pitch"] != 0.0 and kind is not JointKind.HELICAL:
        raise RobotError(
            "only a helical joint has a pitch", where=where("pitch"), got=f"kind {kind.value}", mend='kind = "helical"'
        )
    if numbers["pitch"] == 0.0 and kind is JointKind.HELICAL:
        raise RobotError("a helical joint needs a pitch", where=where("pitch"), mend="pitch = … in m/rad")
    return DHRow(**numbers, kind=kind, name=joint_name(given, number, where), **limits(given, kind, where))


def _rows(rows: Sequence[DHRow | Mapping[str, Any] | Sequence[Any]], kinds: str | Sequence[str] | None) -> list[DHRow]:
    if kinds is not None and len(kinds) != len(rows):
        raise RobotError("kinds has one entry per row", got=len(kinds), allowed=f"{len(rows)} entries")
    result = []
    for number, row in enumerate(rows, 1):
        place = f"DH row {number}"
        if isinstance(row, DHRow):
            given: dict[str, Any] = {key: getattr(row, key) for key in DH_KEYS}
        elif isinstance(row, Mapping):
            given = dict(row)
        elif not isinstance(row, str) and len(row) == 4:
            given = dict(zip(DH_KEYS, row, strict=False))
        else:
            raise RobotError("a DH row has four numbers", where=place, got=repr(row), allowed="(a, alpha, d, theta)")
        if kinds is not None:
            given["kind"] = kinds[number - 1]
        # mypy does not infer a lambda with a default
        result.append(dh_row(given, number, lambda key, place=place: f"{place}, {key}"))  # type: ignore[misc]
    return result
