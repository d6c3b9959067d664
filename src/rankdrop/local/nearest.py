"""How far: the singular configuration nearest to a given one.

    minimise ‖(q − q0)/s‖₂  subject to  F(q) = U₂ᵀ J V₂ = 0,   s the joint scale,

with the rank kept r = generic rank − k. Every start is driven onto the singular set by block Levenberg–Marquardt and
then walks along it: with A = D in scaled variables and P the projector on its row space, a point of the set is a
candidate where (1 − P)(q − q0) = 0, and from anywhere else a step along −(1 − P)(q − q0) comes nearer. D knows nothing
of joints that do not matter, so these stay where they are.

The distance has many local minima. The first starts say about how far it is; the rest are spent in the ball of that
radius, in which a nearer point must lie.

Where one of six freedoms is lost and no limits bind, the second derivative of F is known in closed form, and 56 starts
take Newton's steps on the condition of Lagrange, towards the set and along it together; of those that get lost four
walk. Only where fewer than eight ends agree, or no more than got lost, 128 more begin, all of which walk. A start that
is given may come from a search of its own, as the nearest point of a known family does. Then the first starts are those
in its ball, and where it stays the nearest, 32 walks that find nothing nearer are enough; as they are where half of
them agree.

What is returned is singular and a local minimum, both checked afresh; that no nearer one exists is likely, not proved
(a certified radius is). Distances are right to 1e-11, but for pieces of the set on which σ has a double zero (Stanford
arm: slide at 0): σ holds half the digits there, and distances are right to 1e-6.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from rankdrop import _core
from rankdrop.configuration import Configuration
from rankdrop.errors import OptionError
from rankdrop.kinematics import LARGEST_SEED, one_configuration, whole_number
from rankdrop.local.block import read_only
from rankdrop.options import Options, option, takes
from rankdrop.problem import Mask, Problem, whole_turns
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import html, words_of
from rankdrop.task import Task, resolve_task
from rankdrop.tolerances import DEFAULT, TIE, Tolerances
from rankdrop.units import in_metres, into_metres, out_of_metres, task_in_metres

STARTS = (128, 512)  # that walk, for corank 1, for more: failures to reach the global minimum are rarer than 1 % then
NEWTON = (24, 32)  # that take Newton's steps before, around q and in the ball in which a nearer point must lie
AGREED = 8  # of these, and more than got lost: no walks begin; the nearest was missed in 2 of 14,000 cases then
FEW = 32  # that walk first, and alone where half of them agree, or a given start stays the nearest
SAME = 1e-6  # starts whose distances differ by less have found the same [rad]
_KEPT = 1024  # starts that are drawn once for all configurations, where there are no more
_RADII = (0.3, 1.0, 2.0, 4.0)  # of the balls of the first starts [rad]
_WIDER = 1.25  # the balls after that, as a multiple of the best distance so far
_LM_ITERATIONS = 60
_EVALUATIONS = 200
_NEARLY = 1e-5  # share of the way that lies along the set at which all walks end: distances are off by its square
_STILL = 1e-9  # of the nearest
_FINEST = 8  # the nearest of them go on to the last digit
_ARRIVED, _LOST = 0, 2  # how the core says that Newton's steps ended
_AGAIN = 4  # of the starts whose steps came to no end, so many walk from there,
_NEAR = 1.5  # where that is no farther than so many times the nearest
_MOST_CONDITIONS = 16  # what the core's singular value decomposition takes on its narrow side

OTHERS = 40
"""Starts of the search for other sheets; points that are known are counted as well."""
_HERE = 1e-3  # the end of a walk is a place that is known where it is so near to it, whole turns aside [rad]
_LOOKED_AT = 8  # of the nearest ends
_AROUND = 6  # starts around an end: where most of them lead nearer, the end is no minimum
_ASIDE = 0.01  # how far from it they are [rad]
_GENERIC = 0.05  # a step off a singular q, whose feet often lie on two sheets at once [rad]
_STEPS = 16  # such steps, of which the one that leads off its sheet is taken
_BACK = (0.1, 0.0)  # shares of that step from which the foot is walked to again
_THROUGH = 1.05  # a sheet through q is no farther than that step, to rounding and curvature

Run = Callable[[Array, float], tuple[Array, ...]]
"""Starts (N, n), and how far ends may be -> ends (C, n), their distances (C,), and what else there is."""

Finest = tuple[Array, float]
"""A nearest point (n,) to the last digit, and its stationarity."""


@dataclass(frozen=True, slots=True)
class Nearest:
    """The nearest singular configuration that was found.

    Attributes:
        distance: ‖(q* − q0)/joint scale‖₂ [rad; metres divided by the length scale].
        q: (n,) q*, not wrapped: q* − q0 is the motion [rad, m].
        delta: (n,) q* − q0, joint by joint [rad, m].
        corank: at q*; at least the one asked for.
        sigma: largest of the singular values that vanish there, evaluated anew [1].
        stationarity: ‖(1 − P)(q* − q0)‖/‖q* − q0‖, P the projector on the row space of D: 0 at a local minimum of the
            distance; with limits, over the joints that do not stand at one.
        starts: number of starts, those given included.
        agreeing: how many of them ended at this distance, to 1e-6.
        within_limits: q* respects the joint limits.
    """

    distance: float
    q: tuple[float, ...]
    delta: tuple[float, ...]
    corank: int
    sigma: float
    stationarity: float
    starts: int
    agreeing: int
    within_limits: bool

    def _repr_html_(self) -> str:
        """For notebooks: the configuration, how far it is, and how it was checked."""
        return html(words_of(self).nearest_sections(self))


@dataclass(frozen=True)
class NearestOptions(Options):
    """What `nearest_singularity` is asked.

    Attributes:
        corank: k: the rank is at most the generic rank − k.
        limits: only configurations inside the joint limits count (q itself may lie outside).
        starts: random starts that walk, q itself the first of them; None for 512 beyond corank 1, and there for 56 that
            take Newton's steps, and 128 that walk where these cannot or disagree.
        seed: of the starts; same seed, same result, on any number of threads and any processor.
    """

    corank: Annotated[int, option("Least corank", ge=1)] = 1
    limits: Annotated[bool, option("Within joint limits")] = False
    starts: Annotated[int, option("Random starts", ge=1, le=1_000_000)] | None = None
    seed: Annotated[int, option("Seed", ge=0, le=LARGEST_SEED)] = 0


@takes(NearestOptions)
def nearest_singularity(
    robot: Robot,
    q: ArrayLike,
    task: Task | str | None = None,
    options: NearestOptions | None = None,
    *,
    seeds: Iterable[ArrayLike] = (),
    tolerances: Tolerances = DEFAULT,
    **given: Any,
) -> Nearest | None:
    """The singular configuration of corank k or more that is nearest to q, by multistart.

    Args:
        robot: the arm.
        q: (n,) the configuration [rad, m].
        task: a Task, a name, or None for the arm's own.
        options: what is asked; keywords `given` of the same names count more.
        seeds: further starts (n,), nearest points of known families say.
        tolerances: `singular` decides, `target` is where points are polished to.

    Returns:
        The nearest one found, distance 0 where q is singular itself; None where no start met a singularity. Near misses
        (small but nonzero minima of σ) never count.

    Raises:
        ConfigurationError: q or a seed is not one configuration of this arm.
        OptionError: corank, starts or seed outside what is allowed, or more than 16 joints and conditions at once.
        TaskError: no such task.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = nearest_singularity(open_robot("pa10"), [0.1, 0.9, 0.4, 0.25, 0.7, 1.1, 0.2])  # AM Table 3: θ4 = 0
        >>> round(found.distance, 12), found.corank, [round(x, 12) + 0.0 for x in found.delta]
        (0.25, 1, [0.0, 0.0, 0.0, -0.25, 0.0, 0.0, 0.0])
    """
    asked = NearestOptions.of(options, given)
    centre, extra = one_configuration(robot, q), [one_configuration(robot, seed_q) for seed_q in seeds]
    resolved = resolve_task(task, robot)
    there, there_task = in_metres(robot), task_in_metres(resolved, robot)
    there_task = replace(there_task, length_scale=there_task.scale(there))  # the reach is worked out once
    problem = Problem(there, there_task, asked.corank, tolerances, asked.limits)
    first = np.array([into_metres(robot, seed_q) for seed_q in extra]).reshape(-1, robot.n)
    nearest = _nearest(problem, into_metres(robot, centre), first, asked)
    if nearest is None or there is robot:
        return nearest
    return _out_of_metres(nearest, robot)


def _nearest(problem: Problem, centre: Array, first: Array, asked: NearestOptions) -> Nearest | None:
    """The nearest singular configuration of an arm in metres; `first` (k, n) are further starts."""
    robot, tolerances = problem.robot, problem.tolerances
    corank, starts = asked.corank, asked.starts
    walks = starts
    if walks is None:
        walks = STARTS[0 if corank == 1 else 1]
    whole_number("corank", corank, 1, problem.generic_rank)
    check_joints(problem)
    walk = _WalkQuestion(Configuration(problem, centre), np.stack([robot.lower, robot.upper]) if asked.limits else None)
    if starts is None and walk.smooth:
        ends = walk.newton(first, asked.seed)
    else:
        ends = _SearchEnds(np.empty((0, robot.n)), np.empty(0), 0, 0)
    if not ends.settled:
        walked, far = walk.walk_from(first, walks, asked.seed)
        ends = ends.join(_SearchEnds(walked, far, 0, len(first) + walks))
    finest = ends.finest or walk.finest(ends.best)
    if finest is None:
        return None
    best, sigma = walk.without_idle_motion(finest[0])
    distance, rank = walk.distance(best), problem.rank
    inside = (robot.lower - tolerances.value <= best) & (best <= robot.upper + tolerances.value)
    return Nearest(
        distance=distance,
        q=tuple(best.tolist()),
        delta=tuple((best - centre).tolist()),
        corank=rank + corank - int((sigma > tolerances.singular).sum()),
        sigma=float(sigma[rank]),
        stationarity=finest[1],
        starts=ends.begun,
        agreeing=ends.agreeing(distance),
        within_limits=bool(inside.all()),
    )


def _out_of_metres(there: Nearest, robot: Robot) -> Nearest:
    """The nearest one of the arm in metres, in the arm's own unit of length."""
    q = tuple(out_of_metres(robot, there.q).tolist())
    delta = tuple(out_of_metres(robot, there.delta).tolist())
    return replace(there, q=q, delta=delta)


