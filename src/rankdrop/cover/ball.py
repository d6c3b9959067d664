"""A ball around a configuration that is proven free of singularities.

Two steps. One enclosure of the whole ball gives a radius at once (CERTIFY: local second derivatives and a third-order
remainder). Branch and bound then cuts the ball asked for into boxes. Of each its enclosure tells how far from the
centre it is free, as much as the ball leaves of it; the one that is free least far is cut next, until all are free or
the budget is spent. What is certified then is how far the least is free.

Arms near one arm: how far its Jacobian can change when every joint may stand a little elsewhere.

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
from numpy.typing import ArrayLike

from rankdrop import _core
from rankdrop.cover.setting import Setting, settings_for
from rankdrop.errors import OptionError
from rankdrop.kinematics import one_configuration, whole_number
from rankdrop.robot.arm_reach import nearest
from rankdrop.robot.model import Array, Robot, fingerprint, once
from rankdrop.task import WORLD_ALIGNED, Frame, Task, resolve_task
from rankdrop.tolerances import MOST_EVALUATIONS
from rankdrop.version import VERSION

LARGEST = float(np.pi)  # no ball larger than half a turn is asked for
_SMALLEST = 1e-6  # boxes narrower than this are not divided: the singular set runs through them [rad]
_MARGIN = 1e-9  # off the radius of one enclosure, so that a checker that rounds otherwise comes to the same

MOST_ANGLE = 0.1
"""Larger errors are another arm [rad]."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """A ball ‖(q − q0)/scale‖ < radius in which the rank of the task Jacobian is the generic one, proven.

    Attributes:
        radius: certified [rad; slides divided by the length scale]; 0 where nothing could be proven. Variables that
            move no column against another (the first and the last turning joint, for the full pose) are free.
        single: radius from one enclosure alone, without branch and bound.
        at_most: radius asked for; `radius == at_most` means that all of it was proven.
        q: (n,) the centre [rad, m].
        task: name of the task.
        rank: the rank proven to hold.
        setting: link, point, length and reaches the bound was computed with.
        evaluations: enclosures computed.
        model: fingerprint of the arm.
        complete: False where it was interrupted; the radius holds all the same.
        version: of rankdrop.
        rows, frame: of the task.
    """

    radius: float
    single: float
    at_most: float
    q: Array
    task: str
    rank: int
    setting: Setting
    evaluations: int
    model: str
    complete: bool = True
    version: str = VERSION
    rows: tuple[int, ...] = (0, 1, 2, 3, 4, 5)
    frame: Frame = WORLD_ALIGNED


@once
def _views(robot: Robot, task: Task) -> tuple[list[_core.View], list[_core.EnclosureSettings]]:
    """What the core gets of each setting."""
    settings = settings_for(robot, task)
    return [setting.view(robot) for setting in settings], [setting.core_settings(LARGEST) for setting in settings]


def certified_radius(
    robot: Robot,
    q: ArrayLike,
    task: str | Task | None = None,
    *,
    at_most: float = LARGEST,
    enough: float = np.inf,
    evaluations: int = 20_000,
) -> Certificate:
    """A radius around q within which no configuration is singular: a proof up to the rounding allowance it states.

    U₁ᵀ J(q + δ) V₁ = Σ + E with |E_ij| ≤ Σ_k |g_ijk| |δ_k| + ½ Σ_kl |H_ijkl| |δ_k| |δ_l| + T_j, g and H exact at the
    centre of the box, T_j = ⅙ Σ_i |v_ij| (M_i t³ + 3 t² s), t and s the sums of |δ_k| over the turning joints and of
    |δ_k|/ℓ over the slides between joint i and the link, M_i = √(1 + (reach_i/ℓ)²) a bound on every derivative of
    column i by turns. Where a ball of radius ρ around q cuts the box, whose centre is c off, Σ g_ijk δ_k lies between
    −|g_ij| ρ − g_ij·c and |g_ij| ρ − g_ij·c as well, and the narrower of the two counts. Where the matrix
    Σ_ii − |E_ii|, −|E_ij| is an M-matrix, Σ + E is regular. Floating-point error is allowed for by 1e-12 · Σ M_i in
    every entry. Limits of the joints play no part.

    Args:
        robot: the arm.
        q: (n,) centre [rad, m].
        task: pose, position, orientation, rows in tool axes; other rows only where the arm moves no others.
        at_most: no larger radius is sought, e.g. the distance of a singularity that is known; in (0, π].
        enough: branch and bound ends once this radius is proven.
        evaluations: budget of branch and bound; 0: one enclosure only. About 2 µs each.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        OptionError: at_most or evaluations outside what is allowed, or a task that cannot be certified.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> arm = open_robot("planar3r")
        >>> round(certified_radius(arm, [0.3, 1.2, 0.4]).radius, 3)  # sin θ2 = 0 is 1.2 rad away
        1.2
    """
    centre = one_configuration(robot, q)
    if not 0.0 < at_most <= LARGEST:
        raise OptionError("no such radius", where="at_most", got=at_most, allowed="in (0, π]")
    whole_number("evaluations", evaluations, 0, MOST_EVALUATIONS)
    resolved = resolve_task(task, robot)
    settings = settings_for(robot, resolved)
    best, largest = _core.largest_ball(settings[0].chain(robot), *_views(robot, resolved), centre)
    setting, single = settings[best], min(largest, at_most)
    if single < at_most:
        single *= 1.0 - _MARGIN
    radius, used, complete = single, len(settings), True
    if evaluations and single < min(at_most, enough):
        radius, count, complete = _branch_and_bound(robot, setting, centre, single, at_most, enough, evaluations)
        used += count
    return Certificate(
        float(radius), single, at_most, centre, resolved.name, setting.rank, setting, used, fingerprint(robot),
        complete, rows=resolved.rows, frame=resolved.frame,
    )  # fmt: skip


def proven_free(robot: Robot, q: ArrayLike, task: Task, radius: float, evaluations: int) -> bool:
    """Whether a few enclosures, of one setting, prove that no configuration within a radius of q is singular.

    Args:
        robot, q, task, evaluations: as for `certified_radius`.
        radius: [rad; slides divided by the length scale]; above π nothing is proven.

    Raises:
        ConfigurationError, OptionError: as `certified_radius`, but for the radius.
    """
    if not 0.0 < radius <= LARGEST:
        return False
    centre = one_configuration(robot, q)
    settings, (views, told) = settings_for(robot, task), _views(robot, task)
    middle = len(settings) // 2
    _, single = _core.largest_ball(settings[middle].chain(robot), [views[middle]], [told[middle]], centre)
    if single * (1.0 - _MARGIN) >= radius:
        return True
    single *= 1.0 - _MARGIN
    return _branch_and_bound(robot, settings[middle], centre, single, radius, np.inf, evaluations)[0] >= radius


def _branch_and_bound(
    robot: Robot, setting: Setting, centre: Array, single: float, at_most: float, enough: float, evaluations: int
) -> tuple[float, int, bool]:
    """Radius, enclosures computed, and whether it was not interrupted; `single` is proven by one enclosure."""
    smallest = min(_SMALLEST, single / 8) if single > 0.0 else _SMALLEST  # a small ball needs boxes smaller still
    radius, count, stopped, _, _ = _core.ball(
        setting.chain(robot), setting.view(robot), centre, setting.matters, setting.core_settings(at_most),
        inner=single, enough=float(enough), smallest=smallest, budget=int(evaluations), keep=False,
    )  # fmt: skip
    return radius, count, not stopped


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
    return np.array([nearest((joint.axis, joint.foot), joint.frame[:3, 3]) for joint in robot.joints])


def coupling_of(robot: Robot) -> Array:
    """(N, n) sizes of the multipliers with which joints follow the variables."""
    coupling = np.zeros((len(robot.joints), robot.n))
    coupling[np.arange(len(robot.joints)), robot.drivers] = [abs(joint.multiplier) for joint in robot.joints]
    return coupling


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
        OptionError: the task takes some rows only, in tool axes or in others.
    """
    if setting.tool:
        raise OptionError("a tolerance of the model is for whole tasks: rows in tool axes also depend on how the tool "
                          "is mounted", where="model_tolerance", got=f"rows {rows}",
                          allowed="pose, position, orientation")  # fmt: skip
    if tuple(rows) != setting.rows:
        raise OptionError("a tolerance of the model is for whole tasks: rows that are left out are zero for this arm, "
                          "not for those near it", where="model_tolerance", got=f"rows {rows}",
                          allowed="pose, position, orientation", mend="task='pose': all rows, the same joints",
                          typed="--task pose: all rows, the same joints")  # fmt: skip
    points, count = points_of(robot), len(robot.joints)
    start = setting.home_point(robot)
    slides = np.array([joint.slides for joint in robot.joints])
    pitch = np.array([abs(joint.pitch) for joint in robot.joints])
    offset = np.array([abs(joint.offset) for joint in robot.joints])
    out = (np.zeros(robot.n) if far is None else np.abs(far)) @ coupling_of(robot).T + offset
    travel = np.where(slides, out, pitch * out)
    columns = np.zeros(travel.shape)
    linear, angular = 0 in setting.rows, 3 in setting.rows
    tool = int(not angular)  # a point that is moved with the others
    for side, own in ((range(setting.link, count), 1), (range(setting.link - 1, -1, -1), 0)):
        at, reach = start, np.zeros(travel.shape[:-1])
        for place, i in enumerate(side):
            reach = reach + float(np.linalg.norm(points[i] - at)) + (0.0 if own else travel[..., i])
            at, times = points[i], place + own
            if slides[i]:
                columns[..., i] = times * tolerance.angle * linear / setting.length
            else:
                moment = tolerance.angle * (reach + pitch[i] + (times + tool) * tolerance.length) + tolerance.length
                part = (times * moment + tool * tolerance.length) * linear / setting.length
                columns[..., i] = np.hypot(times * tolerance.angle * angular, part)
            reach = reach + (travel[..., i] if own else 0.0)
    return columns * (1 + 1e-12)
