"""Do solutions of a family's equations lose rank? Tested at solutions from random starts, and at special places.

What else solves the equations are parts of lower dimension, which no random start finds. Equations of coupled joints
may all vanish where some joints stand at special values: A·cos θ4 + B·sin θ6 with A and B long, say, at θ4 = ±π/2,
θ6 = 0, whatever the others do. Newton's method from random starts ends on the family itself, almost surely. So some
joints are held at right angles, or where other rows stand, and the equations are solved in the others. A solution
there that is not singular belongs to no family: the row is not sound, though random starts say so. Such a part may
also be where all equations together lead from random starts, though the first few of them lead to the family.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import pi

import numpy as np

from rankdrop.families.inspection import HIGHER
from rankdrop.families.linear_conditions import Linear
from rankdrop.families.record import Check
from rankdrop.families.row import STARTS, Row, least_slope, solve_equations
from rankdrop.formula.equation import System
from rankdrop.lists import flat_map
from rankdrop.problem import Problem
from rankdrop.robot.model import Array

RIGHT = (0.0, pi, pi / 2, -pi / 2)
SINGLE, SEVERAL = 24, 40  # sets of one joint held, and of two or more, at most
EACH = 8  # random starts for each
LOOSE = 64  # random starts with no joint held
CERTAIN = 1e-14  # |f| at their solutions: where sheets touch, a point near all of them comes to 1e-12 and is no zero
REGULAR = 1e-2
"""σ above this is not zero, however badly the solution is known: |f| ≤ 1e-12 leaves 1e-3 rad at a fourfold zero."""


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
    q, slope, solved = solve_equations(start, system.equations, codimension, np.eye(problem.n))
    q = q[solved & (slope > least_slope(slope[solved]))]
    if not len(q):
        return Check(0, 0), q
    sigma = problem.sigma(q)[:, problem.rank]
    singular = sigma <= problem.tolerances.singular
    if exact:
        regular = (sigma > HIGHER) & system.zero(q)
    else:
        regular = ~singular
    return Check(int((singular | regular).sum()), int(singular.sum())), q[regular]


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