@dataclass(frozen=True, slots=True)
class Elsewhere:
    """A singular configuration on another sheet of the singular set.

    Attributes:
        distance: from q to the sheet [rad; metres divided by the length scale]; from a singular q it may be 0.05 rad
            too large where sheets cross.
        q: (n,) a point of the sheet near there [rad, m].
        corank: at that point.
    """

    distance: float
    q: tuple[float, ...]
    corank: int


def other_sheets(
    here: Configuration, known: ArrayLike | None, *, limits: bool = False, seed: int = 0,
    seeds: Iterable[ArrayLike] = (),
) -> tuple[int, Iterator[Elsewhere]]:  # fmt: skip
    """Sheets of the singular set other than that of a known place, nearest to q first.

    From starts all around, walks along the singular set lead to local minima of the distance from q. A singular q is
    left by a small step first: its foot on another sheet often lies on its own sheet too, and walks do not know them
    apart. Every sheet through q is then no farther than that step.

    Args:
        here: the configuration q.
        known: (n,) the singular configuration that a regular q is near to; None where it is near none.
        limits: only configurations inside the joint limits count.
        seed: of the starts.
        seeds: further starts (n,).

    Returns:
        How many starts there were, and what they found. Not finding a sheet is no proof.

    Raises:
        OptionError: too many joints for a search.
    """
    place = here.metric
    robot, task = place.robot, replace(place.task, length_scale=place.task.scale(place.robot))
    problem = Problem(robot, task, 1, here.tolerances, limits)
    check_joints(problem)
    step = _step_off(problem, place.q, seed)
    centre = read_only(place.q + step * bool(here.measured.corank))
    walk = _WalkQuestion(Configuration(problem, centre), np.stack([robot.lower, robot.upper]) if limits else None)
    given = np.array([into_metres(here.robot, np.array(seed_q)) + step for seed_q in seeds]).reshape(-1, robot.n)
    starts = walk.all_around(given, OTHERS, seed)
    if known is None:
        known_here = None
    else:
        known_here = into_metres(here.robot, np.array(known))
    return len(starts), _sheets(walk, here, starts, known_here, seed)


