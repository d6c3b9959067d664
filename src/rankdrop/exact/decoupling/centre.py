"""What is lost at the centre of a spherical group, as a direction that the arm's own lines give (JL).

With the centre as reference point J = [[J11, 0], [J21, J22]]. Where J11 is singular, yᵀJ11 = 0, the left null vector
of J is (y; 0): the centre cannot translate along y, whatever the wrist does. Where J22 is singular, yᵀJ22 = 0, and J11
is not, a motion that leaves the centre at rest leaves the arm at rest, and cannot turn the end effector about y.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, pairwise

import numpy as np

from rankdrop.local.scene import Scene
from rankdrop.robot.model import Array, Robot

_LOST = 1e-6
"""Share of the block's largest velocity below which a direction is lost at a sample."""


def centre_statement(robot: Robot, points: Array, group: tuple[int, ...], joints: tuple[int, ...], part: str) -> str:
    """The motion lost at the centre, by the first of the directions tried that is lost at every sample; else "".

    Args:
        robot: the arm.
        points: (N, n) configurations at which one block loses rank one.
        group: joints (from 1) whose axes meet in the centre.
        joints: of the block that loses rank: the group or all others.
        part: "wrist", "shoulder", or else what the group is called.
    """
    scene = Scene(robot, points)
    centre = scene.common_point([j - 1 for j in group])[0]
    own = [j - 1 for j in joints]
    name = f"{part} centre" if part in ("wrist", "shoulder") else "centre"
    if joints == group:
        for i, j in combinations(own, 2):
            if _lost(np.cross(scene.z[i], scene.z[j]), scene.screws[:, 3:, own]):
                where = f"the perpendicular to axes {i + 1} and {j + 1}"
                return f"with the {name} at rest the end effector cannot rotate about {where}"
        return ""
    velocity = scene.screws[:, :3, own] + np.cross(scene.screws[:, 3:, own], centre[:, :, None], axis=1)
    for text, direction in _directions(scene, centre, own, name):
        if _lost(direction, velocity):
            return f"the {name} cannot translate {text}"
    return ""


def _directions(scene: Scene, centre: Array, own: list[int], name: str) -> Iterator[tuple[str, Array]]:
    """Directions that an arm's lines give, the plainest first."""
    axes = [i for i in own if i in scene.axes]
    for i, j in pairwise(axes):
        if scene.meeting(i, j).all():
            shoulder = "the shoulder, " if (i, j) == (0, 1) else ""
            meeting = scene.common_point((i, j))[0]
            yield f"along the line from {shoulder}where axes {i + 1} and {j + 1} meet, to it", centre - meeting
    for i in axes:
        yield f"parallel to axis {i + 1}", scene.z[i]
    for i in axes:
        offset = centre - scene.p[i]
        across = offset - scene.z[i] * np.sum(offset * scene.z[i], axis=-1, keepdims=True)
        yield f"along the perpendicular from axis {i + 1} to it", across
    for i, j in combinations(own, 2):
        yield f"perpendicular to axes {i + 1} and {j + 1}", np.cross(scene.z[i], scene.z[j])


def _lost(direction: Array, velocities: Array) -> bool:
    """Whether no column of (N, 3, k) velocities has a part along the direction (N, 3), at every sample."""
    length = np.linalg.norm(direction, axis=1)
    if (length < _LOST).any():
        return False
    part = np.einsum("ni,nij->nj", direction / length[:, None], velocities)
    return bool((np.abs(part) <= _LOST * np.abs(velocities).max()).all())
