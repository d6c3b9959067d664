"""What the axes of an arm have in common: relations, dependent sets in words, screw systems.

`Scene` holds the axes of an arm's joints at some configurations, and which of them are parallel, aligned, or meet.

Circuits are inclusion-minimal dependent sets of joints, the smallest culprits of a loss of rank. With columns J_i of
the task Jacobian a set C is a circuit when Σ_{i∈C} c_i J_i = 0 for some c without a zero entry, and no smaller set
inside C is dependent. Every dependency of the columns is a combination of such c. KG suppress dependent screws one by
one, GR look at runs of neighbours only; the circuits are all of them. Their words follow Paden and Sastry (two
collinear axes, three parallel coplanar ones, four that meet in a point, four in a plane, a slide normal to the plane
of two parallel axes, six that meet a line), and what these leave out.

A screw system is a set of joints inside one proper subgroup of the rigid motions. The screws span no more than the
dimension of the subgroup, and no motion of these joints leaves the subgroup: these are Hunt's systems of full-cycle
mobility, which GR's second rule (section 3) excludes from the search for a joint that escapes. The connected subgroups,
as Lie algebras of twists (all of them up to the choice of axis, point and pitch):

    dimension 1  turns about a line, screws of one pitch along a line, slides along a direction
    dimension 2  cylindrical (a line), translations of a plane
    dimension 3  spherical (a point), planar (a normal), translations of space, planar with a screw (a normal, a pitch)
    dimension 4  Schönflies (a direction): translations of space and turns about parallel axes

A set of joints inside one of them stays inside when joints of the set move, and when a joint moves that maps the
subgroup onto itself: a joint of its normaliser.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property, lru_cache
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.errors import OptionError
from rankdrop.kinematics import jacobian, one_configuration, pose, task_jacobian
from rankdrop.local.block import generic_rank, sigma_of, singular_values, structural_sample, svd
from rankdrop.local.departure import unlocked
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.numbers import reach
from rankdrop.robot.transform import bracket, cross, unit
from rankdrop.sections import words_of
from rankdrop.task import SPACE, Task, resolve_task, six_rows
from rankdrop.tolerances import ALIGNED, DEPENDENT

Verdicts = NDArray[np.bool_]  # one per configuration


@dataclass(frozen=True, eq=False)
class Scene:
    """Joint axes at N configurations, in the base frame. Joints are numbered from 0 here.

    An axis (revolute joint) is the line p_i + s z_i with z = ω, p = ω × v.
    """

    robot: Robot
    q: Array  # (N, n)
    tolerance: float = ALIGNED

    @classmethod
    def of_joints(cls, robot: Robot, q: Array, tolerance: float = ALIGNED) -> Scene:
        """The scene at configurations (N, n) in which every mimic joint is a joint of its own."""
        free, values, _ = unlocked(robot, q)
        return cls(free, values, tolerance)

    @cached_property
    def screws(self) -> Array:
        """(N, 6, n) joint screws about the base origin."""
        return jacobian(self.robot, self.q, SPACE)

    @cached_property
    def kinds(self) -> tuple[JointKind | None, ...]:
        """Kind of each variable; None where a mimic joint follows: then it is not one screw."""
        leaders = {joint.mimic.leader for joint in self.robot.joints if joint.mimic is not None}
        return tuple(None if joint.name in leaders else joint.kind for joint in self.robot.variables)

    @cached_property
    def axes(self) -> tuple[int, ...]:
        """Indices of the revolute joints."""
        return tuple(i for i, kind in enumerate(self.kinds) if kind is JointKind.REVOLUTE)

    @cached_property
    def slides(self) -> Verdicts:
        """(n,) which joints are prismatic."""
        return np.array([kind is JointKind.PRISMATIC for kind in self.kinds])

    @cached_property
    def z(self) -> Array:
        """(n, N, 3) unit directions of the axes; those of the slides for prismatic joints."""
        columns = np.moveaxis(self.screws, -1, 0)
        return np.where(self.slides[:, None, None], columns[..., :3], columns[..., 3:])

    @cached_property
    def p(self) -> Array:
        """(n, N, 3) the points of the axes nearest to the base origin [m]."""
        columns = np.moveaxis(self.screws, -1, 0)
        return cross(columns[..., 3:], columns[..., :3])

    @cached_property
    def tip(self) -> Array:
        """(N, 3) the tip [m]."""
        return pose(self.robot, self.q)[..., :3, 3]

    @cached_property
    def length(self) -> float:
        """Reach of the arm [m]; distances are judged against it."""
        return reach(self.robot)

    @cached_property
    def parallel(self) -> Verdicts:
        """(n, n, N) |z_i × z_j| = 0."""
        return self._small(cross(self.z[:, None], self.z[None]))

    @cached_property
    def perpendicular(self) -> Verdicts:
        """(n, n, N) z_i · z_j = 0."""
        return np.asarray(np.abs(_dot(self.z[:, None], self.z[None])) < self.tolerance)

    @cached_property
    def aligned(self) -> Verdicts:
        """(n, n, N) whether axes i and j are one line, parallel and with (p_j − p_i) × z_i = 0."""
        return self.parallel & self.on_axis(self.p[None], np.arange(len(self.p))[:, None])

    @cached_property
    def crossings(self) -> tuple[Verdicts, Verdicts]:
        """(n, n, N) whether axes i and j meet in one point, and (n, n, n, N) which axes go through it.

        They meet at p_i + s z_i, s from (p_j − p_i) × z_j = s z_i × z_j.
        """
        skew, apart = cross(self.z[:, None], self.z[None]), self.p[None] - self.p[:, None]
        meet = ~self.parallel & (np.abs(_dot(apart, skew)) <= self.tolerance * self.length)
        s = _dot(cross(apart, self.z[None]), skew) / np.where(meet, _dot(skew, skew), 1.0)
        points = self.p[:, None] + s[..., None] * self.z[:, None]
        number = np.arange(len(self.p))
        on = self.on_axis(points[:, :, None], number)
        return meet & on[number[:, None], number, number], on

    def moved(self, joint: int, by: float) -> Scene:
        """The scene after one joint has moved by `by` [rad, m]."""
        q = self.q.copy()
        q[:, joint] += by
        return Scene(self.robot, q, self.tolerance)

    def on_axis(self, point: Array, i: int | NDArray[np.intp]) -> Verdicts:
        """(point − p_i) × z_i = 0 for points (..., N, 3)."""
        return self._small(cross(point - self.p[i], self.z[i]) / self.length)

    def meeting(self, i: int, j: int) -> Verdicts:
        """Not parallel and in one plane: (p_j − p_i) · (z_i × z_j) = 0."""
        volume = _dot(self.p[j] - self.p[i], cross(self.z[i], self.z[j]))
        return np.asarray(~self.parallel[i, j] & (np.abs(volume) < self.tolerance * self.length))

    def common_point(self, axes: Sequence[int]) -> tuple[Array, Verdicts]:
        """(N, 3) the point nearest to some axes, Σ (1 − z zᵀ)(x − p) = 0, and whether it is on all of them."""
        members = np.array(axes)
        normal = np.eye(3) - self.z[members][..., :, None] * self.z[members][..., None, :]  # (a, N, 3, 3)
        total = normal.sum(axis=0)
        right = (normal @ self.p[members][..., None]).sum(axis=0)
        regular = np.linalg.eigvalsh(total)[:, 0] > self.tolerance  # 0 where all are parallel
        point = np.linalg.solve(np.where(regular[:, None, None], total, np.eye(3)), right)[..., 0]
        return point, self.on_axis(point, members).all(axis=0) & regular

    def in_plane(self, point: Array, i: int, direction: Array) -> Verdicts:
        """In the plane through axis i along `direction` (N, 3): (point − p_i) · (z_i × direction) = 0."""
        return np.abs(_dot(point - self.p[i], cross(self.z[i], direction))) < self.tolerance * self.length

    def coplanar(self, axes: Sequence[int], point: Array | None = None) -> Verdicts:
        """All axes (and the point) in one plane."""
        first, members = axes[0], np.array(axes)
        if point is None:
            points = self.p[members[1:]]
        else:
            points = np.concatenate([self.p[members[1:]], point[None]])
        spans = np.concatenate([self.z[members], (points - self.p[first]) / self.length])  # (s, N, 3)
        # remove the freedom along the first axis from the points: only their offset from it counts
        spans = spans - self.z[first] * _dot(spans, self.z[first])[..., None]
        return np.linalg.svd(spans.swapaxes(0, 1), compute_uv=False)[:, 1] < self.tolerance

    def _small(self, vector: Array) -> Verdicts:
        return np.asarray(np.linalg.norm(vector, axis=-1) < self.tolerance)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("...i,...i->...", a, b))


class Common(StrEnum):
    """The pattern of dependent axes and slides."""

    MOVES_NOTHING = "moves nothing"
    DEPENDENT_SCREWS = "dependent screws"
    DEPENDENT_JOINTS = "dependent joints"
    ALIGNED = "aligned"
    PARALLEL = "parallel"
    CONCURRENT = "concurrent"
    COPLANAR = "coplanar"
    PARALLEL_AND_COPLANAR = "parallel and coplanar"
    CONCURRENT_AND_COPLANAR = "concurrent and coplanar"
    IN_ONE_PLANE_WITH_TIP = "in one plane with tip"
    PARALLEL_TO_ONE_PLANE = "parallel to one plane"
    ALL_TRANSLATIONS = "all translations"
    MEET_ONE_LINE = "meet one line"


class SlideWay(StrEnum):
    """How slides lie to axes that they depend on with."""

    NORMAL_TO_AXES = "normal to them"
    NORMAL_TO_PLANE = "normal to their plane"
    ALONG_TRANSLATION = "along their translation"
    NORMAL_TO_LINE = "normal to it"


@dataclass(frozen=True, slots=True)
class Dependence:
    """A minimal dependent set of joint screws.

    Attributes:
        common: its pattern.
        joints: from 0: its axes, or all members where there is no pattern or there are slides alone.
        slides: from 0, where axes and slides depend on each other, and how these lie.
        way: of these slides.
        sliding: the members are slides.
    """

    common: Common
    joints: tuple[int, ...]
    slides: tuple[int, ...] = ()
    way: SlideWay | None = None
    sliding: bool = False

    def __str__(self) -> str:
        """In words: "axes 1, 4, 5 concurrent and coplanar"."""
        words: str = words_of(self).dependence_words(self)
        return words


def describe(scene: Scene, circuit: tuple[int, ...], task: Task) -> str:
    """A circuit in words: see `dependence_of`."""
    return str(dependence_of(scene, circuit, task))


def dependence_of(scene: Scene, circuit: tuple[int, ...], task: Task) -> Dependence:
    """The pattern of the axes and slides of a circuit at every configuration of the scene.

    In the full pose two dependent axes are one line; three lie in one plane and meet in one point or are parallel; four
    that all meet, are all parallel or lie in one plane span a system of rank 3.

    Args:
        scene: one or more configurations.
        circuit: indices of joints from 0, a minimal dependent set at every configuration of the scene.
        task: the rows that are dependent.
    """
    if len(circuit) == 1:
        return Dependence(Common.MOVES_NOTHING, circuit)
    axes = [i for i in circuit if i in scene.axes]
    slides = [i for i in circuit if scene.slides[i]]
    if len(axes) + len(slides) == len(circuit):
        pattern = _pattern(scene, axes, slides, task)
    else:
        pattern = None
    if pattern is not None:
        return pattern
    if task.m == 6:
        return Dependence(Common.DEPENDENT_SCREWS, circuit)
    return Dependence(Common.DEPENDENT_JOINTS, circuit)


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


def _pattern(scene: Scene, axes: Sequence[int], slides: Sequence[int], task: Task) -> Dependence | None:
    """What dependent axes and slides have in common; None without a pattern."""
    if task.m == 6:
        if not axes:
            how = (Common.PARALLEL, Common.PARALLEL_TO_ONE_PLANE, Common.ALL_TRANSLATIONS)[len(slides) - 2]
            return Dependence(how, tuple(slides), sliding=True)
        if slides:
            special = _translations_twice(scene, axes, slides)
        else:
            special = _three_dimensions(scene, axes)
        return special or _transversal(scene, axes, slides)
    count, lines = len(axes), tuple(axes)
    if slides:
        return None
    if max(task.rows) < 3:  # planes through the tip count
        flat = count == 2 and scene.coplanar(axes, scene.tip).all()
        if flat:
            return Dependence(Common.IN_ONE_PLANE_WITH_TIP, lines)
        return None
    if min(task.rows) >= 3:  # directions alone count
        if count == 2 and _parallel(scene, axes):
            return Dependence(Common.PARALLEL, lines)
        flat = count == 3 and (np.abs(_dot(scene.z[axes[0]], np.cross(*scene.z[axes[1:]]))) < ALIGNED).all()
        if flat:
            return Dependence(Common.PARALLEL_TO_ONE_PLANE, lines)
        return None
    return None


def _three_dimensions(scene: Scene, axes: Sequence[int]) -> Dependence | None:
    """Axes alone: parallel, concurrent or coplanar ones have rank 3, so that no circuit of them has more than four."""
    if len(axes) == 2:
        return Dependence(Common.ALIGNED, tuple(axes))
    if len(axes) > 4:
        return None
    if _parallel(scene, axes):
        kinds = (Common.PARALLEL_AND_COPLANAR, Common.PARALLEL)
    elif scene.common_point(axes)[1].all():
        kinds = (Common.CONCURRENT_AND_COPLANAR, Common.CONCURRENT)
    elif len(axes) == 4 and scene.coplanar(axes).all():
        return Dependence(Common.COPLANAR, tuple(axes))
    else:
        return None
    return Dependence(kinds[len(axes) - 3], tuple(axes))


def _translations_twice(scene: Scene, axes: Sequence[int], slides: Sequence[int]) -> Dependence | None:
    """Axes and slides: turning forth and back about parallel axes is a translation, and the slides make it too."""
    if not _parallel(scene, axes):
        return None
    normal = all(scene.perpendicular[axes[0], i].all() for i in slides)
    if normal:
        way = SlideWay.NORMAL_TO_AXES
    else:
        way = SlideWay.ALONG_TRANSLATION
    if len(axes) == 2 and len(slides) == 1:
        way = SlideWay.NORMAL_TO_PLANE
    return Dependence(Common.PARALLEL, tuple(axes), tuple(slides), way)


def _transversal(scene: Scene, axes: Sequence[int], slides: Sequence[int]) -> Dependence | None:
    """Six axes that meet one line; a line at infinity is met by axes and slides parallel to one plane."""
    circuit = sorted([*axes, *slides])
    if len(circuit) != 6:
        return None
    columns = scene.screws[..., circuit].transpose(0, 2, 1)
    about_tip = (columns[..., :3] + np.cross(columns[..., 3:], scene.tip[:, None, :])) / scene.length  # rounds least
    blocked = np.linalg.svd(np.concatenate([about_tip, columns[..., 3:]], axis=-1))[2][:, -1]
    if not _pure_force(blocked):
        return None
    if not slides:
        return Dependence(Common.MEET_ONE_LINE, tuple(axes))
    return Dependence(Common.MEET_ONE_LINE, tuple(axes), tuple(slides), SlideWay.NORMAL_TO_LINE)


def _parallel(scene: Scene, axes: Sequence[int]) -> bool:
    return bool(scene.parallel[axes[0], list(axes[1:])].all())


def _pure_force(wrench: Array) -> bool:
    """Wrenches (N, 6), moments per length scale: forces without a moment along them, and not moments alone."""
    force, moment = wrench[:, :3], wrench[:, 3:]
    pitch = np.abs(np.einsum("ni,ni->n", force, moment))
    return bool((pitch < 1e-6).all() and (np.linalg.norm(force, axis=1) > 1e-6).all())


_PLACES = 2  # random configurations at which a relation has to hold to be structure
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
    here = Scene.of_joints(robot, one_configuration(robot, q)[None], tolerance)
    elsewhere, always = _structure(robot, tolerance)
    groups = _groups(here)
    structural = [group for group in groups if _holds(elsewhere, group)]
    structural += [group for group in always if group not in groups and len(group[1]) > 2 and _holds(here, group)]
    special = [group for group in groups if group not in structural]
    found = [_relation(here, *group, group in structural) for group in special + structural]
    return tuple(sorted(found, key=lambda r: (r.structural, _ORDER.index(r.kind), r.joints)))


@lru_cache(maxsize=16)
def _structure(robot: Robot, tolerance: float) -> tuple[Scene, list[Group]]:
    """The arm at random configurations, and the groups that it has at all of them: a robot never changes."""
    elsewhere = Scene.of_joints(robot, structural_sample(robot, resolve_task(None, robot), _PLACES), tolerance)
    return elsewhere, _groups(elsewhere)


def _members(mask: Verdicts) -> tuple[int, ...]:
    return tuple(np.flatnonzero(mask).tolist())


def _groups(scene: Scene) -> list[Group]:
    """Maximal groups of every kind that hold at all configurations of a scene, indices from 0."""
    turns = np.flatnonzero(~scene.slides)
    verdicts = (scene.aligned, scene.parallel, *scene.crossings)
    line, together, meet, on = (np.asarray(every.all(axis=-1)) for every in verdicts)
    aligned = {_members(row & ~scene.slides) for row in line[turns]}
    parallel = {_members(row) for row in together} - aligned
    points = {_members(on[i, j] & ~scene.slides) for i, j in combinations(turns, 2) if meet[i, j]}
    found = [("aligned", group) for group in aligned] + [("parallel", group) for group in parallel]
    found += [("concurrent" if len(group) > 2 else "intersecting", group) for group in points]
    return [(kind, group) for kind, group in found if len(group) > 1]


def _holds(scene: Scene, group: Group) -> bool:
    """Whether some axes have this in common at every configuration of a scene."""
    kind, joints = group
    pairs = np.ix_(joints, joints)
    if kind in ("aligned", "parallel"):
        return bool((scene.aligned if kind == "aligned" else scene.parallel)[pairs].all())
    meet, on = scene.crossings
    through = meet[pairs] & on[pairs][:, :, list(joints)].all(axis=2)
    return bool(through.any(axis=(0, 1)).all())


def _slides(slides: Sequence[int]) -> str:
    return f"slide{'s' if len(slides) > 1 else ''} {numbers(slides)}"


def _relation(scene: Scene, kind: str, joints: tuple[int, ...], structural: bool) -> Relation:
    slides = [i for i in joints if scene.slides[i]]
    axes = [i for i in joints if i not in slides]
    parts = [f"{'axes' if len(axes) > 1 else 'axis'} {numbers(axes)}"] * bool(axes)
    parts += [_slides(slides)] * bool(slides)
    verb = {"aligned": "aligned", "parallel": "parallel", "concurrent": "meet in one point"}.get(kind, "intersect")
    return Relation(f"{' and '.join(parts)} {verb}", tuple(i + 1 for i in joints), kind, structural)


Subgroup = tuple[str, int, tuple[int, ...], frozenset[int]]
"""Kind and dimension of a subgroup; the joints in it, from 0 in `Robot.joints`, mimic joints included; and its keepers:
all joints, of the set or not, whose motion maps the subgroup onto itself."""


def subgroups(scene: Scene) -> list[Subgroup]:
    """The largest set of joints for every subgroup that two joints at least lie in; a set once, in the smallest.

    The scene has one configuration, and mimic joints as joints of their own.
    """
    smallest: dict[tuple[int, ...], Subgroup] = {}
    for kind, dimension, members, keepers in _every_subgroup(scene):
        joints = _members(members)
        if len(joints) > 1 and (joints not in smallest or dimension < smallest[joints][1]):
            smallest[joints] = kind, dimension, joints, frozenset(_members(keepers))
    return list(smallest.values())


def closure(screws: Array, tolerance: float = 1e-7, most: int = 6) -> Array:
    """Orthonormal basis (d, 6) of the Lie algebra that some twists (N, 6) generate, lengths in one unit.

    Brackets of the basis are added until the dimension stays, or exceeds `most`: then the rest is not looked for.
    Directions below the tolerance are rounding [1].
    """
    basis = _span(screws, tolerance)
    while True:
        if len(basis) > most:
            return basis
        brackets = [bracket(a, b) for a, b in combinations(basis, 2)]
        grown = _span(np.array([*basis, *brackets]), tolerance)
        if len(grown) == len(basis):
            return basis
        basis = grown


def _every_subgroup(scene: Scene) -> Iterator[tuple[str, int, Verdicts, Verdicts]]:
    """Kind, dimension, members and keepers (n,) of every subgroup that an axis, a slide, or two of them choose."""
    slides, turns = scene.slides, ~scene.slides
    parallel, line, square = (pairs[..., 0] for pairs in (scene.parallel, scene.aligned, scene.perpendicular))
    z, zero = scene.z[:, 0], scene.tolerance * scene.length
    pitches = _dot(scene.screws[0, :3].T, scene.screws[0, 3:].T)  # [m/rad]
    straight = turns & (np.abs(pitches) < zero)
    meet, on = (verdicts[..., 0] for verdicts in scene.crossings)
    for i in _members(turns):
        axis, bundle, pitch = turns & line[i], turns & parallel[i], np.abs(pitches - pitches[i]) < zero
        along = axis | (slides & parallel[i])
        yield "coaxial", 1, axis & pitch, along
        yield "cylindrical", 2, along, along
        if straight[i]:
            kind = "planar"
        else:
            kind = "planar with a screw"
        yield kind, 3, (bundle & pitch) | (slides & square[i]), bundle | slides
        yield "Schönflies", 4, bundle | slides, bundle | slides
    for i, j in combinations(_members(straight), 2):
        if meet[i, j]:
            yield "spherical", 3, on[i, j] & straight, on[i, j] & straight
    for i in _members(slides):
        yield "translational", 1, slides & parallel[i], slides | (turns & parallel[i])
    for i, j in combinations(_members(slides), 2):
        if not parallel[i, j]:
            normal = unit(cross(z[i], z[j]))
            keepers = slides | (turns & scene._small(cross(normal, z)))
            yield "translational", 2, slides & (np.abs(z @ normal) < scene.tolerance), keepers
    yield "translational", 3, slides, turns | slides


def _span(rows: Array, tolerance: float) -> Array:
    size = np.linalg.norm(rows, axis=1, keepdims=True)
    kept = rows[size[:, 0] > tolerance]
    if len(kept) == 0:
        return np.zeros((0, 6))
    _, sigma, vt = np.linalg.svd(kept / np.linalg.norm(kept, axis=1, keepdims=True))
    return np.asarray(vt[: int((sigma > tolerance).sum())])


_SYSTEM_SAMPLES = 2  # random configurations that tell what stays


@dataclass(frozen=True, slots=True)
class ScrewSystem:
    """Joints whose motions lie in one proper subgroup.

    Attributes:
        numbers: joints from 1, all of them in the subgroup at this configuration.
        kind: "coaxial", "translational", "cylindrical", "spherical", "planar", "planar with a screw" or "Schönflies".
        dimension: of the subgroup: the most that these joints can span.
        consecutive: the numbers are a run.
        structural: in the subgroup at every configuration: the joints in between keep it as it is.
        permanent: structural, and more joints than the dimension: dependent at every configuration.
        words: the whole in English.
    """

    numbers: tuple[int, ...]
    kind: str
    dimension: int
    consecutive: bool
    structural: bool
    permanent: bool
    words: str

    @property
    def loss(self) -> int:
        """How many of the joints are too many for the dimension; 0 where they are not."""
        return max(0, len(self.numbers) - self.dimension)


def systems_at(robot: Robot, q: ArrayLike, tolerance: float = ALIGNED) -> tuple[ScrewSystem, ...]:
    """The screw systems at one configuration, those that lose most first.

    Told are sets with more joints than the subgroup has dimensions, and structural sets that just fill it (a spherical
    wrist). What a smaller set inside says as well is left out.

    Args:
        robot: the arm. A mimic joint goes with its leader: both have to lie in the subgroup.
        q: (n,) configuration [rad, m].
        tolerance: angles [rad] and lengths per reach below it are zero.

    Raises:
        ConfigurationError: q is not one configuration of this arm.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> [(s.numbers, s.kind) for s in systems_at(open_robot("puma560"), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6])]
        [((4, 5, 6), 'spherical')]
    """
    scene = Scene.of_joints(robot, one_configuration(robot, q)[None], tolerance)
    pieces: dict[tuple[int, ...], ScrewSystem] = {}
    for kind, dimension, members, keepers in subgroups(scene):
        for joints, structural in _pieces(members, keepers):
            always = structural or (len(joints) > dimension and _stay_inside(robot, joints, dimension))
            system = _system(robot, scene, kind, dimension, joints, always)
            count = len(system.numbers)
            telling = count > dimension or (structural and count == dimension >= 2)
            if telling and (system.numbers not in pieces or dimension < pieces[system.numbers].dimension):
                pieces[system.numbers] = system
    kept = [system for system in pieces.values() if not any(_says_more(other, system) for other in pieces.values())]
    return tuple(sorted(kept, key=lambda s: (not s.permanent, -s.loss, s.dimension, s.numbers)))


def always_singular_reason(robot: Robot, task: Task) -> str | None:
    """Why an arm is deficient for a task at every configuration; None where it is not.

    Either all joints lie in one subgroup, or some sets of joints, apart from each other, have fewer dimensions than
    joints: then rank ≤ n − Σ (joints − dimension). The rank itself is that of random configurations; where the systems
    do not account for all of the loss, the words say so.

    Args:
        robot: the arm.
        task: the rows that count.

    Example:
        >>> from rankdrop.robot.screws import from_screws, revolute
        >>> from rankdrop.task import resolve_task
        >>> arm = from_screws([revolute([0, 0, 1], [x, 0, 0]) for x in range(4)], order="linear-first")
        >>> print(always_singular_reason(arm, resolve_task("pose", arm)))
        rank 3 of 4 everywhere: joints 1–4 lie in a planar system (parallel axes, slides normal to them) of dimension 3
    """
    rank = generic_rank(robot, task)
    most = min(task.m, robot.n)
    if rank == most:
        return None
    q = structural_sample(robot, task, 1)[0]
    head = f"rank {rank} of {most} everywhere: "
    dimension = len(closure(_twists(robot, q, task.scale(robot))))
    if dimension < 6 and dimension == generic_rank(robot, resolve_task("pose", robot)):
        return head + _whole(robot, q, dimension, rank)
    losses = _losses(robot, task, q)
    best = max(_apart(losses), key=lambda chosen: (sum(loss for loss, _, _ in chosen), -len(chosen)))
    bound = min(most, robot.n - sum(loss for loss, _, _ in best))
    if bound > rank and dimension < 6:
        return head + _whole(robot, q, dimension, rank)
    if bound == most:
        return f"{head}no screw system of the joints accounts for it"
    words = "; ".join(one for _, _, one in best)
    return head + words + ("" if bound == rank else f"; this accounts for rank {bound}, not for {rank}")


def _stay_inside(robot: Robot, joints: tuple[int, ...], dimension: int) -> bool:
    """Whether some joints lie in a subgroup of this dimension at random configurations too."""
    points = structural_sample(robot, resolve_task("pose", robot), _SYSTEM_SAMPLES)
    every = (_twists(robot, q, reach(robot))[list(joints)] for q in points)
    return all(len(closure(twists, most=dimension)) <= dimension for twists in every)


def _twists(robot: Robot, q: Array, length: float) -> Array:
    """(N, 6) twists of every joint, mimic joints too, about the tip: rounding stays small."""
    free, values, _ = unlocked(robot, q)
    twists = jacobian(free, values).T.copy()
    twists[:, :3] /= length
    return twists


def _whole(robot: Robot, q: Array, dimension: int, rank: int) -> str:
    """All joints in one subgroup, and what the task sees of it."""
    scene = Scene.of_joints(robot, q[None])
    every = tuple(range(len(robot.joints)))
    kinds = [kind for kind, size, joints, _ in subgroups(scene) if joints == every and size == dimension]
    if kinds:
        system = f"a {kinds[0]} system ({_MEANING[kinds[0]]})"
    else:
        system = "a system"
    words = f"joints {numbers(range(robot.n))} lie in {system} of dimension {dimension}"
    if dimension == rank:
        return words
    return f"{words}, of which this task sees {rank}"


def _losses(robot: Robot, task: Task, q: Array) -> list[tuple[int, frozenset[int], str]]:
    """Structural sets with what they lose in this task: joints − rank of their columns."""
    columns = task_jacobian(robot, q, task)
    found = []
    for system in systems_at(robot, q):
        if not system.structural:
            continue
        chosen = frozenset(number - 1 for number in system.numbers)
        loss = len(chosen) - int((np.linalg.svd(columns[:, sorted(chosen)])[1] > DEPENDENT).sum())
        if loss > 0:
            what = f"joints {numbers(sorted(chosen))} lie in a {system.kind} system of dimension {system.dimension}"
            found.append((loss, chosen, f"{what} and lose {loss}"))
    for i in np.flatnonzero(np.linalg.norm(columns, axis=0) <= DEPENDENT).tolist():
        found.append((1, frozenset({i}), f"joint {i + 1} moves nothing in this task"))
    return found


def _apart(losses: list[tuple[int, frozenset[int], str]]) -> Iterator[tuple[tuple[int, frozenset[int], str], ...]]:
    """Choices of at most three sets without a common joint, the empty one included."""
    for count in range(4):
        for chosen in combinations(losses, count):
            if all(not a[1] & b[1] for a, b in combinations(chosen, 2)):
                yield chosen


def _pieces(joints: tuple[int, ...], keepers: frozenset[int]) -> Iterator[tuple[tuple[int, ...], bool]]:
    """The set itself, and its parts that surely stay together: all joints between two neighbours are keepers."""
    runs: list[list[int]] = [[joints[0]]]
    for before, joint in pairwise(joints):
        if keepers.issuperset(range(before + 1, joint)):
            runs[-1].append(joint)
        else:
            runs.append([joint])
    if len(runs) > 1:
        yield joints, False
    yield from ((tuple(run), True) for run in runs if len(run) > 1)


def _says_more(other: ScrewSystem, system: ScrewSystem) -> bool:
    """Does another system make this one superfluous? A structural one never is by one that is not."""
    if other is system or (system.structural and not other.structural):
        return False
    mine, others = set(system.numbers), set(other.numbers)
    filled_inside = system.loss == 0 and other.structural  # a part of a larger structure that is not dependent itself
    if mine < others and (other.dimension <= system.dimension or filled_inside):
        return True
    return others < mine and not system.structural and other.loss >= system.loss


_MEANING = {
    "coaxial": "one line",
    "translational": "slides",
    "cylindrical": "one line, turns and slides",
    "spherical": "axes that meet in one point",
    "planar": "parallel axes, slides normal to them",
    "planar with a screw": "parallel screws of one pitch, slides normal to them",
    "Schönflies": "parallel axes and slides",
}


def _system(
    robot: Robot, scene: Scene, kind: str, dimension: int, joints: tuple[int, ...], structural: bool
) -> ScrewSystem:
    """A set of joints in a subgroup as a record, its joints turned into variables."""
    inside = {robot.joints[i].name for i in joints}
    outside = {j.mimic.leader for j in robot.joints if j.mimic is not None and j.name not in inside}
    chosen = [i for i, joint in enumerate(robot.variables) if joint.name in inside - outside]
    slides = int(scene.slides[list(joints)].sum())
    permanent = structural and len(chosen) > dimension
    if slides == len(joints):
        what = "slides"
    elif slides:
        what = "joints"
    else:
        what = "axes"
    shared = _SHARED[f"{kind} {dimension}" if kind == "translational" else kind][bool(slides)]
    return ScrewSystem(
        numbers=tuple(i + 1 for i in chosen), kind=kind, dimension=dimension,
        consecutive=bool(chosen) and chosen[-1] - chosen[0] == len(chosen) - 1, structural=structural,
        permanent=permanent,
        words=f"{what} {numbers(chosen)} {shared} ({kind} system of dimension {dimension}), "
        f"{_WHEN[structural, permanent]}",
    )  # fmt: skip


_WHEN = {
    (False, False): "dependent here: no motion of these joints alone breaks it",
    (True, False): "at every configuration",
    (True, True): "dependent at every configuration",
}
"""Whether a system is structural, and permanent."""
_SHARED = {
    "coaxial": ("lie on one line", "lie on one line"),
    "translational 1": ("are parallel", "are parallel"),
    "translational 2": ("are parallel to one plane", "are parallel to one plane"),
    "translational 3": ("only translate", "only translate"),
    "cylindrical": ("lie on one line", "lie along one line"),
    "spherical": ("meet in one point", "meet in one point"),
    "planar": ("are parallel", "move in parallel planes"),
    "planar with a screw": ("move in parallel planes that rise by one pitch",) * 2,
    "Schönflies": ("are parallel", "turn about parallel axes and slide"),
}
"""What axes alone have in common in each kind of system, and joints with slides among them."""


LARGEST_CHAIN = 20
"""Joints; with more of them the number of sets to look at is beyond a fraction of a second."""

_REGULAR = 8  # regular configurations that tell what is dependent everywhere
_TIE = 1e-9  # coefficients closer than this share tie for the largest

Sets = tuple[NDArray[np.intp], NDArray[np.intp]]


@dataclass(frozen=True, slots=True)
class Circuit:
    """A set of joints whose columns are dependent while those of no smaller set inside it are.

    Attributes:
        numbers: joints from 1, increasing.
        coefficients: c of Σ c_i J_i = 0: joint rates that leave the task still. The largest is 1.
        units: of each coefficient, "rad" (per second) or "m" (per second).
        generic: dependent at almost every configuration too, as any m + 1 joints of a redundant arm are.
        sigma: smallest singular value of the columns scaled to unit length (0 where there are more columns than rows).
        words: what the axes have in common.
    """

    numbers: tuple[int, ...]
    coefficients: tuple[float, ...]
    units: tuple[str, ...]
    generic: bool
    sigma: float
    words: str


def circuits_at(robot: Robot, q: ArrayLike, task: Task, tolerance: float = DEPENDENT) -> tuple[Circuit, ...]:
    """Every circuit at one configuration, small ones first, then by their numbers.

    Args:
        robot: the arm; at most `LARGEST_CHAIN` variables.
        q: (n,) configuration [rad, m].
        task: rows that count; the circuits do not depend on its frame's axes or its length scale.
        tolerance: columns scaled to unit length are dependent where their smallest σ is at or below it [1].

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        OptionError: more joints than `LARGEST_CHAIN`.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("rcrrrr")
        >>> [circuit.numbers for circuit in circuits_at(arm, [0.0] * 7, resolve_task("pose", arm))]
        [(1, 3, 4, 5), (3, 4, 6, 7), (1, 3, 5, 6, 7), (1, 4, 5, 6, 7)]
    """
    configuration = one_configuration(robot, q)
    if robot.n > LARGEST_CHAIN:
        raise OptionError(
            "there are too many joints to list every circuit", where=f"robot {robot.name!r}", got=robot.n,
            allowed=f"at most {LARGEST_CHAIN}",
        )  # fmt: skip
    columns = task_jacobian(robot, configuration[None, :], task)
    sets = shared_circuits(columns, tolerance)
    usual = _unit_columns(task_jacobian(robot, structural_sample(robot, task, _REGULAR), task))
    scene = Scene(robot, configuration[None, :])
    units = robot.units
    return tuple(
        Circuit(
            numbers=tuple(i + 1 for i in members),
            coefficients=tuple(_dependency(columns[0], members)[list(members)].tolist()),
            units=tuple(units[i] for i in members),
            generic=_dependent(usual, members, tolerance),
            sigma=0.0 if len(members) > task.m else float(sigma_of(_unit_columns(columns[0])[:, members])[-1]),
            words=describe(scene, members, task),
        )
        for members in sets
    )


def blame(robot: Robot, q: ArrayLike, task: Task, tolerance: float = DEPENDENT) -> tuple[Circuit, ...]:
    """The smallest circuits, special to this configuration, that bring as many new dependencies as rank is lost.

    Dependencies count as new when they do not follow from those taken before and from the ones that hold everywhere.
    None at a regular configuration; fewer than the corank where only the whole arm tells (then `circuits_at` has none
    left either).

    Args, Raises: as `circuits_at`.
    """
    found = circuits_at(robot, q, task, tolerance)
    corank = generic_rank(robot, task) - int((singular_values(robot, q, task) > tolerance).sum())
    return make_all(found, robot.n, corank)


def make_all(circuits: Sequence[Circuit], n: int, nullity: int) -> tuple[Circuit, ...]:
    """The smallest circuits, special to this configuration, from which all its dependencies follow.

    For an arm without redundancy these are the ones of `blame`. A redundant one has n − r dependencies everywhere, and
    a single further set of dependent joints need not cost it any rank: only all of them together tell of the loss.

    Args:
        circuits: all circuits, from `circuits_at`.
        n: number of joints.
        nullity: independent dependencies, n − rank.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("pa10")
        >>> found = circuits_at(arm, [0.0] * 7, resolve_task("pose", arm))
        >>> [circuit.numbers for circuit in make_all(found, 7, 4)]  # rank 3
        [(1, 3), (1, 5), (1, 7), (2, 4, 6)]
    """
    known = [_vector(circuit, n) for circuit in circuits if circuit.generic]
    special = [circuit for circuit in circuits if not circuit.generic]
    return tuple(special[i] for i in _independent(known, [_vector(circuit, n) for circuit in special], nullity))


def _vector(circuit: Circuit, n: int) -> Array:
    result = np.zeros(n)
    result[[number - 1 for number in circuit.numbers]] = circuit.coefficients
    return result


def to_blame(columns: Array, generic: Array, corank: int) -> list[tuple[int, ...]]:
    """The smallest circuits that bring as many independent dependencies as rank is lost; fewer if there are no more.

    Args:
        columns: (N, m, n) task Jacobians at the points of a family: the circuits hold at all of them.
        generic: (M, m, n) task Jacobians at random configurations, where they do not.
        corank: how many are wanted.

    Returns:
        Tuples of indices from 0.
    """
    usual = _unit_columns(generic)
    sets = [members for members in shared_circuits(columns) if not _dependent(usual, members, DEPENDENT)]
    chosen = _independent([], [_dependency(columns[0], members) for members in sets], corank)
    return [sets[i] for i in chosen]


def shared_circuits(columns: Array, tolerance: float = DEPENDENT) -> list[tuple[int, ...]]:
    """Circuits that hold at every one of some points: smallest σ of the unit columns at or below the tolerance.

    A set is looked at when none of the sets with one member less is dependent.

    Args:
        columns: (N, m, n) task Jacobians.
        tolerance: [1].

    Returns:
        Tuples of indices from 0, small ones first.
    """
    rows, n = columns.shape[1:]
    unit = _unit_columns(columns)
    dependent = np.zeros(1 << n, dtype=bool)
    found: list[tuple[int, ...]] = []
    for size in range(1, min(rows + 1, n) + 1):
        members, masks = _sets(n, size)
        inside = dependent[masks[:, None] ^ (1 << members)].any(axis=1)
        new = ~inside
        new[new] = _all_dependent(unit, members[new], tolerance)
        dependent[masks[inside | new]] = True
        found += [tuple(chosen) for chosen in members[new].tolist()]
    return found


@lru_cache(maxsize=256)
def _sets(n: int, size: int) -> Sets:
    """(B, size) all sets of `size` out of n, and (B,) their bit masks."""
    members = np.array(list(combinations(range(n), size)), dtype=np.intp).reshape(-1, size)
    return members, (1 << members).sum(axis=1)


def _all_dependent(unit: Array, members: NDArray[np.intp], tolerance: float) -> NDArray[np.bool_]:
    """(B,) whether each set (B, s) is dependent at every point; more columns than rows always are."""
    points, rows, _ = unit.shape
    count, size = members.shape
    if size > rows or count == 0:
        return np.ones(count, dtype=bool)
    parts = unit[:, :, members].transpose(0, 2, 1, 3).reshape(-1, rows, size)
    sigma = sigma_of(parts)[:, -1]
    return np.asarray((sigma.reshape(points, count) <= tolerance).all(axis=0))


def _dependent(unit: Array, members: tuple[int, ...], tolerance: float) -> bool:
    return bool(_all_dependent(unit, np.array([members], dtype=np.intp), tolerance)[0])


def _dependency(columns: Array, members: tuple[int, ...]) -> Array:
    """(n,) c with Σ c_i J_i = 0 over a circuit, the largest entry 1 (the first of equals)."""
    own = columns[:, list(members)]
    rates = svd(_unit_columns(own))[2][:, -1] / _lengths(own)[0]
    size, result = np.abs(rates), np.zeros(columns.shape[1])
    result[list(members)] = rates / rates[int(np.argmax(size >= size.max() * (1 - _TIE)))]
    return result


def _independent(known: list[Array], vectors: list[Array], count: int) -> list[int]:
    """Indices of the first vectors, at most `count`, that are independent of each other and of the known ones."""
    taken, chosen = list(known), list[int]()
    if taken:
        rank = int(np.linalg.matrix_rank(np.array(taken), tol=1e-6))
    else:
        rank = 0
    for i, vector in enumerate(vectors):
        if len(chosen) < count and np.linalg.matrix_rank(np.array([*taken, vector]), tol=1e-6) > rank:
            chosen.append(i)
            taken.append(vector)
            rank += 1
    return chosen


def _lengths(columns: Array) -> Array:
    """Lengths of the columns; 1 for those that are rounding."""
    length = np.linalg.norm(columns, axis=-2, keepdims=True)
    return np.asarray(np.where(length > DEPENDENT, length, 1.0))


def _unit_columns(columns: Array) -> Array:
    return np.asarray(columns / _lengths(columns))
