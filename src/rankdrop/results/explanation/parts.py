"""The parts of an explanation: which families, what is lost, how far a singularity is, and the verdict in words.

Families are known beforehand, or those that the configuration lies on. What is lost: directions, the frame in which
they are read, screws, and what the arm never makes. How far: the nearest found, each known family, a radius that is
proven free.

What an explanation of one configuration holds: frozen data.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from rankdrop.certify.ball import LARGEST, Certificate, certified_radius
from rankdrop.configuration import Cause, Configuration, Rank, at
from rankdrop.errors import OptionError
from rankdrop.families.distance import FamilyDistance, family_distances
from rankdrop.families.on_the_spot import name_on_the_spot
from rankdrop.families.search_record import Outcome
from rankdrop.families.searching import refine
from rankdrop.family.incidence import Incidence, families_at
from rankdrop.family.record import Family
from rankdrop.local.axes import ScrewSystem, always_singular_reason, systems_at
from rankdrop.local.block import decompose
from rankdrop.local.circuits import LARGEST_CHAIN, Circuit, circuits_at, make_all
from rankdrop.local.directions import (
    FramedDirections,
    Screw,
    blocked_words,
    lost_directions,
    lost_in_frame,
    lost_in_sparsest_frame,
    readable_basis,
    screw_of,
    words,
)
from rankdrop.local.nearest import Nearest, nearest_singularity
from rankdrop.local.ordered import Hunt, OrderedSubset, hunt, ordered_subsets
from rankdrop.local.rates import StraightMotion, slowest_motions
from rankdrop.local.ways_out import Escape, JointEscape
from rankdrop.questions import ExplainOptions
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import known_analysis, shipped_conditions_record
from rankdrop.robot.ideal import Near, ideal, near_ideal
from rankdrop.robot.model import Array, Robot, geometry
from rankdrop.task import BASE, TIP, Task, six_rows
from rankdrop.tolerances import ENTRY, NEAR, SMALL, Tolerances
from rankdrop.units import counted, counted_length

if TYPE_CHECKING:
    from rankdrop.results.explanation.explanation import Explanation


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
    def length_scale(self) -> float:
        """Translation rows are divided by it [m]."""
        return float(self.here.task.scale(self.here.robot))


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
                asked.here.robot, asked.here.q, asked.here.task, at_most=min(LARGEST, distance * (1 + 1e-9)),
                enough=distance * (1 - _AS_GOOD), evaluations=options.evaluations,
            ), ""  # fmt: skip
        except OptionError as error:  # a task that cannot be certified
            return None, error.what


def known_families(
    robot: Robot, task: Task, analysis: Analysis | None, tolerances: Tolerances
) -> tuple[tuple[Family, ...], str]:
    """Known families and where they come from: the analysis given, else the atlas that is shipped, else nowhere.

    Raises:
        OptionError: the analysis is about another arm or other rows.
    """
    if analysis is None:
        known = known_analysis(robot, task, any_tip=True)
        return (known.families, "catalogue") if known else ((), "on the spot")
    if not isinstance(analysis, Analysis):
        raise OptionError("an analysis is needed", got=repr(analysis)[:80], allowed="an Analysis, or None")
    mine, other = (geometry(one, tip=task.m < 6) for one in (robot, analysis.robot))
    if mine.shape != other.shape or np.abs(mine - other).max() > tolerances.value:
        raise OptionError("the analysis is about another arm", got=analysis.robot.name, allowed=robot.name)
    if analysis.task.rows != task.rows or analysis.task.frame != task.frame:
        raise OptionError("the analysis is about another task", got=analysis.task.name, allowed=task.name)
    return analysis.families, "analysis"


def incidences_at(asked: Asked, q: Array, corank: int) -> tuple[Incidence, ...]:
    """The families that a singular configuration q lies on; named on the spot where none of its corank is known."""
    robot, task, options = asked.here.robot, asked.here.task, asked.options
    found = families_at(asked.families, robot, q, task, asked.here.tolerances, asked.source)
    if found and found[0].family.corank >= corank:
        return found
    local = name_on_the_spot(robot, q, task, corank, seed=options.seed)
    return (Incidence(local, 0.0, "on the spot"), *found)


def lost_of(asked: Asked, focus: Array, corank: int) -> Lost:
    """What is lost at the focus (`corank` directions; none where it is 0), and what is weakest at q."""
    robot, q, task, rank, options = asked.here.robot, asked.here.q, asked.here.task, asked.here.measured, asked.options
    never = _never(robot, q, task, rank)
    empty = np.zeros((0, 6))
    weakest = lost_directions(robot, q, task, 1)[0] if rank.generic_rank else np.zeros(6)
    if not corank:
        return Lost(empty, weakest, (), (), None, (), (), never)
    length = counted_length(robot)
    framed = lost_in_sparsest_frame(robot, focus, task, corank)
    return Lost(
        directions=lost_directions(robot, focus, task, corank),
        weakest=weakest,
        words=tuple(words(one, framed.name, length) for one in framed.directions),
        blocked_words=tuple(blocked_words(one, framed.name, length) for one in framed.directions),
        framed=framed,
        twist_screws=tuple(screw_of(one).in_lengths(length) for one in framed.directions),
        wrench_screws=tuple(screw_of(np.roll(one, 3)).in_lengths(length) for one in framed.directions),
        never=never,
        seen=_seen(robot, focus, task, corank, framed, options.frame or ""),
    )


FRAMES = ("base", "tool", "link")
"""In whose axes a motion can be told."""


def _seen(
    robot: Robot, q: Array, task: Task, corank: int, sparsest: FramedDirections, asked: str
) -> dict[str, FramedDirections]:
    """What is lost in the axes asked for; in those of a link, where none are, only if they are the simplest."""
    found = {name: lost_seen_from(robot, q, task, corank, name) for name in FRAMES[:2]}
    fewest = min(int((np.abs(one.directions) > ENTRY).sum()) for one in found.values())
    simpler = int((np.abs(sparsest.directions) > ENTRY).sum()) < fewest
    if asked == "link" or (not asked and simpler):
        found["link"] = sparsest
    return {name: framed for name, framed in found.items() if not asked or asked == name}


def lost_seen_from(robot: Robot, q: Array, task: Task, corank: int, frame: str) -> FramedDirections:
    """What is lost in axes of the base or of the tool, at the task's point, or in those of the sparsest frame.

    Args:
        robot, q, task, corank: as in `lost_directions`.
        frame: one of `FRAMES`.
    """
    if frame == "link":
        return lost_in_sparsest_frame(robot, q, task, corank)
    return lost_in_frame(robot, q, task, corank, replace(task.frame, axes=BASE if frame == "base" else TIP))


def checked_frame(frame: str | None) -> str:
    """The axes asked for; empty for None.

    Raises:
        OptionError: there are no such axes.
    """
    if frame is not None and frame not in FRAMES:
        raise OptionError("these are no axes", where="frame", got=repr(frame), allowed=", ".join(FRAMES))
    return frame or ""


def turned_task(task: Task, frame: str | None, lost: Lost) -> Task:
    """The same task with rows along the axes that were asked for; as it is where other axes would make it another one.

    Args:
        task: the rows that matter.
        frame: "base", "tool", "link", or None for the task's own axes.
        lost: gives the axes of the link.
    """
    whole = all(len(block & set(task.rows)) in (0, 3) for block in ({0, 1, 2}, {3, 4, 5}))
    if not frame or not whole:
        return task
    if frame == "link":
        other = task.frame if lost.framed is None else lost.framed.frame
        return replace(task, frame=other) if task.m == 6 else task
    return replace(task, frame=replace(task.frame, axes=BASE if frame == "base" else TIP))


def _never(robot: Robot, q: Array, task: Task, rank: Rank) -> Array:
    """Readable basis of what is beyond the generic rank: the arm makes it nowhere near q."""
    beyond = task.m - rank.generic_rank
    if beyond == 0:
        return np.zeros((0, 6))
    away = q + np.random.default_rng(0).uniform(-1e-3, 1e-3, robot.n) if rank.corank else q
    rows = np.zeros((beyond, 6))
    rows[:, list(task.rows)] = decompose(robot, away, task).u[:, rank.generic_rank :].T
    rows[:, :3] *= counted(robot) / task.scale(robot)
    return readable_basis(rows.T).T


_SEEDS = 8  # nearest points of families that the search begins from


def how_far(asked: Asked) -> Far:
    """Distances from the configuration asked about."""
    away, rank, options = _families_away(asked), asked.here.measured, asked.options
    if rank.corank:
        return Far(asked, None, None, away, "the configuration is singular")
    try:
        nearest = nearest_singularity(
            asked.here.robot, asked.here.q, asked.here.task, limits=options.limits, seed=options.seed,
            seeds=tuple(one.q for one in away[:_SEEDS]), tolerances=asked.here.tolerances,
        )  # fmt: skip
    except OptionError as error:  # a long arm: rank, σ and all that is said at q itself do not need the distance
        return Far(asked, None, None, away, f"{error.what}: {error.got}")
    miss = _near_miss(asked) if float(rank.sigma[rank.generic_rank - 1]) <= options.small else None
    if nearest is None:
        return Far(asked, None, None, away, near_miss=miss)
    there = incidences_at(asked, np.array(nearest.q), nearest.corank)
    closer = sorted((_no_farther(one, nearest, there) for one in away), key=lambda one: one.distance)
    return Far(asked, nearest, there[0], tuple(closer), near_miss=miss)


def _families_away(asked: Asked) -> tuple[FamilyDistance, ...]:
    """Families that were reached and do not hold here."""
    options, here = asked.options, asked.here
    targets = [one for one in asked.families if one.corank <= options.coranks]
    every = family_distances(targets, here.robot, here.q, here.task, limits=options.limits, seed=options.seed)
    least = here.tolerances.explained if here.measured.corank else -np.inf
    return tuple(one for one in every if least < one.distance < np.inf)


def blame_at(asked: Asked, q: Array, corank: int) -> Blame:
    """Which joints make the dependency at q, where `corank` freedoms are lost."""
    robot, task = asked.here.robot, asked.here.task
    dependencies = robot.n - asked.here.measured.generic_rank + corank
    few = robot.n <= LARGEST_CHAIN
    circuits = circuits_at(robot, q, task) if few else ()
    return Blame(
        circuits=circuits,
        smallest=make_all(circuits, robot.n, dependencies) if corank else (),
        ordered=ordered_subsets(robot, q, task),
        systems=systems_at(robot, q),
        always=always_singular_reason(robot, task),
        complete=few,
        hunt=hunt(robot, q, task, asked.here.tolerances) if corank else None,
    )


_AGREE = 1e-6  # distances that differ by less are the same: σ of second order leaves half the digits [rad]


def disagreements(far: Far, single: Sequence[JointEscape]) -> Iterator[str]:
    """Two methods, two answers: on what a joint alone regains, and on how far."""
    for one in single:
        if not one.agrees:
            yield (
                f"joint {one.number} alone: a rank gain of {one.gain} was predicted, finite motion gains "
                f"{one.measured_gain}"
            )
    nearest, certificate = far.nearest, far.certificate
    if nearest is not None and certificate is not None and certificate.radius > nearest.distance * (1 + 1e-8):
        yield f"certified radius {certificate.radius:.6g} beyond a singularity at {nearest.distance:.6g}"
    if nearest is not None and far.families and all(one.family.named for one in far.families):
        first = min(far.families, key=lambda one: one.distance)
        if first.distance < nearest.distance - _AGREE:
            yield f"the search missed a nearer point of family {first.family.id} ({first.family.name})"
        elif not first.distance <= nearest.distance + _AGREE:
            yield "the search found a singularity nearer than every family"


def _no_farther(record: FamilyDistance, nearest: Nearest, there: Sequence[Incidence]) -> FamilyDistance:
    """A family through the point that the search found is no farther away than that point."""
    through = any(met.family is record.family for met in there)
    if not through or record.distance <= nearest.distance:
        return record
    return replace(record, distance=nearest.distance, q=nearest.q, delta=nearest.delta, sigma=nearest.sigma)


def _near_miss(asked: Asked) -> float | None:
    """σ_r at the nonzero local minimum that a descent from q ends in; None where it ends in a singularity."""
    here = asked.here
    found = refine(here.robot, here.q[None, :], 1, task=here.task, seed=asked.options.seed, tolerances=here.tolerances,
                   threads=1)  # fmt: skip
    return found.smallest_near_miss if found.outcome[0] == Outcome.NEAR_MISS else None


def verdict_of(asked: Asked, far: Far, slow: Sequence[StraightMotion]) -> tuple[str, Cause]:
    """The verdict and what decides it; see `rankdrop.verbs.explain`.

    Args:
        asked: the question.
        far: distances.
        slow: straight motions that are slower than was asked.
    """
    rank, options = asked.here.measured, asked.options
    r = rank.generic_rank
    if rank.corank:
        return "singular", Cause.LOST
    if rank.always_singular:
        return "always-singular", Cause.NEVER
    if far.near_miss is not None:
        return "near", Cause.NEAR_MISS
    if far.nearest is not None and far.nearest.distance <= options.near:
        return "near", Cause.DISTANCE
    if r and float(rank.sigma[r - 1]) <= options.small:
        return "near", Cause.SMALL
    return ("near", Cause.SLOW) if slow else ("regular", Cause.NONE)


def straight_motions(asked: Asked) -> tuple[StraightMotion, ...]:
    """The slowest translation and the slowest rotation; none without rate limits, or where the arm lacks a freedom."""
    robot, rank, options = asked.here.robot, asked.here.measured, asked.options
    if rank.generic_rank < asked.here.task.m:
        return ()
    limits = {"m/s": options.speed, "rad/s": options.turn_speed}
    found = []
    for one in slowest_motions(robot, asked.here.q[None], asked.here.task):
        x, y, z = one.direction[0].tolist()
        number = int(one.joint[0])
        found.append(StraightMotion(one.unit, float(one.speed[0]), limits[one.unit], (x, y, z), number,
                                    robot.variables[number - 1].name, one.exact))  # fmt: skip
    return tuple(found)


SlowFamily = tuple[Family, float, Near | None]
"""The family that makes a motion slow, the distance to it, and the ideal arm nearby where it is that arm's family."""
_ALIGNED = 0.7  # cosine between a slow motion and what a family loses from which the family explains it


