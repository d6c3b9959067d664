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
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import combinations, pairwise

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
    """Axes and slides of every joint, mimic joints too, at one configuration.

    Attributes:
        z, p, h: directions (N, 3), points (N, 3), pitches (N,) [m/rad] in the base frame.
        parallel, normal: |z_i × z_j| = 0, and z_i · z_j = 0, of every two joints.
        one_line, one_pitch: parallel, and p_j on axis i; h_i = h_j.
    """

    def __init__(self, robot: Robot, q: Array, tolerance: float = ALIGNED) -> None:
        free, values, _ = unlocked(robot, q)
        screws = jacobian(free, values, SPACE).T
        self.tolerance, self.length = tolerance, reach(robot)
        self.slides = [i for i, joint in enumerate(free.joints) if joint.kind is JointKind.PRISMATIC]
        self.turns = [i for i in range(free.n) if i not in self.slides]
        self.z = np.where(np.isin(np.arange(free.n), self.slides)[:, None], screws[:, :3], screws[:, 3:])
        self.p = cross(screws[:, 3:], screws[:, :3])
        self.h = np.einsum("ni,ni->n", screws[:, :3], screws[:, 3:])
        self.cross = np.linalg.norm(cross(self.z[:, None], self.z[None, :]), axis=-1)
        offset = cross(self.p[None, :] - self.p[:, None], self.z[:, None]) / self.length
        parallel = self.cross < tolerance
        self.one_line: list[list[bool]] = ((np.linalg.norm(offset, axis=-1) < tolerance) & parallel).tolist()
        self.one_pitch: list[list[bool]] = (np.abs(self.h[:, None] - self.h) < tolerance * self.length).tolist()
        self.parallel: list[list[bool]] = parallel.tolist()
        self.normal: list[list[bool]] = (np.abs(self.z @ self.z.T) < tolerance).tolist()

    def through_meeting(self, i: int, j: int) -> list[bool] | None:
        """Of every joint: its axis goes through the point where axes i and j meet; None where they do not meet in one.

        They meet at p_i + s z_i, s from (p_j − p_i) × z_j = s z_i × z_j.
        """
        meet, on = self._meetings
        return on[i][j] if meet[i][j] else None

    @cached_property
    def _meetings(self) -> tuple[list[list[bool]], list[list[list[bool]]]]:
        """Of every two joints whether they meet in one point (N, N), and which axes go through it (N, N, N)."""
        skew, apart = cross(self.z[:, None], self.z[None]), self.p[None] - self.p[:, None]
        meet = self.cross >= self.tolerance
        meet &= np.abs((apart * skew).sum(axis=-1)) <= self.tolerance * self.length  # at least distance · |z_i × z_j|
        s = (cross(apart, self.z[None]) * skew).sum(axis=-1) / np.where(meet, (skew * skew).sum(axis=-1), 1.0)
        points = self.p[:, None] + s[..., None] * self.z[:, None]
        on = np.linalg.norm(cross(points[:, :, None] - self.p, self.z) / self.length, axis=-1) < self.tolerance
        number = np.arange(len(self.p))
        meet &= on[number[:, None], number, number]
        return meet.tolist(), on.tolist()


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
        first = [0 if kind is JointKind.PRISMATIC else 3 for kind in self.kinds]
        return np.stack([self.screws[:, row : row + 3, i] for i, row in enumerate(first)])

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
    words = _pattern(scene, axes, slides, task) if len(axes) + len(slides) == len(circuit) else None
    return words or f"{'screws' if task.m == 6 else 'joints'} {names} dependent"


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


def _pattern(scene: Scene, axes: Sequence[int], slides: Sequence[int], task: Task) -> str | None:
    """What dependent axes and slides have in common; None without a pattern."""
    if task.m == 6:
        if not axes:
            how = ("parallel", "parallel to one plane", "are four translations of space")[len(slides) - 2]
            return f"slides {numbers(slides)} {how}"
        special = _translations_twice(scene, axes, slides) if slides else _three_dimensions(scene, axes)
        return special or _transversal(scene, axes, slides)
    count, lines = len(axes), f"axes {numbers(axes)}"
    if slides:
        return None
    if max(task.rows) < 3:  # planes through the tip count
        flat = count == 2 and scene.coplanar(axes, scene.tip).all()
        return f"{lines} and the tip in one plane" if flat else None
    if min(task.rows) >= 3:  # directions alone count
        if count == 2 and _parallel(scene, axes):
            return f"{lines} parallel"
        flat = count == 3 and (np.abs(_dot(scene.z[axes[0]], np.cross(*scene.z[axes[1:]]))) < ALIGNED).all()
        return f"{lines} parallel to one plane" if flat else None
    return None


