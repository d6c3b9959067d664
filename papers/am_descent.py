"""AM Figures 1 to 3: steepest descent where singular values tie, and AM's treatment of ties.

AM print neither their starts nor the rule of their steps, so the figures themselves cannot be reproduced. What is
drawn are runs with an exact line search that meet a tie: their starts were picked, out of 2,000, because the treatment
of ties decides how they end. Beside them stand runs with other steps, whose gradients turn as AM's do. No verdict rests
on them alone: `paired` counts what the treatment does for all of the 2,000, and `counts` what plain descents do with
another rule of the steps, from starts that nobody picked.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from math import comb, degrees

import numpy as np
from numpy.typing import NDArray

from papers.am_method import pa10
from papers.item import Sheet, Shown
from rankdrop.families import Outcome, Search, refine, search
from rankdrop.local import sample
from rankdrop.robot import Array

SEED = 11
"""Of the starts that counts are made of."""
PAIRED = 2000
"""Starts that are descended from with and without treatment of ties."""
PAIRED_SEED = 2
TIED = 0.01
"""Relative gap below which two singular values are nearly equal here."""
TIME = "Neither the machine nor the rule of the steps is printed; benchmarks/almarkhi.py times the methods here."


@dataclass(frozen=True, slots=True)
class Run:
    """Which run stands for a figure: a line search from one of the 2,000 starts, or another rule of the steps.

    Attributes:
        corank: task freedoms to lose.
        method: "gradient", or "almarkhi" with treatment of ties.
        start: the start's number, from 1.
        seed: of the starts.
        step: share of the step to linearised zero; 0 for a line search.
        iterations: limit.
    """

    corank: int
    method: str
    start: int
    seed: int = PAIRED_SEED
    step: float = 0.0
    iterations: int = 300


RUNS = {1: Run(2, "gradient", 106), 2: Run(3, "gradient", 269), 3: Run(3, "almarkhi", 269)}
"""By figure."""
STEPPED = {
    1: Run(2, "gradient", 79, SEED, 0.1, 6000),
    2: Run(3, "gradient", 269, step=1.0),
    3: Run(3, "almarkhi", 60, SEED, 1.0),
}
"""By figure: runs whose gradients turn as AM say, by up to 180°, and by 120° on average; with an exact line search
successive gradients are square to each other."""


@dataclass(frozen=True, eq=False)
class Descent:
    """One run.

    Attributes:
        sigma: (K + 1, 6) singular values before each iteration and at the end.
        angles: (K,) between the gradients followed in an iteration and the one before [rad]; the first has none: NaN.
        rank: the singular value driven is σ[rank], counted from 0.
        outcome: how it ended.
    """

    sigma: Array
    angles: Array
    rank: int
    outcome: Outcome

    @property
    def iterations(self) -> int:
        """Steps made."""
        return len(self.sigma) - 1

    def first_tie(self, values: int = 2, gap: float = TIED) -> int | None:
        """First iteration at which σ[rank] and the next ones, `values` in all, are nearly equal; None if never."""
        near = self.sigma[:, self.rank] - self.sigma[:, self.rank + values - 1] < gap * self.sigma[:, self.rank]
        return int(np.flatnonzero(near)[0]) if near.any() else None


@cache
def run(figure: int, method: str = "") -> Descent:
    """The descent that stands for Figure 1, 2 or 3, or one from the same start by another method."""
    how = RUNS[figure]
    return descend(replace(how, method=method or how.method))


@cache
def descend(how: Run) -> Descent:
    """One run."""
    robot, task = pa10()
    start = sample(robot, task, how.start, how.seed)[-1]
    found = refine(robot, [start], how.corank, task=task, method=how.method, history=True, step=how.step,
                   iterations=how.iterations)  # fmt: skip
    assert found.history is not None
    used = int(found.iterations[0])
    return Descent(
        found.history.sigma[0, : used + 1], found.history.turning[0, :used], found.rank, Outcome(found.outcome[0])
    )


@dataclass(frozen=True, slots=True)
class Pairs:
    """What the treatment of ties does from the same starts.

    Attributes:
        starts: how many.
        both, treated, plain: converge either way, with the treatment only, without it only.
        steps: medians of the iterations of those that converge either way: with, without.
        tied: of the plain descents, those that come to a tie while the driven value is above 1e-3.
        crease, near_miss: of the plain descents, those stuck on a crease, and at a local minimum.
        work: iterations made in all the starts for each that converges: with, without.
    """

    starts: int
    both: int
    treated: int
    plain: int
    steps: tuple[float, float]
    tied: int
    crease: int
    near_miss: int
    work: tuple[float, float]

    @property
    def chance(self) -> float:
        """How often a fair coin would fall at least so unevenly: the sign test on those where the two differ."""
        differ = self.treated + self.plain
        return float(sum(comb(differ, k) for k in range(self.treated, differ + 1)) / 2**differ)


@cache
def paired(corank: int) -> Pairs:
    """2,000 starts, line search, at most 300 iterations, with and without treatment of ties."""
    robot, task = pa10()
    plain, treated = (
        search(robot, corank, task=task, starts=PAIRED, seed=PAIRED_SEED, method=method, step=0.0, iterations=300,
               history=method == "gradient")
        for method in ("gradient", "almarkhi")
    )  # fmt: skip
    one, other = plain.outcome == Outcome.CONVERGED, treated.outcome == Outcome.CONVERGED
    both = one & other
    return Pairs(
        PAIRED, int(both.sum()), int((other & ~one).sum()), int((one & ~other).sum()),
        (float(np.median(treated.iterations[both])), float(np.median(plain.iterations[both]))),
        int(_tied(plain).sum()), plain.count(Outcome.CREASE), plain.count(Outcome.NEAR_MISS),
        (float(treated.iterations.sum() / other.sum()), float(plain.iterations.sum() / one.sum())),
    )  # fmt: skip


def _tied(search: Search, values: int = 2, gap: float = TIED, above: float = 1e-3) -> NDArray[np.bool_]:
    """(N,) whether starts came to a tie of so many values while the driven one was above a bound."""
    assert search.history is not None
    sigma = search.history.sigma[:, :, search.rank :]
    near = (sigma[..., 0] - sigma[..., values - 1] < gap * sigma[..., 0]) & (sigma[..., 0] > above)
    return np.asarray(near.any(axis=1))


@dataclass(frozen=True, slots=True)
class Counts:
    """What plain descents from random starts do, none of them picked.

    Attributes:
        starts: how many.
        converged: reach the threshold.
        tied: meet σ[rank] ≈ the next one (within 1 %) before σ[rank] is below 1e-3.
        all_tied: meet all driven values within 10 %.
        turned: turn by more than 170° between two iterations.
        risen: σ[rank] goes up at some iteration.
        stuck: σ[rank] above 1e-3 at the end.
        angle: median over the converged of their mean angle between successive gradients [deg].
        angles: the smallest and the largest of these means [deg].
    """

    starts: int
    converged: int
    tied: int
    all_tied: int
    turned: int
    risen: int
    stuck: int
    angle: float
    angles: tuple[float, float]


@cache
def counts(corank: int, iterations: int, share: float) -> Counts:
    """Plain descents from 200 starts of seed 11 with a share of the step to linearised zero."""
    robot, task = pa10()
    found = search(robot, corank, task=task, starts=200, seed=SEED, method="gradient", step=share,
                   iterations=iterations, history=True)  # fmt: skip
    assert found.history is not None
    sigma, turning = found.history.sigma[:, :, found.rank], found.history.turning
    turned = np.isfinite(turning).any(axis=1)
    mean = np.nanmean(turning[turned & (found.outcome == Outcome.CONVERGED)], axis=1)
    return Counts(
        len(sigma), found.count(Outcome.CONVERGED), int(_tied(found).sum()),
        int(_tied(found, corank, 0.1, 0.0).sum()), int((np.nanmax(turning[turned], axis=1) > np.radians(170.0)).sum()),
        int((np.diff(sigma, axis=1) > 0.0).any(axis=1).sum()), int((found.sigma[:, found.rank] > 1e-3).sum()),
        degrees(float(np.median(mean))), (degrees(float(mean.min())), degrees(float(mean.max()))),
    )  # fmt: skip


CAPS = (300, 1000, 3000)
"""Limits on iterations that `reached` counts up to."""
SHARES = (0.0, 0.1, 0.3, 0.5, 1.0)
"""Rules of the steps that `reached` compares: 0 is the line search, else the share of the step to linearised zero."""


@cache
def reached(corank: int, method: str, step: float, starts: int = 500, caps: tuple[int, ...] = CAPS) -> tuple[int, ...]:
    """Of so many random starts of seed 2, how many converge within each number of iterations."""
    robot, task = pa10()
    found = search(robot, corank, task=task, starts=starts, seed=PAIRED_SEED, method=method, step=step,
                   iterations=max(caps))  # fmt: skip
    converged = found.outcome == Outcome.CONVERGED
    return tuple(int((converged & (found.iterations <= cap)).sum()) for cap in caps)


def step_rules(sheet: Sheet) -> None:
    """What decides whether a descent to rank 3 ends: the rule of its steps, or the treatment of ties?"""
    told, without, differ = [], [], []
    for step in SHARES:
        plain, treated = reached(3, "gradient", step), reached(3, "almarkhi", step)
        rule = f"{step:g} of the step to linearised zero" if step else "exact line search"
        told.append(f"{rule}: {', '.join(map(str, plain))} without, {', '.join(map(str, treated))} with")
        without.append(plain[-1])
        differ.append(abs(treated[-1] - plain[-1]))
    sheet.claim(
        "Figures 2(a), 3(a)",
        "of 500 random starts for rank 3, those that converge within 300, 1000 and 3000 iterations",
        "none without the treatment of ties; converges with it", "; ".join(told), max(without) < 0.05 * 500,
        reason="AM show one run each. From random starts the rule of the steps decides, not the treatment.",
        shown=Shown(f"With and without it the counts differ by at most {max(differ)}.", max(differ) < 0.05 * 500),
    )  # fmt: skip


PICKED = "The start and the rule of the steps are not printed. The run drawn was picked because it meets a tie."
OURS = "Descents with a share 0.1 of the step to linearised zero, from starts nobody picked; AM print no rule."


def figure_1(sheet: Sheet) -> None:
    """Plain descent into a rank-2 singularity."""
    found, treated, all_of, pairs = run(1), run(1, "almarkhi"), counts(2, 3000, 0.1), paired(2)
    tie = found.first_tie()
    assert tie is not None
    sheet.claim("Figure 1(a)", "σ5 ≈ σ6 before they reach zero", "happens; not uncommon",
                f"in {pairs.tied} of {pairs.starts} plain descents with a line search",
                pairs.tied > 0.05 * pairs.starts)
    sheet.claim("Figure 1(b)", "gradients of successive iterations almost opposite", "up to 180°",
                f"more than 170° in {all_of.turned} of {all_of.starts} random starts", all_of.turned > 0, reason=OURS)
    sheet.claim(
        "Figure 1", "a tie holds up the plain descent, and not the treated one", "the convergence requires a long time",
        f"start {RUNS[1].start}: tie at iteration {tie}, σ5 = {found.sigma[tie, 4]:.2g}; plain it is stuck on the "
        f"crease at {found.sigma[-1, 4]:.1e} after {found.iterations} iterations, treated it converges in "
        f"{treated.iterations}",
        found.outcome is Outcome.CREASE and treated.outcome is Outcome.CONVERGED and tie < found.iterations,
    )  # fmt: skip
    sheet.cannot("Figure 1", "iterations: of the tie, to σ5 ≤ 1e-6; largest angle", "about 600; about 3000; 180°",
                 f"of {all_of.starts} random starts {all_of.converged} converge within 3000", PICKED)
    sheet.cannot("Figure 1", "convergence time", "approximately 40 seconds",
                 f"the run drawn: {found.iterations} iterations until it is stuck", TIME)


def figure_2(sheet: Sheet) -> None:
    """Plain descent towards a rank-3 singularity that gets stuck."""
    found, all_of, pairs = run(2), counts(3, 300, 0.1), paired(3)
    late = reached(3, "gradient", 0.3)
    sheet.claim("Figure 2(a)", "descents of σ4 that do not come near zero", "happens: never converge to zero",
                f"of 500 random starts {late[1]} converge within 1000 iterations and {late[2]} within 3000",
                late[2] < 0.95 * 500, reason="With steps of 0.3 of that to linearised zero no start fails for ever.",
                shown=Shown(f"{late[2]} of 500 starts converge.", late[2] > 0.99 * 500))  # fmt: skip
    sheet.claim("Figure 2(a)", "σ4 goes up where gradients switch", "happens: an unwanted increase in σ4",
                f"σ4 goes up somewhere in {all_of.risen} of {all_of.starts}", all_of.risen > 0, reason=OURS)
    sheet.claim("Figure 2(b)", "gradients of successive iterations almost opposite", "170°",
                f"more than 170° in {all_of.turned} of {all_of.starts}", all_of.turned > 0, reason=OURS)
    sheet.claim(
        "section 2.2.2", "plain descents that end at no minimum, stuck where values tie", "not uncommon",
        f"rank 2: {paired(2).crease} on a crease, {paired(2).near_miss} at a local minimum; rank 3: {pairs.crease} and "
        f"{pairs.near_miss}, of {pairs.starts} each",
        paired(2).crease > 0.05 * pairs.starts and pairs.crease > 0.05 * pairs.starts,
        reason="Told apart by the shortest mixture of the gradients of the tied values: at a minimum it is zero.",
    )  # fmt: skip
    sheet.cannot("Figure 2", "iterations: σ4 ≈ σ5, all three nearly equal", "106; 135 and 186",
                 f"the run drawn: σ4 ≈ σ5 at {found.first_tie()}; of {all_of.starts} random starts {all_of.all_tied} "
                 "meet all three within 10 %", PICKED)


def figure_3(sheet: Sheet) -> None:
    """AM's own method."""
    found, plain, whole = run(3), run(2), counts(3, 300, 1.0)
    sheet.claim(
        "Figure 3(a)", "the treatment of ties makes a run converge that does not without it",
        "converges in 16 iterations; without it never (Figure 2, the same robot)",
        f"start {RUNS[3].start}: converges in {found.iterations} iterations; without, σ4 = {plain.sigma[-1, 3]:.2g} "
        f"after {plain.iterations}",
        found.outcome is Outcome.CONVERGED and plain.outcome is not Outcome.CONVERGED and plain.sigma[-1, 3] > 0.05,
        reason="AM do not say that the two figures have the same start; these two have.",
    )  # fmt: skip
    sheet.cannot(
        "Figure 3(b)", "average angle between successive gradients", "around 120°",
        f"{whole.angle:.0f}° with the step to linearised zero (median of {whole.converged} runs, from "
        f"{whole.angles[0]:.0f}° to {whole.angles[1]:.0f}°)",
        "One run, from a start that is not printed, with an adaptive step that is not described: with an exact line "
        "search successive gradients are square to each other, and every run averages 90°.",
    )
    for corank in (2, 3):
        pairs = paired(corank)
        sheet.claim(
            "section 2.2.3", f"what the treatment of ties gains, rank {corank}", "faster convergence",
            f"of {pairs.starts} starts {pairs.treated} converge with it only, {pairs.plain} without it only, "
            f"{pairs.both} either way, half of these in {pairs.steps[0]:.0f} and {pairs.steps[1]:.0f} iterations",
            pairs.chance < 1e-3,
            reason="Same starts, exact line search, at most 300 iterations. The gain is in runs that would be held up "
            f"by a tie; a coin would fall so unevenly with a chance of {pairs.chance:.0e}.",
        )  # fmt: skip
    works = [paired(corank).work for corank in (2, 3)]
    sheet.cannot(
        "section 2.2.3", "average convergence time", "from 40 seconds to less than 2 seconds",
        "iterations for each start that converges, from without to with the treatment and the same steps: rank 2 "
        f"{works[0][1]:.0f} to {works[0][0]:.0f}, rank 3 {works[1][1]:.0f} to {works[1][0]:.0f}",
        f"{TIME} AM change the rule of the steps along with the treatment.",
    )  # fmt: skip


def rank_1(sheet: Sheet) -> None:
    """Section 2.2.1: steepest descent of the smallest singular value."""
    robot, task = pa10()
    found = search(robot, 1, task=task, starts=200, seed=0, method="gradient", step=0.0, iterations=300, history=True)
    share = found.count(Outcome.CONVERGED) / 200
    sheet.claim("section 2.2.1, eq. 11", "steepest descent of σ6 from random starts", "finds rank-1 singularities",
                f"{100 * share:.0f} % of 200 starts converge", share > 0.95)  # fmt: skip
    assert found.history is not None
    rises = int((np.diff(found.history.sigma[:, :, 5], axis=1) > 1e-12).sum())
    sheet.claim("section 2.2.1", "the step is chosen for the greatest decrease of σ_m", "a decrease at each iteration",
                f"σ6 goes up at {rises} steps of 200 descents", rises == 0)  # fmt: skip


SECTIONS = (
    ("rank 1", rank_1), ("Figure 1", figure_1), ("Figure 2", figure_2), ("Figure 3", figure_3), ("steps", step_rules),
)  # fmt: skip