def slow_family(asked: Asked, far: Far) -> SlowFamily | None:
    """The family that makes a straight motion slow: one of the ideal arm nearby if that is nearer than the arm's own.

    Of the arm's own families it is the nearest whose lost motions point along the slow one, else the nearest of all.
    """
    own = far.nearest.distance if far.nearest is not None else np.inf
    near = near_ideal(asked.here.robot)
    if near is not None:
        model = _ideal_arm(asked.here.robot, near.tolerance.length, near.tolerance.angle)
        task = replace(asked.here.task, length_scale=asked.length_scale)
        try:
            there = nearest_singularity(model, asked.here.q, task, seed=asked.options.seed)
        except OptionError:  # too many joints for a search
            there = None
        if there is not None and there.distance < own:
            families, source = known_families(model, task, None, asked.here.tolerances)
            here = at(model, asked.here.q, task, asked.here.tolerances)
            question = replace(asked, here=here, families=families, source=source)
            family = incidences_at(question, np.array(there.q), there.corank)[0].family
            return family, there.distance, near
    if far.nearest is None or far.nearest_family is None:
        return None
    slow = [one.normal[0] for one in slowest_motions(asked.here.robot, asked.here.q[None], asked.here.task)]
    nearest = (far.nearest.distance, far.nearest.q, far.nearest.corank, far.nearest_family.family)
    candidates = [nearest, *((one.distance, one.q, one.family.corank, one.family) for one in far.families)]
    explains = (one for one in candidates if any(_lost_along(asked, one[1], one[2], y) for y in slow))
    distance, _, _, family = next(explains, nearest)
    return family, distance, None


