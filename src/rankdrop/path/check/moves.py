"""The moves of a robot program, followed one after the other: rows of joint values with their times.

A joint move goes straight in joint space, a linear move straight with its tip (`path.check.follow`), from the
configuration in which the move before it ended, as a controller does without blending.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import StrEnum
from itertools import product
from math import floor, pi
from typing import Literal

import numpy as np

from rankdrop.errors import ConfigurationError
from rankdrop.kinematics import pose
from rankdrop.local.block import joint_scale
from rankdrop.local.orientation import orientation_coordinates, rotation_vector
from rankdrop.path.check.first_pose import configuration_at, within_limits
from rankdrop.path.check.follow import follow
from rankdrop.path.check.path_file import PathQuestion
from rankdrop.path.check.tool_branch import Followed
from rankdrop.path.check.tool_line import poses_at
from rankdrop.path.check.tool_path import check_tilt, followed_branch, timed_branch, tip_apart
from rankdrop.path.read.arc import arc_poses
from rankdrop.path.read.makers import axes_2_and_3_opposed
from rankdrop.path.read.program_record import Move, MoveAssumption, Posture, Program
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.poses.inverse import Aim
from rankdrop.robot.files import MOST_ROWS
from rankdrop.robot.model import Array, Robot, with_tool
from rankdrop.task import Task
from rankdrop.units import counted_length

STILL = 1e-12  # a move that is shorter does nothing [m, rad]
_SLOWER = 1.0 + 1e-9  # a joint move at the limits of its rates stays below them by rounding
_FIRST_TURN = 3  # row of a task from which on rows are turns
_HALF_TURN = 1e-4  # a turn so near to half a turn has two shortest ways [rad]
_AT_ZERO = 1e-6  # a joint so near to a quarter turn has either sign [rad]
_MOST_TURNS = 4096  # combinations of whole turns of one solution


class EndCause(StrEnum):
    """Why a move could not be followed."""

    UNREACHED = "out of reach"
    POSTURE = "no such posture"
    BRANCH = "branch ends"
    NO_CIRCLE = "no circle"


@dataclass(frozen=True, eq=False)
class Ended:
    """A move that could not be followed to its end.

    Attributes:
        move: the move.
        cause: why.
        branch: how far the tip was followed on its line: place 1 is its beginning, 2 its end; None for other causes.
        available: cf1, cf4, cf6 of the solutions within the joint limits, where the target states others.
    """

    move: Move
    cause: EndCause
    branch: Followed | None = None
    available: tuple[tuple[int, int, int], ...] = ()


def with_tool_frame(robot: Robot, tool: Array) -> Robot:
    """The arm with a tool frame (4, 4) at its tip [m]."""
    return with_tool(robot, tool[:3, 3], orientation_coordinates(tool[:3, :3], "rpy").tolist())


@dataclass(eq=False)
class FollowedMoves:
    """Rows of a part while it is built; `assumptions`: those of its moves, by their index."""

    moves: list[Move]
    assumptions: dict[int, set[MoveAssumption]] = field(default_factory=dict)
    begins: Literal["joints", "start", "before", "stated", "posture"] = "joints"
    rows: list[Array] = field(default_factory=list)
    owner: list[int] = field(default_factory=list)
    lasts: list[float] = field(default_factory=list)
    speeds: list[Array] = field(default_factory=list)
    untimed: Move | None = None
    ended: Ended | None = None
    off: float = 0.0
    turned: float = 0.0
    passed: list[int] = field(default_factory=list)

    def assume(self, index: int, *assumptions: MoveAssumption) -> None:
        """Keep assumptions with which a move is followed."""
        if assumptions:
            self.assumptions.setdefault(index, set()).update(assumptions)

    def add(self, index: int, rows: Array, lasts: Array | None, speeds: Array | None) -> None:
        """Rows after the last one, with the time and the joint rates of each stretch."""
        self.rows.extend(rows)
        self.owner.extend([index] * len(rows))
        if lasts is None or speeds is None:
            self.untimed = self.untimed or self.moves[index]
        else:
            self.lasts.extend(lasts.tolist())
            self.speeds.extend(speeds)


class MoveFollower:
    """Moves made one after the other."""

    def __init__(self, robot: Robot, task: Task, program: Program, question: PathQuestion, raised: float) -> None:
        self.robot, self.task, self.program, self.raised = robot, task, program, raised
        how = question.options
        self.tolerance = how.tip_tolerance * counted_length(robot), how.turn_tolerance
        self.own_tools = program.tool is None and not question.at_tool_point
        self.arms: dict[bytes, Robot] = {}
        self.rates = np.array([joint.velocity for joint in robot.variables], dtype=np.float64)
        self.solved: dict[tuple[int, bytes], Array] = {}

    def follow_moves(self, moves: list[Move], before: Array | None, *, given: bool) -> FollowedMoves:
        """Rows of a run of moves, up to the first that cannot be followed."""
        followed = FollowedMoves(moves)
        for index, move in enumerate(moves):
            if not followed.rows:
                self._begin(followed, move, before, given=given)
            elif move.kind == "joint":
                self._joint_move(followed, index, move)
            else:
                self._line(followed, index, move)
            followed.assume(index, *move.assumed)
            if followed.ended is not None:
                break
            if len(followed.rows) > MOST_ROWS:
                raise TrajectoryError(
                    "the moves up to this line need too many rows", where=f"{self.program.name}, line {move.line}",
                    allowed=f"at most {MOST_ROWS:,}", mend="check parts of the program for themselves",
                )  # fmt: skip
        return followed

    def _begin(self, followed: FollowedMoves, move: Move, before: Array | None, *, given: bool) -> None:
        """The first configuration of a part."""
        if move.target.joints is not None:
            followed.rows.append(self._joints(move))
            return
        first = self._at_first_pose(move, before)
        if isinstance(first, EndCause):
            followed.ended = self._ended(move, first)
            return
        followed.rows.append(first)
        if move.target.posture != Posture():
            followed.begins = "stated"
        elif before is None:
            followed.begins = "posture"
        elif given:
            followed.begins = "start"
        else:
            followed.begins = "before"

    def _at_first_pose(self, move: Move, before: Array | None) -> Array | EndCause:
        """A configuration at the pose of a move: in the posture it names, else near to the one before; or why none."""
        goal, posture = self._pose(move), move.target.posture
        if before is not None and posture == Posture():
            reached = self._reached_from(move, before, goal)
            if reached is not None:
                return reached
        solutions = self._solutions(move, goal)
        if before is None and len(solutions):
            near = solutions[0]
        else:
            near = before
        chosen = self._in_posture(solutions, self._near(move, near), posture)
        if chosen is not None:
            return chosen
        if len(solutions):
            return EndCause.POSTURE
        return EndCause.UNREACHED

    def _arm(self, move: Move) -> Robot:
        """The arm with the tool of a move at its tip."""
        tool = move.tool
        if not self.own_tools or tool is None or np.array_equal(tool, np.eye(4)):
            return self.robot
        key = tool.tobytes()
        if key not in self.arms:
            self.arms[key] = with_tool_frame(self.robot, tool)
        return self.arms[key]

    def _reached_from(self, move: Move, before: Array, goal: Array) -> Array | None:
        """A configuration at a pose on the branch of another one; None where a joint reaches its limit on the way."""
        try:
            return configuration_at(self._arm(move), goal, self.task, before)[0]
        except ConfigurationError:
            return None

    def _joint_move(self, followed: FollowedMoves, index: int, move: Move) -> None:
        """Straight in joint space, to joint values or to a solution of a pose."""
        now = followed.rows[-1]
        if move.target.joints is not None:
            end = self._joints(move)
        else:
            goal = self._pose(move)
            if self.robot.n > self.task.m:
                reached = follow(self._arm(move), goal[None], now, self.task)
                if reached.complete:
                    solutions = reached.q
                else:
                    solutions = self._solutions(move, goal)
            else:
                solutions = self._solutions(move, goal)
            chosen = self._in_posture(solutions, self._near(move, now), move.target.posture)
            if chosen is None:
                followed.ended = self._ended(move, EndCause.POSTURE if len(solutions) else EndCause.UNREACHED)
                return
            end = chosen
        step = np.abs(end - now)
        if step.max(initial=0.0) <= STILL:
            return
        lasts = self._seconds(move, step)
        followed.add(index, end[None], np.array([lasts]), step[None] / lasts)

    def _seconds(self, move: Move, step: Array) -> float:
        """How long a joint move takes: as stated, else as its share of the largest joint rates allows [s].

        Where the arm has no limits of rates, a joint that leads is taken to turn by 1 rad/s: nothing is checked by it.
        """
        speed = move.speed
        if speed.time is not None:
            return speed.time
        if speed.joint is not None:
            return float(step.max()) / speed.joint
        limited = np.isfinite(self.rates) & (self.rates > 0.0)
        if limited.any():
            rates = np.where(limited, self.rates, np.inf)
        else:
            rates = np.ones(len(step))
        share = min(1.0, speed.share or 1.0)
        least = float((step / rates).max()) * _SLOWER / share
        return least if least > 0.0 else 1.0

    def _line(self, followed: FollowedMoves, index: int, move: Move) -> None:
        """Straight with the tip, or on an arc, followed on the branch of the last row."""
        now, arm = followed.rows[-1], self._arm(move)
        begin, end = self._ends_of_line(move, now)
        way = self._way(move, begin, end)
        if way is None:
            followed.ended = Ended(move, EndCause.NO_CIRCLE)
            return
        length = float(np.linalg.norm(np.diff(way[:, :3, 3], axis=0), axis=1).sum())
        turn = float(np.linalg.norm(rotation_vector((end[:3, :3] @ begin[:3, :3].T)[None])[0]))
        if max(length, turn) <= STILL:
            return
        branch = followed_branch(arm, way, now, self.task, self.tolerance, free=False)
        line_path = timed_branch(arm, self.task, way, self._line_times(move, length, turn, len(way)), branch)
        if len(branch.q):
            off, turned = tip_apart(Aim(arm, self.task), branch.q, poses_at(way, branch.place - 1.0))
            off += self._height * (move.kind == "arc")
            followed.off, followed.turned = max(followed.off, off), max(followed.turned, turned)
            jump = np.abs(branch.q[0] - now).max(initial=0.0) > STILL
            if line_path.times is None:
                lasts = None
            else:
                lasts = np.diff(line_path.times)
            rows = branch.q[1:]
            speeds = line_path.speeds
            if jump:  # the tool is held still there: the start lies on a singularity, and is left by a small turn
                rows = branch.q
                lasts = speeds = None
            if len(rows):
                followed.add(index, rows, lasts, speeds)
        if branch.passed:
            followed.passed.append(index)
        if not branch.complete:
            followed.ended = Ended(move, EndCause.BRANCH, _as_shares(branch, len(way) - 1))
        self._assume_of_line(followed, index, move, turn)

    def _assume_of_line(self, followed: FollowedMoves, index: int, move: Move, turn: float) -> None:
        """Keep that a line has two ways round, or that it does not arrive in the posture of its target."""
        if turn >= pi - _HALF_TURN and max(self.task.rows) >= _FIRST_TURN:
            followed.assume(index, MoveAssumption.HALF_TURN)
        arrives = followed.ended is not None or _fits(followed.rows[-1], move.target.posture)
        if move.checks_arrival and not arrives:
            followed.assume(index, MoveAssumption.ARRIVAL)

    def _ends_of_line(self, move: Move, now: Array) -> tuple[Array, Array]:
        """(4, 4) each: where the tip is, and where it goes."""
        arm = self._arm(move)
        begin = pose(arm, now)
        if move.target.joints is None:
            end = self._pose(move)
        else:
            end = np.array(pose(arm, self._joints(move)))
        if move.keeps_turn:
            end[:3, :3] = begin[:3, :3]
        return begin, end

    @property
    def _height(self) -> float:
        """By which chords may leave an arc: a tenth of what the tip may [m]."""
        return 0.1 * self.tolerance[0]

    def _way(self, move: Move, begin: Array, end: Array) -> Array | None:
        """(K, 4, 4) poses between which the tip goes straight; None for an arc through places on one line."""
        if move.kind != "arc":
            return np.stack([begin, end])
        via = np.array(move.via)
        via[2] += self.raised
        return arc_poses(begin, via, end, self._height)

    def _line_times(self, move: Move, length: float, turn: float, count: int) -> Array | None:
        """(count,) times of the poses of a linear move or an arc, which are equally far apart; None: not known."""
        lasting = self._line_seconds(move, length, turn)
        if lasting is None:
            return None
        return np.linspace(0.0, lasting, count)

    def _line_seconds(self, move: Move, length: float, turn: float) -> float | None:
        """How long a linear move takes; None where the program does not say.

        The tip keeps its speed and the tool its rate of turning; the slower of the two decides. Where only one is
        stated it decides, as long as there is a way for it.
        """
        speed = move.speed
        if speed.time is not None:
            return speed.time
        if speed.linear is None or length <= STILL:
            by_length = None
        else:
            by_length = length / speed.linear
        if speed.angular is None or turn <= STILL:
            by_turn = None
        else:
            by_turn = turn / speed.angular
        stated = [duration for duration in (by_length, by_turn) if duration is not None]
        return max(stated) if stated else None

    def _joints(self, move: Move) -> Array:
        """(n,) joint values of a target [rad, m].

        Raises:
            TrajectoryError: not as many as the arm has, or joint 3 is counted from the horizontal and the arm has other
                axes.
        """
        return self._in_units(move.target.joints or (), f"{self.program.name}, line {move.line}")

    def _near(self, move: Move, before: Array | None) -> Array | None:
        """The configuration to which the solution of a target is nearest: that it states, else the one before."""
        stated = move.target.posture.near
        if stated is None:
            return before
        return self._in_units(stated, f"{self.program.name}, line {move.line}")

    def _in_units(self, given: tuple[float, ...], where: str) -> Array:
        """(n,) joint values as the language has them [rad, m]; errors as of `_joints`."""
        n = self.robot.n
        if len(given) < n or any(given[n:]):
            raise TrajectoryError("the target has another number of joints than the arm", where=where, got=len(given),
                                  allowed=f"{n} of {self.robot.name}")  # fmt: skip
        values = np.array(given[:n])
        if self.program.degrees:
            values *= [np.pi / 180.0 if joint.unit == "rad" else 1e-3 for joint in self.robot.variables]
        if self.program.level and n >= 3:
            if not axes_2_and_3_opposed(self.robot):
                raise TrajectoryError(
                    "J3 is counted from the horizontal, and axes 2 and 3 of this arm do not point against each other",
                    where=where, mend="give the targets as poses",
                )  # fmt: skip
            values[2] += values[1]
        return values

    def _pose(self, move: Move) -> Array:
        """(4, 4) of a target in the base frame of the arm."""
        goal = np.array(move.target.pose)
        goal[2, 3] += self.raised
        check_tilt(self._arm(move), self.task, goal[None], f"{self.program.name}, line {move.line}")
        return goal

    def _solutions(self, move: Move, goal: Array) -> Array:
        """(S, n) solutions of a pose within the joint limits, those first that people use."""
        arm = self._arm(move)
        key = id(arm), goal.tobytes()
        if key not in self.solved:
            self.solved[key] = within_limits(arm, goal, self.task)
        return self.solved[key]

    def _ended(self, move: Move, cause: EndCause) -> Ended:
        """A move to a pose that was not made; where its target states another posture, with those that there are."""
        if cause is not EndCause.POSTURE or move.target.posture.quarters is None or self.robot.n < 6:
            return Ended(move, cause)
        solutions = self._solutions(move, self._pose(move))
        every = np.concatenate([self._add_whole_turns(solution) for solution in solutions])
        quarters = np.floor(every[:, [0, 3, 5]] / (pi / 2) + _AT_ZERO).astype(int).tolist()
        available = {(first, fourth, sixth) for first, fourth, sixth in quarters}
        return Ended(move, cause, available=tuple(sorted(available)))

    def _in_posture(self, solutions: Array, near: Array | None, posture: Posture) -> Array | None:
        """The solution in a posture that is nearest to a configuration, whole turns within the limits included."""
        if near is None or not len(solutions):
            return None
        every = np.concatenate([self._add_whole_turns(solution) for solution in solutions])
        fits = every[[_fits(solution, posture) for solution in every]]
        if not len(fits):
            return None
        away = np.linalg.norm((fits - near) / joint_scale(self.robot, self.task), axis=1)
        return np.asarray(fits[away.argmin()])

    def _add_whole_turns(self, q: Array) -> Array:
        """(k, n) a solution with all whole turns that the joint limits allow, at most one either way."""
        options = []
        for value, joint, low, high in zip(q, self.robot.variables, self.robot.lower, self.robot.upper, strict=True):
            turns = (0.0, -2 * pi, 2 * pi) if joint.unit == "rad" else (0.0,)
            options.append([value + turn for turn in turns if turn == 0.0 or low <= value + turn <= high])
        if np.prod([len(turns) for turns in options]) > _MOST_TURNS:
            return q[None]
        return np.array(list(product(*options)))


def _as_shares(branch: Followed, chords: int) -> Followed:
    """A branch along the chords of an arc with its places from 1 to 2, as those of a line."""
    return replace(branch, place=1.0 + (branch.place - 1.0) / chords, reached=1.0 + (branch.reached - 1.0) / chords)


def _fits(q: Array, posture: Posture) -> bool:
    """Whether a configuration has the signs of KRL's T, and the quarter turns of RAPID's cf1, cf4 and cf6."""
    if posture.signs is not None:
        for joint, value in enumerate(q[:6].tolist()):
            negative = bool(posture.signs >> joint & 1)
            if abs(value) > _AT_ZERO and (value < 0.0) != negative:
                return False
    if posture.quarters is not None and len(q) >= 6:
        for value, quarter in zip((q[0], q[3], q[5]), posture.quarters, strict=True):
            turns = float(value) / (pi / 2)
            if quarter not in (floor(turns - _AT_ZERO), floor(turns + _AT_ZERO)):
                return False
    return True
