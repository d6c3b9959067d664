"""How much of the joint space lies near each family: random configurations, and how far each is from the family.

    share = (configurations within δ of the family) / (all),      standard error √(p (1 − p)/N)

Configurations are uniform in the joint space, or inside the limits. Distance is Euclidean in joint space, slides
divided by the length scale, to the family itself, which may go on beyond the limits: a configuration beside a
singularity that is just out of reach is beside it all the same. For coupled joints the nearest point is walked to from
each configuration and from others around it; a nearer one may be missed, so that a share of such a row is a lower
bound.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from rankdrop.errors import OptionError
from rankdrop.families.points import Rows, near_family
from rankdrop.families.record import Family
from rankdrop.families.rescaling import family_in_units
from rankdrop.families.searching import Progress
from rankdrop.formula.equation import REACHED, System
from rankdrop.local.block import joint_scale, sample
from rankdrop.local.slowest import slowest_motions
from rankdrop.problem import Mask, Problem
from rankdrop.robot.model import Array
from rankdrop.solve import iterate, steps_towards
from rankdrop.tolerances import SLOW, SLOW_TURN
from rankdrop.units import in_units, out_of_units, task_in_units

SAMPLES = 10_000
WIDEST = 1.5
"""Distances from here on say nothing: families are everywhere [rad]."""
_STEPS = 12  # of the walk to the nearest point: distances of some degrees are right to 1e-4 of themselves after that
_LONGEST = 0.5  # step [rad]
_BLOCK = 10_000  # configurations whose speeds are computed at one time
_AROUND = 2  # further starts of the walk, within the distance of each configuration
_Z = 1.959963984540054  # two-sided 95 %


@dataclass(frozen=True, slots=True)
class NearShare:
    """Of `samples` configurations, `near` lie within the distance of a family.

    Attributes:
        id: of the family; "" for all of them together.
        near, samples: counts.
        bound: True where a share may be larger: coupled joints, or a family without conditions among all.
    """

    id: str
    near: int
    samples: int
    bound: bool

    @property
    def share(self) -> float:
        """Of the joint space, from 0 to 1."""
        return self.near / self.samples

    @property
    def error(self) -> float:
        """Its standard error."""
        return sqrt(self.share * (1.0 - self.share) / self.samples)

    @property
    def interval(self) -> tuple[float, float]:
        """95 % confidence by Wilson's rule, which holds for shares near 0 and 1 too."""
        n, p = self.samples, self.share
        middle, half = p + _Z**2 / (2 * n), _Z * sqrt(p * (1 - p) / n + _Z**2 / (4 * n**2))
        whole = 1 + _Z**2 / n
        if self.near:
            low = max(0.0, (middle - half) / whole)
        else:
            low = 0.0
        return low, min(1.0, (middle + half) / whole) if self.near < n else 1.0


@dataclass(frozen=True, slots=True)
class JointSpaceShares:
    """Shares of the joint space.

    Attributes:
        within: the distance δ [rad].
        samples, seed, limits: of the random configurations.
        families: one record for each family that has conditions, in their order.
        any: within δ of at least one of them.
        slow: inside the joint limits, where some straight motion of the tool is slower than 25 mm/s or 5°/s
            (`slow_share`); None without rate limits.
    """

    within: float
    samples: int
    seed: int
    limits: bool
    families: tuple[NearShare, ...]
    any: NearShare
    slow: NearShare | None = None
    _hits: Mask | None = field(default=None, compare=False, repr=False)

    @property
    def hits(self) -> Mask:
        """(samples,) which configurations are near any of them; empty where the shares were read from a file."""
        if self._hits is None:
            return np.zeros(0, dtype=np.bool_)
        return self._hits


@dataclass(frozen=True, slots=True)
class SlowShare:
    """Share of the configurations inside the joint limits at which the tool is slower than a speed in some direction.

    Attributes:
        tool_speed: of straight translations, the tool not turning [m/s].
        share: how many configurations are slower in their worst direction, every joint within its rate limit.
        seed: of the configurations, uniform in each joint.
    """

    tool_speed: float
    share: NearShare
    seed: int


def near_shares(
    families: Sequence[Family],
    problem: Problem,
    within: float,
    *,
    samples: int = SAMPLES,
    seed: int = 0,
    progress: Progress | None = None,
) -> JointSpaceShares:
    """Share of the joint space within a distance of each family.

    Args:
        families: of this arm and task, as `analyze` returns them.
        problem: the arm, its task, and whether configurations are inside the joint limits only.
        within: the distance [rad; slides divided by the length scale].
        samples: how many configurations.
        seed: of them.
        progress: called with (families done, families in all).

    Raises:
        OptionError: the distance or the number of samples is outside what is allowed.
    """
    check_within(within)
    if not 1 <= samples <= 10_000_000:
        raise OptionError("samples is outside the range", got=samples, allowed="1 … 10000000")
    robot, limits = problem.robot, problem.limits
    scaled, inside = in_units(robot), task_in_units(problem.task, robot)
    q = sample(scaled, inside, samples, seed, limits=limits)
    scale, rng = joint_scale(scaled, inside), np.random.default_rng([seed, 1])
    met, every = [], np.zeros(samples, dtype=np.bool_)
    named = [family for family in families if family.named and family.equations]
    for done, family in enumerate(named):
        if progress is not None:
            progress(done, len(named))
        moved = family_in_units(family, robot)
        near = near_family(moved, q, within, scale, robot.periodic, partial(_reaches_zero, moved, scale, rng))
        every |= near
        met.append(NearShare(family.id, int(near.sum()), samples, bool(family.coupled)))
    if progress is not None:
        progress(len(named), len(named))
    unsure = len(named) < len(families) or any(share.bound for share in met)
    shared = NearShare("", int(every.sum()), samples, unsure)
    slow, _ = slow_share(problem, samples=samples, seed=seed)
    return JointSpaceShares(within, samples, seed, limits, tuple(met), shared, slow, every)


