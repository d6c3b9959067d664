"""What the axes of an arm have in common at one configuration: lines that coincide, are parallel, meet in a point."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

from numpy.typing import ArrayLike

from rankdrop.local.block import structural_sample
from rankdrop.local.circuit_words import numbers
from rankdrop.local.lines import Lines
from rankdrop.local.verdict import one_configuration
from rankdrop.robot.model import Robot
from rankdrop.task import resolve_task
from rankdrop.tolerances import ALIGNED

_SAMPLES = 2  # random configurations at which a relation has to hold to be structure
_ORDER = ("aligned", "concurrent", "intersecting", "parallel")

Group = tuple[str, tuple[int, ...]]


@dataclass(frozen=True, slots=True)
class Relation:
    """One thing that some axes have in common.

    Attributes:
        words: in English: "axes 1, 3, 5, 7 aligned".
        joints: numbers from 1 in `Robot.joints`, which are those of q where no joint is a mimic.
        kind: "aligned" (one line), "concurrent" (three or more through one point), "intersecting" (two), "parallel".
        structural: true at every configuration, hence no reason for a singularity here.
    """

    words: str
    joints: tuple[int, ...]
    kind: str
    structural: bool


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
    here = Lines(robot, one_configuration(robot, q), tolerance)
    elsewhere = [Lines(robot, c, tolerance) for c in structural_sample(robot, resolve_task(None, robot), _SAMPLES)]
    groups = _groups(here)
    always = [group for group in _groups(elsewhere[0]) if all(_holds(lines, group) for lines in elsewhere[1:])]
    special = [group for group in groups if not all(_holds(lines, group) for lines in elsewhere)]
    structural = [group for group in groups if group not in special]
    structural += [group for group in always if group not in groups and len(group[1]) > 2 and _holds(here, group)]
    told = [_relation(here, group, False) for group in special] + [_relation(here, group, True) for group in structural]
    return tuple(sorted(told, key=lambda r: (r.structural, _ORDER.index(r.kind), r.joints)))


def _groups(lines: Lines) -> list[Group]:
    """Maximal groups of every kind, indices from 0."""
    turns = lines.turns
    aligned = {tuple(j for j in turns if lines.one_line(i, j)) for i in turns}
    every = sorted([*turns, *lines.slides])
    parallel = {tuple(j for j in every if lines.parallel(i, j)) for i in every} - aligned
    points = {}
    for i, j in combinations(turns, 2):
        point = lines.meeting_point(i, j)
        if point is not None:
            on = lines.through(point)
            points[i, j] = tuple(k for k in turns if on[k])
    concurrent = {group for group in points.values() if len(group) > 2}
    pairs = {group for group in points.values() if len(group) == 2}
    found: list[Group] = [("aligned", group) for group in aligned if len(group) > 1]
    found += [("parallel", group) for group in parallel if len(group) > 1]
    found += [("concurrent", group) for group in concurrent]
    return found + [("intersecting", group) for group in pairs]


def _holds(lines: Lines, group: Group) -> bool:
    kind, joints = group
    pairs = list(combinations(joints, 2))
    if kind == "aligned":
        return all(lines.one_line(i, j) for i, j in pairs)
    if kind == "parallel":
        return all(lines.parallel(i, j) for i, j in pairs)
    crossing = [pair for pair in pairs if not lines.parallel(*pair)]
    point = lines.meeting_point(*crossing[0]) if crossing else None
    if point is None:
        return False
    on = lines.through(point)
    return all(on[i] for i in joints)


def _relation(lines: Lines, group: Group, structural: bool) -> Relation:
    kind, joints = group
    axes, slides = [i for i in joints if i in lines.turns], [i for i in joints if i in lines.slides]
    parts = [(f"axes {numbers(axes)}" if len(axes) > 1 else f"axis {numbers(axes)}") if axes else ""]
    parts += [f"slide{'s' if len(slides) > 1 else ''} {numbers(slides)}" if slides else ""]
    verb = {"aligned": "aligned", "parallel": "parallel", "concurrent": "meet in one point"}.get(kind, "intersect")
    words = f"{' and '.join(part for part in parts if part)} {verb}"
    return Relation(words, tuple(i + 1 for i in joints), kind, structural)
