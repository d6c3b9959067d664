"""From the points of a cloud to the rows of a table, for arms whose families no derivation finished.

What rows leave open is not hidden: each kind of points that no row explains becomes a family without a name.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.fit import Budget, holds
from rankdrop.families.linear import SIMPLE, FamilyPoints, Linear, Values, boxes, canonical, grow, smooth
from rankdrop.families.residual import residual_equations
from rankdrop.families.row import Row, verified
from rankdrop.families.signature import Covector, Inspection, Signature, candidates, independent, inspect
from rankdrop.family.equation import Mask
from rankdrop.family.naming import lost_motions
from rankdrop.family.record import Check, Family, Pin, Sampled
from rankdrop.problem import Problem
from rankdrop.robot.model import Array

FITS = 16  # combinations of values of one signature that are fitted on their own, at most
QUICK, THOROUGH = 1.5e9, 6e9  # work for one group: circuits only, and everything
HARD = 8  # groups that are tried a second time, thoroughly
FEW = 3  # points from which a fit is tried
ROUNDING = 10.0  # times `target`: σ below this tells nothing
BADLY = 0.1  # share of the points left out of fits: those that are known worst
Groups = list[tuple[Signature, NDArray[np.int64]]]


def find_rows(
    problem: Problem,
    inspection: Inspection,
    cover: Membership,
    seed: int,
    progress: Callable[[int, int], None] | None = None,
) -> list[Row]:
    """Rows that explain the regular points of a cloud, each verified to be singular.

    Groups are taken by dimension, large ones first, so that a group whose points already lie on a row costs nothing.

    Args:
        problem: the arm, and the corank.
        inspection: the cloud with its signatures.
        cover: of the points of the cloud.
        seed: of every random choice.
        progress: called with (groups done, groups).
    """
    budget = Budget()
    groups = grouped(inspection)
    rows = _fitted(problem, inspection, groups, cover, budget, (seed, problem.corank), progress)
    rest = inspection.q[inspection.exact & ~on_any(cover, rows, len(inspection.q))]
    if len(rest):
        rows += recognised(problem, rest, np.random.default_rng([seed, problem.corank, len(groups)]))
    rng = np.random.default_rng([seed, problem.corank, len(groups) + 1])
    return without_contained(problem, rows, rng)


def _fitted(
    problem: Problem,
    inspection: Inspection,
    groups: Groups,
    cover: Membership,
    budget: Budget,
    seed: tuple[int, ...],
    progress: Callable[[int, int], None] | None = None,
) -> list[Row]:
    """Rows of the groups of an inspection."""
    rows: list[Row] = []
    hard = sorted((i for i, (s, _) in enumerate(groups) if s.residual > 0), key=lambda i: -len(groups[i][1]))[:HARD]
    for step, index in enumerate([*range(len(groups)), *hard]):
        if progress is not None:
            progress(step, len(groups) + len(hard))
        thorough = step >= len(groups)
        signature, members = groups[index]
        left = members[~on_any(cover, rows, len(inspection.q))[members]]
        if not signature.rank or len(left) < (FEW if signature.residual else 1):
            continue
        rng = np.random.default_rng([*seed, index, int(thorough)])
        if smooth(problem, inspection, left, rng):
            rows += _rows_of(problem, signature, inspection, left, budget, rng, thorough=thorough)
    return rows


def grouped(inspection: Inspection) -> Groups:
    """Points by signature: large dimension first, then many points first."""
    found: dict[Signature, list[int]] = {}
    for point, signature in enumerate(inspection.signatures):
        if signature is not None:
            found.setdefault(signature, []).append(point)
    _join(found)
    order = sorted(found, key=lambda s: (s.rank, -len(found[s]), s))
    return [(signature, np.array(found[signature])) for signature in order]


def _join(found: dict[Signature, list[int]]) -> None:
    """Single points whose joints happen to move in a special way go to the group that agrees in everything else."""
    for signature in sorted(found, key=lambda s: (len(found[s]), s)):
        alike = [s for s in found if s != signature and replace(s, bound=()) == replace(signature, bound=())]
        home = max(alike, key=lambda s: (len(found[s]), s), default=None)
        if home is not None and 50 * len(found[signature]) < len(found[home]):
            found[home] += found.pop(signature)


Membership = Callable[[Row], Mask]
"""(N,) which points of a cloud lie on a row."""


def membership(problem: Problem, q: Array) -> Membership:
    """Which of the points q (N, n) lie on a row; each row is asked once."""
    return cache(lambda row: on_row(problem, row, q))


def on_any(cover: Membership, rows: Sequence[Row], count: int) -> Mask:
    """(count,) which points lie on any of the rows."""
    inside = np.zeros(count, dtype=np.bool_)
    for row in rows:
        inside |= cover(row)
    return inside


def on_row(problem: Problem, row: Row, q: Array) -> Mask:
    """(N,) whether points lie on a row.

    A point lies on a row when it is nearer than `tolerances.explained`, or solves the equations to rounding: where
    these are flat, as next to a special structure, rounding alone makes a longer way of it. Where several sheets meet,
    σ is of third or higher order in the distance and a point is known less well than that. So a point also lies on a
    row when σ stays at rounding level on the whole way to it: then nothing tells the point from its foot on the row.
    """
    distance, foot = row.system.nearest(q)
    near = (distance <= problem.tolerances.explained) | row.system.zero(q)
    unsure = np.flatnonzero(~near & np.isfinite(distance))
    if len(unsure):
        part = np.linspace(0.0, 1.0, 6)[:, None, None]
        way = (1 - part) * q[unsure] + part * foot[unsure]  # (6, U, n)
        sigma = problem.sigma(way)[..., problem.rank]
        near[unsure] = (sigma.reshape(6, -1) <= ROUNDING * problem.tolerances.target).all(axis=0)
    return near


def _rows_of(
    problem: Problem,
    signature: Signature,
    inspection: Inspection,
    members: NDArray[np.int64],
    budget: Budget,
    rng: np.random.Generator,
    *,
    thorough: bool,
) -> list[Row]:
    linear = Linear.of(problem.robot, signature.covectors(problem.n))
    weights = inspection.condition[members]
    met = linear.combinations(inspection.q[members], weights, problem.tolerances.value)
    if not signature.residual:
        found = grow(met, linear, partial(verified, problem, linear, (), 0, rng=rng))
        return [Row(linear, sets, (), signature, "values verified") for sets in boxes(found)]
    part = budget.share(THOROUGH if thorough else QUICK)
    rows: list[Row] = []
    done: set[Values] = set()
    for values in sorted(met, key=lambda values: (-len(met[values]), values))[:FITS]:
        if values in done:
            continue
        here = members[met[values]]
        here = rng.permutation(here[inspection.condition[here] >= np.quantile(inspection.condition[here], BADLY)])
        q, tangent = inspection.q[here], inspection.tangent[here]
        source = FamilyPoints(problem, signature, linear, values, q, tangent, rng)
        residual = residual_equations(source, part, thorough=thorough)
        if residual is None:
            continue
        alike = [v for v in met if all(holds(e, inspection.q[members[met[v]]]) for e in residual)]
        holding = partial(verified, problem, linear, residual, signature.residual, rng=rng)
        found = grow([values, *alike], linear, holding)
        done |= found
        rows += [Row(linear, sets, residual, signature, "fitted, then verified") for sets in boxes(found)]
    budget.back(part)
    return rows


def without_contained(problem: Problem, rows: list[Row], rng: np.random.Generator) -> list[Row]:
    """Drop what lies within a larger row, combination of values by combination: θ4 = 0 or π may shrink to θ4 = 0.

    Found by sampling each combination and testing the other rows' equations.
    """
    kept: list[Row] = []
    for row in sorted(rows, key=lambda row: row.signature.rank):
        q, good = row.sample(problem, 6, rng)
        inside = np.zeros(len(q), dtype=np.bool_)
        for other in kept:
            hits = on_row(problem, other, q.reshape(-1, q.shape[2])).reshape(good.shape)
            inside |= (hits | ~good).all(axis=1) & good.any(axis=1)
        outside = {values for i, values in enumerate(row.combinations) if i >= len(inside) or not inside[i]}
        if not inside.any():
            kept.append(row)
        elif outside:
            kept += [replace(row, sets=sets) for sets in boxes(outside)]
    return kept


WIDTH = 3e-5  # values closer than this are shared [rad or length scales]
SHARED = 5  # points that must share a value
GROUPS = 8  # groups of points that are tried, large ones first


def recognised(problem: Problem, q: Array, rng: np.random.Generator) -> list[Row]:
    """Rows with linear conditions only, from the values that points share.

    For families on which D vanishes more than it should: where the condition is a square, D does not see it (det J of
    the Stanford arm is q3²·sin θ2·sin θ5 up to a constant: D = 0 all over q3 = 0), and points are known to √`target`
    only. But the values that unit covectors and small whole-number covectors take do not scatter: those that many
    points share are conditions, and a direct test of the rank at these values decides.

    Args:
        problem: the arm, and the corank.
        q: (N, n) singular points that no row explains.
        rng: for the direct tests.
    """
    if len(q) < SHARED:
        return []
    n = problem.n
    moving = [int(j) for j in np.flatnonzero(~problem.idle)]
    units = np.eye(n, dtype=np.int64)[moving]
    angles = [j for j in moving if problem.robot.periodic[j]]
    covectors = np.concatenate([units, candidates(tuple(angles), n)])
    shared = np.stack([_shared(Linear.of(problem.robot, [tuple(m)]).values(q)[:, 0]) for m in covectors], axis=1)
    patterns, inverse, counts = np.unique(shared, axis=0, return_inverse=True, return_counts=True)
    rows: list[Row] = []
    for label in np.argsort(-counts, kind="stable")[:GROUPS]:
        conditions = independent(covectors[patterns[label]])
        if conditions and counts[label] >= SHARED:
            rows += _rows_of_values(problem, conditions, q[inverse.reshape(-1) == label], rng)
    return rows


def _rows_of_values(
    problem: Problem, conditions: tuple[Covector, ...], q: Array, rng: np.random.Generator
) -> list[Row]:
    linear = Linear.of(problem.robot, conditions)
    met = linear.combinations(q, np.ones(len(q)), WIDTH)
    sharp = [_solved_values(problem, linear, values, q[members]) for values, members in met.items()]
    found = grow(sharp, linear, partial(verified, problem, linear, (), 0, rng=rng))
    signature = _linear_signature(linear)
    return [Row(linear, sets, (), signature, "shared values, verified") for sets in boxes(found)]


def _solved_values(problem: Problem, linear: Linear, values: Values, q: Array) -> Values:
    """The values that are not simple, right to rounding: solved for with the simple ones put at their places.

    Where D is not zero but of too low a rank, σ is of first order in some combination of the errors.
    """
    vague = [i for i, v in enumerate(values) if linear.periodic[i] and abs(v / SIMPLE - round(v / SIMPLE)) > 1e-12]
    if not vague:
        return values
    rng = np.random.default_rng(0)
    at = linear.place(q[:16].copy(), np.repeat(np.array([values]), len(q[:16]), axis=0), rng)
    pivots = [linear.pivots[i] for i in range(len(linear))]
    moves = np.zeros((problem.n, len(vague)))  # what one value drags along
    moves[pivots] = np.linalg.inv(linear.covectors[:, pivots].astype(np.float64))[:, vague]
    for _ in range(4):
        local = problem.block(at)
        f = np.asarray(local.f).reshape(-1)
        slope = np.asarray(local.d).reshape(len(f), problem.n) @ moves
        at = at - np.linalg.lstsq(slope, f, rcond=1e-6)[0] @ moves.T
    sharp = linear.values(at[:1])[0]
    return tuple(canonical(float(sharp[i])) if i in vague else v for i, v in enumerate(values))


def _linear_signature(linear: Linear) -> Signature:
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


VALUES = 12  # values of a pinned joint that are listed at most
SMALL = 0.5  # a group with less than this share of another's points is small beside it
Joints = tuple[int, ...]
Shape = tuple[bool, int, Joints, Joints, Joints]
"""Regular or not; rank of D; joints pinned, free, coupled."""


def leftovers(
    problem: Problem, cloud: Inspection, left_cloud: Mask, fresh: Inspection, left_fresh: Mask
) -> list[tuple[Family, int]]:
    """Families without a name: the points of exactly this corank that are left, grouped by the shape of their tangent.

    Args:
        problem: the arm, and the corank.
        cloud, fresh: the two clouds.
        left_cloud, left_fresh: (N,) points that no row explains.

    Returns:
        The families, that of most points first, and how many points of the cloud each has. The dimension is n − rank D,
        an upper bound where the points are irregular; the witness is the point farthest from a higher corank.
    """
    q = np.concatenate([cloud.q[left_cloud & cloud.exact], fresh.q[left_fresh & fresh.exact]])
    from_cloud = int((left_cloud & cloud.exact).sum())
    if not len(q):
        return []
    inspection = inspect(problem, q)
    groups: dict[Shape, list[int]] = {}
    for i, signature in enumerate(inspection.signatures):
        key = (
            (True, signature.rank, signature.pinned, signature.free, signature.coupled)
            if signature is not None
            else _shape(inspection, i, problem)
        )
        groups.setdefault(key, []).append(i)
    ordered = sorted(_gathered(groups).items(), key=lambda item: (-len(item[1]), item[1][0]))
    tested = int(fresh.exact.sum())
    return [_unnamed(problem, inspection, key, np.array(members), from_cloud, tested) for key, members in ordered]


def _gathered(groups: dict[Shape, list[int]]) -> dict[Shape, list[int]]:
    """Put groups with the same pinned joints together where one is small beside the other.

    Near a degenerate geometry (offsets of a fraction of a millimetre) tangents of one set come in many shapes. What is
    coupled in one of them is coupled; the larger dimension is the bound.
    """
    joined: dict[Shape, list[int]] = {}
    for shape, members in sorted(groups.items(), key=lambda item: (-len(item[1]), item[0])):
        home = next((s for s in joined if s[2] == shape[2] and len(members) < SMALL * len(joined[s])), None)
        if home is None:
            joined[shape] = list(members)
            continue
        everyone = sorted(joined.pop(home) + members)
        coupled = tuple(sorted({*home[4], *shape[4]}))
        free = tuple(j for j in home[3] if j not in coupled)
        joined[(home[0] and shape[0], min(home[1], shape[1]), home[2], free, coupled)] = everyone
    return joined


def _shape(inspection: Inspection, i: int, problem: Problem) -> Shape:
    """Irregular points are told apart by the dimension of ker D alone; joints that never matter are free."""
    dimension = round(float(np.trace(inspection.tangent[i])))
    n = problem.n
    free = tuple(int(j) for j in np.flatnonzero(problem.idle))
    return (False, n - dimension, (), free, tuple(j for j in range(n) if j not in free))


def _unnamed(
    problem: Problem,
    inspection: Inspection,
    key: Shape,
    members: NDArray[np.int64],
    from_cloud: int,
    tested: int,
) -> tuple[Family, int]:
    regular, rank, pinned, free, coupled = key
    q, cloud = inspection.q[members], int((members < from_cloud).sum())
    gap = inspection.sigma[members, problem.rank - 1] if problem.rank else np.ones(len(members))
    at = q[int(np.argmax(gap))]
    directions, sentences = lost_motions(problem, at, q)
    kind = "" if regular else "; D has no clear rank there, so that the dimension is an upper bound"
    names = problem.robot.variables
    family = Family(
        id="",
        name="unnamed family",
        corank=problem.corank,
        dimension=problem.n - rank,
        pinned=tuple(Pin(names[j].name, j + 1, _values(problem, q, j)) for j in pinned),
        free=tuple(j + 1 for j in free),
        coupled=tuple(j + 1 for j in coupled),
        equations=(),
        witness=tuple(float(x) for x in at),
        lost_directions=directions,
        lost_words=sentences,
        evidence=Sampled(
            f"{cloud} points of the cloud and {len(members) - cloud} fresh ones, no condition found{kind}",
            Check(0, 0),
            Check(tested, len(members) - cloud),
        ),
        named=False,
    )
    return family, cloud


def _values(problem: Problem, q: Array, joint: int) -> tuple[float, ...]:
    """Different values of a joint over points, at most twelve."""
    linear = Linear.of(problem.robot, [tuple(int(i == joint) for i in range(problem.n))])
    found = linear.combinations(q, np.ones(len(q)), 1e-5)
    return tuple(sorted(values[0] for values in found)[:VALUES])
