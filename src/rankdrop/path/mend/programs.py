"""Remedies of a robot program, by its lines: they are computed on its literal targets and not written.

Where a straight line ends before its target, the internal turn after which it goes on, or a joint move where its
target is within reach in another posture. Where a line is too fast, the speed at which it keeps the limits. Where a
line crosses a singularity, the least local change of its part (`path.mend.local_remedies`): the joints moved aside,
or the tool led around. A joint move that crosses needs none.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from rankdrop.codec import record_of
from rankdrop.kinematics import pose
from rankdrop.local.rates import rate_limits
from rankdrop.path.check.first_pose import within_limits
from rankdrop.path.check.moves import EndCause
from rankdrop.path.check.passing import Turn
from rankdrop.path.check.program import ProgramCheck, ProgramPart
from rankdrop.path.check.record import FREE, PathCheck
from rankdrop.path.curve import Place
from rankdrop.path.mend.local_change import LocalChange
from rankdrop.path.mend.mend import mend_path
from rankdrop.path.mend.record import BUMP, DETOUR
from rankdrop.path.read.program_record import Move
from rankdrop.questions import RemedyOptions
from rankdrop.results.analysis import Analysis
from rankdrop.robot.model import Array, Robot

_SPARE = 1.0 - 1e-3  # of the speed that keeps the limits
_SINGULAR = ("singular", "few joints", "stuck", "limit")


class Advice(StrEnum):
    """What to do about a line."""

    TURN = "turn"
    JOINT_MOVE = "joint move"
    SLOWER = "slower"
    BUMP = "bump"
    DETOUR = "detour"
    UNREACHED = "out of reach"
    NONE = "none"


@dataclass(frozen=True, eq=False)
class LineRemedy:
    """A remedy of one line of a program.

    Attributes:
        move: of that line.
        advice: what to do.
        turn: the internal turn that is made before the line.
        factor: share of the programmed speed that keeps the joint limits, 0 … 1; nan for other remedies.
        change: of the part's joint path.
        span: shares of the line between which it is changed, 0 … 1.
        goal: (n,) configuration at the target of a joint move [rad, m].
        notes: why there is no remedy, as of a path.
    """

    move: Move
    advice: Advice
    turn: Turn | None = None
    factor: float = np.nan
    change: LocalChange | None = None
    span: tuple[float, float] = (0.0, 1.0)
    goal: Array | None = None
    notes: tuple[str, ...] = ()


def program_remedies(
    check: ProgramCheck, *, analysis: Analysis | None = None, options: RemedyOptions | None = None
) -> tuple[LineRemedy, ...]:
    """Remedies for the lines of a program that end, are too fast or cross a singularity with the tool on a line.

    Args:
        check: of the program.
        analysis: families, where `check` was made with an analysis.
        options: how far bumps and detours may go.
    """
    how = RemedyOptions() if options is None else options
    remedies: list[LineRemedy] = []
    for part in check.parts:
        if part.check is not None:
            crossed = list(_local_change(part, part.check, analysis, how))
            remedies += crossed
            moved = [remedy.move for remedy in crossed if remedy.advice in (Advice.BUMP, Advice.DETOUR)]
            remedies += [remedy for remedy in _slower(part, part.check) if remedy.move not in moved]
        if part.ended is not None:
            remedies += _ways_on(check, part)
    return tuple(remedies)


def remedies_to_dict(remedies: Sequence[LineRemedy], robot: Robot) -> list[dict[str, Any]]:
    """Remedies of a program's lines as the entry `remedies` of its JSON file: docs/json.md.

    Args:
        remedies: of `program_remedies`.
        robot: the arm that moves.
    """
    return [record_of("program_remedies", (remedy, robot)) for remedy in remedies]


def _ways_on(check: ProgramCheck, part: ProgramPart) -> Iterator[LineRemedy]:
    """What lets the arm go on where a line ends before its target."""
    ended = part.ended
    assert ended is not None
    branch = ended.branch
    if ended.cause is not EndCause.BRANCH or branch is None:
        return
    if branch.turn is not None:
        yield LineRemedy(ended.move, Advice.TURN, turn=branch.turn)
        return
    target = ended.move.target
    if target.joints is not None or branch.reason not in _SINGULAR:
        return
    goal = np.array(target.pose)
    goal[2, 3] += check.raised
    solutions = within_limits(check.robot, goal, check.task)
    if len(solutions):
        apart = np.abs(solutions - branch.last).max(axis=1)
        yield LineRemedy(ended.move, Advice.JOINT_MOVE, goal=solutions[int(apart.argmin())])
    else:
        yield LineRemedy(ended.move, Advice.UNREACHED)


def _slower(part: ProgramPart, check: PathCheck) -> Iterator[LineRemedy]:
    """Lines and joint moves that are too fast, with the share of their speed that keeps the limits."""
    rates = check.curve.rates
    if rates is None:
        return
    most = (rates / rate_limits(check.robot)).max(axis=1)
    for index, move in enumerate(part.moves):
        if part.ended is not None and part.ended.move is move:
            continue
        of_move = most[: len(part.owner)][part.owner == index]
        if len(of_move) and of_move.max() > 1.0 + 1e-9:
            yield LineRemedy(move, Advice.SLOWER, factor=_SPARE / float(of_move.max()))


def _local_change(
    part: ProgramPart, check: PathCheck, analysis: Analysis | None, how: RemedyOptions
) -> Iterator[LineRemedy]:
    """The least local change of a part that crosses singularities on its straight lines."""
    met = [stretch for stretch in check.stretches if stretch.verdict != FREE]
    lines = [stretch for stretch in met if part.moves[part.move_at(stretch.closest.place)].kind != "joint"]
    if check.clear or not lines:
        return
    mending = mend_path(check, analysis=analysis, kinds=(BUMP, DETOUR), options=how)
    best = mending.best
    if best is None:
        yield LineRemedy(part.moves[part.move_at(lines[0].closest.place)], Advice.NONE, notes=mending.notes)
        return
    advice = Advice.BUMP if best.kind == BUMP else Advice.DETOUR
    for change in best.changes:
        middle = change.start.position / 2 + change.end.position / 2
        index = part.move_at(check.curve.place(_spot(check, middle)))
        span = _share(part, check, index, change.start), _share(part, check, index, change.end)
        yield LineRemedy(part.moves[index], advice, change=change, span=span)


def _spot(check: PathCheck, position: float) -> tuple[int, float]:
    stretch, share = check.curve.split(np.array([position - 1.0]))
    return int(stretch[0]), float(share[0])


def _share(part: ProgramPart, check: PathCheck, index: int, place: Place) -> float:
    """Share of a move at which a place of the path is, by the way of the tip; 0 before it and 1 after it."""
    rows = np.flatnonzero(part.owner == index)
    first, last = int(rows[0]), int(rows[-1]) + 1
    position = float(np.clip(place.position - 1.0, first, last))
    at = np.unique(np.append(np.arange(first, last + 1), position))
    tips = pose(check.robot, check.curve.at(*check.curve.split(at)))[:, :3, 3]
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(tips, axis=0), axis=1))])
    if lengths[-1] <= 0.0:
        return (position - first) / (last - first)
    return float(np.interp(position, at, lengths) / lengths[-1])
