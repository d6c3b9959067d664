"""The second order of a singularity: what the null space does to the lost motions.

Move along q + sΔ + ½s²a with Δ in the null space of J. The end effector's twist is s (J a + dJ(Δ)Δ) + O(s²), so

    Q_u(Δ) = u · dJ(Δ)Δ,   u a lost direction (uᵀJ = 0)

is what the joints cannot take back: the end effector moves along u at second order. Q_u is a quadratic form on the null
space. Where it is not zero, the lost direction can be reached so (type 1); where it vanishes, only an internal motion
leaves (type 2). A self-motion needs Q_u(Δ) = 0 for every u; where some Q_u is definite there is none through q, not
even one that starts with a cusp: the leading term c sᵏ of an analytic curve has Q_u(c) = 0 too.

Leaving a singularity with the end effector still: which self-motions go through q, and what they restore.

Which null motions can be tangents of one is told at second order (see above); those are traced a short way, all
at once: steps ahead, each put back to where the end effector was (`displacement`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rankdrop.configuration import Configuration
from rankdrop.local.bracket import unit
from rankdrop.local.departure import taylor
from rankdrop.local.directions import lost_directions
from rankdrop.local.orientation import Displacement, determined_by_pose
from rankdrop.robot.model import Array
from rankdrop.solve import iterate, shortest
from rankdrop.tolerances import DEFAULT
from rankdrop.units import counted

FLAT = DEFAULT.block_rank
"""A form with entries below this is zero: the cut of D, for the same reason [1/rad]."""
_STARTS = 48  # random starts for directions on which all forms vanish
_NEWTON = 12  # steps of each
_APART = 0.05  # unit vectors nearer than this, up to sign, are the same direction
_SAMPLES = 256  # combinations of lost directions tried for a definite one


StillReason = Literal["always moves", "definite", "rows", "no tangent", "regular", "left", "stayed", "stayed so far",
                      "too small", "untraced"]  # fmt: skip
"""Why a singularity can be left with the tool held still ("left"), or cannot, or is not known to be."""
EdgeReason = Literal["open", "never whole", "several", "both signs", "one sign", "flat"]
"""What decides whether the tool is at an edge of its reach: the sign of the form on the null space, or why not."""


@dataclass(frozen=True, slots=True)
class LostMotion:
    """One lost direction at second order.

    Attributes:
        direction: (6,) as from `lost_directions`: vx vy vz wx wy wz in the task's frame.
        type: 1 where the end effector can move along it at second order by Δ in the null space; 2 where not: it is
            left only by internal motion.
        form: eigenvalues of u · dJ(Δ)Δ on the null space, ascending, u of unit length in the scaled task [1/rad].
    """

    direction: tuple[float, ...]
    type: int
    form: tuple[float, ...]


def null_derivative(place: Configuration, basis: Array) -> Array:
    """(s, m, s) dJ(N_a) N_b for the columns of a basis N (n, s) of null motions in scaled coordinates."""
    series = taylor(place.robot, place.q, place.task, basis.T * place.scale, 1)
    return np.asarray(series[1] @ (basis * place.scale[:, None]))


def null_basis(place: Configuration) -> Array:
    """(n, s) orthonormal basis of the null space of J in scaled joint coordinates."""
    return np.asarray(np.linalg.qr(place.v2 / place.scale[:, None])[0])


def forms(place: Configuration, basis: Array) -> Array:
    """(m − rank, s, s) symmetric matrices of Q_u on the null space, u the columns of U₂."""
    return _symmetric(np.einsum("mp,amb->pab", place.u2, null_derivative(place, basis)))


def lost_motions(place: Configuration, basis: Array) -> tuple[LostMotion, ...]:
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

    def along_sphere(x: Array, _active: NDArray[np.intp]) -> Array:
        value, slope = np.einsum("pab,ca,cb->cp", each, x, x), 2 * np.einsum("pab,cb->cpa", each, x)
        return unit(x - shortest(slope, value)) - x

    x = iterate(along_sphere, x, iterations=_NEWTON)
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


def boundary(place: Configuration, each: Array) -> tuple[bool | None, EdgeReason]:
    """Whether q maps to the boundary of the workspace, and why; from the form on the null space, corank 1 only.

    The form's kernel holds the null motions that are tangent to the same singular family (D vanishes on them, for D is
    symmetric on the null space). Modulo them a definite form keeps the end effector on one side.
    """
    if not place.corank:
        full = place.generic == place.task.m
        return (False, "open") if full else (None, "never whole")
    if place.corank > 1 or place.generic < place.task.m:
        return None, "several"
    eigenvalues = np.linalg.eigvalsh(each[0])
    up, down = bool(eigenvalues[-1] > FLAT), bool(eigenvalues[0] < -FLAT)
    if up and down:
        return False, "both signs"
    if up or down:
        return True, "one sign"
    return None, "flat"


def _kernel(each: Array) -> Array:
    """(c, s) vectors that every form sends to zero: Newton's method is slow to find them."""
    _, sigma, vt = np.linalg.svd(each.reshape(-1, each.shape[-1]))
    return np.asarray(vt[int((sigma > FLAT).sum()) :])


