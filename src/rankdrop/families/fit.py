"""Conditions fitted to points of a search, for arms whose families no derivation finished.

Points are grouped by what D says of them (`signature`). Values of pinned joints and relations are snapped, completed by
symmetry and verified directly by σ. Equations of coupled joints are fitted circuit by circuit, in order of size, until
they have the family's codimension (`library`). Solutions that are not singular ("strangers": the equations of two
circuits may meet in more than the family) are cut off by further ones, then by minors of the task Jacobian. Where
single circuits have too high a degree (projections of a curve have), low-degree equations in all joints are tried.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.descent import verify_points
from rankdrop.families.evidence import FamilyEvidence, ObtainedFrom
from rankdrop.families.inspection import Covector, Inspection, Signature, candidates, independent, inspect
from rankdrop.families.library import (
    FitProblem,
    Kind,
    circuits,
    holds,
    hypersurface,
    vanishing_spaces,
)
from rankdrop.families.linear_conditions import SIMPLE, Linear, clusters
from rankdrop.families.row import Membership, Row, on_any, on_row, sharp_values
from rankdrop.families.searching import refine
from rankdrop.families.soundness import solve_at_special_values
from rankdrop.families.value_sets import boxes, complete_rows
from rankdrop.formula.equation import Equation, Mask, System, Term, normalised_equation
from rankdrop.kinematics import task_jacobian
from rankdrop.problem import Problem, wrap
from rankdrop.robot.model import Array, JointKind

FITS = 16  # combinations of values of one signature that are fitted on their own, at most
WORK = 6e9  # of the fits for one group, in floating-point operations
MOST_GROUPS = 8  # that are fitted: more would take minutes
_MANY = 9  # joints; of arms with more, one combination of values of one group is fitted: each takes half a minute
FEW = 3  # points from which a fit is tried
BADLY = 0.1  # share of the points left out of fits: those that are known worst

WIDTH = 3e-5  # values closer than this are shared [rad or length scales]
SHARED = 5  # points that must share a value
GROUPS = 8  # groups of points that are tried, large ones first

STEPS = 12  # tangent steps of all points at most; each gives about as many points as it starts from
SAME = 1e-6  # combinations of values closer than this are the same

GRID = 20_000  # grid points at most
LONGEST = 1500  # terms of an equation at most
NOISE = 1e-12  # coefficients below this share of the largest are rounding

EXTRA = 3  # equations beyond the codimension that may be added to cut strangers off
SEED = 12  # points at which ranks are looked at
ROUNDS = 16  # of some 100 solutions at special places: of a row of a general 8R one in 400 is regular


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
    rows: list[Row] = []
    fitted, groups = 0, group_by_signature(inspection)
    for index, (signature, members) in enumerate(groups):
        if progress is not None:
            progress(index, len(groups))
        unexplained = members[~on_any(cover, rows, len(inspection.q))[members]]
        if not signature.rank or len(unexplained) < (FEW if signature.residual else 1):
            continue
        rng = np.random.default_rng([seed, problem.corank, index])
        if fitted < (MOST_GROUPS if problem.n <= _MANY else 1) and smooth(problem, inspection, unexplained, rng):
            fitted += bool(signature.residual)
            rows += _rows_of(problem, signature, inspection, unexplained, rng)
    rest = inspection.q[inspection.exact & ~on_any(cover, rows, len(inspection.q))]
    rows += linear_rows(problem, rest, np.random.default_rng([seed, problem.corank, len(groups)]))
    return without_contained(problem, rows, np.random.default_rng([seed, problem.corank, len(groups) + 1]))


def group_by_signature(inspection: Inspection) -> list[tuple[Signature, NDArray[np.int64]]]:
    """Points by signature: large dimension first, then many points first."""
    groups: dict[Signature, list[int]] = {}
    for point, signature in enumerate(inspection.signatures):
        if signature is not None:
            groups.setdefault(signature, []).append(point)
    order = sorted(groups, key=lambda s: (s.rank, -len(groups[s]), s))
    return [(signature, np.array(groups[signature])) for signature in order]


def _rows_of(
    problem: Problem,
    signature: Signature,
    inspection: Inspection,
    members: NDArray[np.int64],
    rng: np.random.Generator,
) -> list[Row]:
    linear = Linear.of(problem.robot, signature.covectors(problem.n))
    q, tangent, known = (part[members] for part in (inspection.q, inspection.tangent, inspection.condition))
    met = linear.combinations(q, known, problem.tolerances.value)
    plain = Row(linear, (), (), signature, FamilyEvidence(ObtainedFrom.VALUES))
    if not signature.residual:
        return complete_rows(problem, plain, met, rng)
    rows: list[Row] = []
    fitted = FamilyEvidence(ObtainedFrom.FITTED)
    for values in sorted(met, key=lambda values: (-len(met[values]), values))[: FITS if problem.n <= _MANY else 1]:
        if any(values in row.combinations for row in rows):
            continue
        here = met[values]
        here = rng.permutation(here[known[here] >= np.quantile(known[here], BADLY)])
        single = replace(plain, sets=tuple((value,) for value in values), evidence=fitted)
        residual = fitted_equations(FamilyPoints(problem, single, q[here], tangent[here], rng), WORK)
        if residual is not None:
            alike = [others for others, points in met.items() if all(holds(f, q[points]) for f in residual)]
            rows += complete_rows(problem, replace(single, residual=residual), [values, *alike], rng)
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


def linear_rows(problem: Problem, q: Array, rng: np.random.Generator) -> list[Row]:
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
    every = Linear.of(problem.robot, map(tuple, covectors))
    pairs = zip(every.values(q).T, every.periodic.tolist(), strict=True)
    shared = np.stack([_share_a_value(column, turns) for column, turns in pairs], axis=1)
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
    sharp = [
        values if all(map(_is_simple, values)) else sharp_values(problem, linear, values, q[members[0]], WIDTH)
        for values, members in met.items()
    ]
    single = {m: m.index(1) for m in conditions if sum(map(abs, m)) == 1}
    pinned, relations = tuple(single.values()), tuple(m for m in conditions if m not in single)
    coupled = tuple(j for j in range(problem.n) if any(m[j] for m in relations))
    free = tuple(j for j in range(problem.n) if j not in pinned and j not in coupled)
    signature = Signature(len(linear), pinned, free, coupled, relations)
    row = Row(linear, (), (), signature, FamilyEvidence(ObtainedFrom.SHARED_VALUES))
    return complete_rows(problem, row, sharp, rng)


def _is_simple(value: float) -> bool:
    return abs(value / SIMPLE - round(value / SIMPLE)) <= 1e-12


def _share_a_value(values: Array, periodic: bool) -> Mask:
    """(N,) whether at least `SHARED` points have a value within `WIDTH`."""
    labels = clusters(values, WIDTH, periodic=periodic)
    return np.asarray(np.bincount(labels)[labels] >= SHARED)


def smooth(
    problem: Problem, inspection: Inspection, members: NDArray[np.int64], rng: np.random.Generator
) -> bool:
    """Whether ker D is the tangent space: a step ε along it is ε² away from the set, not ε as where families meet."""
    chosen = members[:: max(1, len(members) // 8)][:8]
    q = inspection.q[chosen]
    step = _tangent_steps(inspection.tangent[chosen], rng, 0.01)
    back = refine(problem.robot, q + step, problem.corank, task=problem.task, tolerances=problem.tolerances)
    way = np.linalg.norm(wrap(back.q - q - step), axis=1)
    return bool(np.median(way) < 0.2 * 0.01)


def _tangent_steps(tangent: Array, rng: np.random.Generator, length: float | Array) -> Array:
    """(N, n) random steps of given lengths along tangent spaces, by projectors (N, n, n)."""
    step = np.einsum("nij,nj->ni", tangent, rng.standard_normal(tangent.shape[:2]))
    return np.asarray(step * (length / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-300)))


@dataclass(eq=False)
class FamilyPoints:
    """Points of one family with one combination of values; makes more when asked.

    Attributes:
        problem: the arm, and the corank.
        row: the linear conditions of the family, one value each; its equations are sought.
        q: (N, n) points so far, in no special order: a fit needs them spread over the family.
        tangent: (N, n, n) projectors on the tangent space there.
        rng: of steps, starts and tests.
    """

    problem: Problem
    row: Row
    q: Array
    tangent: Array
    rng: np.random.Generator
    exhausted: bool = field(default=False)

    def __call__(self, count: int) -> Array:
        """At least `count` points, somewhat more where they are there, or all that can be had."""
        for _ in range(STEPS):
            if len(self.q) >= count or self.exhausted:
                break
            self._more(count)
        return self.q[: count + 150]

    def _more(self, count: int) -> None:
        problem, batch = self.problem, min(max(2 * (count - len(self.q)), 64), 2000)
        base = self.rng.integers(0, len(self.q), size=batch)
        way = _tangent_steps(self.tangent[base], self.rng, self.rng.uniform(0.1, 1.0, size=(batch, 1)))
        solved = refine(
            problem.robot, self.q[base] + way, problem.corank, task=problem.task, tolerances=problem.tolerances
        )
        inspection = inspect(problem, verify_points(problem, solved.converged))
        same = np.array([signature == self.row.signature for signature in inspection.signatures], dtype=np.bool_)
        same &= inspection.sigma[:, problem.rank] <= 1e-12
        same &= (np.abs(self.row.linear.deviation(inspection.q, np.array(self.row.combinations[0]))) < SAME).all(axis=1)
        self.exhausted = bool(same.sum() < 0.02 * batch)
        self.q = np.concatenate([self.q, inspection.q[same]])
        self.tangent = np.concatenate([self.tangent, inspection.tangent[same]])


def minors(
    problem: Problem, row: Row, joints: tuple[int, ...], highest: int, rng: np.random.Generator
) -> list[Equation]:
    """Minors of full height as equations in turning joints, the short ones first.

    Corank ≥ 1 means that every minor of full height vanishes. A minor has harmonics up to 2 in every angle (3 for tasks
    whose columns depend on the reference point), so that its values on a grid of 5 (7) angles per joint give all its
    coefficients by a discrete Fourier transform, without any fit. Minors are long where the arm is generic, and an
    irreducible condition is a factor of them at best; but together they cut off whatever is not singular.

    Args:
        problem: the arm; only corank 1 of a task of full rank has such minors.
        row: linear conditions with one value each; joints that they pin are put there.
        joints: from 0; the other joints stand at random values, which is right for joints the family leaves free.
        highest: twice the largest harmonic.
        rng: for the joints that are left free.
    """
    robot, task, shape = problem.robot, problem.task, (highest + 1,) * len(joints)
    turning = bool(joints) and bool(robot.periodic[list(joints)].all())
    if not turning or problem.rank + 1 != task.m or robot.n < task.m or np.prod(shape) > GRID:
        return []
    grid = np.indices(shape).reshape(len(joints), -1).T * (2 * np.pi / (highest + 1))
    q = np.repeat(problem.random(1, rng), len(grid), axis=0)
    q[:, joints] = grid
    q = row.linear.place(q, np.repeat(np.array(row.combinations), len(grid), axis=0), rng)
    jacobian = np.asarray(task_jacobian(robot, q, task))
    equations = []
    for columns in combinations(range(robot.n), task.m):
        values = np.linalg.det(jacobian[:, :, columns]).reshape(shape)
        if np.abs(values).max() >= 1e-13:
            equations.append(_equation_of(np.fft.fftn(values) / values.size, joints, robot.n))
    short = [equation for equation in equations if len(equation.terms) <= LONGEST]
    return sorted(short, key=lambda equation: len(equation.terms))


def _equation_of(waves: NDArray[np.complex128], joints: tuple[int, ...], n: int) -> Equation:
    """Σ c·e^{i m·q} with c(−m) = conj c(m), as `fftn` orders it, as cosines and sines in the given joints of n."""
    floor, zero, size = NOISE * np.abs(waves).max(), (0,) * n, len(waves)
    terms = []
    for index in zip(*np.nonzero(np.abs(waves) > floor), strict=True):
        harmonics = np.zeros(n, dtype=np.int64)
        harmonics[list(joints)] = [2 * i if 2 * i < size else 2 * (i - size) for i in index]
        wave, c = tuple(harmonics.tolist()), complex(waves[index])
        if wave == zero:
            terms.append(Term(c.real, "cos", wave, zero))
        elif wave > zero:
            pairs = ((2 * c.real, "cos"), (-2 * c.imag, "sin"))
            terms += [Term(part, kind, wave, zero) for part, kind in pairs if abs(part) > floor]

    def place(term: Term) -> tuple[float, tuple[Any, ...], str]:
        return sum(map(abs, map(float, term.harmonics))), term.harmonics, term.kind

    return normalised_equation(sorted(terms, key=place))


def fitted_equations(source: FamilyPoints, work: float) -> tuple[Equation, ...] | None:
    """Sound equations of the coupled joints of a family with one combination of its linear values.

    Args:
        source: points of the family.
        work: that may be spent on fits.

    Returns:
        The equations, or None where they are out of reach.
    """
    problem, row, need = source.problem, source.row, source.row.signature.residual
    fit = _fit_problem(source, work)
    moving = tuple(j for j in row.signature.coupled if j not in row.linear.pivots)
    bound = circuits(source.tangent[:SEED], moving)
    fitted = (equation for circuit in bound if (equation := hypersurface(fit, circuit)) is not None)
    chosen, spare = _independent(source, fitted)
    reached = _rank(source, chosen)
    if reached > need:  # more than the signature promises: families meet here
        return None
    if reached == need:
        sound = _without_strangers(source, chosen, spare)
        if sound is None:
            more = minors(problem, row, moving, fit.highest, source.rng)
            holding = (equation for equation in more if holds(equation, source.q))
            sound = _without_strangers(source, chosen, [*spare, *holding])
        if sound is not None:
            return sound
    if len(moving) > 1:
        return _from_all_joints(source, fit, moving)
    return None


def _fit_problem(source: FamilyPoints, work: float) -> FitProblem:
    """What fits of a family stand on."""
    problem = source.problem
    kinds: tuple[Kind, ...] = tuple(
        "angle" if periodic else "length" if joint.kind is JointKind.PRISMATIC else "both"
        for joint, periodic in zip(problem.robot.variables, problem.robot.periodic, strict=True)
    )
    return FitProblem(source, problem.n, kinds, 4 if problem.task.m == 6 else 6, work, problem.tolerances)


def _independent(source: FamilyPoints, equations: Iterable[Equation]) -> tuple[list[Equation], list[Equation]]:
    """Equations that raise the rank of the gradients, until it is the codimension, and those before that do not."""
    chosen: list[Equation] = []
    spare: list[Equation] = []
    for equation in equations:
        raised = _rank(source, [*chosen, equation])
        (chosen if raised > _rank(source, chosen) else spare).append(equation)
        if raised >= source.row.signature.residual:
            break
    return chosen, spare


def _from_all_joints(source: FamilyPoints, fit: FitProblem, joints: tuple[int, ...]) -> tuple[Equation, ...] | None:
    """Low-degree equations in all joints together."""
    need = source.row.signature.residual
    for basis in vanishing_spaces(fit, joints):
        rank = _rank(source, basis)
        if rank > need:
            return None
        chosen, _ = _independent(source, basis)
        spare = [equation for equation in basis if equation not in chosen]
        if rank == need:
            sound = _without_strangers(source, chosen, spare)
        else:
            sound = None
        if sound is not None:
            return sound
    return None


def _without_strangers(
    source: FamilyPoints, chosen: Sequence[Equation], spare: Sequence[Equation]
) -> tuple[Equation, ...] | None:
    """The equations, with spare ones added until no stranger is left: those first that most strangers do not satisfy.
    """
    chosen, spare = list(chosen), list(spare)
    for _ in range(EXTRA + 1):
        tested, strangers = _strangers(source, chosen)
        if not tested:
            return None
        if not len(strangers):
            return tuple(chosen)
        share = [float(np.mean(np.abs(equation(strangers)) > 1e-4)) for equation in spare]
        separating = [i for i, s in enumerate(share) if s > 0.2 and s > 0.8 * max(share)]
        if not separating:
            return None
        chosen.append(spare.pop(separating[0]))
    return None


def _rank(source: FamilyPoints, equations: Sequence[Equation]) -> int:
    """Codimension the equations give within the linear conditions: gradient rank at most of a few points."""
    if not equations:
        return 0
    slopes = System(tuple(equations)).jacobian(source.q[:SEED]) @ source.row.linear.kept_motions
    return int(np.median((np.linalg.svd(slopes, compute_uv=False) > 1e-6).sum(axis=1)))


def _strangers(source: FamilyPoints, equations: Sequence[Equation]) -> tuple[int, Array]:
    """Solutions from random starts, and those of them that are not singular; many starts, and starts at special places,
    before it says none."""
    problem, row, tested = source.problem, replace(source.row, residual=tuple(equations)), 0
    strangers = np.zeros((0, problem.n))
    for count in (200, 800):
        q, good = row.sample(problem, count, source.rng)
        q = q[good]
        strangers = q[problem.sigma(q)[:, problem.rank] > problem.tolerances.singular]
        tested += len(q)
        if len(strangers):
            return tested, strangers
    for _ in range(ROUNDS if tested else 0):
        _, strangers = solve_at_special_values(problem, row, {}, source.rng)
        if len(strangers):
            break
    return tested, strangers
