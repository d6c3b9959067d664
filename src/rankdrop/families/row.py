"""A row under construction: linear conditions with their value sets, and the residual equations of coupled joints.

A readable configuration on a family: zeros where nothing depends on a joint, round numbers elsewhere.

What else solves a row's equations are parts of lower dimension, which no random start finds. Equations of coupled
joints may all vanish where some joints stand at special values: A·cos θ4 + B·sin θ6 with A and B long, say, at θ4 =
±π/2, θ6 = 0, whatever the others do. Newton's method from random starts ends on the family itself, almost surely. So
some joints are held at right angles, or where other rows stand, and the equations are solved in the others. A solution
there that is not singular belongs to no family: the row is not sound, though random starts say so. Such a part may
also be where all equations together lead from random starts, though the first few of them lead to the family.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, product
from math import pi

import numpy as np

from rankdrop.families.genuine import ROUNDING, descents
from rankdrop.families.linear import Linear, Values, canonical
from rankdrop.families.signature import HIGHER, Signature
from rankdrop.family.equation import Equation, Mask, System, normalised
from rankdrop.family.record import Check, Family
from rankdrop.problem import Problem, into_limits, wrap, wrapped
from rankdrop.robot.model import Array

CONDITIONED = 1e-3  # solutions where the equations' Jacobian has a smaller singular value are too inexact to judge σ
FLAT = 1e-7  # where no slope reaches `CONDITIONED` but one exceeds this, slopes are measured by the largest
FURTHER = 1e-11  # |f| of the equations beyond the independent ones at a solution
STARTS = 400  # random starts of a soundness test


@dataclass(frozen=True, eq=False)
class Row:
    """Conditions of one family.

    Attributes:
        linear: covectors; empty for a family without pinned joints or relations.
        sets: per covector the values it takes; every combination belongs to the row.
        residual: equations that bind the coupled joints.
        signature: joints pinned, free and coupled, and the codimension (`signature.rank`).
        evidence: how the conditions were obtained.
        family: the derived family whose conditions these are; None where they were fitted.
    """

    linear: Linear
    sets: tuple[Values, ...]
    residual: tuple[Equation, ...]
    signature: Signature
    evidence: str
    family: Family | None = None

    @cached_property
    def system(self) -> System:
        """All equations."""
        return System(self.linear.equations(self.sets) + self.residual)

    @property
    def combinations(self) -> list[Values]:
        """Every combination of values."""
        return list(product(*self.sets))

    def sample(self, problem: Problem, each: int, rng: np.random.Generator) -> tuple[Array, Mask]:
        """(V, each, n) points on up to 64 combinations, and (V, each) whether they are good: `on_combinations`."""
        need = self.signature.residual
        return on_combinations(problem, self.linear, self.residual, need, self.combinations[:64], each, rng)


def on_combinations(
    problem: Problem,
    linear: Linear,
    residual: tuple[Equation, ...],
    codimension: int,
    values: list[Values],
    each: int,
    rng: np.random.Generator,
) -> tuple[Array, Mask]:
    """Configurations that take the given values exactly and solve the residual equations.

    Args:
        problem, linear, residual: the arm and the conditions.
        codimension: number of independent residual equations (there may be more equations than that).
        values: combinations of values.
        each: random starts for each of them.
        rng: of the starts.

    Returns:
        (V, each, n) configurations and (V, each) whether they solve the equations at a well-conditioned place.
    """
    n = problem.n
    targets = np.repeat(np.array(values, dtype=np.float64).reshape(len(values), -1), each, axis=0)
    q = linear.place(problem.random(len(targets), rng), targets, rng)
    good = np.ones(len(q), dtype=np.bool_)
    if residual:
        q, slope, good = _solved(q, residual, codimension, linear.along)
        good &= slope > _least_slope(slope[good])
    good &= problem.allowed(q)
    return q.reshape(len(values), each, n), good.reshape(len(values), each)


def _solved(
    q: Array, equations: tuple[Equation, ...], codimension: int, along: Array
) -> tuple[Array, Array, Mask]:
    """Solve the first equations, as many as are independent, and keep the solutions that satisfy the rest as well.

    Gauss–Newton on more equations than unknowns would stay in places where no residual gets smaller. Where the first
    equations lead to solutions of no others, all of them are solved together.

    Returns:
        (N, n) end points, (N,) smallest singular value of the solved equations' Jacobian, (N,) whether all hold.
    """
    base, start = System(equations[:codimension]), q
    q, good = base.solve(q, along=along, iterations=60)
    if len(equations) > codimension:
        further, whole = System(equations[codimension:]), System(equations)
        good &= (np.abs(further.values(q)) <= FURTHER).all(axis=1) & further.zero(q)
        if not good.any():
            q, good = whole.solve(start, along=along, iterations=60)
            good &= whole.zero(q)
        slopes = np.linalg.svd(whole.jacobian(q) @ along, compute_uv=False)
        return q, np.asarray(slopes[:, min(codimension, slopes.shape[1]) - 1]), good
    slope = np.asarray(np.linalg.svd(base.jacobian(q) @ along, compute_uv=False)[:, -1], dtype=np.float64)
    return q, slope, good


def _least_slope(slope: Array) -> float:
    """Slope below which a solution is known too inexactly: of equations that are flat everywhere a share of theirs."""
    best = float(slope.max(initial=0.0))
    return CONDITIONED * (best if FLAT < best < CONDITIONED else 1.0)


def verified(
    problem: Problem,
    linear: Linear,
    residual: tuple[Equation, ...],
    codimension: int,
    values: list[Values],
    rng: np.random.Generator,
) -> list[bool]:
    """Which combinations of values belong to the family: tested directly, by σ at random values of all other joints.

    A combination holds when every tested configuration has corank ≥ k and most have exactly k (else it belongs to the
    table of a higher corank).
    """
    each = 24 if residual or problem.limits else 8
    result = _tested(problem, linear, residual, codimension, values, each, rng)
    unsure = [i for i, one in enumerate(result) if one is None]
    if unsure:  # limits leave little room: look harder
        again = _tested(problem, linear, residual, codimension, [values[i] for i in unsure], 20 * each, rng)
        for i, one in zip(unsure, again, strict=True):
            result[i] = one
    return [one is True for one in result]


def _tested(
    problem: Problem,
    linear: Linear,
    residual: tuple[Equation, ...],
    codimension: int,
    values: list[Values],
    each: int,
    rng: np.random.Generator,
) -> list[bool | None]:
    """`verified` with a number of starts; None where fewer than three of them could be used."""
    q, good = on_combinations(problem, linear, residual, codimension, values, each, rng)
    sigma = problem.sigma(q)
    singular = sigma[..., problem.rank] <= problem.tolerances.singular
    exact = sigma[..., problem.rank - 1] > HIGHER if problem.rank else np.ones_like(singular)
    count = good.sum(axis=1)
    holds = (singular | ~good).all(axis=1) & ((exact & good).sum(axis=1) > 0.5 * count)
    return [bool(ok) if used >= 3 else None for ok, used in zip(holds, count, strict=True)]


def soundness(
    problem: Problem, system: System, codimension: int, rng: np.random.Generator, *, exact: bool = False
) -> tuple[Check, Array]:
    """Solve equations from random starts and look at the rank there.

    Solutions where the equations' Jacobian is badly conditioned (sheets crossing) are known too inexactly to be judged
    and are left out; of exact equations also those with a σ that such an error explains.

    Returns:
        The counts, and the (S, n) solutions that do not have the corank.
    """
    start = problem.random(STARTS, rng)
    q, slope, solved = _solved(start, system.equations, codimension, np.eye(problem.n))
    q = q[solved & (slope > _least_slope(slope[solved]))]
    if not len(q):
        return Check(0, 0), q
    sigma = problem.sigma(q)[:, problem.rank]
    singular = sigma <= problem.tolerances.singular
    regular = (sigma > HIGHER) & system.zero(q) if exact else ~singular
    return Check(int((singular | regular).sum()), int(singular.sum())), q[regular]


MOST_VALUES = 8  # values at which a joint still counts as pinned
SAME_VALUE = 1e-8  # values closer than this are one [rad, m]; micrometres of an offset move values by 1e-6
SAMPLED = 64  # solutions from which the values of a family's joints are read


def row_of(problem: Problem, family: Family) -> Row:
    """The conditions of a derived family as a row, of pinned joints the values within the limits alone.

    Args:
        problem: the arm in its own unit of length, and the corank.
        family: of this arm.
    """
    row = _pinned_row(replace(problem, limits=False), family)
    if not problem.limits:
        return row
    sets = []
    for joint, values in zip(row.signature.pinned, row.sets, strict=True):
        q = np.tile(np.mean(problem.box, axis=0), (len(values), 1))
        q[:, joint] = values
        sets.append(tuple(v for v, inside in zip(values, problem.allowed(q), strict=True) if inside) or values)
    return replace(row, sets=tuple(sets))


def stated_row(problem: Problem, family: Family) -> Row:
    """The conditions of a derived family as they are stated: joints that they pin in effect are not taken out."""
    return _row(problem, family, {one.number - 1: one.values for one in family.pinned})


def _pinned_row(problem: Problem, family: Family) -> Row:
    """`row_of` without limits.

    Joints that take only a few values on the family are pinned there, whatever equations say so: θ3 = 0.4 or −1.9. They
    stay coupled where not every combination of the values belongs to the family.
    """
    exact = {one.number - 1: one.values for one in family.pinned}
    row = stated_row(problem, family)
    if not row.residual:
        return row
    each = max(SAMPLED // len(row.combinations), 2)
    q, good = row.sample(problem, each, np.random.default_rng(0))
    points = q[good]
    if not len(points):
        return row
    slopes = np.linalg.svd(row.system.jacobian(points), compute_uv=False)
    slope = np.asarray(slopes[:, min(row.signature.rank, slopes.shape[1]) - 1], dtype=np.float64)
    pins = dict(exact)
    for joint in row.signature.coupled:
        alone = Linear.of(problem.robot, [tuple(int(i == joint) for i in range(problem.n))])
        values = alone.combinations(points, slope, SAME_VALUE)
        if len(values) <= min(MOST_VALUES, len(points) // 4):
            pins[joint] = tuple(
                sorted(_sharpened(problem, joint, value, points[met[0]]) for (value,), met in values.items())
            )
    pinned = _row(problem, family, pins)
    taken = pinned.linear.combinations(points, slope, SAME_VALUE)
    return pinned if len(taken) == len(pinned.combinations) else row


def _sharpened(problem: Problem, joint: int, value: float, q: Array) -> float:
    """The value of a joint at a configuration (n,) of a family, from the arm itself with 50 digits.

    Where the conditions are all but flat, 1e-16 in their coefficients moves their solutions by 1e-10.
    """
    end, sigma = min(descents(problem, q), key=lambda one: one[1])
    sharp = canonical(end[joint]) if problem.robot.periodic[joint] else round(float(end[joint]), 13) + 0.0
    off = abs(float(wrap(np.array(sharp - value)))) if problem.robot.periodic[joint] else abs(sharp - value)
    return sharp if sigma <= ROUNDING and off <= SAME_VALUE else value


def _row(problem: Problem, family: Family, pins: Mapping[int, Values]) -> Row:
    joints = tuple(sorted(pins))
    rest = [one for one in family.equations if not {j - 1 for j in one.joints} <= set(joints)]
    coupled = tuple(sorted({j - 1 for one in rest for j in one.joints} - set(joints)))
    free = tuple(j for j in range(problem.n) if j not in joints and j not in coupled)
    signature = Signature(problem.n - family.dimension, joints, free, coupled, (), ())
    linear = Linear.of(problem.robot, signature.covectors(problem.n))
    residual = tuple(normalised(one.terms) for one in rest)
    return Row(linear, tuple(pins[j] for j in joints), residual, signature, "exact condition", family)


TRIES = 64  # round configurations that are looked at
ROUND = 0.1  # free angles stand at multiples of this [rad], free lengths at multiples of a power of ten [m]


RIGHT = (0.0, pi, pi / 2, -pi / 2)
SINGLE, SEVERAL = 24, 40  # sets of one joint held, and of two or more, at most
EACH = 8  # random starts for each
LOOSE = 64  # random starts with no joint held
CERTAIN = 1e-14  # |f| at their solutions: where sheets touch, a point near all of them comes to 1e-12 and is no zero
REGULAR = 1e-2
"""σ above this is not zero, however badly the solution is known: |f| ≤ 1e-12 leaves 1e-3 rad at a fourfold zero."""


def elsewhere(
    problem: Problem,
    linear: Linear,
    combinations: Sequence[Values],
    residual: tuple[Equation, ...],
    marks: Mapping[int, Sequence[float]],
    rng: np.random.Generator,
) -> tuple[int, Array]:
    """Solve a row's equations with some of their joints held at special values.

    Args:
        problem: the arm, and the corank.
        linear, combinations, residual: the row; each start takes one combination of values by chance.
        marks: further values to hold joints (from 0) at, beside right angles: those of other rows [rad or m].
        rng: of joints, values and starts.

    Returns:
        How many solutions could be judged, and (S, n) those that are regular.
    """
    n = problem.n
    none = np.zeros((0, n))
    if not residual:
        return 0, none
    system = System(residual)
    fixed = set(linear.pivots)
    joints = [j - 1 for j in sorted({j for f in residual for j in f.joints}) if j - 1 not in fixed]
    begun: dict[tuple[int, ...], list[Array]] = {}
    values = np.array(combinations, dtype=np.float64).reshape(len(combinations), -1)
    for held in _held(problem, joints, marks, rng):
        numbers = list(held)
        chosen = rng.integers(len(combinations), size=EACH)
        q = problem.random(EACH, rng)
        q[:, numbers] = list(held.values())
        begun.setdefault(tuple(sorted(held)), []).append(linear.place(q, values[chosen], rng))
    loose = problem.random(LOOSE, np.random.default_rng(0))  # nothing held: a place that draws all equations at once
    begun[()] = [linear.place(loose, values[np.arange(LOOSE) % len(combinations)], np.random.default_rng(0))]
    ends, solved = [none], [np.zeros(0, dtype=np.bool_)]
    for same, starts in begun.items():  # all starts that hold the same joints at once
        along = _free(linear, list(same), n)
        if not along.shape[1]:
            continue
        q, good = system.solve(np.concatenate(starts), along=along, iterations=60)
        if not same:  # counted only where they speak against the row: random starts have spoken for it
            good &= (np.abs(system.values(q)) <= CERTAIN).all(axis=1) & (problem.sigma(q)[:, problem.rank] > REGULAR)
        ends.append(q)
        solved.append(good)
    q = np.concatenate(ends)
    q = q[np.concatenate(solved) & problem.allowed(q)]
    sigma = problem.sigma(q)[:, problem.rank]
    regular = sigma > REGULAR
    return int((regular | (sigma <= problem.tolerances.singular)).sum()), q[regular]


def _held(
    problem: Problem, joints: list[int], marks: Mapping[int, Sequence[float]], rng: np.random.Generator
) -> list[dict[int, float]]:
    """Joints and the values they are held at: each alone, then several by chance."""
    periodic = problem.robot.periodic
    values = {j: list(dict.fromkeys([*(RIGHT if periodic[j] else (0.0,)), *marks.get(j, ())])) for j in joints}
    single = [{j: v} for j in joints for v in values[j]]
    if len(single) > SINGLE:
        single = [single[i] for i in rng.choice(len(single), SINGLE, replace=False)]
    several = []
    for _ in range(SEVERAL if len(joints) > 1 else 0):
        some = rng.choice(joints, size=int(rng.integers(2, len(joints) + 1)), replace=False)
        several.append({int(j): values[int(j)][int(rng.integers(len(values[int(j)])))] for j in some})
    return single + several


def _free(linear: Linear, held: list[int], n: int) -> Array:
    """(n, d) orthonormal basis of the motions that keep the linear values and the joints held."""
    rows = np.concatenate([linear.covectors.astype(np.float64).reshape(-1, n), np.eye(n)[held]])
    _, sigma, vt = np.linalg.svd(rows)
    return np.asarray(vt[int((sigma > sigma.max(initial=0.0) * max(rows.shape) * np.finfo(np.float64).eps).sum()) :].T)


def witness(problem: Problem, row: Row, rng: np.random.Generator) -> Array | None:
    """(n,) a point of the row of corank exactly k, the next singular value as large as round numbers allow.

    Joints on which σ does not depend are 0, free ones at round numbers, pinned ones at the first of their values,
    and only as many coupled ones as there are residual equations are solved for. None when no try succeeds.
    """
    values = np.array([[one[0] for one in row.sets]] * TRIES).reshape(TRIES, -1)
    placed = row.linear.place(_round(problem, rng), values, rng)
    best: tuple[float, Array | None] = (0.0, None)
    for along in _ways(row) if row.residual else [np.zeros((problem.n, 0))]:
        q, good = placed, np.ones(TRIES, dtype=np.bool_)
        if row.residual:
            q, good = System(row.residual).solve(placed, along=along)
        q = _near_zero(problem, q)
        good = good & problem.allowed(q)
        sigma = problem.sigma(q)
        good &= sigma[:, problem.rank] <= problem.tolerances.singular
        gap = np.where(good, sigma[:, problem.rank - 1] if problem.rank else 1.0, 0.0)
        i = int(np.argmax(gap))
        if gap[i] > max(1e-6, 1.2 * best[0]):
            best = (float(gap[i]), q[i])
    return best[1]


def _round(problem: Problem, rng: np.random.Generator) -> Array:
    """(TRIES, n) random configurations of round numbers."""
    low, high = problem.box
    periodic = problem.robot.periodic
    reach = np.where(periodic, 1.5, 0.5 * (high - low))
    middle = np.where(problem.limits | ~periodic, 0.5 * (low + high), 0.0)
    half = 0.5 * np.maximum(high - low, 1e-9)
    scale = np.where(periodic, ROUND, 10.0 ** np.floor(np.log10(0.4 * half)))
    q = middle + rng.uniform(-1, 1, (TRIES, problem.n)) * np.minimum(reach, half)
    q = np.round(q / scale) * scale
    q = np.where((q < low) | (q > high), middle, q)
    resting = problem.idle & (low <= 0) & (high >= 0)
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


def _near_zero(problem: Problem, q: Array) -> Array:
    """Angles in (−π, π], or between the limits where they are set; rounding around zero taken off."""
    q = into_limits(problem.robot, q) if problem.limits else wrapped(problem.robot, q)
    return np.where(np.abs(q) < 1e-15, 0.0, q)
