"""Linear conditions m·q = c of a family: pinned joints and whole-number relations, and the values c they take.

A set of values has an equation, too: what the pinned joint, or the relation, satisfies. More points of one family with
one combination of values are made by random steps along its tangent.

Of joints on one axis only the sum of their angles matters, and one of them stands for both (`Problem.twins`). An
equation is fitted in one joint less, at θ_j = 0, and written with the sum.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations, product
from math import pi

import numpy as np
from numpy.typing import NDArray

from rankdrop.errors import OptionError
from rankdrop.families.genuine import polished
from rankdrop.families.searching import refine
from rankdrop.families.signature import Covector, Inspection, Signature, inspect
from rankdrop.family.equation import Equation, Mask, Term, normalised
from rankdrop.problem import Problem, Twin, wrap
from rankdrop.robot.model import Array, Robot


def vanishing_on(covector: Sequence[int], values: Sequence[float], *, periodic: bool) -> Equation:
    """The simplest equation that holds exactly where covector·q takes one of `values`.

    {0, π} gives sin u, {±π/2} cos u, {v} sin((u − v)/2), {v, v + π} sin(u − v), any other set the product of the
    sin((u − v)/2) written as a sum; a variable that is not periodic gives Π (u − v).

    Args:
        covector: (n,) whole numbers; u = covector·q. One ±1 entry for a pinned joint.
        values: [rad], or [m] where not periodic.
        periodic: whether u is an angle.

    Raises:
        OptionError: no value, or a relation between joints that are not angles with more than one value.
    """
    n, zero = len(covector), (0,) * len(covector)
    if not values:
        raise OptionError("a condition needs at least one value")
    if not periodic:
        return _polynomial(covector, values)
    half = tuple(int(m) for m in covector)
    whole = tuple(2 * m for m in half)
    if len(values) == 1:
        v = float(values[0])
        if abs(v) < 1e-15:
            return Equation((Term(1.0, "sin", half, zero),))
        if abs(abs(v) - pi) < 1e-15:
            return Equation((Term(1.0, "cos", half, zero),))
        return Equation((Term(1.0, "sin", half, zero, v / 2),))
    if len(values) == 2 and abs(np.cos(values[0] - values[1]) + 1) < 1e-15:
        v = float(values[0])
        if abs(np.sin(v)) < 1e-15:
            return Equation((Term(1.0, "sin", whole, zero),))
        if abs(np.cos(v)) < 1e-15:
            return Equation((Term(1.0, "cos", whole, zero),))
        low = v if -pi / 2 < v < pi / 2 else float(values[1])
        return Equation((Term(1.0, "sin", whole, zero, low),))
    return _product_of_sines(half, values, n)


def _product_of_sines(half: tuple[int, ...], values: Sequence[float], n: int) -> Equation:
    """Π sin((u − v)/2) over N values is z^(−N/2)·Π(z − e^{iv}) up to a constant, z = e^{iu}: read off its harmonics."""
    count = len(values)
    coefficients = np.poly(np.exp(1j * np.asarray(values)))  # of z^count … z^0
    coefficients = coefficients * np.exp(-0.5j * (np.angle(coefficients[-1])))  # makes it c_k = conj(c_{count−k})
    terms = []
    for k in range(count // 2 + 1):
        order = count - 2 * k  # twice the harmonic
        c = coefficients[k] * (1.0 if order == 0 else 2.0)
        harmonics = tuple(order * m for m in half)
        terms.append(Term(float(c.real), "cos", harmonics, (0,) * n))
        if order:
            terms.append(Term(float(-c.imag), "sin", harmonics, (0,) * n))
    return normalised(terms, threshold=1e-13)


def _polynomial(covector: Sequence[int], values: Sequence[float]) -> Equation:
    n, zero = len(covector), (0,) * len(covector)
    if sum(abs(m) for m in covector) == 1:
        j = next(i for i, m in enumerate(covector) if m)
        coefficients = np.poly(np.asarray(values, dtype=np.float64) * covector[j])
        degree = len(coefficients) - 1
        terms = [
            Term(float(c), "cos", zero, tuple(degree - k if i == j else 0 for i in range(n)))
            for k, c in enumerate(coefficients)
            if c != 0.0
        ]
        return Equation(tuple(terms))
    if len(values) > 1:
        raise OptionError("a relation between joints that are not angles takes one value", got=len(values))
    terms = [Term(float(m), "cos", zero, tuple(int(i == j) for i in range(n))) for j, m in enumerate(covector) if m]
    return Equation((*terms, Term(-float(values[0]), "cos", zero, zero)) if values[0] else tuple(terms))


SIMPLE = pi / 12  # values are taken for a multiple of this where they agree with one
Values = tuple[float, ...]


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
    def _square(self) -> Array:
        """(c, c) covectors of the pivots."""
        return self.covectors[:, list(self.pivots)].astype(np.float64)

    @cached_property
    def _turns(self) -> int:
        """How many branches the pivots have: the size of their minor."""
        return round(abs(float(np.linalg.det(self._square))))

    @cached_property
    def along(self) -> Array:
        """(n, n − c) orthonormal basis of the motions that keep all values."""
        if not len(self):
            return np.eye(self.covectors.shape[1])
        return np.asarray(np.linalg.svd(self.covectors.astype(np.float64))[2][len(self) :].T)

    def values(self, q: Array) -> Array:
        """(N, c) values at q (N, n), angles in (−π, π]."""
        raw = q @ self.covectors.T
        return np.where(self.periodic, wrap(raw), raw)

    def place(self, q: Array, values: Array, rng: np.random.Generator) -> Array:
        """Move the pivot joints of q (N, n) so that the covectors take `values` (N, c), on a branch by chance."""
        if not len(self):
            return q
        pivots, square = list(self.pivots), self._square
        branch = rng.integers(0, max(self._turns, 1), size=values.shape) * 2 * pi * self.periodic
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
        raw = self.values(q)
        snapped = np.empty_like(raw)
        for i in range(len(self)):
            snapped[:, i] = _snapped(raw[:, i], weights, tolerance, periodic=bool(self.periodic[i]))
        found: dict[Values, list[int]] = {}
        for point, row in enumerate(snapped.tolist()):
            found.setdefault(tuple(row), []).append(point)
        return {key: np.array(members) for key, members in found.items()}

    def neighbours(self, values: Values) -> list[Values]:
        """Combinations with one angle exchanged for v + π or −v: where symmetry puts further pieces."""
        result = []
        for i in range(len(self)):
            for other in (values[i] + pi, -values[i], pi - values[i]) if self.periodic[i] else ():
                v = canonical(other)
                if v != values[i]:
                    result.append((*values[:i], v, *values[i + 1 :]))
        return result


def canonical(angle: float) -> float:
    """The angle in (−π, π], multiples of π/12 exact, other values rounded to 1e-13 so that equal ones compare equal."""
    angle = float(wrap(np.array(angle)))
    whole = round(angle / SIMPLE)
    if abs(angle - whole * SIMPLE) < 1e-12:
        return pi if whole == -12 else whole * SIMPLE
    return round(angle, 13)


def _snapped(values: Array, weights: Array, tolerance: float, *, periodic: bool) -> Array:
    """Each value replaced by the best-known one of its cluster, or the multiple of π/12 there."""
    order = np.argsort(values, kind="stable")
    gaps = np.diff(values[order]) > tolerance
    labels = np.empty(len(values), dtype=np.int64)
    labels[order] = np.concatenate([[0], np.cumsum(gaps)])
    last = labels[order[-1]]
    if periodic and last > 0 and values[order[0]] + 2 * pi - values[order[-1]] <= tolerance:
        labels[labels == last] = 0  # −π and π are one value
    result = np.empty_like(values)
    for label in np.unique(labels):
        members = np.flatnonzero(labels == label)
        value = float(values[members[np.argmax(weights[members])]])
        if periodic:
            whole = round(value / SIMPLE)
            value = canonical(whole * SIMPLE) if abs(value - whole * SIMPLE) <= tolerance else canonical(value)
        elif abs(value) <= tolerance:
            value = 0.0
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
    found: set[Values] = set()
    front = list(dict.fromkeys(same(values) for values in start))
    while front and len(tested) < most:
        tested.update(front)
        good = [values for values, ok in zip(front, holds(front), strict=True) if ok]
        found.update(good)
        near = dict.fromkeys(same(n) for values in good for n in linear.neighbours(values))
        front = [values for values in near if values not in tested]
    return found


def boxes(found: set[Values]) -> list[tuple[Values, ...]]:
    """Cover a set of combinations by full products, large ones first: each product is one row of the table."""
    left = set(found)
    result = []
    while left:
        seed = min(left, key=lambda values: (sum(abs(v) for v in values), values))
        sets = [[v] for v in seed]
        for i in sorted(range(len(seed)), key=lambda i: -len({v[i] for v in left})):
            for v in sorted({values[i] for values in left} - set(sets[i]), key=lambda v: (abs(v), -v)):
                trial = [[*one, v] if j == i else one for j, one in enumerate(sets)]
                if all(values in found for values in product(*trial[:i], [v], *trial[i + 1 :])):
                    sets = trial
        left -= set(product(*sets))
        result.append(tuple(tuple(sorted(one, key=lambda v: (abs(v), -v))) for one in sets))
    return result


def gathered(q: Array, twins: Sequence[Twin]) -> Array:
    """(N, n) the same configurations as far as singular values go, the second of each pair at zero."""
    q = np.array(q)
    for first, second, sign in twins:
        q[:, first] += sign * q[:, second]
        q[:, second] = 0.0
    return q


def gathered_tangent(tangent: Array, twins: Sequence[Twin]) -> Array:
    """(N, n, n) projectors on the tangent space of the part of a family where the second of each pair is at zero.

    A covector that vanishes on the family has c_second = sign·c_first: without that entry it is one of the part.
    """
    if not twins:
        return tangent
    n = tangent.shape[1]
    conormal = np.eye(n) - tangent
    seconds = [twin.second for twin in twins]
    conormal[:, :, seconds] = 0.0
    _, s, vt = np.linalg.svd(conormal)
    inside = (s > 0.1).astype(np.float64)  # a covector keeps at least 1/√3 of its length
    return np.asarray(np.eye(n) - np.einsum("nij,ni,nik->njk", vt, inside, vt))


def spread(equation: Equation, twins: Sequence[Twin]) -> Equation:
    """The equation with θ_first + sign·θ_second in place of θ_first."""
    if not twins:
        return equation
    return normalised([_spread(term, twins) for term in equation.terms])


def _spread(term: Term, twins: Sequence[Twin]) -> Term:
    harmonics = list(term.harmonics)
    for first, second, sign in twins:
        harmonics[second] = sign * harmonics[first]
    return replace(term, harmonics=tuple(harmonics))


ROUNDS = 12  # tangent steps of all points at most; each gives about as many points as it starts from
SAME = 1e-6  # combinations of values closer than this are the same


def smooth(problem: Problem, inspection: Inspection, members: Array, rng: np.random.Generator) -> bool:
    """Whether ker D is the tangent space: a step ε along it is ε² away from the set, not ε as where families meet."""
    chosen = members[:: max(1, len(members) // 8)][:8]
    q, tangent = inspection.q[chosen], inspection.tangent[chosen]
    step = np.einsum("nij,nj->ni", tangent, rng.standard_normal(q.shape))
    step *= 0.01 / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-300)
    back = refine(problem.robot, q + step, problem.corank, task=problem.task, tolerances=problem.tolerances)
    way = np.linalg.norm(wrap(back.q - q - step), axis=1)
    return bool(np.median(way) < 0.2 * 0.01)


@dataclass(eq=False)
class FamilyPoints:
    """Points of one family with one combination of values; makes more when asked.

    Attributes:
        q: (N, n) points so far, in no special order: a fit needs them spread over the family.
        tangent: (N, n, n) projectors on the tangent space there.
    """

    problem: Problem
    signature: Signature
    linear: Linear
    values: Values
    q: Array
    tangent: Array
    rng: np.random.Generator
    exhausted: bool = field(default=False)

    def __call__(self, count: int) -> Array:
        """At least `count` points, somewhat more where they are there, or all that can be had."""
        for _ in range(ROUNDS):
            if len(self.q) >= count or self.exhausted:
                break
            self._more(count)
        return self.q[: count + 150]

    def _more(self, count: int) -> None:
        batch = min(max(2 * (count - len(self.q)), 64), 2000)
        base = self.rng.integers(0, len(self.q), size=batch)
        step = np.einsum("nij,nj->ni", self.tangent[base], self.rng.standard_normal((batch, self.q.shape[1])))
        length = self.rng.uniform(0.1, 1.0, size=(batch, 1))
        step *= length / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-300)
        problem = self.problem
        start = self.q[base] + step
        found = refine(problem.robot, start, problem.corank, task=problem.task, tolerances=problem.tolerances)
        back = found.converged
        inspection = inspect(problem, polished(problem, back))
        same = np.array([s == self.signature for s in inspection.signatures], dtype=np.bool_)
        same &= inspection.sigma[:, problem.rank] <= 1e-12 if len(same) else same
        off = self.linear.values(inspection.q) - np.array(self.values)
        off = np.where(self.linear.periodic, wrap(off), off)
        same &= (np.abs(off) < SAME).all(axis=1)
        if same.sum() < 0.02 * batch:
            self.exhausted = True
        self.q = np.concatenate([self.q, inspection.q[same]])
        self.tangent = np.concatenate([self.tangent, inspection.tangent[same]])
