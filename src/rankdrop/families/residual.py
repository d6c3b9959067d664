"""The equations that bind the coupled joints of a family: fitted circuit by circuit until they are sound.

Equations of last resort are minors of the task Jacobian as trigonometric polynomials, interpolated on a grid. Corank ≥
1 means that every minor of full height vanishes. A minor has harmonics up to 2 in every angle (3 for tasks whose
columns depend on the reference point), so that its values on a grid of 5 (7) angles per joint give all its coefficients
by a discrete Fourier transform, without any fit. Minors are long where the arm is generic, and an irreducible condition
is a factor of them at best; but together they cut off whatever is not singular.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.fit import (
    Budget,
    FitProblem,
    Kind,
    circuits,
    holds,
    hypersurface,
    vanishing_spaces,
)
from rankdrop.families.linear import FamilyPoints, Linear, Values, gathered_tangent
from rankdrop.families.row import elsewhere, on_combinations
from rankdrop.family.equation import Equation, System, Term, normalised
from rankdrop.kinematics import task_jacobian
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, JointKind

GRID = 20_000  # grid points at most
LONGEST = 1500  # terms of an equation at most
NOISE = 1e-12  # coefficients below this share of the largest are rounding


def minors(
    problem: Problem, linear: Linear, values: Values, joints: tuple[int, ...], highest: int, rng: np.random.Generator
) -> list[Equation]:
    """Minors of full height on the given combination of values, as equations in the joints; short ones first.

    Args:
        problem: the arm; only corank 1 of a task of full rank has such minors.
        linear, values: the linear conditions; joints that they pin are put at their values.
        joints: from 0; the other joints stand at random values, which is right for joints the family leaves free.
        highest: twice the largest harmonic.
        rng: for the joints that are left free.
    """
    robot, task = problem.robot, problem.task
    steps = [highest + 1 if robot.periodic[j] else 4 for j in joints]
    plain = all(robot.periodic[j] or robot.variables[j].kind is JointKind.PRISMATIC for j in joints)
    if not plain or problem.rank + 1 != task.m or robot.n < task.m or np.prod(steps) > GRID or not joints:
        return []
    nodes: list[Array] = [
        np.linspace(0.0, 2 * np.pi, step, endpoint=False) if robot.periodic[j] else np.linspace(-1.0, 1.0, step)
        for step, j in zip(steps, joints, strict=True)
    ]
    grid = np.stack(np.meshgrid(*nodes, indexing="ij"), axis=-1).reshape(-1, len(joints))
    q = np.repeat(problem.random(1, rng), len(grid), axis=0)
    q[:, joints] = grid
    q = linear.place(q, np.repeat(np.array(values).reshape(1, -1), len(grid), axis=0), rng) if len(linear) else q
    j = np.asarray(task_jacobian(robot, q, task))
    found = []
    for columns in combinations(range(robot.n), task.m):
        equation = _interpolated(np.linalg.det(j[:, :, columns]).reshape(steps), nodes, problem, joints)
        if equation is not None and len(equation.terms) <= LONGEST:
            found.append(equation)
    return sorted(found, key=lambda equation: len(equation.terms))


def _interpolated(
    values: Array, nodes: list[Array], problem: Problem, joints: tuple[int, ...]
) -> Equation | None:
    """The polynomial with these values on the grid; None for the zero polynomial."""
    size = np.abs(values).max()
    if size < 1e-13:
        return None
    orders: list[NDArray[np.int64]] = []
    c = values.astype(np.complex128)
    for axis, (node, joint) in enumerate(zip(nodes, joints, strict=True)):
        periodic = bool(problem.robot.periodic[joint])
        order = np.arange(len(node)) - (len(node) // 2 if periodic else 0)
        basis = np.exp(1j * np.outer(node, order)) if periodic else node[:, None] ** order
        c = np.moveaxis(np.tensordot(np.linalg.inv(basis), c, axes=(1, axis)), 0, axis)
        orders.append(order)
    return _real(c, orders, problem, joints)


def _real(
    c: NDArray[np.complex128], orders: list[NDArray[np.int64]], problem: Problem, joints: tuple[int, ...]
) -> Equation | None:
    """Σ c·e^{i m·q}·q^p with c(−m) = conj c(m), as cosines and sines."""
    n, periodic = problem.n, problem.robot.periodic
    floor = NOISE * np.abs(c).max()
    terms = []
    for index in zip(*np.nonzero(np.abs(c) > floor), strict=True):
        harmonics, powers = [0] * n, [0] * n
        for joint, order, i in zip(joints, orders, index, strict=True):
            (harmonics if periodic[joint] else powers)[joint] = int(order[i])
        leading = next((h for h in harmonics if h), 0)
        if leading < 0:
            continue
        factor = 2.0 if leading else 1.0
        wave = tuple(2 * h for h in harmonics)
        for part, kind in ((factor * c[index].real, "cos"), (-factor * c[index].imag, "sin")):
            if abs(part) > floor and (leading or kind == "cos"):
                terms.append(Term(float(part), kind, wave, tuple(powers)))
    terms.sort(key=lambda t: (sum(map(abs, t.harmonics)) + 2 * sum(t.powers), t.harmonics, t.powers, t.kind))
    return normalised(terms) if terms else None


EXTRA = 3  # equations beyond the codimension that may be added to cut strangers off
SEED = 12  # points at which ranks are looked at
ROUNDS = 16  # of some 100 solutions at special places: of a row of a general 8R one in 400 is regular


def residual_equations(source: FamilyPoints, budget: Budget, *, thorough: bool) -> tuple[Equation, ...] | None:
    """Sound residual equations of a family with one combination of its linear values.

    Circuits are fitted in order of size, and an equation is kept when it raises the rank of the gradients. Once the
    rank is the codimension, the equations are solved from random starts. Solutions that are not singular ("strangers":
    the equations of two circuits may meet in more than the family) are cut off by further equations. Where single
    circuits have too high a degree (projections of a curve have), low-degree equations in all joints are tried.

    Args:
        source: points of the family.
        budget: work that may be spent on fits.
        thorough: also cut strangers off, and try all joints together: much more work.

    Returns:
        The equations, or None where they are out of reach.
    """
    fit, joints = _fit_problem(source, budget)
    chosen, spare = _from_circuits(source, fit, joints)
    reached = _rank(source, chosen)
    if reached > source.signature.residual:  # more than the signature promises: families meet here
        return None
    if reached == source.signature.residual:
        equations = _cut(source, fit, chosen, spare)
        if equations is not None:
            return equations
    return _from_ideal(source, fit, joints) if thorough and len(joints) > 1 else None


def circuit_equations(source: FamilyPoints, budget: Budget) -> tuple[Equation, ...] | None:
    """The quick part of `residual_equations`: equations of single circuits where they are sound as they are."""
    fit, joints = _fit_problem(source, budget)
    chosen, _ = _from_circuits(source, fit, joints)
    if _rank(source, chosen) != source.signature.residual:
        return None
    tested, strangers = _strangers(source, chosen)
    return tuple(chosen) if tested and not len(strangers) else None


def _fit_problem(source: FamilyPoints, budget: Budget) -> tuple[FitProblem, tuple[int, ...]]:
    """What fits of a family stand on, and the joints (from 0) they bind."""
    problem = source.problem
    bound = np.abs(source.linear.covectors).sum(axis=0) > 0
    twins = tuple(one for one in problem.twins if not bound[one.first] and not bound[one.second])
    seconds = {one.second for one in twins}
    joints = tuple(j for j in source.signature.coupled if j not in source.linear.pivots and j not in seconds)
    kinds: tuple[Kind, ...] = tuple(
        "angle" if periodic else "length" if joint.kind is JointKind.PRISMATIC else "both"
        for joint, periodic in zip(problem.robot.variables, problem.robot.periodic, strict=True)
    )
    highest = 4 if problem.task.m == 6 else 6
    return FitProblem(source, problem.n, kinds, highest, budget, problem.tolerances, twins), joints


def _from_circuits(
    source: FamilyPoints, fit: FitProblem, joints: tuple[int, ...]
) -> tuple[list[Equation], list[Equation]]:
    """Equations of circuits that raise the rank of the gradients, and those that do not."""
    chosen: list[Equation] = []
    spare: list[Equation] = []
    for circuit in circuits(gathered_tangent(source.tangent[:SEED], fit.twins), joints):
        equation = hypersurface(fit, circuit)
        if equation is None:
            continue
        raised = _rank(source, [*chosen, equation])
        (chosen if raised > _rank(source, chosen) else spare).append(equation)
        if raised >= source.signature.residual:
            break
    return chosen, spare


def _separating_equations(equations: list[Equation], strangers: Array) -> list[int]:
    """Equations that tell most strangers from the family, in their own order."""
    share = [float(np.mean(np.abs(equation(strangers)) > 1e-4)) for equation in equations]
    return [i for i, s in enumerate(share) if s > 0.2 and s > 0.8 * max(share)]


def _cut(
    source: FamilyPoints, fit: FitProblem, chosen: list[Equation], spare: list[Equation]
) -> tuple[Equation, ...] | None:
    """Add equations until no stranger is left: circuits not used so far, then short minors."""
    sound = _selected(source, list(chosen), list(spare))
    if sound is not None:
        return sound
    moving = tuple(j for j in source.signature.coupled if j not in source.linear.pivots)
    more = minors(source.problem, source.linear, source.values, moving, fit.highest, source.rng)
    return _selected(source, chosen, [*spare, *(equation for equation in more if holds(equation, source.q))])


def _from_ideal(source: FamilyPoints, fit: FitProblem, joints: tuple[int, ...]) -> tuple[Equation, ...] | None:
    """Low-degree equations in all joints together."""
    need = source.signature.residual
    for basis in vanishing_spaces(fit, joints):
        chosen: list[Equation] = []
        for equation in basis:
            if _rank(source, [*chosen, equation]) > _rank(source, chosen):
                chosen.append(equation)
        if _rank(source, chosen) > need:
            return None
        if _rank(source, chosen) == need:
            sound = _selected(source, chosen, [equation for equation in basis if equation not in chosen])
            if sound is not None:
                return sound
    return None


def _selected(source: FamilyPoints, chosen: list[Equation], spare: list[Equation]) -> tuple[Equation, ...] | None:
    """Add equations of the basis until no stranger is left."""
    for _ in range(EXTRA + 1):
        tested, strangers = _strangers(source, chosen)
        if not tested:
            return None
        if not len(strangers):
            return tuple(chosen)
        told = _separating_equations(spare, strangers)
        if not told:
            return None
        chosen.append(spare.pop(told[0]))
    return None


def _rank(source: FamilyPoints, equations: list[Equation]) -> int:
    """Codimension the equations give within the linear conditions: gradient rank at most of a few points."""
    if not equations:
        return 0
    slopes = System(tuple(equations)).jacobian(source.q[:SEED]) @ source.linear.along
    return int(np.median((np.linalg.svd(slopes, compute_uv=False) > 1e-6).sum(axis=1)))


def _strangers(source: FamilyPoints, equations: list[Equation]) -> tuple[int, Array]:
    """Solutions from random starts, and those of them that are not singular; many starts, and starts at special places,
    before it says none."""
    problem, tested = source.problem, 0
    strangers = np.zeros((0, problem.n))
    for count in (200, 800):
        more, strangers = _from_random_starts(source, tuple(equations), count)
        tested += more
        if len(strangers):
            return tested, strangers
    for _ in range(ROUNDS if tested else 0):
        _, strangers = elsewhere(problem, source.linear, [source.values], tuple(equations), {}, source.rng)
        if len(strangers):
            break
    return tested, strangers


def _from_random_starts(source: FamilyPoints, equations: tuple[Equation, ...], count: int) -> tuple[int, Array]:
    """How many solutions so many random starts lead to, and those of them that are not singular."""
    problem = source.problem
    q, good = on_combinations(
        problem, source.linear, equations, source.signature.residual, [source.values], count, source.rng
    )
    q = q[good]
    return len(q), q[problem.sigma(q)[:, problem.rank] > problem.tolerances.singular]
