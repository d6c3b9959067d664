"""Where a path crosses a singularity, from the slivers that are not proven free.

Signs decide: where a determinant or a family's condition has opposite signs, beyond rounding, on both sides, the path
crosses, by the intermediate value theorem. Where σ_r is within the tolerance and no sign changes it touches, which is
a measurement: a path that passes at 1e-10, or crosses twice within as little, looks the same.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.errors import RankdropError
from rankdrop.families.on_the_spot import name_on_the_spot
from rankdrop.families.row import soundness
from rankdrop.family.record import Family
from rankdrop.kinematics import chain_of, task_view
from rankdrop.local.block import generic_rank, joint_scale, singular_values
from rankdrop.motion.curve import Curve, Index
from rankdrop.motion.prove import Sliver
from rankdrop.motion.record import CROSSING, TOUCHING, UNDECIDED, Evidence, Verdict
from rankdrop.problem import Problem
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import Tolerances

_LOOKS = 65  # points of a sliver
_DENSE = 1025  # points of a sliver that was not finished
_CERTAIN = 1e3 * np.finfo(float).eps  # σ_r/σ_1 above it: LU tells the sign of a determinant
_CERTAIN_F = 1e-11  # |f| above it, of coefficients of size one: the sign of a condition is beyond rounding
_HALVINGS = 60
_SAME = 1e-5  # zeros of two functions nearer to each other are one crossing: rounding blurs touching ones so far [rad]
_SPOTS = 12  # touched configurations around which a condition is looked for: some 0.1 s each
_LYING = 1e-3  # slivers longer than this, singular at every point evaluated, lie in the singular set [rad]


@dataclass(frozen=True, eq=False)
class Crossing:
    """Where a path reaches the singular set, or may.

    Attributes:
        kind: "crossing", "touching" or "undecided".
        start, end: (stretch, share) of the part of the path that is not proven free and belongs to it.
        bracket: (stretch, share) twice, in that part or next to it: a zero lies between them where it is a crossing.
        at: (stretch, share) of `q`.
        q: (n,) configuration: at the zero, where σ_r is least, or in the middle [rad, m].
        sigma: (min(m, n),) singular values there [1].
        corank: at q, by the tolerance; 0 where undecided.
        lies: σ_r is zero within the tolerance at every point evaluated from start to end, which are apart.
        evidence: how it is known.
        condition: left-hand side of the condition that changes its sign; "" for other evidence.
    """

    kind: Verdict
    start: tuple[int, float]
    end: tuple[int, float]
    bracket: tuple[tuple[int, float], tuple[int, float]]
    at: tuple[int, float]
    q: Array
    sigma: Array
    corank: int
    lies: bool
    evidence: Evidence
    condition: str = ""


Signs = Callable[[Array], NDArray[np.int8]]
"""(N, n) configurations -> +1, −1, or 0 where rounding could have made the sign."""
SignFunctions = dict[str, Signs]
"""Left-hand side of a condition, "" for the determinant -> its signs; a change of sign proves a crossing."""


def crossings(
    robot: Robot, task: Task, path: Curve, slivers: Sequence[Sliver], families: Sequence[Family], tolerances: Tolerances
) -> tuple[Crossing, ...]:
    """What every sliver holds, in order along the path.

    Args:
        robot, task: the arm and its task.
        path: the curve.
        slivers: from `prove`.
        families: known ones; the sign of a single condition shows crossings.
        tolerances: `singular`.
    """
    functions = signs(robot, task, families)
    every: list[Crossing] = []
    looks = _SPOTS
    for sliver in slivers:
        judge = _Judge(robot, task, path, sliver, functions, tolerances)
        part = judge.crossings()
        touched = [one for one in part if one.kind == TOUCHING and one.corank == 1 and not one.lies][:looks]
        looks -= len(touched)
        more = signs_at(robot, task, [one.q for one in touched], tolerances)
        if more.keys() - functions.keys():
            functions = functions | more
            part = replace(judge, functions=functions).crossings()
        every += part
    return tuple(every)


def signs(robot: Robot, task: Task, families: Sequence[Family]) -> SignFunctions:
    """The determinant, and conditions of families of one condition that passed their test."""
    square = robot.n == task.m == generic_rank(robot, task)
    found: SignFunctions = {"": _determinant(robot, task)} if square else {}
    for family in families:
        if family.dimension == robot.n - 1 and len(family.equations) == 1 and family.soundness.holds:
            found[family.equations[0].text()] = _condition(family)
    return found


def signs_at(robot: Robot, task: Task, configurations: Sequence[Array], tolerances: Tolerances) -> SignFunctions:
    """As `signs`, of families of one condition that no list has: through configurations (n,) of corank 1.

    The condition is fitted to the neighbourhood, and used where random solutions of it, anywhere, are singular.
    """
    found: SignFunctions = {}
    problem = Problem(robot, task, 1, tolerances)
    for q in configurations:
        try:
            family = name_on_the_spot(robot, q, task, 1, fit=True, tolerances=tolerances)
        except RankdropError:  # rounding: singular to the tolerance and not to that of its neighbours
            continue
        if family.dimension == robot.n - 1 and len(family.equations) == 1:
            sound, _ = soundness(problem, family.system, 1, np.random.default_rng(0))
            if sound.holds:
                found[family.equations[0].text()] = _condition(family)
    return found


def _determinant(robot: Robot, task: Task) -> Signs:
    def sign(q: Array) -> NDArray[np.int8]:
        matrix = _core.jacobian(chain_of(robot), task_view(robot, task), np.ascontiguousarray(q))
        sigma = _core.svd(matrix, False)
        certain = sigma[:, -1] > _CERTAIN * sigma[:, 0]
        return np.where(certain, np.sign(np.linalg.slogdet(matrix)[0]), 0).astype(np.int8)

    return sign


def _condition(family: Family) -> Signs:
    equation = family.equations[0]

    def sign(q: Array) -> NDArray[np.int8]:
        value = equation(q)
        return np.where(np.abs(value) > _CERTAIN_F, np.sign(value), 0).astype(np.int8)

    return sign


@dataclass(frozen=True, eq=False)
class _Judge:
    """One sliver; places on it are counted in stretches from its first one."""

    robot: Robot
    task: Task
    path: Curve
    sliver: Sliver
    functions: SignFunctions
    tolerances: Tolerances

    def crossings(self) -> list[Crossing]:
        places = self._places()
        q = self._at(places)
        parts: list[Crossing] = []
        wide = self._widen(places)
        samples = self._at(wide)
        for condition, function in self.functions.items():
            for low, high in self._brackets(wide, function(samples), function):
                evidence: Evidence = "condition" if condition else "determinant"
                parts.append(replace(self._part(CROSSING, low, high, (low + high) / 2, evidence), condition=condition))
        parts = self._distinct(parts)
        if not self.sliver.finished:
            return self._between(parts, places, q)
        return self._spread(parts) if parts else [self._still(places, q)]

    def _spread(self, parts: list[Crossing]) -> list[Crossing]:
        """Crossings that share the sliver: none of it is proven free."""
        first, last = self.sliver.stretches
        cuts = [(one.bracket[1], two.bracket[0]) for one, two in pairwise(parts)]
        middles = [self._place((self._count(low) + self._count(high)) / 2) for low, high in cuts]
        ends = [(first, self.sliver.shares[0]), *middles, (last, self.sliver.shares[1])]
        return [replace(one, start=ends[k], end=ends[k + 1]) for k, one in enumerate(parts)]

    def _between(self, parts: list[Crossing], places: Array, q: Array) -> list[Crossing]:
        """The work ended early: crossings that were seen, and the parts between them, undecided."""
        cuts = [float(places[0])]
        for one in parts:
            cuts += [self._count(one.bracket[0]), self._count(one.bracket[1])]
        cuts.append(float(places[-1]))
        out = list(parts)
        for low, high in zip(cuts[::2], cuts[1::2], strict=True):
            inside = (places >= low) & (places <= high)
            if high > low:
                at = self._least(places[inside], self._sigma(q[inside]))[0] if inside.any() else (low + high) / 2
                out.append(self._part(UNDECIDED, low, high, at, "unfinished"))
        return sorted(out, key=lambda one: (one.start, one.end))

    def _count(self, place: tuple[int, float]) -> float:
        return place[0] - self.sliver.stretches[0] + place[1]

    def _places(self) -> Array:
        """Increasing, ends included, the samples between too while there are few."""
        first, last = self.sliver.stretches
        start, end = self.sliver.shares[0], last - first + self.sliver.shares[1]
        count = _LOOKS if self.sliver.finished else _DENSE
        places = np.linspace(start, end, count)
        if last - first < count:
            places = np.concatenate([places, np.arange(1, last - first + 1, dtype=np.float64)])
        return np.unique(np.clip(places, start, end))

    def _widen(self, places: Array) -> Array:
        """With a place beside each end, in what is proven free: a zero at an end has no certain sign on both sides."""
        if not self.sliver.finished:
            return places
        first, last = self.sliver.stretches
        beside = [places[0] - (places[-1] - places[0]), *places, places[-1] + (places[-1] - places[0])]
        return np.unique(np.clip(beside, 0.0, last - first + 1.0))

    def _split(self, places: Array) -> tuple[Index, Array]:
        first, last = self.sliver.stretches
        whole = np.clip(np.floor(places), 0, last - first).astype(np.int64)
        return first + whole, places - whole

    def _at(self, places: Array) -> Array:
        return self.path.at(*self._split(places))

    def _place(self, place: float) -> tuple[int, float]:
        stretch, share = self._split(np.array([place]))
        return int(stretch[0]), float(share[0])

    def _brackets(self, places: Array, sign: NDArray[np.int8], function: Signs) -> list[tuple[float, float]]:
        """Where the sign changes, between two points where it is certain, as narrow as it stays certain."""
        certain = np.flatnonzero(sign)
        turns = np.flatnonzero(np.diff(sign[certain].astype(int)))
        low, high = places[certain[turns]].copy(), places[certain[turns + 1]].copy()
        left = sign[certain[turns]]
        active = np.arange(len(low))
        for _ in range(_HALVINGS):
            middle = (low[active] + high[active]) / 2
            apart = (middle > low[active]) & (middle < high[active])
            active, middle = active[apart], middle[apart]
            if not len(active):
                break
            found = function(self._at(middle))
            for side, target in ((found == left[active], low), (found == -left[active], high)):
                target[active[side]] = middle[side]
            active = active[found != 0]  # at the zero itself, as far as rounding tells
        return list(zip(low.tolist(), high.tolist(), strict=True))

    def _part(self, kind: Verdict, low: float, high: float, at: float, evidence: Evidence) -> Crossing:
        q = self._at(np.array([at]))[0]
        sigma = singular_values(self.robot, q, self.task)
        rank = generic_rank(self.robot, self.task)
        corank = rank - int((sigma[:rank] > self.tolerances.singular).sum())
        q.flags.writeable = sigma.flags.writeable = False
        ends = self._place(low), self._place(high)
        return Crossing(
            kind, ends[0], ends[1], ends, self._place(at), q, sigma, 0 if kind == UNDECIDED else corank,
            evidence == "singular throughout", evidence,
        )  # fmt: skip

    def _distinct(self, parts: list[Crossing]) -> list[Crossing]:
        """One crossing for zeros of several functions at the same place; a zero where σ is not zero is none."""
        scale = joint_scale(self.robot, self.task)
        kept: list[Crossing] = []
        for one in parts:
            others = [other for other in kept if other.condition != one.condition]
            if one.corank and not any(np.linalg.norm((one.q - other.q) / scale) < _SAME for other in others):
                kept.append(one)
        return sorted(kept, key=lambda one: one.at)

    def _still(self, places: Array, q: Array) -> Crossing:
        """No change of sign: the point of least σ."""
        sigma = self._sigma(q)
        length = float(np.linalg.norm(np.diff(q, axis=0) / joint_scale(self.robot, self.task), axis=1).sum())
        limit, low, high = self.tolerances.singular, float(places[0]), float(places[-1])
        if length > _LYING and bool((sigma <= limit).all()):
            return self._part(TOUCHING, low, high, (low + high) / 2, "singular throughout")
        at, least = self._least(places, sigma)
        if least <= limit:
            return self._part(TOUCHING, low, high, at, "small sigma")
        return self._part(UNDECIDED, low, high, at, "no enclosure")

    def _sigma(self, q: Array) -> Array:
        """(N,) σ_r."""
        return np.asarray(singular_values(self.robot, q, self.task)[:, generic_rank(self.robot, self.task) - 1])

    def _least(self, places: Array, sigma: Array) -> tuple[float, float]:
        """The place of least σ, zoomed in around the least sample."""
        k = int(sigma.argmin())
        low, high = float(places[max(k - 1, 0)]), float(places[min(k + 1, len(places) - 1)])
        best, least = float(places[k]), float(sigma[k])
        for _ in range(12):
            near = np.linspace(low, high, 9)
            values = self._sigma(self._at(near))
            k = int(values.argmin())
            if values[k] < least:
                best, least = float(near[k]), float(values[k])
            low, high = float(near[max(k - 1, 0)]), float(near[min(k + 1, 8)])
        return best, least
