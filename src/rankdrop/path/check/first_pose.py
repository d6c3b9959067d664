"""Which configuration does the arm have at the first pose of a tool path, and how many others are there?"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import ConfigurationError
from rankdrop.local.block import generic_rank, joint_scale, sampling_box, singular_values
from rankdrop.local.pointing import fitting_task
from rankdrop.local.posture import by_habit
from rankdrop.path.check.follow import follow
from rankdrop.path.check.missed_singularity import missed_start
from rankdrop.poses.inverse import Aim, distinct, near_and_within, wrap_joints
from rankdrop.poses.unreached import nearest_configurations
from rankdrop.problem import whole_turns
from rankdrop.robot.model import Array, Robot, first_joint_beyond_limit
from rankdrop.robot.transform import as_numbers
from rankdrop.task import Task
from rankdrop.units import in_metres, into_metres, task_in_metres

_EDGE_STARTS = 128  # of Levenberg's method, for a pose at the edge of reach
_EDGE = 1e-9  # a joint this far beyond a limit stands at it [rad, m]
_NEAR_START = 0.5  # a start so far from where Newton's method ends may belong to another branch [rad]
STARTS = 512
"""Random configurations, and the one nearest to zero, that solutions at the first pose are searched from."""
_REGULAR = 1e-5  # σ_r below which a configuration may be on a self-motion
SAME_SOLUTION = 1e-4
"""Solutions nearer to each other are one [rad]."""


def within_limits(robot: Robot, goal: Array, task: Task) -> Array:
    """(S, n) configurations at a pose (4, 4) within the joint limits, those first that people use, of those found.

    Newton's method from `STARTS` random configurations and from the one nearest to zero; a redundant arm has more.
    """
    low, high = sampling_box(robot, task, limits=True)
    home = np.clip(np.zeros(robot.n), robot.lower, robot.upper)
    starts = np.concatenate([home[None], np.random.default_rng(0).uniform(low, high, (STARTS, robot.n))])
    q = near_and_within(robot, Aim(robot, task).solve_from(goal, starts), home, limits=True)
    far = np.linalg.norm((q - home) / joint_scale(robot, task), axis=1)
    solutions = distinct(robot, task, q[np.argsort(far, kind="stable")], SAME_SOLUTION)
    if len(solutions) and robot.n <= task.m:
        return solutions[by_habit(robot, task, solutions)]
    return solutions


def first_configuration(
    robot: Robot, poses: Array, task: Task, start: ArrayLike | None, tolerance: tuple[float, float]
) -> tuple[Array, Array, float]:
    """As `configuration_at`, and at a first pose that misses the singularity of the start by rounding this singularity,
    where the branch leads straight away from it.
    """
    if start is not None:
        given = _validate_start(robot, start)
        met = missed_start(Aim(robot, task), poses[0], given)
        if met is not None:
            left = follow(robot, poses[:2], met, task, tolerance=tolerance, through=True)
            if len(left.q) > 1 and np.linalg.norm(left.q[0] - met) <= SAME_SOLUTION:
                away = float(np.linalg.norm((met - given) / joint_scale(robot, task)))
                return met, within_limits(robot, poses[0], task), away
    return configuration_at(robot, poses[0], task, start)


def configuration_at(robot: Robot, goal: Array, task: Task, start: ArrayLike | None) -> tuple[Array, Array, float]:
    """A configuration at the first pose, all that were found, and how far it is from the start that was given."""
    if start is None:
        given = None
    else:
        given = _validate_start(robot, start)
    solutions = within_limits(robot, goal, task)
    if not len(solutions):
        edge = edge_of_reach(robot, goal, task, given)
        if edge is not None:
            return edge, edge[None], _distance(robot, task, edge, given)
    if given is not None:
        near = _nearest_to_start(robot, goal, task, solutions, given)
        if near is not None:
            return near[0], solutions, near[1]
    if not len(solutions):
        raise _out_of_reach(robot, goal, task)
    return solutions[0], solutions, 0.0


def _distance(robot: Robot, task: Task, q: Array, given: Array | None) -> float:
    """How far a configuration (n,) is from the start that was given [rad; slides by the length scale]."""
    if given is None:
        return 0.0
    return float(np.linalg.norm((q - given) / joint_scale(robot, task)))


def edge_of_reach(robot: Robot, goal: Array, task: Task, given: Array | None = None) -> Array | None:
    """(n,) the configuration at the edge of reach, within the joint limits, that a pose (4, 4) without solution misses
    by as little as poses are rounded; None where there is none.

    Args:
        robot, task: the arm.
        goal: the pose.
        given: (n,) a start near it; None: random ones.
    """
    aim = Aim(robot, task)
    if not aim.square:
        return None
    if given is None:
        low, high = sampling_box(robot, task, limits=True)
        starts = np.random.default_rng(0).uniform(low, high, (_EDGE_STARTS, robot.n))
    else:
        starts = given[None]
    ends = wrap_joints(robot, nearest_configurations(aim, goal, np.ones(task.m), starts))
    inside = [q for q in ends if first_joint_beyond_limit(robot, q[None]) < 0]
    if not inside:
        return None
    edge = missed_start(aim, goal, inside[0])
    if edge is None or first_joint_beyond_limit(robot, edge[None]) >= 0:
        return None
    return edge


def count_solutions(robot: Robot, goal: Array, task: Task, solutions: Array) -> tuple[int, int]:
    """How many isolated configurations and how many self-motions at a pose were found within the joint limits.

    Newton's method ends on many points of a self-motion, which are no solutions of their own; `inverse` joins them.

    Args:
        robot, task: the arm.
        goal: (4, 4) the pose.
        found: (S, n) from `within_limits`.

    Returns:
        Of a redundant arm the number of points found, and 0.
    """
    if robot.n > task.m or not len(solutions):
        return len(solutions), 0
    arm, arm_task = in_metres(robot), task_in_metres(task, robot)
    sigma = singular_values(arm, into_metres(robot, solutions), arm_task)[:, generic_rank(arm, arm_task) - 1]
    singular = sigma < _REGULAR
    regular = int((~singular).sum())
    if singular.sum() < 2:
        return len(solutions), 0
    from rankdrop.poses.branches import inverse  # a path from a regular pose does without

    every = inverse(robot, goal, task)
    inside = [branch for branch in every.branches if not branch.beyond]
    isolated = sum(branch.sigma < _REGULAR for branch in inside)
    return regular + isolated, sum(not continuum.beyond for continuum in every.continua)


def _out_of_reach(robot: Robot, goal: Array, task: Task) -> ConfigurationError:
    """The error of a first pose without a configuration; with the task to ask for where the arm has too few joints."""
    other = fitting_task(robot, task)
    if other is not None and len(within_limits(robot, goal, other)):
        return ConfigurationError(
            f"{robot.n} joints cannot take pose 1 in full", where="poses", got="position and orientation",
            mend=f"task={other.name!r} leaves free what they cannot do",
            typed=f"--task {other.name} leaves free what they cannot do",
        )  # fmt: skip
    return ConfigurationError(
        "pose 1 is out of reach: no configuration within the joint limits was found", where="poses",
        got=f"{STARTS + 1} starts of Newton's method", mend="look at its units and its frame, or give a start",
        typed="look at its units and its frame, or give --start; explain with --pose prints how far it is off",
    )  # fmt: skip


def _validate_start(robot: Robot, start: ArrayLike) -> Array:
    """(n,) the start that was given [rad, m].

    Raises:
        ConfigurationError: it is no configuration.
    """
    given = as_numbers(start, "start", ConfigurationError)
    if given.shape != (robot.n,) or not np.isfinite(given).all():
        raise ConfigurationError("the start is one configuration", where="start", got=f"shape {given.shape}",
                                 allowed=f"{robot.n} finite numbers")  # fmt: skip
    return given


def _nearest_to_start(
    robot: Robot, goal: Array, task: Task, solutions: Array, given: Array
) -> tuple[Array, float] | None:
    """The configuration at the first pose that is nearest to the start, and how far it is; None where none is known.

    Raises:
        ConfigurationError: the pose is not reached from the start.
    """
    reached = follow(robot, goal[None], given, task)
    scale = joint_scale(robot, task)
    ends = solutions + whole_turns(robot, given - solutions)
    inside = np.asarray(((ends >= robot.lower - _EDGE) & (ends <= robot.upper + _EDGE)).all(axis=1))
    ends = np.where(inside[:, None], ends, solutions)  # whole turns as in the start, where the limits allow them
    if reached.complete:
        far = float(np.linalg.norm((reached.q[0] - given) / scale))
        if far <= _NEAR_START or not len(ends) or robot.n > task.m:
            return reached.q[0], far
        ends = np.concatenate([reached.q[:1], ends])
    if len(ends) and not reached.joint:
        away = np.linalg.norm((ends - given) / scale, axis=1)
        return ends[away.argmin()], float(away.min())
    if reached.complete:
        return None
    raise ConfigurationError(
        "pose 1 is not reached from this start: " + (
            f"joint {reached.joint} is beyond its limit there" if reached.joint else "Newton's method fails"
        ), where="start", mend="a start nearer to it, or none",
    )  # fmt: skip
