"""A mended path of a file of poses, as poses again: rows that the remedy leaves alone are those of the file.

A remedy is a joint path. Its rows that reach poses of the file, in the order of the file, are rows of the file. Between
two of them the rows on the straight move, at the time that the move would have anyway, are left out. All others are new
poses. Changed parts are then followed as any file of poses is, and proven: the tip goes straight between the new poses,
at its own joint rates. A move that is too fast gets as much more time as its rate asks for. Where the branch that is
followed is not the remedy's at the end of a changed part, or it is not proven free, the remedy has no poses.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from rankdrop.kinematics import pose
from rankdrop.local.orientation import rotation_vector
from rankdrop.local.rates import rate_limits
from rankdrop.path.check.check import check_curve
from rankdrop.path.check.record import GivenPoses, PathCheck
from rankdrop.path.check.tool_branch import Followed
from rankdrop.path.check.tool_line import poses_at
from rankdrop.path.check.tool_path import followed_branch, proof_of, timed_branch, tip_tolerance
from rankdrop.path.curve import Curve, Index
from rankdrop.path.mend.record import Remedy
from rankdrop.path.mend.retime import usage
from rankdrop.poses.inverse import Aim
from rankdrop.problem import Mask
from rankdrop.results.analysis import Analysis
from rankdrop.robot.model import Array

_SAME = 1e-8  # of a pose of the file, lengths divided by the length scale: Newton's method arrives within 1e-11
_SHORTEST, _MOST = 16, 16_384  # poses that are compared at once
_EVERY = 64  # after so many new rows not every row is looked for
_INSTANT = 1e-9  # times nearer to each other are one [s]
_PADDED = 2  # rows before and after a changed part that are followed with it
_ON_BRANCH = 1e-6  # of a configuration from the remedy's at the end of a changed part [rad; slides scaled]
_ROUNDS = 6  # of giving moves more time
_SPARE = 1.0 + 1e-6  # of rates: times are rounded
_REDUNDANT_SPARE = 1.0 + 1e-4  # of a redundant arm: from a start of nine digits its joints go a little elsewhere
_SHORT = 1e-9  # a move that is shorter has no direction [rad; lengths divided by the length scale]


class NoPoses(StrEnum):
    """Why a remedy is not written as poses."""

    SAME = "same"
    UNPROVEN = "unproven"


@dataclass(frozen=True, eq=False)
class MendedPoses:
    """The poses of a file with a remedy put in.

    Attributes:
        matrices: (K, 4, 4) of the tip [m].
        times: (K,) [s]; None where the file has none.
        given: (K,) which pose of the file each is, counted from 0; −1: a new one.
        start: (n,) configuration at the first pose [rad, m].
        moved: the first pose is a new one.
    """

    matrices: Array
    times: Array | None
    given: Index
    start: Array
    moved: bool


def mended_poses(
    check: PathCheck, remedy: Remedy, *, analysis: Analysis | None = None, acceleration: float | None = None
) -> MendedPoses | NoPoses:
    """A remedy of a file of poses as poses, followed and proven where they are changed.

    Args:
        check: of the poses, which has a remedy.
        remedy: that is free.
        analysis: families, where `check` was made with an analysis.
        acceleration: limit of joint accelerations that the remedy keeps [rad/s², m/s²]; None: none.

    Returns:
        The poses; or why there are none: the joints move in another way along the same poses (`SAME`), or the poses
        are not proven free, or not on the branch of the remedy (`UNPROVEN`).
    """
    given = check.poses
    assert given is not None
    writer = _Writer(check, given, remedy, analysis, acceleration)
    rows = writer.rows()
    changed = rows.changed_moves(given)
    if not changed.any():
        return NoPoses.SAME
    times = writer.proven_times(rows, changed)
    if isinstance(times, NoPoses):
        return times
    return MendedPoses(rows.matrices, times, rows.given, rows.q[0], bool(rows.given[0] != 0))


@dataclass(frozen=True, eq=False)
class _PoseRows:
    """Rows to be written: (K, 4, 4) poses, (K,) times, (K,) poses of the file, (K, n) configurations of the remedy."""

    matrices: Array
    times: Array | None
    given: Index
    q: Array

    def changed_moves(self, poses: GivenPoses) -> Mask:
        """(K − 1,) moves that are not moves of the file as they were."""
        begin, end = self.given[:-1], self.given[1:]
        same = (begin >= 0) & (end == begin + 1)
        if self.times is not None and poses.times is not None:
            longer = np.diff(self.times) - (poses.times[end] - poses.times[begin])
            same &= np.abs(longer) <= _INSTANT
        return np.asarray(~same)


@dataclass(eq=False)
class _Writer:
    check: PathCheck
    poses: GivenPoses
    remedy: Remedy
    analysis: Analysis | None
    acceleration: float | None

    def __post_init__(self) -> None:
        self.robot, self.task = self.check.robot, self.poses.task
        self.aim = Aim(self.robot, self.task)

    def rows(self) -> _PoseRows:
        """The rows of the file to be written."""
        made = self.remedy.trajectory
        now = pose(self.robot, made.q)
        given = self._match_poses(now)
        times = made.times if self.poses.times is not None else None
        kept, now = self._needed_rows(now, given, times)
        of_file = given >= 0
        now[of_file] = self.poses.matrices[given[of_file]]
        return _PoseRows(now[kept], None if times is None else times[kept], given[kept], made.q[kept])

    def _match_poses(self, now: Array) -> Index:
        """(K,) which pose of the file each of the rows (K, 4, 4) is, increasing; −1: none.

        After s new rows the next row of the file is looked for among s poses and some more, as a part that is changed
        has at least as many rows as poses that it leaves out.
        """
        poses, count = self.poses.matrices, len(self.poses.matrices)
        given = np.full(len(now), -1, dtype=np.int64)
        row = after = stuck = 0
        length = _SHORTEST
        while row < len(now) and after < count:
            length = min(length, len(now) - row, count - after)
            same = self._same(poses[after : after + length], now[row : row + length])
            run = length if same.all() else int(same.argmin())
            given[row : row + run] = np.arange(after, after + run)
            row, after = row + run, after + run
            length = 2 * length if run == length else _SHORTEST
            if run > 0:
                stuck = 0
                continue
            places = None
            if stuck < _EVERY or stuck % (stuck // _EVERY) == 0:
                ahead = poses[after : after + min(_MOST, 4 * stuck + _SHORTEST)]
                places = np.flatnonzero(self._same(ahead, now[row : row + 1]))
            if places is None or not len(places):
                row, stuck = row + 1, stuck + 1
                continue
            row, after = self._first_of_run(now, row, after + int(places[0]), stuck, after)
            stuck = 0
        return given

    def _first_of_run(self, now: Array, row: int, pose_there: int, stuck: int, least: int) -> tuple[int, int]:
        """The first row, and its pose, of a run of poses of the file that goes on through a row; none before `least`.
        """
        for _ in range(stuck):
            before = pose_there - 1
            if before < least or not self._same(self.poses.matrices[before][None], now[row - 1 : row])[0]:
                break
            row, pose_there = row - 1, before
        return row, pose_there

    def _same(self, poses: Array, now: Array) -> Mask:
        """(N,) which of poses (N, 4, 4) others are, as far as the task asks."""
        away, chord = self.aim.missing_between(poses, now)
        return np.asarray(np.maximum(away / self.aim.length, chord) <= _SAME)

    def _needed_rows(self, now: Array, given: Index, times: Array | None) -> tuple[Mask, Array]:
        """(K,) rows that are needed, and the poses, those within a move of the file exactly on it."""
        needed = given >= 0
        needed[[0, -1]] = True
        of_file = np.flatnonzero(given >= 0)
        out = now.copy()
        edges = np.concatenate([[-1], of_file, [len(given)]])
        for low, high in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
            if high - low <= 1:
                continue
            inside = np.arange(low + 1, high)
            one_move = low >= 0 and high < len(given) and given[high] == given[low] + 1
            if not one_move:
                needed[inside] = True
                continue
            begin, end = self.poses.matrices[given[low]], self.poses.matrices[given[high]]
            share = self._share(begin, end, now[inside])
            on_move = poses_at(np.stack([begin, end]), share)
            if not self._within_tolerance(on_move, now[inside]):
                needed[inside] = True
                continue
            out[inside] = on_move
            if times is not None:
                usual = times[low] + share * (times[high] - times[low])
                needed[inside] = np.abs(times[inside] - usual).max() > _INSTANT + 1e-3 * (times[high] - times[low])
        return needed, out

    def _share(self, begin: Array, end: Array, now: Array) -> Array:
        """(N,) shares of a straight move at which poses (N, 4, 4) are nearest to it, in order."""
        move = (end[:3, 3] - begin[:3, 3]) / self.aim.length
        turn = rotation_vector(end[:3, :3] @ begin[:3, :3].T)
        size = float(move @ move + turn @ turn)
        if size <= _SHORT**2:
            return np.linspace(0.0, 1.0, len(now) + 2)[1:-1]
        moved = (now[:, :3, 3] - begin[:3, 3]) / self.aim.length
        turned = rotation_vector(now[:, :3, :3] @ begin[:3, :3].T)
        return np.maximum.accumulate(np.clip((moved @ move + turned @ turn) / size, 0.0, 1.0))

    def _within_tolerance(self, one: Array, other: Array) -> bool:
        """Whether all poses (N, 4, 4) are within the tolerance of a tool path of others."""
        away, turned = tip_tolerance(self.check.options, self.robot)
        far = np.linalg.norm(one[:, :3, 3] - other[:, :3, 3], axis=1).max()
        turn = np.linalg.norm(rotation_vector(one[:, :3, :3] @ other[:, :3, :3].swapaxes(1, 2)), axis=1).max()
        return bool(far <= away and turn <= turned)

    def proven_times(self, rows: _PoseRows, changed: Mask) -> Array | NoPoses | None:
        """(K,) times at which all changed parts are proven free and within the limits."""
        times = rows.times
        for low, high in self._parts(changed):
            made = self._proven_part(replace(rows, times=times), low, high)
            if isinstance(made, NoPoses):
                return made
            if times is not None and made is not None:
                later = made[-1] - times[high]
                times = np.concatenate([times[:low], made, times[high + 1 :] + later])
        return times

    def _parts(self, changed: Mask) -> list[tuple[int, int]]:
        """First and last rows of the parts that are followed: of a redundant arm all of it, where the joints depend on
        the way that they came.
        """
        last = len(changed)
        if self.robot.n > self.task.m:
            return [(0, last)]
        parts: list[tuple[int, int]] = []
        for move in np.flatnonzero(changed).tolist():
            low, high = max(0, move - _PADDED), min(last, move + 1 + _PADDED)
            if parts and low <= parts[-1][1]:
                parts[-1] = parts[-1][0], high
            else:
                parts.append((low, high))
        return parts

    def _proven_part(self, rows: _PoseRows, low: int, high: int) -> Array | NoPoses | None:
        """Times of a part of the rows at which it is proven."""
        part = slice(low, high + 1)
        matrices, q = rows.matrices[part], rows.q[part]
        times = None if rows.times is None else rows.times[part]
        tolerance = tip_tolerance(self.check.options, self.robot)
        branch = followed_branch(self.robot, matrices, q[0], self.task, tolerance, free=False)
        if not branch.complete or branch.passed:
            return NoPoses.UNPROVEN
        last = len(rows.given) - 1
        if high != last and not self._same_configuration(branch.last, q[-1]):
            return NoPoses.UNPROVEN
        path, times = self._within_rates(matrices, times, branch)
        if not self._holds(path):
            return NoPoses.UNPROVEN
        return times

    def _within_rates(self, matrices: Array, times: Array | None, branch: Followed) -> tuple[Curve, Array | None]:
        """A branch in time, and the times of its poses (T,), later where a joint would exceed its rate."""
        limits = rate_limits(self.robot)
        spare, most_allowed = _SPARE, 1.0
        if self.robot.n > self.task.m:
            spare, most_allowed = _REDUNDANT_SPARE, 2.0 - _REDUNDANT_SPARE
        path = timed_branch(self.robot, self.task, matrices, times, branch)
        for _ in range(_ROUNDS):
            if path.rates is None or times is None:
                break
            most = (path.rates / limits).max(axis=1)
            if most.max(initial=0.0) <= most_allowed:
                break
            move = np.minimum(np.floor(branch.place[:-1]).astype(np.int64) - 1, len(times) - 2)
            factor = np.ones(len(times) - 1)
            np.maximum.at(factor, move, np.where(most > most_allowed, most * spare, 1.0))
            times = times[0] + np.concatenate([[0.0], np.cumsum(np.diff(times) * factor)])
            path = timed_branch(self.robot, self.task, matrices, times, branch)
        return path, times

    def _same_configuration(self, q: Array, other: Array) -> bool:
        return bool(np.abs((q - other) / self.aim.joints).max() <= _ON_BRANCH)

    def _holds(self, path: Curve) -> bool:
        """A part is proven free, far enough from singularities, and keeps the limits that the remedy keeps."""
        check, task = self.check, self.check.task
        if check.options.min_distance > 0.0:
            again = check_curve(self.robot, path, task, check.options, self.analysis, check.tolerances)
            free, complete = again.clear, again.complete
        else:
            rows = path.samples
            proof = proof_of(self.robot, task, rows, check.tolerances, check.options.evaluations)
            free, complete = not proof.slivers, proof.complete
        if not complete:
            raise KeyboardInterrupt
        if not free or path.rates is None:
            return free
        if (path.rates > rate_limits(self.robot)).any() and self.remedy.check.holds:
            return False
        if self.acceleration is None:
            return True
        limits = np.full(self.robot.n, self.acceleration)
        return usage(path, np.full(self.robot.n, np.inf), limits).slower <= _SPARE
