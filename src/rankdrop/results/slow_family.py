"""Which family makes a straight motion of the tool slow: one of the arm itself, or of the ideal arm nearby?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from rankdrop.configuration import Configuration
from rankdrop.errors import OptionError
from rankdrop.families.on_the_spot import families_through
from rankdrop.families.record import Family
from rankdrop.local.directions import lost_directions
from rankdrop.local.nearest import Nearest, nearest_singularity
from rankdrop.local.slowest import slowest_motions
from rankdrop.results.far import Far
from rankdrop.results.known import known_families
from rankdrop.robot.ideal import Near, ideal, near_ideal
from rankdrop.robot.model import Array, Robot
from rankdrop.task import six_rows

_ALIGNED = 0.7  # cosine between a slow motion and what a family loses from which the family explains it


@dataclass(frozen=True, eq=False)
class SlowFamily:
    """The family that makes a motion slow.

    Attributes:
        family: the family.
        distance: to it [rad; slides in length scales].
        ideal: the ideal arm nearby, where it is that arm's family.
        q: (n,) the nearest configuration of the family.
    """

    family: Family
    distance: float
    ideal: Near | None
    q: Array


def slow_family_at(configuration: Configuration, far: Far, seed: int) -> SlowFamily | None:
    """The family that makes a straight motion slow; None where no singularity was found.

    Args:
        configuration: for a task.
        far: how far the next singularity is from it.
        seed: of random starts.
    """
    nearest = far.nearest
    of_ideal_arm = _family_of_ideal_arm(configuration, nearest, seed)
    if of_ideal_arm is not None or nearest is None or far.nearest_family is None:
        return of_ideal_arm
    normals = slow_normals(configuration)
    first = SlowFamily(far.nearest_family.family, nearest.distance, None, np.array(nearest.q))
    if _explains(configuration, nearest.q, nearest.corank, normals):
        return first
    for point in far.families:
        if _explains(configuration, point.q, point.family.corank, normals):
            return SlowFamily(point.family, point.distance, None, np.array(point.q))
    return first


def _family_of_ideal_arm(configuration: Configuration, nearest: Nearest | None, seed: int) -> SlowFamily | None:
    """The nearest family of the ideal arm nearby; None where there is no such arm, or the arm's own are nearer."""
    near = near_ideal(configuration.robot)
    if near is None:
        return None
    model = _ideal_arm(configuration.robot, near.tolerance.length, near.tolerance.angle)
    task = replace(configuration.task, length_scale=float(configuration.task.scale(configuration.robot)))
    try:
        of_ideal_arm = nearest_singularity(model, configuration.q, task, seed=seed)
    except OptionError:  # too many joints for a search
        return None
    if of_ideal_arm is None or (nearest is not None and of_ideal_arm.distance >= nearest.distance):
        return None
    families, source = known_families(model, task, None, configuration.tolerances)
    q = np.array(of_ideal_arm.q)
    through = families_through(
        model, q, task, of_ideal_arm.corank, families, source=source, seed=seed, tolerances=configuration.tolerances
    )
    return SlowFamily(through[0].family, of_ideal_arm.distance, near, q)


@lru_cache(maxsize=16)
def _ideal_arm(robot: Robot, length: float | None, angle: float | None) -> Robot:
    """The ideal arm nearby, made once: it costs more than the rest of an explanation."""
    return ideal(robot, length=length, angle=angle)[0]


def slow_normals(configuration: Configuration) -> list[Array]:
    """(m,) each: normals of the slowest translation and of the slowest rotation."""
    motions = slowest_motions(configuration.robot, configuration.q[None], configuration.task)
    return [motion.normal[0] for motion in motions]


def _explains(configuration: Configuration, q: Sequence[float], corank: int, normals: Sequence[Array]) -> bool:
    """Whether a singular configuration loses a motion along one of the normals."""
    return any(loses_along(configuration, q, corank, normal) for normal in normals)


def loses_along(configuration: Configuration, q: Sequence[float], corank: int, normal: Array) -> bool:
    """Whether a singular configuration loses a motion along `normal`, in the rows of the task [m/s, rad/s]."""
    lost = lost_directions(configuration.robot, q, configuration.task, corank)
    unit = six_rows(normal, configuration.task) / np.linalg.norm(normal)
    return bool(np.linalg.norm(lost @ unit) >= _ALIGNED)
