"""Bounds on how far the tip leaves its Cartesian curve while the joints go straight: proven, not sampled.

Between two rows the joints go as q(τ) = a + τ Δ, 0 ≤ τ ≤ 1, and the tip is on its curve c(τ) at both rows but for e₀
and e₁. A function with |f''| ≤ M differs from the straight line between its ends by M/8 at most, so that

    |p(q(τ)) − c(τ)| ≤ max(|e₀|, |e₁|) + M/8,    M = Σ_i l_i t_i² + Σ_s (|q_s| t_s² + 2 |Δ_s| t_s) + |x| θ²

l_i is the length of link i, t_i the sum of |Δ_k| of the turning joints up to it (t_s: before slide s), θ the turn of
the tool between the rows, x the reference point in the axes of the tip. Rotations as matrices: |R'' − S''| ≤ t_N² + θ².
"""

from __future__ import annotations

import numpy as np

from rankdrop.kinematics import pose
from rankdrop.local.departure import unlocked
from rankdrop.local.orientation import orientation_coordinates
from rankdrop.motion.inverse import Aim
from rankdrop.robot.model import Array, JointKind
from rankdrop.robot.numbers import anchors

_ROUNDED = 1e-12  # share of the links' length that rounding may add


class TipDeviation:
    """Bounds for one arm and task.

    Args:
        aim: the arm and its task; only what the task asks for is compared.
    """

    def __init__(self, aim: Aim) -> None:
        robot = aim.robot
        chain, _, self._share = unlocked(robot, np.zeros(robot.n))
        self._offset = unlocked(robot, np.zeros(robot.n))[1]
        tip = robot.home[:3, 3] + robot.home[:3, :3] @ aim.point
        self._links = np.linalg.norm(np.diff(np.vstack([anchors(robot), tip]), axis=0), axis=1)
        self._turns = np.array([joint.kind is not JointKind.PRISMATIC for joint in chain.joints], dtype=np.float64)
        self._pitch = np.array([_pitch(joint.kind, joint.screw) for joint in chain.joints])
        self._aim = aim
        partial = [row for row in aim.rows if row < 3]
        self._rows = [0, 1, 2] if aim.with_tip and partial else partial
        self._turned = any(row >= 3 for row in aim.rows)

    def bound(self, q: Array, poses: Array) -> tuple[Array, Array]:
        """(K − 1,) each: how far the tip leaves the curve at most between rows, its place [m] and its turn [rad].

        Args:
            q: (K, n) rows.
            poses: (K, 4, 4) of the curve at the rows.
        """
        aim, now = self._aim, pose(self._aim.robot, q)
        values = q @ self._share.T + self._offset
        step = np.abs(np.diff(values, axis=0))
        turn = np.cumsum(step * self._turns, axis=1)
        before = turn - step * self._turns
        most = np.maximum(np.abs(values[1:]), np.abs(values[:-1]))
        bend = (turn**2 @ self._links) + ((most * before + 2 * step) * before) @ self._pitch
        tool = poses[1:, :3, :3] @ poses[:-1, :3, :3].swapaxes(1, 2)
        theta = np.linalg.norm(orientation_coordinates(tool, "rotvec"), axis=1)
        bend = bend + float(np.linalg.norm(aim.point)) * theta**2
        off = now[:, :3, 3] - poses[:, :3, 3] + (now[:, :3, :3] - poses[:, :3, :3]) @ aim.point
        rounding = _ROUNDED * float(self._links.sum())
        away = _largest_end(np.linalg.norm(off[:, self._rows], axis=1)) + bend / 8 + rounding
        if not self._rows:
            away = np.zeros_like(away)
        if not self._turned:
            return away, np.zeros_like(away)
        chord = _largest_end(self._turned_off(now[:, :3, :3], poses[:, :3, :3])) + (turn[:, -1] ** 2 + theta**2) / 8
        return away, 2 * np.arcsin(np.minimum(1.0, (chord + _ROUNDED) / 2))

    def _turned_off(self, now: Array, wanted: Array) -> Array:
        """(K,) |R − S|, of the axis alone about which the task leaves the tool free."""
        free, apart = self._aim.free, now - wanted
        if free is None:
            return np.asarray(np.linalg.norm(apart, axis=(1, 2)) / np.sqrt(2.0))
        return np.asarray(np.linalg.norm(apart[:, :, free] if self._aim.with_tip else apart[:, free], axis=1))


def _pitch(kind: JointKind, screw: Array) -> float:
    """Metres along its axis per unit of a joint's value."""
    return 1.0 if kind is JointKind.PRISMATIC else abs(float(screw[:3] @ screw[3:]))


def _largest_end(values: Array) -> Array:
    return np.maximum(values[1:], values[:-1])
