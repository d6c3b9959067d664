"""Canadarm2 for KG: its screws, this package's derivation, and places where printed formulas vanish."""

from __future__ import annotations

from functools import cache
from math import pi

import numpy as np

from papers import kg_text as kg
from papers.formula import value
from rankdrop.exact import Suppression, exact_chain, suppress
from rankdrop.families import search
from rankdrop.kinematics import jacobian
from rankdrop.local import sample, singular_values
from rankdrop.robot import Array, Robot, open_robot
from rankdrop.task import Frame, resolve_task

DAMAGED = "The copy at hand is damaged here; restored."
SMALL, _NEWTON = 1e-9, 60


@cache
def arm() -> Robot:
    """Canadarm2 of the catalogue."""
    return open_robot("canadarm2")


@cache
def derivation() -> Suppression:
    """KG's derivation by this package, in their frame and with their basic screws."""
    return suppress(exact_chain(arm(), lengths=kg.LENGTHS), frame=5, basic=range(2, 8))


@cache
def places() -> Array:
    """(200, 7) random configurations."""
    return sample(arm(), resolve_task(None, arm()), 200, 3)


def screws(q: Array) -> Array:
    """(..., 6, 7) joint screws in frame 5, rows (ω; v) as KG have them."""
    return np.roll(jacobian(arm(), q, Frame(5, 5)), 3, axis=-2)


def determinant(q: Array, joints: tuple[int, ...], rows: int = 6) -> Array:
    """(...,) determinant of the first rows of some columns."""
    return np.asarray(np.linalg.det(screws(q)[..., :rows, [j - 1 for j in joints]]))


def worst(one: Array, other: Array) -> float:
    """Largest difference, by the size of the larger."""
    return float(np.abs(one - other).max() / max(1.0, float(np.abs(other).max())))


def with_zero(index: int, value_of: float = 0.0) -> Array:
    """`places` with one joint at a value, 0 and π in turn where it is zero."""
    q = places().copy()
    q[:, index - 1] = value_of
    q[::2, index - 1] += pi
    return q


def on(texts: tuple[str, ...], seed: int = 0, count: int = 400) -> Array:
    """(N, 7) configurations where the formulas vanish, by Gauss–Newton with central differences from random starts."""
    q = sample(arm(), resolve_task(None, arm()), count, seed).copy()

    def values(at: Array) -> Array:
        return np.stack([value(text, at, kg.LENGTHS) for text in texts], axis=-1)

    for _ in range(_NEWTON):
        slopes = np.stack([(values(q + 1e-6 * e) - values(q - 1e-6 * e)) / 2e-6 for e in np.eye(7)], axis=-1)
        step = np.einsum("nji,ni->nj", np.linalg.pinv(slopes, rcond=1e-6), values(q))
        q = q - step * np.minimum(1.0, 0.5 / np.maximum(np.linalg.norm(step, axis=1), 1e-12))[:, None]
    return np.asarray(q[np.abs(values(q)).max(axis=1) < 1e-10])


def sigma6(q: Array) -> Array:
    """(N,) the smallest singular value of the 6 × 7 Jacobian."""
    return singular_values(arm(), q, resolve_task(None, arm()))[:, 5]


@cache
def singular() -> Array:
    """(N, 7) singular configurations that 500 random starts lead to."""
    return search(arm(), 1, starts=500, seed=4).converged
