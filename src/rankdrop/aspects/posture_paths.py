"""`aspects_of`: solutions of the inverse, the aspects they lie in, and a way from one to another without singularity.

An aspect is a connected set of regular configurations. An arm is *cuspidal* when two solutions of one pose lie in the
same aspect: it can change its posture without a singularity (Innocenti and Parenti-Castelli 1998). That is claimed only
with a path that is proven free; the contrary only where `exact.decide_postures` proves it.

Paths are found on a roadmap of the joint space: random configurations are joined with near ones wherever the straight
way between keeps the sign of det J at its sample points. A way is the one whose smallest |det J| is the largest that
the roadmap has, made shorter where that does not cost half of it. Whatever comes out is then proven free, or is not
used: that no way is found says nothing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from heapq import heappop, heappush
from itertools import combinations, pairwise, product
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.aspects.arm import count_of_arm
from rankdrop.aspects.count import AspectCount
from rankdrop.aspects.limits import count_within_limits
from rankdrop.codec import Result
from rankdrop.cover.setting import settings_for
from rankdrop.errors import ConfigurationError, TaskError
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.posture_changes import CUSPS, OPEN, Decision
from rankdrop.exact.signs import Signs, configuration_flags
from rankdrop.kinematics import check_robot, one_configuration, pose
from rankdrop.local.block import generic_rank, joint_scale, limit_box, sample, sampling_box
from rankdrop.options import takes
from rankdrop.path.check.prove import prove
from rankdrop.path.curve import Index, curve
from rankdrop.path.read.csv_file import csv_text
from rankdrop.poses.inverse import check_square, determinants, joint_difference, near_and_within, regular, solutions
from rankdrop.poses.postures import decide_exactly
from rankdrop.problem import Mask
from rankdrop.questions import AspectsOptions
from rankdrop.results.aspect_summary import CUSPIDAL as CUSPIDAL
from rankdrop.results.aspect_summary import NOT_ASKED as NOT_ASKED
from rankdrop.results.aspect_summary import NOT_CUSPIDAL as NOT_CUSPIDAL
from rankdrop.results.aspect_summary import NOT_FOUND as NOT_FOUND
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.task import Task, resolve_task
from rankdrop.text import aspects as text
from rankdrop.tolerances import DEFAULT
from rankdrop.units import in_metres, into_metres, out_of_metres, task_in_metres

_RINGS = (0.05, 0.1, 0.2, 0.3, 0.4)  # distances from a cusp at which poses are tried [rad]
_AROUND = 4  # poses on each


EVALUATIONS = 5_000
"""Enclosures that one proof of a way may cost; those that succeed take some dozens."""
_NODES = {1: 100, 2: 400, 3: 800}  # by how many joints det J depends on
_MOST_NODES = 1_500
_NEIGHBOURS = 12
_STEP = 0.08  # between sample points of a straight way [rad; slides scaled]
_FINER = ((2e-2, 10), (2e-4, 100))
"""Below such a share of the usual |det J| so many times as many sample points: two sheets of the singular set near to
each other leave the sign on their far side as it was, and values of the second order between."""
_PART = 200_000  # configurations looked at together
_TRIES = 3  # ways that are tried where the proof of one fails
_SHORTER = 0.5  # share of the smallest |det J| that a shorter way keeps


@dataclass(frozen=True, eq=False)
class Change:
    """A path between two solutions of one pose, or any two configurations, proven free of singularities.

    Attributes:
        q: (T, n) corners [rad, m], straight lines in joint space between them; the end is a solution up to whole turns.
        clearance: the smallest |det J| at sample points of it, J without unit.
        evaluations: enclosures that the proof took.
        own: it starts at the configuration that was asked about.
    """

    q: Array
    clearance: float
    evaluations: int
    own: bool = False


@dataclass(frozen=True, eq=False)
class SolvedPose:
    """One pose: the solutions of its inverse that were found.

    Attributes:
        q: (k, n) regular solutions [rad, m]; the first is the configuration whose pose it is.
        aspect: (k,) numbers from 1; equal ones are joined by paths proven free, or by the proven number of aspects.
            Solutions of different numbers are proven to be in different aspects where a sign differs, or the arm is
            proven not to be cuspidal.
        sign: (k,) of det J.
        names: (k,) the signs of the factors of det J where they tell all solutions apart ("elbow +, wrist −"), else
            the sign of det J.
        near_cusp: the pose was chosen next to a cusp, not at random.
        flags: (k,) signs of the factors of det J at each solution; () where they are not known.
    """

    q: Array
    aspect: tuple[int, ...]
    sign: tuple[int, ...]
    names: tuple[str, ...]
    near_cusp: bool
    flags: tuple[tuple[int, ...], ...] = ()

    @property
    def per_aspect(self) -> tuple[int, ...]:
        """Number of solutions in each aspect, most first."""
        return tuple(sorted(Counter(self.aspect).values(), reverse=True))


@dataclass(frozen=True, eq=False)
class Postures(Result):
    """What was found.

    Attributes:
        robot, task, options: what was asked; with a configuration that is one pose.
        count: how many aspects the arm has, joint limits ignored.
        decision: what is known without a search.
        solved: the poses.
        change: a path from one solution of a pose to another; None where none was found or none exists.
        chain: the arm over the exact ring, which says what was rounded; None where there is none.
        complete: False after Ctrl-C.
        within: how many regions are left within the joint limits; None where limits were not asked for.
    """

    robot: Robot
    task: Task
    options: AspectsOptions
    count: AspectCount
    decision: Decision
    solved: tuple[SolvedPose, ...]
    change: Change | None
    chain: Chain | None
    complete: bool
    within: AspectCount | None = None
    FILE: ClassVar[str] = "aspects"

    @property
    def verdict(self) -> str:
        """`CUSPIDAL` (a path, or two solutions of one pose in one aspect), `NOT_CUSPIDAL` (proven), `NOT_FOUND`;
        `NOT_ASKED` of an arm with more or fewer joints than rows.
        """
        if self.robot.n != self.task.m:
            return NOT_ASKED
        if self.change is not None or self.shared is not None:
            return CUSPIDAL
        if self.decision.impossible:
            return NOT_CUSPIDAL
        return NOT_FOUND

    @property
    def shared(self) -> SolvedPose | None:
        """A pose of which two solutions lie in one aspect because all factors have equal signs there, and the number of
        aspects is proven.
        """
        if not self.count.signs_decide or self.options.limits:  # the number is of joints that turn as they like
            return None
        return next((sample for sample in self.solved if len(set(sample.flags)) < len(sample.flags)), None)

    @property
    def sentence(self) -> str:
        """The verdict and what it rests on."""
        return text.aspects_sentence(self)

    def sections(self, *, deg: bool = False) -> Iterator[Section]:
        """For people: the verdict first and last."""
        return text.aspects_sections(self, deg=deg)

    def path_csv(self) -> str:
        """The path as a file that `rankdrop path` reads: joints by name, one corner a line [rad, m].

        Empty where there is no path.
        """
        names = [joint.name for joint in self.robot.variables]
        if self.change is None:
            return ""
        return csv_text(names, self.change.q)


@takes(AspectsOptions)
def aspects_of(
    robot: Robot,
    task: Task | str | None = None,
    *,
    q: ArrayLike | None = None,
    options: AspectsOptions | None = None,
    progress: Callable[[int, int], None] | None = None,
    **given: Any,
) -> Postures:
    """Whether an arm can change its posture without a singularity, and solutions of poses by their aspects.

    Args:
        robot: the arm. With more or fewer joints than rows the aspects are counted, and no postures are compared.
        task: name, rows or Task; None is the task the arm is made for.
        q: (n,) configuration whose pose is solved [rad, m]; None: the poses of random configurations.
        options: how hard is searched; its fields are taken as keywords as well.
        progress: called as progress(poses solved, poses to solve).

    Returns:
        The verdict with its proof, each pose with its solutions and aspects, and a path where there is one.

    Raises:
        ConfigurationError: q is not one configuration of this arm, or singular.
        OptionError: an option outside what is allowed.
        TaskError: no such task; the arm is redundant for it, or singular everywhere; rows not in the base's axes.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = aspects_of(open_robot("crx10ia"), q=[0.2, 0.9, 0.4, -0.6, 0.9, 0.0], starts=300)
        >>> found.verdict, found.solved[0].per_aspect, found.change.q.shape[1]
        ('cuspidal', (4, 4), 6)
        >>> found = aspects_of(open_robot("puma560"), q=[0.1, 0.5, 0.3, 0.2, 0.9, 0.6])
        >>> found.verdict, found.solved[0].per_aspect
        ('not cuspidal', (1, 1, 1, 1, 1, 1, 1, 1))
    """
    check_robot(robot)
    how = AspectsOptions.of(options, given)
    resolved = resolve_task(task, robot)
    if robot.n != resolved.m and q is None:
        count, numeric = count_of_arm(robot, resolved)
        within = _limited_count(robot, numeric, how)
        return Postures(robot, resolved, how, count, Decision(OPEN, "joints"), (), None, None, True, within)
    check_square(robot, resolved)
    there, there_task = in_metres(robot), task_in_metres(resolved, robot)
    if generic_rank(there, there_task) < there_task.m:
        raise TaskError("the arm is singular at every configuration", got=f"{robot.name}, {resolved.name}")
    start = None
    if q is not None:
        start = _regular_start(robot, there, there_task, q)
    decision, signs, chain = decide_exactly(robot, resolved)
    count, numeric = count_of_arm(robot, resolved)
    if start is None:
        how = replace(how, most=max(how.poses, how.most))
    else:
        how = replace(how, poses=1, most=1)
    places = _places(there, there_task, how, start, decision)
    solved: list[SolvedPose] = []
    change: Change | None = None
    complete = True
    try:
        roadmap = Roadmap(there, there_task, how.seed, how.limits)
        by_signs = count.signs_decide and not how.limits
        for solved_pose, best in _solve_poses(roadmap, places, how, decision, progress, by_signs=by_signs):
            named = _name_solutions(robot, solved_pose, signs)
            solved.append(_by_signs(named, count, numeric, limits=how.limits))
            change = best
    except KeyboardInterrupt:
        complete = False
    if change is not None:
        change = replace(change, q=out_of_metres(robot, change.q))
    within = _limited_count(robot, numeric, how)
    return Postures(robot, resolved, how, count, decision, tuple(solved), change, chain, complete, within)


def _regular_start(robot: Robot, there: Robot, task: Task, q: ArrayLike) -> Array:
    """A configuration in metres.

    Args:
        robot: the arm that q is of.
        there, task: the same in metres.
        q: (n,) [rad, m].

    Raises:
        ConfigurationError: q is not one configuration of this arm, or singular.
    """
    start = into_metres(robot, one_configuration(robot, q))
    if not regular(there, task, start):
        raise ConfigurationError("the configuration is singular: it lies in no aspect", where="q",
                                 mend="rankdrop explain shows ways out of it")  # fmt: skip
    return start


def _places(
    robot: Robot, task: Task, how: AspectsOptions, start: Array | None, decision: Decision
) -> list[tuple[Array, bool]]:
    """Regular configurations, the poses of which are solved, and whether they were drawn near a cusp.

    They are the start, or random ones; those near a cusp, where two solutions of one aspect are likely, come after the
    poses that are asked for.
    """
    if start is None:
        random = sample(robot, task, how.most, how.seed, limits=how.limits)
    else:
        random = start[None]
    places = [(place, False) for place in random if regular(robot, task, place)]
    if decision.kind == CUSPS:
        near = _near_cusps(robot, task, decision, how.seed)
        places[how.poses : how.poses] = [(place, True) for place in near if regular(robot, task, place)]
    return places


def _limited_count(robot: Robot, signs: Signs | None, how: AspectsOptions) -> AspectCount | None:
    """The regions within the joint limits, where they are asked for."""
    if not how.limits or signs is None:
        return None
    return count_within_limits(robot, signs)


def _solve_poses(
    roadmap: Roadmap, places: list[tuple[Array, bool]], how: AspectsOptions, decision: Decision,
    progress: Callable[[int, int], None] | None, *, by_signs: bool,
) -> Iterator[tuple[SolvedPose, Change | None]]:  # fmt: skip
    """Each pose solved, with the best path until then; until a path is known, or it is proven that there is none.

    With `by_signs` the signs of the factors say which solutions share an aspect: one path is enough.
    """
    change: Change | None = None
    for number, (place, near_cusp) in enumerate(places, start=1):
        if number > how.poses and _is_settled(decision, change):
            break
        needless = decision.impossible or (by_signs and change is not None)
        solved_pose, ways = _solve(roadmap, place, how, near_cusp, ways_wanted=not needless)
        change = _best(change, ways)
        if change is not None or not near_cusp:
            yield solved_pose, change
        if progress is not None:
            progress(number, how.poses if _is_settled(decision, change) else len(places))


def _is_settled(decision: Decision, change: Change | None) -> bool:
    """Whether the question for a path is answered: there is one, or it is proven that there is none."""
    return change is not None or decision.impossible


def _best(change: Change | None, ways: Sequence[Change]) -> Change | None:
    """Of the best path so far and further ones: one from the given configuration, of the largest clearance."""
    candidates = [*ways]
    if change is not None:
        candidates.insert(0, change)
    return max(candidates, key=lambda way: (way.own, way.clearance), default=None)


def _near_cusps(robot: Robot, task: Task, decision: Decision, seed: int) -> Iterator[Array]:
    """Configurations around the cusps, the other joints at random."""
    rng = np.random.default_rng(seed)
    random = sample(robot, task, 1, seed)[0]
    for ring, cusp in product(_RINGS, decision.cusps):
        for angle in rng.uniform(-np.pi, np.pi, _AROUND):
            place = random.copy()
            place[1:3] = np.array(cusp) + ring * np.array([np.cos(angle), np.sin(angle)])
            yield place


def _solve(
    roadmap: Roadmap, place: Array, options: AspectsOptions, near_cusp: bool, *, ways_wanted: bool
) -> tuple[SolvedPose, list[Change]]:
    """The solutions at the pose of a configuration, and ways between them."""
    robot, task = roadmap.robot, roadmap.task
    q = solutions(robot, task, pose(robot, place), starts=options.starts, seed=options.seed, also=place)
    q = near_and_within(robot, q, q, limits=options.limits)
    other = np.abs(joint_difference(robot, place, q)).max(axis=1, initial=0.0) > 1e-6
    q = np.concatenate([place[None], q[other]])
    if ways_wanted and len(q) > 1:
        ways = roadmap.ways(q)
    else:
        ways = {}
    numbers = list(dict.fromkeys(groups := _connected_numbers(len(q), ways)))
    aspect = tuple(numbers.index(group) + 1 for group in groups)
    sign = tuple(int(x) for x in np.sign(determinants(robot, task, q)))
    return SolvedPose(q, aspect, sign, (), near_cusp), [replace(way, own=i == 0) for (i, _), way in ways.items()]


def _connected_numbers(count: int, joined: Iterable[tuple[int, int]]) -> list[int]:
    """A number for each of so many, the same for those that pairs join."""
    group = list(range(count))
    for i, j in joined:
        group = [group[i] if g == group[j] else g for g in group]
    return group




def _by_signs(solved: SolvedPose, count: AspectCount, signs: Signs | None, *, limits: bool) -> SolvedPose:
    """The solutions with the signs of all factors, and with their aspects where these signs decide them.

    Within joint limits they decide nothing: an aspect may fall apart there.
    """
    if signs is None or not signs.factors:
        return solved
    values = np.sign(signs.values(solved.q)).astype(np.int64)
    flags = tuple(tuple(row) for row in values.tolist())
    if limits or not count.signs_decide or any(0 in row for row in flags):
        return replace(solved, flags=flags)
    numbers = list(dict.fromkeys(flags))
    return replace(solved, flags=flags, aspect=tuple(numbers.index(row) + 1 for row in flags))


def _name_solutions(robot: Robot, solved: SolvedPose, signs: Signs | None) -> SolvedPose:
    """In the arm's unit, solutions named by the signs of their factors."""
    q = out_of_metres(robot, solved.q)
    if signs is None:
        names = tuple(f"det J {'+' if sign > 0 else '−'}" for sign in solved.sign)
    else:
        names = tuple(_labels(signs, row) for row in q)
    return replace(solved, q=q, names=names)


