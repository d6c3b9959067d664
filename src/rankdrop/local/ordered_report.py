"""GR's search for the joint that escapes, step by step as they print it, and beside it what the joints really do.

Three answers for every joint of an ordered screw set at a singular configuration:

1. GR as printed (sections 4 and 5): a minimal singular run, Lie products that leave its span, screws moved up to the
   end of the run only.
2. The same to first order with motion carried to the end of the chain. At the dependencies Σ λ_i S_i = 0 it is

       Σ_{i>j} λ_i [S_j, S_i]  outside  span{S_1 … S_n}

   that counts: with U₂ a basis of the lost directions and V₂ of the λ, the rank of U₂ᵀ([S_j, S_i])_{i>j} V₂ is gained.
   One product outside is not enough: the weighted sum may vanish.
3. The judge: the rank after a finite motion of the joint.

Below also a session with GR's instructions, each of which prints what theirs prints, and the report as text.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from rankdrop.errors import OptionError
from rankdrop.local.block import STRUCTURE_SEED
from rankdrop.local.ordered import OrderedScrewSet, OrderedSubset, lie_product
from rankdrop.robot.model import Array

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


@dataclass(frozen=True, slots=True)
class Step:
    """One instruction of a session and the lines it prints."""

    instruction: str
    lines: tuple[str, ...]


def session(screws: OrderedScrewSet, instructions: Sequence[Instruction] = PRINTED_IN_GR) -> tuple[Step, ...]:
    """Run GR's instructions, each printing what theirs print; `newscrews` changes the set until `readoss` restores it.

    Raises:
        OptionError: an instruction or a run that does not exist.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> steps = session(OrderedScrewSet.of(open_robot("rcrrrr"), [0.0] * 7))
        >>> [step.lines for step in steps if step.instruction.startswith("newscrews")]
        [('S(5) = [1, 0, -1, 0, 5, 0]',), ('S(4) = [0, 1, 0, 5, 0, 5]', 'S(5) = [1, 0, -1, 0, 0, 0]')]
    """
    current, steps = screws, []
    for name, first, last in instructions:
        lines: tuple[str, ...]
        if name == "readoss":
            rows = current.screws.copy()
            rows[first - 1 : last] = screws.readoss(first, last)
            current = OrderedScrewSet(rows, screws.tolerance)
            lines = tuple(_row(row) for row in screws.readoss(first, last))
        elif name == "newscrews":
            current = current.newscrews(first, last)
            lines = tuple(f"S({k}) = {_row(current.screws[k - 1])}" for k in range(first + 1, last + 1))
        elif name == "dimension":
            lines = (str(current.dimension(first, last)),)
        elif name == "msos":
            lines = _msos_lines(current.msos(first, last))
        elif name == "subspace":
            found = current.subspace(first, last)
            lines = tuple(f"[{u}, {v}] {'yes' if inside else 'no'}" for u, v, inside in found.entries)
            lines += tuple(f"actuating screw {u} can restore ({first}, {last})" for u in found.actuators)
        else:
            allowed = "readoss, msos, subspace, newscrews, dimension"
            raise OptionError("there is no such instruction", got=repr(name), allowed=allowed)
        steps.append(Step(f"{name}({first}, {last})", lines))
    return tuple(steps)


def _msos_lines(subset: OrderedSubset) -> tuple[str, ...]:
    if subset.last - subset.first > GREATEST_RUN:  # the guard as printed: 6 < j − i
        return ("more than seven screws: take a shorter run",)
    end = "a minimal singular ordered subset" if subset.msos else "not a minimal singular ordered subset"
    return (f"dimension = {subset.dimension}", f"lost freedoms = {subset.loss}", end)


def _row(screw: Array) -> str:
    return f"[{', '.join(f'{x + 0.0:.6g}' for x in np.where(np.abs(screw) < 1e-12, 0.0, screw))}]"


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
    remark: str


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
        disagreements: where the printed procedure and the motion differ, in words.
    """

    dimension: int
    generic: int
    lost: int
    dependencies: int
    subsets: tuple[OrderedSubset, ...]
    steps: tuple[Step, ...]
    trials: tuple[Trial, ...]
    printed: tuple[int, ...]
    joints: tuple[JointVerdict, ...]
    escapes: tuple[int, ...]
    disagreements: tuple[str, ...]


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
    special = _special(screws, subsets, seed) if dimension < generic else ()
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
        steps=session(screws, instructions), trials=tuple(trials), printed=printed, joints=joints,
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
    n = len(screws)
    dimension = screws.dimension(1, n)
    everything = screws.subspace(1, n)
    outside = tuple(v for u, v, inside in everything.entries if u == number and not inside)
    carried = screws.propagated(number)
    after = max(screws.moved(number, amount).dimension(1, n) for amount in _AMOUNTS)
    weighted, rate = _first_order(screws, number, dimension, generic)
    escapes = dimension < after == generic
    return JointVerdict(
        number, printed, outside, tuple((i, j, carried.dimension(i, j)) for i, j in watched), weighted, rate,
        after - dimension, escapes, _remark(number, printed, escapes, trials, outside, weighted, after - dimension),
    )