def _three_dimensions(scene: Scene, axes: Sequence[int]) -> str | None:
    """Axes alone: parallel, concurrent or coplanar ones have rank 3, so that no circuit of them has more than four."""
    if len(axes) == 2:
        return f"axes {numbers(axes)} aligned"
    if len(axes) > 4:
        return None
    word = "parallel" if _parallel(scene, axes) else "concurrent" if scene.common_point(axes)[1].all() else None
    if len(axes) == 4 and word is None and scene.coplanar(axes).all():
        word = "coplanar"
    return word and f"axes {numbers(axes)} {word}{' and coplanar' * (len(axes) == 3)}"


def _translations_twice(scene: Scene, axes: Sequence[int], slides: Sequence[int]) -> str | None:
    """Axes and slides: turning forth and back about parallel axes is a translation, and the slides make it too."""
    if not _parallel(scene, axes):
        return None
    normal = all(scene.perpendicular(axes[0], i).all() for i in slides)
    how = "normal to them" if normal else "along what they translate"
    if len(axes) == 2 and len(slides) == 1:
        how = "normal to their plane"
    return f"axes {numbers(axes)} parallel, {_slides(slides)} {how}"


def _slides(slides: Sequence[int]) -> str:
    return f"slide{'s' if len(slides) > 1 else ''} {numbers(slides)}"


def _transversal(scene: Scene, axes: Sequence[int], slides: Sequence[int]) -> str | None:
    """Six axes that meet one line; a line at infinity is met by axes and slides parallel to one plane."""
    circuit = sorted([*axes, *slides])
    if len(circuit) != 6:
        return None
    columns = scene.screws[..., circuit].transpose(0, 2, 1)
    about_tip = (columns[..., :3] + np.cross(columns[..., 3:], scene.tip[:, None, :])) / scene.length  # rounds least
    blocked = np.linalg.svd(np.concatenate([about_tip, columns[..., 3:]], axis=-1))[2][:, -1]
    if not _pure_force(blocked):
        return None
    return f"axes {numbers(axes)} meet one line" + (f", {_slides(slides)} normal to it" if slides else "")


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
    found = [_relation(here, *group, group in structural) for group in special + structural]
    return tuple(sorted(found, key=lambda r: (r.structural, _ORDER.index(r.kind), r.joints)))


@lru_cache(maxsize=16)
def _structure(robot: Robot, tolerance: float) -> tuple[list[Lines], list[Group]]:
    """The arm at random configurations, and the groups that it has at all of them: a robot never changes."""
    elsewhere = [Lines(robot, q, tolerance) for q in structural_sample(robot, resolve_task(None, robot), _PLACES)]
    return elsewhere, [group for group in _groups(elsewhere[0]) if all(_holds(lines, group) for lines in elsewhere)]


def _groups(lines: Lines) -> list[Group]:
    """Maximal groups of every kind, indices from 0."""
    turns, every = lines.turns, range(len(lines.z))
    aligned = {tuple(j for j in turns if lines.one_line[i][j]) for i in turns}
    through = [on for i, j in combinations(turns, 2) if (on := lines.through_meeting(i, j)) is not None]
    points = {tuple(k for k in turns if on[k]) for on in through}
    kinds: dict[str, set[tuple[int, ...]]] = {
        "aligned": aligned,
        "parallel": {tuple(j for j in every if lines.parallel[i][j]) for i in every} - aligned,
        "concurrent": {group for group in points if len(group) > 2},
        "intersecting": {group for group in points if len(group) == 2},
    }
    return [(kind, group) for kind, groups in kinds.items() for group in groups if len(group) > 1]


def _holds(lines: Lines, group: Group) -> bool:
    kind, joints = group
    pairs = list(combinations(joints, 2))
    if kind in ("aligned", "parallel"):
        related = lines.one_line if kind == "aligned" else lines.parallel
        return all(related[i][j] for i, j in pairs)
    crossing = next((pair for pair in pairs if not lines.parallel[pair[0]][pair[1]]), None)
    on = lines.through_meeting(*crossing) if crossing else None
    return on is not None and all(on[i] for i in joints)


def _relation(lines: Lines, kind: str, joints: tuple[int, ...], structural: bool) -> Relation:
    axes, slides = ([i for i in joints if i in some] for some in (lines.turns, lines.slides))
    parts = [f"{'axes' if len(axes) > 1 else 'axis'} {numbers(axes)}"] * bool(axes)
    parts += [_slides(slides)] * bool(slides)
    verb = {"aligned": "aligned", "parallel": "parallel", "concurrent": "meet in one point"}.get(kind, "intersect")
    return Relation(f"{' and '.join(parts)} {verb}", tuple(i + 1 for i in joints), kind, structural)


Subgroup = tuple[str, int, tuple[int, ...], frozenset[int]]
"""Kind and dimension of a subgroup; the joints in it, from 0 in `Robot.joints`, mimic joints included; and its keepers:
all joints, of the set or not, whose motion maps the subgroup onto itself."""


