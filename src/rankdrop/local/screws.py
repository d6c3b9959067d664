"""Twists and wrenches as screws, and in plain English, units always.

A screw has an axis, a pitch and a magnitude; the frame it is written in can be changed. Lost directions and blocked
wrenches become sentences.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, isinf

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import OptionError
from rankdrop.robot.model import Array

_NO_TURN = 1e-9  # rotation below this share of the whole: numbers of rounding, not a turn about a far axis


@dataclass(frozen=True, slots=True)
class Screw:
    """A line with a pitch: what a twist or a wrench is, whatever the frame it is written in.

    Attributes:
        point: (3,) the point of the axis nearest to the reference point [m]; zero for an infinite pitch.
        direction: (3,) unit vector along the axis.
        pitch: translation per rotation [m/rad] of a twist, moment per force [m] of a wrench; inf for a pure translation
            (a pure moment).
        magnitude: |ω| [rad/s] (|f| [N] of a wrench); |v| [m/s] (|τ| [N m]) where the pitch is infinite.
    """

    point: tuple[float, float, float]
    direction: tuple[float, float, float]
    pitch: float
    magnitude: float

    @property
    def twist(self) -> Array:
        """(6,) the twist (v; ω) = magnitude · (p × d + h d; d), or magnitude · (d; 0) for an infinite pitch."""
        direction = np.array(self.direction)
        if isinf(self.pitch):
            return self.magnitude * np.concatenate([direction, np.zeros(3)])
        linear = np.cross(self.point, direction) + self.pitch * direction
        return self.magnitude * np.concatenate([linear, direction])


    def in_lengths(self, length: float) -> Screw:
        """The same screw where `length` [m] was its unit of length: point and pitch in metres."""
        x, y, z = self.point
        return replace(self, point=(x * length, y * length, z * length), pitch=self.pitch * length,
                       magnitude=self.magnitude * (length if isinf(self.pitch) else 1.0))  # fmt: skip


def screw_of(twist: ArrayLike) -> Screw:
    """The axis and the pitch of a twist (v; ω), v taken at the reference point of its frame.

        d = ω/|ω|,  p = ω × v / |ω|²,  h = ω·v / |ω|²

    For a wrench (f; τ) hand in (τ; f): force is to moment as rotation is to translation.

    Args:
        twist: (6,) linear part [m/s] first, angular part [rad/s] second.

    Raises:
        OptionError: not six finite numbers, or all of them zero.

    Example:
        >>> screw_of([0, -2, 0, 0, 0, 1]).point  # a turn about Z through x = 2
        (2.0, 0.0, 0.0)
    """
    values = np.asarray(twist, dtype=np.float64)
    if values.shape != (6,) or not np.isfinite(values).all() or not values.any():
        raise OptionError("a twist is six finite numbers, not all zero", got=np.asarray(twist).tolist())
    v, w = values[:3], values[3:]
    turn, slide = float(np.linalg.norm(w)), float(np.linalg.norm(v))
    if turn <= _NO_TURN * slide:
        return Screw((0.0, 0.0, 0.0), _three(v / slide), inf, slide)
    return Screw(_three(np.cross(w, v) / turn**2), _three(w / turn), float(w @ v) / turn**2, turn)


def rewrite_wrench(wrench: Array, turn: Array, offset: Array) -> Array:
    """Wrenches (f; τ) written in other axes, at another point: f' = Rᵀf, τ' = Rᵀ(τ − d × f).

    The power f·v + τ·ω does not change, so what is blocked in one frame is blocked in the other.

    Args:
        wrench: (..., 6) in the old axes, moment about the old point.
        turn: (..., 3, 3) R, columns are the new axes in the old ones.
        offset: (..., 3) d, the new point seen from the old one, in the old axes [m]; batch axes broadcast.
    """
    force, moment = wrench[..., :3], wrench[..., 3:]
    return np.concatenate([force @ turn, (moment - np.cross(offset, force)) @ turn], axis=-1)


def _three(vector: Array) -> tuple[float, float, float]:
    return float(vector[0]) + 0.0, float(vector[1]) + 0.0, float(vector[2]) + 0.0


_ZERO = 1e-6  # a part below this share of the direction is not there
_AXIS = 1e-6  # an axis is X, Y or Z when its other components are below this


_NEARLY = 0.25  # a part below this share of the whole: what the other part alone says is true to 3 %


def constraint(direction: ArrayLike, length: float = 1.0) -> str:
    """A lost direction as what it does to the motions that remain: "0.63 vy + 0.7 vz + 0.098 m·ωx = 0".

    A direction u = (u_v; u_ω) is lost when u · (v; ω) = 0 for every twist the joints can make. That equation says what
    can still be done; no length has to be chosen for it. Its larger part is a unit vector, its largest number positive.

    Args:
        direction: (6,) vx vy vz wx wy wz of any length and sign, metres and radians.
        length: the direction's own unit of length, `units.counted_length` [m].

    Raises:
        OptionError: not six finite numbers, or all of them zero.

    Example:
        >>> constraint([0, -0.91, 0, 0, 0, -0.41])
        'vy + 0.451 m·ωz = 0'
        >>> constraint([0, 0, 0.05, 0.6, -0.8, 0])
        '−0.6 ωx + 0.8 ωy − 0.05 rad/m·vz = 0'
    """
    v, w = _parts(direction)
    slide, turn = float(np.linalg.norm(v)), float(np.linalg.norm(w))
    moves = slide >= turn
    first, second = (v / slide, w / slide) if moves else (w / turn, v / turn)
    names, others, unit = ("v", "ω", "m") if moves else ("ω", "v", "rad/m")
    per = length if moves else 1.0 / length
    sign = 1.0 if first[int(np.argmax(np.abs(first) >= np.abs(first).max() - _AXIS))] > 0.0 else -1.0
    small = float(np.linalg.norm(second)) <= _ZERO
    terms = [(sign * float(x), f"{names}{axis}") for x, axis in zip(first, "xyz", strict=True) if abs(x) > _AXIS]
    if not small:
        terms += [
            (sign * float(x) * per, f"{unit}·{others}{axis}")
            for x, axis in zip(second, "xyz", strict=True) if abs(x) > _AXIS
        ]  # fmt: skip
    return f"{_sum(terms)} = 0"


def _sum(terms: list[tuple[float, str]]) -> str:
    """Terms with their signs: "−0.6 ωx + 0.8 ωy − 0.05 rad/m·vz"; a factor of 1 without a unit is left out."""
    text = ""
    for value, name in terms:
        number = _number(abs(value))
        sign = ("−" if value < 0 else "") if not text else (" − " if value < 0 else " + ")
        text += sign + (name if number == "1" and "·" not in name else f"{number} {name}")
    return text


def in_short(direction: ArrayLike) -> str:
    """What a lost direction comes to where it is, or nearly is, one of pure translation or pure rotation; else empty.

    Args, Raises: as `constraint`.

    Example:
        >>> in_short([0, 0.6, 0.8, 0, 0, 0]), in_short([0, 0, 0.05, 1, 0, 0]), in_short([0, 0.7, 0, 0, 0.7, 0])
        ('no motion along (0, 0.6, 0.8)', 'nearly no turning about X', '')
    """
    v, w = _parts(direction)
    slide, turn = float(np.linalg.norm(v)), float(np.linalg.norm(w))
    share = min(slide, turn) / np.hypot(slide, turn)
    if share > _NEARLY:
        return ""
    text = f"no motion along {_axis(v)[0]}" if slide >= turn else f"no turning about {_axis(w)[0]}"
    return text if share <= _ZERO else f"nearly {text}"


def words(direction: ArrayLike, frame_name: str = "the base", length: float = 1.0) -> str:
    """One lost direction as a sentence.

    A direction u = (v; ω) is lost when u · twist = 0 for every twist the joints can make. Where u is a pure translation
    or rotation, that motion cannot be made, as AM say. With both parts present it is no motion that is told but what
    ties the others together (`constraint`), and what that nearly comes to.

    Args:
        direction: (6,) vx vy vz wx wy wz of any length and sign, metres and radians.
        frame_name: whose axes: "the base", "the tool", "link 4".
        length: the direction's own unit of length, `units.counted_length` [m].

    Raises:
        OptionError: not six finite numbers, or all of them zero.

    Example:
        >>> words([0, 0, 0, 1, 0, 0])
        'cannot rotate about X of the base'
        >>> words([0, -0.91, 0, 0, 0, -0.1], "the tool")
        'can only move so that vy + 0.11 m·ωz = 0 in axes of the tool: nearly no motion along Y'
    """
    v, w = _parts(direction)
    slide, turn = float(np.linalg.norm(v)), float(np.linalg.norm(w))
    if turn <= _ZERO * slide:
        return f"cannot translate along {_axis(v)[0]} of {frame_name}"
    if slide <= _ZERO * turn:
        return f"cannot rotate about {_axis(w)[0]} of {frame_name}"
    short = in_short(direction)
    return f"can only move so that {constraint(direction, length)} in axes of {frame_name}{f': {short}' * bool(short)}"


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


_NOTHING = 0.02  # parts of a unit direction that are shorter are not drawn
_TURN = 300.0  # degrees of a ring


def arrow_of(direction: ArrayLike) -> tuple[Array, Array, bool]:
    """One lost freedom as one arrow at the reference point, with a ring about its foot where it mixes both motions.

    Args:
        direction: (6,) a lost direction (v; ω), of any length and sign, metres and radians.

    Returns:
        (3,) the arrow, at most of length one; (3,) the axis of its ring, as long as the ring is wide, zero for none;
        whether the arrow is a turning about it (dotted) and not a motion along it.

    Raises:
        OptionError: not six finite numbers, or all of them zero.

    Example:
        >>> arrow, ring, turns = arrow_of([0, 0.8, 0, 0, 0, 0.6])
        >>> arrow.round(3).tolist(), ring.round(3).tolist(), turns
        ([0.0, 0.87, 0.0], [0.0, 0.0, 0.22], False)
    """
    v, w = _parts(direction)
    whole = float(np.linalg.norm(np.concatenate([v, w])))
    v, w = v / whole, w / whole
    slide, turn = float(np.linalg.norm(v)), float(np.linalg.norm(w))
    if turn < _NOTHING:
        return v / slide, np.zeros(3), False
    if slide < _NOTHING:
        return w / turn, np.zeros(3), True
    return (0.35 + 0.65 * slide) * v / slide, (0.07 + 0.25 * turn) * w / turn, False


def ring_about(axis: Array) -> Array:
    """(P, 3) points of a ring about an axis through the origin, its radius the axis's length, with a head at its end.

    It turns as the right hand does about the axis.

    Args:
        axis: (3,) not zero.
    """
    radius = float(np.linalg.norm(axis))
    z = axis / radius
    x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    x /= np.linalg.norm(x)
    angles = np.radians(np.linspace(0.0, _TURN, 41))[:, None]
    round_about = radius * (np.cos(angles) * x + np.sin(angles) * np.cross(z, x))
    end = round_about[-1]
    back = end - 0.36 * np.cross(z, end)
    return np.vstack([round_about, back + 0.2 * end, end, back - 0.2 * end])


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
