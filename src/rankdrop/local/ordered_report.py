"""What each joint of an ordered screw set does at a singular configuration: GR's answer, and two that check it.

First GR as printed (sections 4 and 5): a minimal singular run, Lie products that leave its span, screws moved up to the
end of the run only. Second the same to first order with the motion carried to the end of the chain. With the
dependencies Σ λ_i S_i = 0 the sum

    Σ_{i>j} λ_i [S_j, S_i]  outside  span{S_1 … S_n}

decides: with U₂ a basis of the lost directions and V₂ of the λ, the rank of U₂ᵀ([S_j, S_i])_{i>j} V₂ is gained. One
product outside is not enough, because the weighted sum may vanish. Third the judge: the rank after a finite motion of
the joint. `rankdrop.text.procedure` writes a report.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from rankdrop.local.block import STRUCTURE_SEED
from rankdrop.local.instructions import Executed, Instruction, executed
from rankdrop.local.ordered import OrderedScrewSet, OrderedSubset, lie_product
from rankdrop.sections import words_of

GREATEST_RUN = 6
"""GR section 2.2: a run has at most six screws."""


FINITE_MOTIONS = (0.37, -0.23, 0.1)
"""Finite motions that judge [rad, or the set's unit of length]: no simple fractions of π."""


@dataclass(frozen=True, slots=True)
class ProposedActuator:
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
    trials: tuple[ProposedActuator, ...]
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
    trials: list[ProposedActuator] = []
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
) -> list[ProposedActuator]:
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
        whole = all(d == j - i + 1 for i, j, d in dimensions)
        trials.append(ProposedActuator((first, last), actuator, dimensions, moved, whole))
    return trials


def _verdict(
    screws: OrderedScrewSet, number: int, printed: bool, generic: int, trials: Sequence[ProposedActuator],
    watched: Sequence[tuple[int, int]],
) -> JointVerdict:  # fmt: skip
    n, carried = len(screws), screws.propagated(number)
    dimension = screws.dimension(1, n)
    outside = tuple(v for u, v, inside in screws.subspace(1, n).entries if u == number and not inside)
    after = max(screws.moved(number, amount).dimension(1, n) for amount in FINITE_MOTIONS)
    weighted, rate = _first_order(screws, number, dimension, generic)
    escapes = dimension < after == generic
    return JointVerdict(
        number, printed, outside, tuple((i, j, carried.dimension(i, j)) for i, j in watched), weighted, rate,
        after - dimension, escapes, _remark(number, printed, escapes, trials, outside, weighted, after - dimension),
    )


def _disagreements(joints: Sequence[JointVerdict], trials: Sequence[ProposedActuator]) -> tuple[Disagreement, ...]:
    disagreements = [Disagreement(joint.remark) for joint in joints if joint.remark.kind is not RemarkKind.AGREES]
    named: dict[tuple[int, int], list[int]] = {}
    for trial in trials:
        actuators = named.setdefault(trial.subset, [])
        if trial.restores:
            actuators.append(trial.actuator)
    runs = tuple((first, last, tuple(sorted(actuators))) for (first, last), actuators in named.items())
    if len({actuators for _, _, actuators in runs}) > 1:
        disagreements.append(Disagreement(None, runs))
    return tuple(disagreements)


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
    number: int, printed: bool, escapes: bool, trials: Sequence[ProposedActuator], outside: tuple[int, ...],
    weighted: float, gain: int,
) -> Remark:  # fmt: skip
    """Why the printed procedure and the motion disagree, or what misleads."""
    if escapes and not printed:
        return _escapes_unnamed(number, [trial for trial in trials if trial.actuator == number])
    if printed and not escapes:
        return Remark(RemarkKind.NOT_RESTORED, number)
    if outside and gain == 0:
        return Remark(RemarkKind.NO_GAIN, number, outside, vanishes=weighted == 0.0)
    return Remark(RemarkKind.AGREES, number)


def _escapes_unnamed(number: int, trials: Sequence[ProposedActuator]) -> Remark:
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
