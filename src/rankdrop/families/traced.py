"""Curves walked: the one-dimensional zero set of equations in a slice of joint space, step by step along its tangent.

In the slice's coordinates x the equations are g(x) = 0 with Jacobian A (e × d) of rank d − 1. A step goes along the
null vector of A and is brought back by Newton's method with the shortest correction −A⁺g.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rankdrop.families.linear import wrap
from rankdrop.family.system import SOLVED, System, shortest
from rankdrop.robot.model import Array

STEP = 0.07
"""Between neighbours on a curve [rad]."""
_MOST = 600  # steps of one curve: seven turns; one that is longer does not come to an end
_FLAT = 1e-6  # a second vanishing singular value of A: curves cross there, or it is no curve
_CORRECTIONS = 8


def walk(system: System, base: Array, joints: Sequence[int], seeds: Array, step: float = STEP) -> list[Array] | None:
    """Every curve of the zero set that a seed lies on; all joints of the slice turn, and curves run on past ±π.

    Args:
        system: the equations.
        base: (n,) the other joints [rad, m].
        joints: d joints from 0 that span the slice.
        seeds: (N, d) points that solve the equations.
        step: between neighbours [rad].

    Returns:
        (k, d) polylines, not wrapped; a closed one ends where it begins, up to whole turns. None where a curve does
        not come to an end: equations that nearly hold on more than a curve (Sawyer) are not to be walked.
    """
    found: list[Array] = []
    left = np.array(seeds)
    while len(left):
        line = _line(system, base, list(joints), left[0], step)
        if len(line) > _MOST:
            return None
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
    slope = _linear(system, base, joints, x)[1][0]
    for count in range(_MOST):
        tangent = _tangent(slope)
        if tangent is None:
            break
        if direction is None:
            direction = sign * _positive(tangent)
        direction = tangent if tangent @ direction > 0 else -tangent
        arrived = _corrected(system, base, joints, x + step * direction)
        if arrived is None or np.linalg.norm(arrived[0] - x) > 2 * step:
            break
        x, slope = arrived
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


def _tangent(slope: Array) -> Array | None:
    """The null vector of A (e, d); None where there is more than one."""
    _, s, vt = np.linalg.svd(slope)
    d = slope.shape[1]
    if len(s) < d - 1 or s[d - 2] < _FLAT:
        return None
    return np.asarray(vt[-1])


def _corrected(system: System, base: Array, joints: list[int], x: Array) -> tuple[Array, Array] | None:
    """x brought back to the zero set, and A there; None where it does not get there."""
    for _ in range(_CORRECTIONS):
        f, slope = _linear(system, base, joints, x)
        if np.abs(f).max() <= SOLVED:
            return x, slope[0]
        x = x - shortest(slope, f)[0]
    return None
