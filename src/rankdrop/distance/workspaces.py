"""The workspace in section: where the tip can be, what bounds it, and where the families of singularities lie in it.

A wall is the image of a configuration at which the *position* of the tip loses a direction u. With N a basis of the
null space of the position Jacobian, what the tip does along u at second order is the form

    Q = Nᵀ (½ Σ u · ∂²p/∂q_i∂q_k) N.

Where Q has one sign only, every small motion from that posture leaves the tip on one side of the wall: the boundary of
the workspace, of a void, or a barrier inside it. Where Q has both, the arm can pass in another posture nearby.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rankdrop.families.points import members
from rankdrop.families.record import Family
from rankdrop.families.searching import search
from rankdrop.kinematics import jacobian_derivative, pose
from rankdrop.local.block import decompose, generic_rank, sample
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.task import Task, resolve_task

TIPS = 200_000
"""Random configurations whose tips fill the map."""
WALLS = 6_000
"""Random starts of the search for walls."""
IMAGES = 1_500
"""Random starts for each family's image."""
CELLS = 160
"""Of the map, along each side."""
_FLAT = 1e-6  # eigenvalues of Q below this share of the scale are zero
_THIN = 1e-9  # a workspace flatter than this share of its size is planar


@dataclass(frozen=True, eq=False)
class DrawnPlane:
    """How positions are drawn: the half-plane (distance, height) about axis 1, or the plane that a planar arm stays in.

    Attributes:
        origin: (3,) a point on the axis [m].
        axis: (3,) its direction.
        planar: positions never leave one plane across the axis; it is drawn as it is.
    """

    origin: Array
    axis: Array
    planar: bool

    def __call__(self, points: Array) -> Array:
        """(N, 2) distance from the axis and height along it, or the two coordinates in the plane [m]."""
        away = points - self.origin
        if self.planar:
            x, y = _normals_to(self.axis)
            return np.stack([away @ x, away @ y], axis=-1)
        height = away @ self.axis
        radial = np.linalg.norm(away - height[..., None] * self.axis, axis=-1)
        return np.stack([radial, height], axis=-1)

    @property
    def labels(self) -> tuple[str, str]:
        """What the two coordinates are."""
        if self.planar:
            return ("x [m]", "y [m]")
        return ("distance from axis 1 [m]", "height [m]")


@dataclass(frozen=True, eq=False)
class Workspace:
    """The workspace in section.

    Attributes:
        section: how positions are drawn.
        x, y: edges of the map's square cells, some `CELLS` of them along the longer side [m].
        tips: (len(x) − 1, len(y) − 1) how many of the random tips fell into each cell.
        count: of random tips.
        walls: (W, 2) images of singular configurations of the position task.
        one_sided: (W,) whether Q has one sign only there.
        images: per family of corank 1 its id and (K, 2) tips of random members.
        seed: of every random choice.
    """

    section: DrawnPlane
    x: Array
    y: Array
    tips: NDArray[np.int64]
    count: int
    walls: Array
    one_sided: NDArray[np.bool_]
    images: tuple[tuple[str, Array], ...]
    seed: int


def workspace(robot: Robot, task: Task, families: Sequence[Family], *, seed: int = 0, tips: int = TIPS) -> Workspace:
    """The workspace in section, joint limits of turning joints ignored, as the families are.

    Args:
        robot, task: the arm.
        families: those of corank 1 are drawn.
        seed: of every random choice.
        tips: random configurations for the map.
    """
    positions = pose(robot, sample(robot, task, tips, seed))[:, :3, 3]
    section = section_of(robot, positions)
    drawn = section(positions)
    low, high = drawn.min(axis=0), drawn.max(axis=0)
    if not section.planar:
        low[0] = 0.0
    edges = _edges(low, high, section.planar)
    counts, _, _ = np.histogram2d(drawn[:, 0], drawn[:, 1], bins=(edges[0], edges[1]))
    walls, one_sided = _walls(robot, section, seed)
    images = []
    for family in families:
        if family.corank == 1:
            points = members(robot, task, family, IMAGES, seed)
            images.append((family.id, section(pose(robot, points)[:, :3, 3])))
    return Workspace(
        section, edges[0], edges[1], counts.astype(np.int64), tips, section(walls), one_sided, tuple(images), seed
    )


def _edges(low: Array, high: Array, planar: bool) -> list[Array]:
    """Square cells with a little room around; a distance begins at 0."""
    cell = 1.06 * max(float((high - low).max()), 1e-9) / CELLS
    room = 0.03 * (high - low).max()
    begin = low - np.array([room if planar else 0.0, room])
    count = np.maximum(np.ceil((high + room - begin) / cell), 1).astype(int)
    return [begin[k] + cell * np.arange(count[k] + 1) for k in (0, 1)]


def section_of(robot: Robot, positions: Array) -> DrawnPlane:
    """About the first turning axis; planar where the positions stay in one plane across it."""
    first = next((joint for joint in robot.joints if joint.kind is not JointKind.PRISMATIC), None)
    if first is None:
        axis = np.array([0.0, 0.0, 1.0])
    else:
        axis = np.array(first.screw[3:])
    if first is None:
        origin = np.zeros(3)
    else:
        origin = np.cross(axis, first.screw[:3])
    height = (positions - origin) @ axis
    planar = bool(np.ptp(height) <= _THIN * max(float(np.abs(positions - origin).max()), 1e-9))
    return DrawnPlane(origin, axis, planar)


def _walls(robot: Robot, section: DrawnPlane, seed: int) -> tuple[Array, NDArray[np.bool_]]:
    """(W, 3) tips at singular configurations of the position task, and whether Q has one sign there."""
    nothing = np.empty((0, 3)), np.zeros(0, dtype=np.bool_)
    upright = section.planar and abs(abs(section.axis[2]) - 1) < _THIN
    task = resolve_task("planar-position" if upright else "position", robot)
    rank = generic_rank(robot, task)
    if rank < task.m:
        return nothing
    q = search(robot, 1, task=task, starts=WALLS, seed=seed).converged
    if not len(q):
        return nothing
    parts = decompose(robot, q, task)
    u = np.zeros((len(q), 6))
    u[:, list(task.rows)] = parts.u[..., -1]
    null = parts.v[..., rank - 1 :]
    second = np.einsum("nr,nrik->nik", u, jacobian_derivative(robot, q)) / task.scale(robot)
    form = np.einsum("nia,nik,nkb->nab", null, second, null)
    eigenvalues = np.linalg.eigvalsh((form + np.swapaxes(form, 1, 2)) / 2)
    one_sided = (eigenvalues[:, 0] > -_FLAT) | (eigenvalues[:, -1] < _FLAT)
    return pose(robot, q)[:, :3, 3], np.asarray(one_sided)


def _normals_to(axis: Array) -> tuple[Array, Array]:
    """Two unit vectors across an axis; x and y where it is z."""
    if abs(axis[0]) < 0.9:
        x = np.array([1.0, 0.0, 0.0])
    else:
        x = np.array([0.0, 1.0, 0.0])
    x = x - axis * (axis @ x)
    x /= np.linalg.norm(x)
    return x, np.cross(axis, x)