def _step_off(problem: Problem, q: Array, seed: int) -> Array:
    """(n,) a small step off a singular q: of some at random the one that leads farthest off its sheet, by σ_r.

    Along its own sheet a step is of no use: where another sheet crosses that of q, walks around their crossing end on
    either, and a foot there does not pass for a minimum.
    """
    moves = tuple((~problem.idle).tolist())
    steps = _draws(seed, (1, _STEPS), moves)[1]
    size = np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), 1e-300)
    steps = steps * (_GENERIC / size) * problem.scale
    least = problem.sigma(q + steps)[:, problem.rank]
    return np.asarray(steps[int(np.argmax(least))])


def _sheets(
    walk: _WalkQuestion, configuration: Configuration, starts: Array, known: Array | None, seed: int
) -> Iterator[Elsewhere]:
    """The sheets that starts (N, n) lead to, but for that of the known place and those through a singular q."""
    problem, known_places = walk.problem, np.array([] if known is None else [known]).reshape(-1, walk.problem.n)
    if configuration.measured.corank:
        least = _THROUGH * _GENERIC
        found_ends = walk.run(starts)[0]  # Newton's steps from afar lead to the sheet of q, which is so near
    else:
        least = 0.0
        found_ends = walk.minima(starts)
    ends = walk.distinct(found_ends)
    far = problem.length(ends - walk.centre)
    for end in ends[far > least][:_LOOKED_AT]:
        if not walk.is_new(end, known_places) or not walk.is_minimum(end, seed):
            continue
        finest = walk.finest(end[None])
        if finest is not None:
            lost = problem.rank + 1 - int((problem.sigma(finest[0]) > problem.tolerances.singular).sum())
            foot = walk.foot_from(configuration.metric.q, finest[0])
            distance = float(problem.length(foot - configuration.metric.q))
            yield Elsewhere(distance, tuple(out_of_metres(configuration.robot, finest[0]).tolist()), lost)
            known_places = np.concatenate([known_places, finest[0][None]])


