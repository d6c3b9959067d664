"""Lost directions and blocked wrenches in plain English, units always."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import OptionError
from rankdrop.local.screws import screw_of
from rankdrop.robot.model import Array

_ZERO = 1e-6  # a part below this share of the direction is not there
_AXIS = 1e-6  # an axis is X, Y or Z when its other components are below this


def words(direction: ArrayLike, frame_name: str = "the base", length: float = 1.0) -> str:
    """One lost direction as a sentence about motion, as AM write theirs.

    A direction u = (v; ω) is lost when u · twist = 0 for every twist the joints can make, so u itself is a twist that
    cannot be made. With both parts present neither the translation nor the rotation is lost alone: the two are tied
    together; `blocked_words` says how.

    Args:
        direction: (6,) vx vy vz wx wy wz of any length and sign, metres and radians.
        frame_name: whose axes: "the base", "the end effector", "link 4".
        length: the direction's own unit of length, `units.counted_length` [m].

    Raises:
        OptionError: not six finite numbers, or all of them zero.

    Example:
        >>> words([0, 0, 0, 1, 0, 0])
        'cannot rotate about X of the base'
        >>> words([0, -0.91, 0, 0, 0, -0.41], "the end effector")
        'cannot translate along Y while rotating 0.451 rad/m about Z of the end effector'
    """
    v, w = _parts(direction)
    slide, turn = float(np.linalg.norm(v)), float(np.linalg.norm(w))
    if turn <= _ZERO * slide:
        return f"cannot translate along {_axis(v)[0]} of {frame_name}"
    if slide <= _ZERO * turn:
        return f"cannot rotate about {_axis(w)[0]} of {frame_name}"
    along, forward = _axis(v)
    about, positive = _axis(w)
    sign = "−" if forward != positive else ""
    if slide >= turn:
        rate = _number(turn / slide / length)
        return f"cannot translate along {along} while rotating {sign}{rate} rad/m about {about} of {frame_name}"
    rate = _number(slide / turn * length)
    return f"cannot rotate about {about} while translating {sign}{rate} m/rad along {along} of {frame_name}"


def blocked_words(direction: ArrayLike, frame_name: str = "the base", length: float = 1.0) -> str:
    """The same direction read as the wrench (f; τ) that the structure carries with no joint torque.

    With f ≠ 0 it is a force along the line p + s f, p = f × τ/|f|², and a moment h f, h = f·τ/|f|²: power zero means
    v_p·f + h ω·f = 0. A force alone (h = 0): no point of that line can move along the line. No choice of a length is
    needed for this.

    Args, Raises: as `words`.

    Example:
        >>> blocked_words([0, 0.91, 0, 0, 0, 0.41])
        'the point (0.451, 0, 0) m from the reference point cannot move along Y of the base'
    """
    f, m = _parts(direction)
    force, moment = float(np.linalg.norm(f)), float(np.linalg.norm(m))
    if force <= _ZERO * moment:
        return f"cannot rotate about {_axis(m)[0]} of {frame_name}"
    line = screw_of(np.concatenate([m, f]))
    point = np.array(line.point)
    near = float(np.linalg.norm(point)) <= _ZERO
    where = "the reference point" if near else f"the point {_triple(point, length)} m from the reference point"
    along = _axis(f)[0]
    if abs(line.pitch) <= _ZERO:
        return f"{where} cannot move along {along} of {frame_name}"
    rate = _number(abs(line.pitch) * length)
    sign = "−" if line.pitch > 0.0 else ""
    return f"{where} moves along {along} of {frame_name} only by {sign}{rate} m for every rad of rotation about it"


def _parts(direction: ArrayLike) -> tuple[Array, Array]:
    values = np.asarray(direction, dtype=np.float64)
    if values.shape != (6,) or not np.isfinite(values).all() or not values.any():
        raise OptionError("a direction is six finite numbers, not all zero", got=np.asarray(direction).tolist())
    return values[:3], values[3:]


def _axis(vector: Array) -> tuple[str, bool]:
    """Name of the axis with its largest component positive, and whether the vector points that way."""
    unit = vector / np.linalg.norm(vector)
    size = np.abs(unit)
    largest = int(np.argmax(size >= size.max() - _AXIS))
    forward = bool(unit[largest] > 0.0)
    if np.delete(size, largest).max() <= _AXIS:
        return "XYZ"[largest], forward
    return _triple(unit if forward else -unit), forward


def _triple(vector: Array, length: float = 1.0) -> str:
    return f"({', '.join(_component(float(x), length) for x in vector)})"


def _component(value: float, length: float) -> str:
    return "0" if abs(value) <= _AXIS else _number(value * length)


def _number(value: float) -> str:
    return f"{value:.3g}".replace("-", "−")
