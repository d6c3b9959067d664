"""The second order of a singularity: what the null space does to the lost motions.

Move along q + sΔ + ½s²a with Δ in the null space of J. The end effector's twist is s (J a + dJ(Δ)Δ) + O(s²), so

    Q_u(Δ) = u · dJ(Δ)Δ,   u a lost direction (uᵀJ = 0)

is what the joints cannot take back: the end effector moves along u at second order. Q_u is a quadratic form on the null
space. Where it is not zero, the lost direction can be reached so (type 1); where it vanishes, only an internal motion
leaves (type 2). A self-motion needs Q_u(Δ) = 0 for every u; where some Q_u is definite there is none through q, not
even one that starts with a cusp: the leading term c sᵏ of an analytic curve has Q_u(c) = 0 too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rankdrop.local.directions import lost_directions
from rankdrop.local.place import Place
from rankdrop.local.taylor import taylor
from rankdrop.local.vectors import unit
from rankdrop.robot.model import Array
from rankdrop.tolerances import DEFAULT
from rankdrop.units import counted

FLAT = DEFAULT.block_rank
"""A form with entries below this is zero: the cut of D, for the same reason [1/rad]."""
_STARTS = 48  # random starts for directions on which all forms vanish
_NEWTON = 12  # steps of each
_APART = 0.05  # unit vectors nearer than this, up to sign, are the same direction
_SAMPLES = 256  # combinations of lost directions tried for a definite one


@dataclass(frozen=True, slots=True)
class LostMotion:
    """One lost direction at second order.

    Attributes:
        direction: (6,) as from `lost_directions`: vx vy vz wx wy wz in the task's frame.
        type: 1 where the end effector can move along it at second order by Δ in the null space; 2 where not: it is
            left only by internal motion.
        form: eigenvalues of u · dJ(Δ)Δ on the null space, ascending, u of unit length in the scaled task [1/rad].
        words: the same in words.
    """

    direction: tuple[float, ...]
    type: int
    form: tuple[float, ...]
    words: str


def null_derivative(place: Place, basis: Array) -> Array:
    """(s, m, s) dJ(N_a) N_b for the columns of a basis N (n, s) of null motions in scaled coordinates."""
    series = taylor(place.robot, place.q, place.task, basis.T * place.scale, 1)
    return np.asarray(series[1] @ (basis * place.scale[:, None]))


def null_basis(place: Place) -> Array:
    """(n, s) orthonormal basis of the null space of J in scaled joint coordinates."""
    return np.asarray(np.linalg.qr(place.v2 / place.scale[:, None])[0])


def forms(place: Place, basis: Array) -> Array:
    """(m − rank, s, s) symmetric matrices of Q_u on the null space, u the columns of U₂."""
    return _symmetric(np.einsum("mp,amb->pab", place.u2, null_derivative(place, basis)))


def lost_motions(place: Place, basis: Array) -> tuple[LostMotion, ...]:
    """Each lost direction with its form and its type."""
    if not place.corank:
        return ()
    rows = lost_directions(place.robot, place.q, place.task, place.corank)
    scaled = rows.copy()
    scaled[:, :3] *= place.task.scale(place.robot) / counted(place.robot)
    u = scaled[:, list(place.task.rows)]
    each = _symmetric(np.einsum("pm,amb->pab", unit(u), null_derivative(place, basis)))
    return tuple(_lost_motion(row, form) for row, form in zip(rows, each, strict=True))


def definite(each: Array, seed: int) -> bool:
    """Whether some combination of the forms (p, s, s) is definite; a search: False is not a proof."""
    if not each.size:
        return False
    if len(each) == 1:
        weights = np.array([[1.0], [-1.0]])
    else:
        weights = unit(np.random.default_rng(seed).normal(size=(_SAMPLES, len(each))))
    least = np.linalg.eigvalsh(np.einsum("wp,pab->wab", weights, each))[:, 0]
    return bool(least.max() > FLAT)


def vanishing(each: Array, seed: int) -> tuple[Array, bool]:
    """Unit vectors on which all forms vanish, by Gauss–Newton on the sphere from random starts.

    Args:
        each: (p, s, s) forms.
        seed: of the starts.

    Returns:
        (c, s) vectors, and whether the forms are zero as a whole (every vector counts then).
    """
    size = each.shape[-1]
    starts = np.random.default_rng(seed).normal(size=(_STARTS, size))
    starts = np.concatenate([np.eye(size), starts]) if size > 1 else np.eye(1)
    x = unit(starts)
    if not each.size or float(np.abs(each).max()) <= FLAT:
        return x, True
    x = np.concatenate([x, _kernel(each)])
    for _ in range(_NEWTON):
        slope = 2 * np.einsum("pab,cb->cpa", each, x)
        value = np.einsum("pab,ca,cb->cp", each, x, x)
        square = slope @ np.swapaxes(slope, -1, -2) + 1e-14 * np.eye(len(each))
        x = unit(x - np.einsum("cpa,cp->ca", slope, np.linalg.solve(square, value[..., None])[..., 0]))
    left = np.abs(np.einsum("pab,ca,cb->cp", each, x, x)).max(axis=1)
    return x[left <= 1e-10 * max(1.0, float(np.abs(each).max()))], False


def distinct(vectors: Array, order: NDArray[np.intp]) -> list[int]:
    """Indices of unit vectors (c, n) that differ by more than a sign, the first of each in the given order."""
    near = np.abs(vectors @ vectors.T) >= 1.0 - _APART**2 / 2
    kept: list[int] = []
    for i in order:
        if not near[i, kept].any():
            kept.append(int(i))
    return kept


def boundary(place: Place, each: Array) -> tuple[bool | None, str]:
    """Whether q maps to the boundary of the workspace, and why; from the form on the null space, corank 1 only.

    The form's kernel holds the null motions that are tangent to the same singular family (D vanishes on them, for D is
    symmetric on the null space). Modulo them a definite form keeps the end effector on one side.
    """
    if not place.corank:
        full = place.generic == place.task.m
        words = "regular: every direction of the task is open" if full else "undecided: the task is never fully open"
        return (False if full else None), words
    if place.corank > 1 or place.generic < place.task.m:
        return None, "undecided: the second-order test is for one lost direction of a full-rank task"
    eigenvalues = np.linalg.eigvalsh(each[0])
    up, down = bool(eigenvalues[-1] > FLAT), bool(eigenvalues[0] < -FLAT)
    if up and down:
        return False, "interior: at second order the end effector can leave to both sides of the lost direction"
    if up or down:
        return True, "boundary: at second order the end effector stays on one side of the lost direction (near q only)"
    return None, (
        "undecided: the null motions do not move the end effector along the lost direction at second order; "
        "it is crossed, if at all, by internal motion"
    )


def _kernel(each: Array) -> Array:
    """(c, s) vectors that every form sends to zero: Newton's method is slow to find them."""
    _, sigma, vt = np.linalg.svd(each.reshape(-1, each.shape[-1]))
    return np.asarray(vt[int((sigma > FLAT).sum()) :])


def _lost_motion(row: Array, form: Array) -> LostMotion:
    eigenvalues = np.linalg.eigvalsh(form)
    kind = 1 if np.abs(eigenvalues).max(initial=0.0) > FLAT else 2
    words = (
        "the end effector can move along it at second order, by a motion in the null space"
        if kind == 1
        else "left by internal motion only: no motion in the null space moves along it at second order"
    )
    return LostMotion(tuple(float(x) for x in row), kind, tuple(float(x) for x in eigenvalues), words)


def _symmetric(matrices: Array) -> Array:
    return np.asarray((matrices + np.swapaxes(matrices, -1, -2)) / 2)
