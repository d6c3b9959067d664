"""Families on which D vanishes more than it should: recognised by the values their points share.

Where the condition is a square, D does not see it (det J of the Stanford arm is q3²·sin θ2·sin θ5 up to a constant:
D = 0 all over q3 = 0). Tangent spaces are of no use there, and points are known to √`target` only. But the values that
unit covectors and small whole-number covectors take do not scatter: those that many points share are conditions, and a
direct test of the rank at these values decides.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.linear import SIMPLE, Linear, Values, boxes, canonical, grow
from rankdrop.families.row import Row, verified
from rankdrop.families.sampling import Setting
from rankdrop.families.signature import Covector, Signature, candidates, independent
from rankdrop.family.system import Mask
from rankdrop.local.block import block
from rankdrop.robot.model import Array

WIDTH = 3e-5  # values closer than this are shared [rad or length scales]
SHARED = 5  # points that must share a value
TRIES = 8  # groups of points that are tried, large ones first


def recognised(setting: Setting, q: Array, rng: np.random.Generator) -> list[Row]:
    """Rows with linear conditions only, from the values that points share.

    Args:
        setting: arm, task, corank.
        q: (N, n) singular points that no row explains.
        rng: for the direct tests.
    """
    if len(q) < SHARED:
        return []
    n = setting.robot.n
    moving = [int(j) for j in np.flatnonzero(~setting.irrelevant)]
    units = np.eye(n, dtype=np.int64)[moving]
    angles = [j for j in moving if setting.robot.periodic[j]]
    covectors = np.concatenate([units, candidates(angles, n)])
    shared = np.stack([_shared(Linear.of(setting.robot, [tuple(m)]).values(q)[:, 0]) for m in covectors], axis=1)
    patterns, inverse, counts = np.unique(shared, axis=0, return_inverse=True, return_counts=True)
    rows: list[Row] = []
    for label in np.argsort(-counts, kind="stable")[:TRIES]:
        conditions = independent(covectors[patterns[label]])
        if conditions and counts[label] >= SHARED:
            rows += _rows(setting, conditions, q[inverse.reshape(-1) == label], rng)
    return rows


def _rows(setting: Setting, conditions: tuple[Covector, ...], q: Array, rng: np.random.Generator) -> list[Row]:
    linear = Linear.of(setting.robot, conditions)
    met = linear.combinations(q, np.ones(len(q)), WIDTH)
    sharp = [_sharpened(setting, linear, values, q[members]) for values, members in met.items()]
    found = grow(sharp, linear, partial(verified, setting, linear, (), 0, rng=rng))
    signature = _signature(linear)
    return [Row(linear, sets, (), signature, "shared values, verified") for sets in boxes(found)]


def _sharpened(setting: Setting, linear: Linear, values: Values, q: Array) -> Values:
    """The values that are not simple, right to rounding: solved for with the simple ones put at their places.

    Where D is not zero but of too low a rank, σ is of first order in some combination of the errors.
    """
    vague = [i for i, v in enumerate(values) if linear.periodic[i] and abs(v / SIMPLE - round(v / SIMPLE)) > 1e-12]
    if not vague:
        return values
    rng = np.random.default_rng(0)
    at = linear.place(q[:16].copy(), np.repeat(np.array([values]), len(q[:16]), axis=0), rng)
    pivots = [linear.pivots[i] for i in range(len(linear))]
    moves = np.zeros((setting.robot.n, len(vague)))  # what one value drags along
    moves[pivots] = np.linalg.inv(linear.covectors[:, pivots].astype(np.float64))[:, vague]
    for _ in range(4):
        local = block(setting.robot, at, setting.task, setting.rank)
        f = np.asarray(local.f).reshape(-1)
        slope = np.asarray(local.d).reshape(len(f), setting.robot.n) @ moves
        at = at - np.linalg.lstsq(slope, f, rcond=1e-6)[0] @ moves.T
    sharp = linear.values(at[:1])[0]
    return tuple(canonical(float(sharp[i])) if i in vague else v for i, v in enumerate(values))


def _signature(linear: Linear) -> Signature:
    n = linear.covectors.shape[1]
    single = np.count_nonzero(linear.covectors, axis=1) == 1
    pinned = tuple(int(np.flatnonzero(m)[0]) for m in linear.covectors[single])
    coupled = tuple(int(j) for j in np.flatnonzero(linear.covectors[~single].any(axis=0)))
    free = tuple(j for j in range(n) if j not in pinned and j not in coupled)
    relations = tuple(tuple(int(x) for x in m) for m in linear.covectors[~single])
    return Signature(len(linear), pinned, free, coupled, relations, ())


def _shared(values: Array) -> Mask:
    """(N,) whether at least `SHARED` points have a value within `WIDTH`."""
    order = np.argsort(values, kind="stable")
    labels: NDArray[np.int64] = np.empty(len(values), dtype=np.int64)
    labels[order] = np.concatenate([[0], np.cumsum(np.diff(values[order]) > WIDTH)])
    ends = labels[order[0]] != labels[order[-1]] and values[order[0]] + 2 * np.pi - values[order[-1]] < WIDTH
    if ends:
        labels[labels == labels[order[-1]]] = labels[order[0]]
    return np.asarray(np.bincount(labels)[labels] >= SHARED)

