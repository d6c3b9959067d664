"""A second opinion on a certificate: plain NumPy, none of the code that made it.

An arm seen from a link, and the bound on how far its Jacobian changes in a box, are written a second time on purpose,
with other formulas where there are any: nothing here comes from the core, from `setting.py`, or from `kinematics`.

The checker takes the boxes of a `Certificate`, proves each of them free again with screws, brackets and bounds of its
own, and checks that the boxes cover the ball without a gap. Of the setting it believes only where to look from (link,
point, length): reaches, rows, rank, units of motion and what the variables move are worked out anew from the arm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.certify.ball import LARGEST, Certificate
from rankdrop.errors import OptionError
from rankdrop.robot.model import Array, JointKind, Robot, fingerprint

_ROUNDING = 1e-12  # per unit of M: a thousand times what double precision leaves in these sums
_FAR = 1e-13  # per unit of the screws in base coordinates, before they are brought to the link
_TURNED = 1e-15  # per radian of the joint values: a few times the spacing of doubles


class Arm:
    """An arm seen from a point of link `link`, translation rows divided by `length`.

    Attributes:
        point: (3,) the point at q = 0 in base coordinates [m].
        reach: (N,) length of the polygon from the point to each axis at q = 0, foot to foot, without slides [m].
    """

    def __init__(self, robot: Robot, link: int, point: tuple[float, float, float], length: float) -> None:
        self.robot, self.link, self.length, self.local = robot, link, length, np.array(point)
        self.count = len(robot.joints)
        place = {joint.name: i for i, joint in enumerate(robot.variables)}
        self.driver = [place[joint.mimic.leader if joint.mimic else joint.name] for joint in robot.joints]
        self.times = np.array([joint.mimic.multiplier if joint.mimic else 1.0 for joint in robot.joints])
        self.shift = np.array([joint.mimic.offset if joint.mimic else 0.0 for joint in robot.joints])
        self.slides = np.array([joint.kind is JointKind.PRISMATIC for joint in robot.joints])
        self.screws = np.array([joint.screw for joint in robot.joints])
        home = self._home(link)
        self.point: Array = home[:3, :3] @ self.local + home[:3, 3]
        self.reach = self._reaches()

    def _home(self, link: int) -> Array:
        if link == 0:
            return np.eye(4)
        return self.robot.home if link == self.count + 1 else self.robot.joints[link - 1].frame

    def _sides(self) -> tuple[list[int], list[int]]:
        """Joints before and after the link, nearest first."""
        last = min(self.link, self.count)  # the tip goes with the last link
        return list(range(last - 1, -1, -1)), list(range(last, self.count))

    def _reaches(self) -> Array:
        lengths = np.zeros(self.count)
        for side in self._sides():
            at, total = self.point, 0.0
            for i in side:
                if not self.slides[i]:
                    v, w = self.screws[i, :3], self.screws[i, 3:]
                    step = np.cross(w, v + np.cross(w, at))  # from `at` to the nearest point of the axis
                    at, total = at + step, total + float(np.linalg.norm(step))
                lengths[i] = total
        return lengths

    def moving(self) -> list[int]:
        """Variables that move some column against the link."""
        return sorted({self.driver[k] for side in self._sides() for k in side[:-1]})

    def see(self, q: Array, axes: int | None = None) -> tuple[Array, Array, float]:
        """(6, N) screws at q times multipliers, (N,) joint values, and the size of what was subtracted on the way."""
        values = self.times * q[self.driver] + self.shift
        motion, space, poses = np.eye(4), np.zeros((6, self.count)), [np.eye(4)]
        for i in range(self.count):
            space[:, i] = self.times[i] * _adjoint(motion) @ self.screws[i]
            motion = motion @ _exponential(self.screws[i], values[i])
            poses.append(motion @ self._home(i + 1))
        poses.append(motion @ self.robot.home)
        pose = poses[self.link].copy()
        pose[:3, 3] += pose[:3, :3] @ self.local
        size = float(np.abs(space[:3]).sum() + np.abs(pose[:3, 3]).sum() * np.abs(self.times).sum()) / self.length
        if axes is not None:
            pose[:3, :3] = poses[axes][:3, :3]
        seen = _adjoint(_inverse(pose)) @ space
        seen[:3] /= self.length
        return seen, values, size

    def jacobian(self, q: Array, axes: int) -> Array:
        """(6, n) Jacobian at the point, in the axes of a link."""
        return self._columns(self.see(q, axes)[0])

    def _columns(self, seen: Array) -> Array:
        columns = np.zeros((6, self.robot.n))
        np.add.at(columns.T, self.driver, seen.T)
        return columns

    def bound(self, q: Array, widths: Array, scale: Array, rows: list[int], rank: int) -> tuple[Array, Array]:
        """(r,) Σ at q and (r, r) bound on U₁ᵀ J V₁ − Σ in the box; `widths` in units of `scale`."""
        seen, values, size = self.see(q)
        u, sigma, vt = np.linalg.svd(self._columns(seen)[rows])
        left = np.zeros((6, rank))
        left[rows] = u[:, :rank]
        weight = vt[:rank, self.driver].T  # (N, r): the share of each joint's column in each right vector
        unit = scale[self.driver]
        total = np.zeros((rank, rank))
        for side in self._sides():
            total += _two_orders(side, seen, seen * unit, left, weight, widths[self.driver])
        steps = np.abs(self.times) * unit * widths[self.driver]  # rad, m
        largest, lever = self._derivatives(values, steps, 0 in rows, 3 in rows)
        total += self._third(largest, lever, steps) @ np.abs(weight)
        turned = np.where(self.slides, np.abs(values) / self.length, np.abs(values)).sum()
        total += _ROUNDING * (2 + largest.sum()) + _FAR * size * (0 in rows) + _TURNED * largest.sum() * turned
        return sigma[:rank], total * (1 + 1e-12)

    def _derivatives(self, values: Array, steps: Array, linear: bool, angular: bool) -> tuple[Array, Array]:
        """(N,) bounds on derivatives of each column by turns only, and with one slide among them (per length)."""
        times = np.abs(self.times)
        pitch = np.where(self.slides, 0.0, np.abs((self.screws[:, :3] * self.screws[:, 3:]).sum(axis=1)))
        travel = np.abs(values) + steps
        reach = self.reach * (1 + 1e-12) + pitch
        longer = np.where(self.slides, travel, np.where(pitch > 0.0, pitch * (travel + 3.0), 0.0))
        for side in self._sides():
            for place, i in enumerate(side):
                reach[i] += longer[side[:place]].sum()
        turning = np.sqrt(float(angular) + (linear * reach / self.length) ** 2)
        return times * np.where(self.slides, linear / self.length, turning), times * np.where(self.slides, 0.0, linear)

    def _third(self, largest: Array, lever: Array, steps: Array) -> Array:
        """(N,) third-order remainder of each column."""
        out = np.zeros(self.count)
        for side in self._sides():
            for place, i in enumerate(side):
                between = np.array(side[:place], dtype=int)
                slid = self.slides[between]
                turned, moved = steps[between][~slid].sum(), steps[between][slid].sum() / self.length
                out[i] = (largest[i] * turned**3 + 3 * lever[i] * turned**2 * moved) / 6
        return out


def _two_orders(order: list[int], screws: Array, movers: Array, left: Array, weight: Array, widths: Array) -> Array:
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


def _inverse(pose: Array) -> Array:
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = pose[:3, :3].T, -pose[:3, :3].T @ pose[:3, 3]
    return out


def _adjoint(motion: Array) -> Array:
    r, t = motion[:3, :3], motion[:3, 3]
    return np.block([[r, _skew(t) @ r], [np.zeros((3, 3)), r]])


def _bracket(screw: Array) -> Array:
    """(6, 6) ad_S, with [S, T] = ad_S T, linear part first."""
    return np.block([[_skew(screw[3:]), _skew(screw[:3])], [np.zeros((3, 3)), _skew(screw[3:])]])


def _skew(a: Array) -> Array:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


_SEAM = 1e-15  # corners of neighbouring boxes are rounded: boxes are tested this much wider [rad]


@dataclass(frozen=True, slots=True)
class BallCheck:
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


def check(robot: Robot, certificate: Certificate) -> BallCheck:
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
        return BallCheck(False, 0, 0, "the certificate is about another arm")
    wrong = _numbers(robot, certificate)
    if wrong is None:
        arm = Arm(robot, certificate.setting.link, certificate.setting.point, certificate.setting.length)
        wrong = _claims(robot, certificate, arm)
    if wrong is not None:
        return BallCheck(False, 0, 0, wrong)
    centre, half = certificate.boxes
    free = np.array([_free(arm, certificate, *box) for box in zip(centre, half, strict=True)], dtype=np.bool_)
    doubtful = int((~free).sum())
    if doubtful:
        return BallCheck(False, int(free.sum()), doubtful, f"{doubtful} boxes could not be proven free again")
    if certificate.radius > 0.0 and not _covered(certificate, arm.moving(), centre, half):
        return BallCheck(False, len(free), 0, "the boxes do not cover the ball")
    return BallCheck(True, len(free), 0, "every box is free, and the boxes cover the ball")


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
