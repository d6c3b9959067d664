"""Ordered screw sets of Gallardo-Alvarado and Rico-Martínez (GR, sections 2 to 5), and their minimal singular runs.

Here a screw is (s; s_o) as in GR, direction first, moment about the point O second, and screws are numbered from 1. The
moment of a line through p is s_o = p × s (+ pitch · s). The Lie product is GR's equation 2,

    [S_1, S_2] = (s_1 × s_2 ; s_1 × s_o2 − s_2 × s_o1),

and joint j at small time t carries every later screw: S_k(t) = S_k + [S_j, S_k] t, k > j (rule 1).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.errors import OptionError, RobotError
from rankdrop.kinematics import jacobian, one_configuration
from rankdrop.local.block import sigma_of, structural_sample
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.robot.screws import from_screws, read_screw_list
from rankdrop.robot.transform import bracket, cross, hat, unit
from rankdrop.task import SPACE, Task
from rankdrop.tolerances import DEPENDENT

NO_TURN = 1e-12
"""A direction shorter than this share of the whole screw: a slide."""

_SAMPLES = 4  # random configurations that tell which losses hold everywhere


def lie_product(first: Array, second: Array) -> Array:
    """(6,) GR equation 2, direction first."""
    return np.roll(bracket(np.roll(first, 3), np.roll(second, 3)), 3)


def motion(screw: Array, amount: float) -> Array:
    """(6, 6) Ad(exp(amount · screw)), direction first: [[R, 0], [p̂ R, R]].

    A screw with direction s ≠ 0 turns by |s| · amount about its axis and slides along it; else it slides.
    """
    s, moment = screw[:3], screw[3:]
    size = float(np.linalg.norm(s))
    turn, shift = np.eye(3), moment * amount
    if size > NO_TURN * float(np.linalg.norm(screw)):
        axis, angle = s / size, size * amount
        turned = hat(axis)
        turn = np.eye(3) + np.sin(angle) * turned + (1.0 - np.cos(angle)) * turned @ turned
        centre = np.cross(axis, moment) / size
        shift = (np.eye(3) - turn) @ centre + axis * float(axis @ moment) * amount
    result = np.zeros((6, 6))
    result[:3, :3] = result[3:, 3:] = turn
    result[3:, :3] = hat(shift) @ turn
    return result


@dataclass(frozen=True, slots=True)
class OrderedSubset:
    """A run of screws first … last with fewer dimensions than screws.

    Attributes:
        first, last: numbers from 1.
        dimension: of the span.
        loss: screws − dimension, at least 1.
        msos: loss = 1, GR's test of a minimal singular ordered subset.
        minimal: no shorter run inside has a loss. GR's test does not imply it.
        generic: the run has this loss at almost every configuration.
    """

    first: int
    last: int
    dimension: int
    loss: int
    msos: bool
    minimal: bool
    generic: bool = False


@dataclass(frozen=True, slots=True)
class Products:
    """What GR's `subspace(i, j)` finds.

    Attributes:
        first, last: the run.
        entries: (u, v, inside) of every pair u < v: whether [S_u, S_v] lies in the span of the run (GR print "yes").
        actuators: screws u whose products with all later screws of the run lie outside: GR say that these can escape.
    """

    first: int
    last: int
    entries: tuple[tuple[int, int, bool], ...]
    actuators: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class OrderedScrewSet:
    """The screws of a serial chain at one configuration, base to tip.

    Attributes:
        screws: (n, 6) rows (s; s_o), read-only.
        tolerance: σ of the screws, brought to unit length about a point amid their axes, at or below it is zero [1].

    Raises:
        RobotError: not (n, 6) finite numbers, or a screw that is zero.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> oss = OrderedScrewSet.of(open_robot("rcrrrr"), [0.0] * 7)
        >>> oss.dimension(1, 5), oss.subspace(1, 5).actuators, oss.newscrews(4, 5).readoss(5, 5).tolist()
        (4, (3, 4), [[1.0, 0.0, -1.0, 0.0, 5.0, 0.0]])
    """

    screws: Array  # (n, 6)
    tolerance: float = DEPENDENT

    def __post_init__(self) -> None:
        screws = np.array(self.screws, dtype=np.float64)
        if screws.ndim != 2 or screws.shape[1] != 6 or len(screws) == 0 or not np.isfinite(screws).all():
            raise RobotError("an ordered screw set is (n, 6) finite numbers", got=screws.shape, allowed="n ≥ 1")
        empty = np.flatnonzero(~screws.any(axis=1))
        if len(empty):
            raise RobotError("a screw is zero", where=f"screw {empty[0] + 1}", allowed="a direction or a moment")
        screws.flags.writeable = False
        object.__setattr__(self, "screws", screws)

    @classmethod
    def of(cls, robot: Robot, q: ArrayLike, length: float = 1.0) -> OrderedScrewSet:
        """The screws of an arm at q, in the base frame about the base origin, moments in units of `length` [m].

        Raises:
            ConfigurationError: q is not one configuration of this arm.
            RobotError: the arm has mimic joints: then a variable is not one screw.
        """
        if robot.n < len(robot.joints):
            raise RobotError("an arm with mimic joints is not an ordered screw set", where=f"robot {robot.name!r}")
        if not (np.isfinite(length) and length > 0.0):
            raise OptionError("the unit of length is a positive number", got=length, allowed="metres")
        twists = jacobian(robot, one_configuration(robot, q), SPACE).T
        return cls(np.concatenate([twists[:, 3:], twists[:, :3] / length], axis=1) + 0.0)

    @classmethod
    def read(cls, path: str | PathLike[str]) -> OrderedScrewSet:
        """From a text file with six numbers a line (s; s_o), or from a robot file (.toml, .urdf, .xacro) at q = 0.

        Raises:
            RobotError: not such a file; names line and column.
        """
        if Path(path).suffix.lower() in {".toml", ".urdf", ".xacro", ".xml"}:
            robot = open_robot(Path(path))
            return cls.of(robot, np.zeros(robot.n))
        return cls(read_screw_list(Path(path)))

    def __len__(self) -> int:
        return len(self.screws)

    def robot(self, name: str = "ordered screw set") -> Robot:
        """The chain with these screws at q = 0, tip at O, for everything else that this package can tell."""
        return from_screws(self.screws, order="angular-first", name=name)

    def readoss(self, first: int, last: int) -> Array:
        """(last − first + 1, 6) the screws of a run, as GR print them."""
        self._check(first, last)
        return self.screws[first - 1 : last]

    def lie(self, first: int, second: int) -> Array:
        """(6,) the Lie product [S_first, S_second] (GR eq. 2)."""
        self._check(min(first, second), max(first, second))
        return lie_product(self.screws[first - 1], self.screws[second - 1])

    @cached_property
    def _dimensions(self) -> dict[tuple[int, int], int]:
        """Dimension of the span of every run (first, last), short runs first."""
        rows, n, dimensions = self._rows(self.screws), len(self), dict[tuple[int, int], int]()
        for size in range(1, n + 1):
            ranks = _ranks(np.stack([rows[i : i + size] for i in range(n - size + 1)]), self.tolerance)
            dimensions |= {(i, i + size - 1): int(rank) for i, rank in enumerate(ranks, 1)}
        return dimensions

    def dimension(self, first: int, last: int) -> int:
        """Dimension of the span of a run."""
        self._check(first, last)
        return self._dimensions[first, last]

    def msos(self, first: int, last: int) -> OrderedSubset:
        """GR's test of a run: its dimension and loss. `minimal` is about runs inside, `generic` is not known here."""
        loss = last - first + 1 - self.dimension(first, last)
        if last > first:
            inside = [(first, last - 1), (first + 1, last)]
        else:
            inside = []
        minimal = loss > 0 and all(self.dimension(i, j) == j - i + 1 for i, j in inside)
        return OrderedSubset(first, last, last - first + 1 - loss, loss, loss == 1, minimal)

    def subsets(self) -> tuple[OrderedSubset, ...]:
        """Every run with a loss, short ones first: the search that GR leave to the user's intuition."""
        return tuple(run for run in (self.msos(*both) for both in self._dimensions) if run.loss)

    def subspace(self, first: int, last: int) -> Products:
        """Which Lie products of a run stay in its span, and the actuators that GR read off it.

        GR ask whether the product raises the dimension to the number of screws; here, whether it raises it. For a loss
        of 1, GR's only case, the two are the same.
        """
        dimension = self.dimension(first, last)
        pairs = [(u, v) for u in range(first, last + 1) for v in range(u + 1, last + 1)]
        run = self.screws[first - 1 : last]
        with_product = np.array([[*run, self._drop_rounding(self.lie(u, v))] for u, v in pairs])
        grown = _ranks(self._rows(with_product.reshape(-1, len(run) + 1, 6)), self.tolerance)
        entries = tuple((u, v, bool(rank == dimension)) for (u, v), rank in zip(pairs, grown, strict=True))
        stopped = {u for u, _, inside in entries if inside}
        return Products(first, last, entries, tuple(u for u in range(first, last) if u not in stopped))

    def newscrews(self, actuator: int, last: int) -> OrderedScrewSet:
        """GR's update: S_k + [S_actuator, S_k] for k = actuator + 1 … last; the screws behind `last` are left there."""
        self._check(actuator, last)
        screws = self.screws.copy()
        for k in range(actuator, last):
            screws[k] += lie_product(self.screws[actuator - 1], self.screws[k])
        return replace(self, screws=screws)

    def propagated(self, actuator: int) -> OrderedScrewSet:
        """The update carried to the end of the chain, as the joint carries it (rule 1, first order)."""
        return self.newscrews(actuator, len(self))

    def moved(self, actuator: int, amount: float) -> OrderedScrewSet:
        """The set after a finite motion of one joint: S_k ↦ Ad(exp(amount · S_actuator)) S_k for k > actuator."""
        self._check(actuator, len(self))
        screws = self.screws.copy()
        screws[actuator:] = self.screws[actuator:] @ motion(self.screws[actuator - 1], amount).T
        return replace(self, screws=screws)

    def _check(self, first: int, last: int) -> None:
        if not 1 <= first <= last <= len(self):
            raise OptionError("there is no such run of screws", got=f"({first}, {last})", allowed=f"1 … {len(self)}")

    def _drop_rounding(self, screw: Array) -> Array:
        """Zero where a Lie product is rounding, next to the largest direction and the largest moment of the set."""
        direction, moment = (np.linalg.norm(part, axis=1).max() for part in (self.screws[:, :3], self.screws))
        rounding = np.linalg.norm(screw[:3]) <= self.tolerance * direction
        if rounding and np.linalg.norm(screw[3:]) <= self.tolerance * moment:
            return np.zeros(6)
        return screw

    def _rows(self, screws: Array) -> Array:
        """(..., 6) screws brought to unit length about a point amid the axes of the set."""
        point, length = _middle(self.screws)
        linear = (screws[..., 3:] + cross(screws[..., :3], point)) / length
        return unit(np.concatenate([linear, screws[..., :3]], axis=-1))


