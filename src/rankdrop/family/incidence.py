"""Which family: the families that a configuration lies on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.family.equation import Equation, System
from rankdrop.family.record import Family, rescaled, slides_of
from rankdrop.kinematics import one_configuration
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_metres, into_metres, metre_exponent, task_in_metres

SOLVED = 1e-9  # |f|/|∇f| and √|f| of every equation below this: on the family, no way to walk [rad]
WITHIN = 1e-2  # longest way to a family that is walked [rad]
STEPS = 6  # points looked at on such a way


@dataclass(frozen=True, slots=True)
class Incidence:
    """A family and how near a configuration is to it.

    Attributes:
        family: from an atlas, or found on the spot.
        residual: distance to it [rad; metres divided by the length scale]: the way walked to it by Gauss–Newton.
        source: where the family is from: "catalogue", "analysis" or "on the spot".
    """

    family: Family
    residual: float
    source: str


def families_at(
    families: Sequence[Family],
    robot: Robot,
    q: ArrayLike,
    task: Task,
    tolerances: Tolerances = DEFAULT,
    source: str = "analysis",
) -> tuple[Incidence, ...]:
    """The families that a singular configuration lies on, the one that says most about it first.

    A family holds at q when the way from q to its zero set, walked by Gauss–Newton, is at most `explained`. Where
    sheets cross, σ is of higher order in the distance and q is known less well: then a family holds, too, when σ stays
    zero within the tolerance on the whole way, because nothing tells q from its foot on the family.

    Order: corank, high first; then dimension, small first (a family inside another says more); then distance. A family
    whose corank is higher than that of q does not hold there. Where the first corank is below that of q, larger
    families meet at q and none of those given is of its corank.

    Args:
        families: of this arm and task; those without equations never hold.
        robot: the arm.
        q: (n,) configuration [rad, m].
        task: from `resolve_task`.
        tolerances: `singular` and `explained`.
        source: what `Incidence.source` says.

    Raises:
        ConfigurationError: q is not one configuration of this arm.

    Example:
        >>> from rankdrop.families.table import families
        >>> from rankdrop.families.searching import search
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("scara")
        >>> known = families(search(arm, 1, starts=100)).families
        >>> [met.family.dimension for met in families_at(known, arm, [0.3, 0.0, 0.1, 0.2], resolve_task(None, arm))]
        [3]
    """
    configuration = one_configuration(robot, q)
    problem = Problem(in_metres(robot), task_in_metres(task, robot), tolerances=tolerances)
    at = into_metres(robot, configuration)
    sigma, generic = problem.sigma(at), problem.generic_rank
    corank = generic - int((sigma[:generic] > tolerances.singular).sum())
    met = []
    for family in families:
        if not family.equations or not 1 <= family.corank <= corank:
            continue
        system = _system(family.equations, robot) if metre_exponent(robot) else family.system
        length = _way(problem.at(family.corank), system, at)
        if length < inf:
            met.append(Incidence(family, length, source))
    return tuple(sorted(met, key=lambda one: (-one.family.corank, one.family.dimension, one.residual)))


def on_one_of(
    families: Sequence[Sequence[Equation]], robot: Robot, q: Array, task: Task, tolerances: Tolerances
) -> bool:
    """Whether q (n,) loses rank and lies on one of several zero sets, each given by all of its equations."""
    problem = Problem(in_metres(robot), task_in_metres(task, robot), 1, tolerances)
    at = into_metres(robot, q)
    return bool(problem.singular(at[None])[0]) and any(
        _way(problem, _system(equations, robot), at) < inf for equations in families
    )


def _system(equations: Sequence[Equation], robot: Robot) -> System:
    """The equations of a family as they are of `in_metres(robot)`."""
    power = -metre_exponent(robot)
    return System(tuple(rescaled(one, slides_of(robot), power) if power else one for one in equations))


def _way(problem: Problem, system: System, q: Array) -> float:
    """Distance from q to a family of the problem's corank that holds at q; inf where it does not hold."""
    f, a = system.linear(q[None])
    size, slope = np.abs(f[0]), np.linalg.norm(a[0] * problem.scale, axis=1)
    first = np.minimum(size / np.maximum(slope, 1e-300), np.sqrt(size))
    if first.max() <= SOLVED:
        return float(first.max())
    if first.max() > 4 * WITHIN:
        return inf
    lengths, feet = system.nearest(q[None], WITHIN)
    length = float(lengths[0])
    if length <= problem.tolerances.explained or not np.isfinite(length):
        return length
    part = np.linspace(0.0, 1.0, STEPS)[:, None]
    return length if bool(problem.singular((1 - part) * q + part * feet[0]).all()) else inf