def subgroups(lines: Lines) -> list[Subgroup]:
    """The largest set of joints for every subgroup that two joints at least lie in; a set once, in the smallest."""
    smallest: dict[tuple[int, ...], Subgroup] = {}
    for kind, dimension, members, keepers in _every_subgroup(lines):
        joints = tuple(sorted(members))
        if len(joints) > 1 and (joints not in smallest or dimension < smallest[joints][1]):
            smallest[joints] = kind, dimension, joints, frozenset(keepers)
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


def _every_subgroup(lines: Lines) -> Iterator[tuple[str, int, list[int], list[int]]]:
    turns, slides = lines.turns, lines.slides
    straight = [i for i in turns if abs(lines.h[i]) < lines.tolerance * lines.length]
    for i in turns:
        axis = [j for j in turns if lines.one_line[i][j]]
        along_line = axis + [j for j in slides if lines.parallel[i][j]]
        bundle = [j for j in turns if lines.parallel[i][j]]
        across = [j for j in slides if lines.normal[i][j]]
        yield "coaxial", 1, [j for j in axis if lines.one_pitch[i][j]], along_line
        yield "cylindrical", 2, along_line, along_line
        planar = [j for j in bundle if lines.one_pitch[i][j]] + across
        yield "planar" if i in straight else "planar with a screw", 3, planar, bundle + slides
        yield "Schönflies", 4, bundle + slides, bundle + slides
    for i, j in combinations(straight, 2):
        on = lines.through_meeting(i, j)
        if on is not None:
            ball = [k for k in straight if on[k]]
            yield "spherical", 3, ball, ball
    for i in slides:
        keepers = slides + [j for j in turns if lines.parallel[i][j]]
        yield "translational", 1, [j for j in slides if lines.parallel[i][j]], keepers
    for i, j in combinations(slides, 2):
        if not lines.parallel[i][j]:
            normal = cross(lines.z[i], lines.z[j]) / lines.cross[i, j]
            plane = [k for k in slides if abs(normal @ lines.z[k]) < lines.tolerance]
            keepers = slides + [k for k in turns if np.linalg.norm(cross(normal, lines.z[k])) < lines.tolerance]
            yield "translational", 2, plane, keepers
    yield "translational", 3, slides, turns + slides


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
    pieces: dict[tuple[int, ...], ScrewSystem] = {}
    for kind, dimension, members, keepers in subgroups(lines):
        for joints, structural in _pieces(members, keepers):
            always = structural or (len(joints) > dimension and _stay_inside(robot, joints, dimension))
            system = _system(robot, lines, kind, dimension, joints, always)
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
    lines = Lines(robot, q)
    every = tuple(range(len(robot.joints)))
    kinds = [kind for kind, size, joints, _ in subgroups(lines) if joints == every and size == dimension]
    system = f"a {kinds[0]} system ({_MEANING[kinds[0]]})" if kinds else "a system"
    words = f"joints {numbers(range(robot.n))} lie in {system} of dimension {dimension}"
    return words if dimension == rank else f"{words}, of which this task sees {rank}"


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
    robot: Robot, lines: Lines, kind: str, dimension: int, joints: tuple[int, ...], structural: bool
) -> ScrewSystem:
    """A set of joints in a subgroup as a record, its joints turned into variables."""
    inside = {robot.joints[i].name for i in joints}
    outside = {j.mimic.leader for j in robot.joints if j.mimic is not None and j.name not in inside}
    chosen = [i for i, joint in enumerate(robot.variables) if joint.name in inside - outside]
    slides = sum(i in lines.slides for i in joints)
    permanent = structural and len(chosen) > dimension
    what = "slides" if slides == len(joints) else "joints" if slides else "axes"
    when = "dependent here: no motion of these joints alone breaks it"
    if structural:
        when = "dependent at every configuration" if permanent else "at every configuration"
    return ScrewSystem(
        numbers=tuple(i + 1 for i in chosen), kind=kind, dimension=dimension,
        consecutive=bool(chosen) and chosen[-1] - chosen[0] == len(chosen) - 1, structural=structural,
        permanent=permanent,
        words=f"{what} {numbers(chosen)} {_shared(kind, dimension, bool(slides))} ({kind} system of dimension "
        f"{dimension}), {when}",
    )  # fmt: skip


def _shared(kind: str, dimension: int, slides: bool) -> str:
    return {
        "coaxial": "lie on one line",
        "translational": ("are parallel", "are parallel to one plane", "only translate")[min(dimension, 3) - 1],
        "cylindrical": "lie along one line" if slides else "lie on one line",
        "spherical": "meet in one point",
        "planar": "move in parallel planes" if slides else "are parallel",
        "planar with a screw": "move in parallel planes that rise by one pitch",
        "Schönflies": "turn about parallel axes and slide" if slides else "are parallel",
    }[kind]
