"""Fitting: from points of a hypersurface on the torus to its equation.

*Libraries* are spaces of trigonometric polynomials of given degree in each joint. In the half-angle variable t =
tan(θ/2) a trigonometric polynomial is an ordinary one, and unique factorisation holds there (it fails in cos and sin).
Degree d in t means the harmonics −d/2, −d/2 + 1, …, d/2: d + 1 functions. So d = 1 holds sin(θ/2) and cos(θ/2), d = 2
the usual 1, cos, sin, and d = 4 is enough for every minor of a pose Jacobian. A prismatic joint has powers 0 … d, a
helical one both. Without helical joints a space of multidegree (d_1, …, d_b) has Π(d_j + 1) functions. All terms of a
space have one parity, so that every zero set is well defined on the torus.

*Fitting.* Let a family have dimension D in its coupled joints. A minimal set of joints bound by an equation of their
own is a circuit of the family's algebraic matroid, and has at most D + 1 joints. Seen in the joints of a circuit the
family is a hypersurface, so the polynomials in these joints that vanish on it form a *principal* ideal of the ring in t
= tan(θ/2): one generator, the same whichever library it is found in. Two things follow.

- If f has multidegree d(f), the null space of a library of multidegree d has dimension Π(d_j − d_j(f) + 1). So a
  generous library finds out whether f is within reach, and lowering one degree at a time as long as something is left
  ends at d(f), where the null space has dimension one and the coefficients come out without any choice of basis.
- Half-angle conditions (d·cos(θ4/2) = a·sin(θ3 + θ4/2)) need no special treatment: an odd degree is one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, product
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.linear import gathered, spread
from rankdrop.family.equation import Equation, Term, normalised
from rankdrop.problem import Twin
from rankdrop.robot.model import Array
from rankdrop.tolerances import Tolerances

Kind = Literal["angle", "length", "both"]
"""How a joint enters: through harmonics, through powers, or, helical, through both."""


NULL = 1e-9  # singular values of the library matrix below this share of the largest may be zero
WORSE = 3.0  # the residual may grow so much when small coefficients are dropped
Degrees = tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Library:
    """The functions of one multidegree in b variables, simplest first.

    Attributes:
        harmonics: (L, b) twice the multiples m.
        powers: (L, b) exponents of the variables that are not periodic.
        is_sin: (L,) sine rather than cosine.
    """

    harmonics: NDArray[np.int64]
    powers: NDArray[np.int64]
    is_sin: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.harmonics)

    def __call__(self, x: Array) -> Array:
        """(N, L) values at x (N, b)."""
        unique, inverse = np.unique(self.harmonics, axis=0, return_inverse=True)
        angle = x @ (unique.T / 2)
        waves = np.where(self.is_sin, np.sin(angle)[:, inverse.reshape(-1)], np.cos(angle)[:, inverse.reshape(-1)])
        for j in np.flatnonzero(self.powers.any(axis=0)):
            waves = waves * x[:, j : j + 1] ** self.powers[:, j]
        return np.asarray(waves)

    def equation(self, coefficients: Array, variables: tuple[int, ...], n: int) -> Equation:
        """Σ c_i·function_i as an equation in n joints, the b variables being the given joints (from 0)."""
        terms = []
        for c, h, p, is_sin in zip(coefficients, self.harmonics, self.powers, self.is_sin, strict=True):
            if c != 0.0:
                wide_h, wide_p = [0] * n, [0] * n
                for j, joint in enumerate(variables):
                    wide_h[joint], wide_p[joint] = int(h[j]), int(p[j])
                terms.append(Term(float(c), "sin" if is_sin else "cos", tuple(wide_h), tuple(wide_p)))
        return normalised(terms)


@lru_cache(maxsize=256)
def library(degrees: Degrees, kinds: tuple[Kind, ...]) -> Library:
    """The functions of multidegree `degrees` in joints of these kinds."""
    waves = [(0,) if k == "length" else range(-d, d + 1, 2) for d, k in zip(degrees, kinds, strict=True)]
    powers = [range(_power(d, k) + 1) for d, k in zip(degrees, kinds, strict=True)]
    rows: list[tuple[tuple[int, ...], tuple[int, ...], bool]] = []
    for m in product(*waves):
        leading = next((h for h in m if h), 0)
        if leading < 0:
            continue
        for is_sin in (False, True) if leading else (False,):
            rows.extend((m, p, is_sin) for p in product(*powers))
    rows.sort(key=lambda row: (sum(map(abs, row[0])) + 2 * sum(row[1]), sum(map(bool, row[0])), row))
    return Library(
        np.array([row[0] for row in rows], dtype=np.int64),
        np.array([row[1] for row in rows], dtype=np.int64),
        np.array([row[2] for row in rows], dtype=np.bool_),
    )


def size(degrees: Degrees, kinds: tuple[Kind, ...]) -> int:
    """Number of functions of a multidegree."""
    pairs = zip(degrees, kinds, strict=True)
    return int(np.prod([(1 if k == "length" else d + 1) * (_power(d, k) + 1) for d, k in pairs]))


def _power(degree: int, kind: Kind) -> int:
    """Largest power at a degree: none for angles; helical joints take one for every two half-angles."""
    return {"angle": 0, "length": degree, "both": degree // 2}[kind]


def vanishing(values: Array, tolerances: Tolerances) -> Array:
    """Combinations of functions that are zero at all points.

    Args:
        values: (N, L) functions at points, N > L.
        tolerances: `fit_gap`.

    Returns:
        (L, d) orthonormal basis; d = 0 when no gap separates zero singular values from the rest.
    """
    r = np.linalg.qr(values, mode="r")
    _, s, vt = np.linalg.svd(r)
    inside = s <= NULL * s[0]
    count = int(inside.sum())
    if count == 0 or count == len(s):
        return np.zeros((values.shape[1], 0))
    first = len(s) - count
    if s[first] > tolerances.fit_gap * s[first - 1]:
        return np.zeros((values.shape[1], 0))
    return np.asarray(vt[first:].T)


def sparse_basis(null: Array) -> Array:
    """(L, d) basis of the same space with zeros where possible: each vector leads at another, late, function.

    Gauss–Jordan from the least simple function upwards, so that simple generators come out by themselves; sparse
    ones first.
    """
    rows = null.T[:, ::-1].copy()
    pivot = 0
    for column in range(rows.shape[1]):
        if pivot == len(rows):
            break
        best = pivot + int(np.argmax(np.abs(rows[pivot:, column])))
        if abs(rows[best, column]) < 1e-7:
            continue
        rows[[pivot, best]] = rows[[best, pivot]]
        rows[pivot] /= rows[pivot, column]
        others = np.arange(len(rows)) != pivot
        rows[others] -= rows[others, column : column + 1] * rows[pivot]
        pivot += 1
    rows = rows[:, ::-1]
    rows = rows / np.abs(rows).max(axis=1, keepdims=True)
    filled = np.abs(rows) > 1e-7
    last = rows.shape[1] - np.argmax(filled[:, ::-1], axis=1)  # the least simple function of each
    return np.asarray(rows[np.lexsort((last, filled.sum(axis=1)))].T)


def refit(values: Array, coefficients: Array, tolerances: Tolerances) -> Array:
    """Drop coefficients that are zero within noise and solve again on the support: right to the points' own accuracy.

    Args:
        values: (N, L) functions at points.
        coefficients: (L,) a combination that vanishes there.

    Returns:
        (L,) exact zeros outside the support; the largest entry has size one.
    """
    best = coefficients / np.abs(coefficients).max()
    noise = float(np.linalg.norm(values @ best) / np.linalg.norm(best))
    floor = 1e-15 * float(np.linalg.norm(values))
    for threshold in tolerances.coefficient * np.array([1e2, 1.0, 1e-2, 1e-4]):
        support = np.abs(best) > threshold
        _, s, vt = np.linalg.svd(np.linalg.qr(values[:, support], mode="r"))
        if s[-1] <= WORSE * noise + floor:  # a small coefficient that is real would show here
            result = np.zeros_like(best)
            result[support] = vt[-1]
            return np.asarray(result / np.abs(result).max())
    return np.asarray(best)


LARGEST = 700  # functions in a library at most; a generic 6R needs 225
MOST = 24  # equations of one library that are looked at
HELD_OUT = 1e-7  # |f|/|∇f| on points that took no part in the fit [rad]

FamilyPoints = Callable[[int], Array]
"""source(count) -> (N, n) points of the family; N < count when no more can be had."""


@dataclass
class Budget:
    """Work left for fits, in floating-point operations: a limit that does not depend on the machine."""

    left: float = 2e10

    def spend(self, points: int, functions: int) -> bool:
        """Take the cost of one null space off; False when the budget would not suffice."""
        cost = 4.0 * points * functions**2
        if cost > self.left:
            return False
        self.left -= cost
        return True

    def share(self, most: float) -> Budget:
        """A part of this budget, for one task; give back what it leaves with `back`."""
        part = Budget(min(most, self.left))
        self.left -= part.left
        return part

    def back(self, part: Budget) -> None:
        """Take back what a share has left."""
        self.left += part.left


@dataclass(frozen=True)
class FitProblem:
    """What a fit stands on.

    Attributes:
        source: points of the family.
        n: number of joints of the arm.
        kinds: (n,) how each joint enters.
        highest: largest degree in t of an angle. 4 for the full pose: an exterior power of the adjoint map of a
            rotation has harmonics up to 2. 6 for the other tasks, whose columns each depend on the reference point.
        budget: work that may be spent.
        tolerances: `fit_gap`, `coefficient`.
        twins: joints on one axis, of which the first stands for both in every fit.
    """

    source: FamilyPoints
    n: int
    kinds: tuple[Kind, ...]
    highest: int
    budget: Budget
    tolerances: Tolerances
    twins: tuple[Twin, ...] = ()

    def equation(self, functions: Library, vector: Array, joints: tuple[int, ...]) -> Equation:
        """A combination of the functions of a library as an equation of the arm."""
        return spread(functions.equation(vector, joints, self.n), self.twins)

    def of(self, joints: tuple[int, ...]) -> tuple[Kind, ...]:
        """Kinds of the given joints (from 0)."""
        return tuple(self.kinds[j] for j in joints)

    def ladder(self, joints: tuple[int, ...]) -> Iterator[Degrees]:
        """Multidegrees to try for the joints, growing."""
        return ladder(self.of(joints), self.highest)

    def enough(self, degrees: Degrees, joints: tuple[int, ...]) -> Array | None:
        """Points for a library, or None when there are too few or the budget is used up."""
        count = size(degrees, self.of(joints))
        points = gathered(self.source(int(1.25 * count) + 24), self.twins)
        return points if len(points) >= 1.1 * count + 12 and self.budget.spend(len(points), count) else None


def ladder(kinds: tuple[Kind, ...], highest: int = 4, most: int = LARGEST) -> Iterator[Degrees]:
    """Multidegrees to try, growing: all 1, then 2, 4 … (angle) and 1 or 2 (length) per joint by library size."""
    yield tuple(1 for _ in kinds)
    steps = product(*((1, 2) if k == "length" else range(2, highest + 1, 2) for k in kinds))
    yield from (degrees for degrees in sorted(steps, key=lambda d: (size(d, kinds), d)) if size(degrees, kinds) <= most)


def hypersurface(fit: FitProblem, joints: tuple[int, ...]) -> Equation | None:
    """The equation that binds the given joints on a family.

    Args:
        fit: points, budget …
        joints: from 0; the family seen in them has one dimension less than their number.

    Returns:
        The generator, its largest coefficient of size one, or None: not within reach of the libraries, the points or
        the budget, or refuted by held-out points.
    """
    kinds, tolerances = fit.of(joints), fit.tolerances
    for degrees, train, held, null in _nulls(fit, joints):
        x = train[:, joints]
        degrees, null = _lowest(x, degrees, null, kinds, tolerances)
        functions = library(degrees, kinds)
        vector = sparse_basis(null)[:, 0] if null.shape[1] > 1 else null[:, 0]
        equation = fit.equation(functions, refit(functions(x), vector, tolerances), joints)
        return equation if holds(equation, held) else None
    return None


def _lowest(
    x: Array, degrees: Degrees, null: Array, kinds: tuple[Kind, ...], tolerances: Tolerances
) -> tuple[Degrees, Array]:
    """Lower the degrees one by one as long as something vanishes."""
    for j in range(len(degrees)):
        while degrees[j] > 0 and null.shape[1] > 1:
            trial = (*degrees[:j], degrees[j] - 1, *degrees[j + 1 :])
            smaller = vanishing(library(trial, kinds)(x), tolerances)
            if not smaller.shape[1]:
                break
            degrees, null = trial, smaller
    return degrees, null


def holds(equation: Equation, points: Array, tolerance: float = HELD_OUT) -> bool:
    """Whether an equation vanishes on points, as a distance |f|/|∇f| where the gradient is not small."""
    f, slope = np.abs(equation(points)), np.linalg.norm(equation.gradient(points), axis=-1)
    return bool((f <= tolerance * np.maximum(slope, 1e-2)).all())


_BOUND = 1e-11  # eigenvalue of the projector on the tangent space, restricted to joints that are bound
MOST_CIRCUITS = 1000
"""More are not looked for: a family in general position of 14 joints has 924, of 20 joints 18,564."""


def circuits(tangent: Array, joints: tuple[int, ...]) -> list[tuple[int, ...]]:
    """Minimal sets of joints bound by an equation of their own, small and close together first.

    On a family of dimension D in its coupled joints any D + 1 of them are bound. `MOST_CIRCUITS` are told at most.

    Args:
        tangent: (p, n, n) projectors on the tangent space at a few points of the family.
        joints: the joints (from 0) to look among.
    """
    found: list[tuple[int, ...]] = []
    free = np.linalg.eigvalsh(tangent[:, joints, :][:, :, joints]) >= _BOUND
    for count in range(1, min(len(joints), int(free.sum(axis=1).max(initial=0)) + 1) + 1):
        bound: list[tuple[int, ...]] = []
        for support in combinations(joints, count):
            if len(found) + len(bound) >= MOST_CIRCUITS:
                break
            if any(set(circuit) <= set(support) for circuit in found):
                continue
            part = tangent[:, support, :][:, :, support]
            if np.median(np.linalg.eigvalsh(part)[:, 0]) < _BOUND:
                bound.append(support)
        found += sorted(bound, key=lambda support: (support[-1] - support[0], support))
    return found


def vanishing_spaces(fit: FitProblem, joints: tuple[int, ...]) -> Iterator[list[Equation]]:
    """For every library of the ladder that holds equations of the family: a basis of them, sparse ones first."""
    for degrees, train, held, null in _nulls(fit, joints):
        functions = library(degrees, fit.of(joints))
        values = functions(train[:, joints])
        basis = sparse_basis(null)[:, :MOST].T
        equations = [fit.equation(functions, refit(values, v, fit.tolerances), joints) for v in basis]
        yield [equation for equation in equations if holds(equation, held)]


def _nulls(fit: FitProblem, joints: tuple[int, ...]) -> Iterator[tuple[Degrees, Array, Array, Array]]:
    """Multidegrees whose libraries hold equations of the family, training and held-out points, null space."""
    for degrees in fit.ladder(joints):
        points = fit.enough(degrees, joints)
        if points is None:
            return
        out = np.arange(len(points)) % 8 == 7
        train, held = points[~out], points[out]
        null = vanishing(library(degrees, fit.of(joints))(train[:, joints]), fit.tolerances)
        if null.shape[1]:
            yield degrees, train, held, null
