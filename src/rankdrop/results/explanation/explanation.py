"""The explanation of one configuration: its data, and how it goes to JSON, to text and to a notebook.

An explanation as plain data: the names of docs/json.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from rankdrop.codec import Result
from rankdrop.configuration import Cause, Rank
from rankdrop.family.incidence import Incidence
from rankdrop.local.axes import Relation, relations_at
from rankdrop.local.failures import Failures, failures_at
from rankdrop.local.nearest import Nearest
from rankdrop.local.orientation import Representations, representation_at
from rankdrop.local.rates import Ellipsoids, Rates, StraightMotion, ellipsoids, joint_rates
from rankdrop.local.redundant import Redundancy, redundancy
from rankdrop.local.ways_out import Escape, escape
from rankdrop.results.explanation.parts import (
    AT_LIMIT,
    Asked,
    Blame,
    Far,
    Lost,
    SlowFamily,
    Summary,
    blame_at,
    disagreements,
    incidences_at,
    lost_of,
    slow_family,
    summary_of,
    turned_task,
)
from rankdrop.results.explanation.text import (
    reason_of,
    sections_of,
)
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.task import Task


@dataclass(frozen=True, eq=False, repr=False)
class Explanation(Result):
    """Everything rankdrop can say of one configuration; parts that take long are made when first asked for, and kept.

    Attributes:
        asked: the question: arm, configuration, task, rank, known families, settings.
        verdict: "regular", "near", "singular" or "always-singular".
        cause: what decides it.
        far: how far the next singularity is.
        straight: the slowest translation and the slowest rotation of the tool.
    """

    asked: Asked
    verdict: str
    cause: Cause
    far: Far
    straight: tuple[StraightMotion, ...] = ()
    FILE: ClassVar[str] = "explanation"

    @property
    def reason(self) -> str:
        """What decides the verdict, in a sentence."""
        return reason_of(self)

    @cached_property
    def slow_family(self) -> SlowFamily | None:
        """The family that makes a straight motion slow; None where speed does not decide the verdict."""
        return slow_family(self.asked, self.far) if self.cause == Cause.SLOW else None

    @property
    def distance(self) -> float | None:
        """To the nearest singular configuration found [rad; slides in length scales]; 0 at one, None where none was."""
        if self.rank.corank:
            return 0.0
        return None if self.far.nearest is None else self.far.nearest.distance

    @cached_property
    def summary(self) -> Summary:
        """The answer in facts."""
        return summary_of(self)

    @property
    def robot(self) -> Robot:
        """The arm that was asked about."""
        return self.asked.here.robot

    @property
    def task(self) -> Task:
        """What the tool is to do, with the length scale that was used."""
        return replace(self.asked.here.task, length_scale=self.asked.length_scale)

    @property
    def q(self) -> Array:
        """(n,) the configuration [rad, m]."""
        return self.asked.here.q

    @property
    def rank(self) -> Rank:
        """Singular values, rank, generic rank, corank, nullity."""
        return self.asked.here.measured

    @property
    def source(self) -> str:
        """Where the families come from."""
        return self.asked.source

    @cached_property
    def focus(self) -> Array:
        """(n,) what family, relations and blame speak of, q itself or the nearest singular one where q is near it."""
        return self.q if self._at_hand is None else np.array(self._at_hand.q)

    @property
    def _at_hand(self) -> Nearest | None:
        return self.far.nearest if self.cause in (Cause.DISTANCE, Cause.SMALL) else None

    @property
    def _corank(self) -> int:
        return self.rank.corank if self._at_hand is None else self._at_hand.corank

    @cached_property
    def met(self) -> tuple[Incidence, ...]:
        """Families that hold at the focus; the first is the one that says most."""
        return incidences_at(self.asked, self.focus, self._corank) if self._corank else ()

    @cached_property
    def relations(self) -> tuple[Relation, ...]:
        """What the axes have in common at the focus."""
        return relations_at(self.robot, self.focus)

    @cached_property
    def lost(self) -> Lost:
        """Directions of the tool that are lost at the focus."""
        return lost_of(self.asked, self.focus, self._corank or int(self.cause in (Cause.NEAR_MISS, Cause.SLOW)))

    @cached_property
    def blame(self) -> Blame:
        """Which joints make the dependency at the focus."""
        return blame_at(self.asked, self.focus, self._corank)

    @cached_property
    def escape(self) -> Escape:
        """Which motions lead out."""
        return escape(self.asked.here, seed=self.asked.options.seed, step=self.asked.options.step)

    @cached_property
    def rates(self) -> Rates:
        """What motion costs the joints."""
        task = turned_task(self.asked.here.task, self.asked.options.frame, self.lost)
        return joint_rates(self.asked.here) if task == self.asked.here.task else joint_rates(self.robot, self.q, task)

    @cached_property
    def failures(self) -> Failures:
        """What the failure of each single joint leaves at q."""
        return failures_at(self.asked.here)

    @cached_property
    def ellipsoids(self) -> Ellipsoids:
        """How motion and force compare by direction."""
        return ellipsoids(self.asked.here)

    @cached_property
    def redundancy(self) -> Redundancy:
        """What motions of the joints leave the tool still."""
        return redundancy(self.asked.here)

    @cached_property
    def representations(self) -> Representations:
        """How far the coordinates of the orientation are from singularities of their own."""
        return representation_at(self.robot, self.q, tolerances=self.asked.here.tolerances)

    @cached_property
    def disagreements(self) -> tuple[str, ...]:
        """Where two methods disagree; empty when all is well."""
        return tuple(disagreements(self.far, self.escape.single))

    @property
    def nearly_lost(self) -> int:
        """Further singular values that are small but not zero: freedoms nearly lost, by offsets or by nearness."""
        kept = self.rank.sigma[: self.rank.rank]
        return int((kept <= self.asked.options.small).sum())

    @property
    def outside_limits(self) -> tuple[int, ...]:
        """Joints (from 1) whose value is beyond a limit by more than `AT_LIMIT`."""
        out = np.maximum(self.robot.lower - self.q, self.q - self.robot.upper) / self._scale
        return tuple(int(i) + 1 for i in np.flatnonzero(out > AT_LIMIT))

    @property
    def at_limits(self) -> tuple[int, ...]:
        """Joints (from 1) that stand at a limit, to within `AT_LIMIT`."""
        gap = np.minimum(np.abs(self.q - self.robot.lower), np.abs(self.robot.upper - self.q)) / self._scale
        return tuple(int(i) + 1 for i in np.flatnonzero(gap <= AT_LIMIT))

    @property
    def _scale(self) -> Array:
        turning = [joint.unit == "rad" for joint in self.robot.variables]
        return np.where(turning, 1.0, self.asked.length_scale)

    @cached_property
    def certified_radius(self) -> float | None:
        """Radius proven free of singularities [rad]; 0 at a singularity, None where it cannot be certified."""
        if self.rank.corank or self.rank.always_singular:
            return 0.0
        return None if self.far.certificate is None else self.far.certificate.radius

    def __repr__(self) -> str:
        return f"<Explanation of {self.robot.name}: {self.verdict}, {self.reason}>"

    def sections(self, *, full: bool = False, parts: Sequence[str] = ()) -> tuple[Section, ...]:
        """The explanation in words: see `rankdrop.results.explanation.text.sections_of`."""
        return sections_of(self, full=full, parts=parts)
