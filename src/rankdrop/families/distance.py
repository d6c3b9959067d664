"""How far to each family: the nearest point that satisfies a family's equations, and whether the search agrees.

A family of pinned joints only is nearest where each of them turns to its nearest value: closed form. The others are
walked (`coupled`). A point counts where |f| ≤ 1e-9 and σ vanishes in the Jacobian itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.families.coupled import Coupled, nearest_turns
from rankdrop.family.record import Family, Pinned
from rankdrop.family.system import REACHED, System
from rankdrop.family.unit import family_in_metres
from rankdrop.local.block import generic_rank, joint_scale, singular_values
from rankdrop.local.nearest import Nearest
from rankdrop.local.verdict import one_configuration
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_metres, into_metres, metre_exponent, out_of_metres, task_in_metres

AGREE = 1e-6  # distances that differ by less are the same: σ that vanishes to second order leaves half the digits [rad]


@dataclass(frozen=True, slots=True)
class FamilyDistance:
    """The nearest point of one family.

    Attributes:
        family: the family.
        distance: ‖(q* − q0)/joint scale‖₂ [rad; metres divided by the length scale]; inf where no point of the family
            was reached (none within the limits, or no equations: `family.named` is False).
        q: (n,) q*, not wrapped: q* − q0 is the motion [rad, m]; empty where the distance is inf.
        delta: (n,) q* − q0 [rad, m].
        residual: largest |f| of the family's equations at q*.
        sigma: largest of the singular values that should vanish at q*, from the Jacobian [1].
        exact: closed form: the nearest without doubt. Otherwise the best of many starts.
    """

    family: Family
    distance: float
    q: tuple[float, ...]
    delta: tuple[float, ...]
    residual: float
    sigma: float
    exact: bool


@dataclass(frozen=True, slots=True)
class Agreement:
    """Two answers to "how far": the nearest point over the families and the nearest of a search.

    Attributes:
        agree: both distances are the same to 1e-6, or neither found anything.
        gap: distance of the search minus that of the nearest family [rad]; nan where one of them has none.
        family: the nearest family, where its distance is the smaller or the same; None where the search is nearer.
        words: one sentence.
    """

    agree: bool
    gap: float
    family: Family | None
    words: str


def family_distances(
    families: Sequence[Family],
    robot: Robot,
    q: ArrayLike,
    task: Task,
    *,
    limits: bool = False,
    seed: int = 0,
    tolerances: Tolerances = DEFAULT,
) -> tuple[FamilyDistance, ...]:
    """Distance from q to every family, nearest first.

    Args:
        families: of any coranks, for this arm and task.
        robot: the arm.
        q: (n,) [rad, m].
        task: from `resolve_task`.
        limits: only points within the joint limits.
        seed: of the starts of families whose joints are coupled.
        tolerances: `singular` decides whether a point is singular.

    Returns:
        One record per family. Families without equations come last with distance inf: they were not asked.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
    """
    centre = one_configuration(robot, q)
    if metre_exponent(robot):
        there = [family_in_metres(family, robot) for family in families]
        made = family_distances(
            there, in_metres(robot), into_metres(robot, centre), task_in_metres(task, robot), limits=limits, seed=seed,
            tolerances=tolerances,
        )
        given = dict(zip(map(id, there), families, strict=True))
        return tuple(_out_of_metres(one, given[id(one.family)], robot) for one in made)
    scale = joint_scale(robot, task)
    box = np.stack([robot.lower, robot.upper]) if limits else np.array([[-np.inf], [np.inf]]) * np.ones(robot.n)
    full = generic_rank(robot, task)
    records = []
    for family in families:
        exact = family.named and bool(family.pinned) and not family.coupled
        points = np.empty((0, robot.n))
        if exact:
            points = _pinned_point(family.pinned, robot, centre, box)
        elif family.named and family.equations:
            points = Coupled(family, robot, centre, scale, box, seed).points()
        records.append(_record(family, points, robot, task, full - family.corank, centre, scale, exact, tolerances))
    return tuple(sorted(records, key=lambda record: record.distance))


def _out_of_metres(found: FamilyDistance, family: Family, robot: Robot) -> FamilyDistance:
    if not found.q:
        return replace(found, family=family)
    q, delta = out_of_metres(robot, found.q), out_of_metres(robot, found.delta)
    return replace(found, family=family, q=tuple(q.tolist()), delta=tuple(delta.tolist()))


def agreement(distances: Sequence[FamilyDistance], nearest: Nearest | None) -> Agreement:
    """Whether the families and a search give the same distance; where they do not, which of the two falls short.

    Args:
        distances: from `family_distances`, over all families known.
        nearest: from `nearest_singularity` at the same q, task and limits; None where the search found nothing.
    """
    reached = [record for record in distances if np.isfinite(record.distance)]
    unnamed = sum(not record.family.named for record in distances)
    first = min(reached, key=lambda record: record.distance, default=None)
    if first is None and nearest is None:
        return Agreement(True, np.nan, None, "neither the families nor the search reach a singularity")
    if first is None:
        text = f"the search found a singularity, no named family has one{_more(unnamed)}"
        return Agreement(False, np.nan, None, text)
    if nearest is None:
        return Agreement(False, np.nan, first.family, f"the search found none, family {first.family.id} has one")
    gap = nearest.distance - first.distance
    if abs(gap) <= AGREE:
        return Agreement(True, gap, first.family, f"search and families agree: {first.family.id} ({first.family.name})")
    if gap > 0:
        text = f"the search missed a nearer point of family {first.family.id} ({first.family.name})"
        return Agreement(False, gap, first.family, text)
    text = f"the search found a singularity nearer than every named family{_more(unnamed)}"
    return Agreement(False, gap, None, text)


def _more(unnamed: int) -> str:
    return f" ({unnamed} families have no conditions and were not asked)" if unnamed else ""


def _record(
    family: Family,
    points: Array,
    robot: Robot,
    task: Task,
    rank: int,
    centre: Array,
    scale: Array,
    exact: bool,
    tolerances: Tolerances,
) -> FamilyDistance:
    """The nearest of the points that solve the equations and are singular."""
    nothing = FamilyDistance(family, np.inf, (), (), np.inf, np.inf, exact)
    if not len(points):
        return nothing
    residual = np.abs(System(family.equations).values(points)).max(axis=1)
    sigma = singular_values(robot, points, task)[:, rank]
    distance = np.linalg.norm((points - centre) / scale, axis=1)
    good = (residual <= REACHED) & (sigma <= tolerances.singular)
    if not good.any():
        return nothing
    best = int(np.where(good, distance, np.inf).argmin())
    at = points[best]
    return FamilyDistance(
        family, float(distance[best]), tuple(at.tolist()), tuple((at - centre).tolist()), float(residual[best]),
        float(sigma[best]), exact,
    )  # fmt: skip


def _pinned_point(pinned: Sequence[Pinned], robot: Robot, centre: Array, box: Array) -> Array:
    """(1, n) every pinned joint at its nearest value, the others where they are; (0, n) where the limits forbid it."""
    point = np.clip(centre, box[0], box[1])
    for joint in pinned:
        j = joint.number - 1
        options = nearest_turns(np.array(joint.values), centre[j], bool(robot.periodic[j]), box[:, j])
        if not len(options):
            return np.empty((0, robot.n))
        point[j] = options[np.abs(options - centre[j]).argmin()]
    return point[None]
