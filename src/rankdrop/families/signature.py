"""What kind of family a singular point lies on, read from D alone.

At a regular point of the set of corank ≥ k, ker D is the tangent space and the rows of D span the conormal space C.
Three questions about C give the signature of the point's family, and the same answers hold all over the family:

- which unit covectors e_j lie in C (joint j is pinned) or are orthogonal to it (joint j is free); the rest are coupled;
- which small whole-number covectors m lie in C: then m·q is constant on the family, θ3 + θ5 = 0 say;
- which small sets of coupled joints are bound by an equation of their own (C has a covector with that support). In the
  language of algebraic matroids these sets hold the circuits; pinned joints are its loops, free joints its coloops.

The rank of D drops where families meet. Such points are marked irregular: they take part in no grouping.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.family.equation import Mask
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.tolerances import Tolerances

WELL = 1e-5  # singular values of D [1/rad] above this are clearly not zero: five times `block_rank`
APART = 1e-4  # σ of a kept singular value [1] above which a point is not next to a higher corank
HIGHER = 1e-6  # σ of a kept singular value below which a point has a higher corank
_MANY = 10  # coupled joints beyond which whole-number relations are looked for between two only
INTEGER = 1e-7  # a covector whose part outside C is shorter than this lies in C
_NEARLY = 1e-12  # squares below this are looked at exactly: a hundred times what `INTEGER` and `DEPENDENT` leave
_AT_ONCE = 512  # points whose relations are looked for together: of a long arm, with 10 joints coupled, 20 MB
_ENTRIES = 4_000_000  # entries of D that are held at once: those of 10,000 points of a 10R's corank 1, 32 MB
DEPENDENT = 1e-14  # smallest eigenvalue of the projector on ker D, restricted to dependent joints

Covector = tuple[int, ...]


@dataclass(frozen=True, slots=True, order=True)
class Signature:
    """Rank of D, joints (from 0) pinned, free and coupled, whole-number relations, sets of joints bound together."""

    rank: int
    pinned: tuple[int, ...]
    free: tuple[int, ...]
    coupled: tuple[int, ...]
    relations: tuple[Covector, ...]
    bound: tuple[tuple[int, ...], ...]

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
        parts = [q[first : first + each] for first in range(0, count, each)]
        return joined([inspect(problem, part, signatures=signatures) for part in parts])
    local = problem.block(q)
    sigma = np.asarray(local.sigma)
    exact = sigma[:, rank - 1] > HIGHER if rank else np.ones(count, dtype=np.bool_)
    d = np.asarray(local.d).reshape(count, -1, n)
    s, v = _right(d)
    s = np.concatenate([s, np.zeros((count, n - s.shape[1]))], axis=1) if s.shape[1] < n else s[:, :n]
    ranks = (s > tolerances.block_rank).sum(axis=1)
    smallest = np.where(ranks > 0, s[np.arange(count), np.maximum(ranks - 1, 0)], 0.0)
    clear = sigma[:, rank - 1] > APART if rank else np.ones(count, dtype=np.bool_)
    regular = exact & clear & (smallest > WELL)
    inside = np.arange(n)[None, :] < ranks[:, None]  # (N, n)
    conormal, tangent = ((v * part[:, None, :]) @ v.swapaxes(1, 2) for part in (inside, ~inside))
    taken = regular if signatures else np.zeros_like(regular)
    signed = signatures_of(robot, conormal, tangent, ranks, taken, tolerances)
    return Inspection(q, sigma, exact, regular, smallest, signed, tangent)


def joined(parts: list[Inspection]) -> Inspection:
    """One inspection of the points of several."""
    names = ("q", "sigma", "exact", "regular", "condition", "tangent")
    arrays = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    return Inspection(**arrays, signatures=tuple(one for part in parts for one in part.signatures))


_WIDEST = 16  # narrow side of a matrix that the core takes apart


def _right(d: Array) -> tuple[Array, Array]:
    """Singular values (N, min(e, n)) and right vectors (N, n, n), by columns, of matrices (N, e, n)."""
    if min(d.shape[1:]) <= _WIDEST:
        _, s, v = _core.svd(np.ascontiguousarray(d))
        return s, v
    _, s, vt = np.linalg.svd(d, full_matrices=d.shape[1] < d.shape[2])
    return s, vt.swapaxes(1, 2)


def signatures_of(
    robot: Robot, conormal: Array, tangent: Array, ranks: NDArray[np.int64], regular: Mask, tolerances: Tolerances
) -> tuple[Signature | None, ...]:
    """Signatures from projectors on the conormal and the tangent space (N, n, n) of codimension `ranks` (N,); None
    where a point is not regular."""
    result: list[Signature | None] = [None] * len(conormal)
    pinned = np.einsum("njj->nj", tangent) < tolerances.tangent
    free = np.einsum("njj->nj", conormal) < tolerances.tangent
    keys = np.concatenate([ranks[:, None], pinned, free], axis=1)
    where = np.flatnonzero(regular)
    alike: dict[bytes, list[int]] = {}
    for point, key in zip(where.tolist(), keys[where], strict=True):
        alike.setdefault(key.tobytes(), []).append(point)
    turning, n = robot.periodic, robot.n
    for members in alike.values():
        rank, pins, frees = int(ranks[members[0]]), *(
            tuple(int(j) for j in np.flatnonzero(which[members[0]])) for which in (pinned, free)
        )
        coupled = tuple(j for j in range(n) if j not in pins and j not in frees)
        relations = _relations(conormal[members], tuple(j for j in coupled if turning[j]), n)
        bound = _bound(tangent[members], coupled)
        for i, point in enumerate(members):
            result[point] = Signature(rank, pins, frees, coupled, relations[i], bound[i])
    return tuple(result)


@lru_cache(maxsize=64)
def candidates(coupled: tuple[int, ...], n: int) -> NDArray[np.int64]:
    """(c, n) whole-number covectors on coupled joints: entries ±1 on 2–4 joints, ±1, ±2 on 2; simplest first.

    On 2 joints only where there are more than `_MANY`: there would be tens of thousands.
    """
    found = []
    for size in (2, 3, 4) if len(coupled) <= _MANY else (2,):
        values = (-2, -1, 1, 2) if size == 2 else (-1, 1)
        for support in combinations(coupled, size):
            for entries in product(values, repeat=size):
                if entries[0] > 0 and np.gcd.reduce(np.abs(entries)) == 1:
                    row = np.zeros(n, dtype=np.int64)
                    row[list(support)] = entries
                    found.append(row)
    found.sort(key=lambda row: (np.count_nonzero(row), int(np.abs(row).sum()), tuple(-row)))
    rows = np.array(found, dtype=np.int64).reshape(-1, n)
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


def _bound(tangent: Array, coupled: tuple[int, ...]) -> list[tuple[tuple[int, ...], ...]]:
    """For every point the sets of 2 or 3 coupled joints whose motions on the family are dependent."""
    result: list[list[tuple[int, ...]]] = [[] for _ in range(len(tangent))]
    for size in (2, 3):
        for support in combinations(coupled, size):
            part = tangent[:, support, :][:, :, support]
            near = np.flatnonzero(np.linalg.det(part) < _NEARLY)  # no eigenvalue of a part of a projector is above 1
            for i in near[np.linalg.eigvalsh(part[near])[:, 0] < DEPENDENT]:
                result[i].append(support)
    return [tuple(sets) for sets in result]
