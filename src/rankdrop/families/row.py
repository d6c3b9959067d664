"""The conditions of one family in an arm's numbers: values of pinned joints and relations, equations of coupled joints.

A row is made of the conditions of a derived family (`row_of`) or of those that are fitted to points. Its equations are
solved from random starts, and a point lies on it where it is near to such a solution.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.descent import ROUNDING, descents
from rankdrop.families.evidence import FamilyEvidence, ObtainedFrom
from rankdrop.families.incidence import ways_to
from rankdrop.families.inspection import Signature
from rankdrop.families.linear_conditions import Linear, Values, canonical
from rankdrop.families.record import Family
from rankdrop.formula.equation import Equation, Mask, System, normalised_equation
from rankdrop.lists import flat_map
from rankdrop.problem import Problem, wrap
from rankdrop.robot.model import Array

CONDITIONED = 1e-3  # solutions where the equations' Jacobian has a smaller singular value are too inexact to judge σ
FLAT = 1e-7  # where no slope reaches `CONDITIONED` but one exceeds this, slopes are measured by the largest
ROUNDED = 10.0  # times `target`: σ below this tells nothing
NEAR = 1e-3  # longest way from a point to a row that is walked [rad]
FURTHER = 1e-11  # |f| of the equations beyond the independent ones at a solution
STARTS = 400  # random starts from which equations are solved
VALUE_ERROR = 1e-10  # rad: so far 1e-16 in the coefficients of all but flat conditions moves their solutions
MOST_VALUES = 8  # values at which a joint still counts as pinned
SAME_VALUE = 1e-8  # values closer than this are one [rad, m]; micrometres of an offset move values by 1e-6
SAMPLED = 64  # solutions from which the values of a family's joints are read


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
            q, slope, good = solve_equations(q, self.residual, self.signature.residual, self.linear.kept_motions)
            good &= slope > least_slope(slope[good])
        good &= problem.within_limits(q)
        return q.reshape(len(values), each, problem.n), good.reshape(len(values), each)

    def sample(self, problem: Problem, each: int, rng: np.random.Generator) -> tuple[Array, Mask]:
        """(V, each, n) points on up to 64 combinations, and (V, each) whether they are good: `solve`."""
        return self.solve(problem, self.combinations[:64], each, rng)


def solve_equations(
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


def least_slope(slope: Array) -> float:
    """Slope below which a solution is known too inexactly: of equations that are flat everywhere a share of theirs."""
    best = float(slope.max(initial=0.0))
    return CONDITIONED * (best if FLAT < best < CONDITIONED else 1.0)

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
