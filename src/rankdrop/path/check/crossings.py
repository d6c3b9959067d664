"""Where a path crosses a singularity or touches it: what every sliver holds that is not proven free.

A sliver is decided by signs: where a determinant or a family's condition has opposite signs, beyond rounding, on both
sides, the path crosses, by the intermediate value theorem. Where σ_r is within the tolerance and no sign changes it
touches, which is a measurement: a path that passes at 1e-10, or crosses twice within as little, looks the same.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rankdrop import _core
from rankdrop.errors import RankdropError
from rankdrop.families.record import Family
from rankdrop.kinematics import chain_of, task_view
from rankdrop.local.block import generic_rank, joint_scale, singular_values
from rankdrop.path.check.prove import Sliver
from rankdrop.path.check.record import CROSSING, TOUCHING, UNDECIDED, Closest, Evidence, Stretch, Verdict
from rankdrop.path.curve import Curve, Index, Place
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
_LYING = 1e-3  # slivers longer than this, singular at every point evaluated, lie in the singular set [rad]
SPOTS = 12  # families fitted or named, and nearest points searched, without an atlas: some 0.1 s each
Signs = Callable[[Array], NDArray[np.int8]]
"""(N, n) configurations -> +1, −1, or 0 where rounding could have made the sign."""
SignFunctions = dict[str, Signs]
"""Left-hand side of a condition, "" for the determinant -> its signs; a change of sign proves a crossing."""


def crossings(
    robot: Robot, task: Task, path: Curve, slivers: Sequence[Sliver], families: Sequence[Family], tolerances: Tolerances
) -> tuple[Stretch, ...]:
    """What every sliver holds, in order along the path; where it is nearest to a singularity, the configuration.

    Args:
        robot, task: the arm and its task.
        path: the curve.
        slivers: from `prove`.
        families: known ones; the sign of a single condition shows crossings.
        tolerances: `singular`.
    """
    functions = signs(robot, task, families)
    every: list[Stretch] = []
    looks = SPOTS
    for sliver in slivers:
        judge = _Judge(robot, task, path, sliver, functions, tolerances)
        part = judge.crossings()
        touched = [
            crossing for crossing in part if crossing.verdict == TOUCHING and crossing.corank == 1 and not crossing.lies
        ][:looks]
        looks -= len(touched)
        more = signs_at(robot, task, [crossing.closest.q for crossing in touched], tolerances)
        if more.keys() - functions.keys():
            functions = functions | more
            part = replace(judge, functions=functions).crossings()
        every += part
    return tuple(every)


def signs(robot: Robot, task: Task, families: Sequence[Family]) -> SignFunctions:
    """The determinant, and conditions of families of one condition that passed their test."""
    square = robot.n == task.m == generic_rank(robot, task)
    functions: SignFunctions = {"": _determinant(robot, task)} if square else {}
    single = (family for family in families if family.dimension == robot.n - 1 and len(family.equations) == 1)
    return functions | {family.equations[0].text(): _condition(family) for family in single if family.soundness.holds}


def signs_at(robot: Robot, task: Task, configurations: Sequence[Array], tolerances: Tolerances) -> SignFunctions:
    """As `signs`, of families of one condition that no list has: through configurations (n,) of corank 1.

    The condition is fitted to the neighbourhood, and used where random solutions of it, anywhere, are singular.
    """
    from rankdrop.families.on_the_spot import name_on_the_spot  # a path free of singularities does without
    from rankdrop.families.soundness import soundness

    values: SignFunctions = {}
    problem = Problem(robot, task, 1, tolerances)
    for q in configurations:
        try:
            family = name_on_the_spot(robot, q, task, 1, fit=True, tolerances=tolerances)
        except RankdropError:  # rounding: singular to the tolerance and not to that of its neighbours
            continue
        single = family.dimension == robot.n - 1 and len(family.equations) == 1
        if single and soundness(problem, family.system, 1, np.random.default_rng(0))[0].holds:
            values[family.equations[0].text()] = _condition(family)
    return values


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


def smallest_sigma(robot: Robot, task: Task, q: Array) -> Array:
    """(...) σ_r at q (..., n); 0 of a task in which nothing moves."""
    rank = generic_rank(robot, task)
    if rank:
        return np.asarray(singular_values(robot, q, task)[..., rank - 1])
    return np.zeros(q.shape[:-1])


@dataclass(frozen=True, eq=False)
class _Judge:
    """One sliver; places on it are counted in stretches from its first one."""

    robot: Robot
    task: Task
    path: Curve
    sliver: Sliver
    functions: SignFunctions
    tolerances: Tolerances

    def crossings(self) -> list[Stretch]:
        finished = self.sliver[2]
        places = self._places()
        if not finished:
            return self._crossings_seen(self._distinct(self._changes(places, places)), places)
        # a place next to each end, in what is free: a zero at an end has no certain sign on both sides
        width = places[-1] - places[0]
        limit = self.sliver[1][0] - self.sliver[0][0] + 1.0
        wide = np.unique(np.clip([places[0] - width, *places, places[-1] + width], 0.0, limit))
        lying = self._lying(places)
        changes = self._changes(places, wide)
        for stretch in lying:
            changes = [part for part in changes if not self._meet(part, stretch)]
        parts = sorted([*self._distinct(changes), *lying], key=lambda part: part.closest.place)
        if parts:
            return self._spread(parts)
        return [self._still(places)]

    def _places(self) -> Array:
        """(N,) where the path is evaluated, in ascending order."""
        (first, start), (last, end), finished = self.sliver
        size = last - first
        if finished:
            count = _LOOKS
        else:
            count = _DENSE
        places = np.linspace(start, size + end, count)
        if size < count:  # the samples between too while there are few
            places = np.concatenate([places, np.arange(1, size + 1, dtype=np.float64)])
        return np.unique(np.clip(places, start, size + end))

    def _changes(self, places: Array, wide: Array) -> list[Stretch]:
        """Changes of sign of all functions between `wide` places, those of them that are in the sliver."""
        samples = self._configurations(wide)
        stretches = []
        for condition, function in self.functions.items():
            evidence: Evidence = "determinant"
            if condition:
                evidence = "condition"
            for low, high in self._brackets(wide, function(samples), function):
                if places[0] <= high and low <= places[-1]:
                    stretches.append(self._part(CROSSING, low, high, (low + high) / 2, evidence, condition))
        return stretches

    @staticmethod
    def _meet(part: Stretch, other: Stretch) -> bool:
        return part.bracket[0] <= other.bracket[1] and other.bracket[0] <= part.bracket[1]

    def _lying(self, places: Array) -> list[Stretch]:
        """Where the path does not leave the singular set.

        Functions that are zero all the time change no sign there, and others, as that of the wrist on a path in the
        elbow, tell of a singularity in the singularity.
        """
        q = self._configurations(places)
        singular = smallest_sigma(self.robot, self.task, q) <= self.tolerances.singular
        lengths = np.linalg.norm(np.diff(q, axis=0) / joint_scale(self.robot, self.task), axis=1)
        ends = np.flatnonzero(np.diff(np.concatenate([[False], singular, [False]]).astype(int)))
        stretches = []
        for first, last in ends.reshape(-1, 2):
            if lengths[first : last - 1].sum() > _LYING:
                at = self._typical(places[first:last], q[first:last])
                low, high = float(places[first]), float(places[last - 1])
                stretches.append(self._part(TOUCHING, low, high, at, "singular throughout"))
        return stretches

    def _spread(self, parts: list[Stretch]) -> list[Stretch]:
        """Crossings that share the sliver: none of it is proven free."""
        middles = [self._place((self._count(first.bracket[1]) + self._count(second.bracket[0])) / 2)
                   for first, second in pairwise(parts)]  # fmt: skip
        ends = [self.path.place(self.sliver[0]), *middles, self.path.place(self.sliver[1])]
        return [replace(part, start=ends[k], end=ends[k + 1]) for k, part in enumerate(parts)]

    def _crossings_seen(self, parts: list[Stretch], places: Array) -> list[Stretch]:
        """The work ended early: crossings that were seen, and the parts between them, undecided."""
        cuts = [float(places[0])]
        for part in parts:
            cuts += [self._count(part.bracket[0]), self._count(part.bracket[1])]
        cuts.append(float(places[-1]))
        out = list(parts)
        for low, high in zip(cuts[::2], cuts[1::2], strict=True):
            inside = places[(places >= low) & (places <= high)]
            if high > low:
                if len(inside):
                    at = self._least(inside)[0]
                else:
                    at = (low + high) / 2
                out.append(self._part(UNDECIDED, low, high, at, "unfinished"))
        return sorted(out, key=lambda part: (part.start, part.end))

    def _count(self, place: Place) -> float:
        return place.row - 1 - self.sliver[0][0] + place.share

    def _split(self, places: Array) -> tuple[Index, Array]:
        first, last = self.sliver[0][0], self.sliver[1][0]
        whole = np.clip(np.floor(places), 0, last - first).astype(np.int64)
        return first + whole, places - whole

    def _configurations(self, places: Array) -> Array:
        return self.path.at(*self._split(places))

    def _place(self, place: float) -> Place:
        stretch, share = self._split(np.array([place]))
        return self.path.place((int(stretch[0]), float(share[0])))

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
            at_middle = function(self._configurations(middle))
            for side, target in ((at_middle == left[active], low), (at_middle == -left[active], high)):
                target[active[side]] = middle[side]
            active = active[at_middle != 0]  # at the zero itself, as far as rounding tells
        return list(zip(low.tolist(), high.tolist(), strict=True))

    def _part(
        self, verdict: Verdict, low: float, high: float, at: float, evidence: Evidence, condition: str = ""
    ) -> Stretch:
        q = self._configurations(np.array([at]))[0]
        sigma = singular_values(self.robot, q, self.task)
        rank = generic_rank(self.robot, self.task)
        if verdict == UNDECIDED:
            corank = 0
        else:
            corank = rank - int((sigma[:rank] > self.tolerances.singular).sum())
        q.flags.writeable = False
        ends = self._place(low), self._place(high)
        closest = Closest(self._place(at), q, 0.0, q, float(sigma[rank - 1]) if rank else 0.0, np.nan)
        return Stretch(*ends, ends, verdict, closest, evidence, condition, corank, evidence == "singular throughout")

    def _distinct(self, parts: list[Stretch]) -> list[Stretch]:
        """One crossing for zeros of several functions at the same place; a zero where σ is not zero is none."""
        scale = joint_scale(self.robot, self.task)
        kept: list[Stretch] = []
        for part in parts:
            others = [other.closest.q for other in kept if other.condition != part.condition]
            same = (np.linalg.norm((part.closest.q - q) / scale) < _SAME for q in others)
            if part.corank and not any(same):
                kept.append(part)
        return sorted(kept, key=lambda part: part.closest.place)

    def _still(self, places: Array) -> Stretch:
        """No change of sign: the point of least σ."""
        limit, low, high = self.tolerances.singular, float(places[0]), float(places[-1])
        at, least = self._least(places)
        if least <= limit:
            return self._part(TOUCHING, low, high, at, "small sigma")
        return self._part(UNDECIDED, low, high, at, "no enclosure")

    def _typical(self, places: Array, q: Array) -> float:
        """Of places that are all singular: near their middle, and away from those at which the rank drops further.

        Args:
            places: (N,) in ascending order.
            q: (N, n) there.
        """
        limit = self.tolerances.singular
        sigma = singular_values(self.robot, q, self.task)[:, : generic_rank(self.robot, self.task)]
        least_corank = int((sigma <= limit).sum(axis=1).min())
        middle = (places[0] + places[-1]) / 2
        if least_corank < sigma.shape[1]:
            next_sigma = sigma[:, -1 - least_corank]
            places = places[next_sigma >= next_sigma.max() / 2]
        return float(places[np.abs(places - middle).argmin()])

    def _least(self, places: Array) -> tuple[float, float]:
        """The place of least σ, zoomed in around the least sample."""
        best, least = 0.0, np.inf
        for _ in range(13):
            values = smallest_sigma(self.robot, self.task, self._configurations(places))
            k = int(values.argmin())
            if values[k] < least:
                best, least = float(places[k]), float(values[k])
            places = np.linspace(places[max(k - 1, 0)], places[min(k + 1, len(places) - 1)], 9)
        return best, least
