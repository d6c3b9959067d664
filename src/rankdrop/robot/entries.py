"""What an entry of a table says about one joint, whatever the form of the table: keys, kind, limits."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import inf, isfinite, pi, radians
from typing import Any

from rankdrop.errors import RobotError
from rankdrop.robot.model import Joint, JointKind
from rankdrop.robot.quantities import quantity

Where = Callable[[str], str]
"""Place of a key (or of the whole entry, for "") in words, for errors: "pa10.toml, line 12, joint 3, alpha"."""

_MANY_TURNS = 8 * pi  # [rad]; cables of real arms allow a few turns, and 30 deg is more than this
_LARGEST_DEGREES = 720.0
_LETTERS = {"R": JointKind.REVOLUTE, "P": JointKind.PRISMATIC, "H": JointKind.HELICAL}


def check_keys(given: Iterable[str], allowed: Sequence[str], where: Where) -> None:
    """Refuse keys that nobody reads.

    Raises:
        RobotError: the first unknown key, with the allowed ones.
    """
    for key in given:
        if key not in allowed:
            raise RobotError("unknown key", where=where(key), got=repr(key), allowed=", ".join(allowed))


def joint_kind(kind: Any, where: str, more: Sequence[str] = ()) -> JointKind:
    """The `JointKind` named by a word or by its first letter in capitals (R, P, H).

    Raises:
        RobotError: there is no such kind; `more` lists what else the caller would have taken.
    """
    if isinstance(kind, str) and kind in _LETTERS:
        return _LETTERS[kind]
    try:
        return JointKind(kind)
    except (ValueError, TypeError):
        allowed = ", ".join([entry.value for entry in JointKind] + list(more))
        raise RobotError("there is no such kind of joint", where=where, got=repr(kind), allowed=allowed) from None


def limits(given: Mapping[str, Any], kind: JointKind, where: Where) -> dict[str, float]:
    """`lower`, `upper` and `velocity` of one joint as numbers [rad or m, per second]; ±inf where not given.

    Raises:
        RobotError: not a number, lower above upper, or a velocity that is not positive.
    """
    measure = "length" if kind is JointKind.PRISMATIC else "angle"
    lower = quantity(given.get("lower", -inf), measure, where=where("lower"), endless=True)
    upper = quantity(given.get("upper", inf), measure, where=where("upper"), endless=True)
    velocity = quantity(given.get("velocity", inf), measure, where=where("velocity"), rate=True, endless=True)
    if lower > upper:
        raise RobotError(
            "lower limit above upper limit", where=where("lower"), allowed="lower ≤ upper",
            got=f"lower {given['lower']}, upper {given['upper']}", mend="exchange or correct the two limits",
        )
    if velocity <= 0.0:
        raise RobotError(
            "the largest velocity is not positive", where=where("velocity"), got=given["velocity"],
            allowed="a rate > 0", mend="leave the key out where it is not known",
        )
    return {"lower": lower, "upper": upper, "velocity": velocity}


def turn_notes(joints: Iterable[Joint], *, units: bool = True) -> list[str]:
    """Notes on revolute joints whose limits look like degrees taken for radians.

    Args:
        joints: of the arm.
        units: the file may say units; a URDF cannot, and its exporters write numbers above 720 where no limit is.
    """
    notes = []
    for joint in joints:
        most = max((abs(x) for x in (joint.lower, joint.upper) if isfinite(x)), default=0.0)
        if joint.kind is JointKind.REVOLUTE and _MANY_TURNS < most <= (inf if units else _LARGEST_DEGREES):
            mend = f'write "{most:g} deg" for degrees' if units else f"{most:g}° is {radians(most):.4g}"
            notes.append(
                f"joint {joint.name!r}: limits of {joint.lower:g} … {joint.upper:g} rad are many turns; {mend}"
            )
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
    return RobotError(error.what, where=where, got=error.got, allowed=error.allowed, mend=error.mend, typed=error.typed)
