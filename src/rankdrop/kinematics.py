"""Pose, Jacobian and its derivative, batched: free functions of a robot and its configurations.

Joint screws at q, in one fixed frame: S_i(q) = Ad(exp(S_1 q_1) … exp(S_{i−1} q_{i−1})) S_i. Moving joint k carries
every later screw along, and that is all there is to differentiate:

    ∂S_i/∂q_k = [S_k, S_i] for k < i, else 0,   [A, B] = (ω_A × v_B + v_A × ω_B ; ω_A × ω_B).

Twists are (v; ω), linear part first. Leading batch axes are kept; empty batches work.

The core works them out. First what it is told: one chain per robot, one view per robot and frame or task, made once and
kept; and what a configuration has to be.
"""

from __future__ import annotations

import weakref
from pathlib import PurePath

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rankdrop import _core
from rankdrop._core import derivative_one, jacobian_one, pose_one
from rankdrop.errors import ConfigurationError, OptionError, RobotError
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.transform import as_numbers
from rankdrop.task import WORLD_ALIGNED, Frame, Task, frame_of, link_index, resolve_task

__all__ = ["jacobian", "jacobian_derivative", "link_poses", "pose", "task_jacobian", "task_jacobian_derivative"]
"""Of what stands here; the rest is for the package."""

LARGEST_SEED = 2**63 - 1
"""What the core takes."""
_ALL_ROWS = (0, 1, 2, 3, 4, 5)

_handles: dict[int, Handles] = {}  # by id: a weak dictionary would cost as much as a Jacobian


class Handles:
    """Everything the core keeps for one robot."""

    __slots__ = ("chain", "idle", "ranks", "robot", "samples", "scales", "tasks", "views", "world")

    def __init__(self, robot: Robot) -> None:
        check_robot(robot)
        self.robot = weakref.ref(robot)
        self.chain = _make_chain(robot)
        self.views: dict[tuple[Frame, tuple[int, ...], float], _core.View] = {}
        self.tasks: dict[Task | str | tuple[str, ...] | None, _core.View] = {}  # views of tasks as people name them
        self.ranks: dict[tuple[Frame, tuple[int, ...], float], int] = {}  # generic ranks met so far
        self.scales: dict[float, Array] = {}  # of joints, by the length scale of their task
        self.samples: dict[tuple[int, float], Array] = {}  # random configurations that stand for almost all
        self.idle: dict[tuple[Frame, tuple[int, ...], float, bool], NDArray[np.bool_]] = {}  # joints that do nothing
        self.world = _make_view(self.chain, robot, WORLD_ALIGNED, _ALL_ROWS, 1.0)


def check_robot(robot: object) -> None:
    """Tell a name or a file from the robot itself.

    Raises:
        RobotError: not a Robot.
    """
    if not isinstance(robot, Robot):
        if isinstance(robot, str | PurePath):
            what = repr(robot)[:80]
        else:
            what = f"a {type(robot).__name__}"
        raise RobotError("a Robot is needed", got=what, allowed="a Robot", mend="use open_robot(…)")


def whole_number(name: str, value: object, least: int, most: int) -> int:
    """An option as a whole number of Python.

    Raises:
        OptionError: not a whole number, or outside least … most.
    """
    if isinstance(value, int | np.integer) and not isinstance(value, bool):
        number = value
    else:
        number = None
    if number is None or not least <= number <= most:
        if number is None:
            shown = repr(value)
        elif abs(int(number)) < 10**30:
            shown = str(number)
        else:
            shown = "a number too long"
        raise OptionError(
            f"{name} is not a whole number" if number is None else f"{name} is outside the range",
            got=shown, allowed=f"{least} … {most}",
        )
    return int(number)


def handles_of(robot: Robot) -> Handles:
    """The robot's handles, forgotten when the robot is.

    Where that failed, as a callback does that is called at the limit of recursion, another robot may come to stand at
    the same address: handles are taken only from the robot that they were made for.
    """
    handles = _handles.get(id(robot))
    if handles is None or handles.robot() is not robot:
        handles = _handles[id(robot)] = Handles(robot)
        _core.keep(robot, handles.chain, handles.world)  # for the calls of one configuration
        weakref.finalize(robot, _let_go, id(robot))
    return handles


def _let_go(robot: int) -> None:
    _core.let_go(robot)
    _handles.pop(robot, None)


