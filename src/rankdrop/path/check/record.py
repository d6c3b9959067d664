"""A checked path as data: what was asked, the verdict, every stretch, the limits it breaks, and its profile.

Facts alone; their sentences are made in `text.paths`, their file by `schema.motion`. Rows and joints are numbered
from 1.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from functools import partial
from operator import attrgetter
from typing import Any, ClassVar, Literal

import numpy as np

from rankdrop.codec import Result
from rankdrop.path.check.overrun import Fastest, Overrun, fastest, overruns
from rankdrop.path.check.tool_branch import Followed
from rankdrop.path.check.turns import FarTurn, far_turns
from rankdrop.path.curve import Curve, Index, Place
from rankdrop.questions import PathOptions
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.task import Task
from rankdrop.text import paths as text
from rankdrop.text.tool_paths import why_ended
from rankdrop.tolerances import Tolerances

LEADS = 1e-6
"""A free stretch that comes nearer than this leads to a crossing at one of its ends [rad]."""

Evidence = Literal["covered", "determinant", "condition", "singular throughout", "small sigma", "no enclosure",
                   "unfinished"]
"""How the verdict of a stretch is known."""
Remark = Literal["degrees", "velocities", "jump", "lost", "distances", "no distance", "distance open",
                 "missed", "edge"]  # fmt: skip
"""What a reader should know besides the verdict; its values follow it in `PathCheck.remarks`."""


class Verdict(StrEnum):
    """What is known of a path; of a stretch: free, crossing, touching or undecided. Worst first."""

    CROSSING = "crossing"
    TOUCHING = "touching"
    NOT_FOLLOWED = "cannot be followed"
    OUTSIDE = "outside limits"
    TOO_FAST = "too fast"
    TOO_NEAR = "too near"
    UNDECIDED = "undecided"
    FREE = "free"


CROSSING, TOUCHING, NOT_FOLLOWED, OUTSIDE, TOO_FAST, TOO_NEAR, UNDECIDED, FREE = VERDICTS = tuple(Verdict)


@dataclass(frozen=True, eq=False)
class Closest:
    """Where a stretch is nearest to a singularity.

    Attributes:
        place: on the path.
        q: (n,) configuration there [rad, m].
        distance: to the nearest configuration known or found [rad; slides divided by the length scale]; 0 at a
            singularity, inf where none is known.
        foot: (n,) that configuration; empty where none is known.
        sigma: σ_r there [1].
        weak: share of the tool's travel there that goes along the direction of σ_r, the one that is lost first, 0 … 1;
            nan where the tool stands still.
    """

    place: Place
    q: Array
    distance: float
    foot: Array
    sigma: float
    weak: float


@dataclass(frozen=True, eq=False)
class Stretch:
    """A part of a path with one verdict and one nearest family.

    Attributes:
        start, end: its ends.
        bracket: two places inside, a zero between them where it is a crossing; its ends on a free stretch.
        verdict: free (proven), crossing, touching or undecided.
        closest: where it is nearest to a singularity; where it reaches one, the configuration.
        evidence: how the verdict is known.
        condition: left-hand side of the condition that changes its sign; "" for other evidence.
        corank: of the singularity reached, by the tolerance; 0 on a free stretch, and where it is undecided.
        lies: all of it is singular, as far as it was evaluated.
        family: id of the family crossed or nearest; "" where there is none.
        name: of that family.
        lost: what is lost where it reaches a singularity.
        null_share: share of the joints' motion there that does not move the task, 0 … 1; nan on a free stretch.
        rates: (n,) largest joint rates of the commanded motion [rad/s, m/s]; empty without times.
        speed_factor: largest factor, at most 1, that brings them within the velocity limits; nan where there are no
            times or no limits.
        slowest: number from 1 of the joint that decides it; 0 where none does.
    """

    start: Place
    end: Place
    bracket: tuple[Place, Place]
    verdict: Verdict
    closest: Closest
    evidence: Evidence
    condition: str = ""
    corank: int = 0
    lies: bool = False
    family: str = ""
    name: str = ""
    lost: tuple[str, ...] = ()
    null_share: float = np.nan
    rates: Array = field(default_factory=partial(np.zeros, 0))
    speed_factor: float = np.nan
    slowest: int = 0


@dataclass(frozen=True, eq=False)
class Violation:
    """A joint limit that a path breaks.

    Attributes:
        what: "rate" or "range" (of the joint's values).
        joint: number from 1.
        place: where the rate is largest, or the first row outside the range.
        amount: the rate as a multiple of its limit [1], or the largest excess over the range [rad, m].
        rows: number of rows outside the range; 0 for a rate.
        proven: the limit is exceeded; False: only a bound exceeds it.
        name: of the family nearest to that place; "" where none is known.
        distance: to it [rad; slides divided by the length scale]; inf where none is known.
        foot: (n,) the configuration of that family nearest to the place; empty where none is known [rad, m].
    """

    what: str
    joint: int
    place: Place
    amount: float
    rows: int
    proven: bool
    name: str
    distance: float
    foot: Array


@dataclass(frozen=True, eq=False)
class Profile:
    """Numbers along the path, at places close enough to draw.

    Attributes:
        position: (P,) rows, from 1, with fractions.
        time: (P,) [s]; None without times.
        distance: (P,) to the nearest known family; nan where none is known.
        family: (P,) index into `ids` of that family; −1 where none is known.
        sigma: (P,) σ_r.
        rates: (P,) largest share of a velocity limit that the commanded motion needs; nan without.
        ids: of the families.
    """

    position: Array
    time: Array | None
    distance: Array
    family: Index
    sigma: Array
    rates: Array
    ids: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class GivenPoses:
    """The poses that a tool path was given as.

    Attributes:
        matrices: (P, 4, 4) of the tip [m].
        times: (P,) [s]; None without times.
        task: that they are reached for.
    """

    matrices: Array
    times: Array | None
    task: Task


@dataclass(frozen=True, eq=False)
class PathCheck(Result):
    """A checked path.

    Attributes:
        robot, task: the arm and its task, its length scale worked out.
        curve: the path.
        rows: number of samples.
        options: how it was checked.
        tolerances: `singular` decides what counts as touching.
        verdict: of the whole path.
        stretches: all parts, worst first.
        violations: joint limits that it breaks, worst first.
        free_share: of the length in joint space, proven free.
        undecided_share, undecided_length, undecided_time: what is undecided: share of the length, length [rad], and
            time [s; None without times].
        margin: what is known of `min_distance`: "kept" (proven), "violated" (a nearer singular configuration was
            found), "not proven"; None where none was asked for.
        evaluations: enclosures spent.
        source: where the families are from: "catalogue", "analysis" or "on the spot".
        remarks: what a reader should know.
        complete: False where it was interrupted.
        profile: for drawings.
        tool: how joint values were found, where poses of the tip were given; else None.
        poses: these poses.
    """

    robot: Robot
    task: Task
    curve: Curve
    rows: int
    options: PathOptions
    tolerances: Tolerances
    verdict: Verdict
    stretches: tuple[Stretch, ...]
    violations: tuple[Violation, ...]
    free_share: float
    undecided_share: float
    undecided_length: float
    undecided_time: float | None
    margin: str | None
    evaluations: int
    source: str
    remarks: tuple[tuple[Remark, Any], ...]
    complete: bool
    profile: Profile
    tool: Followed | None = None
    poses: GivenPoses | None = None
    FILE: ClassVar[str] = "path"

    @property
    def holds(self) -> bool:
        """Proven free, the distance asked for proven to be kept, and every joint limit kept."""
        return self.verdict == FREE and self.complete

    @property
    def clear(self) -> bool:
        """Proven free of singularities, and the distance asked for proven to be kept, whatever joint limits say."""
        passed = self.tool is not None and bool(self.tool.passed)
        met = passed or any(stretch.verdict != FREE for stretch in self.stretches)
        return self.complete and not met and self.margin in (None, "kept") and (self.tool is None or self.tool.complete)

    @property
    def length_scale(self) -> float:
        """Translation is divided by it [m]."""
        return float(self.task.scale(self.robot))

    @property
    def crossings(self) -> tuple[Stretch, ...]:
        """Where it reaches singularities, crossing or touching, in order along the path."""
        met = (stretch for stretch in self.stretches if stretch.verdict in (CROSSING, TOUCHING))
        return tuple(sorted(met, key=attrgetter("start")))

    @property
    def turns(self) -> tuple[FarTurn, ...]:
        """Joints that turn far within a short part of it."""
        return far_turns(self.robot, self.curve)

    @property
    def overruns(self) -> tuple[Overrun, ...]:
        """Joints that exceed their rate limits: how fast, how far and how long; none where that is not proven."""
        if not any(violation.what == "rate" and violation.proven for violation in self.violations):
            return ()
        return overruns(self.robot, self.curve)

    @property
    def fastest(self) -> Fastest | None:
        """The joint that comes nearest to its rate limit; None without times."""
        return fastest(self.robot, self.curve)

    @property
    def sentence(self) -> str:
        """The verdict for people."""
        return text.sentence(self)

    @property
    def notes(self) -> tuple[str, ...]:
        """The remarks, and joints outside their limits, in words."""
        return text.notes(self)

    @property
    def summary(self) -> tuple[str, ...]:
        """The lines that are printed first."""
        return text.summary(self)

    @property
    def why_ended(self) -> str:
        """Why the tool path could not be followed to its end; "" where it was, or joints were given."""
        if self.tool is None:
            return ""
        return why_ended(self.tool, self.robot)

    def sections(
        self, *, deg: bool = True, full: bool = False, mending: Any = None, listed: bool = False,
        target: str | None = None,
    ) -> tuple[Section, ...]:  # fmt: skip
        """As sections of text.

        Args:
            deg: joint angles in degrees.
            full: every crossing and every free stretch.
            mending: remedies of the path, which decide the next step; None: none were computed.
            listed: the remedies are printed in sections of their own; else the best one in a line below the verdict.
            target: file that the path of the best remedy is written to; None: none.
        """
        return text.path_sections(self, deg=deg, full=full, mending=mending, listed=listed, target=target)
