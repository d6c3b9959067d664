"""Which null motions are tangents of a self-motion: all at a regular configuration, few at a singular one.

A curve q0 + t v + ½ t² a keeps the displacement d at zero to second order if J v = 0 and J a + d²(v, v) = 0. The second
has a solution a only if

    u · d²(v, v) = 0   for every u with uᵀJ = 0:

one quadratic condition on v for each lost direction. It is necessary; whether a curve exists is then seen by tracing.
"""

from __future__ import annotations

import numpy as np

from rankdrop.local.displacement import Displacement
from rankdrop.robot.model import Array

INTEGRABLE = 1e-6
"""Second-order part along lost directions below which it counts as none [1/rad²]: derivatives are taken by differences,
good to 1e-9."""
_DIFFERENCE = 1e-4  # of a central difference: error 1e-9, rounding 1e-12
_STARTS = 40
_ROUNDS = 30


def forms(where: Displacement, rank: int) -> tuple[Array, Array]:
    """Null space (n, s) at the start in scaled coordinates, and the quadratic forms (m − rank, s, s) on it."""
    u, _, v = where.split(where.start)
    null, lost = v[:, rank:], u[:, rank:]
    bent = np.empty((null.shape[1], len(u), len(v)))
    for i, motion in enumerate(null.T):
        shift = _DIFFERENCE * where.joints * motion
        bent[i] = (where.derivative(where.start + shift) - where.derivative(where.start - shift)) / (2 * _DIFFERENCE)
    found = np.einsum("mp,imn,nj->pij", lost, bent, null)
    return null, 0.5 * (found + found.swapaxes(1, 2))


def obstruction(quadratic: Array, coefficients: Array) -> float:
    """Largest second-order motion along a lost direction for a unit null motion [1/rad²]."""
    return float(np.abs(np.einsum("pij,i,j->p", quadratic, coefficients, coefficients)).max(initial=0.0))


def tangents(quadratic: Array, first: Array) -> list[Array]:
    """Unit coefficients of null motions that satisfy all second-order conditions, `first` among the first if it does.

    Solved by Gauss–Newton on the sphere from `first`, the basis and seeded random starts: what is found is checked,
    what is not found may exist.
    """
    count = len(first)
    random = np.random.default_rng(0).normal(size=(_STARTS, count))
    found: list[Array] = []
    for start in [first, *np.eye(count), *random]:
        c = start / np.linalg.norm(start)
        for _ in range(_ROUNDS):
            along = quadratic @ c  # (p, s)
            if np.abs(along @ c).max(initial=0.0) <= 1e-2 * INTEGRABLE:
                break
            c = c - np.linalg.lstsq(2.0 * along, along @ c, rcond=1e-9)[0]
            c = c / max(float(np.linalg.norm(c)), np.finfo(float).tiny)
        if obstruction(quadratic, c) <= INTEGRABLE and not any(abs(c @ other) > 0.999 for other in found):
            found.append(c)
    return found


def definite(quadratic: Array) -> bool:
    """Whether one of the forms alone forbids every null motion (it has one sign), so that none is a tangent."""
    for form in quadratic:
        values = np.linalg.eigvalsh(form)
        if values[0] > INTEGRABLE or values[-1] < -INTEGRABLE:
            return True
    return False