def _disagreements(joints: Sequence[JointVerdict], trials: Sequence[Trial]) -> tuple[str, ...]:
    told = [f"joint {joint.number}: {joint.remark}" for joint in joints if joint.remark]
    named = {t.subset: [u.actuator for u in trials if u.subset == t.subset and u.restores] for t in trials}
    if len({tuple(sorted(actuators)) for actuators in named.values()}) > 1:
        parts = [f"{first}–{last}: {_list(sorted(found))}" for (first, last), found in named.items()]
        told.append(f"what the printed procedure names depends on the run it starts from ({'; '.join(parts)})")
    return tuple(told)


def _list(numbers: Sequence[int]) -> str:
    return ", ".join(map(str, numbers)) or "none"


def _first_order(screws: OrderedScrewSet, number: int, dimension: int, generic: int) -> tuple[float, float]:
    """Size of the weighted sums Σ_{i>j} λ_i [S_j, S_i], and the rate at which σ_generic leaves zero."""
    n = len(screws)
    u, _, vt = np.linalg.svd(screws.screws.T)
    dependencies = vt[dimension:].T
    products = np.zeros((6, n))
    for i in range(number, n):
        products[:, i] = lie_product(screws.screws[number - 1], screws.screws[i])
    sums = products @ dependencies
    weighted = float(np.linalg.norm(sums, 2)) if sums.size else 0.0
    if generic == dimension:
        return _clean(weighted), 0.0
    gained = np.linalg.svd(u[:, dimension:].T @ sums, compute_uv=False)
    return _clean(weighted), _clean(float(gained[generic - dimension - 1]))


def _remark(
    number: int, printed: bool, escapes: bool, trials: Sequence[Trial], outside: tuple[int, ...], weighted: float,
    gain: int,
) -> str:  # fmt: skip
    """Why the printed procedure and the motion disagree; empty where they agree and nothing misleads."""
    if escapes and not printed:
        left = [t for t in trials if t.actuator == number]
        if left and any(t.dimensions != t.carried for t in left):
            last = left[0].subset[1]
            return (
                f"escapes, though the printed update finds runs still singular: newscrews({number}, {last}) leaves "
                f"the screws behind {last} where they were, and joint {number} carries them too"
            )
        return "escapes, though no run with all its products outside names it"
    if printed and not escapes:
        return "named by the printed procedure, but a finite motion does not restore the rank"
    if outside and gain == 0:
        later = ", ".join(f"[{number}, {k}]" for k in outside)
        how = "vanishes" if weighted == 0.0 else "stays in the span"
        verb = "lies" if len(outside) == 1 else "lie"
        return f"does not escape although {later} {verb} outside the span: Σ λ_i [S_{number}, S_i] {how}"
    return ""


