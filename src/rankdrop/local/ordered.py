"""Ordered screw sets and the procedures of Gallardo-Alvarado and Rico-Martínez (GR, sections 2 to 5).

Here a screw is (s; s_o) as in GR, direction first, moment about the point O second, and screws are numbered from 1. The
moment of a line through p is s_o = p × s (+ pitch · s). The Lie product is GR's equation 2,

    [S_1, S_2] = (s_1 × s_2 ; s_1 × s_o2 − s_2 × s_o1),

and joint j at small time t carries every later screw: S_k(t) = S_k + [S_j, S_k] t, k > j (rule 1).

`report` gives three answers for every joint of a set at a singular configuration. First GR as printed (sections 4 and
5): a minimal singular run, Lie products that leave its span, screws moved up to the end of the run only. Second the
same to first order with the motion carried to the end of the chain. With the dependencies Σ λ_i S_i = 0 the sum

    Σ_{i>j} λ_i [S_j, S_i]  outside  span{S_1 … S_n}

decides: with U₂ a basis of the lost directions and V₂ of the λ, the rank of U₂ᵀ([S_j, S_i])_{i>j} V₂ is gained. One
product outside is not enough, because the weighted sum may vanish. Third the judge: the rank after a finite motion of
the joint.

`executed` runs GR's instructions, `session` prints what theirs print; `rankdrop.text.procedure_text` writes a report.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property, lru_cache
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from rankdrop.configuration import Configuration, at
from rankdrop.errors import OptionError, RobotError
from rankdrop.kinematics import jacobian, one_configuration, task_jacobian_derivative
from rankdrop.local.block import STRUCTURE_SEED, sigma_of, structural_sample
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.robot.screws import from_screws, read_screw_list
from rankdrop.robot.transform import bracket, cross, hat, unit
from rankdrop.sections import words_of
from rankdrop.task import SPACE, Task
from rankdrop.tolerances import DEFAULT, DEPENDENT, Tolerances

NO_TURN = 1e-12
"""A direction shorter than this share of the whole screw: a slide."""


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


_SAMPLES = 4  # random configurations that tell which losses hold everywhere


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
        rows, n, found = self._rows(self.screws), len(self), dict[tuple[int, int], int]()
        for size in range(1, n + 1):
            ranks = _ranks(np.stack([rows[i : i + size] for i in range(n - size + 1)]), self.tolerance)
            found |= {(i, i + size - 1): int(rank) for i, rank in enumerate(ranks, 1)}
        return found

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
        with_product = np.array([[*run, self._sized(self.lie(u, v))] for u, v in pairs])
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

    def _sized(self, screw: Array) -> Array:
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
    found = []
    for run in runs:
        generic = all(other.dimension(run.first, run.last) == run.dimension for other in elsewhere)
        found.append(replace(run, generic=generic))
    return tuple(found)


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


Instruction = tuple[str, int, int]

PRINTED_IN_GR: tuple[Instruction, ...] = (
    ("readoss", 1, 7),
    ("msos", 1, 5),
    ("subspace", 1, 5),
    ("newscrews", 4, 5),
    ("dimension", 1, 5),
    ("dimension", 1, 6),
    ("readoss", 4, 5),
    ("newscrews", 3, 5),
    ("dimension", 1, 5),
    ("dimension", 1, 6),
    ("dimension", 2, 7),
)
"""The instructions of GR's section 5, in their order."""

GREATEST_RUN = 6
"""GR section 2.2: a run has at most six screws."""


@dataclass(frozen=True, eq=False)
class Executed:
    """One instruction of a session, and what it finds.

    Attributes:
        name, first, last: the instruction and its arguments.
        found: screws (k, 6) of `readoss` (first … last) and of `newscrews` (those after first, to last); the run of
            `msos`; the Lie products of `subspace`; the number of `dimension`.
    """

    name: str
    first: int
    last: int
    found: Array | OrderedSubset | Products | int

    @property
    def text(self) -> tuple[str, tuple[str, ...]]:
        """The instruction as it is typed, and the lines that it prints."""
        text: tuple[str, tuple[str, ...]] = words_of(self).step_text(self)
        return text

    def __json__(self) -> list[object]:
        instruction, lines = self.text
        return [instruction, list(lines)]