def ordered_subsets(robot: Robot, q: ArrayLike, task: Task) -> tuple[OrderedSubset, ...]:
    """Every run of neighbouring joints whose whole screws (all six rows) are dependent at q, short ones first.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].
        task: gives the length of the box that random configurations are taken from.

    Raises:
        ConfigurationError: q is not one configuration of this arm.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("rcrrrr")
        >>> found = ordered_subsets(arm, [0.0] * 7, resolve_task("pose", arm))
        >>> [(run.first, run.last) for run in found if run.minimal]
        [(1, 5), (3, 7)]
    """
    elsewhere, runs = _elsewhere(robot, task), _screws_at(robot, one_configuration(robot, q)).subsets()
    subsets = []
    for run in runs:
        generic = all(other.dimension(run.first, run.last) == run.dimension for other in elsewhere)
        subsets.append(replace(run, generic=generic))
    return tuple(subsets)


def _screws_at(robot: Robot, q: Array) -> OrderedScrewSet:
    return OrderedScrewSet(np.roll(jacobian(robot, q, SPACE).T, 3, axis=1))


@lru_cache(maxsize=16)
def _elsewhere(robot: Robot, task: Task) -> tuple[OrderedScrewSet, ...]:
    """The screws at random configurations, always the same ones."""
    return tuple(_screws_at(robot, q) for q in structural_sample(robot, task, _SAMPLES))


def _ranks(rows: Array, tolerance: float) -> Array:
    """(B,) ranks of (B, k, 6) unit rows."""
    if len(rows):
        return np.asarray((sigma_of(rows) > tolerance).sum(axis=-1))
    return np.zeros(0, dtype=int)


def _middle(screws: Array) -> tuple[Array, float]:
    """A point amid the axes and their largest distance from it (1 where they meet): for well-scaled columns."""
    size = np.linalg.norm(screws[:, :3], axis=1)
    turning = size > NO_TURN * np.linalg.norm(screws, axis=1)
    if not turning.any():
        return np.zeros(3), 1.0
    rows = screws[turning]
    points = cross(rows[:, :3], rows[:, 3:]) / size[turning, None] ** 2
    point = points.mean(axis=0)
    length = float(np.linalg.norm(points - point, axis=1).max())
    return point, length if length > 1e-9 else 1.0
