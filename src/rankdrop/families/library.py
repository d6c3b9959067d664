"""Libraries of functions, and fits: from points of a hypersurface on the torus to its equation.

A library is a space of trigonometric polynomials of given degree in each joint. In the half-angle variable t = tan(θ/2)
a trigonometric polynomial is an ordinary one, and unique factorisation holds there (it fails in cos and sin).
Degree d in t means the harmonics −d/2, −d/2 + 1, …, d/2: d + 1 functions. So d = 1 holds sin(θ/2) and cos(θ/2), d = 2
the usual 1, cos, sin, and d = 4 is enough for every minor of a pose Jacobian. A prismatic joint has powers 0 … d, a
helical one both. Without helical joints a space of multidegree (d_1, …, d_b) has Π(d_j + 1) functions. All terms of a
space have one parity, so that every zero set is well defined on the torus.

Let a family have dimension D in its coupled joints. A minimal set of joints bound by an equation of their
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

from rankdrop.formula.equation import Equation, Term, normalised_equation
from rankdrop.robot.model import Array
from rankdrop.tolerances import Tolerances

Kind = Literal["angle", "length", "both"]
"""How a joint enters: through harmonics, through powers, or, helical, through both."""


NULL = 1e-9  # singular values of the library matrix below this share of the largest may be zero
WORSE = 3.0  # the residual may grow so much when small coefficients are dropped
Degrees = tuple[int, ...]

LARGEST = 700  # functions in a library at most; a generic 6R needs 225
MOST = 24  # equations of one library that are looked at
HELD_OUT = 1e-7  # |f|/|∇f| on points that took no part in the fit [rad]

Source = Callable[[int], Array]
"""source(count) -> (N, n) points of the family; N < count when no more can be had."""

_BOUND = 1e-11  # eigenvalue of the projector on the tangent space, restricted to joints that are bound
MOST_CIRCUITS = 1000
"""More are not looked for: a family in general position of 14 joints has 924, of 20 joints 18,564."""
MOST_SUPPORTS = 20_000
"""More sets of joints are not tried: 14 joints have 16,383, 30 joints a billion."""


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
        wide = np.zeros((2, len(self), n), dtype=np.int64)
        wide[:, :, list(variables)] = self.harmonics, self.powers
        kinds = np.where(self.is_sin, "sin", "cos").tolist()
        rows = zip(coefficients.tolist(), kinds, *wide.tolist(), strict=True)
        return normalised_equation(Term(c, kind, tuple(h), tuple(p)) for c, kind, h, p in rows if c != 0.0)


@lru_cache(maxsize=256)
def library(degrees: Degrees, kinds: tuple[Kind, ...]) -> Library:
    """The functions of multidegree `degrees` in joints of these kinds."""
    waves = [(0,) if k == "length" else range(-d, d + 1, 2) for d, k in zip(degrees, kinds, strict=True)]
    powers = [range(_power(d, k) + 1) for d, k in zip(degrees, kinds, strict=True)]
    zero = (0,) * len(degrees)
    half = [m for m in product(*waves) if m >= zero]  # of m and −m the one whose first entry is positive
    rows = [(m, p, is_sin) for m in half for is_sin in (False, True)[: 1 + (m > zero)] for p in product(*powers)]
    rows.sort(key=lambda row: (sum(map(abs, row[0])) + 2 * sum(row[1]), sum(map(bool, row[0])), row))
    harmonics, exponents, is_sin = zip(*rows, strict=True)
    return Library(np.array(harmonics, dtype=np.int64), np.array(exponents, dtype=np.int64), np.array(is_sin))


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

    Leading functions are chosen from the least simple one on, as in Gauss–Jordan elimination, so that simple generators
    come out by themselves; sparse ones first.
    """
    leading: list[int] = []
    rest = null.copy()
    for row in reversed(range(len(null))):
        size = float(np.linalg.norm(rest[row]))
        if size > 1e-7 and len(leading) < null.shape[1]:
            leading.append(row)
            direction = rest[row] / size
            rest -= np.outer(rest @ direction, direction)
    if len(leading) == null.shape[1]:
        basis = np.linalg.solve(null[leading].T, null.T).T
    else:
        basis = null
    basis = basis / np.abs(basis).max(axis=0)
    filled = np.abs(basis) > 1e-7
    last = len(basis) - np.argmax(filled[::-1], axis=0)  # the least simple function of each
    return np.asarray(basis[:, np.lexsort((last, filled.sum(axis=0)))])


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