def session(
    screws: OrderedScrewSet, instructions: Sequence[Instruction] = PRINTED_IN_GR
) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Run GR's instructions: each as it is typed, with the lines that it prints. `executed` has them as numbers.

    Raises:
        OptionError: an instruction or a run that does not exist.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> steps = session(OrderedScrewSet.of(open_robot("rcrrrr"), [0.0] * 7))
        >>> [lines for instruction, lines in steps if instruction.startswith("newscrews")]
        [('S(5) = [1, 0, -1, 0, 5, 0]',), ('S(4) = [0, 1, 0, 5, 0, 5]', 'S(5) = [1, 0, -1, 0, 0, 0]')]
    """
    return tuple(step.text for step in executed(screws, instructions))


def executed(
    screws: OrderedScrewSet, instructions: Sequence[Instruction] = PRINTED_IN_GR
) -> tuple[Executed, ...]:
    """Run GR's instructions; `newscrews` changes the set until `readoss` restores it.

    Args:
        screws: the set that the first instruction works on.
        instructions: (name, first, last) of each, `PRINTED_IN_GR` those of section 5.

    Raises:
        OptionError: an instruction or a run that does not exist.
    """
    current, steps = screws, list[Executed]()
    for name, first, last in instructions:
        found: Array | OrderedSubset | Products | int
        match name:
            case "newscrews":
                current = current.newscrews(first, last)
                found = current.screws[first:last]
            case "readoss":
                rows = current.screws.copy()
                rows[first - 1 : last] = screws.readoss(first, last)
                current = OrderedScrewSet(rows, screws.tolerance)
                found = current.readoss(first, last)
            case "msos":
                found = current.msos(first, last)
            case "subspace":
                found = current.subspace(first, last)
            case "dimension":
                found = current.dimension(first, last)
            case _:
                raise OptionError("there is no such instruction", got=repr(name), allowed=", ".join(_INSTRUCTIONS))
        steps.append(Executed(name, first, last, found))
    return tuple(steps)


_INSTRUCTIONS = ("readoss", "msos", "subspace", "newscrews", "dimension")

_AMOUNTS = (0.37, -0.23, 0.1)  # finite motions that judge [rad, or the set's unit of length]: no simple fractions of π


@dataclass(frozen=True, slots=True)
class Trial:
    """One actuator that GR's procedure proposes for a minimal singular run.

    Attributes:
        subset: (first, last) of the run.
        actuator: the screw, from 1.
        dimensions: (first, last, dimension) of the singular runs of at most six screws after `newscrews`, as GR have
            it.
        carried: the same with the motion carried to the end of the chain.
        restores: every one of these runs is independent after `newscrews`: GR's conclusion.
    """

    subset: tuple[int, int]
    actuator: int
    dimensions: tuple[tuple[int, int, int], ...]
    carried: tuple[tuple[int, int, int], ...]
    restores: bool


class RemarkKind(StrEnum):
    """How GR's printed procedure and a finite motion of one joint compare."""

    AGREES = "agrees"
    NOT_RESTORED = "not restored"
    NO_GAIN = "no gain"
    NAMED_BY_NO_RUN = "unnamed"
    LEFT_SINGULAR = "left singular"


