"""A twist or a wrench as a screw: an axis, a pitch and a magnitude, whatever the frame it is written in."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isinf

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.local.directions import parts_of_direction
from rankdrop.robot.model import Array
from rankdrop.robot.transform import cross

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
    v, w, slide, turn = parts_of_direction(twist)
    if turn <= _NO_TURN * slide:
        return Screw((0.0, 0.0, 0.0), _three(v / slide), inf, slide)
    return Screw(_three(cross(w, v) / turn**2), _three(w / turn), float(w @ v) / turn**2, turn)


def _three(vector: Array) -> tuple[float, float, float]:
    return float(vector[0]) + 0.0, float(vector[1]) + 0.0, float(vector[2]) + 0.0
