"""What is drawn for a configuration, as numbers: poses of the links, rods of the slides, arrows of what is lost.

An arm without meshes: capsules along the links, barrels at the turning joints, rods at the slides.

What is known of a configuration the moment it is reached: fast enough for every movement of a slider.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain, pairwise

import numpy as np
from numpy.typing import NDArray

from rankdrop.distance import Monitor, Sighting
from rankdrop.families import Family
from rankdrop.kinematics import link_poses
from rankdrop.local import LARGEST_CHAIN, Circuit, arrow_of, blame, lost_directions, ring_about, skeleton
from rankdrop.results import first_verdict
from rankdrop.robot import Array, JointKind, Robot, reach
from rankdrop.task import Task, link_index

THIN = 0.022  # radius of a capsule, as a share of the reach
_HALF = 2.5  # of a joint, in radii of a link
_AXIS = 0.3 / (_HALF * THIN)  # half the line of an axis, 0.3 of the reach, over half its joint
_SHORT = 1e-6  # a capsule shorter than this share of the reach is left out

LENGTH = 0.32  # of an arrow, as a share of the size
_OF_ARM = 0.25  # of an arrow at most, as a share of the diagonal of the arm as it stands
DASHES = 7  # of a dotted arrow
HEAD = 0.18  # share of an arrow that is its head
RINGS = 6  # capsule ends
AROUND = 20  # capsule sides


@dataclass(frozen=True, eq=False)
class Bar:
    """A piece of a link, a joint, or the rod of a slide.

    Attributes:
        link: index of `link_poses` in whose frame it stands: 0 the base, i the link after joint i.
        start, end: (3,) [m]; the end of a rod in the frame of the next link, so that it grows as the slide moves.
        radius: [m].
        joint: number of the joint from 1, mimic joints counted; 0 of a link.
        variable: number of the variable that moves the joint, from 1; 0 of a link.
    """

    link: int
    start: Array
    end: Array
    radius: float
    joint: int = 0
    variable: int = 0


Body = dict[str, tuple[Bar, ...]]
"""Bars of an arm: "link" (capsules), "joint" (barrels), "rod" (of the slides)."""


def body_of(robot: Robot) -> Body:
    """The arm as bars through the points of `skeleton`, as the page and the figures draw it."""
    size = reach(robot)
    thin = THIN * size
    into = [np.linalg.inv(frame) for frame in (np.eye(4), *(joint.frame for joint in robot.joints))]
    points, middles = skeleton(robot)
    ends = [np.zeros(3), *points, robot.home[:3, 3]]
    numbers = {joint.name: number for number, joint in enumerate(robot.variables, start=1)}
    links = tuple(
        Bar(link, carry_points(into[link], start), carry_points(into[link], end), thin)
        for link, (start, end) in enumerate(pairwise(ends)) if np.linalg.norm(end - start) > _SHORT * size
    )  # fmt: skip
    barrels, rods = [], []
    for number, (joint, point, middle) in enumerate(zip(robot.joints, points, middles, strict=True), start=1):
        slides = joint.kind is JointKind.PRISMATIC
        half = _HALF * thin * (joint.screw[:3] if slides else joint.screw[3:])
        marks = (number, numbers[joint.name if joint.mimic is None else joint.mimic.leader])
        low, high = (carry_points(into[number - slides], middle + way) for way in (-half, half))
        barrels.append(Bar(number - slides, low, high, 1.55 * thin, *marks))
        if slides:
            before, after = (carry_points(into[k], point) for k in (number - 1, number))
            rods.append(Bar(number - 1, before, after, 0.8 * thin, *marks))
    return {"link": links, "joint": tuple(barrels), "rod": tuple(rods)}


def carry_points(pose: Array, points: Array) -> Array:
    """(..., 3) points moved by a pose (4, 4)."""
    return np.asarray(points @ pose[:3, :3].T + pose[:3, 3])


@dataclass(frozen=True, eq=False)
class Arrow:
    """The arrow of one lost freedom in the base frame.

    Attributes:
        start, end: (3,) [m].
        turns: a rotation, drawn dotted (AM); a translation is solid.
        number: of the direction it belongs to, from 0.
        ring: (S, 2, 3) a ring about its foot, where a rotation is tied to the translation; else empty.
    """

    start: Array
    end: Array
    turns: bool
    number: int
    ring: Array

    @property
    def neck(self) -> Array:
        """(3,) where the head begins."""
        return np.asarray(self.end - HEAD * (self.end - self.start))

    def segments(self) -> Array:
        """(DASHES, 2, 3) the dashes of a dotted shaft."""
        return np.linspace(self.start, self.neck, 2 * DASHES).reshape(DASHES, 2, 3)


def task_frame(links: Array, task: Task) -> tuple[Array, Array]:
    """Axes (3, 3) and reference point (3,) of the task's frame in the base frame.

    Args:
        links: (N + 2, 4, 4) from `link_poses`.
        task: its frame.
    """
    frame, joints = task.frame, len(links) - 2
    axes, carrier = (links[link_index(which, joints, "frame")] for which in (frame.axes, frame.origin))
    return axes[:3, :3], carry_points(carrier, np.array(frame.point))


def arrows(directions: Array, links: Array, task: Task, size: float, share: float = LENGTH) -> tuple[Arrow, ...]:
    """One arrow for each of the directions (k, 6) of the task's frame, as `arrow_of` makes it.

    Args:
        directions: unit rows (v; ω) in the task's frame, from `lost_directions`.
        links: (N + 2, 4, 4) from `link_poses`.
        task: its frame.
        size: of the arm [m].
        share: of the size that an arrow is long.
    """
    axes, point = task_frame(links, task)
    drawn, long = [], share * size
    for number, direction in enumerate(np.asarray(directions, dtype=np.float64)):
        arrow, axis, turns = arrow_of(direction)
        if axis.any():
            ring = point + long * ring_about(axes @ axis)
        else:
            ring = np.empty((0, 3))
        segments = np.stack([ring[:-1], ring[1:]], axis=1)
        drawn.append(Arrow(point, point + long * (axes @ arrow), turns, number, segments))
    return tuple(drawn)


def rods(body: Body, links: Array) -> Array:
    """(R, 2, 3) ends of the slides' rods in the base frame [m]."""
    ends = [
        [carry_points(links[rod.link], rod.start), carry_points(links[rod.link + 1], rod.end)] for rod in body["rod"]
    ]
    return np.array(ends, dtype=np.float64).reshape(-1, 2, 3)