def _labels(signs: Signs, q: Array) -> str:
    """The signs of the factors at a configuration."""
    return ", ".join(flag.label for flag in configuration_flags(signs.chain, q, signs=signs).flags)


@dataclass(eq=False)
class Roadmap:
    """Random configurations, and which of them straight ways join.

    Attributes:
        robot, task: as many joints as rows.
        seed: of the configurations.
        limits: whether joints keep their limits; else turning joints go round.
    """

    robot: Robot
    task: Task
    seed: int
    limits: bool

    @cached_property
    def scale(self) -> Array:
        """(n,) of joint motions."""
        return joint_scale(self.robot, self.task)

    @cached_property
    def matters(self) -> Mask:
        """(n,) joints on which det J depends, seen at random configurations."""
        base, other = np.split(sample(self.robot, self.task, 64, 20231), 2)
        moved = np.repeat(base[None], self.robot.n, axis=0)  # (n, 32, n)
        j = np.arange(self.robot.n)
        moved[j, :, j] = other.T
        values = determinants(self.robot, self.task, np.concatenate([base[None], moved]).reshape(-1, self.robot.n))
        values = values.reshape(-1, len(base))
        return np.asarray(np.abs(values[1:] - values[0]).max(axis=1) > 1e-10)

    @cached_property
    def graph(self) -> tuple[Array, float, Index, Array]:
        """Configurations (N, n) in scaled joints, the median of |det J|; edges (E, 2), the least |det J| on each."""
        robot, task = self.robot, self.task
        if self.limits:
            low, high = limit_box(robot, task)
        else:
            low, high = sampling_box(robot, task, limits=False)
        count = _NODES.get(int(self.matters.sum()), _MOST_NODES)
        drawn = sample(robot, task, count, self.seed, limits=self.limits) / self.scale
        middle = np.where(np.isfinite(low + high), 0.5 * (low + high) / self.scale, 0.0)
        nodes = np.where(self.matters, drawn, middle)
        values = self._determinants(nodes)
        signs, usual = np.sign(values), float(np.median(np.abs(values)))
        joined: list[tuple[int, int]] = []
        for i in range(count):
            joined += [(i, j) for j in self._nearest_of_sign(nodes[i], signs[i], nodes, signs, skip=i)]
        edges = np.unique(np.sort(np.array(joined, dtype=np.int64).reshape(-1, 2), axis=1), axis=0)
        return nodes, usual, *self._edges_of_sign(nodes, edges, usual)

    def ways(self, q: Array) -> dict[tuple[int, int], Change]:
        """Ways between some configurations: enough of them that all that are joined are joined through these.

        Args:
            q: (k, n) regular configurations; with `limits` inside them.

        Returns:
            (i, j) with i < j -> the way from i to j.
        """
        q = q / self.scale
        k = len(q)
        old, usual, old_edges, old_weights = self.graph
        nodes = np.concatenate([np.where(self.matters, q, old[0]), old])
        signs = np.sign(self._determinants(nodes))
        new: list[tuple[int, int]] = []
        for i in range(k):
            new += [(i, j) for j in self._nearest_of_sign(nodes[i], signs[i], old, signs[k:], skip=-1) + k]
        for i in range(k):
            new += [(i, j) for j in range(i) if signs[i] == signs[j]]
        edges, weights = self._edges_of_sign(nodes, np.array(new, dtype=np.int64).reshape(-1, 2), usual)
        edges, weights = np.concatenate([edges, old_edges + k]), np.concatenate([weights, old_weights])
        changes: dict[tuple[int, int], Change] = {}
        for i, j in combinations(range(k), 2):
            groups = _connected_numbers(k, changes)
            if groups[i] != groups[j] and signs[i] == signs[j]:
                way = self._way(nodes, edges, weights, (i, j), q)
                if way is not None:
                    changes[i, j] = way
        return changes

    def _way(self, nodes: Array, edges: Index, weights: Array, ends: tuple[int, int], q: Array) -> Change | None:
        usable = np.ones(len(edges), dtype=np.bool_)
        for _ in range(_TRIES):
            chain = _widest(len(nodes), edges[usable], weights[usable], *ends)
            if not chain:
                return None
            corners = nodes[chain]  # one after another, each the short way from the one before
            steps = self._difference(corners[:-1], corners[1:])
            unwound = np.concatenate([corners[:1], corners[0] + np.cumsum(steps, axis=0)])
            for corners in (self._shorten(unwound), unwound):
                way = self._proven(corners, q[ends[0]], q[ends[1]])
                if way is not None:
                    return way
            on_it = {tuple(sorted(pair)) for pair in pairwise(chain)}
            usable &= np.array([tuple(sorted(pair)) not in on_it for pair in edges.tolist()])
        return None

    def _proven(self, corners: Array, start: Array, end: Array) -> Change | None:
        """The way through corners, the joints that do not matter going evenly from start to end; None if not proven."""
        length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
        if length[-1] > 0:
            share = length / length[-1]
        else:
            share = np.linspace(0.0, 1.0, len(corners))
        free = start + share[:, None] * self._difference(start, end)
        q = np.where(self.matters, corners, free) * self.scale
        proof = prove(self.robot, settings_for(self.robot, self.task), curve(q, None), singular=DEFAULT.singular,
                      evaluations=EVALUATIONS)  # fmt: skip
        if proof.slivers or not proof.complete:
            return None
        clearance = self._least(q[:-1] / self.scale, q[1:] / self.scale, self.graph[1]).min()
        return Change(q, float(clearance), proof.evaluations)

    def _shorten(self, corners: Array) -> Array:
        """Fewer corners, where the smallest |det J| is not halved."""
        usual = self.graph[1]
        least = _SHORTER * float(self._least(corners[:-1], corners[1:], usual).min())
        kept, at = [0], 0
        while at < len(corners) - 1:
            ahead = np.arange(at + 1, len(corners))
            clear = self._least(np.repeat(corners[[at]], len(ahead), axis=0), corners[ahead], usual) >= least
            if clear.any():
                at = int(ahead[clear].max())
            else:
                at = at + 1
            kept.append(at)
        return corners[kept]

    def _nearest_of_sign(self, q: Array, sign: float, others: Array, signs: Array, *, skip: int) -> Index:
        """Indices of the nearest configurations of the same sign."""
        gap = np.linalg.norm(self._difference(q, others)[:, self.matters], axis=1)
        gap[signs != sign] = np.inf
        if skip >= 0:
            gap[skip] = np.inf
        near = np.argpartition(gap, min(_NEIGHBOURS, len(gap) - 1))[:_NEIGHBOURS]
        return np.asarray(near[np.isfinite(gap[near])], dtype=np.int64)

    def _edges_of_sign(self, nodes: Array, edges: Index, usual: float) -> tuple[Index, Array]:
        """The edges on which the sign is kept, and their smallest |det J|."""
        start = nodes[edges[:, 0]]
        weights = self._least(start, start + self._difference(start, nodes[edges[:, 1]]), usual)
        return edges[weights > 0.0], weights[weights > 0.0]

    def _least(self, start: Array, end: Array, usual: float) -> Array:
        """(E,) the smallest |det J| on straight ways; negative where the sign changes. `usual`: its median."""
        least = self._sample_edges(start, end, 1)
        for share, finer in _FINER:
            small = (least > 0.0) & (least < share * usual)
            least[small] = self._sample_edges(start[small], end[small], finer)
        return least

    def _sample_edges(self, start: Array, end: Array, finer: int) -> Array:
        least = np.full(len(start), np.inf)
        if not len(start):
            return least
        points = finer * int(np.ceil(np.linalg.norm(end - start, axis=1).max() / _STEP)) + 2
        share = np.linspace(0.0, 1.0, points)[None, :, None]
        part = max(1, _PART // points)
        for first in range(0, len(start), part):
            some = slice(first, first + part)
            at = start[some, None] + share * (end[some, None] - start[some, None])
            values = self._determinants(at.reshape(-1, at.shape[2])).reshape(at.shape[:2])
            least[some] = (values * np.sign(values[:, :1])).min(axis=1)
        return least

    def _determinants(self, nodes: Array) -> Array:
        return determinants(self.robot, self.task, nodes * self.scale)

    def _difference(self, start: Array, end: Array) -> Array:
        if self.limits:
            return end - start
        return joint_difference(self.robot, start, end)


def _widest(count: int, edges: Index, weights: Array, start: int, end: int) -> list[int]:
    """Nodes of the path whose lightest edge is heaviest; [] where the two are not joined (Prim's algorithm)."""
    near: list[list[tuple[float, int]]] = [[] for _ in range(count)]
    for (a, b), weight in zip(edges.tolist(), weights.tolist(), strict=True):
        near[a].append((-weight, b))
        near[b].append((-weight, a))
    came: dict[int, int] = {}
    front = [(0.0, start, start)]
    while front and end not in came:
        _, at, before = heappop(front)
        if at not in came:
            came[at] = before
            for weight, other in near[at]:
                if other not in came:
                    heappush(front, (weight, other, at))
    if end not in came:
        return []
    chain = [end]
    while chain[-1] != start:
        chain.append(came[chain[-1]])
    return chain[::-1]
