"""Pose, Jacobian and its derivative, batched: free functions of a robot and its configurations.

Joint screws at q, in one fixed frame: S_i(q) = Ad(exp(S_1 q_1) … exp(S_{i−1} q_{i−1})) S_i. Moving joint k carries
every later screw along, and that is all there is to differentiate:

    ∂S_i/∂q_k = [S_k, S_i] for k < i, else 0,   [A, B] = (ω_A × v_B + v_A × ω_B ; ω_A × ω_B).

Twists are (v; ω), linear part first. Leading batch axes are kept; empty batches work.
"""

from __future__ import annotations

from numpy.typing import ArrayLike

from rankdrop import _core
from rankdrop._core import derivative_one, jacobian_one
from rankdrop._handles import chain_of, configurations, frame_view, rows_of, task_view
from rankdrop.frames import WORLD_ALIGNED, Frame
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task


def pose(robot: Robot, q: ArrayLike, *, out: Array | None = None) -> Array:
    """Pose of the tip in the base frame, T(q) = exp(S_1 q_1) … exp(S_N q_N) · home.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad or m].
        out: where to write the result, float64 of its shape; fresh memory costs a large batch up to half its time.

    Returns:
        (..., 4, 4).

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
        OptionError: out has another shape or type, or shares memory with q.
    """
    rows, batch = configurations(robot, q)
    found = _core.pose(chain_of(robot), rows, rows_of(out, rows, batch, (4, 4)))
    return found.reshape(*batch, 4, 4) if out is None else out


def link_poses(robot: Robot, q: ArrayLike) -> Array:
    """Poses of the base, of the link after each joint (`Joint.frame` carried along) and of the tip, in the base frame.

        T_i(q) = exp(S_1 q_1) … exp(S_i q_i) · frame_i

    The first is the identity, the last equals `pose`. Mimic joints count as joints, N in all.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad or m].

    Returns:
        (..., N + 2, 4, 4).

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> link_poses(open_robot("pa10"), [0.0] * 7).shape
        (9, 4, 4)
    """
    rows, batch = configurations(robot, q)
    return _core.links(chain_of(robot), rows).reshape(*batch, len(robot.joints) + 2, 4, 4)


def jacobian(robot: Robot, q: ArrayLike, frame: Frame = WORLD_ALIGNED, *, out: Array | None = None) -> Array:
    """Geometric Jacobian: column i is the twist (v; ω) that unit speed of joint i gives the tip.

    J_i = (Rᵀ(v_i + ω_i × p) ; Rᵀω_i), with R the axes and p the reference point of `frame` (AM eq. 1; for a revolute
    joint v_i + ω_i × p = z_i × (p − p_i)).

    Args:
        robot: the arm.
        q: (..., n) configurations [rad or m].
        frame: SPACE, BODY, WORLD_ALIGNED (default), or any `Frame` of the chain.
        out: where to write the result, float64 of its shape; fresh memory costs a large batch up to half its time.

    Returns:
        (..., 6, n): rows 0–2 in m per rad or m, rows 3–5 in rad per rad or m.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
        OptionError: out has another shape or type, or shares memory with q.
        TaskError: the frame names a link that does not exist.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> jacobian(open_robot("pa10"), [0.0] * 7).shape
        (6, 7)
    """
    single = jacobian_one(robot, q, out, None if frame is WORLD_ALIGNED else frame_view(robot, frame))
    if single is not None:
        return single
    rows, batch = configurations(robot, q)
    found = _core.jacobian(chain_of(robot), frame_view(robot, frame), rows, rows_of(out, rows, batch, (6, robot.n)))
    return found.reshape(*batch, 6, robot.n) if out is None else out


def jacobian_derivative(robot: Robot, q: ArrayLike, frame: Frame = WORLD_ALIGNED, *, out: Array | None = None) -> Array:
    """Derivative of the Jacobian by every joint, from the bracket.

    In SPACE, ∂J_i/∂q_k = [J_k, J_i] for k < i, else 0. In another frame the reference point and the axes move too:
    the linear part gains ω_i × ∂p/∂q_k (AM eq. 9, with the erratum's p_i), and axes of a moving link turn it back.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad or m].
        frame: as for `jacobian`.
        out: where to write the result, float64 of its shape; fresh memory costs a large batch up to half its time.

    Returns:
        (..., 6, n, n): [..., :, i, k] = ∂J[:, i]/∂q_k.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
        OptionError: out has another shape or type, or shares memory with q.
        TaskError: the frame names a link that does not exist.
    """
    single = derivative_one(robot, q, out, None if frame is WORLD_ALIGNED else frame_view(robot, frame))
    if single is not None:
        return single
    rows, batch = configurations(robot, q)
    into = rows_of(out, rows, batch, (6, robot.n, robot.n))
    derivative = _core.derivative(chain_of(robot), frame_view(robot, frame), rows, into)
    return derivative.reshape(*batch, 6, robot.n, robot.n) if out is None else out


def task_jacobian(robot: Robot, q: ArrayLike, task: Task) -> Array:
    """Rows of the Jacobian that the task needs, translation rows divided by the length scale.

    Args:
        robot: the arm.
        q: (..., n) configurations [rad or m].
        task: from `resolve_task`.

    Returns:
        (..., m, n), without unit for revolute joints.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
    """
    rows, batch = configurations(robot, q)
    return _core.jacobian(chain_of(robot), task_view(robot, task), rows).reshape(*batch, task.m, robot.n)


def task_jacobian_derivative(robot: Robot, q: ArrayLike, task: Task) -> Array:
    """Derivative of `task_jacobian` by every joint.

    Returns:
        (..., m, n, n): [..., :, i, k] = ∂J[:, i]/∂q_k.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
    """
    rows, batch = configurations(robot, q)
    derivative = _core.derivative(chain_of(robot), task_view(robot, task), rows)
    return derivative.reshape(*batch, task.m, robot.n, robot.n)