def check_joints(problem: Problem) -> None:
    """Refuse a problem that the walks cannot take.

    Raises:
        OptionError: more than 16 joints and conditions at once.
    """
    conditions = (problem.task.m - problem.rank) * (problem.n - problem.rank)
    if min(problem.n, conditions) > _MOST_CONDITIONS:
        raise OptionError(
            "too many joints for this corank", got=f"{problem.n} joints, {conditions} conditions",
            allowed=f"at most {_MOST_CONDITIONS} joints, or as many conditions", mend="a lower corank",
        )  # fmt: skip


@lru_cache(maxsize=16)
def _draws(seed: int, counts: tuple[int, ...], moves: tuple[bool, ...]) -> tuple[Array, ...]:
    """Points (N, n) that fill balls evenly, over the joints that move: first of several radii, then of radius 1."""
    rng = np.random.default_rng(seed)

    def draw_in_balls(radii: Array) -> Array:
        x = rng.standard_normal((len(radii), len(moves))) * np.array(moves)
        share = radii * rng.random((len(radii), 1)) ** (1 / max(1, sum(moves)))
        return np.asarray(x * (share / np.maximum(np.sqrt(np.add.reduce(x * x, axis=1, keepdims=True)), 1e-300)))

    first = draw_in_balls(np.resize(_RADII, (counts[0], 1)))
    return first, *(draw_in_balls(np.ones((count, 1))) for count in counts[1:])


@dataclass(frozen=True, slots=True)
class _SearchEnds:
    """Where starts ended.

    Attributes:
        best: (C, n) some of the ends, the nearest among them.
        distances: (N,) of all ends on the singular set.
        lost: number of starts that took Newton's steps and got lost.
        begun: number of starts.
        finest: the nearest of the ends; None where it has not gone on to the last digit.
        settled: no further start is needed.
    """

    best: Array
    distances: Array
    lost: int
    begun: int
    finest: Finest | None = None
    settled: bool = False

    def join(self, other: _SearchEnds) -> _SearchEnds:
        """With the ends of further starts."""
        best = np.concatenate([self.best, other.best])
        distances = np.concatenate([self.distances, other.distances])
        return _SearchEnds(best, distances, self.lost + other.lost, self.begun + other.begun)

    def agreeing(self, nearest: float) -> int:
        """How many ends are at this distance, those included that are too near, where σ is not quite zero."""
        return int((self.distances <= nearest + SAME).sum())

    def settles(self, nearest: float) -> bool:
        """Whether so many ends agree on the nearest distance that no further start is needed."""
        return self.agreeing(nearest) >= max(AGREED, self.lost + 1)