@dataclass(frozen=True, slots=True)
class Remark:
    """Why the printed procedure and the motion of a joint disagree, or what misleads; a sentence as text and in JSON.

    Attributes:
        kind: `NOT_RESTORED`: named, and the motion does not restore the rank; `NO_GAIN`: it does not escape, with Lie
            products outside the span; `NAMED_BY_NO_RUN`: it escapes, and no run names it; `LEFT_SINGULAR`: it escapes,
            and the printed update leaves runs singular.
        number: of the joint, from 1.
        outside: later screws with Lie products outside the span, where nothing is gained.
        vanishes: the weighted sum of these is zero, and not only inside the span.
        last: of the run that the printed update moves, where it leaves runs singular.
    """

    kind: RemarkKind
    number: int
    outside: tuple[int, ...] = ()
    vanishes: bool = False
    last: int = 0

    def __str__(self) -> str:
        words: str = words_of(self).remark_text(self)
        return words

    def __json__(self) -> str:
        return str(self)


@dataclass(frozen=True, slots=True)
class Disagreement:
    """Where the printed procedure and the motion differ; a sentence as text and in JSON.

    Attributes:
        remark: on one joint; None where the procedure names other joints for other runs.
        named: (first, last, actuators) of each run that the procedure may start from, where these differ.
    """

    remark: Remark | None
    named: tuple[tuple[int, int, tuple[int, ...]], ...] = ()

    def __str__(self) -> str:
        words: str = words_of(self).disagreement_text(self)
        return words

    def __json__(self) -> str:
        return str(self)


@dataclass(frozen=True, slots=True)
class JointVerdict:
    """One joint, by all three ways.

    Attributes:
        number: from 1.
        printed: GR's procedure ends with this joint as an actuator.
        outside: the later screws i with [S_j, S_i] outside the span of all screws: receptors, in GR's word.
        dimensions: (first, last, dimension) of every singular run after the first-order motion carried to the end.
        weighted: largest length of Σ_{i>j} λ_i [S_j, S_i] over the dependencies λ of unit length, inside the span or
            outside.
        rate: σ_r leaves zero at this rate, r the rank of almost all configurations, in the units of the screws about O
            [per rad or per unit of length]; 0.0 where not at first order.
        gain: rank after a finite motion − rank before.
        escapes: that motion reaches the rank of almost all configurations.
        remark: where the printed procedure and the motion disagree, why.
    """

    number: int
    printed: bool
    outside: tuple[int, ...]
    dimensions: tuple[tuple[int, int, int], ...]
    weighted: float
    rate: float
    gain: int
    escapes: bool
    remark: Remark


@dataclass(frozen=True, slots=True)
class OrderedReport:
    """Everything about one ordered screw set.

    Attributes:
        dimension: of the span of all screws.
        generic: dimension at almost every configuration of this chain.
        lost: generic − dimension: task freedoms lost.
        dependencies: screws − dimension: what GR count as freedoms lost at first.
        subsets: runs with a loss.
        steps: the session, as GR would have run it, for every minimal singular run.
        trials: the actuators it proposes.
        printed: those that its conclusion names, for the first minimal run; GR stop there.
        joints: verdicts, one for every joint.
        escapes: joints that do escape, by finite motion.
        disagreements: where the printed procedure and the motion differ.
    """

    dimension: int
    generic: int
    lost: int
    dependencies: int
    subsets: tuple[OrderedSubset, ...]
    steps: tuple[Executed, ...]
    trials: tuple[Trial, ...]
    printed: tuple[int, ...]
    joints: tuple[JointVerdict, ...]
    escapes: tuple[int, ...]
    disagreements: tuple[Disagreement, ...]


