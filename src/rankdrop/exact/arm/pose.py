"""Poses and screws over the exact ring: 4 × 4 matrices of reduced trigonometric polynomials."""

from __future__ import annotations

from rankdrop.exact.algebra.flint import Polynomial
from rankdrop.exact.algebra.ring import Ring
from rankdrop.robot.model import JointKind

Matrix = list[list[Polynomial]]


def identity(ring: Ring) -> Matrix:
    """The pose of a frame in itself."""
    return [[ring.one if i == j else ring.zero for j in range(4)] for i in range(4)]


def times(ring: Ring, one: Matrix, two: Matrix) -> Matrix:
    """One pose after another."""
    return [[ring.reduce(_inner(ring, row, [two[k][j] for k in range(4)])) for j in range(4)] for row in one]


def _inner(ring: Ring, row: list[Polynomial], column: list[Polynomial]) -> Polynomial:
    return sum((ring.product(a, b) for a, b in zip(row, column, strict=True) if a != 0 and b != 0), ring.zero)


def inverse(ring: Ring, pose: Matrix) -> Matrix:
    """Of the pose of one frame in another, the pose of the other in the one."""
    turned = [[pose[j][i] for j in range(3)] for i in range(3)]
    back = [ring.reduce(-sum((turned[i][k] * pose[k][3] for k in range(3)), ring.zero)) for i in range(3)]
    return [[*turned[i], back[i]] for i in range(3)] + [[ring.zero, ring.zero, ring.zero, ring.one]]


def joint_screw(ring: Ring, pose: Matrix, kind: JointKind) -> list[Polynomial]:
    """The screw (v; ω) of a joint along z of a pose: v = p × z; of a slide (z; 0)."""
    axis, point = [pose[i][2] for i in range(3)], [pose[i][3] for i in range(3)]
    if kind is JointKind.PRISMATIC:
        return [*axis, ring.zero, ring.zero, ring.zero]
    return [*_cross(ring, point, axis), *axis]


def moved(ring: Ring, screw: list[Polynomial], point: list[Polynomial]) -> list[Polynomial]:
    """The screw with its linear part taken at another point: v + ω × point."""
    cross = _cross(ring, screw[3:], point)
    return [*(ring.reduce(v + w) for v, w in zip(screw[:3], cross, strict=True)), *screw[3:]]


def _cross(ring: Ring, a: list[Polynomial], b: list[Polynomial]) -> list[Polynomial]:
    return [ring.reduce(ring.product(a[i - 2], b[i - 1]) - ring.product(a[i - 1], b[i - 2])) for i in range(3)]
