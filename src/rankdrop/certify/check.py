"""A second opinion on a certificate: plain NumPy, none of the code that made it.

It takes the boxes of a `Certificate`, proves each of them free again with screws, brackets and bounds of its own, and
checks that the boxes cover the ball without a gap. Of the setting it believes only where to look from (link, point,
length): reaches, rows, rank, units of motion and what the variables move are worked out anew from the arm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.certify.ball import LARGEST, Certificate
from rankdrop.certify.recompute import Arm
from rankdrop.errors import OptionError
from rankdrop.robot.fingerprint import fingerprint
from rankdrop.robot.model import Array, JointKind, Robot

_SEAM = 1e-15  # corners of neighbouring boxes are rounded: boxes are tested this much wider [rad]


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
    wrong = _numbers(robot, certificate)
    if wrong is None:
        arm = Arm(robot, certificate.setting.link, certificate.setting.point, certificate.setting.length)
        wrong = _claims(robot, certificate, arm)
    if wrong is not None:
        return Check(False, 0, 0, wrong)
    centre, half = certificate.boxes
    free = np.array([_free(arm, certificate, *box) for box in zip(centre, half, strict=True)], dtype=np.bool_)
    doubtful = int((~free).sum())
    if doubtful:
        return Check(False, int(free.sum()), doubtful, f"{doubtful} boxes could not be proven free again")
    if certificate.radius > 0.0 and not _covered(certificate, arm.moving(), centre, half):
        return Check(False, len(free), 0, "the boxes do not cover the ball")
    return Check(True, len(free), 0, "every box is free, and the boxes cover the ball")


def _numbers(robot: Robot, certificate: Certificate) -> str | None:
    """Shapes and ranges of everything in the certificate."""
    setting = certificate.setting
    if not 0.0 <= certificate.radius <= certificate.at_most <= LARGEST:  # NaN fails too
        return "the radius is outside 0 … at_most … π"
    if certificate.q.shape != (robot.n,) or not np.isfinite(certificate.q).all():
        return "the centre is not a configuration of the arm"
    for part in certificate.boxes or ():
        if part.ndim != 2 or part.shape[1] != robot.n or not np.isfinite(part).all():
            return "the boxes have another shape than the arm, or values that are not finite"
    if certificate.boxes is not None and (certificate.boxes[1] < 0.0).any():
        return "a box has a negative width"
    if not 0 <= setting.link <= len(robot.joints) or not 0.0 < setting.length < np.inf:
        return "the link or the length is impossible"
    slides = np.array([joint.kind is JointKind.PRISMATIC for joint in robot.variables])
    scale = np.asarray(setting.scale)
    if scale.shape != (robot.n,) or not (np.isfinite(scale) & (scale > 0.0)).all() or (scale[~slides] != 1.0).any():
        return "motions of the joints are measured in impossible units"
    return None


def _claims(robot: Robot, certificate: Certificate, arm: Arm) -> str | None:
    """What the certificate says of task, rank, reaches and variables, against what the arm says."""
    setting = certificate.setting
    blocks = tuple(row for block in ((0, 1, 2), (3, 4, 5)) if set(block) & set(certificate.rows) for row in block)
    if setting.rows != blocks:
        return "the rows are not those of the task"
    frame, joints = certificate.frame, len(robot.joints)
    origin = joints + 1 if frame.origin == -1 else frame.origin
    if blocks == (0, 1, 2):
        home = robot.home if origin == joints + 1 else robot.joints[-1].frame
        wanted = home[:3, :3] @ np.array(frame.point) + home[:3, 3]
        off = float(np.linalg.norm(arm.point - wanted)) / float(np.linalg.norm(wanted) + arm.reach.max())
        if setting.link != joints or origin < joints or not off < 1e-12:
            return "the point is not that of the task"
    axes = joints + 1 if frame.axes == -1 else frame.axes
    q = np.random.default_rng(0).uniform(-1, 1, (8, robot.n)) * np.pi * setting.scale
    seen = np.array([Arm(robot, origin, frame.point, setting.length).jacobian(one, axes) for one in q])
    missing = [row for row in blocks if row not in certificate.rows]
    if missing and np.abs(seen[:, missing]).max() > 1e-11 * np.abs(seen).max():
        return "the task takes some rows only, and its rank depends on the axes"
    sigma = np.linalg.svd(seen[:, list(certificate.rows)], compute_uv=False)
    rank = int((sigma > 1e-11 * sigma[:, :1]).sum(axis=1).max())
    if not certificate.rank == setting.rank == rank:
        return f"the rank is {rank} almost everywhere, not {certificate.rank}"
    if np.shape(setting.arm) != (joints,) or (np.asarray(setting.arm) < arm.reach * (1 - 1e-9)).any():
        return "the reaches of the certificate are too short"
    if not np.asarray(setting.matters)[arm.moving()].all():
        return "the certificate leaves out a joint that matters"
    return None


def _free(arm: Arm, certificate: Certificate, centre: Array, half: Array) -> bool:
    """Σ − B an M-matrix: Σ⁻¹B, positive everywhere, shrinks a positive vector, so its spectral radius is below 1."""
    setting = certificate.setting
    q = certificate.q + centre * setting.scale
    widths = half + _SEAM * (1.0 + np.abs(q) / setting.scale)
    sigma, bound = arm.bound(q, widths, setting.scale, list(setting.rows), setting.rank)
    if not np.isfinite(bound).all() or sigma[-1] <= 0.0:
        return False
    share = bound / sigma[:, None]
    try:
        vector = np.linalg.solve(np.eye(len(share)) - share, np.ones(len(share)))  # any positive vector would do
    except np.linalg.LinAlgError:
        return False
    return bool((vector > 0.0).all() and (share @ vector / vector).max() < 1.0 - 1e-13)


def _covered(certificate: Certificate, moving: list[int], centre: Array, half: Array) -> bool:
    """Do the boxes cover the ball? Cells are halved until each is one box, or lies outside the ball."""
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
