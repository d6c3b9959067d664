"""How far a configuration is from a family, with an upper bound over boxes: what a distance that keeps a speed is in.

    joints    max_j |q_j − v_j| over the joints that stand at values v_j on the family [rad]
    residual  |f(q)| of the only condition f(q) = 0 of a family that couples joints

With f = Σ_t A_t cos(m_t·q − φ_t), at every q with |q_k − c_k| ≤ h_k,

    |f(q)| ≤ |f(c)| + Σ_k |∂f/∂q_k(c)| h_k + ½ Σ_t |A_t| (Σ_k |m_tk| h_k)²

by Taylor's theorem. Where f is, for some length s, (P − P₁)·(z₁ × z₂)/s, with P the point in which the last two axes
meet and z₁ × z₂ a unit vector, s |f| is a length: how far P is from the plane through axis 1 along axis 2. For a wrist
with three axes through one point, P is the wrist centre. That both are one function is tested at random configurations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rankdrop.families.record import Family
from rankdrop.formula.equation import Equation
from rankdrop.kinematics import link_poses
from rankdrop.problem import whole_turns
from rankdrop.robot.arm_reach import nearest
from rankdrop.robot.model import Array, JointKind, Robot

_OUTWARDS = 1.0 + 1e-9
_TRIED = 40  # random configurations at which a residual is compared with a length
_SAME = 1e-9  # share by which both may differ there
_ROUNDED = 1e-12  # of the amplitudes: more than the rounding of a residual
_LOOKS = 721  # values of a joint between which a residual changes its sign
_HALVINGS = 60


@dataclass(frozen=True, eq=False)
class AtValues:
    """The largest distance of several joints from their values on a family.

    Attributes:
        joints: their places, from 0.
        values: those nearest to the middle of the region [rad].
    """

    joints: tuple[int, ...]
    values: tuple[float, ...]
    unit = "rad"

    def at(self, q: Array) -> Array:
        """(N,) of configurations (N, n) [rad]."""
        return np.asarray(np.abs(q[:, self.joints] - self.values).max(axis=1))

    def most(self, centre: Array, half: Array) -> Array:
        """(M,) upper bounds over boxes (M, n) [rad]."""
        away = np.abs(centre[:, self.joints] - self.values) + half[:, self.joints]
        return np.asarray(away.max(axis=1) * _OUTWARDS)

    def far_corner(self, centre: Array, half: Array) -> Array:
        """(M, n) the point of each box that is farthest from the values."""
        away = np.zeros_like(centre)
        away[:, self.joints] = centre[:, self.joints] - self.values
        return np.asarray(centre + np.where(away < 0.0, -half, half) * (away != 0.0))

    def slope(self) -> float:
        """By how much it changes at most for each radian of a joint."""
        return 1.0


@dataclass(frozen=True, eq=False)
class ConditionResidual:
    """|f| of one condition of turning joints.

    Attributes:
        condition: f.
        factor: s, the length that f counts [m]; 1 where f is no length.
        unit: "m" or "1".
    """

    condition: Equation
    factor: float
    unit: str

    def at(self, q: Array) -> Array:
        """(N,) of configurations (N, n)."""
        return np.asarray(self.factor * np.abs(self.condition(q)))

    def most(self, centre: Array, half: Array) -> Array:
        """(M,) upper bounds over boxes (M, n)."""
        value, slope = self.condition.with_gradient(centre)
        multiples, amplitudes = self._waves()
        turned = half @ np.abs(multiples).T  # (M, t)
        bend = 0.5 * (turned**2) @ amplitudes
        rounding = _ROUNDED * amplitudes.sum()
        bound = np.abs(value) + (np.abs(slope) * half).sum(axis=1) + bend + rounding
        return np.asarray(self.factor * bound * _OUTWARDS)

    def far_corner(self, centre: Array, half: Array) -> Array:
        """(M, n) the corner of each box to which |f| rises."""
        value, slope = self.condition.with_gradient(centre)
        return np.asarray(centre + np.sign(slope) * np.where(value < 0.0, -1.0, 1.0)[:, None] * half)

    def slope(self) -> float:
        """By how much it changes at most for each radian of a joint."""
        multiples, amplitudes = self._waves()
        return self.factor * float((np.abs(multiples).max(axis=1) * amplitudes).sum())

    def _waves(self) -> tuple[Array, Array]:
        """(t, n) multiples m and (t,) amplitudes of the summands."""
        multiples, _, a, b, _ = self.condition.tables
        return multiples, np.hypot(a, b)


def at_values(robot: Robot, family: Family, around: Array) -> AtValues | None:
    """The measure of a family that has only turning joints at values; None for others."""
    if family.coupled or not family.pinned or not family.named:
        return None
    joints = tuple(pin.number - 1 for pin in family.pinned)
    if any(robot.variables[j].kind is JointKind.PRISMATIC for j in joints):
        return None
    values = []
    for j, pin in zip(joints, family.pinned, strict=True):
        values.append(_nearest_value(robot, j, pin.values, float(around[j])))
    return AtValues(joints, tuple(values))


def _nearest_value(robot: Robot, j: int, values: Sequence[float], middle: float) -> float:
    """The value of a joint, or a whole turn from it, that is nearest to the middle: inside the limits where one is."""
    gaps = np.zeros((len(values), robot.n))
    gaps[:, j] = middle - np.array(values)
    gaps -= whole_turns(robot, gaps)
    near = np.concatenate([middle - gaps[:, j], values])
    inside = (near >= robot.lower[j]) & (near <= robot.upper[j])
    if inside.any():
        near = near[inside]
    return float(near[np.abs(near - middle).argmin()])


def residual(robot: Robot, family: Family) -> ConditionResidual | None:
    """The measure of a family with one condition on several turning joints; None for others."""
    if family.pinned or len(family.equations) != 1:
        return None
    (condition,) = family.equations
    if condition.tables[4].any():  # powers of slides
        return None
    length = _length_of(robot, condition)
    if length is None:
        return ConditionResidual(condition, 1.0, "1")
    return ConditionResidual(condition, length, "m")


def _length_of(robot: Robot, condition: Equation) -> float | None:
    """s with |s f| = |(P − P₁)·(z₁ × z₂)| at every configuration [m]; None where there is none."""
    first, second, *_ = robot.joints
    before, last = robot.joints[-2:]
    normal = np.cross(first.axis, second.axis)
    meeting = _meeting((before.axis, before.foot), (last.axis, last.foot))
    if len(robot.joints) != robot.n or meeting is None or np.linalg.norm(normal) < _SAME:
        return None
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (_TRIED, robot.n))
    home, moved = link_poses(robot, np.zeros(robot.n)), link_poses(robot, q)
    carried = moved @ np.linalg.inv(home)  # of what stands at each link at q = 0
    point = carried[:, -3, :3, :3] @ meeting + carried[:, -3, :3, 3]
    across = carried[:, 1, :3, :3] @ (normal / np.linalg.norm(normal))
    away = ((point - first.foot) * across).sum(axis=1)
    value = condition(q)
    most = int(np.abs(value).argmax())
    length = float(away[most] / value[most])
    if np.abs(away - length * value).max() > _SAME * np.abs(away).max():
        return None
    return abs(length)


def _meeting(one: tuple[Array, Array], other: tuple[Array, Array]) -> Array | None:
    """(3,) the point in which two axes (direction, point) meet; None where they do not."""
    (z, foot), (direction, start) = one, other
    normal = np.cross(z, direction)
    square = float(normal @ normal)
    if square < _SAME:
        return None
    along = float(np.cross(start - foot, direction) @ normal) / square
    point = np.asarray(foot + along * z)
    if np.linalg.norm(nearest(other, point) - point) > _SAME:
        return None
    return point


def nearest_root(
    condition: Equation, around: Array, joints: Sequence[int], low: Array, high: Array
) -> tuple[int, float] | None:
    """The joint, from 0, and its value at which a residual vanishes with the other joints as they are: the nearest."""
    roots: list[tuple[float, int, float]] = []
    for j in joints:
        values = np.linspace(max(low[j], around[j] - np.pi), min(high[j], around[j] + np.pi), _LOOKS)
        rows = np.tile(around, (_LOOKS, 1))
        rows[:, j] = values
        signs = np.sign(condition(rows))
        for k in np.flatnonzero(signs[1:] != signs[:-1]).tolist():
            root = _bisect_zero(condition, rows[k], rows[k + 1], signs[k])[j]
            roots.append((abs(float(root) - float(around[j])), j, float(root)))
    if not roots:
        return None
    _, joint, value = min(roots)
    return joint, value


def _bisect_zero(condition: Equation, start: Array, end: Array, sign: float) -> Array:
    """(n,) a zero between two configurations, of which the first has the sign."""
    for _ in range(_HALVINGS):
        middle = (start + end) / 2
        if np.sign(condition(middle)) == sign:
            start = middle
        else:
            end = middle
    return np.asarray((start + end) / 2)
