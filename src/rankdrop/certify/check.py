"""A second opinion on a certificate: plain NumPy, none of the code that made it.

It takes the boxes of a `Certificate`, proves each of them free again with screws, brackets and bounds of its own, and
checks that the boxes cover the ball without a gap.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.certify.ball import Certificate
from rankdrop.errors import OptionError
from rankdrop.robot.fingerprint import fingerprint
from rankdrop.robot.model import Array, JointKind, Robot

_SEAM = 1e-15  # corners of neighbouring boxes are rounded: boxes are tested this much wider [rad]
_ROUNDING = 1e-12  # per unit of M: a thousand times what double precision leaves in these sums


@dataclass(frozen=True, slots=True)
class Check:
    """The verdict of the checker.

    Attributes:
        holds: the certificate is confirmed.
        boxes: how many were proven free again.
        doubtful: how many were not.
        reason: one sentence.
    """

    holds: bool
    boxes: int
    doubtful: int
    reason: str


def check(robot: Robot, certificate: Certificate) -> Check:
    """Prove a certificate again.

    Args:
        robot: the arm it is about.
        certificate: made with `keep_boxes=True`.

    Raises:
        OptionError: the certificate has no boxes.
    """
    if certificate.boxes is None:
        raise OptionError("this certificate holds no boxes", mend="make it with keep_boxes=True")
    if fingerprint(robot) != certificate.model:
        return Check(False, 0, 0, "the certificate is about another arm")
    centre, half = certificate.boxes
    free = np.array([_free(robot, certificate, *box) for box in zip(centre, half, strict=True)], dtype=np.bool_)
    doubtful = int((~free).sum())
    if doubtful:
        return Check(False, int(free.sum()), doubtful, f"{doubtful} boxes could not be proven free again")
    if certificate.radius > 0.0 and not _covered(certificate, centre, half):
        return Check(False, len(free), 0, "the boxes do not cover the ball")
    return Check(True, len(free), 0, "every box is free, and the boxes cover the ball")


def _free(robot: Robot, certificate: Certificate, centre: Array, half: Array) -> bool:
    """Σ − B an M-matrix: by its inverse, which is nonnegative for M-matrices and for no other of this form."""
    setting = certificate.setting
    screws, values = _screws_in_link(robot, certificate.q + centre * setting.scale, setting.link, setting.point)
    screws[:3] /= setting.length
    rows, rank = list(setting.rows), setting.rank
    driver = _drivers(robot)
    jacobian = np.zeros((6, robot.n))
    for i, variable in enumerate(driver):
        jacobian[:, variable] += screws[:, i]
    u, sigma, vt = np.linalg.svd(jacobian[rows])
    left = np.zeros((6, rank))
    left[rows] = u[:, :rank]
    weight = vt[:rank, driver].T  # (N, r): the share of each joint's column in each right vector
    widths = half[driver] + _SEAM
    movers = screws * setting.scale[driver]
    bound = np.zeros((rank, rank))
    for order in (range(setting.link - 1, -1, -1), range(setting.link, len(driver))):
        bound += _side(list(order), screws, movers, left, weight, widths)
    arms = _arm_bounds(robot, certificate, values, widths)
    bound += _remainder(robot, certificate, arms, weight, widths) + _ROUNDING * (2 + arms.sum())
    comparison = np.diag(sigma[:rank]) - bound
    if np.diag(comparison).min() <= 0.0:
        return False
    inverse = np.linalg.inv(comparison)
    return bool((inverse >= 0.0).all() and np.linalg.cond(comparison) < 1e10)


def _side(order: list[int], screws: Array, movers: Array, left: Array, weight: Array, widths: Array) -> Array:
    """First- and second-order part of the bound from the joints on one side, nearest to the link first."""
    rank = left.shape[1]
    bound = np.zeros((rank, rank))
    for place, inner in enumerate(order):
        later = order[place + 1 :]
        moved = _bracket(movers[:, inner]) @ (screws[:, later] @ weight[later])  # (6, r): ± dJ(e) V₁
        bound += widths[inner] * np.abs(left.T @ moved)
        for outer in order[: place + 1]:
            twice = np.abs(left.T @ (_bracket(movers[:, outer]) @ moved))
            bound += widths[inner] * widths[outer] * twice * (0.5 if outer == inner else 1.0)
    return bound


def _arm_bounds(robot: Robot, certificate: Certificate, values: Array, widths: Array) -> Array:
    """(N,) bound on any derivative of the screw of each joint, times its multiplier."""
    setting = certificate.setting
    translation, rotation = 0 in setting.rows, 3 in setting.rows
    bounds = np.zeros(len(robot.joints))
    drivers = _drivers(robot)
    for order in (range(setting.link, len(robot.joints)), range(setting.link - 1, -1, -1)):
        extra = slide = 0.0
        for i in order:
            joint = robot.joints[i]
            multiplier = abs(joint.mimic.multiplier) if joint.mimic else 1.0
            unit = multiplier * setting.scale[drivers[i]]
            travel = abs(values[i]) + widths[i] * unit
            if joint.kind is JointKind.PRISMATIC:
                bounds[i] = multiplier * translation / setting.length
                extra += travel
                slide = max(slide, unit / setting.length)
                continue
            pitch = abs(float(joint.screw[:3] @ joint.screw[3:]))
            reach = (setting.arm[i] + pitch + extra) / setting.length
            bounds[i] = multiplier * max(float(np.hypot(rotation, translation * reach)), translation * slide)
            extra += pitch * (travel + 3.0) if pitch else 0.0
    return bounds


def _remainder(robot: Robot, certificate: Certificate, arms: Array, weight: Array, widths: Array) -> Array:
    """(r,) third-order part of the bound for each right vector."""
    link = certificate.setting.link
    multiplier = np.array([abs(joint.mimic.multiplier) if joint.mimic else 1.0 for joint in robot.joints])
    steps = multiplier * widths
    between = np.array([steps[link:i].sum() if i >= link else steps[i + 1 : link].sum() for i in range(len(steps))])
    return np.asarray((np.abs(weight) * (arms * between**3)[:, None]).sum(axis=0) / 6.0)


def _drivers(robot: Robot) -> list[int]:
    index = {joint.name: i for i, joint in enumerate(robot.variables)}
    return [index[joint.mimic.leader if joint.mimic else joint.name] for joint in robot.joints]


def _screws_in_link(robot: Robot, q: Array, link: int, point: tuple[float, float, float]) -> tuple[Array, Array]:
    """(6, N) joint screws times multipliers, seen from the link at the point, and (N,) joint values."""
    values = np.array(
        [
            (joint.mimic.multiplier * q[v] + joint.mimic.offset) if joint.mimic else q[v]
            for joint, v in zip(robot.joints, _drivers(robot), strict=True)
        ]
    )
    motion, screws, frame = np.eye(4), np.zeros((6, len(values))), np.eye(4)
    for i, joint in enumerate(robot.joints):
        factor = joint.mimic.multiplier if joint.mimic else 1.0
        screws[:, i] = factor * _adjoint(motion) @ joint.screw
        motion = motion @ _exponential(np.asarray(joint.screw), values[i])
        if i + 1 == link:
            frame = motion @ joint.frame
    frame = frame.copy()
    frame[:3, 3] += frame[:3, :3] @ np.array(point)
    return np.asarray(_adjoint(np.asarray(np.linalg.inv(frame), dtype=np.float64)) @ screws), values


def _exponential(screw: Array, value: float) -> Array:
    """exp(S q) by Rodrigues."""
    out = np.eye(4)
    v, w = screw[:3], screw[3:]
    if not w.any():
        out[:3, 3] = v * value
        return out
    skew = _skew(w)
    s, c = np.sin(value), np.cos(value)
    out[:3, :3] = np.eye(3) + s * skew + (1 - c) * skew @ skew
    out[:3, 3] = (np.eye(3) * value + (1 - c) * skew + (value - s) * skew @ skew) @ v
    return out


def _adjoint(motion: Array) -> Array:
    r, t = motion[:3, :3], motion[:3, 3]
    return np.block([[r, _skew(t) @ r], [np.zeros((3, 3)), r]])


def _bracket(screw: Array) -> Array:
    """(6, 6) ad_S, with [S, T] = ad_S T, linear part first."""
    return np.block([[_skew(screw[3:]), _skew(screw[:3])], [np.zeros((3, 3)), _skew(screw[3:])]])


def _skew(a: Array) -> Array:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def _covered(certificate: Certificate, centre: Array, half: Array) -> bool:
    """Do the boxes cover the ball? Cells are halved until each is one box, or lies outside the ball."""
    moving = np.flatnonzero(certificate.setting.matters)
    low, high = (centre - half - _SEAM)[:, moving], (centre + half + _SEAM)[:, moving]
    side = certificate.at_most
    cells = [(np.full(len(moving), -side), np.full(len(moving), side), np.arange(len(low)))]
    while cells:
        bottom, top, inside = cells.pop()
        gap = np.maximum(0.0, np.maximum(bottom, -top))
        if float(np.linalg.norm(gap)) >= certificate.radius * (1 - 1e-15):
            continue
        if len(inside) == 1 and (low[inside[0]] <= bottom).all() and (high[inside[0]] >= top).all():
            continue
        middle = (bottom + top) / 2
        for axis in np.argsort(bottom - top):
            below = high[inside, axis] <= middle[axis] + 4 * _SEAM
            above = low[inside, axis] >= middle[axis] - 4 * _SEAM
            if len(inside) and (below | above).all():
                break
        else:
            return False
        for part, which in ((0, below), (1, above)):
            new_bottom, new_top = bottom.copy(), top.copy()
            (new_bottom if part else new_top)[axis] = middle[axis]
            cells.append((new_bottom, new_top, inside[which]))
    return True
