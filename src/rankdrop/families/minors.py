"""Minors of the task Jacobian as trigonometric polynomials, interpolated on a grid: equations of last resort.

Corank ≥ 1 means that every minor of full height vanishes. A minor has harmonics up to 2 in every angle (3 for tasks
whose columns depend on the reference point), so that its values on a grid of 5 (7) angles per joint give all its
coefficients by a discrete Fourier transform, without any fit. Minors are long where the arm is generic, and an
irreducible condition is a factor of them at best; but together they cut off whatever is not singular.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.linear import Linear, Values
from rankdrop.families.sampling import Setting
from rankdrop.family.equation import Equation, Term, normalised
from rankdrop.kinematics import task_jacobian
from rankdrop.robot.model import Array, JointKind

GRID = 20_000  # grid points at most
LONGEST = 1500  # terms of an equation at most
NOISE = 1e-12  # coefficients below this share of the largest are rounding


def minors(
    setting: Setting, linear: Linear, values: Values, joints: tuple[int, ...], highest: int, rng: np.random.Generator
) -> list[Equation]:
    """Minors of full height on the given combination of values, as equations in the joints; short ones first.

    Args:
        setting: the arm; only corank 1 of a task of full rank has such minors.
        linear, values: the linear conditions; joints that they pin are put at their values.
        joints: from 0; the other joints stand at random values, which is right for joints the family leaves free.
        highest: twice the largest harmonic.
        rng: for the joints that are left free.
    """
    robot, task = setting.robot, setting.task
    steps = [highest + 1 if robot.periodic[j] else 4 for j in joints]
    plain = all(robot.periodic[j] or robot.variables[j].kind is JointKind.PRISMATIC for j in joints)
    if not plain or setting.rank + 1 != task.m or robot.n < task.m or np.prod(steps) > GRID or not joints:
        return []
    nodes = [_nodes(step, bool(robot.periodic[j])) for step, j in zip(steps, joints, strict=True)]
    grid = np.stack(np.meshgrid(*nodes, indexing="ij"), axis=-1).reshape(-1, len(joints))
    q = np.repeat(setting.random(1, rng), len(grid), axis=0)
    q[:, joints] = grid
    q = linear.place(q, np.repeat(np.array(values).reshape(1, -1), len(grid), axis=0), rng) if len(linear) else q
    j = np.asarray(task_jacobian(robot, q, task))
    found = []
    for columns in combinations(range(robot.n), task.m):
        equation = _interpolated(np.linalg.det(j[:, :, columns]).reshape(steps), nodes, setting, joints)
        if equation is not None and len(equation.terms) <= LONGEST:
            found.append(equation)
    return sorted(found, key=lambda equation: len(equation.terms))


def _nodes(count: int, periodic: bool) -> Array:
    nodes = np.arange(count) * (2 * np.pi / count) if periodic else np.linspace(-1.0, 1.0, count)
    return np.asarray(nodes, dtype=np.float64)


def _interpolated(
    values: Array, nodes: list[Array], setting: Setting, joints: tuple[int, ...]
) -> Equation | None:
    """The polynomial with these values on the grid; None for the zero polynomial."""
    size = np.abs(values).max()
    if size < 1e-13:
        return None
    orders: list[NDArray[np.int64]] = []
    c = values.astype(np.complex128)
    for axis, (node, joint) in enumerate(zip(nodes, joints, strict=True)):
        periodic = bool(setting.robot.periodic[joint])
        order = np.arange(len(node)) - (len(node) // 2 if periodic else 0)
        basis = np.exp(1j * np.outer(node, order)) if periodic else node[:, None] ** order
        c = np.moveaxis(np.tensordot(np.linalg.inv(basis), c, axes=(1, axis)), 0, axis)
        orders.append(order)
    return _real(c, orders, setting, joints)


def _real(
    c: NDArray[np.complex128], orders: list[NDArray[np.int64]], setting: Setting, joints: tuple[int, ...]
) -> Equation | None:
    """Σ c·e^{i m·q}·q^p with c(−m) = conj c(m), as cosines and sines."""
    n, periodic = setting.robot.n, setting.robot.periodic
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

