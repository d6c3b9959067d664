"""The one solver: Newton from many starts at once, and curves of solutions.

What is solved is a function of q (N, n) that gives values f (N, e) and derivatives A (N, e, n): equations of a family,
or the block F with its derivative D. Nothing here knows what they mean.

Newton's step is the shortest one that solves f + A·x = 0 in the least-squares sense, x = −A⁺f, capped. A curve is
walked along the null vector of A and brought back by such steps. The core has the same steps for equations of families
and for the searches, where there are thousands of starts, and those to the nearest solution.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from rankdrop.robot.model import Array

Linear = Callable[[Array], tuple[Array, Array]]
"""q (N, n) -> values (N, e), and derivatives (N, e, n)."""
Residuals = Callable[[Array], tuple[NDArray[np.bool_], Array, Array]]
"""q (N, n) -> (N,) what is not solved yet; values (N, e) and derivatives (N, e, n) of all."""

CUT = 1e-7  # singular values of A below this share of the largest are not inverted
FLAT = 1e-6  # a second vanishing singular value of A: curves cross there, or it is no curve
_CORRECTIONS = 8
_EARLY = 3  # steps of a curve before which it is not closed


def shortest(a: Array, f: Array) -> Array:
    """(N, n) shortest least-squares solutions of a·x = f, a (N, e, n), f (N, e); small singular values are left out."""
    u, s, vt = np.linalg.svd(a, full_matrices=False)
    keep = s > np.maximum(CUT * s[:, :1], 1e-14)
    inverse = np.where(keep, 1.0 / np.where(keep, s, 1.0), 0.0)
    return np.asarray(np.einsum("nrj,nr->nj", vt, inverse * np.einsum("ner,ne->nr", u, f)))


def newton(
    residuals: Residuals,
    starts: Array,
    *,
    along: Array | None = None,
    scale: Array | None = None,
    iterations: int = 40,
    step: float = 0.5,
    still: float = 1e-14,
) -> Array:
    """Gauss–Newton with the shortest step, capped, from every start until it is solved or stands still.

    Args:
        residuals: what is solved.
        starts: (N, n).
        along: (n, d) orthonormal basis of the directions that may be used, in scaled coordinates; None for all.
        scale: (n,) what steps are measured by; None for 1.
        iterations: at most.
        step: longest step, in scaled coordinates.
        still: a start whose step gets shorter has arrived.

    Returns:
        (N, n) end points; whether they are solutions is for the caller to say.
    """
    q = np.array(starts, dtype=np.float64)
    active = np.arange(len(q))
    for _ in range(iterations):
        if not len(active):
            break
        going, f, a = residuals(q[active])
        active, f, a = active[going], f[going], a[going]
        if scale is not None:
            a = a * scale
        if along is not None:
            a = a @ along
        delta = -shortest(a, f)
        if along is not None:
            delta = delta @ along.T
        length = np.linalg.norm(delta, axis=1, keepdims=True)
        move = delta if scale is None else scale * delta
        q[active] += move * np.minimum(1.0, step / np.maximum(length, 1e-300))
        active = active[length[:, 0] > still]
    return q


def trace(
    linear: Linear, start: Array, step: float, *, zero: float, most: int, sign: float = 1.0
) -> tuple[Array, bool]:
    """A curve of solutions from one of its points on; angles, which run on past ±π.

    Args:
        linear: what is solved; the curve is where it vanishes, and A has rank n − 1 there.
        start: (n,) on the curve.
        step: between neighbours.
        zero: |f| of a point of the curve.
        most: steps at most.
        sign: 1 to set out with the largest entry of the tangent up, −1 for the other way.

    Returns:
        (N, n) points in order, and whether the last one is the start again, up to whole turns. Otherwise the walk
        ended where A has a second null vector, where no point was met, or after `most` steps.
    """
    x, line, direction = start, [start], np.zeros(len(start))
    slope = linear(x[None])[1][0]
    for number in range(most):
        tangent = _tangent(slope)
        if tangent is None:
            break
        if number == 0:
            direction = sign * tangent * np.sign(tangent[np.abs(tangent).argmax()])
        direction = tangent if tangent @ direction > 0 else -tangent
        arrived = _corrected(linear, x + step * direction, zero)
        if arrived is None or np.linalg.norm(arrived[0] - x) > 2 * step:
            break
        x, slope = arrived
        line.append(x)
        gap = np.pi - np.mod(np.pi - (start - x), 2 * np.pi)
        if number >= _EARLY and np.linalg.norm(gap) < 0.75 * step and gap @ direction > -0.75 * step:
            line[-1] = x + gap
            return np.array(line), True
    return np.array(line), False


def _tangent(slope: Array) -> Array | None:
    """The null vector of A (e, d); None where there is more than one."""
    _, s, vt = np.linalg.svd(slope)
    d = slope.shape[1]
    if len(s) < d - 1 or s[d - 2] < FLAT:
        return None
    return np.asarray(vt[-1])


def _corrected(linear: Linear, x: Array, zero: float) -> tuple[Array, Array] | None:
    """x brought back to the zero set, and A there; None where it does not get there."""
    for _ in range(_CORRECTIONS):
        f, slope = linear(x[None])
        if np.abs(f).max() <= zero:
            return x, slope[0]
        x = x - shortest(slope, f)[0]
    return None