@lru_cache(maxsize=16)
def _ideal_arm(robot: Robot, length: float | None, angle: float | None) -> Robot:
    """The ideal arm nearby, made once: it costs more than the rest of an explanation."""
    return ideal(robot, length=length, angle=angle)[0]


def _lost_along(asked: Asked, q: Sequence[float], corank: int, normal: Array) -> bool:
    """Whether a singular configuration loses a motion along `normal`, in the rows of the task [m/s, rad/s]."""
    lost = lost_directions(asked.here.robot, q, asked.here.task, corank)
    unit = six_rows(normal, asked.here.task) / np.linalg.norm(normal)
    return bool(np.linalg.norm(lost @ unit) >= _ALIGNED)


def summary_of(explanation: Explanation) -> Summary:
    """The answer in facts."""
    asked, far, rank = explanation.asked, explanation.far, explanation.rank
    slow, met = explanation.slow_family, explanation.met
    nearest = None if far.nearest_family is None else far.nearest_family.family
    about = met[0].family if met and slow is None else None
    family, distance, near = (about, explanation.distance, None) if slow is None else slow
    base = explanation.lost.seen.get("base")
    rest = [one for one in far.families if about is None or one.family.name != about.name]
    following, away = (rest[0].family, rest[0].distance) if rest else (None, None)
    if about is None and slow is None and far.nearest is not None:
        following, away = nearest, far.nearest.distance
    moves, after = best_way_out(explanation.escape, rank) if rank.generic_rank else ((), None)
    slowest = [one for one in explanation.straight if slow is None or one.speed < one.limit]
    turned = explanation.focus if about is not None else explanation.q
    known = shipped_conditions_record(asked.here.robot, asked.here.task, any_tip=True)
    return Summary(
        verdict=explanation.verdict, cause=explanation.cause, family=family.name if family else "",
        family_id=family.id if family else "", distance=distance, ideal=near is not None,
        length=near.length if near else 0.0, angle=near.angle if near else 0.0,
        pinned=() if about is None else tuple((pin.number, float(turned[pin.number - 1])) for pin in about.pinned),
        lost=() if base is None else tuple(tuple(row.tolist()) for row in base.directions),
        slowest=slowest[0] if slowest else None, way_out=moves,
        sigma_after=after, next_family=following.name if following else "", next_distance=away, source=asked.source,
        exact=asked.source == "catalogue" and known is not None,
        radius=explanation.certified_radius,
    )  # fmt: skip


