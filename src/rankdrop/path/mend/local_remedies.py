"""Local remedies: the path changed around its singularities, by bumps of the joints and by detours of the tool.

Where the joints stay on one side they are moved aside (`path.mend.bumps`). Where they have to go to the other side, the
tool is led around the singularity (`path.mend.detours`), on the path with its bumps. Poses are moved in windows
(`path.mend.pose_detours`), on the branch that they are on or on another one.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from operator import attrgetter

import numpy as np

from rankdrop.errors import TaskError
from rankdrop.path.check.record import FREE, PathCheck
from rankdrop.path.mend.bumped_path import Bump, BumpedPath, ends_of
from rankdrop.path.mend.bumps import CLEARANCE, SPARE, Bumper, NoBump, Obstacle
from rankdrop.path.mend.candidates import other_branches
from rankdrop.path.mend.detours import Detour, Detourer, NoDetour
from rankdrop.path.mend.given_poses import given_tool_path
from rankdrop.path.mend.joint_tool_path import JointToolPath, tool_path
from rankdrop.path.mend.local_change import ON_PATH, LocalChange, RowsBefore, largest_off, size_of_off
from rankdrop.path.mend.pose_detours import Blocked, PoseDetourer, PoseWindow
from rankdrop.path.mend.record import BUMP, DETOUR, Failure, Proposal, Remedy, joint_values
from rankdrop.path.mend.singular_parts import SingularParts
from rankdrop.path.mend.verifier import Verifier
from rankdrop.questions import RemedyOptions
from rankdrop.results.known import known_families
from rankdrop.robot.model import Array

_CLEARER = 1.5  # times the clearance of a bump whose window was not proven free
_ROUNDS = 3  # of that
_MANY = 200  # places on one path above which no local remedy is tried: such a file is not what it was meant to be
_ELSEWHERE = 12  # windows that are looked for on all other branches of poses together, some 0.3 s each
_DETOURS = 12  # crossings of one path that the tool is led around, some 2 s each


@dataclass(frozen=True, eq=False)
class FoundBumps:
    """Bumps of the singular parts of a path, and why the other parts have none."""

    bumps: list[Bump] = field(default_factory=list)
    failed: list[NoBump] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class LocalMender:
    """Changes one path around its singularities.

    Attributes:
        verifier: checks changed paths as the path was checked.
        kinds: those that are tried.
        bounds: how far the path may be changed.
    """

    verifier: Verifier
    kinds: Collection[str]
    bounds: RemedyOptions

    @property
    def check(self) -> PathCheck:
        """The judgement of the path."""
        return self.verifier.before

    @property
    def clearance(self) -> float:
        """First-order distance from a singularity that a change leaves [rad]."""
        asked = SPARE * self.check.options.min_distance
        return asked if asked > 0.0 else CLEARANCE

    @property
    def moves_aside(self) -> bool:
        """Whether bumps are asked for as a remedy."""
        return BUMP in self.kinds and self.bounds.bump > 0.0

    @property
    def leads_around(self) -> bool:
        """Whether detours of joint paths are asked for."""
        return DETOUR in self.kinds and self.bounds.detour > 0.0 and self.check.poses is None

    def change_joints(self, tool: JointToolPath) -> Iterator[Remedy | Failure]:
        """The joints moved aside; where they have to go to the other side, the tool led around it."""
        check, most = self.check, self.bounds
        if sum(stretch.verdict != FREE for stretch in check.stretches) > _MANY:
            yield "local", _MANY
            return
        families, _ = known_families(check.robot, check.task, self.verifier.analysis, check.tolerances)
        bumper = Bumper(SingularParts(check, tool), families, most.bump, *self.verifier.limits)
        found = FoundBumps()
        if most.bump > 0.0 and (self.moves_aside or self.leads_around):
            found = self.find_bumps(bumper, self.clearance)
        if self.moves_aside:
            result = self._bump(bumper, found)
            yield result
            if isinstance(result, Remedy) and bumper.parts.size(result.deviation) <= ON_PATH:
                return
        if self.leads_around:
            yield self._detour_after_bumps(bumper, found)

    def _detour_after_bumps(self, bumper: Bumper, found: FoundBumps) -> Remedy | Failure:
        """Detours, and of the bumps those that leave the tool on its path; where these are not enough, those that take
        it no farther off than a detour may.
        """
        size = bumper.parts.size
        near = [bump for bump in found.bumps if size(bump.off) <= min(ON_PATH, self.bounds.detour)]
        result = self._detour(bumper.parts, self.bumps_before_detours(bumper, near, found))
        farther = [bump for bump in found.bumps if size(bump.off) <= self.bounds.detour]
        if isinstance(result, Remedy) or len(farther) == len(near):
            return result
        return self._detour(bumper.parts, self.bumps_before_detours(bumper, farther, found))

    def bumps_before_detours(
        self, bumper: Bumper, bumps: list[Bump], found: FoundBumps
    ) -> tuple[Proposal, PathCheck] | None:
        """The path with some of the bumps that were found, where it needs detours in addition; None where it does not,
        or without bumps.

        Bumps that bring the tool back are taken where only the singularities without a bump are left after them.
        """
        led_around = [failure.core for failure in found.failed]
        led_around += [bump.core for bump in found.bumps if bump not in bumps]
        if not bumps or not led_around:
            return None
        most = sum(len(core.stretches) for core in led_around)
        for proposal in bump_proposals(bumper, bumps, self.clearance):
            check = self.verifier.check_changed(proposal.trajectory)
            if sum(stretch.verdict != FREE for stretch in check.stretches) <= most:
                break
        return proposal, check

    def _bump(self, bumper: Bumper, found: FoundBumps) -> Remedy | Failure:
        """The joints moved aside at every singularity, farther where the path is not proven free."""
        parts, clearance = bumper.parts, self.clearance
        for tried in range(1, _ROUNDS + 1):
            if found.failed or not found.bumps:
                missing = [
                    (parts.path.place(parts.spot(failure.core)), failure.obstacle, failure.needed)
                    for failure in found.failed
                ]
                return BUMP, (tried - 1, bumper.bound, missing)
            remedy = self.verifier.first_proven(BUMP, bump_proposals(bumper, found.bumps, clearance))
            if remedy is not None:
                return remedy
            if tried < _ROUNDS:
                clearance *= _CLEARER
                found = self.find_bumps(bumper, clearance)
        return BUMP, (_ROUNDS, bumper.bound, [])

    def find_bumps(self, bumper: Bumper, clearance: float) -> FoundBumps:
        """A bump for each part of a path that has one, and why the others have none."""
        cores, crossed = bumper.cores(clearance)
        results: list[Bump | NoBump] = [NoBump(core, Obstacle.SIDE) for core in crossed]
        for k, core in enumerate(cores):
            self.verifier.report(BUMP, k, len(cores))
            results.append(bumper.bump(core, clearance))
        self.verifier.report(BUMP, len(cores), len(cores))
        bumps = [result for result in results if isinstance(result, Bump)]
        return FoundBumps(bumps, [result for result in results if isinstance(result, NoBump)])

    def _detour(self, parts: SingularParts, bumped: tuple[Proposal, PathCheck] | None) -> Remedy | Failure:
        """The tool led around what no bump avoids, on the path with its bumps."""
        if not _poses_determine(parts.tool) or parts.path.degree != 1:
            return DETOUR, None
        most = self.bounds.detour
        changes: list[LocalChange] = []
        rows = RowsBefore.of(parts.path, parts.path, ())
        if bumped is not None:
            before, checked = bumped
            rows = RowsBefore.of(parts.path, checked.curve, before.changes)
            parts = SingularParts(checked, tool_path(checked.robot, checked.task, checked.curve))
            changes += before.changes
        stretches = sorted(
            (stretch for stretch in parts.check.stretches if stretch.verdict != FREE), key=attrgetter("start")
        )
        if len(stretches) > _DETOURS:
            return DETOUR, (most, [], len(stretches))
        cores = [parts.core(stretch, self.clearance) for stretch in stretches]
        work = Detourer(parts, most)
        results = work.find_detours(cores, self.clearance)
        self.verifier.report(DETOUR, len(results), len(cores))
        detours = [result for result in results if isinstance(result, Detour)]
        failed = [(rows.place(parts.path.place(parts.spot(result.core))), result.hindrance, result.needed,
                   result.joints) for result in results if isinstance(result, NoDetour)]  # fmt: skip
        if failed or not detours:
            return DETOUR, (most, failed, 0)
        for change in work.changes(detours):
            changes.append(replace(change, start=rows.place(change.start), end=rows.place(change.end)))
        changes.sort(key=attrgetter("start"))
        trajectory, rest = work.trajectory(detours)
        off = largest_off([rest, *(change.off for change in changes)])
        proposal = Proposal(("detour", len(detours)), (), trajectory, off, tuple(changes))
        return self.verifier.first_proven(DETOUR, [proposal]) or (DETOUR, (most, [], 0))

    def change_poses(self) -> Iterator[Remedy | Failure]:
        """The poses moved around each singularity that they lead through, and the joints along them."""
        most = self.bounds.detour
        if DETOUR not in self.kinds or most <= 0.0:
            return
        work = PoseDetourer(self.check, most, self.clearance)
        windows = work.find_windows(partial(self.verifier.report, DETOUR))
        if isinstance(windows, Blocked):
            place = work.place_at(windows.place)
            joints = (windows.joint,) if windows.joint else ()
            yield DETOUR, (most, [(place, windows.hindrance, windows.needed, joints)], 0)
            if np.isfinite(windows.beyond):
                yield "range", (windows.joint, windows.beyond, self.check.robot)
            return
        if not windows:
            yield DETOUR, (most, [], 0)
            return
        proposal = self._pose_proposal(work, windows, "detour")
        yield self.verifier.first_proven(DETOUR, [proposal]) or (DETOUR, (most, [], 0))

    def change_poses_on_other_branch(self, start: Array) -> Iterator[Remedy | Failure]:
        """The poses followed on another branch from the first one on, and moved around the singularities there; and how
        many branches were followed, where the budget of windows did not last for all.

        Args:
            start: (n,) the configuration at the first pose.
        """
        work = PoseDetourer(self.check, self.bounds.detour, self.clearance)
        starts = other_branches(given_tool_path(self.check, start))
        proposals = []
        followed = len(starts)
        for k, other in enumerate(starts):
            if work.searched >= _ELSEWHERE:
                followed = k
                break
            self.verifier.report(DETOUR, k, len(starts))
            windows = work.find_windows(_unreported, other, _ELSEWHERE - work.searched)
            if isinstance(windows, Blocked) or not windows:
                continue
            proposal = self._pose_proposal(work, windows, "detour elsewhere")
            proposals.append(replace(proposal, parameters=(joint_values("start", other),)))
        self.verifier.report(DETOUR, len(starts), len(starts))
        length = self.check.length_scale
        proposals.sort(key=lambda proposal: size_of_off(proposal.off, length))
        remedy = self.verifier.first_proven(DETOUR, proposals)
        if remedy is not None:
            yield remedy
        if followed < len(starts):
            yield "other branches", (followed, len(starts), _ELSEWHERE)

    def _pose_proposal(self, work: PoseDetourer, windows: list[PoseWindow], how: str) -> Proposal:
        """The joints along poses that are moved in windows."""
        still = np.zeros(self.check.robot.n)
        changes = tuple(
            LocalChange(work.place_at(window.low), work.place_at(window.high), still, window.off, still)
            for window in windows
        )
        off = largest_off(window.off for window in windows)
        return Proposal((how, len(windows)), (), work.trajectory(), off, changes)


def _poses_determine(tool: JointToolPath) -> bool:
    """Whether poses of the tool determine its task, so that the joints can follow them."""
    try:
        tool.aim  # noqa: B018  # refuses a task that poses do not determine
    except TaskError:
        return False
    return True


def _unreported(done: int, count: int) -> None:
    """Progress of a part of the work that is too short to be reported."""


def bump_proposals(bumper: Bumper, bumps: list[Bump], clearance: float) -> Iterator[Proposal]:
    """A path with bumps: the tool brought back to its path where that is better; then as the bumps are."""
    led = [bumper.lead_aside(bump, clearance) for bump in bumps]
    if any(bump.twist is not None for bump in led):
        yield _bump_proposal(bumper, led)
    yield _bump_proposal(bumper, bumps)


def _bump_proposal(bumper: Bumper, bumps: list[Bump]) -> Proposal:
    """A path with bumps."""
    parts = bumper.parts
    changes = []
    for bump in sorted(bumps, key=lambda bump: bump.core.low):
        start, end = (parts.path.place(spot) for spot in ends_of(parts, bump))
        way = BumpedPath(parts, [bump]).most_moved()
        changes.append(LocalChange(start, end, way, bump.off, np.zeros_like(bump.way)))
    off = largest_off(bump.off for bump in bumps)
    return Proposal(("bump", len(bumps)), (), BumpedPath(parts, bumps).trajectory(), off, tuple(changes))