def _lost_motion(row: Array, form: Array) -> LostMotion:
    eigenvalues = np.linalg.eigvalsh(form)
    kind = 1 if np.abs(eigenvalues).max(initial=0.0) > FLAT else 2
    return LostMotion(tuple(float(x) for x in row), kind, tuple(float(x) for x in eigenvalues))


def _symmetric(matrices: Array) -> Array:
    return np.asarray((matrices + np.swapaxes(matrices, -1, -2)) / 2)


_MOST = 4  # tangents that are traced, both ways
_STEPS = 4  # of a trace
_LENGTH = 0.12  # at least so far, so that the ends are 0.1 rad away even where the curve bends
_LEFT = 1e-5  # σ_r that a trace has to reach: where it is of second order an error of 1e-12 hides σ of 1e-6
_STAYED = 1e-6  # σ_r up to which a trace counts as singular all along
_FIRST = 1e-6  # singular values of D along a tangent below this are zero


@dataclass(frozen=True, slots=True)
class Trace:
    """Short self-motions from q, one per tangent.

    Attributes:
        q: (c, steps + 1, n) configurations, the first is q itself [rad, m].
        sigma: (c, steps + 1) σ_r there, r the generic rank.
        ranks: (c,) rank at the last one.
        error: (c,) largest displacement of the task on the way, translations over the length scale.
        length: (c,) how far the last one is from q, in scaled coordinates.
        valid: (c,) the end effector stood still and the arm did move.
    """

    q: Array
    sigma: Array
    ranks: NDArray[np.intp]
    error: Array
    length: Array
    valid: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Stillness:
    """What was found.

    Attributes:
        tangent: (n,) unit tangent at q of the traced self-motion that restores most, scaled coordinates; None if none.
        gain: rank at its end minus rank at q.
        order, rate: σ_r ≈ rate · s^order along it; from D where that is of full rank, else from the trace.
        length: distance of its end from q, scaled coordinates.
        sigma_after: σ_r there.
        error: largest task error on the way.
        within_limits: the whole trace stays inside the limits.
        avoidable, reason: see `Escape`.
        forms: (m − rank, s, s) the forms on the null space.
    """

    tangent: Array | None
    gain: int
    order: int | None
    rate: float
    length: float
    sigma_after: float
    error: float
    within_limits: bool
    avoidable: bool | None
    reason: StillReason
    forms: Array


def find_still(place: Configuration, basis: Array, step: float, seed: int) -> Stillness:
    """Look for a self-motion through q that restores the rank, and say what is known if there is none.

    Args:
        place: where.
        basis: (n, s) of the null space, scaled coordinates.
        step: length of a trace, at least 0.12.
        seed: of random starts.
    """
    each = forms(place, basis)
    if not basis.shape[1]:
        return _none(each, False, "always moves")
    if place.corank and definite(each, seed):
        return _none(each, False, "definite")
    if not determined_by_pose(place.task):
        return _none(each, None, "rows")
    vectors, all_vanish = vanishing(each, seed)
    if not len(vectors):
        return _none(each, None, "no tangent")
    tangents, promise = _chosen(place, vectors @ basis.T)
    traced = trace(place, tangents, max(step, _LENGTH))
    return _judged(place, each, tangents, promise, traced, all_vanish or _few(each))


