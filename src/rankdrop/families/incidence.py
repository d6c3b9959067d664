"""On which families does a configuration lie, and how far is it from each?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.families.record import Family
from rankdrop.families.rescaling import family_in_metres
from rankdrop.formula.equation import System
from rankdrop.kinematics import one_configuration
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_metres, into_metres, task_in_metres

_ON = 1e-9  # |f|/|∇f| and √|f| of every equation below this: on the family, no way to walk [rad]
_WITHIN = 1e-2  # longest way to a family that is walked [rad]
_LOOKS = 6  # points looked at on such a way


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
        if family.equations and 1 <= family.corank <= corank:
            if family.corank == problem.corank:  # most often: what the problem keeps serves again
                problem_of_corank = problem
            else:
                problem_of_corank = problem.at(family.corank)
            length = float(ways_to(problem_of_corank, family_in_metres(family, robot).system, at[None])[0])
            if length < inf:
                met.append(Incidence(family, length, source))
    met.sort(key=lambda incidence: (-incidence.family.corank, incidence.family.dimension, incidence.residual))
    return tuple(met)


def ways_to(
    problem: Problem, system: System, q: Array, within: float = _WITHIN, zero: float | None = None
) -> Array:
    """Distances from configurations to a zero set that is of the problem's corank.

    Args:
        problem: the arm, and the corank.
        system: the equations of the set; without any it is everything.
        q: (N, n).
        within: longest way that is walked [rad].
        zero: σ at or below this is zero where sheets cross; None for `singular`.

    Returns:
        (N,) [rad]: at most `explained`, or longer where σ is zero on the whole way; else inf.
    """
    if not system.equations or not len(q):
        return np.zeros(len(q))
    f, a = system.linear(q)
    scaled = a * problem.scale
    size, slope = np.abs(f), np.sqrt(np.add.reduce(scaled * scaled, axis=-1))
    first = np.minimum(size / np.maximum(slope, 1e-300), np.sqrt(size)).max(axis=1)
    result = np.where(first <= _ON, first, inf)
    rows = np.flatnonzero((first > _ON) & (first <= 4 * within))
    if not len(rows):
        return np.asarray(result)
    lengths, feet = system.nearest(q[rows], within)
    crossing = np.flatnonzero((lengths > problem.tolerances.explained) & np.isfinite(lengths))
    if not len(crossing):
        result[rows] = lengths
        return np.asarray(result)
    part = np.linspace(0.0, 1.0, _LOOKS)[:, None, None]
    sigma = problem.sigma((1 - part) * q[rows[crossing]] + part * feet[crossing])[..., problem.rank]
    lengths[crossing[(sigma > (problem.tolerances.singular if zero is None else zero)).any(axis=0)]] = inf
    result[rows] = lengths
    return np.asarray(result)
