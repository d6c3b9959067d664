"""Arms near one arm: how far its Jacobian can change when every joint may stand a little elsewhere.

A measured arm is not the described one. *Within δ_p and δ_a of this arm* means: every joint stands, in the link before
it, turned by at most δ_a [rad] about a point of its axis and moved by at most δ_p [m]. Zero positions of the joints
are among these errors, each being a turn about the axis itself. How far it is to the tip does not matter for the rank,
unless the task is the translation of a point: this point, too, is moved by at most δ_p in the last link then.

Seen from link c at a point P, column i is carried by the displacements of the joints between, its own included on the
far side of c: N_i of them. One that turns about p_k carries an axis through a point a with direction z and turns by
θ, |θ| ≤ δ_a, with |z' − z| ≤ δ_a; of the moment m = (a − P) × z changes (p_k − P) × z by at most |p_k − P| δ_a, the
rest of m, which is turned, by at most |a − p_k| δ_a, and the move adds δ_p. |p_k − P| + |a − p_k| is at most the
length R_i of the polygon from P over the points of the joints to that of joint i, which the moves before have made
longer by at most N_i δ_p. So, lengths divided by ℓ,

    ‖ΔJ_i‖ ≤ D_i = N_i √(δ_a² + ((δ_a (R_i + N_i δ_p) + δ_p) / ℓ)²)        turning joints
    ‖ΔJ_i‖ ≤ D_i = N_i δ_a / ℓ                                             slides

R_i grows by how far the slides between are out, and by how far joints that screw carry along their axes; of these the
moment has the pitch times z as well, which adds the size of the pitch to R_i in their own D_i. Joints that follow
others are displaced each for itself; how they follow is exact, and a column of the Jacobian is the sum of theirs, each
times its multiplier. A point that is moved itself makes N_i in the inner bracket larger by
one, and adds δ_p/ℓ. Then |(U₁ᵀ ΔJ V₁)_rj| ≤ Σ_i D_i |v_ij|, which is added to the bound of an enclosure.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.certify.setting import Setting
from rankdrop.errors import OptionError
from rankdrop.robot.model import Array, JointKind, Robot

MOST_ANGLE = 0.1
"""Larger errors are another arm [rad]."""


@dataclass(frozen=True, slots=True)
class ModelTolerance:
    """How far an arm may be from the one that is described.

    Attributes:
        length: every joint is moved by at most this in the link before it [m].
        angle: … and turned by at most this [rad].

    Raises:
        OptionError: below zero, not finite, or an angle above `MOST_ANGLE`.
    """

    length: float
    angle: float

    def __post_init__(self) -> None:
        if not 0.0 <= self.length < np.inf:
            raise OptionError("this is no length", where="model_tolerance", got=self.length, allowed="0 or more [m]")
        if not 0.0 <= self.angle <= MOST_ANGLE:
            raise OptionError("this is no small angle", where="model_tolerance", got=self.angle,
                              allowed=f"0 … {MOST_ANGLE} [rad]")  # fmt: skip


def points_of(robot: Robot) -> Array:
    """(N, 3) the point of each axis nearest to the origin of the joint's frame, of slides that origin, at q = 0 [m]."""
    found = []
    for joint in robot.joints:
        origin = joint.frame[:3, 3]
        if joint.kind is not JointKind.PRISMATIC:
            v, w = joint.screw[:3], joint.screw[3:]
            foot = np.cross(w, v)
            origin = foot + w * (w @ (origin - foot))
        found.append(origin)
    return np.array(found)


def coupling_of(robot: Robot) -> Array:
    """(N, n) sizes of the multipliers with which joints follow the variables."""
    place = {joint.name: k for k, joint in enumerate(robot.variables)}
    found = np.zeros((len(robot.joints), robot.n))
    for i, joint in enumerate(robot.joints):
        found[i, place[joint.mimic.leader if joint.mimic else joint.name]] = (
            abs(joint.mimic.multiplier) if joint.mimic else 1.0
        )  # fmt: skip
    return found


def displaced_jacobian(
    robot: Robot, setting: Setting, tolerance: ModelTolerance, rows: tuple[int, ...], far: Array | None = None
) -> Array:
    """(..., n) how far each column of the Jacobian can change: D_i of the joints of one variable together.

    Arguments and errors as for `displaced_columns`.
    """
    return displaced_columns(robot, setting, tolerance, rows, far) @ coupling_of(robot)


def displaced_columns(
    robot: Robot, setting: Setting, tolerance: ModelTolerance, rows: tuple[int, ...], far: Array | None = None
) -> Array:
    """(..., N) D_i: how far each column, seen as the setting has it, can change for any arm within the tolerance.

    Args:
        robot, setting: the arm as a certificate looks at it.
        tolerance: how far a joint may be from where it is described.
        rows: of the task; all that the setting has, for rows that are zero for this arm need not be for those near it.
        far: (..., n) how far the variables go from zero, at most; of slides it is used. None for zero.

    Raises:
        OptionError: the task takes some rows only.
    """
    if tuple(rows) != setting.rows:
        raise OptionError("a tolerance of the model is for whole tasks: rows that are left out are zero for this arm, "
                          "not for those near it", where="model_tolerance", got=f"rows {rows}",
                          allowed="pose, position, orientation", mend="task='pose': all rows, the same joints",
                          typed="--task pose: all rows, the same joints")  # fmt: skip
    points, count = points_of(robot), len(robot.joints)
    frame = robot.home if setting.link == count + 1 else np.eye(4) if not setting.link else (
        robot.joints[setting.link - 1].frame
    )
    start = frame[:3, :3] @ np.array(setting.point) + frame[:3, 3]
    slides = np.array([joint.kind is JointKind.PRISMATIC for joint in robot.joints])
    pitch = np.array([abs(joint.screw[:3] @ joint.screw[3:]) * (joint.kind is JointKind.HELICAL)
                      for joint in robot.joints])  # fmt: skip
    offset = np.array([abs(joint.mimic.offset) if joint.mimic else 0.0 for joint in robot.joints])
    out = (np.zeros(robot.n) if far is None else np.abs(far)) @ coupling_of(robot).T + offset
    travel = np.where(slides, out, pitch * out)
    found = np.zeros(travel.shape)
    linear, angular = 0 in setting.rows, 3 in setting.rows
    tool = int(not angular)  # a point that is moved with the others
    for side, own in ((range(setting.link, count), 1), (range(setting.link - 1, -1, -1), 0)):
        at, reach = start, np.zeros(travel.shape[:-1])
        for place, i in enumerate(side):
            reach = reach + float(np.linalg.norm(points[i] - at)) + (0.0 if own else travel[..., i])
            at, times = points[i], place + own
            if slides[i]:
                found[..., i] = times * tolerance.angle * linear / setting.length
            else:
                moment = tolerance.angle * (reach + pitch[i] + (times + tool) * tolerance.length) + tolerance.length
                part = (times * moment + tool * tolerance.length) * linear / setting.length
                found[..., i] = np.hypot(times * tolerance.angle * angular, part)
            reach = reach + (travel[..., i] if own else 0.0)
    return found * (1 + 1e-12)
