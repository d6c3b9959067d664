"""Robot programs checked, move by move: what was read of a program, on one joint path with the program's lines.

Between the targets that were read the arm does what its controller would do without blending: a joint move goes
straight in joint space, a linear move straight with its tip (`path.check.follow`), from the configuration in which the
move before it ended. Where a line that moves the arm was not read, or a move cannot be followed, a new part begins at
the next target. Every part is one curve, checked as any other path (`path.check.check.check_curve`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cached_property
from operator import attrgetter
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np

from rankdrop.codec import Result
from rankdrop.errors import OptionError
from rankdrop.lists import flat_map
from rankdrop.local.pointing import followed_task
from rankdrop.path.check.check import asked_for, check_curve
from rankdrop.path.check.moves import STILL, Ended, FollowedMoves, MoveFollower, with_tool_frame
from rankdrop.path.check.overrun import Overrun, overruns
from rankdrop.path.check.path_file import PathQuestion, check_file
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
from rankdrop.path.check.turns import FarTurn, far_turns
from rankdrop.path.curve import Curve, Index, Place, curve
from rankdrop.path.read.makers import shoulder_height
from rankdrop.path.read.program_file import read_program
from rankdrop.path.read.program_record import BREAKS, LASTING, Kind, Move, MoveAssumption, Program, Skipped, is_program
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.task import Task
from rankdrop.text import programs as text

_MOST_PARTS = 200
_WHOLE_POSE = 6  # rows of a task that asks for all of a pose


@dataclass(frozen=True, eq=False)
class MoveCheck:
    """One move of a program, checked.

    Attributes:
        line: of the program, from 1.
        text: of that line.
        kind: "joint", "line" or "arc".
        verdict: the worst of it; None where it is only where a part begins, so that nothing leads to it.
        distance: to the nearest singularity known [rad; slides by the length scale]; inf where none is known.
        family, name: of it.
        joint: number of the joint that turns most; 0 where none turns.
        turn: by how much [rad].
        seconds: how long it takes; None where its speed is not known.
        overruns: joints that exceed their rate limits in it.
        assumed: assumptions with which it is followed, its own and lasting ones of moves before it.
    """

    line: int
    text: str
    kind: Kind
    verdict: Verdict | None
    distance: float
    family: str
    name: str
    joint: int
    turn: float
    seconds: float | None
    overruns: tuple[Overrun, ...] = ()
    assumed: frozenset[MoveAssumption] = frozenset()


@dataclass(frozen=True, eq=False)
class ProgramPart:
    """A part of a program without a gap.

    Attributes:
        moves: in order; the first leads to where the part begins.
        check: its joint path, checked; None where its first target is out of reach.
        owner: of each stretch between two rows the index of its move.
        begins: how its first configuration is known: "joints", "start" (--start), "before" (nearest to where the part
            before it ended), "stated" (the posture that the target states), or "posture" (that which people use).
        ended: why it ends before its last move does; None where it does not.
        off, turned: the tip is proven to stay so near to its lines [m], [rad].
        passed: indices of moves that pass through a singularity.
        untimed: the first linear move whose speed is not known; None where there is none.
        own_assumptions: those of single moves, by their index.
        inherited: assumptions of the part before that hold at its beginning.
    """

    moves: tuple[Move, ...]
    check: PathCheck | None
    owner: Index
    begins: Literal["joints", "start", "before", "stated", "posture"]
    ended: Ended | None
    off: float
    turned: float
    passed: tuple[int, ...]
    untimed: Move | None
    own_assumptions: Mapping[int, Set[MoveAssumption]] = field(default_factory=dict)
    inherited: frozenset[MoveAssumption] = frozenset()

    @cached_property
    def assumed(self) -> tuple[frozenset[MoveAssumption], ...]:
        """Assumptions with which each move is followed: its own, and lasting ones of moves before it.

        A lasting one holds up to the next joint values: until then the arm may be elsewhere.
        """
        lasting = self.inherited
        assumed = []
        for index, move in enumerate(self.moves):
            own = self._own(index)
            if index == 0 and move.target.joints is not None:
                lasting = frozenset()
            assumed.append(own | lasting)
            lasting = _lasting_after(move, own, lasting)
        return tuple(assumed)

    @property
    def assumed_after(self) -> frozenset[MoveAssumption]:
        """Lasting assumptions with which the part ends."""
        lasting = self.inherited
        for index, move in enumerate(self.moves):
            lasting = _lasting_after(move, self._own(index), lasting)
        return lasting

    def _own(self, index: int) -> frozenset[MoveAssumption]:
        return frozenset(self.own_assumptions.get(index, ()))

    @property
    def verdicts(self) -> list[Verdict]:
        """Those of its moves; moves that are followed with an assumption are undecided."""
        if not any(self.assumed):
            return self._whole_verdicts()
        kinds = [UNDECIDED]
        kinds += [move.verdict for move in self.checked_moves() if move.verdict is not None and not move.assumed]
        if self.ended is not None and not self.assumed[self.moves.index(self.ended.move)]:
            kinds.append(NOT_FOLLOWED)
        return kinds

    def _whole_verdicts(self) -> list[Verdict]:
        kinds = []
        if self.check is not None:
            kinds.append(self.check.verdict)
        if self.ended is not None:
            kinds.append(NOT_FOLLOWED)
        if self.passed:
            kinds.append(TOUCHING)
        return kinds

    def move_at(self, place: Place) -> int:
        """Index of the move that a place of the path belongs to."""
        if self.check is None or not len(self.owner):
            return 0
        return int(self.owner[min(self.check.curve.spot(place)[0], len(self.owner) - 1)])

    def overruns(self, index: int) -> tuple[Overrun, ...]:
        """Joints that exceed their rate limits in a move."""
        first, last = self._rows(index)
        if self.check is None or first == last:
            return ()
        return overruns(self.check.robot, self.check.curve, first, last)

    def turns(self, index: int) -> tuple[FarTurn, ...]:
        """Joints that turn far within a short part of a move."""
        first, last = self._rows(index)
        if self.check is None or first == last:
            return ()
        curve, times = self.check.curve, self.check.curve.times
        if times is not None:
            times = times[first : last + 1]
        return far_turns(self.check.robot, replace(curve, control=curve.control[first:last], times=times, speeds=None))

    def _rows(self, index: int) -> tuple[int, int]:
        """Rows between which a move goes, from 0; twice the same for a move that has none."""
        first, last = np.searchsorted(self.owner, [index, index + 1]).tolist()
        return first, last

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
            assumed = self.assumed[index]
            if first < last:
                verdict = self._verdict(index, stretches.get(index, []), violations.get(index, []))
                distance, family = _nearest(check.profile, first, last, stretches.get(index, []))
                joint, turn = _largest_turn(check, first, last)
                seconds = None if times is None else float(times[last] - times[first])
                yield MoveCheck(move.line, move.text, move.kind, verdict, distance, family, names.get(family, ""),
                                joint, turn, seconds, self.overruns(index), assumed)  # fmt: skip
            elif index == 0 or self.ended is None:
                yield MoveCheck(move.line, move.text, move.kind, None, np.inf, "", "", 0, 0.0, None, (), assumed)

    def _verdict(self, index: int, stretches: Sequence[Stretch], violations: Sequence[Violation]) -> Verdict:
        """The worst of a move."""
        kinds = [FREE, *(stretch.verdict for stretch in stretches), *map(_broken, violations)]
        if self.overruns(index):
            kinds.append(TOO_FAST)
        if index in self.passed:
            kinds.append(TOUCHING)
        if self.ended is not None and self.ended.move is self.moves[index]:
            kinds.append(NOT_FOLLOWED)
        return min(kinds, key=VERDICTS.index)


def _lasting_after(
    move: Move, own: frozenset[MoveAssumption], lasting: frozenset[MoveAssumption]
) -> frozenset[MoveAssumption]:
    """Lasting assumptions after a move: joint values end those before it."""
    if move.kind == "joint" and move.target.joints is not None:
        lasting = frozenset()
    return lasting | (own & LASTING)


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
    if turns[joint] > STILL:
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
    kind: Kind
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
        tool: (4, 4) the tool of the program that was added to the arm [m]; None: none.
    """

    robot: Robot
    task: Task
    program: Program
    parts: tuple[ProgramPart, ...]
    raised: float
    interrupted: int = 0
    tool: Array | None = None
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
        kinds: list[Verdict] = [FREE, *flat_map(attrgetter("verdicts"), self.parts)]
        if self.unread or not self.complete:
            kinds += [UNDECIDED]
        return min(kinds, key=VERDICTS.index)

    @cached_property
    def assumptions(self) -> dict[MoveAssumption, tuple[int, ...]]:
        """Assumptions with which moves are followed, and the lines that bring them in."""
        lines: dict[MoveAssumption, list[int]] = {assumption: [] for assumption in MoveAssumption}
        for part in self.parts:
            for index, own in part.own_assumptions.items():
                for assumption in own:
                    lines[assumption].append(part.moves[index].line)
        return {assumption: tuple(found) for assumption, found in lines.items() if found}

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
        reached = []
        for part in self.parts:
            for crossing in () if part.check is None else part.check.crossings:
                move = part.moves[part.move_at(crossing.closest.place)]
                reached.append(Met(move.line, move.text, move.kind, crossing))
        return tuple(reached)

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
        robot: the arm; its base frame is the base frame of the program, its tip the flange. The tool that the program
            states for all its moves is added to it.
        program: from `read_program`.
        question: task, families and options; `start` decides the branch of a program that begins with a pose.
        progress: called with (stretches decided, stretches) of each part.

    Raises:
        TrajectoryError: joint values do not fit the arm, with the line.
        ConfigurationError: a target is tilted, and the arm never tilts its tool, with the line.
        OptionError, TaskError: as `check_path`.
    """
    tool = _stated_tool(program, question)
    robot = _with_tool(robot, tool)
    task = followed_task(robot, question.task)
    program = _with_what_is_given(program, question, task)
    if program.raised:
        raised = shoulder_height(robot)
    else:
        raised = 0.0
    follower = MoveFollower(robot, task, program, question, raised)
    parts: list[ProgramPart] = []
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
        followed = follower.follow_moves(moves, before, given=not parts and start is not None)
        if parts:
            inherited = parts[-1].assumed_after
        else:
            inherited = frozenset()
        part = _check_part(robot, question, followed, inherited, progress)
        parts.append(part)
        if followed.rows:
            before = followed.rows[-1]
        if part.ended is not None and (rest := moves[moves.index(part.ended.move) + 1 :]):
            waiting.append(rest)
        if part.check is not None and not part.check.complete:
            break
    return ProgramCheck(robot, asked_for(robot, question.task, question.analysis), program, tuple(parts), raised,
                        len(waiting), tool)  # fmt: skip


def _with_what_is_given(program: Program, question: PathQuestion, task: Task) -> Program:
    """A program without the assumptions that the question decides, on the tool and the first posture.

    Where there are several tools, and singularities of the task depend on where the tip is, one on the tool is added.
    """
    decided: set[MoveAssumption] = set()
    if question.at_tool_point:
        decided.add(MoveAssumption.TOOL)
    if question.start is not None:
        decided.add(MoveAssumption.CONFIGURATION)
    tip_counts = program.tool is None and len(task.rows) < _WHOLE_POSE
    items: list[Move | Skipped] = []
    for item in program.items:
        if isinstance(item, Move):
            tools = [MoveAssumption.TOOL] * (tip_counts and item.needs_tool)
            items.append(replace(item, assumed=item.assumed.union(tools) - decided))
        else:
            items.append(item)
    return replace(program, items=tuple(items))


def _stated_tool(program: Program, question: PathQuestion) -> Array | None:
    """(4, 4) the tool that is added to the arm; None: the program states none, or the arm has its tip there already."""
    if question.at_tool_point or program.tool is None or np.array_equal(program.tool, np.eye(4)):
        return None
    return program.tool


def _with_tool(robot: Robot, tool: Array | None) -> Robot:
    """The arm with a tool (4, 4) at its tip; as it is without one."""
    if tool is None:
        return robot
    return with_tool_frame(robot, tool)


def _check_part(
    robot: Robot, question: PathQuestion, followed: FollowedMoves, inherited: frozenset[MoveAssumption],
    progress: Callable[[int, int], None] | None,
) -> ProgramPart:
    """A part with its path checked; it begins with lasting assumptions of the part before."""
    check = None
    if followed.rows:
        q = np.array(followed.rows)
        path = curve(q, None)
        if followed.untimed is None and len(q) > 1:
            times = np.concatenate([[0.0], np.cumsum(followed.lasts)])
            path = Curve(np.stack([q[:-1], q[1:]], axis=1), times, np.array(followed.speeds))
        task = asked_for(robot, question.task, question.analysis)
        check = check_curve(robot, path, task, question.options, question.analysis, progress=progress)
        check = replace(check, rows=len(q))
    return ProgramPart(
        tuple(followed.moves), check, np.array(followed.owner, dtype=np.int64), followed.begins, followed.ended,
        followed.off, followed.turned, tuple(followed.passed), followed.untimed,
        followed.assumptions, inherited,
    )  # fmt: skip


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