def best_way_out(out: Escape, rank: Rank) -> tuple[tuple[tuple[int, float], ...], float | None]:
    """The joint to move, or joints where none alone helps, with their motions [rad, m], and σ_r then."""
    best = max((abs(one.rate) for one in out.single), default=0.0)
    for one in out.single:
        worth = rank.corank or abs(one.rate) > max(IDLE * best, NO_RATE)
        if one.order is not None and worth and one.within_limits and abs(one.step) >= NO_RATE:
            return ((one.number, one.step),), one.sigma_after
    several = out.best_direction
    if not (several.within_limits and several.restores):
        return (), None
    delta = np.array(several.delta) * several.step
    large = [number for number in several.numbers if abs(delta[number - 1]) >= SHARE * np.abs(delta).max()]
    return tuple((number, float(delta[number - 1])) for number in large), several.sigma_after


IDLE = 0.01
"""Away from a singularity: a joint whose rate is below this share of the best does not help."""
NO_RATE = 1e-12
"""A rate or a step below it is rounding."""
SHARE = 0.02
"""A joint that moves less than this share of the fastest is left out of a direction."""


def first_verdict(corank: int, generic_rank: int, smallest: int, sigma: float, distance: float, near: float = NEAR,
                  small: float = SMALL) -> str:  # fmt: skip
    """The verdict by what a monitor measures, before any search.

    Args:
        corank: at the configuration.
        generic_rank: r.
        smallest: min(m, n) of the task and the arm.
        sigma: σ_r [1].
        distance: to the nearest singular configuration known [rad].
        near, small: as in `rankdrop.verbs.explain`.
    """
    if corank:
        return "singular"
    if generic_rank < smallest:
        return "always-singular"
    return "near" if distance <= near or sigma <= small else "regular"
