"""Lost directions in words: the motion that cannot be made, the constraint, the blocked wrench; and frames.

Example:
    >>> from rankdrop.local.directions import LostDirection
    >>> short_text(LostDirection([0, 0.6, 0.8, 0, 0, 0]))
    'no motion along (0, 0.6, 0.8)'
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.local.directions import (
    AXIS,
    ENTRY_SHARE,
    NEARLY_SHARE,
    LostDirection,
    constraint_values,
    is_nearly_pure,
    main_axis,
    parts_of_direction,
)
from rankdrop.local.screws import screw_of
from rankdrop.robot.model import Array
from rankdrop.task import BASE, TIP, Frame
from rankdrop.units import shift_decimal

_LABELS = {
    False: ("vx", "vy", "vz", "m·ωx", "m·ωy", "m·ωz"),
    True: ("ωx", "ωy", "ωz", "rad/m·vx", "rad/m·vy", "rad/m·vz"),
}
"""Whether the larger part of a constraint is ω -> what its coefficients multiply, the larger part first."""


_SMALLEST = 5e-5
"""Coefficients of a constraint below it are not printed, lengths divided by the length scale."""

_SHOWN = 5e-4  # components of a unit vector below it are 0 with three decimals

_HALF_UP = 1.0 + 1e-10  # halves are rounded away from zero: 0.03265 m and 32.65 mm have the same digits


def constraint_text(lost: LostDirection) -> str:
    """What a lost direction does to the motions that remain: see `rankdrop.local.directions.constraint`."""
    values, turns = constraint_values(lost.direction, lost.length)
    labels = _LABELS[turns]
    text = ""
    sizes = np.abs(values)
    sizes[3:] *= lost.length if turns else 1.0 / lost.length  # without a unit, as the larger part is
    for i in np.flatnonzero(sizes >= _SMALLEST).tolist():
        value = float(values[i])
        number = f"{_number(abs(value))} "
        if i < 3 and number == "1 ":
            number = ""
        term = f"{number}{labels[i]}"
        if text:
            text += f" {_sign(value)} {term}"
        elif value < 0:
            text = f"−{term}"
        else:
            text = term
    return f"{text} = 0"


def _sign(value: float) -> str:
    if value < 0:
        return "−"
    return "+"


def short_text(lost: LostDirection) -> str:
    """What it comes to where it is, or nearly is, one of pure translation or pure rotation; else empty."""
    v, w, slide, turn = parts_of_direction(lost.direction)
    if min(slide, turn) > NEARLY_SHARE * np.hypot(slide, turn):
        return ""
    if slide >= turn:
        text = f"no motion along {axis_text(v)}"
    else:
        text = f"no turning about {axis_text(w)}"
    if is_nearly_pure(lost.direction):
        return f"nearly {text}"
    return text


def lost_text(lost: LostDirection, frame: str) -> str:
    """A lost direction as a sentence on the tool, without a subject; `frame`: with these axes, "the base"."""
    v, w, slide, turn = parts_of_direction(lost.direction)
    if turn <= ENTRY_SHARE * slide:
        return f"cannot translate along {axis_text(v)} of {frame}"
    if slide <= ENTRY_SHARE * turn:
        return f"cannot rotate about {axis_text(w)} of {frame}"
    text = f"can only move so that {constraint_text(lost)} in axes of {frame}"
    short = short_text(lost)
    if short:
        return f"{text}: {short}"
    return text


def blocked_text(lost: LostDirection, frame: str) -> str:
    """A lost direction read as a wrench, as a sentence on points of the tool; `frame`: with these axes, "the base"."""
    f, m, force, moment = parts_of_direction(lost.direction)
    if force <= ENTRY_SHARE * moment:
        return f"cannot rotate about {axis_text(m)} of {frame}"
    line = screw_of(np.concatenate([m, f]))
    point = np.array(line.point)
    if float(np.linalg.norm(point)) <= ENTRY_SHARE:
        where = "the reference point"
    else:
        where = f"the point {_triple(point, lost.length)} m from the reference point"
    along = axis_text(f)
    if abs(line.pitch) <= ENTRY_SHARE:
        return f"{where} cannot move along {along} of {frame}"
    rate = _number(abs(line.pitch) * lost.length)
    if line.pitch > 0.0:
        rate = f"−{rate}"
    return f"{where} moves along {along} of {frame} only by {rate} m for every rad of rotation about it"


def axis_text(vector: ArrayLike) -> str:
    """A direction for people, its largest component positive: "Y", or "(0.6, 0, 0.8)".

    Args:
        vector: (3,) not zero, of any length.
    """
    largest, _ = main_axis(vector)
    unit = np.asarray(vector, dtype=np.float64) / np.linalg.norm(vector)
    if np.count_nonzero(np.abs(unit) >= _SHOWN) == 1:
        return "XYZ"[largest]
    return _triple(unit * np.sign(unit[largest]))


def _triple(vector: Array, length: float = 1.0) -> str:
    parts = []
    for value in vector.tolist():
        if abs(value) <= AXIS:
            parts.append("0")
        else:
            parts.append(_number(value * length))
    return f"({', '.join(parts)})"


def _number(value: float) -> str:
    steady = float(f"{value:.8g}")  # 0.7345 is one number, however its last bits fell
    return f"{steady * _HALF_UP:.3g}".replace("-", "−")


def frame_name(frame: Frame, power: int = 0) -> str:
    """A frame in words, to end a sentence with; numbers of its point are reported times 10 to a power."""
    axes = _link(frame.axes)
    if frame.origin == TIP and not any(frame.point):
        return axes
    if frame.origin == frame.axes and not any(frame.point):
        return f"{axes} at its origin"
    given = [shift_decimal(x, power) for x in frame.point]
    if not any(frame.point):
        where = "the origin"
    else:
        where = f"({', '.join(f'{x:g}' for x in given)}) m"
    return f"{axes} at {where} of {_link(frame.origin)}"


def _link(number: int) -> str:
    return {BASE: "the base", TIP: "the tool"}.get(number, f"link {number}")