@dataclass(frozen=True)
class _WalkQuestion:
    """One question, the configuration to stay near to, and the corners (2, n) of the box to stay in."""

    here: Configuration
    box: Array | None

    @cached_property
    def problem(self) -> Problem:
        return self.here.problem

    @cached_property
    def centre(self) -> Array:
        return self.here.q

    def distance(self, q: Array) -> float:
        return float(self.problem.length(q - self.centre))

    def _in_two_rounds(self, run: Run, given: Array, counts: tuple[int, int], seed: int) -> tuple[Array, ...]:
        """What comes of q itself and starts around it, then of starts in the ball in which a nearer point must lie."""
        first, rest = self._draw_starts(counts, seed)
        around = self._ball(first, 1.0)
        around[0] = self.centre
        early = run(np.concatenate([given, around]), np.inf)
        nearest = early[1].min(initial=np.inf)
        late = run(self._nearer(rest, nearest), nearest)
        return tuple(np.concatenate(both) for both in zip(early, late, strict=True))

    def _draw_starts(self, counts: tuple[int, ...], seed: int) -> tuple[Array, ...]:
        """Points of balls around 0, for rounds of so many starts."""
        moves = tuple((~self.problem.idle).tolist())
        if sum(counts) <= _KEPT:
            return _draws(seed, counts, moves)
        return _draws.__wrapped__(seed, counts, moves)

    def _nearer(self, draw: Array, nearest: float) -> Array:
        """Starts in the ball in which a nearer point must lie; none where the centre is singular itself."""
        if nearest == 0.0:
            return draw[:0]
        if np.isfinite(nearest):
            radius = _WIDER * nearest
        else:
            radius = max(_RADII)
        return self._ball(draw, radius)

    def _ball(self, draw: Array, radius: float) -> Array:
        return np.asarray(self.centre + draw * (radius * self.problem.scale))

    @property
    def smooth(self) -> bool:
        """Whether Newton's steps can be taken: rank 5 of six rows, each joint a variable of its own, no limits."""
        robot, rows = self.problem.robot, self.problem.task.rows
        plain = len(robot.joints) == robot.n and not any(joint.mimic for joint in robot.joints)
        return self.box is None and self.problem.rank == len(rows) - 1 == 5 and plain

    def newton(self, given: Array, seed: int) -> _SearchEnds:
        """Ends of starts that take Newton's steps, in rounds until one settles the nearest; few of the last walk."""
        if self.problem.sigma(self.centre)[self.problem.rank] <= self.problem.tolerances.target:
            return _SearchEnds(self.centre[None], np.zeros(1), 0, len(given) + sum(NEWTON), settled=True)
        known = float(self.problem.length(given - self.centre).min(initial=np.inf))
        around, ball, few = self._draw_starts((*NEWTON, FEW), seed)
        around = self._ball(around, 1.0)
        around[0] = self.centre
        if 0.0 < known < np.inf:
            starts = np.concatenate([given, self._nearer(ball, known)])
            early = self._feet(starts, known)
            first = self._settle_nearest(self._gather_ends(early, len(starts)))
            if first.settled:
                return first
            late = self._feet(around, np.inf)
        else:
            early = self._feet(np.concatenate([given, around]), np.inf)
            nearest = float(early[1].min(initial=np.inf))
            late = self._feet(self._nearer(ball, nearest), nearest)
        ends = self._with_lost(*(np.concatenate(both) for both in zip(early, late, strict=True)))
        second = self._settle_nearest(self._gather_ends(ends, len(given) + sum(NEWTON)))
        if second.settled or second.finest is None:
            return second
        return self._confirm_nearest(second, known, self._nearer(few, self.distance(second.finest[0])))

    def _with_lost(self, ends: Array, distances: Array, lost: Array) -> tuple[Array, Array, Array]:
        """Ends, their distances and lost starts, with the walks of lost ones that may come nearer than all ends."""
        far = self.problem.length(lost - self.centre)
        near = far.argsort(kind="stable")[:_AGAIN]
        near = near[far[near] < _NEAR * distances.min(initial=np.inf)]
        if not len(near):
            return ends, distances, lost
        ends_of_lost, again_far = self.run(lost[near])
        return np.concatenate([ends, ends_of_lost]), np.concatenate([distances, again_far]), lost

    def _confirm_nearest(self, ends: _SearchEnds, known: float, starts: Array) -> _SearchEnds:
        """With walks from few starts, which settle the nearest where it was known or half of them agree."""
        walked = self._gather_ends(self.run(starts), len(starts))
        joined = self._settle_nearest(ends.join(walked))
        if joined.finest is None:
            return joined
        nearest = self.distance(joined.finest[0])
        agreed = abs(known - nearest) <= SAME or 2 * walked.agreeing(nearest) >= len(starts)
        return replace(joined, settled=joined.settled or agreed)

    def _gather_ends(self, ends: tuple[Array, ...], begun: int) -> _SearchEnds:
        """Ends (C, n), their distances (C,), and starts that got lost, if any."""
        lost = sum(len(more) for more in ends[2:])
        return _SearchEnds(_best(ends[0], ends[1]), ends[1], lost, begun)

    def _settle_nearest(self, ends: _SearchEnds) -> _SearchEnds:
        """Ends of which the nearest has gone on to the last digit, and whether it needs no further start."""
        finest = self.finest(ends.best)
        if finest is None:
            return ends
        return replace(ends, finest=finest, settled=ends.settles(self.distance(finest[0])))

    def _feet(self, starts: Array, farthest: float) -> tuple[Array, Array, Array]:
        """Where Newton's steps lead, no farther than that (C, n); the distances (C,); and where others got lost."""
        if not len(starts):
            return starts, np.empty(0), starts
        q, met, far = _core.set_feet(
            self.here.chain, self.here.view, starts, centre=self.centre, scale=self.problem.scale,
            turn=np.where(self.problem.robot.periodic, 2 * np.pi, 0.0), farthest=farthest,
        )  # fmt: skip
        arrived = met == _ARRIVED
        return q[arrived], far[arrived], q[met == _LOST]

    def walk_from(self, given: Array, starts: int, seed: int) -> tuple[Array, Array]:
        """The best ends (C, n) of starts that walk, and the distances of all (N,)."""
        few = max(1, starts // 4)
        ends, distances = self._in_two_rounds(self.run, given, (few, starts - few), seed)
        return _best(ends, distances), distances

    def run(self, starts: Array, _farthest: float = np.inf) -> tuple[Array, Array]:
        """Onto the singular set, then along it to the nearest point, to half the digits; without what is not singular.

        Returns:
            (C, n) where starts ended, (C,) their distances.
        """
        if self.box is not None:
            starts = np.clip(starts, *self.box)
        q, _, outcome, *_ = _core.search(self.here.chain, self.here.view, starts, self._search_settings, threads=1)
        near = self._brought_near(q[outcome == 0])
        q, distance, _ = self._walk_along(near, _NEARLY, polish=False)
        q = q[self.problem.singular(q) & np.isfinite(distance)]
        return q, self.problem.length(q - self.centre)

    @cached_property
    def _search_settings(self) -> _core.SearchSettings:
        problem, limit = self.problem, self.problem.tolerances.singular
        return _core.SearchSettings(
            method=0, rank=problem.rank, iterations=_LM_ITERATIONS, singular=limit, target=limit,
            stationary=problem.tolerances.stationary, seed=0, scale=problem.scale, limits=self.box, tie=TIE,
        )  # fmt: skip

    def all_around(self, given: Array, count: int, seed: int) -> Array:
        """(N, n) starts given, and in balls of several radii around the centre."""
        moves = tuple((~self.problem.idle).tolist())
        return np.concatenate([given, self._ball(_draws(seed, (count, 1), moves)[0], 1.0)])

    def minima(self, starts: Array) -> Array:
        """(C, n) where starts (N, n) end that take Newton's steps, or walk where these cannot be taken."""
        if self.smooth:
            return self._feet(starts, np.inf)[0]
        return self.run(starts)[0]

    def distinct(self, ends: Array) -> Array:
        """(C, n) ends without those that repeat another, nearest first."""
        nearest_first = ends[self.problem.length(ends - self.centre).argsort(kind="stable")]
        same = ~self._apart(nearest_first[:, None], nearest_first)
        kept: list[int] = []
        for number in range(len(nearest_first)):
            if not same[number, kept].any():
                kept.append(number)
        return nearest_first[kept]

    def is_new(self, end: Array, places: Array) -> bool:
        """Whether an end (n,) is none of some places (K, n), whole turns aside."""
        return bool(self._apart(end, places).all())

    def _apart(self, ends: Array, places: Array) -> Mask:
        """(...) whether ends (..., n) are other places than some (..., n), whole turns aside."""
        ways = ends - places
        ways = ways - whole_turns(self.problem.robot, ways)
        return self.problem.length(ways) > _HERE

    def foot_from(self, q: Array, end: Array) -> Array:
        """(n,) the foot of q on the sheet of an end (n,): as near to it as walks come that do not leave the sheet.

        The distance of a sheet changes by no more than the centre moves: a walk that comes nearer went to another one.
        """
        way, walk, foot = self.centre - q, self, end
        for share in _BACK if way.any() else ():
            other = _WalkQuestion(Configuration(self.problem, read_only(q + share * way)), self.box)
            moved = float(self.problem.length(other.centre - walk.centre))
            ended, _, _ = other._walk_along(foot[None], _NEARLY, polish=False)
            if not self.problem.singular(ended)[0] or abs(other.distance(ended[0]) - walk.distance(foot)) > moved:
                break
            walk, foot = other, ended[0]
        return foot

    def is_minimum(self, end: Array, seed: int) -> bool:
        """Whether walks that begin around an end (n,) come back to it, or to what is no nearer."""
        moves = tuple((~self.problem.idle).tolist())
        aside = _draws(seed, (1, _AROUND), moves)[1] * (_ASIDE * self.problem.scale)
        distances = self.run(end + aside)[1]
        nearer = int((distances < self.distance(end) - _HERE).sum())
        return 2 * nearer < max(len(distances), 1)

    def finest(self, ends: Array) -> Finest | None:
        """The best of the ends of walks (C, n), after these have gone on to the last digit; its stationarity."""
        if not len(ends):
            return None
        q, distance, stationarity = self._walk_along(ends, _STILL, polish=True)
        sound = self.problem.singular(q) & np.isfinite(distance)
        distance = np.where(sound, self.problem.length(q - self.centre), np.inf)
        number = int(distance.argmin())
        if sound[number]:
            return (q[number], float(stationarity[number]))
        return None

    def _walk_along(self, starts: Array, still: float, *, polish: bool) -> tuple[Array, Array, Array]:
        """Along the singular set to the nearest points (C, n); their distances and stationarities (C,)."""
        problem = self.problem
        settings = _core.NearestSettings(
            rank=problem.rank, evaluations=_EVALUATIONS, singular=problem.tolerances.singular,
            target=problem.tolerances.target, centre=self.centre, scale=problem.scale, limits=self.box,
            still=still, polish=polish,
        )  # fmt: skip
        return _core.nearest(self.here.chain, self.here.view, starts, settings, threads=1)[:3]

    def _brought_near(self, q: Array) -> Array:
        """Whole turns taken off the way from the centre, as far as the limits let them."""
        way = q - self.centre
        if not (np.abs(way) > np.pi).any():
            return np.ascontiguousarray(q)
        near = q - whole_turns(self.problem.robot, way)
        if self.box is not None:
            near = np.where((near < self.box[0]) | (near > self.box[1]), q, near)
        return np.ascontiguousarray(near)

    def without_idle_motion(self, q: Array) -> tuple[Array, Array]:
        """q with motions that are rounding set to nothing, where it is as singular as before; its singular values."""
        still = np.abs(q - self.centre) / self.problem.scale < 1e-7 * self.distance(q)
        plain = np.where(still, self.centre, q)
        if self.box is not None:
            plain = np.clip(plain, *self.box)
        sigma, rank = self.problem.sigma(np.stack([q, plain])), self.problem.rank
        good = sigma[1, rank] <= max(sigma[0, rank], self.problem.tolerances.target)
        if good:
            return (plain, sigma[1])
        return (q, sigma[0])


def _best(ends: Array, distances: Array) -> Array:
    return np.asarray(ends[distances.argsort(kind="stable")[:_FINEST]])
