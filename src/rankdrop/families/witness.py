"""A readable configuration on a family: zeros where nothing depends on a joint, round numbers elsewhere."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from rankdrop.families.linear import Linear
from rankdrop.families.row import Row
from rankdrop.families.sampling import Setting
from rankdrop.family.system import System
from rankdrop.local.block import sampling_box, singular_values
from rankdrop.robot.model import Array

TRIES = 64  # round configurations that are looked at
ROUND = 0.1  # free angles stand at multiples of this [rad], free lengths at multiples of a power of ten [m]


def witness(setting: Setting, row: Row, rng: np.random.Generator) -> Array | None:
    """(n,) a point of the row of corank exactly k, the next singular value as large as round numbers allow.

    Joints on which σ does not depend are 0, free ones at round numbers, pinned ones at the first of their values,
    and only as many coupled ones as there are residual equations are solved for. None when no try succeeds.
    """
    values = np.array([[one[0] for one in row.sets]] * TRIES).reshape(TRIES, -1)
    placed = row.linear.place(_round(setting, rng), values, rng)
    best: tuple[float, Array | None] = (0.0, None)
    for along in _ways(row) if row.residual else [np.zeros((setting.robot.n, 0))]:
        q, good = placed, np.ones(TRIES, dtype=np.bool_)
        if row.residual:
            q, good = System(row.residual).solve(placed, along=along)
        q = _near_zero(setting, q)
        good = good & setting.allowed(q)
        sigma = singular_values(setting.robot, q, setting.task)
        good &= sigma[:, setting.rank] <= setting.tolerances.singular
        gap = np.where(good, sigma[:, setting.rank - 1] if setting.rank else 1.0, 0.0)
        i = int(np.argmax(gap))
        if gap[i] > max(1e-6, 1.2 * best[0]):
            best = (float(gap[i]), q[i])
    return best[1]


def _round(setting: Setting, rng: np.random.Generator) -> Array:
    """(TRIES, n) random configurations of round numbers."""
    low, high = sampling_box(setting.robot, setting.task, limits=setting.limits)
    periodic = setting.robot.periodic
    reach = np.where(periodic, 1.5, 0.5 * (high - low))
    middle = np.where(setting.limits | ~periodic, 0.5 * (low + high), 0.0)
    half = 0.5 * np.maximum(high - low, 1e-9)
    scale = np.where(periodic, ROUND, 10.0 ** np.floor(np.log10(0.4 * half)))
    q = middle + rng.uniform(-1, 1, (TRIES, setting.robot.n)) * np.minimum(reach, half)
    q = np.round(q / scale) * scale
    q = np.where((q < low) | (q > high), middle, q)
    resting = setting.irrelevant & (low <= 0) & (high >= 0)
    return np.asarray(np.round(np.where(resting, 0.0, q), 12), dtype=np.float64)


def _ways(row: Row) -> list[Array]:
    """Directions in which the residual equations may be solved: as few coupled joints as there are equations."""
    need = row.signature.residual
    moves = _moves(row.linear)
    coupled = [j for j in row.signature.coupled if j not in row.linear.pivots]
    few = list(combinations(reversed(coupled), need))[:12]
    return [np.linalg.qr(moves[:, list(chosen)])[0] for chosen in few] + [row.linear.along]


def _moves(linear: Linear) -> Array:
    """(n, n) column j: what joint j drags along so that all covectors keep their values (zero for pivots)."""
    n = linear.covectors.shape[1]
    moves = np.eye(n)
    if len(linear):
        pivots = list(linear.pivots)
        moves[:, pivots] = 0.0
        moves[pivots] = -np.linalg.solve(linear.covectors[:, pivots].astype(np.float64), linear.covectors @ moves)
    return moves


def _near_zero(setting: Setting, q: Array) -> Array:
    """Angles in (−π, π] where no limits are set; rounding around zero taken off."""
    if not setting.limits:
        q = np.where(setting.robot.periodic, np.pi - np.mod(np.pi - q, 2 * np.pi), q)
    return np.where(np.abs(q) < 1e-15, 0.0, q)
