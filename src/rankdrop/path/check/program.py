"""Robot programs checked, move by move: what was read of a program, on one joint path with the program's lines.

Between the targets that were read the arm does what its controller would do without blending: a joint move goes
straight in joint space, a linear move straight with its tip (`path.check.follow`), from the configuration in which the
move before it ended. Where a line that moves the arm was not read, or a move cannot be followed, a new part begins at
the next target. Every part is one curve, checked as any other path (`path.check.check.check_curve`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from itertools import product
from math import floor, pi
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np

from rankdrop.codec import Result
from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.kinematics import pose
from rankdrop.local.block import joint_scale
from rankdrop.local.orientation import rotation_vector
from rankdrop.local.pointing import followed_task
from rankdrop.path.check.check import (
    PathQuestion,
    asked_for,
    check_curve,
    check_file,
    check_tilt,
    configuration_at,
    followed_branch,
    timed_branch,
    tip_apart,
    within_limits,
)
from rankdrop.path.check.follow import Followed, follow
from rankdrop.path.check.record import (
    FREE,
    NOT_FOLLOWED,
    OUTSIDE,
    TOO_FAST,
    TOUCHING,
    UNDECIDED,
    VERDICTS,
    PathCheck,
    Profile,
    Stretch,
    Verdict,
    Violation,
)
from rankdrop.path.check.tool_line import poses_at
from rankdrop.path.curve import Curve, Index, Place, curve
from rankdrop.path.read.program_file import read_program
from rankdrop.path.read.program_record import BREAKS, Move, Posture, Program, Skipped, is_program
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.poses.inverse import Aim
from rankdrop.robot.files import MOST_ROWS
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.task import Task
from rankdrop.text import programs as text
from rankdrop.units import counted_length

_STILL = 1e-12  # a move that is shorter does nothing [m, rad]
_SLOWER = 1.0 + 1e-9  # a joint move at the limits of its rates stays below them by rounding
_ON_AXIS = 1e-6  # of directions of axes that count as parallel
_AT_ZERO = 1e-6  # a joint so near to a quarter turn has either sign [rad]
_MOST_PARTS = 200
_MOST_TURNS = 4096  # combinations of whole turns of one solution


class Cause(StrEnum):
    """Why a move could not be followed."""

    UNREACHED = "out of reach"
    POSTURE = "no such posture"
    BRANCH = "branch ends"


@dataclass(frozen=True, eq=False)
class Ended:
    """A move that could not be followed to its end.

    Attributes:
        move: the move.
        cause: why.
        branch: how far the tip was followed on its line: place 1 is its beginning, 2 its end; None for other causes.
    """

    move: Move
    cause: Cause
    branch: Followed | None = None


@dataclass(frozen=True, eq=False)
class MoveCheck:
    """One move of a program, checked.

    Attributes:
        line: of the program, from 1.
        text: of that line.
        kind: "joint" or "line".
        verdict: the worst of it; None where it is only where a part begins, so that nothing leads to it.
        distance: to the nearest singularity known [rad; slides by the length scale]; inf where none is known.
        family, name: of it.
        joint: number of the joint that turns most; 0 where none turns.
        turn: by how much [rad].
        seconds: how long it takes; None where its speed is not known.
    """

    line: int
    text: str
    kind: Literal["joint", "line"]
    verdict: Verdict | None
    distance: float
    family: str
    name: str
    joint: int
    turn: float
    seconds: float | None


@dataclass(frozen=True, eq=False)
class Part:
    """A part of a program without a gap.

    Attributes:
        moves: in order; the first leads to where the part begins.
        check: its joint path, checked; None where its first target is out of reach.
        owner: of each stretch between two rows the index of its move.
        begins: how its first configuration is known: "joints", "start" (--start), "before" (nearest to where the part
            before it ended), or "posture" (that which people use).
        ended: why it ends before its last move does; None where it does not.
        off, turned: the tip is proven to stay so near to its lines [m], [rad].
        passed: indices of moves that pass through a singularity.
        untimed: the first linear move whose speed is not known; None where there is none.
    """

    moves: tuple[Move, ...]
    check: PathCheck | None
    owner: Index
    begins: Literal["joints", "start", "before", "posture"]
    ended: Ended | None
    off: float
    turned: float
    passed: tuple[int, ...]
    untimed: Move | None

    def move_at(self, place: Place) -> int:
        """Index of the move that a place of the path belongs to."""
        if self.check is None or not len(self.owner):
            return 0
        return int(self.owner[min(self.check.curve.spot(place)[0], len(self.owner) - 1)])

    def checked_moves(self) -> Iterator[MoveCheck]:
        """Every move, checked; those that follow the end are left out."""
        if self.check is None:
            return
        check, times = self.check, self.check.curve.times
        stretches: dict[int, list[Stretch]] = {}
        for stretch in check.stretches:
            stretches.setdefault(self.move_at(stretch.closest.place), []).append(stretch)
        violations: dict[int, list[Violation]] = {}
        for violation in check.violations:
            violations.setdefault(self.move_at(violation.place), []).append(violation)
        names = {stretch.family: stretch.name for stretch in check.stretches}
        begins = np.searchsorted(self.owner, np.arange(len(self.moves) + 1)).tolist()
        for index, move in enumerate(self.moves):
            first, last = begins[index : index + 2]
            if first < last:
                verdict = self._verdict(index, stretches.get(index, []), violations.get(index, []))
                distance, family = _nearest(check.profile, first, last, stretches.get(index, []))
                joint, turn = _largest_turn(check, first, last)
                seconds = None if times is None else float(times[last] - times[first])
                yield MoveCheck(move.line, move.text, move.kind, verdict, distance, family, names.get(family, ""),
                                joint, turn, seconds)  # fmt: skip
            elif index == 0 or self.ended is None:
                yield MoveCheck(move.line, move.text, move.kind, None, np.inf, "", "", 0, 0.0, None)

    def _verdict(self, index: int, stretches: Sequence[Stretch], violations: Sequence[Violation]) -> Verdict:
        """The worst of a move."""
        kinds = [FREE, *(stretch.verdict for stretch in stretches), *map(_broken, violations)]
        if index in self.passed:
            kinds.append(TOUCHING)
        if self.ended is not None and self.ended.move is self.moves[index]:
            kinds.append(NOT_FOLLOWED)
        return min(kinds, key=VERDICTS.index)


def _nearest(profile: Profile, first: int, last: int, stretches: Sequence[Stretch]) -> tuple[float, str]:
    """(distance, family) of a move from one row to another where it is nearest to a singularity.

    The distance is inf where no singularity is known; the family is "" where it is not known.
    """
    distance, family = np.inf, ""
    low = int(np.searchsorted(profile.position, first + 1, "left"))
    high = int(np.searchsorted(profile.position, last + 1, "right"))
    known = low + np.flatnonzero(np.isfinite(profile.distance[low:high]))
    if len(known):
        nearest = int(known[profile.distance[known].argmin()])
        distance = float(profile.distance[nearest])
        if profile.family[nearest] >= 0:
            family = profile.ids[profile.family[nearest]]
    for stretch in stretches:
        if stretch.closest.distance < distance:
            distance, family = stretch.closest.distance, stretch.family
    return distance, family


def _largest_turn(check: PathCheck, first: int, last: int) -> tuple[int, float]:
    """(number of the joint that turns most between two rows, 0 where none turns; by how much [rad])."""
    turning = np.array([joint.unit == "rad" for joint in check.robot.variables])
    control = check.curve.control[first:last]
    rows = np.concatenate([control[:, 0], control[-1:, -1]])
    turns = np.where(turning, np.ptp(rows, axis=0), 0.0)
    joint = int(turns.argmax())
    if turns[joint] > _STILL:
        return joint + 1, float(turns[joint])
    return 0, float(turns[joint])


def _broken(violation: Violation) -> Verdict:
    if not violation.proven:
        return UNDECIDED
    if violation.what == "rate":
        return TOO_FAST
    return OUTSIDE


@dataclass(frozen=True, eq=False)
class Met:
    """A singularity that a program reaches: the line, its kind of move, and the stretch of its part."""

    line: int
    text: str
    kind: Literal["joint", "line"]
    stretch: Stretch


@dataclass(frozen=True, eq=False)
class ProgramCheck(Result):
    """A checked robot program.

    Attributes:
        robot, task: the arm and its task.
        program: what was read.
        parts: parts without a gap, in order.
        raised: height of the program's base frame above that of the arm [m].
        interrupted: parts that were not reached before an interruption.
    """

    robot: Robot
    task: Task
    program: Program
    parts: tuple[Part, ...]
    raised: float
    interrupted: int = 0
    FILE: ClassVar[str] = "program"

    @property
    def checks(self) -> tuple[PathCheck, ...]:
        """Of the parts that have a path."""
        return tuple(part.check for part in self.parts if part.check is not None)

    @property
    def unread(self) -> tuple[Skipped, ...]:
        """Lines that move the arm and were not read."""
        return tuple(skipped for skipped in self.program.skipped if skipped.moves)

    @property
    def verdict(self) -> Verdict:
        """The worst of all parts; undecided where moves were not read and all others are free."""
        kinds = [check.verdict for check in self.checks] + [FREE]
        kinds += [NOT_FOLLOWED for part in self.parts if part.ended is not None]
        kinds += [TOUCHING for part in self.parts if part.passed]
        if self.unread or not self.complete:
            kinds += [UNDECIDED]
        return min(kinds, key=VERDICTS.index)

    @property
    def complete(self) -> bool:
        """False where it was interrupted."""
        return not self.interrupted and all(check.complete for check in self.checks)

    @property
    def holds(self) -> bool:
        """Every move of the program was read, and is proven free and within its limits."""
        return self.verdict == FREE and self.complete

    @property
    def rows(self) -> int | None:
        """Rows of the joint path of all parts; None where there is none."""
        return sum(check.rows for check in self.checks) or None

    @property
    def free_share(self) -> float:
        """Of the part of which least is proven free."""
        return min((check.free_share for check in self.checks), default=0.0)

    @property
    def stretches(self) -> tuple[Stretch, ...]:
        """Of all parts, worst first."""
        every = [stretch for check in self.checks for stretch in check.stretches]
        return tuple(sorted(every, key=lambda stretch: (VERDICTS.index(stretch.verdict), stretch.closest.distance)))

    @property
    def met(self) -> tuple[Met, ...]:
        """Singularities on the way, in the order of the program."""
        found = []
        for part in self.parts:
            for crossing in () if part.check is None else part.check.crossings:
                move = part.moves[part.move_at(crossing.closest.place)]
                found.append(Met(move.line, move.text, move.kind, crossing))
        return tuple(found)

    @cached_property
    def moves(self) -> tuple[MoveCheck, ...]:
        """Every move that was read and reached."""
        return tuple(move for part in self.parts for move in part.checked_moves())

    @property
    def sentence(self) -> str:
        """The verdict for people, with lines of the program."""
        return text.sentence(self)

    @property
    def summary(self) -> tuple[str, ...]:
        """The lines that are printed first."""
        return text.summary(self)

    def sections(self, *, full: bool = False, remedies: Sequence[Any] = ()) -> tuple[Section, ...]:
        """As sections of text; `full`: every move, and every line that was not read; `remedies` of its lines."""
        return text.sections(self, full=full, remedies=remedies)


def check_any_file(
    robot: Robot,
    file: Path,
    question: PathQuestion,
    *,
    say: Callable[[str], None] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> PathCheck | ProgramCheck:
    """Check one file: a robot program by its ending, else joint values or poses of the tip (`check_file`).

    Raises:
        RankdropError: the file cannot be read, with the place in it, or an option does not fit it.
    """
    if not is_program(file):
        return check_file(robot, file, question, say=say, progress=progress)
    if question.topic is not None:
        raise OptionError("only a bag has topics", where=str(file), got=question.topic)
    if question.options.interpolate != "linear":
        raise OptionError("the moves of a program are its own", where="interpolate", got=question.options.interpolate,
                          allowed="linear")  # fmt: skip
    return check_program(robot, read_program(file), question, progress=progress)


def check_program(
    robot: Robot, program: Program, question: PathQuestion, *, progress: Callable[[int, int], None] | None = None
) -> ProgramCheck:
    """Check what was read of a program.

    Args:
        robot: the arm; its base frame is the base frame of the program, its tip the tool.
        program: from `read_program`.
        question: task, families and options; `start` decides the branch of a program that begins with a pose.
        progress: called with (stretches decided, stretches) of each part.

    Raises:
        TrajectoryError: joint values do not fit the arm, with the line.
        ConfigurationError: a target is tilted, and the arm never tilts its tool, with the line.
        OptionError, TaskError: as `check_path`.
    """
    task = followed_task(robot, question.task)
    if program.raised:
        raised = _shoulder_height(robot)
    else:
        raised = 0.0
    walker = _Walker(robot, task, program, question, raised)
    parts: list[Part] = []
    runs = _runs(program)
    start = _start(question, runs)
    waiting, before = runs[::-1], start
    while waiting:
        moves = waiting.pop()
        if len(parts) == _MOST_PARTS:
            raise TrajectoryError(
                "the program has too many parts without a way from one to the next",
                where=f"{program.name}, line {moves[0].line}", allowed=f"at most {_MOST_PARTS}",
                mend="write targets as numbers, or check parts of the program for themselves",
            )  # fmt: skip
        walked = walker.walk(moves, before, given=not parts and start is not None)
        part = walker.check_part(walked, progress)
        parts.append(part)
        if walked.rows:
            before = walked.rows[-1]
        if part.ended is not None and (rest := moves[moves.index(part.ended.move) + 1 :]):
            waiting.append(rest)
        if part.check is not None and not part.check.complete:
            break
    return ProgramCheck(robot, asked_for(robot, question.task, question.analysis), program, tuple(parts), raised,
                        len(waiting))  # fmt: skip


def _start(question: PathQuestion, runs: Sequence[Sequence[Move]]) -> Array | None:
    """The start that decides the branch of a program that begins with a pose; None where there is none.

    Raises:
        OptionError: the first move has joint values.
    """
    if question.start is None:
        return None
    if runs[0][0].target.joints is not None:
        raise OptionError("a start is for programs that begin with a pose, this one begins with joint values",
                          where="start", got=", ".join(f"{x:.6g}" for x in question.start))  # fmt: skip
    return np.array(question.start)


def _runs(program: Program) -> list[list[Move]]:
    """Moves between lines that were not read and after which the arm may be anywhere."""
    runs: list[list[Move]] = [[]]
    for item in program.items:
        if isinstance(item, Move):
            runs[-1].append(item)
        elif item.reason in BREAKS and runs[-1]:
            runs.append([])
    return [run for run in runs if run]


def _shoulder_height(robot: Robot) -> float:
    """Height of axis 2 above the base [m], where axis 1 is the vertical axis of the base and axis 2 is horizontal."""
    if len(robot.joints) < 2:
        return 0.0
    first, second = robot.joints[:2]
    upright = abs(first.axis[2]) > 1.0 - _ON_AXIS and float(np.hypot(*first.foot[:2])) <= _ON_AXIS
    if upright and abs(second.axis[2]) <= _ON_AXIS:
        return float(second.foot[2])
    return 0.0


@dataclass(eq=False)
class _Walked:
    """Rows of a part while it is built."""

    moves: list[Move]
    begins: Literal["joints", "start", "before", "posture"] = "joints"
    rows: list[Array] = field(default_factory=list)
    owner: list[int] = field(default_factory=list)
    lasts: list[float] = field(default_factory=list)
    speeds: list[Array] = field(default_factory=list)
    untimed: Move | None = None
    ended: Ended | None = None
    off: float = 0.0
    turned: float = 0.0
    passed: list[int] = field(default_factory=list)

    def add(self, index: int, rows: Array, lasts: Array | None, speeds: Array | None) -> None:
        """Rows after the last one, with the time and the joint rates of each stretch."""
        self.rows.extend(rows)
        self.owner.extend([index] * len(rows))
        if lasts is None or speeds is None:
            self.untimed = self.untimed or self.moves[index]
        else:
            self.lasts.extend(lasts.tolist())
            self.speeds.extend(speeds)


class _Walker:
    """Moves made one after the other."""

    def __init__(self, robot: Robot, task: Task, program: Program, question: PathQuestion, raised: float) -> None:
        self.robot, self.task, self.program, self.question, self.raised = robot, task, program, question, raised
        how = question.options
        self.tolerance = how.tip_tolerance * counted_length(robot), how.turn_tolerance
        self.rates = np.array([joint.velocity for joint in robot.variables], dtype=np.float64)
        self.solved: dict[bytes, Array] = {}

    def walk(self, moves: list[Move], before: Array | None, *, given: bool) -> _Walked:
        """Rows of a run of moves, up to the first that cannot be followed."""
        walked = _Walked(moves)
        for index, move in enumerate(moves):
            if not walked.rows:
                self._begin(walked, move, before, given=given)
            elif move.kind == "joint":
                self._joint_move(walked, index, move)
            else:
                self._line(walked, index, move)
            if walked.ended is not None:
                break
            if len(walked.rows) > MOST_ROWS:
                raise TrajectoryError(
                    "the moves up to this line need too many rows", where=f"{self.program.name}, line {move.line}",
                    allowed=f"at most {MOST_ROWS:,}", mend="check parts of the program for themselves",
                )  # fmt: skip
        return walked

    def _begin(self, walked: _Walked, move: Move, before: Array | None, *, given: bool) -> None:
        """The first configuration of a part."""
        if move.target.joints is not None:
            walked.rows.append(self._joints(move))
            return
        first = self._at_first_pose(move, before)
        if isinstance(first, Cause):
            walked.ended = Ended(move, first)
            return
        walked.rows.append(first)
        if before is None:
            walked.begins = "posture"
        elif given:
            walked.begins = "start"
        else:
            walked.begins = "before"

    def _at_first_pose(self, move: Move, before: Array | None) -> Array | Cause:
        """A configuration at the pose of a move: in the posture it names, else near to the one before; or why none."""
        goal, posture = self._pose(move), move.target.posture
        if before is not None and posture == Posture():
            try:
                return configuration_at(self.robot, goal, self.task, before)[0]
            except ConfigurationError:
                return Cause.UNREACHED
        solutions = self._solutions(goal)
        if before is None and len(solutions):
            near = solutions[0]
        else:
            near = before
        chosen = self._in_posture(solutions, near, posture)
        if chosen is not None:
            return chosen
        if len(solutions):
            return Cause.POSTURE
        return Cause.UNREACHED

    def _joint_move(self, walked: _Walked, index: int, move: Move) -> None:
        """Straight in joint space, to joint values or to a solution of a pose."""
        now = walked.rows[-1]
        if move.target.joints is not None:
            end = self._joints(move)
        else:
            goal = self._pose(move)
            if self.robot.n > self.task.m:
                reached = follow(self.robot, goal[None], now, self.task)
                if reached.complete:
                    solutions = reached.q
                else:
                    solutions = self._solutions(goal)
            else:
                solutions = self._solutions(goal)
            chosen = self._in_posture(solutions, now, move.target.posture)
            if chosen is None:
                walked.ended = Ended(move, Cause.POSTURE if len(solutions) else Cause.UNREACHED)
                return
            end = chosen
        step = np.abs(end - now)
        if step.max(initial=0.0) <= _STILL:
            return
        lasts = self._seconds(move, step)
        walked.add(index, end[None], np.array([lasts]), step[None] / lasts)

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

    def _line(self, walked: _Walked, index: int, move: Move) -> None:
        """Straight with the tip, followed on the branch of the last row."""
        now = walked.rows[-1]
        begin = pose(self.robot, now)
        if move.target.joints is None:
            end = self._pose(move)
        else:
            end = pose(self.robot, self._joints(move))
        way = np.stack([begin, end])
        length = float(np.linalg.norm(end[:3, 3] - begin[:3, 3]))
        turn = float(np.linalg.norm(rotation_vector((end[:3, :3] @ begin[:3, :3].T)[None])[0]))
        if max(length, turn) <= _STILL:
            return
        branch = followed_branch(self.robot, way, now, self.task, self.tolerance, free=False)
        times = self._line_seconds(move, length, turn)
        line_path = timed_branch(self.robot, self.task, way, None if times is None else np.array([0.0, times]), branch)
        if len(branch.q):
            off, turned = tip_apart(Aim(self.robot, self.task), branch.q, poses_at(way, branch.place - 1.0))
            walked.off, walked.turned = max(walked.off, off), max(walked.turned, turned)
            jump = np.abs(branch.q[0] - now).max(initial=0.0) > _STILL
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
                walked.add(index, rows, lasts, speeds)
        if branch.passed:
            walked.passed.append(index)
        if not branch.complete:
            walked.ended = Ended(move, Cause.BRANCH, branch)

    def _line_seconds(self, move: Move, length: float, turn: float) -> float | None:
        """How long a linear move takes; None where the program does not say.

        The tip keeps its speed and the tool its rate of turning; the slower of the two decides. Where only one is
        stated it decides, as long as there is a way for it.
        """
        speed = move.speed
        if speed.time is not None:
            return speed.time
        if speed.linear is None or length <= _STILL:
            by_length = None
        else:
            by_length = length / speed.linear
        if speed.angular is None or turn <= _STILL:
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
        given, where = move.target.joints or (), f"{self.program.name}, line {move.line}"
        n = self.robot.n
        if len(given) < n or any(given[n:]):
            raise TrajectoryError("the target has another number of joints than the arm", where=where, got=len(given),
                                  allowed=f"{n} of {self.robot.name}")  # fmt: skip
        values = np.array(given[:n])
        if self.program.degrees:
            values *= [np.pi / 180.0 if joint.unit == "rad" else 1e-3 for joint in self.robot.variables]
        if self.program.level and n >= 3:
            if not self._axes_2_and_3_opposed():
                raise TrajectoryError(
                    "J3 is counted from the horizontal, and axes 2 and 3 of this arm do not point against each other",
                    where=where, mend="give the targets as poses",
                )  # fmt: skip
            values[2] += values[1]
        return values

    def _axes_2_and_3_opposed(self) -> bool:
        """Axes 2 and 3 point against each other, and no joint is a mimic."""
        robot = self.robot
        if len(robot.joints) != robot.n:
            return False
        return float(np.dot(robot.joints[1].axis, robot.joints[2].axis)) <= -1.0 + _ON_AXIS

    def _pose(self, move: Move) -> Array:
        """(4, 4) of a target in the base frame of the arm."""
        goal = np.array(move.target.pose)
        goal[2, 3] += self.raised
        check_tilt(self.robot, self.task, goal[None], f"{self.program.name}, line {move.line}")
        return goal

    def _solutions(self, goal: Array) -> Array:
        """(S, n) solutions of a pose within the joint limits, those first that people use."""
        key = goal.tobytes()
        if key not in self.solved:
            self.solved[key] = within_limits(self.robot, goal, self.task)
        return self.solved[key]

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

    def check_part(self, walked: _Walked, progress: Callable[[int, int], None] | None) -> Part:
        """A part with its path checked."""
        question = self.question
        check = None
        if walked.rows:
            q = np.array(walked.rows)
            path = curve(q, None)
            if walked.untimed is None and len(q) > 1:
                times = np.concatenate([[0.0], np.cumsum(walked.lasts)])
                path = Curve(np.stack([q[:-1], q[1:]], axis=1), times, np.array(walked.speeds))
            asked = asked_for(self.robot, question.task, question.analysis)
            check = check_curve(self.robot, path, asked, question.options, question.analysis, progress=progress)
            check = replace(check, rows=len(q))
        return Part(
            tuple(walked.moves), check, np.array(walked.owner, dtype=np.int64), walked.begins, walked.ended,
            walked.off, walked.turned, tuple(walked.passed), walked.untimed,
        )  # fmt: skip


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
