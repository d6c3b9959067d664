"""Twists and wrenches as screws: axis, pitch, magnitude; and change of the frame they are written in."""

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
        return Screw((0.0, 0.0, 0.0), _triple(v / slide), inf, slide)
    return Screw(_triple(np.cross(w, v) / turn**2), _triple(w / turn), float(w @ v) / turn**2, turn)


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


def _triple(vector: Array) -> tuple[float, float, float]:
    return float(vector[0]) + 0.0, float(vector[1]) + 0.0, float(vector[2]) + 0.0
