"""Axis-parallel poses of six-joint arms: is every printed branch a solution, and is none missed?

The tool points along axes of the base and the tip is in a plane through the first axis, where arms are singular and
solutions coincide. Each pose is given to `rankdrop.inverse`. Judges are forward kinematics of `tests/reference`
(products of exponentials in NumPy) and a damped Newton's method written here, from 2,000 random starts: a regular
solution that it finds and that is neither among the branches nor on a self-motion (singular there, or other joints
with the same pose next to it) is missed.

    python benchmarks/branches.py [--count 300] [--seed 0] [--starts 2000] [--arms irb120,ur5e] [--quick] [--json]
"""

from __future__ import annotations

import argparse
import time
from itertools import permutations, product
from typing import Any

import measure  # first: sets the number of threads
import numpy as np
from reference import kinematics as oracle

import rankdrop
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot, robot_names

RESIDUAL = 1e-9
"""Largest entry of the difference between the pose of a printed branch and the pose asked for [m, 1]."""
_ROUNDS, _ARRIVED, _APART, _REGULAR = 60, 1e-10, 1e-3, 1e-4


def axis_parallel(robot: Robot, rng: np.random.Generator) -> Array:
    """(4, 4) a pose with the tool along axes of the base and the tip in a plane through the base's axis."""
    turns = [np.eye(3)[list(order)] * np.array(signs)[:, None]
             for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3))]  # fmt: skip
    turns = [turn for turn in turns if np.linalg.det(turn) > 0.0]
    made = np.eye(4)
    made[:3, :3] = turns[int(rng.integers(len(turns)))]
    far, height = rng.uniform(0.25, 0.75) * reach(robot), rng.uniform(-0.2, 0.6) * reach(robot)
    made[:3, 3] = (far, 0.0, height) if rng.random() < 0.5 else (0.0, far, height)
    return made


def solutions(robot: Robot, goal: Array, starts: Array, length: float) -> tuple[Array, Array]:
    """(k, n) ends of damped Newton's method that reach a pose, and (k,) σ_6 there, translations divided by a length."""
    q = starts.copy()
    for _ in range(_ROUNDS):
        now, jacobian = oracle.pose(robot, q), oracle.jacobian(robot, q)
        error = _error(now, goal, length)
        jacobian = jacobian / np.array([length] * 3 + [1.0] * 3)[:, None]
        damping = np.minimum((error * error).sum(axis=1), 1.0)[:, None, None] * np.eye(6)
        step = np.linalg.solve(jacobian @ jacobian.swapaxes(1, 2) + damping + 1e-15 * np.eye(6), error[:, :, None])
        change = (jacobian.swapaxes(1, 2) @ step)[:, :, 0]
        size = np.linalg.norm(change, axis=1, keepdims=True)
        q = q + change * np.minimum(1.0, 0.7 / np.maximum(size, 1e-12))
    good = np.linalg.norm(_error(oracle.pose(robot, q), goal, length), axis=1) <= _ARRIVED
    jacobian = oracle.jacobian(robot, q[good]) / np.array([length] * 3 + [1.0] * 3)[:, None]
    return q[good], np.linalg.svd(jacobian, compute_uv=False)[:, -1] if good.any() else np.zeros(0)


def _error(now: Array, goal: Array, length: float) -> Array:
    """(N, 6) what is missing, in axes of the base; the turn by its sine, and π where it is more than a right angle."""
    turn = goal[:3, :3] @ now[:, :3, :3].swapaxes(1, 2)
    vector = 0.5 * np.stack([turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0],
                             turn[:, 1, 0] - turn[:, 0, 1]], axis=1)  # fmt: skip
    sine = np.linalg.norm(vector, axis=1)
    angle = np.arctan2(sine, 0.5 * (np.trace(turn, axis1=1, axis2=2) - 1.0))
    vector = vector * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 1.0)[:, None]
    vector[(sine <= 1e-9) & (angle > 1.0)] = (np.pi, 0.0, 0.0)
    return np.concatenate([(goal[:3, 3] - now[:, :3, 3]) / length, vector], axis=1)


def one(name: str, goal: Array, starts: int, rng: np.random.Generator) -> measure.Row:
    """One pose: what is printed, and what is missed."""
    arm = open_robot(name)
    begun = time.process_time()
    found = rankdrop.inverse(arm, goal)
    seconds = time.process_time() - begun
    printed = np.array([branch.q for branch in found.branches]).reshape(-1, arm.n)
    worst = 0.0
    if len(printed):
        worst = float(np.abs(oracle.pose(arm, printed) - goal).max())
    ends, sigma = solutions(arm, goal, rng.uniform(-np.pi, np.pi, (starts, arm.n)), reach(arm))
    regular = ends[sigma > _REGULAR]
    missed: list[Array] = []
    for q in regular:
        known = np.concatenate([printed, np.array(missed).reshape(-1, arm.n)])
        gap = np.abs(np.remainder(known - q + np.pi, 2 * np.pi) - np.pi)
        if not len(known) or gap.max(axis=1).min() > _APART:
            missed.append(q)
    return {"arm": name, "branches": len(printed), "self-motions": len(found.continua), "arrived": len(ends),
            "residual": worst, "missed": len(missed), "CPU s": seconds,
            "faults": len(missed) + (worst > RESIDUAL)}  # fmt: skip


def six_jointed() -> list[str]:
    """Arms of the catalogue with six turning joints, counted in metres."""
    arms = [(name, open_robot(name)) for name in robot_names()]
    return [name for name, arm in arms if arm.n == len(arm.joints) == 6
            and all(joint.unit == "rad" for joint in arm.variables) and 0.1 < reach(arm) < 20.0]  # fmt: skip


def main() -> None:
    """All poses asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=5 if measure.quick() else 300, help="poses in all (300)")
    parser.add_argument("--seed", type=int, default=0, help="of the poses and the starts (0)")
    parser.add_argument("--starts", type=int, default=200 if measure.quick() else 2000, help="for each pose (2000)")
    parser.add_argument("--arms", help="some of the arms, with commas; all six-joint arms of the catalogue without it")
    measure.options(parser)
    asked = parser.parse_args()
    names = asked.arms.split(",") if asked.arms else six_jointed()
    rng = np.random.default_rng([37, asked.seed])
    order = rng.permutation(len(names))
    rows: list[Any] = []
    for k in range(asked.count):
        name = names[order[k % len(names)]]
        rows.append(one(name, axis_parallel(open_robot(name), rng), asked.starts, rng))
    faults = sum(row["faults"] > 0 for row in rows)
    measure.report(
        f"{len(rows)} axis-parallel poses of {len(names)} six-joint arms: {faults} with a branch that is off by more "
        f"than {RESIDUAL:g}, or that is missed", rows, ratio="faults", target=0.0, at_most=True, arguments=asked,
    )  # fmt: skip


if __name__ == "__main__":
    main()
