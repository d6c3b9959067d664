"""What the axes of an arm have in common: relations, dependent sets in words, screw systems.

`Lines` holds every axis at one configuration, mimic joints included; `Scene` the axes of the variables at many.

Dependent sets of joints follow Paden and Sastry (two collinear axes, three parallel coplanar ones, four that meet in a
point, four in a plane, a slide normal to the plane of two parallel axes, six that meet a line), and what these leave
out.

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
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop.kinematics import jacobian, one_configuration, pose, task_jacobian
from rankdrop.local.block import generic_rank, structural_sample
from rankdrop.local.bracket import bracket, cross
from rankdrop.local.departure import unlocked
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.numbers import reach
from rankdrop.task import SPACE, Task, resolve_task, six_rows
from rankdrop.tolerances import ALIGNED, DEPENDENT


class Lines:
    """Axes and slides of every joint, mimic joints too, at one configuration."""

    def __init__(self, robot: Robot, q: Array, tolerance: float = ALIGNED) -> None:
        """Directions z (N, 3), points p (N, 3), pitches h (N,) [m/rad] in the base frame."""
        free, values, _ = unlocked(robot, q)
        screws = jacobian(free, values, SPACE).T
        self.tolerance, self.length = tolerance, reach(robot)
        self.slides = [i for i, joint in enumerate(free.joints) if joint.kind is JointKind.PRISMATIC]
        self.turns = [i for i in range(free.n) if i not in self.slides]
        self.z = np.where(np.isin(np.arange(free.n), self.slides)[:, None], screws[:, :3], screws[:, 3:])
        self.p = cross(screws[:, 3:], screws[:, :3])
        self.h = np.einsum("ni,ni->n", screws[:, :3], screws[:, 3:])
        self.cross = np.linalg.norm(cross(self.z[:, None], self.z[None, :]), axis=-1)
        self.dot = np.abs(self.z @ self.z.T)
        offset = cross(self.p[None, :] - self.p[:, None], self.z[:, None]) / self.length
        parallel = self.cross < tolerance
        self._line = ((np.linalg.norm(offset, axis=-1) < tolerance) & parallel).tolist()
        self._parallel, self._normal = parallel.tolist(), (self.dot < tolerance).tolist()

    def parallel(self, i: int, j: int) -> bool:
        """|z_i × z_j| = 0."""
        known: bool = self._parallel[i][j]
        return known

    def normal(self, i: int, j: int) -> bool:
        """z_i · z_j = 0."""
        known: bool = self._normal[i][j]
        return known

    def one_line(self, i: int, j: int) -> bool:
        """Parallel, and p_j on axis i."""
        known: bool = self._line[i][j]
        return known

    def one_pitch(self, i: int, j: int) -> bool:
        """h_i = h_j."""
        return bool(abs(self.h[i] - self.h[j]) < self.tolerance * self.length)

    def through_meeting(self, i: int, j: int) -> list[bool] | None:
        """Of every joint: its axis goes through the point where axes i and j meet; None where they do not meet in one.

        They meet at p_i + s z_i, s from (p_j − p_i) × z_j = s z_i × z_j.
        """
        met, on = self._meetings
        return on[i][j] if met[i][j] else None

    @cached_property
    def _meetings(self) -> tuple[list[list[bool]], list[list[list[bool]]]]:
        """Of every two joints whether they meet in one point (N, N), and which axes go through it (N, N, N)."""
        skew, apart = cross(self.z[:, None], self.z[None]), self.p[None] - self.p[:, None]
        met = self.cross >= self.tolerance
        met &= np.abs((apart * skew).sum(axis=-1)) <= self.tolerance * self.length  # at least distance · |z_i × z_j|
        size = (skew * skew).sum(axis=-1)
        s = (cross(apart, self.z[None]) * skew).sum(axis=-1) / np.where(met, size, 1.0)
        points = self.p[:, None] + s[..., None] * self.z[:, None]
        offset = cross(points[:, :, None] - self.p, self.z) / self.length
        on = np.linalg.norm(offset, axis=-1) < self.tolerance
        number = np.arange(len(self.p))
        met &= on[number[:, None], number, number]
        return met.tolist(), on.tolist()


Verdicts = NDArray[np.bool_]  # one per configuration


@dataclass(frozen=True, eq=False)
class Scene:
    """Joint axes at N configurations, in the base frame. Joints are numbered from 0 here.

    An axis (revolute joint) is the line p_i + s z_i with z = ω, p = ω × v. The questions below take axes only.
    """

    robot: Robot
    q: Array  # (N, n)
    tolerance: float = ALIGNED

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
    def z(self) -> Array:
        """(n, N, 3) unit directions of the axes; those of the slides for prismatic joints."""
        slides = [kind is JointKind.PRISMATIC for kind in self.kinds]
        parts = [self.screws[:, :3, i] if slide else self.screws[:, 3:, i] for i, slide in enumerate(slides)]
        return np.stack(parts)

    @cached_property
    def p(self) -> Array:
        """(n, N, 3) the points of the axes nearest to the base origin [m]."""
        return np.stack([np.cross(self.screws[:, 3:, i], self.screws[:, :3, i]) for i in range(self.robot.n)])

    @cached_property
    def tip(self) -> Array:
        """(N, 3) the tip [m]."""
        return pose(self.robot, self.q)[..., :3, 3]

    @cached_property
    def length(self) -> float:
        """Reach of the arm [m]; distances are judged against it."""
        return reach(self.robot)

    def moved(self, joint: int, by: float) -> Scene:
        """The scene after one joint has moved by `by` [rad, m]."""
        q = self.q.copy()
        q[:, joint] += by
        return Scene(self.robot, q, self.tolerance)

    def parallel(self, i: int, j: int) -> Verdicts:
        """|z_i × z_j| = 0."""
        return self._small(np.cross(self.z[i], self.z[j]))

    def perpendicular(self, i: int, j: int) -> Verdicts:
        """z_i · z_j = 0."""
        return np.abs(_dot(self.z[i], self.z[j])) < self.tolerance

    def aligned(self, i: int, j: int) -> Verdicts:
        """One line: parallel, and (p_j − p_i) × z_i = 0."""
        return self.parallel(i, j) & self.on_axis(self.p[j], i)

    def on_axis(self, point: Array, i: int) -> Verdicts:
        """(point − p_i) × z_i = 0 for a point (N, 3)."""
        return self._small(np.cross(point - self.p[i], self.z[i]) / self.length)

    def meeting(self, i: int, j: int) -> Verdicts:
        """Not parallel and in one plane: (p_j − p_i) · (z_i × z_j) = 0."""
        volume = _dot(self.p[j] - self.p[i], np.cross(self.z[i], self.z[j]))
        return ~self.parallel(i, j) & (np.abs(volume) < self.tolerance * self.length)

    def common_point(self, axes: Sequence[int]) -> tuple[Array, Verdicts]:
        """(N, 3) the point nearest to some axes, Σ (1 − z zᵀ)(x − p) = 0, and whether it is on all of them."""
        normal = np.eye(3) - self.z[list(axes)][..., :, None] * self.z[list(axes)][..., None, :]  # (a, N, 3, 3)
        total = normal.sum(axis=0)
        right = (normal @ self.p[list(axes)][..., None]).sum(axis=0)
        regular = np.linalg.eigvalsh(total)[:, 0] > self.tolerance  # 0 where all are parallel
        point = np.linalg.solve(np.where(regular[:, None, None], total, np.eye(3)), right)[..., 0]
        on = np.stack([self.on_axis(point, i) for i in axes]).all(axis=0)
        return point, on & regular

    def in_plane(self, point: Array, i: int, direction: Array) -> Verdicts:
        """In the plane through axis i along `direction` (N, 3): (point − p_i) · (z_i × direction) = 0."""
        return np.abs(_dot(point - self.p[i], np.cross(self.z[i], direction))) < self.tolerance * self.length

    def coplanar(self, axes: Sequence[int], point: Array | None = None) -> Verdicts:
        """All axes (and the point) in one plane."""
        first = axes[0]
        spans = [self.z[i] for i in axes] + [(self.p[i] - self.p[first]) / self.length for i in axes[1:]]
        if point is not None:
            spans.append((point - self.p[first]) / self.length)
        # remove the freedom along the first axis from the points: only their offset from it counts
        stacked = np.stack([s - self.z[first] * _dot(s, self.z[first])[:, None] for s in spans], axis=1)  # (N, s, 3)
        return np.linalg.svd(stacked, compute_uv=False)[:, 1] < self.tolerance

    def _small(self, vector: Array) -> Verdicts:
        return np.asarray(np.linalg.norm(vector, axis=-1) < self.tolerance)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("...i,...i->...", a, b))


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
        elsewhere = [Lines(robot, c, tolerance) for c in structural_sample(robot, resolve_task(None, robot), _PLACES)]
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


@dataclass(frozen=True, slots=True)
class Member:
    """The largest set of joints inside one subgroup.

    Attributes:
        kind: "coaxial", "translational", "cylindrical", "spherical", "planar", "planar with a screw" or "Schönflies".
        dimension: of the subgroup.
        joints: indices from 0 in `Robot.joints`, mimic joints included.
        keepers: all joints, of the set or not, whose motion maps the subgroup onto itself.
    """

    kind: str
    dimension: int
    joints: tuple[int, ...]
    keepers: frozenset[int]


def members(lines: Lines) -> list[Member]:
    """The largest set of joints for every subgroup that two joints at least lie in; a set once, in the smallest."""
    found: dict[tuple[int, ...], Member] = {}
    for member in _all_members(lines):
        known = found.get(member.joints)
        if len(member.joints) > 1 and (known is None or member.dimension < known.dimension):
            found[member.joints] = member
    return list(found.values())


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


def _all_members(lines: Lines) -> Iterator[Member]:
    turns, slides = lines.turns, lines.slides
    straight = [i for i in turns if abs(lines.h[i]) < lines.tolerance * lines.length]
    for i in turns:
        axis = [j for j in turns if lines.one_line(i, j)]
        along = [j for j in slides if lines.parallel(i, j)]
        bundle = [j for j in turns if lines.parallel(i, j)]
        keep_line, keep_direction = axis + along, bundle + slides
        across = [j for j in slides if lines.normal(i, j)]
        pitched = [j for j in bundle if lines.one_pitch(i, j)]
        yield _member("coaxial", 1, [j for j in axis if lines.one_pitch(i, j)], keep_line)
        yield _member("cylindrical", 2, axis + along, keep_line)
        yield _member("planar" if i in straight else "planar with a screw", 3, pitched + across, keep_direction)
        yield _member("Schönflies", 4, keep_direction, keep_direction)
    for i, j in combinations(straight, 2):
        on = lines.through_meeting(i, j)
        if on is not None:
            ball = [k for k in straight if on[k]]
            yield _member("spherical", 3, ball, ball)
    yield from _translations(lines)


def _translations(lines: Lines) -> Iterator[Member]:
    turns, slides = lines.turns, lines.slides
    for i in slides:
        keepers = slides + [j for j in turns if lines.parallel(i, j)]
        yield _member("translational", 1, [j for j in slides if lines.parallel(i, j)], keepers)
    for i, j in combinations(slides, 2):
        if not lines.parallel(i, j):
            normal = cross(lines.z[i], lines.z[j]) / lines.cross[i, j]
            plane = [k for k in slides if abs(normal @ lines.z[k]) < lines.tolerance]
            keepers = slides + [k for k in turns if np.linalg.norm(cross(normal, lines.z[k])) < lines.tolerance]
            yield _member("translational", 2, plane, keepers)
    yield _member("translational", 3, slides, turns + slides)


def _member(kind: str, dimension: int, joints: list[int], keepers: list[int]) -> Member:
    return Member(kind, dimension, tuple(sorted(joints)), frozenset(keepers))


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
    lines = Lines(robot, one_configuration(robot, q), tolerance)
    elsewhere: list[Array] = []  # worked out when first needed
    pieces: dict[tuple[int, ...], ScrewSystem] = {}
    for member in members(lines):
        for joints, structural in _pieces(member):
            overfull = len(joints) > member.dimension
            if overfull and not structural and not elsewhere:
                elsewhere = _elsewhere(robot)
            always = structural or (overfull and all(
                len(closure(twists[list(joints)], most=member.dimension)) <= member.dimension for twists in elsewhere
            ))  # fmt: skip
            system = _system(robot, lines, member, joints, always)
            count = len(system.numbers)
            telling = count > system.dimension or (structural and count == system.dimension >= 2)
            known = pieces.get(system.numbers)
            if telling and (known is None or system.dimension < known.dimension):
                pieces[system.numbers] = system
    told = [system for system in pieces.values() if not any(_says_more(other, system) for other in pieces.values())]
    return tuple(sorted(told, key=lambda s: (not s.permanent, -s.loss, s.dimension, s.numbers)))


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
    told = "; ".join(words for _, _, words in best)
    return head + told + ("" if bound == rank else f"; this accounts for rank {bound}, not for {rank}")


def _elsewhere(robot: Robot) -> list[Array]:
    """Joint twists (N, 6) at random configurations, about the tip, lengths per reach."""
    points = structural_sample(robot, resolve_task("pose", robot), _SYSTEM_SAMPLES)
    return [_twists(robot, q, reach(robot)) for q in points]


def _twists(robot: Robot, q: Array, length: float) -> Array:
    """(N, 6) twists of every joint, mimic joints too, about the tip: rounding stays small."""
    free, values, _ = unlocked(robot, q)
    twists = jacobian(free, values).T.copy()
    twists[:, :3] /= length
    return twists


def _whole(robot: Robot, q: Array, dimension: int, rank: int) -> str:
    """All joints in one subgroup, and what the task sees of it."""
    lines = Lines(robot, q)
    every = tuple(range(len(robot.joints)))
    whole = [member for member in members(lines) if member.joints == every and member.dimension == dimension]
    system = f"a {whole[0].kind} system ({_MEANING[whole[0].kind]})" if whole else "a system"
    told = f"joints {numbers(range(robot.n))} lie in {system} of dimension {dimension}"
    return told if dimension == rank else f"{told}, of which this task sees {rank}"


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


def _pieces(member: Member) -> Iterator[tuple[tuple[int, ...], bool]]:
    """The set itself, and its parts that surely stay together: all joints between two neighbours are keepers."""
    runs: list[list[int]] = [[member.joints[0]]]
    for before, joint in zip(member.joints, member.joints[1:], strict=False):
        if all(between in member.keepers for between in range(before + 1, joint)):
            runs[-1].append(joint)
        else:
            runs.append([joint])
    if len(runs) > 1:
        yield member.joints, False
    for run in runs:
        if len(run) > 1:
            yield tuple(run), True


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


def _system(robot: Robot, lines: Lines, member: Member, joints: tuple[int, ...], structural: bool) -> ScrewSystem:
    """A piece of a member as a record, its joints turned into variables."""
    names = [joint.name for joint in robot.variables]
    inside = {robot.joints[i].name for i in joints}
    outside = {j.mimic.leader for j in robot.joints if j.mimic is not None and j.name not in inside}
    chosen = tuple(i for i, name in enumerate(names) if name in inside - outside)
    permanent = structural and len(chosen) > member.dimension
    consecutive = bool(chosen) and chosen[-1] - chosen[0] == len(chosen) - 1
    system = ScrewSystem(
        numbers=tuple(i + 1 for i in chosen), kind=member.kind, dimension=member.dimension, consecutive=consecutive,
        structural=structural, permanent=permanent, words="",
    )
    slides = [i for i in joints if i in lines.slides]
    return replace(system, words=_words(system, bool(slides), len(slides) == len(joints)))


def _words(system: ScrewSystem, slides: bool, only_slides: bool) -> str:
    what = "slides" if only_slides else "joints" if slides else "axes"
    has = {
        "coaxial": "lie on one line",
        "translational": ("are parallel", "are parallel to one plane", "only translate")[min(system.dimension, 3) - 1],
        "cylindrical": "lie along one line" if slides else "lie on one line",
        "spherical": "meet in one point",
        "planar": "move in parallel planes" if slides else "are parallel",
        "planar with a screw": "move in parallel planes that rise by one pitch",
        "Schönflies": "turn about parallel axes and slide" if slides else "are parallel",
    }[system.kind]
    which = numbers([number - 1 for number in system.numbers])
    head = f"{what} {which} {has} ({system.kind} system of dimension {system.dimension})"
    if system.permanent:
        return f"{head}, dependent at every configuration"
    if system.structural:
        return f"{head}, at every configuration"
    return f"{head}, dependent here: no motion of these joints alone breaks it"