def trace(place: Configuration, tangents: Array, length: float) -> Trace:
    """Follow self-motions with the given tangents.

    Args:
        place: where they start.
        tangents: (c, n) unit vectors in scaled coordinates, in the null space of J.
        length: how far to go, in scaled coordinates.

    Returns:
        What came of each; `valid` is False where the corrector did not bring the end effector back.
    """
    where = Displacement(place.robot, place.q, place.task)
    path, valid = [np.broadcast_to(place.q, tangents.shape)], np.ones(len(tangents), dtype=bool)
    ahead = tangents
    for _ in range(_STEPS):
        reached, arrived = where.back(path[-1] + ahead * (length / _STEPS) * place.scale)
        ahead = unit((reached - path[-1]) / place.scale)
        path.append(reached)
        valid &= arrived
    q = np.stack(path, axis=1)
    sigma = place.singular_values(q)[..., : place.generic]
    gone = np.linalg.norm((q[:, -1] - place.q) / place.scale, axis=1)
    return Trace(
        q=q,
        sigma=sigma[..., -1],
        ranks=(sigma[:, -1] > place.floor).sum(axis=-1),
        error=np.linalg.norm(where.error(q), axis=-1).max(axis=1),
        length=gone,
        valid=valid & (gone >= 0.6 * length),
    )


def _few(each: Array) -> bool:
    """Whether the directions on which the forms vanish are a few lines, which are then all found.

    One form on a plane vanishes on two lines at most, a semidefinite one on its kernel only.
    """
    size = each.shape[-1]
    if size == 1 or (size == 2 and len(each) == 1):
        return True
    if len(each) != 1:
        return False
    eigenvalues = np.linalg.eigvalsh(each[0])
    one_sided = eigenvalues[0] >= -FLAT or eigenvalues[-1] <= FLAT
    return bool(one_sided and (np.abs(eigenvalues) <= FLAT).sum() == 1)


def _chosen(place: Configuration, tangents: Array) -> tuple[Array, Array]:
    """The most promising tangents, both ways, and the k-th singular value of D along each."""
    tangents = unit(tangents)
    series = taylor(place.robot, place.q, place.task, tangents * place.scale, 1)[1]
    if place.corank:
        first = place.u2.T @ series @ place.v2
        promise = np.linalg.svd(first, compute_uv=False)[:, place.corank - 1]
    else:
        r = place.generic - 1
        promise = np.abs(place.u[:, r] @ series @ place.v[:, r])
    kept = distinct(tangents, np.lexsort((np.arange(len(promise)), -np.round(promise, 9))))[:_MOST]
    return np.concatenate([tangents[kept], -tangents[kept]]), np.concatenate([promise[kept], promise[kept]])


def _judged(
    place: Configuration, each: Array, tangents: Array, promise: Array, traced: Trace, complete: bool
) -> Stillness:
    """The best of the traces that stood still."""
    down, up = place.room
    moved = (traced.q - place.q) / place.scale
    inside = np.asarray(((moved >= -down - 1e-9) & (moved <= up + 1e-9)).all(axis=(1, 2)))
    least = max(_LEFT, place.floor) if place.corank else traced.sigma[:, 0]
    leaves = np.asarray(traced.valid & (traced.sigma[:, -1] > least))
    if not leaves.any():
        return _stays(place, each, traced, complete)
    value = np.where(leaves, traced.sigma[:, -1] + 1e3 * inside, -1.0)
    best = int(np.argmax(value))
    sigma = traced.sigma[best]
    order, rate = _along(sigma, float(promise[best]), float(traced.length[best]))
    avoidable = True if place.corank else None
    return Stillness(
        tangents[best], int(traced.ranks[best]) - place.rank, order, rate, float(traced.length[best]), float(sigma[-1]),
        float(traced.error[best]), bool(inside[best]), avoidable, "left", each,
    )  # fmt: skip


def _stays(place: Configuration, each: Array, traced: Trace, complete: bool) -> Stillness:
    """No trace restores the rank: say whether those were all there are."""
    if not place.corank:
        return _none(each, None, "regular")
    stayed = bool((traced.sigma.max(axis=1) <= max(_STAYED, place.floor)).all())
    if complete and stayed and traced.valid.all():
        return _none(each, False, "stayed")
    if stayed and traced.valid.any():
        return _none(each, None, "stayed so far")
    if traced.valid.any():
        return _none(each, None, "too small")
    return _none(each, None, "untraced")


def _along(sigma: Array, promise: float, length: float) -> tuple[int, float]:
    """Order and rate of σ_r along a trace with evenly spaced points."""
    if promise > _FIRST:
        return 1, promise
    quarter = length / (len(sigma) - 1)
    ratio = float(sigma[2] / max(sigma[1], 1e-300))
    order = max(1, round(np.log2(max(ratio, 1e-300))))
    return order, float(sigma[1]) / quarter**order


def _none(each: Array, avoidable: bool | None, reason: StillReason) -> Stillness:
    return Stillness(None, 0, None, 0.0, 0.0, 0.0, 0.0, False, avoidable, reason, each)
