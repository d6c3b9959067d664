"""How times grow: with joints, with the batch, with threads, with starts; and the share of the processor's peak."""

from __future__ import annotations

import os
from collections.abc import Callable

import measure  # first: sets the number of threads
import numpy as np
from reference import arms

from rankdrop import _core
from rankdrop.families.searching import search
from rankdrop.kinematics import chain_of, frame_view
from rankdrop.robot.model import Robot
from rankdrop.task import WORLD_ALIGNED


def flops(robot: Robot) -> int:
    """Additions and multiplications of one Jacobian, world-aligned, of turning joints, as the core does them.

    A joint: sine and cosine 44; the direction of its screw 3 along x, y or z, else 15, the linear part 15, the moment
    9, scaling 6; the motion on 33 for the place, 20 for the rotation, else 72; seen 12, into the matrix 12. The tip 78.
    """
    each = 0
    for joint in robot.joints:
        along = np.count_nonzero(joint.screw[3:]) == 1
        each += 44 + (3 if along else 15) + 15 + 9 + 6 + 33 + (20 if along else 72) + 24
    return each + 78


def peak() -> float:
    """Floating-point operations a second of one thread, by the product of two matrices that fit the cache.

    NumPy's product uses fused multiply-add; the core does not (docs/decisions/0004): half of this is all it can.
    """
    a = np.random.default_rng(0).normal(size=(384, 384))
    return float(2 * 384**3 / measure.best_of(10 if measure.quick() else 60, lambda: a @ a))


def per_row(function: Callable[[], object], rows: int) -> float:
    """Shortest time of a row [us]."""
    return 1e6 * measure.best_of(3 if measure.quick() else 15, function) / rows


def main() -> None:
    """Random chains of turning joints; the PA-10 where nothing else is said."""
    quick, rng = measure.quick(), np.random.default_rng(0)
    table: list[measure.Row] = []

    def add(what: str, size: int, us: float, beside: float | None) -> None:
        ratio = us / beside if beside else 1.0
        table.append({"what": what, "size": size, "us each": us, "of the first": ratio, "claimed": False})

    kernels = {"Jacobian": _core.jacobian, "σ": _core.singular_values, "derivative": _core.derivative}
    for what, kernel in kernels.items():
        first = None
        for n in (4, 8, 16, 30):
            robot = arms.random_chain(np.random.default_rng(n), "r" * n)
            told = chain_of(robot), frame_view(robot, WORLD_ALIGNED)
            q = rng.uniform(-3, 3, (200 if quick else 2_000, n))
            out = kernel(*told, q, threads=1)
            us = per_row(lambda k=kernel, t=told, q=q, out=out: k(*t, q, out, threads=1), len(q))
            add(f"{what}, joints", n, us, first)
            first = first or us
    robot = arms.pa10()
    told, first = (chain_of(robot), frame_view(robot, WORLD_ALIGNED)), None
    for rows in (1, 8, 64, 257, 2_000, 200_000 if not quick else 4_000):
        q, out = rng.uniform(-3, 3, (rows, 7)), np.empty((rows, 6, 7))
        us = per_row(lambda q=q, out=out: _core.jacobian(*told, q, out, threads=1), rows)
        add("Jacobian, batch", rows, us, first)
        first = first or us
    first = None
    for threads in range(1, (os.cpu_count() or 1) + 1):
        for rows in (257, 20_000):
            q = rng.uniform(-3, 3, (rows, 7))
            us = per_row(lambda q=q, t=threads: _core.decompose(*told, q, threads=t), rows)
            add(f"decomposition of {rows}, threads", threads, us, None)
    first = None
    for starts in (200, 2_000) if quick else (1_000, 10_000, 100_000):
        us = 1e6 * measure.once(lambda s=starts: search(robot, 1, starts=s, threads=1))[0] / starts
        add("search of corank 1, starts", starts, us, first)
        first = first or us
    q, out = rng.uniform(-3, 3, (2_000, 7)), np.empty((2_000, 6, 7))
    rate, most = flops(robot) / (1e-6 * per_row(lambda: _core.jacobian(*told, q, out, threads=1), 2_000)), peak()
    what = f"Jacobian: {flops(robot)} flops, {rate / 1e9:.1f} of {most / 1e9:.1f} GFlop/s (with fused multiply-add)"
    add(what, 2_000, flops(robot) / rate * 1e6, None)
    table[-1]["of the first"] = rate / most
    measure.report("growth, one thread unless said otherwise; the last row: share of the peak", table,
                   ratio="of the first", target=0.0)  # fmt: skip


if __name__ == "__main__":
    main()
