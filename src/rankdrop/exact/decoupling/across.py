"""What is lost beside a planar triple, as a line along which no point can move.

With the rows of the plane across the parallel axes first, J = [[P, Q], [0, R]]. Where P is singular the three axes lie
in one plane; a motion that has no part out of the plane leaves the other joints at rest, R being regular, and moves
nothing along the line that crosses the three. Where R is singular, wᵀR = 0, the left null vector of J is (0; w): a
force along z with a moment across it, which is a force along one line parallel to the axes, or a couple. Power zero for
every joint means that no point of this line moves along it.
"""

from __future__ import annotations

import numpy as np

from rankdrop.exact.arm.structure import listed
from rankdrop.local.scene import Scene
from rankdrop.robot.model import Array, Robot

_FORCE = 1e-6
"""Share of a unit null vector (lengths per reach) below which its force counts as none: a couple."""


def across_statement(robot: Robot, points: Array, group: tuple[int, ...], joints: tuple[int, ...]) -> str:
    """The motion lost where one block of an arm with a planar triple loses rank one; "" where there is no such line.

    Args:
        robot: the arm; all joints of `group` and `joints` are revolute.
        points: (N, n) configurations at which the block loses rank one, the other none.
        group: the three joints (from 1) with parallel axes.
        joints: of the block that loses rank: the group or all others.
    """
    scene = Scene(robot, points)
    bundle = [j - 1 for j in group]
    if joints == group:
        if not scene.coplanar(bundle).all():
            return ""
        return f"motions in the plane across axes {listed(group)} have no part along the line that meets these axes"
    others = [j - 1 for j in joints]
    if not _has_line(scene, bundle[0], others):
        return ""
    met = tuple(i + 1 for i in others if not scene.parallel(bundle[0], i).any())
    which = f"axes {listed(met)}" if len(met) > 1 else f"axis {listed(met)}"
    return f"the points of the line that is parallel to axes {listed(group)} and meets {which} cannot move along it"


def _has_line(scene: Scene, parallel: int, others: list[int]) -> bool:
    """At every sample the null vector of (z·v, x·ω, y·ω) of the other joints has a force."""
    z = scene.z[parallel]
    x = np.cross(z, np.eye(3)[np.abs(z).argmin(axis=1)])
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(z, x)
    v, w = scene.screws[:, :3, others] / scene.length, scene.screws[:, 3:, others]
    rows = np.stack([np.einsum("ni,nij->nj", a, b) for a, b in ((z, v), (x, w), (y, w))], axis=1)
    return bool((np.abs(np.linalg.svd(rows)[0][:, 0, -1]) > _FORCE).all())