def report(screws: OrderedScrewSet, seed: int = STRUCTURE_SEED) -> OrderedReport:
    """GR's search on any ordered screw set, the same with the whole chain carried along, and finite motion as judge.

    Args:
        screws: the set. Where it is not singular, there are no trials and every joint's gain is zero.
        seed: of the random configurations that tell the rank of almost all.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> found = report(OrderedScrewSet.of(open_robot("rcrrrr"), [0.0] * 7))
        >>> found.printed, found.escapes, [round(joint.rate, 4) for joint in found.joints if joint.escapes]
        ((3,), (3, 4), [0.7036, 2.0713])
    """
    n = len(screws)
    dimension, generic = screws.dimension(1, n), _generic(screws, seed)
    subsets = screws.subsets()
    if dimension < generic:
        special = _special(screws, subsets, seed)
    else:
        special = ()
    watched = tuple((s.first, s.last) for s in special if s.last - s.first < GREATEST_RUN)
    trials: list[Trial] = []
    instructions: list[Instruction] = [("readoss", 1, n)]
    for run in special:
        if run.minimal and (run.first, run.last) in watched:
            trials += _trials(screws, run, watched, instructions)
    first = trials[0].subset if trials else None
    printed = tuple(sorted(trial.actuator for trial in trials if trial.restores and trial.subset == first))
    everywhere = tuple((s.first, s.last) for s in special)
    joints = tuple(_verdict(screws, k, k in printed, generic, trials, everywhere) for k in range(1, n + 1))
    return OrderedReport(
        dimension=dimension, generic=generic, lost=generic - dimension, dependencies=n - dimension, subsets=subsets,
        steps=executed(screws, instructions), trials=tuple(trials), printed=printed, joints=joints,
        escapes=tuple(joint.number for joint in joints if joint.escapes),
        disagreements=_disagreements(joints, trials),
    )


def _trials(
    screws: OrderedScrewSet, run: OrderedSubset, watched: Sequence[tuple[int, int]], instructions: list[Instruction]
) -> list[Trial]:
    """GR's steps for one minimal singular run; the session stops at the first run that stays singular, as theirs."""
    first, last = run.first, run.last
    instructions += [("msos", first, last), ("subspace", first, last)]
    order = [(first, last), *(other for other in watched if other != (first, last))]
    trials = []
    for actuator in reversed(screws.subspace(first, last).actuators):
        new, carried = screws.newscrews(actuator, last), screws.propagated(actuator)
        dimensions = tuple((i, j, new.dimension(i, j)) for i, j in order)
        instructions.append(("newscrews", actuator, last))
        for i, j, dimension in dimensions:
            instructions.append(("dimension", i, j))
            if dimension < j - i + 1:
                break
        instructions.append(("readoss", actuator, last))
        moved = tuple((i, j, carried.dimension(i, j)) for i, j in order)
        trials.append(Trial((first, last), actuator, dimensions, moved, all(d == j - i + 1 for i, j, d in dimensions)))
    return trials


def _verdict(
    screws: OrderedScrewSet, number: int, printed: bool, generic: int, trials: Sequence[Trial],
    watched: Sequence[tuple[int, int]],
) -> JointVerdict:  # fmt: skip
    n, carried = len(screws), screws.propagated(number)
    dimension = screws.dimension(1, n)
    outside = tuple(v for u, v, inside in screws.subspace(1, n).entries if u == number and not inside)
    after = max(screws.moved(number, amount).dimension(1, n) for amount in _AMOUNTS)
    weighted, rate = _first_order(screws, number, dimension, generic)
    escapes = dimension < after == generic
    return JointVerdict(
        number, printed, outside, tuple((i, j, carried.dimension(i, j)) for i, j in watched), weighted, rate,
        after - dimension, escapes, _remark(number, printed, escapes, trials, outside, weighted, after - dimension),
    )


def _disagreements(joints: Sequence[JointVerdict], trials: Sequence[Trial]) -> tuple[Disagreement, ...]:
    found = [Disagreement(joint.remark) for joint in joints if joint.remark.kind is not RemarkKind.AGREES]
    named: dict[tuple[int, int], list[int]] = {}
    for trial in trials:
        actuators = named.setdefault(trial.subset, [])
        if trial.restores:
            actuators.append(trial.actuator)
    runs = tuple((first, last, tuple(sorted(actuators))) for (first, last), actuators in named.items())
    if len({actuators for _, _, actuators in runs}) > 1:
        found.append(Disagreement(None, runs))
    return tuple(found)


