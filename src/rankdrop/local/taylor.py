"""The Jacobian along a straight motion of the joints, as a power series, exact but for rounding.

Let the joints move as q + t Δ, and let every screw be written in the task's own frame F. With Ŝ_i the screw of joint i
in F, ρ_k the rate of joint k,

    dŜ_i/dt = [Ŵ_i − V̂, Ŝ_i],   Ŵ_i = Σ_{k<i} ρ_k Ŝ_k,   V̂ = (Σ_{k≤b} ρ_k v̂_k ; Σ_{k≤a} ρ_k ω̂_k)

V̂ being the twist of F, whose reference point is fixed in link b and whose axes turn with link a: earlier joints carry
a screw along (bracket rule), the frame's own motion is taken off. Comparing powers of t gives a recursion,

    (p + 1) Ŝ_i^(p+1) = Σ_{a+b=p} [Ŵ_i^(a) − V̂^(a), Ŝ_i^(b)],

valid for turning, sliding and helical joints, in every frame. A mimic joint is a joint with the rate of its leader
times the multiplier. In the frame SPACE and with Δ = e_j this is ad_{S_j}^p S_i / p! for i > j (GR section 2).

Mimic joints let go: what belongs to one screw alone is asked of a chain in which every joint is a variable.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from rankdrop import _core
from rankdrop.kinematics import jacobian
from rankdrop.local.block import row_scale
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, link_index


def unlocked(robot: Robot, q: Array) -> tuple[Robot, Array, Array]:
    """The same chain with every mimic joint a variable of its own.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].

    Returns:
        The chain with N variables; its configuration (N,); and the share (N, n) each variable of `robot` has in it.
    """
    if robot.n == len(robot.joints):
        return robot, q, np.eye(robot.n)
    index = {joint.name: i for i, joint in enumerate(robot.variables)}
    share, offset = np.zeros((len(robot.joints), robot.n)), np.zeros(len(robot.joints))
    for row, joint in enumerate(robot.joints):
        if joint.mimic is None:
            share[row, index[joint.name]] = 1.0
        else:
            share[row, index[joint.mimic.leader]], offset[row] = joint.mimic.multiplier, joint.mimic.offset
    free = replace(robot, joints=tuple(replace(joint, mimic=None) for joint in robot.joints))
    return free, share @ q + offset, share


def taylor(robot: Robot, q: ArrayLike, task: Task, directions: ArrayLike, order: int) -> Array:
    """Taylor coefficients of the task Jacobian along straight motions: J(q + t Δ) = Σ_p J_p t^p.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].
        task: rows, frame and length scale.
        directions: (d, n) motions Δ, [rad, m] per unit of t.
        order: the highest power P wanted.

    Returns:
        (P + 1, d, m, n) the coefficients J_0 … J_P; J_1 is dJ(Δ), J_2 half the second derivative.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("pa10")
        >>> taylor(arm, [0.1] * 7, resolve_task(None, arm), np.eye(7), 4).shape
        (5, 7, 6, 7)
    """
    chain, values, share = unlocked(robot, np.asarray(q, dtype=np.float64))
    joints = len(chain.joints)
    axes, origin = (link_index(link, joints, "frame") for link in (task.frame.axes, task.frame.origin))
    rates = np.asarray(directions, dtype=np.float64) @ share.T  # (d, N)
    screws = jacobian(chain, values, task.frame).T  # (N, 6)
    terms = _core.series(np.ascontiguousarray(screws), np.ascontiguousarray(rates), axes, origin, order)
    columns = terms[..., list(task.rows)]  # (P + 1, d, N, m)
    return np.asarray(np.swapaxes(columns * row_scale(robot, task), -1, -2) @ share)
