"""What an explanation holds: its summary, what is lost, who is to blame, what is next, where two methods disagree.

What is lost: directions, the frame in which they are read, screws, and what the arm never makes.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from rankdrop.configuration import Cause
from rankdrop.families.record import Family
from rankdrop.local.circuits import Circuit
from rankdrop.local.cofactors import Hunt
from rankdrop.local.directions import FramedDirections
from rankdrop.local.ordered import OrderedSubset
from rankdrop.local.screw_systems import AlwaysSingular, ScrewSystem
from rankdrop.local.screws import Screw
from rankdrop.local.slowest import StraightMotion
from rankdrop.local.special import Special
from rankdrop.robot.model import Array


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
        way_out: (number, motion) of the one or two joints to jog, one after the other [rad, m]; empty where no such jog
            was found.
        regular_after: the verdict after them is regular, or the generic rank of an arm that is deficient everywhere.
        sigma_after: σ_r after them.
        next_family, next_distance: the nearest singularity other than the one the answer is about, on any sheet.
        next_searches: how many searches looked for it; 0 for none.
        source: where the families come from; `exact`: exact conditions of this arm are shipped.
        radius: proven free of singularities [rad]; None where that is not known.
        place, next_place: the parts of the arm that are special at the singular configuration that the answer is about,
            and those that the next one adds; where it adds none, those of the next one.
        crosses: the jogs of `way_out` pass another singular configuration on the way.
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
    regular_after: bool
    sigma_after: float | None
    next_family: str
    next_distance: float | None
    next_searches: int
    source: str
    exact: bool
    radius: float | None
    place: tuple[Special, ...] = ()
    next_place: tuple[Special, ...] = ()
    crosses: bool = False


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
        circuits: the inclusion-minimal dependent sets of joint screws, small ones first.
        smallest: those that are special to this configuration and carry the loss.
        ordered: GR's singular intervals of the chain.
        systems: screw systems (subalgebras) that hold sets of joints.
        always: why the arm is deficient everywhere; None where it is not.
        complete: False where circuits are too many to list, or the chain is too long to look for them.
        hunt: what Hunt's matrix of cofactors names, held against finite motion; None where nothing is lost.
    """

    circuits: tuple[Circuit, ...]
    smallest: tuple[Circuit, ...]
    ordered: tuple[OrderedSubset, ...]
    systems: tuple[ScrewSystem, ...]
    always: AlwaysSingular | None
    complete: bool = True
    hunt: Hunt | None = None


class DifferenceKind(StrEnum):
    """Which two methods give two answers."""

    GAIN = "gain"
    RADIUS = "radius"
    SEARCH_MISSED = "missed point"
    FAMILIES_MISSED = "beyond the families"


@dataclass(frozen=True, slots=True)
class Difference:
    """Two methods, two answers.

    Attributes:
        kind: `GAIN`: predicted and measured for one joint alone; `RADIUS`: the certified one is beyond a singularity;
            `SEARCH_MISSED`: a family has a point nearer than the search found; `FAMILIES_MISSED`: the search found one
            nearer than every family.
        number, predicted, measured: the joint, from 1, and its gains of rank.
        radius, distance: certified, and to the singularity [rad; slides in length scales].
        family: the one that has a nearer point.
    """

    kind: DifferenceKind
    number: int = 0
    predicted: int = 0
    measured: int = 0
    radius: float = 0.0
    distance: float = 0.0
    family: Family | None = None


@dataclass(frozen=True, slots=True)
class Next:
    """The singularity that is next.

    Attributes:
        family, distance: of the nearest other singular configuration [rad; slides in length scales]; None: none found.
        searches: how many searches looked for it; 0 for none.
        q: (n,) that configuration; None: none found.
    """

    family: Family | None
    distance: float | None
    searches: int
    q: Array | None = None
