"""A row under construction: the values that pinned joints and relations take, and the equations of coupled joints.

Linear conditions are m·q = c, for pinned joints and whole-number relations, and the values c they take. A set of values
has an equation, too: what the pinned joint, or the relation, satisfies.

What else solves a row's equations are parts of lower dimension, which no random start finds. Equations of coupled
joints may all vanish where some joints stand at special values: A·cos θ4 + B·sin θ6 with A and B long, say, at θ4 =
±π/2, θ6 = 0, whatever the others do. Newton's method from random starts ends on the family itself, almost surely. So
some joints are held at right angles, or where other rows stand, and the equations are solved in the others. A solution
there that is not singular belongs to no family: the row is not sound, though random starts say so. Such a part may
also be where all equations together lead from random starts, though the first few of them lead to the family.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from itertools import combinations, product
from math import pi

import numpy as np
from numpy.typing import NDArray

from rankdrop.errors import OptionError
from rankdrop.families.descent import ROUNDING, descents
from rankdrop.families.evidence import FamilyEvidence, ObtainedFrom
from rankdrop.families.incidence import ways_to
from rankdrop.families.inspection import HIGHER, Covector, Signature
from rankdrop.families.record import Check, Family
from rankdrop.formula.equation import Equation, Mask, System, Term, normalised_equation
from rankdrop.lists import flat_map
from rankdrop.problem import Problem, wrap
from rankdrop.robot.model import Array, Robot

CONDITIONED = 1e-3  # solutions where the equations' Jacobian has a smaller singular value are too inexact to judge σ
FLAT = 1e-7  # where no slope reaches `CONDITIONED` but one exceeds this, slopes are measured by the largest
ROUNDED = 10.0  # times `target`: σ below this tells nothing
NEAR = 1e-3  # longest way from a point to a row that is walked [rad]
FURTHER = 1e-11  # |f| of the equations beyond the independent ones at a solution
STARTS = 400  # random starts of a soundness test

SIMPLE = pi / 12  # values are taken for a multiple of this where they agree with one
Values = tuple[float, ...]
VALUE_ERROR = 1e-10  # rad: so far 1e-16 in the coefficients of all but flat conditions moves their solutions

MOST_VALUES = 8  # values at which a joint still counts as pinned
SAME_VALUE = 1e-8  # values closer than this are one [rad, m]; micrometres of an offset move values by 1e-6
SAMPLED = 64  # solutions from which the values of a family's joints are read

RIGHT = (0.0, pi, pi / 2, -pi / 2)
SINGLE, SEVERAL = 24, 40  # sets of one joint held, and of two or more, at most
EACH = 8  # random starts for each
LOOSE = 64  # random starts with no joint held
CERTAIN = 1e-14  # |f| at their solutions: where sheets touch, a point near all of them comes to 1e-12 and is no zero
REGULAR = 1e-2
"""σ above this is not zero, however badly the solution is known: |f| ≤ 1e-12 leaves 1e-3 rad at a fourfold zero."""


def _product_of_differences(covector: Sequence[int], values: Sequence[float]) -> Equation:
    """Π (u − v) over the values v of a joint that slides, written as a sum; u = covector·q."""
    n, count = len(covector), len(values)
    j = next(i for i, m in enumerate(covector) if m)
    coefficients = np.poly(np.asarray(values, dtype=np.float64) * covector[j])
    terms = []
    for k, coefficient in enumerate(coefficients):
        if coefficient:
            powers = [0] * n
            powers[j] = count - k
            terms.append(Term(float(coefficient), "cos", (0,) * n, tuple(powers)))
    return Equation(tuple(terms))


def vanishing_on(covector: Sequence[int], values: Sequence[float], *, periodic: bool) -> Equation:
    """The simplest equation that holds exactly where covector·q takes one of `values`.

    {0, π} gives sin u, {±π/2} cos u, {v} sin((u − v)/2), {v, v + π} sin(u − v), any other set the product of the
    sin((u − v)/2) written as a sum; a joint that is not periodic gives Π (u − v).

    Args:
        covector: (n,) whole numbers; u = covector·q. One ±1 entry for a pinned joint.
        values: [rad], or [m] where not periodic.
        periodic: whether u is an angle.

    Raises:
        OptionError: no value.
    """
    count = len(values)
    if not values:
        raise OptionError("a condition needs at least one value")
    if not periodic:
        return _product_of_differences(covector, values)
    half = [int(m) for m in covector]
    if count == 1:
        return _one_wave(half, float(values[0]) / 2)
    if count == 2 and abs(np.cos(values[0] - values[1]) + 1) < 1e-15:  # half a turn apart
        inner = values[0] if -pi / 2 < values[0] < pi / 2 else values[1]
        return _one_wave([2 * m for m in half], float(inner))
    return _product_of_sines(half, values)


def _one_wave(harmonics: Sequence[int], phase: float) -> Equation:
    """sin(u − phase), simplified where the phase is 0, π or ±π/2; harmonics in half angles."""
    zero, multiples = (0,) * len(harmonics), tuple(harmonics)
    if abs(np.cos(phase)) < 1e-15:
        return Equation((Term(1.0, "cos", multiples, zero),))
    if abs(np.sin(phase)) < 1e-15:
        return Equation((Term(1.0, "sin", multiples, zero),))
    return Equation((Term(1.0, "sin", multiples, zero, phase),))


def _product_of_sines(half: Sequence[int], values: Sequence[float]) -> Equation:
    """Π sin((u − v)/2) over N values is z^(−N/2)·Π(z − e^{iv}) up to a constant, z = e^{iu}: read off its harmonics."""
    zero, count = (0,) * len(half), len(values)
    waves = np.poly(np.exp(1j * np.asarray(values)))  # of z^count … z^0
    waves = waves * np.exp(-0.5j * (np.angle(waves[-1])))  # makes it c_k = conj(c_{count−k})
    terms = []
    for k in range(count // 2 + 1):
        order = count - 2 * k  # twice the harmonic
        c = waves[k] * (1.0 if order == 0 else 2.0)
        harmonics = tuple(order * m for m in half)
        terms.append(Term(float(c.real), "cos", harmonics, zero))
        if order:
            terms.append(Term(float(-c.imag), "sin", harmonics, zero))
    return normalised_equation(terms, threshold=1e-13)


@dataclass(frozen=True, eq=False)
class Linear:
    """Covectors m_1 … m_c, of which a family fixes the values m_i·q.

    Attributes:
        covectors: (c, n) whole numbers, independent.
        periodic: (c,) whether the value is an angle.
    """

    covectors: NDArray[np.int64]
    periodic: Mask

    @classmethod
    def of(cls, robot: Robot, covectors: Iterable[Covector]) -> Linear:
        """The linear conditions for an arm; an angle is what only periodic joints enter."""
        rows = np.array(list(covectors), dtype=np.int64).reshape(-1, robot.n)
        turning = robot.periodic
        return cls(rows, np.array([bool(turning[row != 0].all()) for row in rows], dtype=np.bool_))

    def __len__(self) -> int:
        return len(self.covectors)

    @cached_property
    def pivots(self) -> tuple[int, ...]:
        """Joints (from 0) that are solved for: the last ones whose minor is ±1, or as small as it gets."""
        best: tuple[float, tuple[int, ...]] = (np.inf, ())
        columns = [j for j in range(self.covectors.shape[1]) if self.covectors[:, j].any()]
        for choice in combinations(reversed(columns), len(self)):
            minor = abs(float(np.linalg.det(self.covectors[:, choice])))
            if 0.5 < minor < best[0] - 0.5:
                best = (minor, choice)
            if minor and best[0] < 1.5:
                break
        return tuple(best[1])

    @cached_property
    def kept_motions(self) -> Array:
        """(n, n − c) orthonormal basis of the motions that keep all values."""
        if not len(self):
            return np.eye(self.covectors.shape[1])
        return np.asarray(np.linalg.svd(self.covectors.astype(np.float64))[2][len(self) :].T)

    def values(self, q: Array) -> Array:
        """(N, c) values at q (N, n), angles in (−π, π]."""
        return self.deviation(q, np.zeros(len(self)))

    def deviation(self, q: Array, values: Array) -> Array:
        """(N, c) how far the values at q (N, n) are from others (c,) or (N, c), angles the short way round."""
        off = q @ self.covectors.T - values
        return np.where(self.periodic, wrap(off), off)

    def place(self, q: Array, values: Array, rng: np.random.Generator) -> Array:
        """Move the pivot joints of q (N, n) so that the covectors take `values` (N, c), on a branch by chance."""
        if not len(self):
            return q
        pivots = list(self.pivots)
        square = self.covectors[:, pivots].astype(np.float64)
        turns = round(abs(float(np.linalg.det(square))))  # how many branches the pivots have
        branch = rng.integers(0, max(turns, 1), size=values.shape) * 2 * pi * self.periodic
        rest = q.copy()
        rest[:, pivots] = 0.0
        placed = q.copy()
        placed[:, pivots] = np.linalg.solve(square, (values + branch - rest @ self.covectors.T).T).T
        return placed

    def equations(self, sets: Iterable[Values]) -> tuple[Equation, ...]:
        """One equation per covector, for the set of values it takes."""
        return tuple(
            vanishing_on([int(m) for m in row], values, periodic=bool(periodic))
            for row, values, periodic in zip(self.covectors, sets, self.periodic, strict=True)
        )

    def combinations(self, q: Array, weights: Array, tolerance: float) -> dict[Values, NDArray[np.int64]]:
        """The value combinations that points take, simple values exact, each with its points.

        Args:
            q: (N, n) points.
            weights: (N,) the larger, the better the point is known.
            tolerance: values closer than this are one.
        """
        pairs = zip(self.values(q).T, self.periodic.tolist(), strict=True)
        columns = [_snap_to_known_values(column, weights, tolerance, periodic=turns) for column, turns in pairs]
        points_of_values: dict[Values, list[int]] = {}
        for point, values in enumerate(np.reshape(columns, (len(self), len(q))).T.tolist()):
            points_of_values.setdefault(tuple(values), []).append(point)
        return {key: np.array(members) for key, members in points_of_values.items()}

    def neighbours(self, values: Values) -> list[Values]:
        """Combinations with one angle exchanged for v + π or −v: where symmetry puts further pieces."""
        result = []
        for i in range(len(self)):
            for other in (values[i] + pi, -values[i], pi - values[i]) if self.periodic[i] else ():
                v = canonical(other)
                if v != values[i]:
                    result.append((*values[:i], v, *values[i + 1 :]))
        return result


def canonical(angle: float, tolerance: float = 1e-12) -> float:
    """The angle in (−π, π], multiples of π/12 exact, other values rounded to 1e-13 so that equal ones compare equal.

    Args:
        angle: in rad.
        tolerance: an angle closer to a multiple of π/12 is that multiple [rad]; −π + 2e-12 and π − 2e-12 are one angle.
    """
    angle = float(wrap(np.array(angle)))
    whole = round(angle / SIMPLE)
    if abs(angle - whole * SIMPLE) < tolerance:
        if whole == -12:
            return pi
        return whole * SIMPLE
    return round(angle, 13)


def clusters(values: Array, width: float, *, periodic: bool) -> NDArray[np.int64]:
    """(N,) numbers of groups of values that lie closer together than `width`, −π and π being one value."""
    order = np.argsort(values, kind="stable")
    labels = np.empty(len(values), dtype=np.int64)
    labels[order] = np.concatenate([[0], np.cumsum(np.diff(values[order]) > width)])
    if periodic and values[order[0]] + 2 * pi - values[order[-1]] <= width:
        labels[labels == labels[order[-1]]] = 0
    return labels


def _snap_to_known_values(values: Array, weights: Array, tolerance: float, *, periodic: bool) -> Array:
    """Each value replaced by the best-known one of its cluster, or the multiple of π/12 there."""
    labels, result = clusters(values, tolerance, periodic=periodic), np.empty_like(values)
    for label in np.unique(labels):
        members = np.flatnonzero(labels == label)
        value = float(values[members[np.argmax(weights[members])]])
        if periodic:
            whole = round(value / SIMPLE) * SIMPLE
            value = canonical(whole if abs(value - whole) <= tolerance else value)
        if not periodic and abs(value) <= tolerance:
            result[members] = 0.0
        else:
            result[members] = value
    return result


def grow(
    start: Iterable[Values], linear: Linear, holds: Callable[[list[Values]], list[bool]], most: int = 1024
) -> set[Values]:
    """All combinations that hold, from those observed outwards by symmetry.

    Args:
        start: observed combinations.
        linear: gives the neighbours.
        holds: tests a batch of combinations directly, by their rank.
        most: tested combinations at most.
    """
    known: dict[tuple[int, float], float] = {}

    def same(values: Values) -> Values:
        """Values that agree to 1e-9 become one, so that rounding makes no new combinations."""
        return tuple(known.setdefault((i, round(v, 9) + 0.0), v) for i, v in enumerate(values))

    tested: set[Values] = set()
    holding: set[Values] = set()
    front = list(dict.fromkeys(same(values) for values in start))
    while front and len(tested) < most:
        tested.update(front)
        good = [values for values, ok in zip(front, holds(front), strict=True) if ok]
        holding.update(good)
        near = dict.fromkeys(same(n) for values in good for n in linear.neighbours(values))
        front = [values for values in near if values not in tested][: max(0, most - len(tested))]
    return holding


def boxes(holding: set[Values]) -> list[tuple[Values, ...]]:
    """Cover a set of combinations by full products, large ones first: each product is one row of the table."""
    left = set(holding)
    result = []
    while left:
        seed = min(left, key=lambda values: (sum(abs(v) for v in values), values))
        sets = _grown(seed, left, holding)
        left -= set(product(*sets))
        result.append(tuple(tuple(sorted(values, key=_zero_first)) for values in sets))
    return result


def _grown(seed: Values, left: set[Values], holding: set[Values]) -> list[list[float]]:
    """Per covector the values of a product that contains one combination, and is as large as `holding` allows.

    Covectors with many values in `left` come first.
    """
    sets = [[v] for v in seed]
    for i in sorted(range(len(seed)), key=lambda i: -len({v[i] for v in left})):
        for v in sorted({values[i] for values in left} - set(sets[i]), key=_zero_first):
            slab = product(*sets[:i], [v], *sets[i + 1 :])  # what the product grows by
            if all(values in holding for values in slab):
                sets[i].append(v)
    return sets


def _zero_first(value: float) -> tuple[float, float]:
    """Order of values: small ones first, of v and −v the positive one."""
    return abs(value), -value


@dataclass(frozen=True, eq=False)
class Row:
    """Conditions of one family.

    Attributes:
        linear: covectors; empty for a family without pinned joints or relations.
        sets: per covector the values it takes; every combination belongs to the row.
        residual: equations that bind the coupled joints; there may be more than are independent.
        signature: joints pinned, free and coupled, and the codimension (`signature.rank`).
        evidence: how the conditions were obtained.
        family: the derived family whose conditions these are; None where they were fitted.
    """

    linear: Linear
    sets: tuple[Values, ...]
    residual: tuple[Equation, ...]
    signature: Signature
    evidence: FamilyEvidence
    family: Family | None = None

    @cached_property
    def system(self) -> System:
        """All equations."""
        return System(self.linear.equations(self.sets) + self.residual)

    @property
    def combinations(self) -> list[Values]:
        """Every combination of values."""
        return list(product(*self.sets))

    def nearest_values(self, q: Array) -> tuple[NDArray[np.int64], Array]:
        """(N, c) which of its values each covector is nearest to at q (N, n), and how far from it [rad or m]."""
        labels, far = np.zeros((len(q), len(self.linear)), dtype=np.int64), np.zeros((len(q), len(self.linear)))
        values = self.linear.values(q)
        for i, options in enumerate(self.sets):
            off = values[:, i : i + 1] - np.array(options)
            off = np.abs(wrap(off) if self.linear.periodic[i] else off)
            labels[:, i], far[:, i] = off.argmin(axis=1), off.min(axis=1)
        return labels, far

    def solve(
        self, problem: Problem, values: list[Values], each: int, rng: np.random.Generator
    ) -> tuple[Array, Mask]:
        """Configurations that take combinations of values exactly and solve the residual equations.

        Args:
            problem: the arm.
            values: combinations of values, of this row or others.
            each: random starts for each of them.
            rng: of the starts.

        Returns:
            (V, each, n) configurations and (V, each) whether they solve the equations at a well-conditioned place.
        """
        targets = np.repeat(np.array(values, dtype=np.float64).reshape(len(values), -1), each, axis=0)
        q = self.linear.place(problem.random(len(targets), rng), targets, rng)
        good = np.ones(len(q), dtype=np.bool_)
        if self.residual:
            q, slope, good = _solve_equations(q, self.residual, self.signature.residual, self.linear.kept_motions)
            good &= slope > _least_slope(slope[good])
        good &= problem.within_limits(q)
        return q.reshape(len(values), each, problem.n), good.reshape(len(values), each)

    def sample(self, problem: Problem, each: int, rng: np.random.Generator) -> tuple[Array, Mask]:
        """(V, each, n) points on up to 64 combinations, and (V, each) whether they are good: `solve`."""
        return self.solve(problem, self.combinations[:64], each, rng)


def _solve_equations(
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


def complete_rows(problem: Problem, row: Row, start: Iterable[Values], rng: np.random.Generator) -> list[Row]:
    """Rows with all combinations of values that hold, from those observed outwards by symmetry."""
    combinations = grow(start, row.linear, partial(verify_values, problem, row, rng=rng))
    return [replace(row, sets=sets) for sets in boxes(combinations)]


def verify_values(problem: Problem, row: Row, values: list[Values], rng: np.random.Generator) -> list[bool]:
    """Which combinations of values belong to the family: tested directly, by σ at random values of all other joints.

    A combination holds when every tested configuration has corank ≥ k and most have exactly k (else it belongs to the
    table of a higher corank).
    """
    if row.residual or problem.limits:
        each = 24
    else:
        each = 8
    result = _holding(problem, row, values, each, rng)
    unsure = [i for i, answer in enumerate(result) if answer is None]
    if unsure:  # limits leave little room: look harder
        again = _holding(problem, row, [values[i] for i in unsure], 20 * each, rng)
        for i, answer in zip(unsure, again, strict=True):
            result[i] = answer
    return [answer is True for answer in result]


def _holding(
    problem: Problem, row: Row, values: list[Values], each: int, rng: np.random.Generator
) -> list[bool | None]:
    """`verify_values` with a number of starts; None where fewer than three of them could be used."""
    q, good = row.solve(problem, values, each, rng)
    sigma = problem.sigma(q)
    singular = sigma[..., problem.rank] <= problem.tolerances.singular
    if problem.rank:
        exact = sigma[..., problem.rank - 1] > HIGHER
    else:
        exact = np.ones_like(singular)
    count = good.sum(axis=1)
    holds = (singular | ~good).all(axis=1) & ((exact & good).sum(axis=1) > 0.5 * count)
    return [bool(ok) if used >= 3 else None for ok, used in zip(holds, count, strict=True)]


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
    way = ways_to(problem, row.system, q, NEAR, ROUNDED * problem.tolerances.target)
    return np.isfinite(way) | row.system.zero(q)


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
    q, slope, solved = _solve_equations(start, system.equations, codimension, np.eye(problem.n))
    q = q[solved & (slope > _least_slope(slope[solved]))]
    if not len(q):
        return Check(0, 0), q
    sigma = problem.sigma(q)[:, problem.rank]
    singular = sigma <= problem.tolerances.singular
    if exact:
        regular = (sigma > HIGHER) & system.zero(q)
    else:
        regular = ~singular
    return Check(int((singular | regular).sum()), int(singular.sum())), q[regular]


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
        sets.append(tuple(v for v, inside in zip(values, problem.within_limits(q), strict=True) if inside) or values)
    return replace(row, sets=tuple(sets))


def stated_row(problem: Problem, family: Family) -> Row:
    """The conditions of a derived family as they are stated: joints that they pin in effect are not taken out."""
    return _row(problem, family, {pin.number - 1: pin.values for pin in family.pinned})


def _pinned_row(problem: Problem, family: Family) -> Row:
    """`row_of` without limits.

    Joints that take only a few values on the family are pinned there, whatever equations say so: θ3 = 0.4 or −1.9. They
    stay coupled where not every combination of the values belongs to the family.
    """
    exact = {pin.number - 1: pin.values for pin in family.pinned}
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
            sharp = (sharp_values(problem, alone, value, points[met[0]], SAME_VALUE) for value, met in values.items())
            pins[joint] = tuple(sorted(value for (value,) in sharp))
    pinned = _row(problem, family, pins)
    taken = pinned.linear.combinations(points, slope, SAME_VALUE)
    if len(taken) < len(pinned.combinations) or _has_further_roots(problem, row, pinned):
        return row
    return pinned


def _has_further_roots(problem: Problem, row: Row, pinned: Row) -> bool:
    """Whether singular configurations satisfy the conditions of a row away from the values that joints were found at.

    Next to a special structure a root may lie where conditions are all but flat, which `Row.sample` leaves out, or
    where their gradients are all but dependent (`System.solve_flat`).
    """
    rng = np.random.default_rng(1)
    values = row.combinations
    targets = np.repeat(np.array(values, dtype=np.float64).reshape(len(values), -1), STARTS // len(values) + 1, axis=0)
    starts = row.linear.place(problem.random(len(targets), rng), targets, rng)
    q, solved = row.system.solve_flat(starts, along=row.linear.kept_motions, iterations=200)
    q = q[solved & problem.singular(q)]
    _, far = pinned.nearest_values(q)
    return bool((far > NEAR).any())


def sharp_values(problem: Problem, linear: Linear, values: Values, q: Array, within: float) -> Values:
    """Values of linear conditions right to 13 digits: from a point (n,) of the family followed with 50 digits.

    Where conditions are all but flat, 1e-16 in their coefficients moves their solutions by 1e-10; where one is a
    square, σ is of second order in the error. The values stay where the singular point is farther away than `within`.
    """
    end, sigma = min(descents(problem, q), key=lambda descent: descent[1])
    if sigma > ROUNDING or np.abs(linear.deviation(end[None], np.array(values))).max() > within:
        return values
    pairs = zip(linear.values(end[None])[0].tolist(), linear.periodic.tolist(), strict=True)
    return tuple(canonical(value, VALUE_ERROR) if turns else round(value, 13) + 0.0 for value, turns in pairs)


def _row(problem: Problem, family: Family, pins: Mapping[int, Values]) -> Row:
    joints = tuple(sorted(pins))
    rest = [equation for equation in family.equations if not {j - 1 for j in equation.joints} <= set(joints)]
    coupled = tuple(sorted({j - 1 for j in flat_map(lambda equation: equation.joints, rest)} - set(joints)))
    free = tuple(j for j in range(problem.n) if j not in joints and j not in coupled)
    signature = Signature(problem.n - family.dimension, joints, free, coupled)
    linear = Linear.of(problem.robot, signature.covectors(problem.n))
    residual = tuple(normalised_equation(equation.terms) for equation in rest)
    return Row(linear, tuple(pins[j] for j in joints), residual, signature, FamilyEvidence(ObtainedFrom.EXACT), family)


def solve_at_special_values(
    problem: Problem, row: Row, marks: Mapping[int, Sequence[float]], rng: np.random.Generator
) -> tuple[int, Array]:
    """Solve a row's equations with some of their joints held at special values.

    Args:
        problem: the arm, and the corank.
        row: its conditions; each start takes one combination of values by chance.
        marks: further values to hold joints (from 0) at, beside right angles: those of other rows [rad or m].
        rng: of joints, values and starts.

    Returns:
        How many solutions could be judged, and (S, n) those that are regular.
    """
    n, linear = problem.n, row.linear
    none = np.zeros((0, n))
    if not row.residual:
        return 0, none
    system = System(row.residual)
    fixed = set(linear.pivots)
    numbers = sorted(set(flat_map(lambda f: f.joints, row.residual)))
    joints = [j - 1 for j in numbers if j - 1 not in fixed]
    begun: dict[tuple[int, ...], list[Array]] = {}
    values = np.array(row.combinations, dtype=np.float64).reshape(len(row.combinations), -1)
    for held in _choose_held_values(problem, joints, marks, rng):
        chosen = rng.integers(len(values), size=EACH)
        q = problem.random(EACH, rng)
        q[:, list(held)] = list(held.values())
        begun.setdefault(tuple(sorted(held)), []).append(linear.place(q, values[chosen], rng))
    loose = problem.random(LOOSE, np.random.default_rng(0))  # nothing held: a place that draws all equations at once
    begun[()] = [linear.place(loose, values[np.arange(LOOSE) % len(values)], np.random.default_rng(0))]
    ends = [none]
    for same, starts in begun.items():  # all starts that hold the same joints at once
        along = _free(linear, list(same), n)
        if not along.shape[1]:
            continue
        q, good = system.solve(np.concatenate(starts), along=along, iterations=60)
        if not same:  # counted only where they speak against the row: random starts have spoken for it
            good &= (np.abs(system.values(q)) <= CERTAIN).all(axis=1) & (problem.sigma(q)[:, problem.rank] > REGULAR)
        ends.append(q[good])
    q = np.concatenate(ends)
    q = q[problem.within_limits(q)]
    sigma = problem.sigma(q)[:, problem.rank]
    regular = sigma > REGULAR
    return int((regular | (sigma <= problem.tolerances.singular)).sum()), q[regular]


def _choose_held_values(
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
