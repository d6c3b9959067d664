"""A changed path becomes a remedy where a new check proves it: as the path was checked, and inside the limits."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rankdrop.local.block import joint_scale
from rankdrop.path.check.check import check_path
from rankdrop.path.check.record import FREE, UNDECIDED, PathCheck
from rankdrop.path.curve import Curve
from rankdrop.path.mend.record import Proposal, Remedy
from rankdrop.path.mend.retime import Usage, retime_path, usage
from rankdrop.path.mend.slow_down import slowed_down
from rankdrop.path.read.trajectory import Trajectory
from rankdrop.results.analysis import Analysis
from rankdrop.robot.model import Array

Progress = Callable[[str, int, int], None]
"""progress(kind, done, all)."""
SLOWER = 1.0 + 1e-9
"""Of a limit: above it by less is within it."""


@dataclass(frozen=True, eq=False)
class Verifier:
    """Checks changed paths as one path was checked.

    Attributes:
        before: the judgement of the path; its settings are those of the new ones.
        analysis: families, where the path was checked with an analysis.
        limits: (n,) each: of rates and accelerations; inf where there are none.
        progress: called with the kind, and how much of it is done.
    """

    before: PathCheck
    analysis: Analysis | None
    limits: tuple[Array, Array]
    progress: Progress | None = None

    @cached_property
    def scale(self) -> Array:
        """(n,) of joint motions."""
        return joint_scale(self.before.robot, self.before.task)

    @property
    def interpolate(self) -> str:
        """Between the rows of the path, and of changed ones."""
        return self.before.options.interpolate

    def usage(self, path: Curve) -> Usage | None:
        """Shares of the limits that a path takes; None without times or limits."""
        limited = bool(np.isfinite(self.limits[0]).any() or np.isfinite(self.limits[1]).any())
        if path.times is not None and limited:
            return usage(path, *self.limits)
        return None

    def breaks_limits(self, path: Curve) -> bool:
        """Whether a path in time breaks a limit."""
        took = self.usage(path)
        return took is not None and took.slower > SLOWER

    def report(self, kind: str, done: int, count: int) -> None:
        """How much of a kind is done, to whoever asked for it."""
        if self.progress is not None:
            self.progress(kind, done, count)

    def first_proven(self, kind: str, proposals: Iterable[Proposal]) -> Remedy | None:
        """The first proposal that is proven free; one in time that breaks a limit gets another time law."""
        for proposal in proposals:
            trajectory = proposal.trajectory
            path = trajectory.curve(self.interpolate)
            retimed = trajectory.timed and self.breaks_limits(path)
            if retimed:
                trajectory = self._within_limits(path)
            remedy = self.as_remedy(kind, replace(proposal, trajectory=trajectory), retimed=retimed)
            if remedy.check.clear:
                return remedy
        return None

    def _within_limits(self, path: Curve) -> Trajectory:
        """A changed path slower around the rows that are too fast, or else all of it in a new time."""
        slowed = slowed_down(path, *self.limits)
        if slowed is not None:
            return slowed[0]
        return retime_path(path, *self.limits, self.scale)

    def as_remedy(self, kind: str, proposal: Proposal, *, retimed: bool) -> Remedy:
        """A proposal with its new check, and what it gains over the path."""
        trajectory = proposal.trajectory
        check = self.check_changed(trajectory)
        was, took = self.usage(self.before.curve), self.usage(check.curve)
        gains = {"distance": (_distance(self.before), _distance(check))}
        if was is not None and took is not None:
            gains |= {"speed": (1 / was.slower, 1 / took.slower),
                      "duration": (_duration(self.before), _duration(check))}  # fmt: skip
        trajectory = replace(trajectory, name="mended")
        return Remedy(kind, proposal.how, proposal.parameters, gains, trajectory, self.interpolate, check, took,
                      proposal.off, retimed, proposal.changes)  # fmt: skip

    def check_changed(self, trajectory: Trajectory) -> PathCheck:
        """A changed path, checked as the path was."""
        check = check_path(
            self.before.robot, trajectory.q, trajectory.times if trajectory.timed else None,
            velocities=trajectory.velocities, accelerations=trajectory.accelerations, task=self.before.task,
            analysis=self.analysis, options=self.before.options, tolerances=self.before.tolerances,
        )  # fmt: skip
        if not check.complete:
            raise KeyboardInterrupt
        return check


def _distance(check: PathCheck) -> float:
    """Least distance known along a path; 0 where it reaches a singularity, or may."""
    if any(stretch.verdict not in (FREE, UNDECIDED) for stretch in check.stretches):
        return 0.0
    return min((stretch.closest.distance for stretch in check.stretches), default=np.inf)


def _duration(check: PathCheck) -> float:
    times = check.curve.times
    if times is None:
        return np.nan
    return float(times[-1] - times[0])
