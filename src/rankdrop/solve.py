"""The one solver: Newton from many starts at once, and curves of solutions.

What is solved is a function of q (N, n) that gives values f (N, e) and derivatives A (N, e, n): equations of a family,
or the block F with its derivative D. Nothing here knows what they mean.

Newton's step is the shortest one that solves f + A·x = 0 in the least-squares sense, x = −A⁺f, capped. A curve is
walked along the null vector of A and brought back by such steps. Every such step, whatever it is made of, is repeated
by `iterate`. The core has the same steps for equations of families and for the searches, where there are thousands of
starts, and those to the nearest solution.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.robot.model import Array

Linear = Callable[[Array], tuple[Array, Array]]
"""q (N, n) -> values (N, e), and derivatives (N, e, n)."""
Residuals = Callable[[Array], tuple[NDArray[np.bool_], Array, Array]]
"""q (N, n) -> (N,) what is not solved yet; values (N, e) and derivatives (N, e, n) of all."""
Step = Callable[[Array, NDArray[np.intp]], Array]
"""q (N, n) of the starts that still go, and which they are (N,) -> steps (N, n), in scaled coordinates."""

CUT = 1e-7  # singular values of A below this share of the largest are not inverted
_SMALLEST = 1e-14  # nor are those below this
FLAT = 1e-6  # a second vanishing singular value of A: curves cross there, or it is no curve
_ARRIVED = 1e-14  # a start whose step gets shorter has arrived
_CORRECTIONS = 8
_EARLY = 3  # steps of a curve before which it is not closed


def shortest(a: Array, f: Array, cut: float = CUT, rank: int | None = None) -> Array:
    """(N, n) shortest least-squares solutions of a·x = f, a (N, e, n), f (N, e); small singular values are left out.

    So are those beyond `rank`, where the number of independent equations is known.
    """
    if a.shape[1] == 1:  # a·f/|a|², ten times as fast
        square = (a[:, 0] ** 2).sum(axis=1)
        return np.asarray(a[:, 0] * np.where(square > _SMALLEST**2, f[:, 0] / np.maximum(square, 1e-300), 0.0)[:, None])
    u, s, vt = np.linalg.svd(a, full_matrices=False)
    return _inverted((u, s, vt), f, cut, rank)


def shortest_of_small(a: Array, f: Array) -> Array:
    """As `shortest`, for many finite matrices with at most 16 rows or columns: several at once, in the core."""
    if a.shape[1] == 1:
        return shortest(a, f)
    u, s, v = _core.svd(np.ascontiguousarray(a))
    count = s.shape[1]
    return _inverted((u[:, :, :count], s, v[:, :, :count].swapaxes(1, 2)), f, CUT, None)


def _inverted(factors: tuple[Array, Array, Array], f: Array, cut: float, rank: int | None) -> Array:
    """(N, n) A⁺ f of decomposed matrices u (N, e, r), s (N, r), vᵀ (N, r, n)."""
    u, s, vt = factors
    keep = s > np.maximum(cut * s[:, :1], _SMALLEST)
    if rank is not None:
        keep[:, rank:] = False
    inverse = np.where(keep, 1.0 / np.where(keep, s, 1.0), 0.0)
    return np.asarray(np.einsum("nrj,nr->nj", vt, inverse * np.einsum("ner,ne->nr", u, f)))


def steps_towards(away: Array, f: Array, a: Array) -> Array:
    """(N, n) steps to the point of the tangent plane f + A·x = 0 nearest to a target: x = away − A⁺(f + A·away).

    Args:
        away: (N, n) target less q, in the coordinates of `a`.
        f, a: (N, e) and (N, e, n) values and derivatives at q.
    """
    return away - shortest(a, f + np.einsum("nej,nj->ne", a, away))


def iterate(
    step: Step,
    starts: Array,
    *,
    iterations: int,
    longest: float = np.inf,
    still: float = 0.0,
    scale: Array | None = None,
    box: Array | None = None,
) -> Array:
    """Steps again and again, capped, from every start until it stands still.

    Args:
        step: one step of each.
        starts: (N, n).
        iterations: at most.
        longest: a step, in scaled coordinates; longer ones are cut.
        still: a start whose step gets no longer than this has arrived, that step taken.
        scale: (n,) what steps are measured by, or (n, d) the directions of d coordinates; None for 1.
        box: (2, n) least and largest q; None for no limits.

    Returns:
        (N, n) end points; what they are worth is for the caller to say.
    """
    q = np.array(starts, dtype=np.float64)
    active = np.arange(len(q))
    for _ in range(iterations):
        if not len(active):
            break
        move = step(q[active], active)
        length = np.linalg.norm(move, axis=1)
        move = move * np.minimum(1.0, longest / np.maximum(length, 1e-300))[:, None]
        there = q[active] + (move if scale is None else scale * move if scale.ndim == 1 else move @ scale.T)
        if box is None:
            q[active] = there
        else:
            q[active] = np.clip(there, box[0], box[1])
        active = active[length > still]
    return q


def newton(
    residuals: Residuals,
    starts: Array,
    *,
    scale: Array | None = None,
    iterations: int = 40,
    step: float = 0.5,
    box: Array | None = None,
    cut: float = CUT,
) -> Array:
    """Gauss–Newton with the shortest step, capped, from every start until it is solved or stands still.

    Args:
        residuals: what is solved.
        starts: (N, n).
        scale: (n,) what steps are measured by, or (n, d) the directions of d coordinates; None for 1.
        iterations: at most.
        step: longest step, in scaled coordinates.
        box: (2, n) least and largest q; None for no limits.
        cut: singular values of A below this share of the largest are not inverted.

    Returns:
        (N, n) end points; whether they are solutions is for the caller to say.
    """

    def shortest_step(q: Array, _active: NDArray[np.intp]) -> Array:
        going, f, a = residuals(q)
        if scale is None:
            a = a
        elif scale.ndim == 1:
            a = a * scale
        else:
            a = a @ scale
        move = np.zeros((len(q), a.shape[2]))
        move[going] = -shortest(a[going], f[going], cut)
        return move

    return iterate(shortest_step, starts, iterations=iterations, longest=step, still=_ARRIVED, scale=scale, box=box)


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
        if tangent @ direction > 0:
            direction = tangent
        else:
            direction = -tangent
        arrived = _correct_to_zero(linear, x + step * direction, zero)
        if arrived is None or np.linalg.norm(arrived[0] - x) > 2 * step:
            break
        x, slope = arrived
        line.append(x)
        gap = np.pi - np.mod(np.pi - (start - x), 2 * np.pi)
        if number >= _EARLY and np.linalg.norm(gap) < 0.75 * step and gap @ direction > -0.75 * step:
            line[-1] = x + gap
            return np.array(line), True
    return np.array(line), False


def curves_through(
    linear: Linear, seeds: Array, step: float, *, zero: float, most: int
) -> list[tuple[Array, bool]]:
    """Every curve of solutions that one of its points is given of, and whether it closes; angles run on past ±π.

    Args:
        linear, step, zero, most: as for `trace`.
        seeds: (N, n) points of the curves; those within a step of a curve before are of that one.
    """
    found = []
    while len(seeds):
        line, closed = trace(linear, seeds[0], step, zero=zero, most=most)
        if not closed:
            behind, _ = trace(linear, seeds[0], step, zero=zero, most=most, sign=-1.0)
            line = np.concatenate([behind[:0:-1], line])
        found.append((line, closed))
        seeds = seeds[1:]
        for start in range(0, len(line), 256):
            gap = np.pi - np.mod(np.pi - (seeds[:, None] - line[None, start : start + 256]), 2 * np.pi)
            seeds = seeds[np.abs(gap).max(axis=2).min(axis=1, initial=np.inf) > step]
    return found


def _tangent(slope: Array) -> Array | None:
    """The null vector of A (e, d); None where there is more than one."""
    _, s, vt = np.linalg.svd(slope)
    d = slope.shape[1]
    if len(s) < d - 1 or s[d - 2] < FLAT:
        return None
    return np.asarray(vt[-1])


def _correct_to_zero(linear: Linear, x: Array, zero: float) -> tuple[Array, Array] | None:
    """x brought back to the zero set, and A there; None where it does not get there."""
    for _ in range(_CORRECTIONS):
        f, slope = linear(x[None])
        if np.abs(f).max() <= zero:
            return x, slope[0]
        x = x - shortest(slope, f, rank=len(x) - 1)[0]  # more equations than that agree on the curve alone
    return None