def _first_order(screws: OrderedScrewSet, number: int, dimension: int, generic: int) -> tuple[float, float]:
    """Size of the weighted sums Σ_{i>j} λ_i [S_j, S_i], and the rate at which σ_generic leaves zero."""
    u, _, vt = np.linalg.svd(screws.screws.T)
    products = np.zeros((6, len(screws)))
    for i in range(number, len(screws)):
        products[:, i] = lie_product(screws.screws[number - 1], screws.screws[i])
    sums = products @ vt[dimension:].T
    if sums.size:
        weighted = float(np.linalg.norm(sums, 2))
    else:
        weighted = 0.0
    lost = generic - dimension
    if lost:
        rate = float(np.linalg.svd(u[:, dimension:].T @ sums, compute_uv=False)[lost - 1])
    else:
        rate = 0.0
    return (0.0 if weighted < 1e-9 else weighted), (0.0 if rate < 1e-9 else rate)


def _remark(
    number: int, printed: bool, escapes: bool, trials: Sequence[Trial], outside: tuple[int, ...], weighted: float,
    gain: int,
) -> Remark:  # fmt: skip
    """Why the printed procedure and the motion disagree, or what misleads."""
    if escapes and not printed:
        return _escapes_unnamed(number, [trial for trial in trials if trial.actuator == number])
    if printed and not escapes:
        return Remark(RemarkKind.NOT_RESTORED, number)
    if outside and gain == 0:
        return Remark(RemarkKind.NO_GAIN, number, outside, vanishes=weighted == 0.0)
    return Remark(RemarkKind.AGREES, number)


def _escapes_unnamed(number: int, trials: Sequence[Trial]) -> Remark:
    """Why the printed procedure does not name a joint that escapes: its own trials."""
    if all(trial.dimensions == trial.carried for trial in trials):
        return Remark(RemarkKind.NAMED_BY_NO_RUN, number)
    return Remark(RemarkKind.LEFT_SINGULAR, number, last=trials[0].subset[1])


def _special(screws: OrderedScrewSet, subsets: Sequence[OrderedSubset], seed: int) -> tuple[OrderedSubset, ...]:
    """Runs that lose more here than at almost every configuration, in the order of their numbers."""
    elsewhere = [_moved_anywhere(screws, seed + i) for i in range(2)]
    kept = [s for s in subsets if max(other.dimension(s.first, s.last) for other in elsewhere) > s.dimension]
    return tuple(sorted(kept, key=lambda s: (s.last - s.first == len(screws) - 1, s.first, s.last)))


def _generic(screws: OrderedScrewSet, seed: int) -> int:
    return max(_moved_anywhere(screws, seed + i).dimension(1, len(screws)) for i in range(4))


def _moved_anywhere(screws: OrderedScrewSet, seed: int) -> OrderedScrewSet:
    """The chain after a random motion of every joint; the last one first, so that each still stands in its place."""
    amounts = np.random.default_rng(seed).uniform(-np.pi, np.pi, len(screws))
    for number in range(len(screws), 0, -1):
        screws = screws.moved(number, float(amounts[number - 1]))
    return screws


# σ grows at first order where it is faster than this [1/rad]: derivatives of Jacobians of unit size are good to 1e-14,
# and null vectors of an angle that is right to 1e-9 to as much
_FIRST_ORDER = 1e-7


@dataclass(frozen=True, slots=True)
class HuntJoint:
    """One column of the matrix.

    Attributes:
        number: of the joint, from 1.
        share: length of its column over that of the longest: 0 for a joint that is not in the dependency.
        named: whether the column is not zero: Hunt's responsible screws.
        actuator: GR's procedure names it, on a minimal singular run.
        rate: ∂ det J/∂q_j over the product of the other singular values: how fast σ grows [1/rad; slides: 1/length
            scale].
        tells: whether that is not zero: the matrix says that the joint leads out.
        escapes: the rank is restored after a finite motion of the joint alone.
    """

    number: int
    share: float
    named: bool
    actuator: bool
    rate: float
    tells: bool
    escapes: bool


