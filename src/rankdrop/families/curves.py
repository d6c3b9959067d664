"""Along lines and curves of joint space: singular values as one joint is swept, and the singular set traced.

The set is a curve where so many joints are held that nothing larger is left (AM Figure 5).

At a singular configuration of corank k the block F = U₂ᵀJV₂ vanishes, and a joint motion Δ keeps it zero to first order
where D(Δ) = 0. With all but a few joints held, that kernel is one direction: a step along it, then Gauss–Newton on F
back to the set, until the curve is where it began.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import OptionError
from rankdrop.families.searching import search
from rankdrop.kinematics import one_configuration
from rankdrop.local.block import generic_rank, sampling_box, singular_values
from rankdrop.problem import Mask, Problem
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.solve import Linear, newton, trace
from rankdrop.task import Task, resolve_task


@dataclass(frozen=True, eq=False)
class Sweep:
    """One joint swept through a configuration.

    Attributes:
        number: the joint, from 1.
        unit: "rad" or "m".
        at: its value in the configuration.
        values: (N,) its values, increasing; `at` is one of them.
        sigma: (N, r) singular values σ_1 … σ_r there, descending, r the generic rank.
    """

    number: int
    unit: str
    at: float
    values: Array
    sigma: Array


def sweeps(robot: Robot, q: ArrayLike, task: Task, count: int = 121) -> tuple[Sweep, ...]:
    """Singular values with each joint swept in turn: a whole turn about q, or the travel of a slide.

    Args:
        robot, task: the arm.
        q: (n,) [rad, m].
        count: values of each joint, one more where the configuration's own is not among them.

    Returns:
        One `Sweep` per joint.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
    """
    centre = one_configuration(robot, q)
    low, high = sampling_box(robot, task, limits=False)
    rank = generic_rank(robot, task)
    found = []
    for j, joint in enumerate(robot.variables):
        begin, end = (-np.pi, np.pi) if robot.periodic[j] else (min(low[j], centre[j]), max(high[j], centre[j]))
        values = np.union1d(np.linspace(begin, end, count), [centre[j]])
        line = np.repeat(centre[None], len(values), axis=0)
        line[:, j] = values
        sigma = singular_values(robot, line, task)[:, :rank]
        found.append(Sweep(j + 1, joint.unit, float(centre[j]), values, sigma))
    return tuple(found)


_ON = 1e-11  # |F| at a point of the set [1]
_LONGEST = 200.0  # of a curve that does not come to an end [rad]
_CORRECTIONS = 12


@dataclass(frozen=True, eq=False)
class Curve:
    """One traced piece of the singular set.

    Attributes:
        q: (N, n) configurations in order; angles run on, they are not wrapped [rad].
        closed: it came back to its start (angles modulo 2π).
        length: in joint space [rad].
        windings: (n,) turns that each joint makes on the way round; zero where not closed.
    """

    q: Array
    closed: bool
    length: float
    windings: tuple[int, ...]


def singular_curves(
    robot: Robot, joints: Sequence[int], *, held: ArrayLike | None = None, corank: int = 1,
    task: Task | str | None = None, starts: int = 200, step: float = 0.05,
) -> tuple[Curve, ...]:  # fmt: skip
    """Every curve of singular configurations that random starts meet, longest first.

    Args:
        robot: an arm of revolute joints.
        joints: numbers (from 1) of those that move; the others stay where `held` has them.
        held: (n,) configuration [rad]; zeros if None.
        corank: task freedoms lost.
        task: name, `Task`, or None for the task the arm is made for.
        starts: of the search that gives the first points.
        step: between two points of a curve [rad].

    Raises:
        OptionError: a joint that does not turn, or that there is not.
        ConfigurationError: `held` is not one configuration of this arm.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> [(curve.closed, curve.windings) for curve in singular_curves(open_robot("almarkhi4"), (2, 3, 4))][0]
        (True, (0, 1, 0, 0))
    """
    moving = [number - 1 for number in joints]
    if not moving or not set(moving) <= set(range(robot.n)):
        raise OptionError("there is no such joint", got=list(joints), allowed=f"1 … {robot.n}")
    if any(robot.variables[j].kind is not JointKind.REVOLUTE for j in range(robot.n)):
        raise OptionError("curves are traced of revolute joints only", where=f"robot {robot.name!r}")
    resolved = resolve_task(task, robot)
    base = one_configuration(robot, np.zeros(robot.n) if held is None else held)
    problem = Problem(robot, resolved, corank)

    def linear(x: Array) -> tuple[Array, Array]:
        """F as a vector, and its derivative by the joints that move."""
        q = np.repeat(base[None], len(x), axis=0)
        q[:, moving] = x
        at = problem.block(q)
        return at.f.reshape(len(x), -1), at.d[..., moving].reshape(len(x), -1, len(moving))

    def unsolved(x: Array) -> tuple[Mask, Array, Array]:
        f, slope = linear(x)
        return np.abs(f).max(axis=1) > _ON, f, slope

    found: list[Curve] = []
    starts_found = search(robot, corank, task=resolved, starts=starts).converged[:, moving]
    for x in newton(unsolved, starts_found, iterations=_CORRECTIONS) if len(moving) > 1 else ():
        on = bool(np.abs(linear(x[None])[0]).max() <= _ON)
        if not on or any(_distance(curve.q[:, moving], x) < step for curve in found):
            continue
        curve = _traced(linear, base, moving, x, step)
        if curve is not None:
            found.append(curve)
    return tuple(sorted(found, key=lambda curve: -curve.length))


def _traced(linear: Linear, base: Array, moving: list[int], x: Array, step: float) -> Curve | None:
    """From x until it is met again; None where the set is not a smooth curve."""
    line, closed = trace(linear, x, step, zero=_ON, most=int(_LONGEST / step))
    if not closed and len(line) <= int(_LONGEST / step):
        return None
    q = np.repeat(base[None], len(line), axis=0)
    q[:, moving] = line
    turns = np.round((q[-1] - q[0]) / (2 * np.pi)).astype(int) if closed else np.zeros(len(base), dtype=int)
    if turns.any() and turns[np.flatnonzero(turns)[0]] < 0:
        q, turns = q[::-1].copy(), -turns
    q.flags.writeable = False
    length = float(np.linalg.norm(np.diff(q, axis=0), axis=1).sum())
    return Curve(q, closed, length, tuple(int(turn) for turn in turns))


def _distance(points: Array, point: Array) -> float:
    """Smallest distance, angles modulo 2π."""
    off = points - point
    return float(np.linalg.norm(off - 2 * np.pi * np.round(off / (2 * np.pi)), axis=1).min())
