"""What the axes of an arm have in common at one configuration: lines that coincide, are parallel, meet in a point.

A dependent set of joints in words: what its axes and slides have in common.

The patterns are those of Paden and Sastry (two collinear axes, three parallel coplanar ones, four that meet in a point,
four in a plane, a slide normal to the plane of two parallel axes, six that meet a line) and what they leave out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.kinematics import one_configuration, task_jacobian
from rankdrop.local.block import structural_sample
from rankdrop.local.lines import Lines, Scene
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.task import Task, resolve_task, six_rows
from rankdrop.tolerances import ALIGNED

_POSITION, _ORIENTATION = {0, 1, 2}, {3, 4, 5}


def describe(scene: Scene, circuit: tuple[int, ...], task: Task) -> str:
    """A circuit in words: what its axes and slides have in common at every configuration of the scene.

    In the full pose two dependent axes are one line; three lie in one plane and meet in one point or are parallel; four
    that all meet, are all parallel or lie in one plane span a system of rank 3. Without a pattern: "screws 1, 3, 4
    dependent".

    Args:
        scene: one or more configurations.
        circuit: indices of joints from 0, a minimal dependent set at every configuration of the scene.
        task: the rows that are dependent.
    """
    names = numbers(circuit)
    if len(circuit) == 1:
        return f"joint {names} moves nothing"
    axes = [i for i in circuit if i in scene.axes]
    slides = [i for i in circuit if scene.kinds[i] is JointKind.PRISMATIC]
    told = None
    if len(axes) + len(slides) == len(circuit):
        if task.m == 6:
            told = _axes(scene, circuit) if not slides else _slides(scene, slides) if not axes else None
            told = told or (_mixed(scene, axes, slides) if axes and slides else None) or _transversal(scene, circuit)
        elif set(task.rows) <= _POSITION and not slides:
            told = _through_the_tip(scene, circuit)
        elif set(task.rows) <= _ORIENTATION and not slides:
            told = _directions(scene, circuit)
    return told or f"{'screws' if task.m == 6 else 'joints'} {names} dependent"


def line_meets_all(scene: Scene, task: Task) -> bool:
    """Is there a line that meets every axis (or is parallel to it) at every point of the scene?

    The blocked wrench (f; τ) of a corank-1 point, f·v_i + τ·ω_i = 0 for every joint, is a pure force along that line
    when its pitch f·τ/|f|² is zero: a force does no work on a rotation about an axis it meets. In a task without
    rotation the wrench is always a force, through the tip.
    """
    jacobians = task_jacobian(scene.robot, scene.q, task)
    if len(scene.axes) < scene.robot.n:
        return False
    left = np.linalg.svd(jacobians)[0][..., -1]  # (N, m)
    return _pure_force(six_rows(left, task))


def numbers(members: Sequence[int]) -> str:
    """ "2–6" for a run of four or more, "1, 3, 4" otherwise, numbers from 1."""
    if len(members) > 3 and members[-1] - members[0] == len(members) - 1:
        return f"{members[0] + 1}–{members[-1] + 1}"
    return ", ".join(str(i + 1) for i in members)


def _axes(scene: Scene, axes: tuple[int, ...]) -> str | None:
    """Axes alone, in the full pose."""
    names = numbers(axes)
    if len(axes) == 2:
        return f"axes {names} aligned"
    if len(axes) > 4:
        return None  # parallel, concurrent or coplanar axes have rank 3: no circuit is larger than four
    parallel = _parallel(scene, axes)
    concurrent = not parallel and bool(scene.common_point(axes)[1].all())
    if len(axes) == 3:
        word = "parallel" if parallel else "concurrent" if concurrent else None
        return word and f"axes {names} {word} and coplanar"
    coplanar = not parallel and not concurrent and bool(scene.coplanar(axes).all())
    for told, word in ((parallel, "parallel"), (concurrent, "concurrent"), (coplanar, "coplanar")):
        if told:
            return f"axes {names} {word}"
    return None


def _slides(scene: Scene, slides: Sequence[int]) -> str:
    """Slides alone: directions of which one too many lie on a line, in a plane, in space."""
    names = numbers(slides)
    if len(slides) == 2:
        return f"slides {names} parallel"
    return f"slides {names} {'parallel to one plane' if len(slides) == 3 else 'are four translations of space'}"


def _mixed(scene: Scene, axes: Sequence[int], slides: Sequence[int]) -> str | None:
    """Axes and slides: turning forth and back about parallel axes is a translation, and the slides make it too."""
    if not _parallel(scene, axes):
        return None
    both, sliding = f"axes {numbers(axes)}", f"slide{'s' if len(slides) > 1 else ''} {numbers(slides)}"
    normal = all(scene.perpendicular(axes[0], i).all() for i in slides)
    if len(axes) == 2 and len(slides) == 1:
        return f"axes {numbers(axes)} parallel, {sliding} normal to their plane"
    if normal:
        return f"{both} parallel, {sliding} normal to them"
    return f"{both} parallel, {sliding} along what they translate"


def _transversal(scene: Scene, circuit: tuple[int, ...]) -> str | None:
    """Six axes that meet one line; a line at infinity is met by axes and slides parallel to one plane."""
    if len(circuit) != 6:
        return None
    about = scene.tip[:, None, :]  # moments about the tip: rounding stays small
    columns = scene.screws[..., list(circuit)].transpose(0, 2, 1)
    moved = (columns[..., :3] + np.cross(columns[..., 3:], about)) / scene.length
    left = np.linalg.svd(np.concatenate([moved, columns[..., 3:]], axis=-1))[2][:, -1]  # the blocked wrench
    if not _pure_force(left):
        return None
    slides = [i for i in circuit if i not in scene.axes]
    axes = [i for i in circuit if i in scene.axes]
    if slides:
        also = f"slide{'s' if len(slides) > 1 else ''} {numbers(slides)} normal to it"
        return f"axes {numbers(axes)} meet one line, {also}"
    return f"axes {numbers(circuit)} meet one line"


def _through_the_tip(scene: Scene, axes: tuple[int, ...]) -> str | None:
    """Axes in a position task: planes and lines through the tip."""
    names = numbers(axes)
    if len(axes) == 2 and bool(scene.coplanar(axes, scene.tip).all()):
        return f"axes {names} and the tip in one plane"
    return None


def _directions(scene: Scene, axes: tuple[int, ...]) -> str | None:
    """Axes in an orientation task: only their directions count."""
    if len(axes) == 2 and _parallel(scene, axes):
        return f"axes {numbers(axes)} parallel"
    if len(axes) == 3:
        volume = np.einsum("...i,...i->...", scene.z[axes[0]], np.cross(scene.z[axes[1]], scene.z[axes[2]]))
        if (np.abs(volume) < ALIGNED).all():
            return f"axes {numbers(axes)} parallel to one plane"
    return None


def _parallel(scene: Scene, axes: Sequence[int]) -> bool:
    return all(bool(scene.parallel(axes[0], i).all()) for i in axes[1:])


def _pure_force(wrench: Array) -> bool:
    """Wrenches (N, 6), moments per length scale: forces without a moment along them, and not moments alone."""
    force, moment = wrench[:, :3], wrench[:, 3:]
    pitch = np.abs(np.einsum("ni,ni->n", force, moment))
    return bool((pitch < 1e-6).all() and (np.linalg.norm(force, axis=1) > 1e-6).all())


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
    elsewhere, always = _structure(robot, tolerance)
    groups = _groups(here)
    special = [group for group in groups if not all(_holds(lines, group) for lines in elsewhere)]
    structural = [group for group in groups if group not in special]
    structural += [group for group in always if group not in groups and len(group[1]) > 2 and _holds(here, group)]
    told = [_relation(here, group, False) for group in special] + [_relation(here, group, True) for group in structural]
    return tuple(sorted(told, key=lambda r: (r.structural, _ORDER.index(r.kind), r.joints)))


_known: WeakKeyDictionary[Robot, dict[float, tuple[list[Lines], list[Group]]]] = WeakKeyDictionary()


def _structure(robot: Robot, tolerance: float) -> tuple[list[Lines], list[Group]]:
    """The arm at random configurations, and the groups that it has at all of them: a robot never changes."""
    known = _known.setdefault(robot, {})
    if tolerance not in known:
        elsewhere = [Lines(robot, c, tolerance) for c in structural_sample(robot, resolve_task(None, robot), _SAMPLES)]
        always = [group for group in _groups(elsewhere[0]) if all(_holds(lines, group) for lines in elsewhere[1:])]
        known[tolerance] = elsewhere, always
    return known[tolerance]


def _groups(lines: Lines) -> list[Group]:
    """Maximal groups of every kind, indices from 0."""
    turns = lines.turns
    aligned = {tuple(j for j in turns if lines.one_line(i, j)) for i in turns}
    every = sorted([*turns, *lines.slides])
    parallel = {tuple(j for j in every if lines.parallel(i, j)) for i in every} - aligned
    points = {}
    for i, j in combinations(turns, 2):
        on = lines.through_meeting(i, j)
        if on is not None:
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
    on = lines.through_meeting(*crossing[0]) if crossing else None
    return on is not None and all(on[i] for i in joints)


def _relation(lines: Lines, group: Group, structural: bool) -> Relation:
    kind, joints = group
    axes, slides = [i for i in joints if i in lines.turns], [i for i in joints if i in lines.slides]
    parts = [(f"axes {numbers(axes)}" if len(axes) > 1 else f"axis {numbers(axes)}") if axes else ""]
    parts += [f"slide{'s' if len(slides) > 1 else ''} {numbers(slides)}" if slides else ""]
    verb = {"aligned": "aligned", "parallel": "parallel", "concurrent": "meet in one point"}.get(kind, "intersect")
    words = f"{' and '.join(part for part in parts if part)} {verb}"
    return Relation(words, tuple(i + 1 for i in joints), kind, structural)