@dataclass(frozen=True, slots=True)
class Hunt:
    """What the matrix of cofactors tells of one configuration.

    Attributes:
        applies: a square Jacobian of corank 1.
        shape: rows and columns of the Jacobian.
        lost: freedoms lost.
        matrix: (m, n) cofactors, largest entry 1, rows of the task with lengths in length scales; empty where it does
            not apply.
        joints: one per joint; empty likewise.
    """

    applies: bool
    shape: tuple[int, int]
    lost: int
    matrix: tuple[tuple[float, ...], ...] = ()
    joints: tuple[HuntJoint, ...] = ()


def hunt(
    robot: Robot | Configuration, q: ArrayLike | None = None, task: Task | str | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Hunt:  # fmt: skip
    """Hunt's matrix of cofactors (Robotica 4, 1986) at a singular configuration, judged by finite motion.

    At corank 1 of a square Jacobian, with J λ = 0 and uᵀ J = 0 (u, λ of unit length),

        cof J = ± (σ₁ … σ_{m−1}) u λᵀ

    so that column j is zero where joint j is not in the dependency, and every other column is the wrench u that no
    joint works against. By Jacobi's formula, ∂ det J/∂q_j = Σ (cof J) ∘ ∂J/∂q_j = ± (σ₁ … σ_{m−1}) uᵀ (∂J/∂q_j) λ, the
    matrix shows which joint leaves the singularity at first order. At corank 2 and more the matrix is zero, and for
    arms with more joints than rows there is none: GR's procedures are meant to remove these limits.

    Args:
        robot: the arm.
        q: (n,) configuration [rad, m].
        task: resolved.
        tolerances: `singular` decides what is lost, and whether a finite motion restores it.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("puma560")
        >>> found = hunt(arm, np.array([0.3, 0.5, 0.4, 0.2, 0.0, 0.6]), resolve_task(None, arm))
        >>> [one.number for one in found.joints if one.named], [one.number for one in found.joints if one.tells]
        ([4, 6], [5])
    """
    here = at(robot, q, task, tolerances)
    m, n = here.jacobian.shape
    left, sigma, right = np.linalg.svd(here.jacobian)
    least = here.tolerances.singular
    lost = int((sigma <= least).sum())
    if n != m or lost != 1:
        return Hunt(False, (m, n), lost)
    u, null = left[:, -1], right[-1]
    cofactors = np.linalg.det(left) * np.linalg.det(right) * np.outer(u, null)
    shares = np.abs(null) / np.abs(null).max()
    shares[shares <= DEPENDENT] = 0.0
    rates = np.einsum("i,ikj,k->j", u, task_jacobian_derivative(here.robot, here.q, here.task), null) * here.scale
    tells = np.abs(rates) > _FIRST_ORDER * max(1.0, sigma[0])
    reached = here.singular_values(here.q + np.multiply.outer(_AMOUNTS, np.diag(here.scale)))[..., -1].max(axis=0)
    escapes = reached > max(least, 10 * sigma[-1])
    actuators = _actuators(here.robot, here.q)
    columns = zip(shares.tolist(), rates.tolist(), tells.tolist(), escapes.tolist(), strict=True)
    joints = tuple(
        HuntJoint(number, share, share > 0.0, number in actuators, rate, leads, out)
        for number, (share, rate, leads, out) in enumerate(columns, 1)
    )
    largest = np.abs(cofactors).max()
    entries = np.where(np.abs(cofactors) > DEPENDENT * largest, cofactors / largest, 0.0)
    return Hunt(True, (m, n), lost, tuple(map(tuple, entries.tolist())), joints)


def _actuators(robot: Robot, q: Array) -> set[int]:
    """Joints that GR's procedure names on some minimal singular run."""
    try:
        screws = OrderedScrewSet.of(robot, q)
    except RobotError:  # mimic joints: GR's procedures do not know them
        return set()
    runs = [run for run in screws.subsets() if run.minimal and run.last > run.first]
    return {j for run in runs for j in screws.subspace(run.first, run.last).actuators}
