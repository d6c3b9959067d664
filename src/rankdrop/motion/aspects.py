"""`aspects_of`: solutions of the inverse, the aspects they lie in, and a way from one to another without singularity.

An aspect is a connected set of regular configurations. An arm is *cuspidal* when two solutions of one pose lie in the
same aspect: it can change its posture without a singularity (Innocenti and Parenti-Castelli 1998). That is claimed only
with a path that is proven free; the contrary only where `exact.decide_postures` proves it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.codec import Result
from rankdrop.errors import ConfigurationError, MissingExtraError, RobotError, TaskError
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.aspects import Signs, configuration_flags, signs_of
from rankdrop.exact.posture_changes import CUSPS, OPEN, SIGNS, Decision, decide_postures
from rankdrop.kinematics import check_robot, one_configuration, pose
from rankdrop.local.block import generic_rank, sample
from rankdrop.motion.inverse import apart, check_square, determinants, regular, solutions
from rankdrop.motion.options import AspectsOptions
from rankdrop.motion.roadmap import Change, Roadmap
from rankdrop.motion.text import joint_cells, joint_heads
from rankdrop.motion.trajectory import csv_text
from rankdrop.options import takes
from rankdrop.robot.model import Array, Robot
from rankdrop.sections import Section
from rankdrop.task import Task, resolve_task
from rankdrop.units import in_metres, into_metres, out_of_metres, task_in_metres

CUSPIDAL, NOT_CUSPIDAL, NOT_FOUND = "cuspidal", "not cuspidal", "none found"
_RINGS = (0.05, 0.1, 0.2, 0.3, 0.4)  # distances from a cusp at which poses are tried [rad]
_AROUND = 4  # poses on each


@dataclass(frozen=True, eq=False)
class Solved:
    """One pose: the solutions of its inverse that were found.

    Attributes:
        q: (k, n) regular solutions [rad, m]; the first is the configuration whose pose it is.
        aspect: (k,) numbers from 1; equal ones are joined by paths proven free. Solutions of different numbers are
            proven to be in different aspects where the sign differs, or the arm is proven not to be cuspidal.
        sign: (k,) of det J.
        names: (k,) the signs of the factors of det J where they tell all solutions apart ("elbow +, wrist −"), else
            the sign of det J.
        near_cusp: the pose was chosen next to a cusp, not at random.
    """

    q: Array
    aspect: tuple[int, ...]
    sign: tuple[int, ...]
    names: tuple[str, ...]
    near_cusp: bool

    @property
    def per_aspect(self) -> tuple[int, ...]:
        """Number of solutions in each aspect, most first."""
        return tuple(sorted(Counter(self.aspect).values(), reverse=True))


@dataclass(frozen=True, eq=False)
class Postures(Result):
    """What was found.

    Attributes:
        robot, task, options: what was asked; with a configuration that is one pose.
        decision: what is known without a search.
        solved: the poses.
        change: a path from one solution of a pose to another; None where none was found or none exists.
        notes: what was rounded.
        complete: False after Ctrl-C.
    """

    robot: Robot
    task: Task
    options: AspectsOptions
    decision: Decision
    solved: tuple[Solved, ...]
    change: Change | None
    notes: tuple[str, ...]
    complete: bool
    FILE: ClassVar[str] = "aspects"

    @property
    def verdict(self) -> str:
        """`CUSPIDAL` (with a path), `NOT_CUSPIDAL` (proven), `NOT_FOUND`."""
        if self.change is not None:
            return CUSPIDAL
        return NOT_CUSPIDAL if self.decision.impossible else NOT_FOUND

    @property
    def sentence(self) -> str:
        """The verdict and what it rests on."""
        if self.change is not None:
            corners, spent = len(self.change.q), self.change.evaluations
            return (f"It can change its posture without a singularity (cuspidal): a path of {corners} corners from one "
                    f"solution of a pose to another is proven free ({spent:,} enclosures).")  # fmt: skip
        if self.decision.impossible:
            words = f"{self.decision.words[:1].upper()}{self.decision.words[1:]}"
            return f"It cannot change its posture without a singularity (not cuspidal): proven. {words}."
        where = f" {self._where}" if self.options.limits else ""
        poses = f"{len(self.solved)} pose{'' if len(self.solved) == 1 else 's'}"
        return f"No change of posture without a singularity was found in {poses}{where}; that is no proof of absence."

    def sections(self, *, deg: bool = False) -> Iterator[Section]:
        """For people: the verdict first and last."""
        yield Section(self.sentence)
        yield Section(f"{self.robot.name}, {self.task.name}", lines=tuple(self._about()))
        if len(self.solved) == 1:
            yield self._solutions(self.solved[0], deg=deg)
        elif self.solved:
            yield self._counts()
        if self.change is not None:
            yield self._way(self.change, deg=deg)
        if self.notes:
            yield Section("Notes", lines=self.notes)
        yield Section(self.sentence)

    def path_csv(self) -> str:
        """The path as a file that `rankdrop path` reads: joints by name, one corner a line [rad, m].

        Empty where there is no path.
        """
        names = [joint.name for joint in self.robot.variables]
        return "" if self.change is None else csv_text(names, self.change.q)

    @property
    def _where(self) -> str:
        return "within the joint limits" if self.options.limits else "joint limits ignored"

    def _about(self) -> Iterator[str]:
        if not self.decision.impossible:  # else the verdict says it
            yield f"without a search: {self.decision.words}"
        yield (f"solutions of the inverse: Newton's method from {self.options.starts:,} starts for each pose, seed "
               f"{self.options.seed}, {self._where}; more may exist")  # fmt: skip

    def _solutions(self, solved: Solved, *, deg: bool) -> Section:
        order = sorted(range(len(solved.q)), key=lambda i: (solved.aspect[i], i))
        cells = [joint_cells(self.robot, q, deg=deg) for q in solved.q]
        rows = tuple((f"{solved.aspect[i]}{' ←' if i == 0 else ''}", solved.names[i], *cells[i]) for i in order)
        columns = ("aspect", "sign", *joint_heads(self.robot, deg=deg))
        notes = ("← the configuration whose pose it is", *self._what_numbers_mean())
        return Section(f"{len(solved.q)} solutions in {len(solved.per_aspect)} aspects", columns=columns, rows=rows,
                       texts=(0, 1), notes=notes)  # fmt: skip

    def _counts(self) -> Section:
        met = Counter((len(one.q), one.per_aspect) for one in self.solved if not one.near_cusp)
        rows = tuple(
            (str(count), " + ".join(map(str, sizes)), str(times))
            for (count, sizes), times in sorted(met.items(), key=lambda item: (-item[1], item[0]))
        )
        return Section("Solutions by aspect", columns=("solutions", "in the aspects", "poses"), rows=rows, texts=(1,),
                       notes=self._what_numbers_mean())  # fmt: skip

    def _what_numbers_mean(self) -> tuple[str, ...]:
        if self.decision.impossible:
            return ("every solution lies in an aspect of its own: proven",)
        joined = "solutions of one aspect are joined by paths proven free"
        if all(len(set(one.sign)) == len(set(one.aspect)) for one in self.solved):
            return (f"{joined}; aspects of different signs of det J are parted by a singularity",)
        return (f"{joined}; of aspects with the same sign no path was found, which does not prove them two",)

    def _way(self, change: Change, *, deg: bool) -> Section:
        rows = tuple((str(k), *joint_cells(self.robot, q, deg=deg)) for k, q in enumerate(change.q, start=1))
        lines = () if change.own else ("not from the configuration first named, but between two other solutions",)
        columns = ("", *joint_heads(self.robot, deg=deg))
        return Section("A change of posture without a singularity", lines=lines, columns=columns, rows=rows,
                       notes=(f"straight lines between; smallest |det J| of its sample points "
                                         f"{change.clearance:.3g}, lengths by the length scale",))  # fmt: skip


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
        robot: the arm, with as many joints as the task has rows.
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
    check_square(robot, resolved)
    there, there_task = in_metres(robot), task_in_metres(resolved, robot)
    if generic_rank(there, there_task) < there_task.m:
        raise TaskError("the arm is singular at every configuration", got=f"{robot.name}, {resolved.name}")
    start = None if q is None else into_metres(robot, one_configuration(robot, q))
    if start is not None and not regular(there, there_task, start):
        raise ConfigurationError("the configuration is singular: it lies in no aspect", where="q",
                                 mend="rankdrop explain shows ways out of it")  # fmt: skip
    decision, signs, notes = _decided(robot, resolved)
    how = replace(how, most=max(how.poses, how.most)) if start is None else replace(how, poses=1, most=1)
    search = _Search(there, there_task, how, decision)
    solved, complete = search.all(start, progress)
    change = search.change
    if change is not None:
        change = replace(change, q=out_of_metres(robot, change.q))
    solved = tuple(_name_solutions(robot, one, signs) for one in solved)
    return Postures(robot, resolved, how, decision, solved, change, notes, complete)


class _Search:
    def __init__(self, robot: Robot, task: Task, options: AspectsOptions, decision: Decision) -> None:
        self.robot, self.task, self.options, self.decision = robot, task, options, decision
        self.change: Change | None = None

    @property
    def decided(self) -> bool:
        """Whether more random poses would change nothing: a path is known, or it is proven that there is none."""
        return self.change is not None or self.decision.impossible or self.decision.kind == CUSPS

    def all(self, start: Array | None, progress: Callable[[int, int], None] | None) -> tuple[tuple[Solved, ...], bool]:
        """Every pose, and whether the work was not interrupted."""
        robot, task, options = self.robot, self.task, self.options
        random = sample(robot, task, options.most, options.seed, limits=options.limits)
        places = random if start is None else start[None]
        found: list[Solved] = []
        try:
            for number, place in enumerate(places, start=1):
                if number > options.poses and self.decided:
                    break
                if regular(robot, task, place):
                    found.append(self._solve(place, near_cusp=False))
                if progress is not None:
                    progress(number, options.poses if self.decided else len(places))
            if self.decision.kind == CUSPS and self.change is None:
                for place in self._near_cusps():
                    one = self._solve(place, near_cusp=True)
                    if self.change is not None:
                        found.append(one)
                        break
        except KeyboardInterrupt:
            return tuple(found), False
        return tuple(found), True

    def _near_cusps(self) -> Iterator[Array]:
        """Configurations around the cusps, the other joints at random."""
        rng = np.random.default_rng(self.options.seed)
        random = sample(self.robot, self.task, 1, self.options.seed)[0]
        for ring in _RINGS:
            for cusp in self.decision.cusps:
                for angle in rng.uniform(-np.pi, np.pi, _AROUND):
                    place = random.copy()
                    place[1:3] = np.array(cusp) + ring * np.array([np.cos(angle), np.sin(angle)])
                    if regular(self.robot, self.task, place):
                        yield place

    def _solve(self, place: Array, *, near_cusp: bool) -> Solved:
        robot, task, options = self.robot, self.task, self.options
        q = solutions(robot, task, pose(robot, place), starts=options.starts, seed=options.seed, also=place)
        if options.limits:
            q = _inside(robot, q)
        own = np.array([np.abs(apart(robot, place, row)).max() for row in q])
        q = np.concatenate([place[None], q[own > 1e-6]]) if len(q) else place[None]
        ways: dict[tuple[int, int], Change] = {}
        if not self.decision.impossible and len(q) > 1:
            ways = self._roadmap.ways(q)
        for (i, _), way in ways.items():
            if self.change is None or (i == 0, way.clearance) > (self.change.own, self.change.clearance):
                self.change = replace(way, own=i == 0)
        aspect = _grouped(len(q), ways)
        sign = tuple(int(x) for x in np.sign(determinants(robot, task, q)))
        return Solved(q, aspect, sign, (), near_cusp)

    @cached_property
    def _roadmap(self) -> Roadmap:
        return Roadmap(self.robot, self.task, self.options.seed, self.options.limits)


def _decided(robot: Robot, task: Task) -> tuple[Decision, Signs | None, tuple[str, ...]]:
    """What is known without a search, the signs that tell solutions apart, and remarks."""
    try:
        chain = exact_chain(robot, task)
        decision = decide_postures(chain)
    except (RobotError, TaskError, MissingExtraError) as error:
        return Decision(OPEN, f"not decided exactly: {error}"), None, ()
    return decision, signs_of(chain) if decision.kind == SIGNS else None, chain.remarks


def _name_solutions(robot: Robot, solved: Solved, signs: Signs | None) -> Solved:
    """In the arm's unit, solutions named by the signs of their factors."""
    q = out_of_metres(robot, solved.q)
    if signs is None:
        names = tuple(f"det J {'+' if sign > 0 else '−'}" for sign in solved.sign)
    else:
        flags = (configuration_flags(signs.chain, row, signs=signs).flags for row in q)
        names = tuple(", ".join(flag.label for flag in some) for some in flags)
    return replace(solved, q=q, names=names)


def _grouped(count: int, ways: dict[tuple[int, int], Change]) -> tuple[int, ...]:
    """Number of the aspect of each solution, from 1; each its own but for those that ways join."""
    group = list(range(count))
    for i, j in ways:
        group = [group[i] if g == group[j] else g for g in group]
    order = list(dict.fromkeys(group))
    return tuple(order.index(g) + 1 for g in group)


def _inside(robot: Robot, q: Array) -> Array:
    """The solutions that have a place within the joint limits, moved there by whole turns."""
    low, high = robot.lower, robot.upper
    turns = np.where(robot.periodic & (q < low - 1e-12), np.ceil((low - q) / (2 * np.pi) - 1e-12), 0.0)
    turns = np.where(robot.periodic & (q > high + 1e-12), -np.ceil((q - high) / (2 * np.pi) - 1e-12), turns)
    q = q + 2 * np.pi * np.where(np.isfinite(turns), turns, 0.0)
    return q[((q >= low - 1e-12) & (q <= high + 1e-12)).all(axis=1)]
