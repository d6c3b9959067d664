"""How are the parts of the explanation of one configuration made when they are read?

Families are known beforehand, or those that the configuration lies on. How far: the nearest found, each known family, a
radius that is proven free. Its entries as plain data have the names of docs/json.md; its other records are in
`results/explained.py`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from rankdrop.codec import Result
from rankdrop.configuration import Cause, Configuration, Rank
from rankdrop.cover.ball import proven_free
from rankdrop.distance.distance import FamilyDistance, family_distances
from rankdrop.errors import OptionError
from rankdrop.families.incidence import Incidence
from rankdrop.families.on_the_spot import families_through
from rankdrop.families.record import Family
from rankdrop.families.searching import Outcome, refine
from rankdrop.local.block import decompose
from rankdrop.local.circuits import LARGEST_CHAIN, MOST_LISTED, circuits_at, make_all
from rankdrop.local.cofactors import hunt
from rankdrop.local.directions import (
    FRAMES,
    FramedDirections,
    lost_directions,
    lost_in_sparsest_frame,
    lost_seen_from,
    readable_basis,
)
from rankdrop.local.ellipsoids import Ellipsoids, ellipsoids
from rankdrop.local.failures import Failures, failures_at
from rankdrop.local.jog import Jog, jog_farther, jog_out
from rankdrop.local.nearest import STARTS, Nearest, nearest_singularity
from rankdrop.local.ordered import ordered_subsets
from rankdrop.local.orientation import Representations, representation_at
from rankdrop.local.rates import Rates, joint_rates
from rankdrop.local.redundant import Redundancy, redundancy
from rankdrop.local.relations import Relation, relations_at
from rankdrop.local.screw_systems import always_singular_reason, systems_at
from rankdrop.local.screws import screw_of
from rankdrop.local.slowest import StraightMotion, slowest_motions
from rankdrop.local.special import Special, specials_at
from rankdrop.local.ways_out import Escape, escape
from rankdrop.questions import ExplainOptions
from rankdrop.results.explained import Blame, Difference, Lost, Next, Summary
from rankdrop.results.far import Far, differences, no_farther
from rankdrop.results.known import shipped_conditions_record
from rankdrop.results.other_singularities import SEEDS, OtherSingularities
from rankdrop.results.slow_family import SlowFamily, slow_family_at
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section, words_of
from rankdrop.task import BASE, TIP, Task, six_rows
from rankdrop.tolerances import ENTRY, NEAR, SMALL
from rankdrop.units import counted_as_radian, counted_length

AT_LIMIT = 1e-3
"""A joint so close to its limit stands at it [rad; slides in length scales]: `escape` does not move it that way."""
_FEW_ENCLOSURES = 160  # of a quick proof: 0.3 ms, as much as the shortest searches

VERDICTS = {
    Cause.LOST: "singular", Cause.NEVER: "always-singular", Cause.NEAR_MISS: "near", Cause.DISTANCE: "near",
    Cause.SMALL: "near", Cause.SLOW: "near", Cause.NONE: "regular",
}  # fmt: skip
"""What decides -> the verdict."""

_TURNS = 1  # whole turns that may bring a joint inside its limits


def _seen_in_axes(
    robot: Robot, q: Array, task: Task, corank: int, sparsest: FramedDirections, axes: str
) -> dict[str, FramedDirections]:
    """What is lost in the axes asked for; in those of a link, where none are, only if they are the simplest."""
    directions = {name: lost_seen_from(robot, q, task, corank, name) for name in FRAMES[:2]}
    fewest = min(int((np.abs(framed.directions) > ENTRY).sum()) for framed in directions.values())
    simpler = int((np.abs(sparsest.directions) > ENTRY).sum()) < fewest
    if axes == "link" or (not axes and simpler):
        directions["link"] = sparsest
    return {name: framed for name, framed in directions.items() if not axes or axes == name}


def _never_possible(configuration: Configuration) -> Array:
    """Readable basis of what is beyond the generic rank: the arm makes it nowhere near."""
    robot, task = configuration.robot, configuration.task
    if task.m == configuration.generic:
        return np.zeros((0, 6))
    singular = bool(configuration.measured.corank)
    beside = configuration.q + np.random.default_rng(0).uniform(-1e-3, 1e-3, robot.n) * singular
    rows = six_rows(decompose(robot, beside, task).u[:, configuration.generic :].T, task)
    rows[:, :3] *= counted_as_radian(robot) / task.scale(robot)
    return readable_basis(rows.T).T


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
    if distance <= near or sigma <= small:
        return "near"
    return "regular"


@dataclass(frozen=True, eq=False, repr=False)
class Explanation(Result):
    """Everything rankdrop can say of one configuration; parts that take long are made when first asked for, and kept.

    Attributes:
        here: the configuration, for a task.
        families: known families of all coranks; empty where there are none.
        source: where they come from: "catalogue", "analysis" or "on the spot".
        options: thresholds and budgets.
    """

    here: Configuration
    families: tuple[Family, ...]
    source: str
    options: ExplainOptions
    FILE: ClassVar[str] = "explanation"

    @property
    def verdict(self) -> str:
        """ "regular", "near", "singular" or "always-singular"."""
        return VERDICTS[self.cause]

    @cached_property
    def cause(self) -> Cause:
        """What decides the verdict."""
        rank, options = self.rank, self.options
        if rank.corank:
            return Cause.LOST
        if rank.always_singular:
            return Cause.NEVER
        far = self.far
        if far.near_miss is not None:
            return Cause.NEAR_MISS
        if far.nearest is not None and far.nearest.distance <= options.near:
            return Cause.DISTANCE
        if float(rank.sigma[rank.generic_rank - 1]) <= options.small:
            return Cause.SMALL
        if any(motion.speed < motion.limit for motion in self.straight):
            return Cause.SLOW
        return Cause.NONE

    @cached_property
    def far(self) -> Far:
        """How far the next singularity is."""
        configuration, options, away = self.here, self.options, self._families_away
        if configuration.measured.corank:
            return Far(configuration, options, None, None, away)
        try:
            nearest = nearest_singularity(
                configuration.robot, configuration.q, configuration.task, limits=options.limits, seed=options.seed,
                seeds=[np.array(point.q) for point in away[:SEEDS]], tolerances=configuration.tolerances,
            )  # fmt: skip
        except OptionError as error:  # a long arm: rank, σ and all that is said at q itself do not need the distance
            return Far(configuration, options, None, None, away, f"{error.what}: {error.got}")
        if float(configuration.measured.sigma[configuration.generic - 1]) <= options.small:
            miss = self._near_miss
        else:
            miss = None
        if nearest is None:
            return Far(configuration, options, None, None, away, near_miss=miss)
        incidences = self.incidences_at(np.array(nearest.q), nearest.corank)
        closer = sorted((no_farther(point, nearest, incidences) for point in away), key=lambda point: point.distance)
        return Far(configuration, options, nearest, incidences[0], tuple(closer), near_miss=miss)

    @property
    def _families_away(self) -> tuple[FamilyDistance, ...]:
        """Families that were reached and do not hold here."""
        options, configuration = self.options, self.here
        targets = [family for family in self.families if family.corank <= options.coranks]
        every = family_distances(
            targets, configuration.robot, configuration.q, configuration.task, limits=options.limits, seed=options.seed
        )
        if configuration.measured.corank:
            least = configuration.tolerances.explained
        else:
            least = -np.inf
        return tuple(point for point in every if least < point.distance < np.inf)

    @property
    def _near_miss(self) -> float | None:
        """σ_r at the nonzero local minimum that a descent from q ends in; None where it ends in a singularity."""
        configuration, seed = self.here, self.options.seed
        descent = refine(
            configuration.robot, configuration.q[None], 1, task=configuration.task, seed=seed,
            tolerances=configuration.tolerances, threads=1,
        )  # fmt: skip
        if descent.outcome[0] == Outcome.NEAR_MISS:
            return descent.smallest_near_miss
        return None

    def incidences_at(self, q: Array, corank: int) -> tuple[Incidence, ...]:
        """The families that a singular configuration q lies on; named on the spot where none of its corank is known."""
        configuration, seed = self.here, self.options.seed
        return families_through(
            configuration.robot, q, configuration.task, corank, self.families, source=self.source, seed=seed,
            tolerances=configuration.tolerances,
        )  # fmt: skip

    @cached_property
    def straight(self) -> tuple[StraightMotion, ...]:
        """The slowest translation and the slowest rotation of the tool."""
        configuration, options = self.here, self.options
        if configuration.generic < configuration.task.m:
            return ()
        limits = {"m/s": options.speed, "rad/s": options.turn_speed}
        return tuple(
            StraightMotion(motion.unit, float(motion.speed[0]), limits[motion.unit],
                           tuple(motion.direction[0].tolist()), int(motion.joint[0]),
                           configuration.robot.variables[int(motion.joint[0]) - 1].name, motion.exact)
            for motion in slowest_motions(configuration.robot, configuration.q[None], configuration.task)
        )  # fmt: skip

    @property
    def reason(self) -> str:
        """What decides the verdict, in a sentence."""
        reason: str = words_of(self).reason_of(self)
        return reason

    @cached_property
    def slow_family(self) -> SlowFamily | None:
        """The family that makes a straight motion slow; None where speed does not decide the verdict."""
        if self.cause != Cause.SLOW:
            return None
        return slow_family_at(self.here, self.far, self.options.seed)

    @property
    def distance(self) -> float | None:
        """To the nearest singular configuration found [rad; slides in length scales]; 0 at one, None where none was."""
        if self.rank.corank:
            return 0.0
        if self.far.nearest is None:
            return None
        return self.far.nearest.distance

    @cached_property
    def summary(self) -> Summary:
        """The answer in facts."""
        configuration, slow = self.here, self.slow_family
        if self.met and slow is None:
            about = self.met[0].family
        else:
            about = None
        if slow is None:
            family, distance, near, singular_q = about, self.distance, None, self.focus
        else:
            family, distance, near, singular_q = slow.family, slow.distance, slow.ideal, slow.q
        place = () if family is None else self._specials_at(singular_q, family.corank)
        known = shipped_conditions_record(configuration.robot, configuration.task, any_tip=True)
        return Summary(
            verdict=self.verdict, cause=self.cause, distance=distance,
            family=family.name if family else "", family_id=family.id if family else "",
            ideal=near is not None, length=near.length if near else 0.0, angle=near.angle if near else 0.0,
            pinned=self._held_joints(about), lost=self._lost_in_base(), slowest=self._slowest(),
            way_out=self.jog.moves, regular_after=self.jog.regular, sigma_after=self.jog.sigma_after,
            next_family=self.next.family.name if self.next.family else "",
            next_distance=self.next.distance, next_searches=self.next.searches,
            source=self.source, exact=self.source == "catalogue" and known is not None,
            radius=self.certified_radius,
            place=place, next_place=self._next_place(place), crosses=self.jog.crosses,
        )  # fmt: skip

    def _next_place(self, place: tuple[Special, ...]) -> tuple[Special, ...]:
        """The parts special at the next singularity, without those that are so here already.

        Where the next family lies so that this singularity holds there too (elbow at 0, then wrist and elbow), those
        found at its own corank may be the stated ones alone: the parts that the family is called by are looked for too.
        """
        family, q = self.next.family, self.next.q
        if family is None or q is None:
            return ()
        stated = {(special.part, special.joint) for special in place}
        found = self._specials_at(q, family.corank)
        more = self._specials_at(q, family.corank + len(place))
        parts = {part.value for part in family.called.parts}
        called = tuple(special for special in more if special.exact and special.part.value in parts)
        for specials in (found, called):
            added = tuple(special for special in specials if (special.part, special.joint) not in stated)
            if added:
                return added
        return found

    def _held_joints(self, family: Family | None) -> tuple[tuple[int, float], ...]:
        """Joints that a family holds at a value, and their values at the focus."""
        if family is None:
            return ()
        return tuple((pin.number, float(self.focus[pin.number - 1])) for pin in family.pinned)

    def _lost_in_base(self) -> tuple[tuple[float, ...], ...]:
        """Lost directions in base axes."""
        base = self.lost.seen.get("base")
        if base is None:
            return ()
        return tuple(tuple(row.tolist()) for row in base.directions)

    def _slowest(self) -> StraightMotion | None:
        """The straight motion that is reported as slow: the slowest; at a near miss one that is slower than asked."""
        for motion in self.straight:
            if self.slow_family is None or motion.speed < motion.limit:
                return motion
        return None

    @cached_property
    def jog(self) -> Jog:
        """The jog after which the verdict is regular; from a regular configuration, the one that raises σ_r most."""
        if self.cause == Cause.NEVER:
            return Jog((), regular=False, sigma_after=None)
        if self.cause == Cause.NONE:
            return jog_farther(self.here, self.options, self._is_proven_free)
        return jog_out(self.here, self.options, self._is_proven_free)

    def _is_proven_free(self, q: Array, radius: float) -> bool:
        """Whether it is proven that no configuration within a radius [rad] of q is singular."""
        try:
            return proven_free(self.robot, q, self.here.task, radius, _FEW_ENCLOSURES)
        except OptionError:  # an arm or a task that has no certificates
            return False

    @cached_property
    def next(self) -> Next:
        """The nearest singularity other than the one that the answer is about, on any sheet."""
        far = self.far
        if self.cause not in (Cause.NONE, Cause.NEVER, Cause.NEAR_MISS):
            return self._others.nearest()
        if far.nearest is None or far.nearest_family is None:
            return Next(None, None, 0 if far.unasked else STARTS[0])
        return Next(far.nearest_family.family, far.nearest.distance, far.nearest.starts, np.array(far.nearest.q))

    @property
    def _others(self) -> OtherSingularities:
        return OtherSingularities(
            configuration=self.here, options=self.options, far=self.far, incidences=self.met, focus=self.focus,
            slow=self.slow_family, families_at=self.incidences_at, specials_at=self._specials_at,
        )  # fmt: skip

    def _specials_at(self, q: Array, corank: int) -> tuple[Special, ...]:
        """The parts special at a configuration, looked for once at each."""
        key = (q.tobytes(), corank)
        if key not in self._specials:
            self._specials[key] = specials_at(self.here.robot, self.here.task, q, corank)
        return self._specials[key]

    @cached_property
    def _specials(self) -> dict[tuple[bytes, int], tuple[Special, ...]]:
        """By configuration and corank: what `_specials_at` has found."""
        return {}

    @property
    def robot(self) -> Robot:
        """The arm that was asked about."""
        return self.here.robot

    @property
    def task(self) -> Task:
        """What the tool is to do, with the length scale that was used."""
        return replace(self.here.task, length_scale=self.length_scale)

    @property
    def q(self) -> Array:
        """(n,) the configuration [rad, m]."""
        return self.here.q

    @property
    def rank(self) -> Rank:
        """Singular values, rank, generic rank, corank, nullity."""
        return self.here.measured

    @property
    def length_scale(self) -> float:
        """Translation rows are divided by it [m]."""
        return float(self.here.task.scale(self.here.robot))

    @cached_property
    def focus(self) -> Array:
        """(n,) what family, relations and blame speak of, q itself or the nearest singular one where q is near it."""
        if self._at_hand is None:
            return self.q
        return np.array(self._at_hand.q)

    @property
    def _at_hand(self) -> Nearest | None:
        if self.cause in (Cause.DISTANCE, Cause.SMALL):
            return self.far.nearest
        return None

    @property
    def _corank(self) -> int:
        if self._at_hand is None:
            return self.rank.corank
        return self._at_hand.corank

    @cached_property
    def met(self) -> tuple[Incidence, ...]:
        """Families that hold at the focus; the first is the one that says most."""
        if self._corank:
            return self.incidences_at(self.focus, self._corank)
        return ()

    @cached_property
    def relations(self) -> tuple[Relation, ...]:
        """What the axes have in common at the focus."""
        return relations_at(self.robot, self.focus)

    @cached_property
    def lost(self) -> Lost:
        """Directions of the tool that are lost at the focus."""
        robot, task = self.here.robot, self.here.task
        never, length = _never_possible(self.here), counted_length(robot)
        lengths = np.repeat([length, 1.0], 3)
        weakest = lost_directions(robot, self.here.q, task, 1)[0]
        corank = self._corank or int(self.cause in (Cause.NEAR_MISS, Cause.SLOW))
        if not corank:
            return Lost(np.zeros((0, 6)), weakest, (), (), None, (), (), never)
        framed = lost_in_sparsest_frame(robot, self.focus, task, corank)
        return Lost(
            directions=lost_directions(robot, self.focus, task, corank),
            weakest=weakest,
            words=framed.sentences(length),
            blocked_words=framed.blocked_sentences(length),
            framed=framed,
            twist_screws=tuple(screw_of(direction * lengths) for direction in framed.directions),
            wrench_screws=tuple(screw_of(np.roll(direction, 3) * lengths) for direction in framed.directions),
            never=never,
            seen=_seen_in_axes(robot, self.focus, task, corank, framed, self.options.frame or ""),
        )

    @cached_property
    def blame(self) -> Blame:
        """Which joints make the dependency at the focus."""
        robot, task = self.here.robot, self.here.task
        q, corank = self.focus, self._corank
        if robot.n <= LARGEST_CHAIN:
            circuits = circuits_at(robot, q, task, most=MOST_LISTED)
        else:
            circuits = ()
        return Blame(
            circuits=circuits,
            smallest=make_all(circuits, robot.n, robot.n - self.here.generic + corank) if corank else (),
            ordered=ordered_subsets(robot, q, task),
            systems=systems_at(robot, q),
            always=always_singular_reason(robot, task),
            complete=robot.n <= LARGEST_CHAIN and len(circuits) < MOST_LISTED,
            hunt=hunt(robot, q, task, self.here.tolerances) if corank else None,
        )

    @cached_property
    def escape(self) -> Escape:
        """Which motions lead out."""
        return escape(self.here, seed=self.options.seed, step=self.options.step)

    @cached_property
    def rates(self) -> Rates:
        """What motion costs the joints."""
        task = self.turned_task
        if task == self.here.task:
            return joint_rates(self.here)
        return joint_rates(self.robot, self.q, task)

    @property
    def turned_task(self) -> Task:
        """The task with rows along the axes asked for; itself where other axes would make it another one."""
        task, frame = self.here.task, self.options.frame
        whole = all(len(block & set(task.rows)) in (0, 3) for block in ({0, 1, 2}, {3, 4, 5}))
        if not frame or not whole:
            return task
        if frame == "link":
            if task.m < 6 or self.lost.framed is None:
                return task
            return replace(task, frame=self.lost.framed.frame)
        return replace(task, frame=replace(task.frame, axes=BASE if frame == "base" else TIP))

    @cached_property
    def failures(self) -> Failures:
        """What the failure of each single joint leaves at q."""
        return failures_at(self.here)

    @cached_property
    def ellipsoids(self) -> Ellipsoids:
        """How motion and force compare by direction."""
        return ellipsoids(self.here)

    @cached_property
    def redundancy(self) -> Redundancy:
        """What motions of the joints leave the tool still."""
        return redundancy(self.here)

    @cached_property
    def representations(self) -> Representations:
        """How far the coordinates of the orientation are from singularities of their own."""
        return representation_at(self.robot, self.q, tolerances=self.here.tolerances)

    @cached_property
    def disagreements(self) -> tuple[str, ...]:
        """Where two methods disagree, one sentence each; empty when all is well."""
        return tuple(map(words_of(self).difference_sentence, self.differences))

    @cached_property
    def differences(self) -> tuple[Difference, ...]:
        """The same as facts."""
        return tuple(differences(self.far, self.escape.single))

    @property
    def nearly_lost(self) -> int:
        """Further singular values that are small but not zero: freedoms nearly lost, by offsets or by nearness."""
        nonzero = self.rank.sigma[: self.rank.rank]
        return int((nonzero <= self.options.small).sum())

    @property
    def outside_limits(self) -> tuple[int, ...]:
        """Joints (from 1) whose value is beyond a limit by more than `AT_LIMIT`."""
        inside = np.maximum(self.robot.lower - self.q, self.q - self.robot.upper) / self._scale
        return tuple(int(i) + 1 for i in np.flatnonzero(inside > AT_LIMIT))

    @property
    def same_inside(self) -> tuple[tuple[int, float], ...]:
        """(joint from 1, value) of joints outside their limits that whole turns bring inside [rad]."""
        out = []
        for number in self.outside_limits:
            lower, upper = self.robot.lower[number - 1], self.robot.upper[number - 1]
            turned = self.q[number - 1] + 2 * np.pi * np.arange(-_TURNS, _TURNS + 1)
            inside = turned[(turned >= lower) & (turned <= upper)]
            if self.robot.periodic[number - 1] and len(inside):
                out.append((number, float(inside[np.abs(inside).argmin()])))
        return tuple(out)

    @property
    def at_limits(self) -> tuple[int, ...]:
        """Joints (from 1) that stand at a limit, to within `AT_LIMIT`."""
        gap = np.minimum(np.abs(self.q - self.robot.lower), np.abs(self.robot.upper - self.q)) / self._scale
        return tuple(int(i) + 1 for i in np.flatnonzero(gap <= AT_LIMIT))

    @property
    def _scale(self) -> Array:
        turning = [joint.unit == "rad" for joint in self.robot.variables]
        return np.where(turning, 1.0, self.length_scale)

    @cached_property
    def certified_radius(self) -> float | None:
        """Radius proven free of singularities [rad]; 0 at a singularity, None where it cannot be certified."""
        if self.rank.corank or self.rank.always_singular:
            return 0.0
        if self.far.certificate is None:
            return None
        return self.far.certificate.radius

    def __repr__(self) -> str:
        return f"<Explanation of {self.robot.name}: {self.verdict}, {self.reason}>"

    def sections(self, *, full: bool = False, parts: Sequence[str] = ()) -> tuple[Section, ...]:
        """The explanation in words: see `rankdrop.text.explanation.sections_of`."""
        sections: tuple[Section, ...] = words_of(self).sections_of(self, full=full, parts=parts)
        return sections
