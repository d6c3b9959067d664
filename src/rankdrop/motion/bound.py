"""How far the Jacobian can change along one short curve: the enclosure of a certificate with a direction.

The enclosure of a box (`rankdrop.certify`) takes the sum of what every joint can do on its own. Along a curve
q = c + Δ τ + e, |τ| ≤ 1, |e_k| ≤ ε_k, the joints move together, and with U₁, Σ, V₁ the first r singular directions at c

    U₁ᵀ J(q) V₁ = Σ + E,   |E_ij| ≤ |g_ij| + ½ |H_ij| + T_j + X_j + rounding

    g = U₁ᵀ dJ(Δ) V₁,   H = U₁ᵀ d²J(Δ, Δ) V₁             brackets at c, once and twice
    T_j = ⅙ Σ_i |v_ij| (M_i t³ + 3 t² s)                 third order, t and s of Δ: the remainder of the box
    X_j = Σ_i |v_ij| (M_i t_ε + s_ε)                     what e adds, by the mean value theorem

M_i bounds every derivative of column i by turns everywhere near the curve; t and s are sums of |Δ_k| over the turning
joints, of |Δ_k|/ℓ over the slides between joint i and the link that the screws are seen from. Where a curve only
touches the singular set g vanishes with σ, so that few pieces are enough where boxes would need a million.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.certify.setting import Setting, enclose, regular
from rankdrop.kinematics import chain_of
from rankdrop.local.departure import unlocked
from rankdrop.robot.model import Array, JointKind, Robot

Mask = NDArray[np.bool_]

ROUNDED = 1e-14
"""Of a joint value per radian of it: what some thirty halvings of a curve leave of its last digits."""


@dataclass(frozen=True, eq=False)
class Enclosed:
    """The bound over P short curves.

    Attributes:
        free: (P,) the rank is kept on all of the curve, proven.
        sigma: (P, r) Σ at the middle.
        bound: (P, r, r) what |E| does not exceed.
        floor: (P, r, r) what the bound is for a curve of no length: the allowance for rounding.
        u, v: (P, m, r) and (P, n, r) the singular directions it speaks of.
    """

    free: Mask
    sigma: Array
    bound: Array
    floor: Array
    u: Array
    v: Array


@dataclass(frozen=True, eq=False)
class Along:
    """An arm seen from one setting, ready to enclose curves.

    Attributes:
        robot: the arm.
        setting: of a certificate.
    """

    robot: Robot
    setting: Setting

    @cached_property
    def _free(self) -> tuple[Robot, Array, Array]:
        """The chain with every joint a variable, its values at q = 0, and the shares (N, n) of the variables."""
        return unlocked(self.robot, np.zeros(self.robot.n))

    @cached_property
    def _view(self) -> _core.View:
        """All six rows, whatever the task takes: brackets need whole screws."""
        length = self.setting.length
        link, point = self.setting.link, list(self.setting.point)
        return _core.make_view(
            chain_of(self._free[0]), axes=link, origin=link, point=point, rows=list(range(6)),
            factors=[1 / length] * 3 + [1.0] * 3,
        )  # fmt: skip

    def enclosed(self, middle: Array, chord: Array, extra: Array) -> Enclosed:
        """Bounds over curves c + Δ τ + e.

        Args:
            middle, chord, extra: (P, n) c, Δ and ε [rad, m], as from `straightened`.
        """
        setting = self.setting
        extra = extra + ROUNDED * (setting.scale + np.abs(middle) + np.abs(chord))
        half = (np.abs(chord) + extra) / setting.scale
        _, _, _, sigma, u, v, largest = enclose(self.robot, setting, middle, half)
        floor = enclose(self.robot, setting, middle, np.zeros_like(half))[2]
        bound = (floor + self._orders(middle, chord, extra, u, v, largest)) * (1 + 1e-12)
        return Enclosed(regular(sigma, bound), sigma, bound, floor, u, v)

    def _orders(self, middle: Array, chord: Array, extra: Array, u: Array, v: Array, largest: Array) -> Array:
        """(P, r, r) all but the rounding."""
        setting = self.setting
        free, offset, share = self._free
        joints = np.ascontiguousarray(middle @ share.T + offset)
        screws = _core.jacobian(chain_of(free), self._view, joints).swapaxes(1, 2)  # (P, N, 6)
        step, slack = chord @ share.T, extra @ np.abs(share).T
        weight = np.einsum("ij,pjr->pir", share, v)  # (P, N, r)
        slides = np.array([joint.kind is JointKind.PRISMATIC for joint in free.joints])
        size = np.where(slides, np.abs(step) + slack, np.abs(step) + slack)
        size[:, slides] /= setting.length
        slack = np.where(slides, slack / setting.length, slack)
        lever = np.where(slides, 0.0, np.abs(share).sum(axis=1)) * (setting.rows[0] < 3)
        driven = np.abs(v)[:, np.abs(share).argmax(axis=1)]  # (P, N, r) |v| of the variable that drives each joint
        count, rank = len(middle), v.shape[2]
        first, second = np.zeros((count, 6, rank)), np.zeros((count, 6, rank))
        rest = np.zeros((count, rank))
        for order, sign in self._sides():
            beyond = np.zeros((count, 6, rank))
            for place in range(len(order) - 1, -1, -1):
                joint = order[place]
                nearer = np.einsum("pk,pkc->pc", step[:, order[:place]], screws[:, order[:place]])
                mover = step[:, joint, None] * screws[:, joint]
                moved = _bracket(mover, beyond)
                first += sign * moved
                second += _bracket(mover + 2 * nearer, moved)
                beyond = beyond + screws[:, joint, :, None] * weight[:, joint, None, :]
                rest += self._remainder(joint, order[:place], slides, size, slack, largest, lever)[:, None] * (
                    driven[:, joint]
                )
        rows = list(setting.rows)
        slope = np.abs(np.einsum("pcr,pcs->prs", u, first[:, rows]))
        bend = np.abs(np.einsum("pcr,pcs->prs", u, second[:, rows]))
        return np.asarray(slope + bend / 2 + rest[:, None, :])

    def _sides(self) -> tuple[tuple[list[int], float], ...]:
        """Joints from the link outwards, after it and before it, with the sign of their brackets."""
        link, count = self.setting.link, len(self.robot.joints)
        return (list(range(link, count)), 1.0), (list(range(link - 1, -1, -1)), -1.0)

    @staticmethod
    def _remainder(
        joint: int, between: list[int], slides: Mask, size: Array, slack: Array, largest: Array, lever: Array
    ) -> Array:
        """(P,) M t³/6 + t² s/2 + M t_ε + s_ε of one column."""
        turning = [k for k in between if not slides[k]]
        sliding = [k for k in between if slides[k]]
        t, s = size[:, turning].sum(axis=1), size[:, sliding].sum(axis=1)
        t_extra, s_extra = slack[:, turning].sum(axis=1), slack[:, sliding].sum(axis=1)
        return np.asarray(
            largest[:, joint] * (t**3 / 6 + t_extra) + lever[joint] * (t * t * s / 2 + s_extra)
        )


def _bracket(a: Array, b: Array) -> Array:
    """(P, 6, r) Lie brackets [a, b_j] of twists a (P, 6) and b (P, 6, r), linear part first."""
    v, w = a[:, :3, None], a[:, 3:, None]
    linear, angular = b[:, :3], b[:, 3:]
    return np.concatenate([_cross(w, linear) + _cross(v, angular), _cross(w, angular)], axis=1)


def _cross(a: Array, b: Array) -> Array:
    return np.stack(
        [
            a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1],
            a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2],
            a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0],
        ],
        axis=1,
    )
