"""What an explanation of one configuration holds: frozen data."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from rankdrop.certify.ball import LARGEST, Certificate, certified_radius
from rankdrop.configuration import Cause, Configuration, Rank
from rankdrop.errors import OptionError
from rankdrop.families.distance import FamilyDistance
from rankdrop.family.record import Family
from rankdrop.family.which import Incidence
from rankdrop.local.axes import ScrewSystem
from rankdrop.local.circuits import Circuit
from rankdrop.local.directions import FramedDirections, Screw
from rankdrop.local.nearest import Nearest
from rankdrop.local.ordered import Hunt, OrderedSubset
from rankdrop.local.rates import StraightMotion
from rankdrop.questions import ExplainOptions
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import Tolerances

_AS_GOOD = 1e-4  # what a radius may stay below the distance of the singularity that was found, as a share of it
AT_LIMIT = 1e-3
"""A joint so close to its limit stands at it [rad; slides in length scales]: `escape` does not move it that way."""


@dataclass(frozen=True, slots=True)
class Summary:
    """The answer in facts: what the configuration is, what is lost, what to do, what is next, how sure it is.

    Attributes:
        verdict, cause: as in `Explanation`.
        family, family_id: that the answer is about; empty where there is none.
        distance: to it [rad; slides in length scales]; None at a regular configuration without one.
        ideal: it is a family of the ideal arm nearby, and not one of the arm itself; length, angle: what keeps it from
            being the arm's own, the largest differences between the two [m, rad].
        pinned: (number, value) of the joints that the family holds at fixed values [rad, m].
        lost: (6,) directions that are lost, or nearly, in base axes.
        slowest: the slowest straight motion in terms of its limit; None without rate limits.
        way_out: (number, motion) of the joints to move [rad, m]; empty where no way out is known.
        sigma_after: σ_r after that motion.
        next_family, next_distance: the next family, or the nearest singularity of all.
        source: where the families come from; `exact`: exact conditions of this arm are shipped.
        radius: proven free of singularities [rad]; None where that is not known.
    """

    verdict: str
    cause: Cause
    family: str
    family_id: str
    distance: float | None
    ideal: bool
    length: float
    angle: float
    pinned: tuple[tuple[int, float], ...]
    lost: tuple[tuple[float, ...], ...]
    slowest: StraightMotion | None
    way_out: tuple[tuple[int, float], ...]
    sigma_after: float | None
    next_family: str
    next_distance: float | None
    source: str
    exact: bool
    radius: float | None


@dataclass(frozen=True, eq=False)
class Asked:
    """A question in full: the configuration and all that is known before any part is worked out.

    Attributes:
        here: what is asked about.
        families: known families of all coranks; empty where there are none.
        source: where they come from: "catalogue", "analysis" or "on the spot".
        options: thresholds and budgets.
    """

    here: Configuration
    families: tuple[Family, ...]
    source: str
    options: ExplainOptions

    @property
    def robot(self) -> Robot:
        """The arm."""
        return self.here.robot

    @property
    def q(self) -> Array:
        """(n,) the configuration [rad, m]."""
        return self.here.q

    @property
    def task(self) -> Task:
        """What the tool is to do."""
        return self.here.task

    @property
    def rank(self) -> Rank:
        """Singular values, rank, generic rank, corank, nullity."""
        return self.here.measured

    @property
    def tolerances(self) -> Tolerances:
        """Thresholds."""
        return self.here.tolerances

    @property
    def length_scale(self) -> float:
        """Translation rows are divided by it [m]."""
        return float(self.task.scale(self.robot))


@dataclass(frozen=True, eq=False)
class Lost:
    """What cannot be done, or is about to be lost.

    Attributes:
        directions: (k, 6) orthonormal, readable, in the task's frame; twists that cannot be made and, the same numbers
            as (f; τ), wrenches that are carried without joint torque. Near a singularity: those of the nearest singular
            configuration. At a regular configuration: empty.
        weakest: (6,) the direction of σ_r at q, in the task's frame: what is lost first.
        words: one sentence per direction, in the frame where they are sparsest.
        blocked_words: the same directions read as wrenches.
        framed: the directions in that frame, and its name.
        twist_screws, wrench_screws: axis and pitch of each direction, read as twist and as wrench, in that frame.
        never: (p, 6) directions that this arm cannot make anywhere near, where its generic rank is below that of the
            task.
        seen: the same directions in axes of the "base", of the "tool", and of a "link" where they are simpler there.
    """

    directions: Array
    weakest: Array
    words: tuple[str, ...]
    blocked_words: tuple[str, ...]
    framed: FramedDirections | None
    twist_screws: tuple[Screw, ...]
    wrench_screws: tuple[Screw, ...]
    never: Array
    seen: dict[str, FramedDirections] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Blame:
    """Which joints make the dependency.

    Attributes:
        circuits: every inclusion-minimal dependent set of joint screws.
        smallest: those that are special to this configuration and carry the loss.
        ordered: GR's singular intervals of the chain.
        systems: screw systems (subalgebras) that hold sets of joints.
        always: why the arm is deficient everywhere; None where it is not.
        complete: False where the chain is too long to list every circuit.
        hunt: what Hunt's matrix of cofactors names, held against finite motion; None where nothing is lost.
    """

    circuits: tuple[Circuit, ...]
    smallest: tuple[Circuit, ...]
    ordered: tuple[OrderedSubset, ...]
    systems: tuple[ScrewSystem, ...]
    always: str | None
    complete: bool = True
    hunt: Hunt | None = None


@dataclass(frozen=True, eq=False)
class Far:
    """How far the next singularity is.

    Attributes:
        asked: the question.
        nearest: the nearest singular configuration that was found; None where none was.
        nearest_family: a family it belongs to.
        families: distance to each known family that does not hold here, nearest first.
        unasked: why no radius is certified at all; empty where one is.
        near_miss: σ_r of the smallest nonzero local minimum met from here; None unless that is what is near.
    """

    asked: Asked
    nearest: Nearest | None
    nearest_family: Incidence | None
    families: tuple[FamilyDistance, ...]
    unasked: str = ""
    near_miss: float | None = None

    @property
    def certificate(self) -> Certificate | None:
        """Ball proven free of singularities, worked out when it is first asked for; None where the task cannot be
        certified (`uncertified` says why) or the configuration is singular."""
        return self._certified[0]

    @property
    def uncertified(self) -> str:
        """Why there is no certificate; empty where there is one."""
        return self._certified[1]

    @cached_property
    def _certified(self) -> tuple[Certificate | None, str]:
        """Within the limits the nearest singularity may lie farther than one outside them, and bounds nothing."""
        if self.unasked:
            return None, self.unasked
        asked, options = self.asked, self.asked.options
        distance = self.nearest.distance if self.nearest is not None and not options.limits else float("inf")
        try:
            return certified_radius(
                asked.robot, asked.q, asked.task, at_most=min(LARGEST, distance * (1 + 1e-9)),
                enough=distance * (1 - _AS_GOOD), evaluations=options.evaluations,
            ), ""  # fmt: skip
        except OptionError as error:  # a task that cannot be certified
            return None, error.what
