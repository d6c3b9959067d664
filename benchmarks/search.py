"""Time per converged singular configuration of the PA-10: block-LM in the core against the same method in NumPy, and
against what people write: SciPy's least squares on the smallest singular value of Pinocchio's Jacobian."""

from __future__ import annotations

import os
import time

import measure  # first: sets the number of threads
import numpy as np
import peers
from reference import arms, newton

from rankdrop.families.searching import Outcome, refine
from rankdrop.robot.model import Array, Robot
from rankdrop.task import resolve_task


def by_scipy(robot: Robot, starts: Array, length: float, corank: int) -> tuple[float, int, float]:
    """Time of all starts [s], how many end at σ ≤ 1e-9, and the median number of evaluations.

    `scipy.optimize.least_squares` (Levenberg–Marquardt, differences for the derivative) on the smallest singular
    values, translation rows divided by `length`.
    """
    import pinocchio as pin
    from scipy.optimize import least_squares

    model, tip = peers.turning_about_z(robot)
    data, rows = model.createData(), np.array([[length]] * 3 + [[1.0]] * 3)

    def lost(q: Array) -> Array:
        seen = pin.computeFrameJacobian(model, data, q, tip, pin.LOCAL_WORLD_ALIGNED) / rows
        few = np.linalg.svd(seen, compute_uv=False)[-corank:]
        return np.concatenate([few, np.zeros(robot.n - corank)])  # the method wants as many residuals as unknowns

    begin = time.perf_counter()
    told = {"method": "lm", "xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15, "max_nfev": 2_000}
    found = [least_squares(lost, q, **told) for q in starts]
    seconds = time.perf_counter() - begin
    converged = sum(float(np.abs(one.fun).max()) <= 1e-9 for one in found)
    return seconds, converged, float(np.median([one.nfev for one in found]))


def main() -> None:
    """Both begin at the same uniform random starts and stop at σ ≤ 1e-13; the core on all cores, then on one."""
    many, few = (1_000, 100) if measure.quick() else (40_000, 4_000)
    robot = arms.pa10()
    task = resolve_task("pose", robot)
    starts = np.random.default_rng(0).uniform(-np.pi, np.pi, (many, 7))
    rows: list[measure.Row] = []
    absent = peers.missing("SciPy", "Pinocchio")
    for corank in (1, 2, 3):
        numpy_time, other = measure.quickest(2, lambda k=corank: newton.refine(robot, starts[:few], task, 6 - k))
        theirs = numpy_time / int(other.converged.sum())
        for threads in (0, 1):
            core_time, core = measure.quickest(
                3, lambda k=corank, t=threads: refine(robot, starts, k, task=task, threads=t)
            )
            mine = core_time / core.count(Outcome.CONVERGED)
            rows.append({
                "corank": corank, "other": "the same in NumPy", "threads": threads or os.cpu_count(),
                "core us": 1e6 * mine, "other us": 1e6 * theirs,
                "ratio": theirs / mine, "core converged": core.count(Outcome.CONVERGED) / many,
                "other converged": float(other.converged.mean()), "core iterations": float(np.median(core.iterations)),
                "other iterations": float(np.median(other.iterations)), "claimed": threads == 0,
            })  # fmt: skip
        if absent:
            continue
        some = 20 if measure.quick() else 200
        seconds, converged, evaluations = by_scipy(robot, starts[:some], task.scale(robot), corank)
        rows.append(rows[-1] | {
            "other": "SciPy on Pinocchio", "other us": 1e6 * seconds / max(converged, 1),
            "ratio": 1e6 * seconds / max(converged, 1) / rows[-1]["core us"], "other converged": converged / some,
            "other iterations": evaluations, "claimed": False,
        })  # fmt: skip
    measure.report(
        f"block-LM on the PA-10, {many} starts in the core, {few} of them in NumPy, time per converged start: at least "
        "50 times the same method in batched NumPy with all cores; one thread for information",
        rows, ratio="ratio", target=50.0, missing=absent,
    )  # fmt: skip


if __name__ == "__main__":
    main()
