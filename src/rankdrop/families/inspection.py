"""Singular points of a search: what D says of each; those that no family explains are followed down (`descent.py`).

At a regular point of the set of corank ≥ k, ker D is the tangent space and the rows of D span the conormal space C.
Two questions about C give the signature of the point's family, and the same answers hold all over the family:

- which unit covectors e_j lie in C (joint j is pinned) or are orthogonal to it (joint j is free); the rest are coupled;
- which small whole-number covectors m lie in C: then m·q is constant on the family, θ3 + θ5 = 0 say.

The rank of D drops where families meet. Such points are marked irregular: they take part in no grouping.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import chain, combinations, product

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.families.descent import not_singular, verify_points
from rankdrop.families.points import Cloud, count_explained
from rankdrop.formula.equation import Equation
from rankdrop.problem import Mask, Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.tolerances import Tolerances

WELL = 1e-5  # singular values of D [1/rad] above this are clearly not zero: five times `block_rank`
APART = 1e-4  # σ of a kept singular value [1] above which a point is not next to a higher corank
HIGHER = 1e-6  # σ of a kept singular value below which a point has a higher corank
_MANY = 10  # coupled joints beyond which whole-number relations are looked for between two only
INTEGER = 1e-7  # a covector whose part outside C is shorter than this lies in C
_NEARLY = 1e-12  # squares below this are looked at exactly: a hundred times what `INTEGER` leaves
_AT_ONCE = 512  # points whose relations are looked for together: of a long arm, with 10 joints coupled, 20 MB
_ENTRIES = 4_000_000  # entries of D that are held at once: those of 10,000 points of a 10R's corank 1, 32 MB

Covector = tuple[int, ...]

_WIDEST = 16  # narrow side of a matrix that the core takes apart


@dataclass(frozen=True, slots=True, order=True)
class Signature:
    """Rank of D, joints (from 0) pinned, free and coupled, whole-number relations."""

    rank: int
    pinned: tuple[int, ...]
    free: tuple[int, ...]
    coupled: tuple[int, ...]
    relations: tuple[Covector, ...] = ()

    @property
    def residual(self) -> int:
        """Number of independent equations beside the pinned joints and the relations."""
        return self.rank - len(self.pinned) - len(self.relations)

    def covectors(self, n: int) -> tuple[Covector, ...]:
        """The linear conditions of the family: unit covectors of pinned joints, then the relations."""
        return tuple(tuple(int(i == j) for i in range(n)) for j in self.pinned) + self.relations


@dataclass(frozen=True, eq=False)
class Inspection:
    """Points of a cloud with what D says about each.

    Attributes:
        q: (N, n).
        sigma: (N, min(m, n)) singular values of the task Jacobian.
        exact: (N,) corank exactly k.
        regular: (N,) corank exactly k, and every singular value of D clearly zero or clearly not.
        condition: (N,) smallest singular value of D that is not zero.
        signatures: one per point; None where irregular.
        tangent: (N, n, n) projector on ker D.
    """

    q: Array
    sigma: Array
    exact: Mask
    regular: Mask
    condition: Array
    signatures: tuple[Signature | None, ...]
    tangent: Array


def inspect(problem: Problem, q: Array, *, signatures: bool = True) -> Inspection:
    """Signature of every point of a cloud.

    Args:
        problem: the arm, and the corank; of its tolerances `block_rank` and `tangent` are used.
        q: (N, n) points with σ[rank] = 0.
        signatures: False: the rest alone, all signatures None.

    Returns:
        Inspection with arrays over the N points.
    """
    robot, rank, tolerances = problem.robot, problem.rank, problem.tolerances
    count, n = len(q), problem.n
    if not count:
        empty = np.zeros(0, dtype=np.bool_)
        return Inspection(q, np.zeros((0, min(problem.task.m, n))), empty, empty, np.zeros(0), (), np.zeros((0, n, n)))
    entries = (problem.task.m - rank) * (n - rank) * n  # of D
    if count * entries > _ENTRIES and count > 1:
        each = max(_ENTRIES // entries, 1)
        parts = [inspect(problem, q[i : i + each], signatures=signatures) for i in range(0, count, each)]
        return _merge_inspections(parts)
    local = problem.block(q)
    sigma = np.asarray(local.sigma)
    least_kept = sigma[:, rank - 1] if rank else np.full(count, np.inf)  # the smallest singular value that stays
    exact = least_kept > HIGHER
    d = np.asarray(local.d).reshape(count, -1, n)
    s, v = _right(d)
    if s.shape[1] < n:
        s = np.concatenate([s, np.zeros((count, n - s.shape[1]))], axis=1)
    else:
        s = s[:, :n]
    ranks = (s > tolerances.block_rank).sum(axis=1)
    smallest = np.where(ranks > 0, s[np.arange(count), np.maximum(ranks - 1, 0)], 0.0)
    regular = exact & (least_kept > APART) & (smallest > WELL)
    inside = np.arange(n)[None, :] < ranks[:, None]  # (N, n)
    conormal, tangent = ((v * part[:, None, :]) @ v.swapaxes(1, 2) for part in (inside, ~inside))
    if signatures:
        taken = regular
    else:
        taken = np.zeros_like(regular)
    signed = _signatures(robot, conormal, tangent, ranks, taken, tolerances)
    return Inspection(q, sigma, exact, regular, smallest, signed, tangent)


def _merge_inspections(parts: Sequence[Inspection]) -> Inspection:
    """Inspections of the parts of a cloud as one of the whole."""
    names = ("q", "sigma", "exact", "regular", "condition", "tangent")
    arrays = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    return Inspection(**arrays, signatures=tuple(chain.from_iterable(part.signatures for part in parts)))


def _right(d: Array) -> tuple[Array, Array]:
    """Singular values (N, min(e, n)) and right vectors (N, n, n), by columns, of matrices (N, e, n)."""
    if min(d.shape[1:]) <= _WIDEST:
        _, s, v = _core.svd(np.ascontiguousarray(d))
        return s, v
    _, s, vt = np.linalg.svd(d, full_matrices=d.shape[1] < d.shape[2])
    return s, vt.swapaxes(1, 2)


def _signatures(
    robot: Robot, conormal: Array, tangent: Array, ranks: NDArray[np.int64], regular: Mask, tolerances: Tolerances
) -> tuple[Signature | None, ...]:
    """Signatures from projectors on the conormal and the tangent space (N, n, n) of codimension `ranks` (N,); None
    where a point is not regular."""
    result: list[Signature | None] = [None] * len(conormal)
    pinned, free = (np.einsum("njj->nj", space) < tolerances.tangent for space in (tangent, conormal))
    where = np.flatnonzero(regular)
    keys, alike = np.unique(np.column_stack([ranks, pinned, free])[where], axis=0, return_inverse=True)
    for number, (rank, *held) in enumerate(keys.tolist()):
        points = where[alike.reshape(-1) == number]
        joints = range(robot.n)
        pins, frees = (tuple(j for j in joints if part[j]) for part in (held[: robot.n], held[robot.n :]))
        coupled = tuple(j for j in joints if j not in pins and j not in frees)
        turning = tuple(j for j in coupled if robot.periodic[j])
        for point, relations in zip(points, _relations(conormal[points], turning, robot.n), strict=True):
            result[point] = Signature(rank, pins, frees, coupled, relations)
    return tuple(result)


@lru_cache(maxsize=64)
def candidates(coupled: tuple[int, ...], n: int) -> NDArray[np.int64]:
    """(c, n) whole-number covectors on coupled joints: entries ±1 on 2–4 joints, ±1, ±2 on 2; simplest first.

    On 2 joints only where there are more than `_MANY`: there would be tens of thousands.
    """
    places = []
    for size in (2, 3, 4) if len(coupled) <= _MANY else (2,):
        values = (-2, -1, 1, 2) if size == 2 else (-1, 1)
        for support in combinations(coupled, size):
            for entries in product(values, repeat=size):
                if entries[0] > 0 and np.gcd.reduce(np.abs(entries)) == 1:
                    row = np.zeros(n, dtype=np.int64)
                    row[list(support)] = entries
                    places.append(row)
    places.sort(key=lambda row: (np.count_nonzero(row), int(np.abs(row).sum()), tuple(-row)))
    rows = np.array(places, dtype=np.int64).reshape(-1, n)
    rows.flags.writeable = False  # the same to everyone who asks
    return rows


def _relations(conormal: Array, coupled: tuple[int, ...], n: int) -> list[tuple[Covector, ...]]:
    """For every point an independent set of the simplest whole-number covectors in its conormal space."""
    tried = candidates(coupled, n)
    if not len(tried):
        return [()] * len(conormal)
    entries = (tried[:, :, None] * tried[:, None, :]).reshape(len(tried), -1).T.astype(np.float64)  # m mᵀ of each
    length = (tried * tried).sum(axis=1)
    cache: dict[bytes, tuple[Covector, ...]] = {}
    result = []
    for first in range(0, len(conormal), _AT_ONCE):
        part = conormal[first : first + _AT_ONCE]
        near = length - part.reshape(len(part), -1) @ entries < _NEARLY  # |m − C m|² = |m|² − mᵀC m, C a projector
        point, which = np.nonzero(near)
        off = tried[which] - np.einsum("nij,nj->ni", part[point], tried[which])
        near[point, which] = np.linalg.norm(off, axis=-1) < INTEGER
        for row in near:
            key = row.tobytes()
            if key not in cache:
                cache[key] = independent(tried[row])
            result.append(cache[key])
    return result


def independent(rows: NDArray[np.int64]) -> tuple[Covector, ...]:
    """Of covectors in order, those that the earlier ones do not span."""
    chosen: list[Covector] = []
    for row in rows:
        if np.linalg.matrix_rank(np.array([*chosen, row])) > len(chosen):
            chosen.append(tuple(int(x) for x in row))
    return tuple(chosen)


def near_misses(
    points: Cloud, remaining: NDArray[np.int64], families: Sequence[Sequence[Equation]]
) -> tuple[NDArray[np.int64], float]:
    """Configurations on no family that are not singular, decided with 50 digits (`not_singular`).

    Args:
        points: from `cloud`.
        remaining: (L,) indices of the points that `count_explained` leaves over.
        families: the equations of each family, as for `count_explained`.

    Returns:
        (≤ L,) the indices of points that are not singular; the smallest minimum of σ next to them, inf without one.
    """
    wrong = [remaining[:0]]
    least = np.inf
    for corank in np.unique(points.corank[remaining]).tolist():
        mine = remaining[points.corank[remaining] == corank]
        problem = Problem(points.robot, points.task, corank)

        def on_family(q: Array, corank: int = corank) -> Mask:
            _, others = count_explained(Cloud(points.robot, points.task, q, np.full(len(q), corank)), families)
            return ~np.isin(np.arange(len(q)), others)

        mistakes, lowest = not_singular(problem, verify_points(problem, points.q[mine]), on_family)
        wrong.append(mine[mistakes])
        least = min(least, lowest)
    return np.concatenate(wrong), least