def slow_share(
    problem: Problem, *, speed: float = SLOW, turn_speed: float = SLOW_TURN, samples: int = SAMPLES, seed: int = 0
) -> tuple[NearShare | None, Mask]:
    """Share of the configurations inside the joint limits at which some straight motion of the tool is slow.

    Args:
        problem: the arm with its rate limits, and its task.
        speed: a straight translation slower than this is slow [m/s].
        turn_speed: the same of rotations about the tool point [rad/s].
        samples: how many configurations.
        seed: of them.

    Returns:
        The share, and (samples,) which configurations are slow; None and an empty mask without rate limits. The share
        is a lower bound where the arm has too many joints to list all directions.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("ur5e")
        >>> share, _ = slow_share(Problem(arm, resolve_task(None, arm)), samples=2000)
        >>> f"{100 * share.share:.1f} %"
        '7.4 %'
    """
    robot, task = problem.robot, problem.task
    scaled, inside = in_units(robot), task_in_units(task, robot)
    q = out_of_units(robot, sample(scaled, inside, samples, seed, limits=True))
    slow, bound = np.zeros(samples, dtype=np.bool_), False
    for first in range(0, samples, _BLOCK):
        kinds = slowest_motions(robot, q[first : first + _BLOCK], task)
        if not kinds:
            return None, np.zeros(0, dtype=np.bool_)
        for motion in kinds:
            slow[first : first + _BLOCK] |= motion.speed < (speed if motion.unit == "m/s" else turn_speed)
            bound |= not motion.exact
    return NearShare("", int(slow.sum()), samples, bound), slow


def slower_than(problem: Problem, speed: float, *, samples: int = SAMPLES, seed: int = 0) -> SlowShare | None:
    """Share of the configurations at which some straight translation of the tool is slower than a speed.

    Args:
        problem: the arm with its rate limits, and its task.
        speed: to be reached in every direction, the tool not turning [m/s].
        samples: how many configurations, uniform in each joint inside its limits.
        seed: of them.

    Returns:
        The share; None where too few joints have rate limits to bound the speed.
    """
    share, _ = slow_share(problem, speed=speed, turn_speed=0.0, samples=samples, seed=seed)
    if share is None:
        return None
    return SlowShare(speed, share, seed)


def check_within(within: float) -> None:
    """
    Raises:
        OptionError: this is no distance to look within.
    """
    if not (isinstance(within, int | float | np.number) and 0.0 < within <= WIDEST):
        raise OptionError("this is no distance to look within", where="within", got=within,
                          allowed=f"above 0, up to {WIDEST} rad (86°)")  # fmt: skip


def _reaches_zero(family: Family, scale: Array, rng: np.random.Generator, _rows: Rows, q: Array, within: Array) -> Mask:
    """(N,) whether a zero of the equations was found so near, pinned joints held."""
    system = family.system
    moves = np.array([j for j in range(q.shape[1]) if j + 1 in family.coupled])
    moving = np.isin(np.arange(q.shape[1]), moves)
    reaches = np.zeros(len(q), dtype=np.bool_)
    may = _may_be_near(system, q, scale, moves, within)
    for attempt in range(1 + _AROUND):
        rows = np.flatnonzero(~reaches)
        if not len(rows):
            break
        centre, reach = q[rows], within[rows]
        x = centre.copy()
        if attempt:
            away = rng.normal(size=(len(rows), len(moves)))
            away *= (reach / np.maximum(np.linalg.norm(away, axis=1), 1e-300))[:, None]
            x[:, moves] += away * rng.random((len(rows), 1)) * scale[moves]
        possible = may[rows]
        rows, centre, reach, x = rows[possible], centre[possible], reach[possible], x[possible]
        if not len(rows):
            continue
        def step(x: Array, active: NDArray[np.intp], centre: Array = centre) -> Array:
            f, slope = system.linear(x)
            return steps_towards((centre[active] - x) * moving / scale, f, slope * (moving * scale))

        x = iterate(step, x, iterations=_STEPS, longest=_LONGEST, scale=scale)
        x, _ = system.solve(x, along=np.eye(x.shape[1])[:, moves], iterations=20)  # pinned joints held
        there = np.abs(system.values(x)).max(axis=1) <= REACHED
        distance = np.linalg.norm((x - centre) / scale, axis=1)
        reaches[rows] = there & (distance <= reach)
    return reaches


def _may_be_near(system: System, q: Array, scale: Array, moves: NDArray[np.intp], within: Array) -> Mask:
    """(N,) False where a bound on the slope proves that no zero x is so near: |f(q)| ≤ sup |∇f| · |q − x|.

    Of equations in which a slide stands as a power nothing is proven.
    """
    may = np.ones(len(q), dtype=np.bool_)
    for equation in system.equations:
        m, _, a, b, powers = equation.tables
        if not powers.any():
            steepest = float((np.hypot(a, b) * np.linalg.norm(m[:, moves] * scale[moves], axis=1)).sum())
            may &= np.abs(equation(q)) <= steepest * within * (1.0 + 1e-9) + REACHED
    return may
