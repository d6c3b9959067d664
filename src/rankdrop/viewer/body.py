"""An arm without meshes: capsules along the links, barrels at the turning joints, rods at the slides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.local import skeleton
from rankdrop.robot import Array, JointKind, Robot, reach

THIN = 0.022  # radius of a capsule, as a share of the reach
_PARALLEL = 1e-6  # |z × z'| below which two axes are taken for parallel
_SHORT = 1e-6  # a capsule shorter than this share of the reach is left out


@dataclass(frozen=True, eq=False)
class Capsule:
    """A link, or a piece of one.

    Attributes:
        link: index of `link_poses`: 0 the base, i the link after joint i.
        start, end: (3,) in the frame of that link [m].
        radius: [m].
    """

    link: int
    start: Array
    end: Array
    radius: float


@dataclass(frozen=True, eq=False)
class Barrel:
    """A turning joint, or the block in which one slides.

    Attributes:
        joint: number of the joint from 1, mimic joints counted.
        variable: number of the variable that moves it, from 1.
        link: index of `link_poses` that it turns with.
        centre, axis: (3,) in the frame of that link [m; unit].
        length, radius: [m].
        slides: whether the joint is prismatic.
    """

    joint: int
    variable: int
    link: int
    centre: Array
    axis: Array
    length: float
    radius: float
    slides: bool


@dataclass(frozen=True, eq=False)
class Rod:
    """The rod of a slide: from a point of the link before it to a point of the link after it, which part as it moves.

    Attributes:
        joint, variable: as of `Barrel`.
        before, after: (3,) the points in the frames of links joint − 1 and joint [m].
        radius: [m].
    """

    joint: int
    variable: int
    before: Array
    after: Array
    radius: float


@dataclass(frozen=True, eq=False)
class Body:
    """All of them, and the size by which they are drawn [m]."""

    capsules: tuple[Capsule, ...]
    barrels: tuple[Barrel, ...]
    rods: tuple[Rod, ...]
    size: float


def body_of(robot: Robot) -> Body:
    """The arm as capsules and barrels.

    The spine runs from the base along each axis to the common normal with the next one, across it, and so on to the
    tip; for parallel axes the normal starts where the spine is. Its pieces belong to the links.
    """
    size = reach(robot)
    thin = THIN * size
    places = _places(robot)
    frames = [np.eye(4), *(joint.frame for joint in robot.joints)]
    capsules: list[Capsule] = []
    barrels: list[Barrel] = []
    rods: list[Rod] = []
    position = np.zeros(3)
    numbers = _variables(robot)
    for number, (joint, (arrival, departure)) in enumerate(zip(robot.joints, places, strict=True), start=1):
        _add(capsules, number - 1, frames[number - 1], position, arrival, thin, size)
        _add(capsules, number, frames[number], arrival, departure, thin, size)
        slides = joint.kind is JointKind.PRISMATIC
        centre = arrival if slides else 0.5 * (arrival + departure)
        axis = joint.screw[:3] if slides else joint.screw[3:]
        link = number - 1 if slides else number
        barrels.append(
            Barrel(number, numbers[number - 1], link, _into(frames[link], centre), frames[link][:3, :3].T @ axis,
                   5.0 * thin, 1.55 * thin, slides)
        )  # fmt: skip
        if slides:
            before, after = _into(frames[number - 1], arrival), _into(frames[number], arrival)
            rods.append(Rod(number, numbers[number - 1], before, after, 0.8 * thin))
        position = departure
    _add(capsules, len(robot.joints), frames[-1], position, robot.home[:3, 3], thin, size)
    return Body(tuple(capsules), tuple(barrels), tuple(rods), size)


def _variables(robot: Robot) -> list[int]:
    """Number of the variable behind each joint."""
    own = {joint.name: number for number, joint in enumerate(robot.variables, start=1)}
    return [own[joint.name if joint.mimic is None else joint.mimic.leader] for joint in robot.joints]


def _add(capsules: list[Capsule], link: int, frame: Array, start: Array, end: Array, thin: float, size: float) -> None:
    if np.linalg.norm(end - start) > _SHORT * size:
        capsules.append(Capsule(link, _into(frame, start), _into(frame, end), thin))


def _into(frame: Array, point: Array) -> Array:
    """A point of the base frame in another frame."""
    return np.asarray(frame[:3, :3].T @ (point - frame[:3, 3]))


def _places(robot: Robot) -> list[tuple[Array, Array]]:
    """Where the spine comes to each axis, and where it leaves it, at q = 0 in the base frame.

    A first axis that the second one is parallel to is a pillar: left where the arm goes on, not on the floor.
    """
    here = np.zeros(3)
    lines = []
    for joint in robot.joints:
        slides = joint.kind is JointKind.PRISMATIC
        z = joint.screw[:3] if slides else joint.screw[3:]
        lines.append((None if slides else np.cross(z, joint.screw[:3]), z))
    far = 1.5 * reach(robot)
    arrival = _onto(lines[0], here)
    pillar = _onto(lines[0], skeleton(robot)[0][1]) if len(lines) > 1 else arrival
    places = []
    for i, line in enumerate(lines):
        if i + 1 < len(lines):
            start = pillar if i == 0 else arrival
            departure, following = _normal((arrival, line[1]), lines[i + 1], start, far)
        else:
            departure = following = _onto((arrival, line[1]), robot.home[:3, 3])
        places.append((arrival, departure))
        arrival = following
    return places


def _onto(line: tuple[Array | None, Array], point: Array) -> Array:
    """The point of a line nearest to a point; a slide's line goes through the point itself."""
    p, z = line
    return point if p is None else np.asarray(p + z * (z @ (point - p)))


def _normal(
    first: tuple[Array, Array], second: tuple[Array | None, Array], here: Array, far: float
) -> tuple[Array, Array]:
    """Feet of the common normal of two lines; from `here` straight across where they are parallel or it is far off."""
    p, z = first
    o, w = second
    across = np.cross(z, w)
    if o is None:
        return here, here
    if np.linalg.norm(across) > _PARALLEL:
        solved = np.linalg.solve(np.stack([z, -w, across], axis=1), o - p)
        foot, other = p + z * solved[0], o + w * solved[1]
        if max(np.linalg.norm(foot - here), np.linalg.norm(other - here)) <= far:
            return foot, other
    return here, _onto(second, here)
