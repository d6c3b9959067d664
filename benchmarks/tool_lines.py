"""Straight tool lines that pass by singularities: is a line called free that a controller could not run?

Each line of 0.2 m passes the singular configuration of one joint of ten arms at 0.001° to 1°, at 0.01 to 1 m/s. It is
given to `check_poses` as two poses with times. The judge is a small controller written here: it runs along the line in
equal steps, and solves each pose by Newton's method (least motion, of an arm with a spare joint) from the one before,
with forward kinematics and Jacobian of `tests/reference`. A line that is called free is a fault where the controller
needs a joint rate above its limit, or where the joint path that was proven leaves the line by more than 0.1 mm between
its rows. Rates are compared for arms without a spare joint alone: the joint motion of others is a choice.

    python benchmarks/tool_lines.py [--count 1000] [--seed 0] [--quick] [--json]
"""

from __future__ import annotations

import argparse
import time

import measure  # first: sets the number of threads
import numpy as np
from mended import ARMS
from reference import kinematics as oracle

from rankdrop.path import check_poses
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot

_HALF = 0.1  # of a line [m]
_STEPS, _FINE = 100, 20  # of the controller, and in the middle so many times finer
_MIDDLE = 0.05  # share of the line, each way, that is stepped finely
_TIP, _RATE = 1e-4, 1.01  # faults: off the line [m]; times the limit, for differences of a finite step
_PARTS = 16  # places between two rows of the joint path


def line(rng: np.random.Generator, name: str) -> tuple[Robot, Array, Array, float, float]:
    """An arm, the middle pose, the way along the line (3,), how near it passes [°], and the speed [m/s]."""
    arm = open_robot(name)
    joint, middle = ARMS[name]
    near = 10 ** rng.uniform(-3.0, 0.0)
    q = np.array(middle, dtype=float) + rng.uniform(-15.0, 15.0, len(middle))
    q[joint] = near * rng.choice([-1.0, 1.0])
    way = rng.normal(size=3)
    return arm, np.radians(q), way / np.linalg.norm(way), near, float(10 ** rng.uniform(-2.0, 0.0))


def shares(finely: float = _MIDDLE) -> Array:
    """Shares −1 … 1 of the half lines at which the controller solves, in finer steps from −`finely` to `finely`."""
    coarse = np.linspace(-1.0, 1.0, _STEPS + 1)
    fine = np.linspace(-finely, finely, int(_STEPS * _FINE * finely) + 1)
    return np.unique(np.round(np.concatenate([coarse, fine]), 12))


def driven(arm: Robot, q: Array, way: Array, places: Array) -> Array:
    """(K, n) the controller's configurations at shares of the way from the middle outwards; nan where it fails."""
    goal = oracle.pose(arm, q)
    out = np.full((len(places), arm.n), np.nan)
    for side in (1.0, -1.0):
        now = q
        for k in np.argsort(np.abs(places)):
            if np.sign(places[k]) * side < 0.0:
                continue
            target = goal.copy()
            target[:3, 3] += _HALF * places[k] * way
            solved = _newton(arm, target, now)
            if solved is None:
                break
            out[k] = now = solved
    return out


def _newton(arm: Robot, goal: Array, q: Array) -> Array | None:
    for _ in range(12):
        now = oracle.pose(arm, q)
        turn = goal[:3, :3] @ now[:3, :3].T
        vector = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        error = np.concatenate([goal[:3, 3] - now[:3, 3], vector])
        if np.abs(error).max() < 1e-12:
            return q
        step = np.linalg.lstsq(oracle.jacobian(arm, q), error, rcond=None)[0]
        if np.abs(step).max() > 0.5:
            return None
        q = q + step
    return q if np.abs(error).max() < 1e-9 else None


def off_line(arm: Robot, q: Array, begin: Array, end: Array) -> float:
    """How far the tip of a straight joint path (K, n) is from a line, at places between its rows [m]."""
    share = np.linspace(0.0, 1.0, _PARTS, endpoint=False)[:, None, None]
    every = (q[:-1] + share * np.diff(q, axis=0)).reshape(-1, arm.n)
    tip = oracle.pose(arm, every)[:, :3, 3] - begin
    way = (end - begin) / np.linalg.norm(end - begin)
    return float(np.linalg.norm(tip - (tip @ way)[:, None] * way, axis=1).max())


def one(number: int, seed: int) -> measure.Row | None:
    """One line, judged; None where the arm cannot begin it."""
    rng = np.random.default_rng([37, seed, number])
    name = list(ARMS)[number % len(ARMS)]
    arm, q, way, near, speed = line(rng, name)
    places = shares()
    rows = driven(arm, q, way, places)
    if np.isnan(rows).any():  # the joints turn far behind the middle too
        places = shares(finely=1.0)
        rows = driven(arm, q, way, places)
    if np.isnan(rows[0]).any() or (rows[0] < arm.lower).any() or (rows[0] > arm.upper).any():
        return None
    middle = oracle.pose(arm, q)
    poses = np.stack([middle, middle])
    poses[0, :3, 3] -= _HALF * way
    poses[1, :3, 3] += _HALF * way
    lasts = 2 * _HALF / speed
    begun = time.process_time()
    check = check_poses(arm, poses, [0.0, lasts], start=rows[0], branches=False)
    seconds = time.process_time() - begun
    limits = np.array([joint.velocity for joint in arm.variables], dtype=float)
    steps = np.abs(np.diff(rows, axis=0)) / (np.diff(places) / 2 * lasts)[:, None]
    if not np.isfinite(limits).any():
        share = 0.0  # any rate will do, and the steps of the controller may be too coarse
    else:
        share = float((steps / limits).max()) if np.isfinite(rows).all() else np.inf
    free, off = check.verdict == "free", 0.0
    if free:
        q_rows = np.concatenate([check.curve.control[:, 0], check.curve.control[-1:, -1]])
        off = off_line(arm, q_rows, poses[0, :3, 3], poses[1, :3, 3])
    within = bool(((rows >= arm.lower) & (rows <= arm.upper)).all())
    too_fast = free and arm.n == 6 and share > _RATE
    return {"line": number, "arm": name, "near deg": near, "m/s": speed, "verdict": str(check.verdict),
            "controller's rate": share, "off mm": 1e3 * off, "CPU s": seconds,
            "refused": float(not free and arm.n == 6 and within and share < 1 / _RATE),
            "faults": float(too_fast) + float(off > _TIP)}  # fmt: skip


def main() -> None:
    """All lines asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=10 if measure.quick() else 1000, help="lines (1000)")
    parser.add_argument("--seed", type=int, default=0, help="of the lines (0)")
    measure.options(parser)
    asked = parser.parse_args()
    rows, _ = measure.collected(one, asked.count, asked.seed)
    faults = sum(row["faults"] > 0 for row in rows)
    free = sum(row["verdict"] == "free" for row in rows)
    refused = sum(row["refused"] > 0 for row in rows)
    measure.report(
        f"{len(rows)} tool lines past singularities: {free} free, {faults} of them above the limits of a controller or "
        f"more than 0.1 mm off; {refused} not free that the controller runs", rows, ratio="faults", target=0.0,
        at_most=True, arguments=asked,
    )  # fmt: skip


if __name__ == "__main__":
    main()
