"""Programs of 50,000 rows with 1 to 5 crossings: how many are mended, in which time, and how far the tool leaves them.

Each program goes a long way round in all joints. At each of 1 to 5 times the joint whose zero is singular dips across
it, by 0.3° to 3°, for 0.2 s to 1 s, and comes back; or, in every third program, the last of them stays on the other
side. Every mended path is checked again as a whole.
"""

from __future__ import annotations

import time

import measure  # first: sets the number of threads
import numpy as np

from rankdrop.motion.check import check_path
from rankdrop.motion.remedies import LOCAL, mend_path
from rankdrop.results.known import known_analysis
from rankdrop.robot.model import Array
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

ARMS = {
    "irb120": (4, (0, -10, 10, 20, 50, 0)),
    "ur5e": (4, (0, -80, 80, -60, 50, 0)),
    "puma560": (4, (0, -40, 40, 20, 50, 0)),
    "kr6r900": (4, (0, -80, 90, 20, 50, 0)),
    "iiwa7": (3, (0, 30, 20, 60, 20, 40, 0)),
    "pa10": (3, (0, 30, 20, 60, 20, 40, 0)),
}
"""Joint whose zero is singular, counted from 0, and the middle of the program [°]."""
SECONDS = 500.0


def smooth(x: Array) -> Array:
    """From 0 to 1, C²."""
    x = np.clip(x, 0.0, 1.0)
    return np.asarray(x**3 * (10 - 15 * x + 6 * x * x))


def program(rng: np.random.Generator, joint: int, middle: tuple[float, ...], rows: int, crossings: int,
            stays: bool) -> tuple[Array, Array]:  # fmt: skip
    """(rows, n) joint values [rad] and their times [s]."""
    t = np.linspace(0.0, SECONDS, rows)
    q = np.array(middle)[None] + sum(
        rng.uniform(-6, 6, len(middle)) * np.sin(2 * np.pi * k * t[:, None] / SECONDS + rng.uniform(0, 6, len(middle)))
        for k in range(1, 4)
    )
    for k in range(crossings):
        at = SECONDS * (k + 0.5) / crossings
        depth, half = rng.uniform(0.3, 3.0), rng.uniform(0.1, 0.5)
        down = smooth((t - (at - half - 2.0)) / 2.0)
        if stays and k == crossings - 1:
            q[:, joint] *= 1 - 2 * down
            continue
        dip = down * smooth(((at + half + 2.0) - t) / 2.0)
        q[:, joint] = q[:, joint] * (1 - dip) - depth * dip
    return np.radians(q), t


def main() -> None:
    """Twice every arm; once with `--quick`."""
    rng, out = np.random.default_rng(1), []
    rows, rounds = (5_000, 1) if measure.quick() else (50_000, 2)
    for number, name in enumerate(sorted(ARMS) * rounds):
        joint, middle = ARMS[name]
        arm = open_robot(name)
        known_analysis(arm, resolve_task(None, arm))  # read once
        crossings, stays = 1 + number % 5, number % 3 == 2
        q, t = program(rng, joint, middle, rows, crossings, stays)
        begin = time.process_time()
        found = check_path(arm, q, t)
        middle_time = time.process_time()
        mended = mend_path(found, kinds=LOCAL)
        spent = time.process_time() - middle_time
        best = mended.best
        away, turned = (np.nan, np.nan) if best is None else best.deviation
        out.append({
            "arm": name, "rows": rows, "dips": crossings, "stays": stays, "verdict": str(found.verdict),
            "crossings": len(found.crossings), "check CPU s": middle_time - begin, "mend CPU s": spent,
            "remedy": "none" if best is None else best.kind, "mended": float(best is not None),
            "tool mm": 1e3 * away, "tool deg": float(np.degrees(turned)), "share of the target": spent / 10.0,
            "why not": "" if best is not None else "; ".join(mended.notes),
        })  # fmt: skip
    share = 100.0 * float(np.mean([one["mended"] for one in out]))
    measure.report(
        f"programs of {rows:,} rows with 1 to 5 crossings: {share:.0f} % mended; under 10 s (CPU) each",
        out, ratio="share of the target", target=1.0, at_most=True,
    )  # fmt: skip


if __name__ == "__main__":
    main()
