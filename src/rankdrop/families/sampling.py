"""More points of one family, by random steps along its tangent.

Of joints on one axis only the sum of their angles matters, and one of them stands for both. Where the axes of joints i
and j are one line at every configuration, singular values depend on θ_i + s θ_j alone, with s = ±1 as they turn the
same way or not. An equation is fitted in one joint less, at θ_j = 0, and written with the sum.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from rankdrop.families.linear import Linear, Values
from rankdrop.families.searching import refine
from rankdrop.families.signature import Inspection, Signature, inspect
from rankdrop.family.equation import Equation, Term, normalised
from rankdrop.problem import Problem, Twin, wrap
from rankdrop.robot.model import Array


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


def polished(problem: Problem, q: Array) -> Array:
    """Singular points driven on to σ ≤ 1e-15: signatures of arms that are nearly special need it."""
    if not len(q):
        return q
    finer = replace(problem.tolerances, target=POLISHED)
    found = refine(
        problem.robot, q, problem.corank, task=problem.task, limits=problem.limits, iterations=8, tolerances=finer
    )
    better = found.sigma[:, problem.rank] <= problem.tolerances.singular
    return np.where(better[:, None], found.q, q)


def smooth(problem: Problem, inspection: Inspection, members: Array, rng: np.random.Generator) -> bool:
    """Whether ker D is the tangent space: a step ε along it is ε² away from the set, not ε as where families meet."""
    chosen = members[:: max(1, len(members) // 8)][:8]
    q, tangent = inspection.q[chosen], inspection.tangent[chosen]
    step = np.einsum("nij,nj->ni", tangent, rng.standard_normal(q.shape))
    step *= 0.01 / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-300)
    back = refine(problem.robot, q + step, problem.corank, task=problem.task, tolerances=problem.tolerances)
    way = np.linalg.norm(wrap(back.q - q - step), axis=1)
    return bool(np.median(way) < 0.2 * 0.01)


@dataclass(eq=False)
class Supply:
    """Points of one family with one combination of values; makes more when asked.

    Attributes:
        q: (N, n) points so far, in no special order: a fit needs them spread over the family.
        tangent: (N, n, n) projectors on the tangent space there.
        more: how points that the search brought back are inspected; None: polished, then by D.
    """

    problem: Problem
    signature: Signature
    linear: Linear
    values: Values
    q: Array
    tangent: Array
    rng: np.random.Generator
    more: Callable[[Array], Inspection] | None = None
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
        problem = self.problem
        start = self.q[base] + step
        found = refine(problem.robot, start, problem.corank, task=problem.task, tolerances=problem.tolerances)
        back = found.converged
        inspection = inspect(problem, polished(problem, back)) if self.more is None else self.more(back)
        same = np.array([s == self.signature for s in inspection.signatures], dtype=np.bool_)
        same &= inspection.sigma[:, problem.rank] <= 1e-12 if len(same) else same
        off = self.linear.values(inspection.q) - np.array(self.values)
        off = np.where(self.linear.periodic, wrap(off), off)
        same &= (np.abs(off) < SAME).all(axis=1)
        if same.sum() < 0.02 * batch:
            self.exhausted = True
        self.q = np.concatenate([self.q, inspection.q[same]])
        self.tangent = np.concatenate([self.tangent, inspection.tangent[same]])