def _special(screws: OrderedScrewSet, subsets: Sequence[OrderedSubset], seed: int) -> tuple[OrderedSubset, ...]:
    """Runs that lose more here than at almost every configuration, in the order of their numbers."""
    elsewhere = [_elsewhere(screws, seed + i) for i in range(2)]
    kept = [s for s in subsets if max(other.dimension(s.first, s.last) for other in elsewhere) > s.dimension]
    return tuple(sorted(kept, key=lambda s: (s.last - s.first == len(screws) - 1, s.first, s.last)))


def _generic(screws: OrderedScrewSet, seed: int) -> int:
    return max(_elsewhere(screws, seed + i).dimension(1, len(screws)) for i in range(4))


def _elsewhere(screws: OrderedScrewSet, seed: int) -> OrderedScrewSet:
    """The chain after a random motion of every joint; the last one first, so that each still stands in its place."""
    amounts = np.random.default_rng(seed).uniform(-np.pi, np.pi, len(screws))
    for number in range(len(screws), 0, -1):
        screws = screws.moved(number, float(amounts[number - 1]))
    return screws


def _clean(value: float) -> float:
    return 0.0 if abs(value) < 1e-9 else value


def render(report: OrderedReport) -> str:
    """The whole report, one line a fact; lines end without blanks.

    Example:
        >>> from rankdrop.local.ordered import OrderedScrewSet
        >>> from rankdrop.local.ordered_report import report
        >>> from rankdrop.robot.open import open_robot
        >>> text = render(report(OrderedScrewSet.of(open_robot("rcrrrr"), [0.0] * 7)))
        >>> print(text.splitlines()[0])
        7 screws of dimension 5, elsewhere 6: 1 task freedom lost, 2 dependencies
    """
    return "\n".join(_lines(report)) + "\n"


def _lines(report: OrderedReport) -> Iterator[str]:
    screws = report.dimension + report.dependencies
    lost = f"{report.lost} task freedom{'' if report.lost == 1 else 's'} lost" if report.lost else "not singular"
    both = f"{report.dependencies} dependenc{'y' if report.dependencies == 1 else 'ies'}"
    yield f"{screws} screws of dimension {report.dimension}, elsewhere {report.generic}: {lost}, {both}"
    if report.subsets:
        yield ""
        yield "Runs with a loss (screws, dimension, loss):"
        for run in report.subsets:
            marks = (", passes the msos test" if run.msos else "") + (", minimal" if run.minimal else "")
            yield f"  {run.first}–{run.last}  {run.dimension}  {run.loss}{marks}"
    yield ""
    yield "As printed (screws moved up to the end of the run only):"
    for step in report.steps:
        yield f"  {step.instruction};"
        yield from (f"    {line}" for line in step.lines)
    if report.lost:
        yield f"  conclusion: actuate {_list(report.printed)}"
        yield ""
        yield from _corrected(report)


def _corrected(report: OrderedReport) -> Iterator[str]:
    for trial in report.trials:
        if trial.dimensions != trial.carried:
            yield (
                f"newscrews({trial.actuator}, {trial.subset[1]}): dimensions {_dimensions(trial, carried=False)} as "
                f"printed, {_dimensions(trial, carried=True)} with every later screw carried along"
            )
    yield ""
    yield "Every joint, carried to the end of the chain, and judged by finite motion:"
    for joint in report.joints:
        runs = " ".join(f"{i}–{j}:{d}" for i, j, d in joint.dimensions)
        verdict = "escapes" if joint.escapes else f"gains {joint.gain}" if joint.gain else "does not escape"
        yield f"  joint {joint.number}  {verdict}, rate {joint.rate:.4f}, dimensions {runs}"
    yield f"  conclusion: actuate {_list(report.escapes)}"
    if report.disagreements:
        yield ""
        yield "Disagreements with the printed procedure:"
        yield from (f"  {told}" for told in report.disagreements)


def _dimensions(trial: Trial, *, carried: bool) -> str:
    return " ".join(f"{i}–{j}:{d}" for i, j, d in (trial.carried if carried else trial.dimensions))