def chain_of(robot: Robot) -> _core.Chain:
    """The robot's chain in the core."""
    return handles_of(robot).chain


def frame_view(
    robot: Robot, frame: Frame, rows: tuple[int, ...] = _ALL_ROWS, length: float = 1.0
) -> _core.View:
    """Some rows, all six unless said, seen in `frame`; those of translation divided by a length."""
    handles = handles_of(robot)
    key = (frame, rows, length)
    view = handles.views.get(key)
    if view is None:
        view = handles.views[key] = _make_view(handles.chain, robot, *key)
    return view


def task_view(robot: Robot, task: Task) -> _core.View:
    """The rows of `task`, translation divided by its length scale."""
    return frame_view(robot, task.frame, task.rows, task.scale(robot))


def view_of(robot: Robot, task: Task | str | None) -> _core.View:
    """The view of a task as people name it, looked up by that name: in less time than resolving it takes.

    Raises:
        TaskError: the task does not exist.
    """
    views = handles_of(robot).tasks
    if isinstance(task, list):
        task = tuple(task)
    view = views.get(task)
    if view is None:
        view = views[task] = task_view(robot, resolve_task(task, robot))
    return view


def configurations(robot: Robot, q: ArrayLike) -> tuple[Array, tuple[int, ...]]:
    """q as a contiguous (B, n) array, and its leading batch shape.

    Raises:
        ConfigurationError: wrong last dimension, or a value that is not finite (named by its index).
        RobotError: not a Robot.
    """
    check_robot(robot)
    array = as_numbers(q, "q", ConfigurationError)
    if array.ndim == 0 or array.shape[-1] != robot.n:
        raise ConfigurationError(
            f"expected q of shape (..., {robot.n})", where=f"robot {robot.name!r}", got=array.shape,
            allowed="one number per joint: " + ", ".join(joint.name for joint in robot.variables),
        )
    if not np.isfinite(array).all():
        bad = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise ConfigurationError(
            "q has a value that is not finite", where=f"robot {robot.name!r}", got=f"{array[bad]} at index {bad}"
        )
    return np.ascontiguousarray(array).reshape(-1, robot.n), array.shape[:-1]


def one_configuration(robot: Robot, q: ArrayLike) -> Array:
    """q as one finite configuration (n,).

    Raises:
        ConfigurationError: another shape, or a value that is no number or not finite.
    """
    configuration = np.array(as_numbers(q, "q", ConfigurationError))
    if configuration.shape != (robot.n,) or not np.isfinite(configuration).all():
        names = ", ".join(joint.name for joint in robot.variables)
        raise ConfigurationError(
            f"one configuration is needed: {robot.n} finite numbers", where=f"robot {robot.name!r}",
            got=configuration.shape if configuration.shape != (robot.n,) else configuration.tolist(),
            allowed=f"one number per joint: {names}",
        )  # fmt: skip
    return configuration


def rows_of(out: Array | None, q: Array, batch: tuple[int, ...], entry: tuple[int, ...]) -> Array | None:
    """The caller's array as the core writes it, (B, *entry); None for none.

    Raises:
        OptionError: not a writable C-contiguous float64 array of shape (*batch, *entry), or sharing memory with q.
    """
    if out is None:
        return None
    shape = (*batch, *entry)
    if not isinstance(out, np.ndarray) or out.dtype != np.float64 or out.shape != shape:
        if isinstance(out, np.ndarray):
            got = f"{out.dtype} {out.shape}"
        else:
            got = f"a {type(out).__name__}"
        raise OptionError("out does not fit the result", got=got, allowed=f"a float64 array of shape {shape}")
    if not out.flags.c_contiguous or not out.flags.writeable:
        raise OptionError("out cannot be written to row by row", allowed="a C-contiguous, writable array")
    if np.may_share_memory(out, q):
        raise OptionError("out and q share memory", allowed="an array of its own")
    return out.reshape(-1, *entry)


def _make_chain(robot: Robot) -> _core.Chain:
    index = {joint.name: i for i, joint in enumerate(robot.variables)}
    driver = [index[joint.mimic.leader if joint.mimic else joint.name] for joint in robot.joints]
    return _core.make_chain(
        screws=np.array([joint.screw for joint in robot.joints]),
        turns=[int(joint.kind is not JointKind.PRISMATIC) for joint in robot.joints],
        frames=np.array([np.eye(4), *(joint.frame for joint in robot.joints), robot.home]),
        variable=driver,
        multiplier=np.array([joint.mimic.multiplier if joint.mimic else 1.0 for joint in robot.joints]),
        offset=np.array([joint.mimic.offset if joint.mimic else 0.0 for joint in robot.joints]),
        variables=robot.n,
    )


