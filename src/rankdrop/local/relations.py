"""Relations of the axes at one configuration: which are aligned, parallel, or meet, and which of that holds everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.kinematics import one_configuration
from rankdrop.local.axes import Scene, indices
from rankdrop.local.block import structural_sample
from rankdrop.robot.model import Robot
from rankdrop.sections import words_of
from rankdrop.task import resolve_task
from rankdrop.tolerances import ALIGNED

_PLACES = 2  # random configurations at which a relation has to hold to be structure
_ORDER = ("aligned", "concurrent", "intersecting", "parallel")

Group = tuple[str, tuple[int, ...]]


@dataclass(frozen=True, slots=True)
class Relation:
    """One thing that some axes have in common.

    Attributes:
        joints: numbers from 1 in `Robot.joints`, which are those of q where no joint is a mimic.
        kind: "aligned" (one line), "concurrent" (three or more through one point), "intersecting" (two), "parallel".
        structural: true at every configuration, hence no reason for a singularity here.
        slides: those of the joints that slide.
    """

    joints: tuple[int, ...]
    kind: str
    structural: bool
    slides: tuple[int, ...] = ()

    @property
    def words(self) -> str:
        """In words: "axes 1, 3, 5, 7 aligned"."""
        sentence: str = words_of(self).relation_words(self)
        return sentence


def relations_at(robot: Robot, q: ArrayLike, tolerance: float = ALIGNED) -> tuple[Relation, ...]:
    """Relations of the axes at one configuration, those special to it first.

    Groups are as large as they can be. A group that holds everywhere is told beside a larger one that holds here only;
    a pair inside a larger group is not. Slides have a direction but no place: they can only be parallel.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].
        tolerance: angles [rad] and distances per reach below it are zero.

    Raises:
        ConfigurationError: q is not one configuration of this arm.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> for relation in relations_at(open_robot("puma560"), [0.1, 0.2, 0.3, 0.4, 0.0, 0.6]):
        ...     print(relation.structural, relation.words)
        False axes 4, 6 aligned
        True axes 4, 5, 6 meet in one point
        True axes 1, 2 intersect
        True axes 2, 3 parallel
    """
    here = Scene.at(robot, one_configuration(robot, q), tolerance, every_joint=True)
    elsewhere, always = _structure(robot, tolerance)
    groups = _groups(here)
    structural = [group for group in groups if _holds(elsewhere, group)]
    structural += [group for group in always if group not in groups and len(group[1]) > 2 and _holds(here, group)]
    special = [group for group in groups if group not in structural]
    relations = [_relation(here, *group, group in structural) for group in special + structural]
    return tuple(sorted(relations, key=lambda r: (r.structural, _ORDER.index(r.kind), r.joints)))


@lru_cache(maxsize=16)
def _structure(robot: Robot, tolerance: float) -> tuple[Scene, list[Group]]:
    """The arm at random configurations, and the groups that it has at all of them: a robot never changes."""
    elsewhere = Scene.of_joints(robot, structural_sample(robot, resolve_task(None, robot), _PLACES), tolerance)
    return elsewhere, _groups(elsewhere)


def _groups(scene: Scene) -> list[Group]:
    """Maximal groups of every kind that hold at all configurations of a scene, indices from 0."""
    turns = np.flatnonzero(~scene.slides)
    verdicts = (scene.aligned, scene.parallel, *scene.crossings)
    line, together, meet, on = (np.asarray(every.all(axis=-1)) for every in verdicts)
    aligned = {indices(row & ~scene.slides) for row in line[turns]}
    parallel = {indices(row) for row in together} - aligned
    points = {indices(on[i, j] & ~scene.slides) for i, j in combinations(turns, 2) if meet[i, j]}
    groups = [("aligned", group) for group in aligned] + [("parallel", group) for group in parallel]
    groups += [("concurrent" if len(group) > 2 else "intersecting", group) for group in points]
    return [(kind, group) for kind, group in groups if len(group) > 1]


def _holds(scene: Scene, group: Group) -> bool:
    """Whether some axes have this in common at every configuration of a scene."""
    kind, joints = group
    pairs = np.ix_(joints, joints)
    if kind in ("aligned", "parallel"):
        return bool((scene.aligned if kind == "aligned" else scene.parallel)[pairs].all())
    meet, on = scene.crossings
    through = meet[pairs] & on[pairs][:, :, list(joints)].all(axis=2)
    return bool(through.any(axis=(0, 1)).all())


def _relation(scene: Scene, kind: str, joints: tuple[int, ...], structural: bool) -> Relation:
    slides = tuple(i + 1 for i in joints if scene.slides[i])
    return Relation(tuple(i + 1 for i in joints), kind, structural, slides)
