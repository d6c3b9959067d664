"""`mend_path`: what would make a path free of singularities, or keep its limits, each proven by a new check.

Local changes are made in `path.mend.local_remedies`, corners cut in `path.mend.blends`, other joint paths for the tool
in `path.mend.candidates`, new time laws in `path.mend.time_remedies`; `path.mend.verifier` checks what they propose.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import OptionError, TaskError
from rankdrop.local.rates import rate_limits
from rankdrop.options import takes
from rankdrop.path.check.record import PathCheck
from rankdrop.path.mend.blends import blends
from rankdrop.path.mend.candidates import Candidate, Ranking, branches, null_spaces, shifts, tilts
from rankdrop.path.mend.given_poses import given_tool_path
from rankdrop.path.mend.joint_tool_path import JointToolPath, tool_path
from rankdrop.path.mend.local_remedies import LocalMender
from rankdrop.path.mend.record import (
    BLEND,
    DETOUR,
    FLIP,
    KINDS,
    LOCAL,
    NULL,
    RETIME,
    SHIFT,
    SLOW,
    TILT,
    Failure,
    Mending,
    Proposal,
    Remedy,
)
from rankdrop.path.mend.time_remedies import in_new_time, slower
from rankdrop.path.mend.verifier import Progress, Verifier
from rankdrop.questions import RemedyOptions
from rankdrop.results.analysis import Analysis
from rankdrop.robot.model import Array

_CHECKED = 4  # candidates of a kind that are checked, widest first


@takes(RemedyOptions)
def mend_path(
    check: PathCheck,
    *,
    analysis: Analysis | None = None,
    acceleration: ArrayLike | None = None,
    kinds: Collection[str] = KINDS,
    options: RemedyOptions | None = None,
    progress: Progress | None = None,
    **given: Any,
) -> Mending:
    """Remedies of a checked path: computed, and checked again as `check_path` checked the path itself.

    null-space    the same tool path by other joint motion of a redundant arm, from the same start where there is one
    flip          the same tool path on another branch of the inverse kinematics
    bump          the joints moved aside around each singularity, within `bump`, and the rest of the path as it is
    detour        where the joints go to the other side of a singularity, or a bump takes the tool off its path: the
                  tool led around it, within `detour`
    blend         a corner cut, where the path meets the singularity around it, within `blend`
    tool tilt     the tool held tilted, within `tool_tilt`
    base shift    the base moved, within `base_shift`
    slow-down     the same path, slower where it is too fast, and the rest of its times only shifted
    retime        the same path in a new time: inside the limits of joint rates and accelerations; where no slow-down
                  is found

    A change of the path is a remedy only where its judgement is free, proven for every point, with the distance asked
    for proven to be kept. A new time law is one only where the limits hold at every instant, by bounds on the curve
    between its rows (`Usage.how`). Paths in time that would break limits once changed get a new time law as well. That
    no remedy is found is no proof that there is none.

    Args:
        check: the judgement; its settings are those of the new ones.
        analysis: families, where the path was checked with an analysis.
        acceleration: () or (n,) limits [rad/s², m/s²]; None: none. Arms state none of their own.
        kinds: those of `KINDS` that are tried.
        options: how far the path may be changed; its fields are taken as keywords as well.
        progress: called with the kind, and how much of it is done.

    Returns:
        The remedies found, one of each kind at most, and for the other kinds what was tried.

    Raises:
        OptionError: a bound outside what is allowed.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.path.check.check import check_path
        >>> path = [[0.3, 0.4, 0.1], [0.5, -0.2, 0.3], [0.9, 0.5, 0.3]]
        >>> mended = mend_path(check_path(open_robot("planar3r"), path), kinds=["blend"], blend=0.5)
        >>> [(one.kind, one.check.verdict.value) for one in mended.remedies]
        [('blend', 'free')]
    """
    how = RemedyOptions.of(options, given)
    unknown = [kind for kind in kinds if kind not in KINDS]
    if unknown:
        raise OptionError("there is no such remedy", where="kinds", got=unknown[0], allowed=", ".join(KINDS))
    verifier = Verifier(check, analysis, _limits(check, acceleration), progress)
    work = _Mender(verifier, frozenset(kinds), how)
    results: list[Remedy | Failure] = []
    complete = True
    try:
        for result in work.results():
            results.append(result)  # what is made before Ctrl-C is kept
    except KeyboardInterrupt:
        complete = False
    remedies = sorted((result for result in results if isinstance(result, Remedy)), key=attrgetter("rank"))
    failures = tuple(result for result in results if not isinstance(result, Remedy))
    return Mending(check, tuple(remedies), failures, not check.clear or verifier.breaks_limits(check.curve), complete)


def _limits(check: PathCheck, acceleration: ArrayLike | None) -> tuple[Array, Array]:
    """(n,) each: of rates and accelerations."""
    given = np.asarray(np.inf if acceleration is None else acceleration, dtype=np.float64)
    if given.shape not in ((), (check.robot.n,)) or np.isnan(given).any() or not (given > 0.0).all():
        raise OptionError("an acceleration limit is above zero", where="acceleration", got=given.tolist(),
                          allowed=f"one number, or {check.robot.n}, one for each joint")  # fmt: skip
    return rate_limits(check.robot), np.array(np.broadcast_to(given, (check.robot.n,)))


@dataclass(frozen=True, eq=False)
class _Mender:
    """Tries the kinds of remedies of one path, within bounds."""

    verifier: Verifier
    kinds: frozenset[str]
    bounds: RemedyOptions

    @property
    def check(self) -> PathCheck:
        """The judgement of the path."""
        return self.verifier.before

    @cached_property
    def _local(self) -> LocalMender:
        return LocalMender(self.verifier, self.kinds, self.bounds)

    def results(self) -> Iterator[Remedy | Failure]:
        """A remedy of each kind, or what was tried."""
        if not self.check.clear:
            yield from self._changed_paths()
        if not self.verifier.breaks_limits(self.check.curve) or _ends_early(self.check) is not None:
            return
        if SLOW in self.kinds and self.check.clear:
            slowed = slower(self.verifier)
            yield slowed
            if isinstance(slowed, Remedy):
                return
        if RETIME in self.kinds:
            yield in_new_time(self.verifier)

    def _changed_paths(self) -> Iterator[Remedy | Failure]:
        """Every kind that changes the path; of poses in turn until one is found."""
        if self.check.poses is None:
            yield from self._changed_joints()
            return
        for change in (self._local.change_poses, self._changed_joints, self._other_branch):
            is_found = False
            for result in change():
                is_found |= isinstance(result, Remedy)
                yield result
            if is_found:
                return

    def _other_branch(self) -> Iterator[Remedy | Failure]:
        """The poses on another branch of the inverse kinematics, and moved around the singularities there."""
        start = self._start()
        if {DETOUR, FLIP} <= self.kinds and self.bounds.detour > 0.0 and start is not None:
            yield from self._local.change_poses_on_other_branch(start)

    def _start(self) -> Array | None:
        """(n,) the configuration at the first pose; None where it is not reached."""
        tool = self.check.tool
        if tool is None or not len(tool.q):
            return None
        return np.asarray(tool.q[0])

    def _changed_joints(self) -> Iterator[Remedy | Failure]:
        """Every kind that changes joint paths; of poses that cannot be followed to their end those that begin anew."""
        reached = _ends_early(self.check)
        if reached is not None:
            start = self._start()
            if start is not None:
                yield from self._rank_paths(given_tool_path(self.check, start))
            elif self.kinds - set(LOCAL):
                yield "unfinished", reached
            return
        tool = tool_path(self.check.robot, self.check.task, self.check.curve)
        yield from self._local.change_joints(tool)
        if self.bounds.blend > 0.0 and BLEND in self.kinds:
            yield self._blend(self.bounds.blend)
        yield from self._rank_paths(tool)

    def _rank_paths(self, tool: JointToolPath) -> Iterator[Remedy | Failure]:
        """Every kind that ranks whole paths of the joints."""
        kinds: dict[str, Callable[[Callable[[int, int], None]], Ranking]] = {
            NULL: partial(null_spaces, tool), FLIP: partial(branches, tool),
        }  # fmt: skip
        if self.bounds.tool_tilt:
            kinds[TILT] = partial(tilts, tool, self.bounds.tool_tilt)
        if self.bounds.base_shift:
            kinds[SHIFT] = partial(shifts, tool, self.bounds.base_shift)
        kinds = {kind: rank for kind, rank in kinds.items() if kind in self.kinds}
        try:
            tool.aim  # noqa: B018  # refuses a task that poses do not determine
        except TaskError as error:
            if kinds:
                yield "path", error.what
            return
        for kind, rank in kinds.items():
            candidates, ended = rank(partial(self.verifier.report, kind))
            yield self.verifier.first_proven(kind, self._proposals(candidates)) or (kind, (len(candidates), ended))

    def _proposals(self, candidates: list[Candidate]) -> Iterator[Proposal]:
        """The widest candidates, followed in full."""
        for candidate in candidates[:_CHECKED]:
            tool, followed = candidate.tool.refine_run(candidate.run)
            if followed.complete:
                trajectory = tool.trajectory(followed.q, self.verifier.interpolate)
                off = tool.deviation(trajectory, self.verifier.interpolate)
                yield Proposal((candidate.how, None), candidate.parameters, trajectory, off)

    def _blend(self, most: float) -> Remedy | Failure:
        """The corners nearest to singularities cut, the tool within `most` [m]."""
        if self.verifier.interpolate != "linear":
            return BLEND, None
        proposals = list(blends(self.check, most))
        return self.verifier.first_proven(BLEND, proposals) or (BLEND, len(proposals))



def _ends_early(check: PathCheck) -> float | None:
    """The pose up to which a tool path can be followed; None where it is followed to its end, or is of joints."""
    if check.tool is None or check.tool.complete:
        return None
    return check.tool.reached