def axis_lines(body: Body, links: Array, variables: Sequence[int]) -> Array:
    """(A, 2, 3) the axes of some variables as long lines through their barrels, in the base frame [m].

    One line for each of them, in their order; of a variable that moves several joints, the axis of the first.
    """
    barrels = [next(barrel for barrel in body["joint"] if barrel.variable == variable) for variable in variables]
    ends = [carry_points(links[barrel.link], np.stack([barrel.start, barrel.end])) for barrel in barrels]
    lines = np.array(ends, dtype=np.float64).reshape(-1, 2, 3)
    middles = lines.mean(axis=1, keepdims=True)
    return np.asarray(middles + _AXIS * (lines - middles))


def circuit_of(circuits: Sequence[Sequence[int]]) -> dict[int, int]:
    """Variable -> the first of the circuits (from 0) that it belongs to: the smallest, as they are ordered."""
    blamed = dict.fromkeys(chain.from_iterable(circuits))
    return {number: next(k for k, circuit in enumerate(circuits) if number in circuit) for number in blamed}


def wxyz(turns: Array) -> Array:
    """Unit quaternions (..., 4), w ≥ 0, of rotation matrices (..., 3, 3)."""
    from viser.transforms import SO3

    quaternions = np.asarray(SO3.from_matrix(np.asarray(turns, dtype=np.float64)).wxyz)
    return np.asarray(np.where(quaternions[..., :1] < 0, -quaternions, quaternions))


def turn_onto(axis: Array) -> Array:
    """(3, 3) a rotation that takes z to a unit axis."""
    z = np.array([0.0, 0.0, 1.0])
    cross, cosine = np.cross(z, axis), float(z @ axis)
    if cosine < -1 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    skew = np.array([[0, -cross[2], cross[1]], [cross[2], 0, -cross[0]], [-cross[1], cross[0], 0]])
    return np.asarray(np.eye(3) + skew + skew @ skew / (1 + cosine))