@dataclass
class FitProblem:
    """What a fit stands on.

    Attributes:
        source: points of the family.
        n: number of joints of the arm.
        kinds: (n,) how each joint enters.
        highest: largest degree in t of an angle. 4 for the full pose: an exterior power of the adjoint map of a
            rotation has harmonics up to 2. 6 for the other tasks, whose columns each depend on the reference point.
        work: that may be spent, in floating-point operations: a limit that does not depend on the machine.
        tolerances: `fit_gap`, `coefficient`.
    """

    source: Source
    n: int
    kinds: tuple[Kind, ...]
    highest: int
    work: float
    tolerances: Tolerances

    def kinds_of(self, joints: tuple[int, ...]) -> tuple[Kind, ...]:
        """Kinds of the given joints (from 0)."""
        return tuple(self.kinds[j] for j in joints)

    def enough(self, degrees: Degrees, joints: tuple[int, ...]) -> Array | None:
        """Points for a library, or None where there are too few or the work is more than is left."""
        count = size(degrees, self.kinds_of(joints))
        if 4.0 * (1.1 * count + 12) * count**2 > self.work:  # before a single point is solved for
            return None
        points = self.source(int(1.25 * count) + 24)
        cost = 4.0 * len(points) * count**2
        if len(points) < 1.1 * count + 12 or cost > self.work:
            return None
        self.work -= cost
        return points


def ladder(kinds: tuple[Kind, ...], highest: int = 4, most: int = LARGEST) -> Iterator[Degrees]:
    """Multidegrees to try, growing: all 1, then 2, 4 … (angle) and 1 or 2 (length) per joint by library size."""
    yield tuple(1 for _ in kinds)
    steps = product(*((1, 2) if k == "length" else range(2, highest + 1, 2) for k in kinds))
    yield from (degrees for degrees in sorted(steps, key=lambda d: (size(d, kinds), d)) if size(degrees, kinds) <= most)


def hypersurface(fit: FitProblem, joints: tuple[int, ...]) -> Equation | None:
    """The equation that binds the given joints on a family.

    Args:
        fit: points, work …
        joints: from 0; the family seen in them has one dimension less than their number.

    Returns:
        The generator, its largest coefficient of size one, or None: not within reach of the libraries, the points or
        the work, or refuted by held-out points.
    """
    kinds, tolerances = fit.kinds_of(joints), fit.tolerances
    for degrees, train, held, null in _nulls(fit, joints):
        x = train[:, joints]
        degrees, null = _lowest(x, degrees, null, kinds, tolerances)
        functions = library(degrees, kinds)
        coefficients = refit(functions(x), sparse_basis(null)[:, 0], tolerances)
        equation = functions.equation(coefficients, joints, fit.n)
        if holds(equation, held):
            return equation
        return None
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


def circuits(tangent: Array, joints: tuple[int, ...]) -> list[tuple[int, ...]]:
    """Minimal sets of joints bound by an equation of their own, small and close together first.

    On a family of dimension D in its coupled joints any D + 1 of them are bound. `MOST_CIRCUITS` are told at most.

    Args:
        tangent: (p, n, n) projectors on the tangent space at a few points of the family.
        joints: the joints (from 0) to look among.
    """
    supports: list[tuple[int, ...]] = []
    tried = 0
    free = np.linalg.eigvalsh(tangent[:, joints, :][:, :, joints]) >= _BOUND
    for count in range(1, min(len(joints), int(free.sum(axis=1).max(initial=0)) + 1) + 1):
        bound: list[tuple[int, ...]] = []
        for support in combinations(joints, count):
            tried += 1
            if len(supports) + len(bound) >= MOST_CIRCUITS or tried > MOST_SUPPORTS:
                break
            if any(set(circuit) <= set(support) for circuit in supports):
                continue
            part = tangent[:, support, :][:, :, support]
            if np.median(np.linalg.eigvalsh(part)[:, 0]) < _BOUND:
                bound.append(support)
        supports += sorted(bound, key=lambda support: (support[-1] - support[0], support))
    return supports


def vanishing_spaces(fit: FitProblem, joints: tuple[int, ...]) -> Iterator[list[Equation]]:
    """For every library of the ladder that holds equations of the family: a basis of them, sparse ones first."""
    for degrees, train, held, null in _nulls(fit, joints):
        functions = library(degrees, fit.kinds_of(joints))
        values = functions(train[:, joints])
        basis = sparse_basis(null)[:, :MOST].T
        equations = [functions.equation(refit(values, v, fit.tolerances), joints, fit.n) for v in basis]
        yield [equation for equation in equations if holds(equation, held)]


def _nulls(fit: FitProblem, joints: tuple[int, ...]) -> Iterator[tuple[Degrees, Array, Array, Array]]:
    """Multidegrees whose libraries hold equations of the family, training and held-out points, null space."""
    for degrees in ladder(fit.kinds_of(joints), fit.highest):
        points = fit.enough(degrees, joints)
        if points is None:
            return
        out = np.arange(len(points)) % 8 == 7
        train, held = points[~out], points[out]
        null = vanishing(library(degrees, fit.kinds_of(joints))(train[:, joints]), fit.tolerances)
        if null.shape[1]:
            yield degrees, train, held, null
