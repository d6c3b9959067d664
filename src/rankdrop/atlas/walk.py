"""Curves walked: the one-dimensional zero set of equations in a slice of joint space, step by step along its tangent.

In the slice's coordinates x the equations are g(x) = 0 with Jacobian A (e × d) of rank d − 1. A step goes along the
null vector of A and is brought back by Newton's method with the shortest correction −A⁺g.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rankdrop.atlas.linear import wrap
from rankdrop.atlas.system import SOLVED, System, shortest
from rankdrop.robot.model import Array

STEP = 0.04
"""Between neighbours on a curve [rad]."""
_MOST = 2000  # steps of one curve
_FLAT = 1e-6  # a second vanishing singular value of A: curves cross there, or it is no curve
_CORRECTIONS = 8


def walk(system: System, base: Array, joints: Sequence[int], seeds: Array, step: float = STEP) -> list[Array]:
    """Every curve of the zero set that a seed lies on; all joints of the slice turn, and curves run on past ±π.

    Args:
        system: the equations.
        base: (n,) the other joints [rad, m].
        joints: d joints from 0 that span the slice.
        seeds: (N, d) points that solve the equations.
        step: between neighbours [rad].

    Returns:
        (k, d) polylines, not wrapped; a closed one ends where it begins, up to whole turns.
    """
    found: list[Array] = []
    left = np.array(seeds)
    while len(left):
        line = _line(system, base, list(joints), left[0], step)
        if len(line) > 2:
            found.append(line)
        left = left[1:]
        for start in range(0, len(line), 256):
            gap = np.abs(wrap(left[:, None] - line[None, start : start + 256])).max(axis=2).min(axis=1, initial=np.inf)
            left = left[gap > step]
    return found


def closed(line: Array, step: float = STEP) -> bool:
    """Whether a curve comes back to where it began, up to whole turns."""
    return bool(np.abs(wrap(line[-1] - line[0])).max() < step / 2)


def _line(system: System, base: Array, joints: list[int], seed: Array, step: float) -> Array:
    ahead, back_again = _half(system, base, joints, seed, step, 1.0)
    if back_again:
        return ahead
    behind, _ = _half(system, base, joints, seed, step, -1.0)
    return np.concatenate([behind[:0:-1], ahead])


def _half(system: System, base: Array, joints: list[int], seed: Array, step: float, sign: float) -> tuple[Array, bool]:
    """Points from the seed on, and whether the walk came back to it."""
    x, line, direction = seed, [seed], None
    for count in range(_MOST):
        tangent = _tangent(system, base, joints, x)
        if tangent is None:
            break
        if direction is None:
            direction = sign * _positive(tangent)
        direction = tangent if tangent @ direction > 0 else -tangent
        arrived = _corrected(system, base, joints, x + step * direction)
        if arrived is None or np.linalg.norm(arrived - x) > 2 * step:
            break
        x = arrived
        line.append(x)
        gap = wrap(seed - x)
        if count > 2 and np.linalg.norm(gap) < 0.75 * step and gap @ direction > -0.75 * step:
            line[-1] = x + gap
            return np.array(line), True
    return np.array(line), False


def _positive(vector: Array) -> Array:
    return np.asarray(vector * np.sign(vector[np.abs(vector).argmax()]))


def _linear(system: System, base: Array, joints: list[int], x: Array) -> tuple[Array, Array]:
    q = base.copy()
    q[joints] = x
    f, slope = system.linear(q[None])
    return f, slope[..., joints]


def _tangent(system: System, base: Array, joints: list[int], x: Array) -> Array | None:
    _, slope = _linear(system, base, joints, x)
    _, s, vt = np.linalg.svd(slope[0])
    d = len(joints)
    if len(s) < d - 1 or s[d - 2] < _FLAT:
        return None
    return np.asarray(vt[-1])


def _corrected(system: System, base: Array, joints: list[int], x: Array) -> Array | None:
    for _ in range(_CORRECTIONS):
        f, slope = _linear(system, base, joints, x)
        if np.abs(f).max() <= SOLVED:
            return x
        x = x - shortest(slope, f)[0]
    return None
