"""More points: random configurations, and those of one family by random steps along its tangent.

Of joints on one axis only the sum of their angles matters, and one of them stands for both. Where the axes of joints i
and j are one line at every configuration, singular values depend on θ_i + s θ_j alone, with s = ±1 as they turn the
same way or not. An equation is fitted in one joint less, at θ_j = 0, and written with the sum.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from rankdrop.families.linear import Linear, Values, wrap
from rankdrop.families.searching import refine
from rankdrop.families.signature import Inspection, Signature, inspect
from rankdrop.family.equation import Equation, Term, normalised
from rankdrop.family.system import Mask
from rankdrop.local.block import sampling_box, singular_values, structural_sample
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import Tolerances

SAMPLES = 8  # configurations at which the sum is tried
SAME_SUM = 1e-12  # singular values that differ by less are the same [1]


class Twin(NamedTuple):
    """Joints on one axis, from 0: wherever θ_j occurs it stands in θ_first + sign·θ_second."""

    first: int
    second: int
    sign: int


def twins_of(robot: Robot, task: Task, irrelevant: Sequence[bool]) -> tuple[Twin, ...]:
    """Pairs of turning joints of which only the sum or the difference matters; of three on one axis two pairs.

    Args:
        robot, task: the arm.
        irrelevant: (n,) joints that do not matter at all; they are nobody's twin.
    """
    q = structural_sample(robot, task, SAMPLES)
    sigma = singular_values(robot, q, task)
    joints = [j for j in range(robot.n) if robot.periodic[j] and not irrelevant[j]]
    found: list[Twin] = []
    for place, first in enumerate(joints):
        if any(first == twin.second for twin in found):
            continue
        for second in joints[place + 1 :]:
            for sign in (1, -1):
                moved = q.copy()
                moved[:, first] += 0.7
                moved[:, second] -= sign * 0.7
                if np.abs(singular_values(robot, moved, task) - sigma).max() < SAME_SUM:
                    found.append(Twin(first, second, sign))
                    break
    return tuple(found)


def gathered(q: Array, twins: Sequence[Twin]) -> Array:
    """(N, n) the same configurations as far as singular values go, the second of each pair at zero."""
    q = np.array(q)
    for first, second, sign in twins:
        q[:, first] += sign * q[:, second]
        q[:, second] = 0.0
    return q


def gathered_tangent(tangent: Array, twins: Sequence[Twin]) -> Array:
    """(N, n, n) projectors on the tangent space of the part of a family where the second of each pair is at zero.

    A covector that vanishes on the family has c_second = sign·c_first: without that entry it is one of the part.
    """
    if not twins:
        return tangent
    n = tangent.shape[1]
    conormal = np.eye(n) - tangent
    seconds = [twin.second for twin in twins]
    conormal[:, :, seconds] = 0.0
    _, s, vt = np.linalg.svd(conormal)
    inside = (s > 0.1).astype(np.float64)  # a covector keeps at least 1/√3 of its length
    return np.asarray(np.eye(n) - np.einsum("nij,ni,nik->njk", vt, inside, vt))


def spread(equation: Equation, twins: Sequence[Twin]) -> Equation:
    """The equation with θ_first + sign·θ_second in place of θ_first."""
    if not twins:
        return equation
    return normalised([_spread(term, twins) for term in equation.terms])


def _spread(term: Term, twins: Sequence[Twin]) -> Term:
    harmonics = list(term.harmonics)
    for first, second, sign in twins:
        harmonics[second] = sign * harmonics[first]
    return replace(term, harmonics=tuple(harmonics))


ROUNDS = 12  # tangent steps of all points at most; each gives about as many points as it starts from
POLISHED = 1e-15  # σ of a polished point [1]
SAME = 1e-6  # combinations of values closer than this are the same


@dataclass(frozen=True, eq=False)
class Setting:
    """What every step of the pipeline needs to know.

    Attributes:
        robot, task: the arm.
        corank, rank: k, and the rank kept.
        tolerances: thresholds.
        limits: stay within the joint limits.
    """

    robot: Robot
    task: Task
    corank: int
    rank: int
    tolerances: Tolerances
    limits: bool = False

    def inspect(self, q: Array) -> Inspection:
        """Signatures of points."""
        return inspect(self.robot, self.task, self.rank, q, self.tolerances)

    def polished(self, q: Array) -> Array:
        """Singular points driven on to σ ≤ 1e-15: signatures of arms that are nearly special need it."""
        if not len(q):
            return q
        finer = replace(self.tolerances, target=POLISHED)
        found = refine(self.robot, q, self.corank, task=self.task, limits=self.limits, iterations=8, tolerances=finer)
        better = found.sigma[:, self.rank] <= self.tolerances.singular
        return np.where(better[:, None], found.q, q)

    def random(self, count: int, rng: np.random.Generator) -> Array:
        """(count, n) uniform configurations of the box that the search draws from."""
        lower, upper = self._box
        return rng.uniform(lower, upper, size=(count, self.robot.n))

    @cached_property
    def _box(self) -> tuple[Array, Array]:
        return sampling_box(self.robot, self.task, limits=self.limits)

    @cached_property
    def irrelevant(self) -> Mask:
        """(n,) joints on which the singular values do not depend at all (the first one, the last one, …)."""
        rng = np.random.default_rng(0)
        q = np.repeat(self.random(16, rng)[None], self.robot.n + 1, axis=0)  # (n + 1, 16, n), the last one unchanged
        j = np.arange(self.robot.n)
        q[j, :, j] = self.random(16, rng).T
        sigma = singular_values(self.robot, q.reshape(-1, self.robot.n), self.task).reshape(*q.shape[:2], -1)
        return np.asarray(np.abs(sigma[:-1] - sigma[-1]).max(axis=(1, 2)) < 1e-12)

    @cached_property
    def twins(self) -> tuple[Twin, ...]:
        """Joints on one axis."""
        return twins_of(self.robot, self.task, [bool(one) for one in self.irrelevant])

    def allowed(self, q: Array) -> Mask:
        """(N,) whether configurations respect the limits, angles up to whole turns; all True without limits."""
        ok = np.ones(len(q), dtype=np.bool_)
        if not self.limits:
            return ok
        for j, joint in enumerate(self.robot.variables):
            x = q[:, j]
            if self.robot.periodic[j] and np.isfinite(joint.lower):
                x = joint.lower - 1e-9 + np.mod(x - joint.lower + 1e-9, 2 * np.pi)
            ok &= (x >= joint.lower - 1e-9) & (x <= joint.upper + 1e-9)
        return ok


def smooth(setting: Setting, inspection: Inspection, members: Array, rng: np.random.Generator) -> bool:
    """Whether ker D is the tangent space: a step ε along it is ε² away from the set, not ε as where families meet."""
    chosen = members[:: max(1, len(members) // 8)][:8]
    q, tangent = inspection.q[chosen], inspection.tangent[chosen]
    step = np.einsum("nij,nj->ni", tangent, rng.standard_normal(q.shape))
    step *= 0.01 / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-300)
    back = refine(setting.robot, q + step, setting.corank, task=setting.task, tolerances=setting.tolerances)
    way = np.linalg.norm(wrap(back.q - q - step), axis=1)
    return bool(np.median(way) < 0.2 * 0.01)


@dataclass(eq=False)
class Supply:
    """Points of one family with one combination of values; makes more when asked.

    Attributes:
        q: (N, n) points so far, in no special order: a fit needs them spread over the family.
        tangent: (N, n, n) projectors on the tangent space there.
        inspect: how points that the search brought back are inspected; None: polished, then by D.
    """

    setting: Setting
    signature: Signature
    linear: Linear
    values: Values
    q: Array
    tangent: Array
    rng: np.random.Generator
    inspect: Callable[[Array], Inspection] | None = None
    exhausted: bool = field(default=False)

    def __call__(self, count: int) -> Array:
        """At least `count` points, somewhat more where they are there, or all that can be had."""
        for _ in range(ROUNDS):
            if len(self.q) >= count or self.exhausted:
                break
            self._more(count)
        return self.q[: count + 150]

    def _more(self, count: int) -> None:
        batch = min(max(2 * (count - len(self.q)), 64), 2000)
        base = self.rng.integers(0, len(self.q), size=batch)
        step = np.einsum("nij,nj->ni", self.tangent[base], self.rng.standard_normal((batch, self.q.shape[1])))
        length = self.rng.uniform(0.1, 1.0, size=(batch, 1))
        step *= length / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-300)
        setting = self.setting
        start = self.q[base] + step
        found = refine(setting.robot, start, setting.corank, task=setting.task, tolerances=setting.tolerances)
        back = found.converged
        inspection = setting.inspect(setting.polished(back)) if self.inspect is None else self.inspect(back)
        same = np.array([s == self.signature for s in inspection.signatures], dtype=np.bool_)
        same &= inspection.sigma[:, setting.rank] <= 1e-12 if len(same) else same
        off = self.linear.values(inspection.q) - np.array(self.values)
        off = np.where(self.linear.periodic, wrap(off), off)
        same &= (np.abs(off) < SAME).all(axis=1)
        if same.sum() < 0.02 * batch:
            self.exhausted = True
        self.q = np.concatenate([self.q, inspection.q[same]])
        self.tangent = np.concatenate([self.tangent, inspection.tangent[same]])