def _make_view(chain: _core.Chain, robot: Robot, frame: Frame, rows: tuple[int, ...], length: float) -> _core.View:
    joints = len(robot.joints)
    return _core.make_view(
        chain, axes=link_index(frame.axes, joints, "axes"), origin=link_index(frame.origin, joints, "origin"),
        point=list(frame.point), rows=list(rows), factors=[1.0 / length if row < 3 else 1.0 for row in rows],
    )


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
    single = pose_one(robot, q, out, None)
    if single is not None:
        return single
    rows, batch = configurations(robot, q)
    found = _core.pose(chain_of(robot), rows, rows_of(out, rows, batch, (4, 4)))
    if out is None:
        return found.reshape(*batch, 4, 4)
    return out


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


def jacobian(robot: Robot, q: ArrayLike, frame: Frame | str = WORLD_ALIGNED, *, out: Array | None = None) -> Array:
    """Geometric Jacobian: column i is the twist (v; ω) that unit speed of joint i gives the tip.

    J_i = (Rᵀ(v_i + ω_i × p) ; Rᵀω_i), with R the axes and p the reference point of `frame` (AM eq. 1; for a revolute
    joint v_i + ω_i × p = z_i × (p − p_i)).

    Args:
        robot: the arm.
        q: (..., n) configurations [rad or m].
        frame: SPACE, BODY, WORLD_ALIGNED (default), or any `Frame` of the chain; or "space", "tip", "base".
        out: where to write the result, float64 of its shape; fresh memory costs a large batch up to half its time.

    Returns:
        (..., 6, n): rows 0–2 in m per rad or m, rows 3–5 in rad per rad or m.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
        OptionError: out has another shape or type, or shares memory with q.
        TaskError: no such frame, or it names a link that does not exist.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> jacobian(open_robot("pa10"), [0.0] * 7).shape
        (6, 7)
    """
    frame = frame_of(frame)
    view = None
    if frame is not WORLD_ALIGNED:
        view = frame_view(robot, frame)
    single = jacobian_one(robot, q, out, view)
    if single is not None:
        return single
    rows, batch = configurations(robot, q)
    if view is None:
        view = handles_of(robot).world
    into = rows_of(out, rows, batch, (6, robot.n))
    found = _core.jacobian(chain_of(robot), view, rows, into)
    if out is None:
        return found.reshape(*batch, 6, robot.n)
    return out


def jacobian_derivative(
    robot: Robot, q: ArrayLike, frame: Frame | str = WORLD_ALIGNED, *, out: Array | None = None
) -> Array:
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
        TaskError: no such frame, or it names a link that does not exist.
    """
    frame = frame_of(frame)
    view = None
    if frame is not WORLD_ALIGNED:
        view = frame_view(robot, frame)
    single = derivative_one(robot, q, out, view)
    if single is not None:
        return single
    rows, batch = configurations(robot, q)
    if view is None:
        view = handles_of(robot).world
    into = rows_of(out, rows, batch, (6, robot.n, robot.n))
    derivative = _core.derivative(chain_of(robot), view, rows, into)
    if out is None:
        return derivative.reshape(*batch, 6, robot.n, robot.n)
    return out


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
    view = task_view(robot, task)
    single = jacobian_one(robot, q, None, view)
    if single is not None:
        return single
    rows, batch = configurations(robot, q)
    return _core.jacobian(chain_of(robot), view, rows).reshape(*batch, task.m, robot.n)


def task_jacobian_derivative(robot: Robot, q: ArrayLike, task: Task) -> Array:
    """Derivative of `task_jacobian` by every joint.

    Returns:
        (..., m, n, n): [..., :, i, k] = ∂J[:, i]/∂q_k.

    Raises:
        ConfigurationError: q has the wrong shape or is not finite.
    """
    view = task_view(robot, task)
    single = derivative_one(robot, q, None, view)
    if single is not None:
        return single
    rows, batch = configurations(robot, q)
    derivative = _core.derivative(chain_of(robot), view, rows)
    return derivative.reshape(*batch, task.m, robot.n, robot.n)
