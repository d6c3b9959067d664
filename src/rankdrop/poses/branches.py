"""`inverse`: the configurations of an arm at one pose of the tip, each confirmed by forward kinematics.

Damped Newton's method from random starts finds solutions (`poses.inverse`, `poses.solution_search`). Not finding one
proves nothing; how the search was made is part of the result. Where there is none, `poses.unreached` says how far the
pose is out of reach.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.codec import Result
from rankdrop.configuration import configuration_at
from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import check_robot
from rankdrop.options import takes
from rankdrop.poses.arm_posture import ArmPosture, arm_postures
from rankdrop.poses.inverse import Aim
from rankdrop.poses.postures import posture_names
from rankdrop.poses.solution_search import SINGULAR, Continuum, SelfMotionCurve, SolutionSearch, joints_beyond
from rankdrop.poses.unreached import Unreached, tilt_missing, why_unreached
from rankdrop.problem import into_limits
from rankdrop.questions import ExplainOptions, InverseOptions
from rankdrop.results.explanation import Explanation
from rankdrop.results.known import known_families
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.transform import as_numbers, from_xyz_rpy, nearest_rotation
from rankdrop.sections import Section
from rankdrop.task import Task, resolve_task
from rankdrop.text.inverse import inverse_sections, inverse_sentence
from rankdrop.tolerances import DEFAULT

_JUDGED = 64  # branches whose verdict is computed by a search; beyond, by σ alone
_QUATERNION = 1e-3  # a quaternion's length may be off by this: digits of a file


@dataclass(frozen=True, eq=False)
class Branch:
    """One isolated configuration at the pose.

    Attributes:
        q: (n,) [rad, m]; turning joints between their limits where a whole turn brings them there.
        verdict: "regular", "near" or "singular", as `explain` gives it.
        sigma: σ_r [1].
        posture: signs of the parts of the arm, such as "elbow +"; empty where none are known.
        parts: the posture by parts of the arm.
        beyond: joints (from 1) outside their limits, each with how far [rad, m].
        residual: the largest entry of the difference between the pose of q and the pose asked for [m, 1].
    """

    q: Array
    verdict: str
    sigma: float
    posture: tuple[str, ...]
    parts: ArmPosture
    beyond: tuple[tuple[int, float], ...]
    residual: float


@dataclass(frozen=True, eq=False)
class InverseSolutions(Result):
    """The solutions that were found, how they were searched, and why there is none.

    Attributes:
        robot, task, options: what was asked.
        pose: (4, 4) of the tip in the base frame [m].
        branches: isolated solutions, those inside the joint limits first, then the nearest to q = 0.
        continua: self-motions.
        most: the number that no such arm exceeds: 16 for six turning joints and a full pose; None where none is stated.
        starts: starts of Newton's method.
        arrived: how many of them ended on a solution.
        more: there may be self-motions that are not listed: beyond a number of curves, or next to a surface.
        unreached: why there is no solution; None where there is one.
    """

    robot: Robot
    task: Task
    options: InverseOptions
    pose: Array
    branches: tuple[Branch, ...]
    continua: tuple[Continuum, ...]
    most: int | None
    starts: int
    arrived: int
    more: bool
    unreached: Unreached | None
    FILE: ClassVar[str] = "inverse"

    @property
    def inside(self) -> int:
        """How many solutions and self-motions have a place inside the joint limits."""
        return sum(not branch.beyond for branch in self.branches) + sum(not branch.beyond for branch in self.continua)

    @property
    def residual(self) -> float:
        """The largest of all."""
        every = [branch.residual for branch in self.branches] + [branch.residual for branch in self.continua]
        return max(every, default=0.0)

    @property
    def missed(self) -> tuple[float, float] | None:
        """By how much the tool misses the pose at most [m, rad], where it takes the nearest one in reach; else None."""
        found = [branch.q for branch in self.branches] + [continuum.q for continuum in self.continua]
        q = np.array(found).reshape(-1, self.robot.n)
        return Aim(self.robot, self.task).missed(np.broadcast_to(self.pose, (len(q), 4, 4)), q)

    @property
    def sentence(self) -> str:
        """How many solutions there are, or why there is none."""
        return inverse_sentence(self)

    def sections(self, *, deg: bool = False) -> tuple[Section, ...]:
        """For people: the count first, then a table of the solutions, then how they were searched."""
        return inverse_sections(self, deg=deg)


def _unit_quaternion(given: Array) -> Array:
    """A quaternion (4,) of unit length to rounding, divided by its length.

    Raises:
        ConfigurationError: it has another length.
    """
    length = float(np.linalg.norm(given))
    if abs(length - 1.0) <= _QUATERNION:
        return np.asarray(given / length)
    mend = None
    if length > _QUATERNION:
        mend = f"write {','.join(f'{value:.9g}' for value in given / length)}"
    raise ConfigurationError("the quaternion has no unit length", where="pose", got=f"length {length:.6g}",
                             allowed="qx² + qy² + qz² + qw² = 1", mend=mend)  # fmt: skip


def matrix_of(pose: ArrayLike) -> Array:
    """(4, 4) the pose that numbers write.

    Args:
        pose: a (4, 4) matrix; x, y, z; x, y, z, roll, pitch, yaw with R = Rz(yaw) Ry(pitch) Rx(roll); or
            x, y, z, qx, qy, qz, qw [m, rad], in the base frame.

    Raises:
        ConfigurationError: neither of these, not finite, no rotation, or no unit quaternion.
    """
    given = as_numbers(pose, "pose", ConfigurationError)
    forms = "a (4, 4) matrix; x,y,z; x,y,z,roll,pitch,yaw; or x,y,z,qx,qy,qz,qw [m, rad]"
    if given.shape not in ((4, 4), (3,), (6,), (7,)):
        raise ConfigurationError("this is no pose", where="pose", got=f"shape {given.shape}", allowed=forms)
    if not np.isfinite(given).all():
        raise ConfigurationError("the pose is not finite", where="pose", got=given.tolist(), allowed=forms)
    if given.shape == (7,):
        x, y, z, w = _unit_quaternion(given[3:])
        matrix = np.eye(4)
        matrix[:3, 3] = given[:3]
        k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        matrix[:3, :3] += 2 * w * k + 2 * k @ k
        return matrix
    if given.ndim == 1:
        return from_xyz_rpy(given[:3].tolist(), given[3:].tolist() or [0.0, 0.0, 0.0])
    turn = given[:3, :3]
    off = float(np.abs(turn @ turn.T - np.eye(3)).max())
    if off > 1e-6 or np.linalg.det(turn) < 0.0 or np.abs(given[3] - (0, 0, 0, 1)).max() > 1e-12:
        raise ConfigurationError("the pose is no rotation with a translation", where="pose", got=given.tolist(),
                                 allowed="[R p; 0 0 0 1]")  # fmt: skip
    matrix = given.copy()
    matrix[:3, :3] = nearest_rotation(turn)
    return matrix


@takes(InverseOptions)
def inverse(
    robot: Robot,
    pose: ArrayLike,
    task: Task | str | None = None,
    *,
    options: InverseOptions | None = None,
    **given: Any,
) -> InverseSolutions:
    """Find the configurations of an arm at a pose of the tip: all branches, or why there is none.

    Newton's method runs from random starts until several batches of them find nothing new. Each solution is confirmed
    by forward kinematics to 1e-9; of an arm of five joints to 0.05 mm and 5e-5 rad, since poses are rounded. That every
    solution is found is not proven. Joint limits do not restrict the search: each solution says which joints exceed
    theirs.

    Args:
        robot: the arm.
        pose: of the tip in the base frame: (4, 4); x, y, z, roll, pitch, yaw; or x, y, z, qx, qy, qz, qw [m, rad]. x,
            y, z alone do for a task without rotation. What the task leaves free is ignored, but for the tilt of a tool
            that no joint tilts.
        task: name, rows or Task; None is the task the arm is made for.
        options: starts and seed; its fields are taken as keywords as well.

    Returns:
        Isolated solutions with verdict, posture and joint limits; self-motions with their dimension; how far the pose
        is out of reach where there is none.

    Raises:
        ConfigurationError: this is no pose, or the task needs an orientation and the pose has none.
        OptionError: an option outside what is allowed.
        TaskError: no such task, or the pose does not determine what it wants.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = inverse(open_robot("puma560"), [0.3, 0.2, 0.4, 0.0, 1.2, 0.4])
        >>> len(found.branches), found.most, found.residual < 1e-9
        (8, 16, True)
        >>> inverse(open_robot("puma560"), [3, 0, 0, 0, 0, 0]).unreached.kind
        'position'
    """
    check_robot(robot)
    how = InverseOptions.of(options, given)
    resolved = resolve_task(task, robot)
    goal = _goal_of(pose, resolved)
    aim = Aim(robot, resolved)
    search = SolutionSearch(aim, resolved, goal)
    tilted = tilt_missing(search, how)
    if tilted is not None:
        return InverseSolutions(
            robot, resolved, how, goal, (), (), _most(robot, resolved), search.tried, search.arrived, False, tilted
        )
    search.run(how)
    isolated, curves, more = search.isolated_and_curves()
    branches = _judge_solutions(search, isolated)
    return InverseSolutions(
        robot, resolved, how, goal, branches, curves, _most(robot, resolved), search.tried, search.arrived, more,
        None if branches or curves else why_unreached(search, how),
    )  # fmt: skip


def _goal_of(pose: ArrayLike, task: Task) -> Array:
    """(4, 4) the pose that numbers write, with an orientation where the task has rows of rotation.

    Raises:
        ConfigurationError: as of `matrix_of`, or the orientation is missing.
    """
    goal = matrix_of(pose)
    if np.shape(pose) == (3,) and {3, 4, 5} & set(task.rows):
        raise ConfigurationError(
            "the pose has no orientation, and the task needs one", where="pose", got="x,y,z",
            allowed="x,y,z,roll,pitch,yaw; or x,y,z,qx,qy,qz,qw [m, rad]",
            mend="task='position', or 'planar-position', asks for the position alone",
            typed="--task position, or planar-position, asks for the position alone",
        )  # fmt: skip
    return goal


def _most(robot: Robot, task: Task) -> int | None:
    """16 for six turning joints and a full pose: Lee and Liang 1988, attained by Manseur and Doty 1989."""
    turning = all(joint.kind is not JointKind.PRISMATIC for joint in robot.joints)
    if robot.n == len(robot.joints) == task.m == 6 and turning:
        return 16
    return None


def self_motion_curves(
    robot: Robot, pose: ArrayLike, task: Task | str | None = None, *, options: InverseOptions | None = None
) -> tuple[tuple[SelfMotionCurve, ...], bool]:
    """Curves of configurations along which the tool stands still at a pose, joint limits ignored.

    Args:
        robot, pose, task, options: as of `inverse`.

    Returns:
        The curves, and whether there may be more. No curve where the self-motions are surfaces: an arm with two joints
        to spare, or more.

    Raises:
        ConfigurationError, OptionError, TaskError: as `inverse`.
    """
    check_robot(robot)
    resolved = resolve_task(task, robot)
    search = SolutionSearch(Aim(robot, resolved), resolved, _goal_of(pose, resolved))
    search.run(options or InverseOptions())
    _, _, more = search.isolated_and_curves()
    return tuple(search.curves), more


def _judge_solutions(search: SolutionSearch, q: Array) -> tuple[Branch, ...]:
    """Isolated solutions with verdict, posture and limits, in order."""
    robot, task = search.robot, search.task
    q = into_limits(robot, q)
    sigma = search.sigma(q)
    postures, parts = posture_names(robot, task, q), arm_postures(robot, q)
    if len(q):
        families, source = known_families(robot, task, None, DEFAULT)
    else:
        families, source = ((), "")
    branches: list[Branch] = []
    for row in range(len(q)):
        verdict = "singular"
        if sigma[row] > SINGULAR:
            how = ExplainOptions(evaluations=0)
            if sigma[row] > how.small:
                verdict = "regular"
            else:
                verdict = "near"
            if row < _JUDGED:
                verdict = str(Explanation(configuration_at(robot, q[row], task), families, source, how).verdict)
        branches.append(Branch(q[row], verdict, float(sigma[row]), postures[row], parts[row],
                           joints_beyond(robot, q[row]), search.residual(q[row : row + 1])))  # fmt: skip
    home = np.clip(np.zeros(robot.n), robot.lower, robot.upper)

    def order(branch: Branch) -> tuple[bool, float]:
        return bool(branch.beyond), round(float(np.linalg.norm((branch.q - home) / search.scale)), 6)

    return tuple(sorted(branches, key=order))