def solid_of_revolution(start: Array, end: Array, outline: Array, sides: int) -> tuple[Array, NDArray[np.uint32]]:
    """Vertices (V, 3) and triangles (F, 3), outward normals, of a solid of revolution about the way from start to end.

    Args:
        start, end: (3,) [m].
        outline: (P, 2) place along the way and radius [m]; a point given twice makes a sharp edge.
        sides: of the circle.
    """
    way = end - start
    length = float(np.linalg.norm(way))
    if length > 0:
        turn = turn_onto(way / length)
    else:
        turn = np.eye(3)
    around = np.linspace(0.0, 2 * np.pi, sides, endpoint=False)
    place, radius = outline[:, :1] + 0.0 * around, outline[:, 1:]
    vertices = np.stack([radius * np.cos(around), radius * np.sin(around), place], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(len(outline) - 1), np.arange(sides), indexing="ij")
    a, b = i * sides + j, i * sides + (j + 1) % sides
    faces = np.stack([a, b, b + sides, a, b + sides, a + sides], axis=-1).reshape(-1, 3)
    corners = vertices[faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return vertices @ turn.T + start, faces[areas > 1e-9 * areas.max()].astype(np.uint32)


def capsule_mesh(start: Array, end: Array, radius: float) -> tuple[Array, NDArray[np.uint32]]:
    """Vertices and triangles of a capsule."""
    polar = np.linspace(0.0, np.pi / 2, RINGS)
    cap = radius * np.stack([-np.cos(polar), np.sin(polar)], axis=1)
    far = cap[::-1] * [-1.0, 1.0] + [float(np.linalg.norm(end - start)), 0.0]
    return solid_of_revolution(start, end, np.concatenate([cap, far]), AROUND)


def barrel_mesh(
    start: Array, end: Array, radius: float, *, sides: int = AROUND + 8, taper: float = 1.0
) -> tuple[Array, NDArray[np.uint32]]:
    """Vertices and triangles of a closed cylinder with sharp edges.

    Args:
        start, end: (3,) middles of its flat ends [m].
        radius: [m].
        sides: of its outline; 4 make a box.
        taper: radius of its far end over that of its near end: 0.001 makes a cone.
    """
    low, high = np.array([0.0, radius]), np.array([float(np.linalg.norm(end - start)), taper * radius])
    outline = np.array([low * [1, 0], low, low, high, high, high * [1, 0]])
    return solid_of_revolution(start, end, outline, sides)


@dataclass(frozen=True, eq=False)
class Now:
    """One configuration as it is drawn.

    Attributes:
        q: (n,) [rad, m].
        verdict: "regular", "near", "singular", "always-singular" by the distance.
        seen: what the monitor says: σ, corank, family, residual.
        family: the one q lies on; None at a regular configuration, or where no known one holds.
        nearest: the known one that is nearest; None where another singular configuration is, or none was reached.
        distance: to it, or to that configuration, as `Monitor.distances` measures it [rad]; inf where none was reached.
        at_least: no singular configuration is nearer than this: proven [rad].
        links: (N + 2, 4, 4) from `link_poses`.
        lost: (k, 6) lost directions in the task's frame; at a configuration that is not singular the weakest one.
        arrows: they as arrows, one each.
        blamed: circuits to blame; empty where the configuration is not singular.
        outside: joints (from 1) beyond a limit.
    """

    q: Array
    verdict: str
    seen: Sighting
    family: Family | None
    nearest: Family | None
    distance: float
    at_least: float
    links: Array
    lost: Array
    arrows: tuple[Arrow, ...]
    blamed: tuple[Circuit, ...]
    outside: tuple[int, ...]

    @property
    def sigma(self) -> Array:
        """(min(m, n),) singular values, descending."""
        return self.seen.sigma


class Live:
    """One arm and task under watch.

    Args:
        robot, task: the arm.
        families: known ones; those that have no equations are never named.
    """

    def __init__(self, robot: Robot, task: Task, families: tuple[Family, ...]) -> None:
        self.robot, self.task, self.families = robot, task, families
        self.monitor = Monitor(robot, task, families)
        self.generic_rank = self.monitor.generic_rank
        self.body, self.size = body_of(robot), reach(robot)
        self._lower, self._upper = robot.lower - 1e-9, robot.upper + 1e-9

    def look(self, q: Array) -> Now:
        """Everything that is cheap, at one configuration (n,) [rad, m]."""
        q = np.array(q, dtype=np.float64)
        seen = self.monitor.look_one(q)
        far = self.monitor.distances(q[None])
        nearest, distance = (values[0] for values in far.nearest())
        links = link_poses(self.robot, q)
        extent = float(np.linalg.norm(np.ptp(links[:, :3, 3], axis=0)))
        r = self.generic_rank
        if r:
            lost = lost_directions(self.robot, q, self.task, max(1, seen.corank))
        else:
            lost = np.zeros((0, 6))
        blamed: tuple[Circuit, ...] = ()
        if seen.corank and self.robot.n <= LARGEST_CHAIN:
            blamed = blame(self.robot, q, self.task)
        sigma = float(seen.sigma[r - 1]) if r else 0.0
        return Now(
            q=q,
            verdict=first_verdict(seen.corank, r, min(self.task.m, self.robot.n), sigma, float(distance)),
            seen=seen,
            family=self.families[seen.family] if seen.family >= 0 else None,
            nearest=self.families[nearest] if nearest >= 0 else None,
            distance=float(distance),
            at_least=float(far.at_least[0]),
            links=links,
            lost=lost,
            arrows=arrows(lost, links, self.task, self.size, min(LENGTH, _OF_ARM * extent / self.size)),
            blamed=blamed,
            outside=tuple(int(i) + 1 for i in np.flatnonzero((q < self._lower) | (q > self._upper))),
        )
