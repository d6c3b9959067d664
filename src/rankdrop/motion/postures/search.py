"""`aspects_of`: solutions of the inverse, the aspects they lie in, and a way from one to another without singularity.

An aspect is a connected set of regular configurations. An arm is *cuspidal* when two solutions of one pose lie in the
same aspect: it can change its posture without a singularity (Innocenti and Parenti-Castelli 1998). That is claimed only
with a path that is proven free; the contrary only where `exact.decide_postures` proves it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import ConfigurationError, MissingExtraError, OptionError, RobotError, TaskError
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.aspects import Signs, configuration_flags, signs_of
from rankdrop.exact.posture_changes import CUSPS, OPEN, SIGNS, Decision, decide_postures
from rankdrop.kinematics import check_robot, one_configuration, pose
from rankdrop.local.block import generic_rank, sample
from rankdrop.motion.inverse import apart, check_square, determinants, regular, solutions
from rankdrop.motion.postures.record import Change, Postures, PosturesSettings, Solved
from rankdrop.motion.postures.roadmap import Roadmap
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task, resolve_task
from rankdrop.units import in_metres, into_metres, out_of_metres, task_in_metres
from rankdrop.version import VERSION

_RINGS = (0.05, 0.1, 0.2, 0.3, 0.4)  # distances from a cusp at which poses are tried [rad]
_AROUND = 4  # poses on each


def aspects_of(
    robot: Robot,
    task: Task | str | None = None,
    *,
    q: ArrayLike | None = None,
    poses: int = 10,
    most: int = 100,
    starts: int = 600,
    seed: int = 0,
    limits: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Postures:
    """Whether an arm can change its posture without a singularity, and solutions of poses by their aspects.

    Args:
        robot: the arm, with as many joints as the task has rows.
        task: name, rows or Task; None is the task the arm is made for.
        q: (n,) configuration whose pose is solved [rad, m]; None: the poses of random configurations.
        poses: how many random ones are solved in any case.
        most: and how many at most, while none of them decides.
        starts: of Newton's method, for each pose.
        seed: of every random choice; the same seed gives the same result.
        limits: solutions and paths within the joint limits only.
        progress: called as progress(poses solved, poses to solve).

    Returns:
        The verdict with its proof, each pose with its solutions and aspects, and a path where there is one.

    Raises:
        ConfigurationError: q is not one configuration of this arm, or singular.
        OptionError: poses, starts or seed outside what is allowed.
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
    _check_numbers(poses=poses, most=most, starts=starts, seed=seed)
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
    settings = PosturesSettings(*((1, 1) if start is not None else (poses, max(poses, most))), starts, seed, limits,
                                float(resolved.scale(robot)), VERSION)  # fmt: skip
    search = _Search(there, there_task, settings, decision)
    solved, complete = search.all(start, progress)
    change = search.change
    solved = tuple(_out(robot, one, signs) for one in solved)
    if change is not None:
        change = replace(change, q=out_of_metres(robot, change.q))
    return Postures(robot, resolved, settings, decision, solved, change, notes, complete)


class _Search:
    """The poses one after another, and the best way met."""

    def __init__(self, robot: Robot, task: Task, settings: PosturesSettings, decision: Decision) -> None:
        self.robot, self.task, self.settings, self.decision = robot, task, settings, decision
        self.change: Change | None = None
        self._map: Roadmap | None = None

    @property
    def decided(self) -> bool:
        """Whether more random poses would change nothing: a path is known, or it is proven that there is none."""
        return self.change is not None or self.decision.impossible or self.decision.kind == CUSPS

    def all(self, start: Array | None, progress: Callable[[int, int], None] | None) -> tuple[tuple[Solved, ...], bool]:
        """Every pose, and whether the work was not interrupted."""
        robot, task, settings = self.robot, self.task, self.settings
        random = sample(robot, task, settings.most, settings.seed, limits=settings.limits)
        places = random if start is None else start[None]
        found: list[Solved] = []
        try:
            for number, place in enumerate(places, start=1):
                if number > settings.poses and self.decided:
                    break
                if regular(robot, task, place):
                    found.append(self._solve(place, near_cusp=False))
                if progress is not None:
                    progress(number, settings.poses if self.decided else len(places))
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
        rng = np.random.default_rng(self.settings.seed)
        random = sample(self.robot, self.task, 1, self.settings.seed)[0]
        for ring in _RINGS:
            for cusp in self.decision.cusps:
                for angle in rng.uniform(-np.pi, np.pi, _AROUND):
                    place = random.copy()
                    place[1:3] = np.array(cusp) + ring * np.array([np.cos(angle), np.sin(angle)])
                    if regular(self.robot, self.task, place):
                        yield place

    def _solve(self, place: Array, *, near_cusp: bool) -> Solved:
        robot, task, settings = self.robot, self.task, self.settings
        q = solutions(robot, task, pose(robot, place), starts=settings.starts, seed=settings.seed, also=place)
        if settings.limits:
            q = _inside(robot, q)
        own = np.array([np.abs(apart(robot, place, row)).max() for row in q])
        q = np.concatenate([place[None], q[own > 1e-6]]) if len(q) else place[None]
        ways: dict[tuple[int, int], Change] = {}
        if not self.decision.impossible and len(q) > 1:
            ways = self._roadmap().ways(q)
        for (i, _), way in ways.items():
            if self.change is None or (i == 0, way.clearance) > (self.change.own, self.change.clearance):
                self.change = replace(way, own=i == 0)
        aspect = _grouped(len(q), ways)
        sign = tuple(int(x) for x in np.sign(determinants(robot, task, q)))
        return Solved(q, aspect, sign, (), near_cusp)

    def _roadmap(self) -> Roadmap:
        if self._map is None:
            self._map = Roadmap(self.robot, self.task, self.settings.seed, self.settings.limits)
        return self._map


def _decided(robot: Robot, task: Task) -> tuple[Decision, Signs | None, tuple[str, ...]]:
    """What is known without a search, the signs that tell solutions apart, and remarks."""
    try:
        chain = exact_chain(robot, task)
        decision = decide_postures(chain)
    except (RobotError, TaskError, MissingExtraError) as error:
        return Decision(OPEN, f"not decided exactly: {error}"), None, ()
    return decision, _signs(chain) if decision.kind == SIGNS else None, chain.remarks


def _signs(chain: Chain) -> Signs:
    return signs_of(chain)


def _out(robot: Robot, solved: Solved, signs: Signs | None) -> Solved:
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


def _check_numbers(**numbers: int) -> None:
    for name, value in numbers.items():
        low, high = {"starts": (1, 1_000_000), "seed": (0, 2**63 - 1)}.get(name, (1, 100_000))
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise OptionError(f"{name} is outside the range", got=repr(value), allowed=f"{low} … {high}")
