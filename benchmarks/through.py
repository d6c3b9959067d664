"""Straight tool lines exactly through singularities: does each go on, fold back or need a turn first, as is said?

Each line is 0.08 long (m and rad, turns as well as straight ways) and given to `check_poses` as two poses. A singular
configuration of the wrist, the elbow or the shoulder of six arms stands in its middle or at its start; the line has a
random direction, or one without a share along the motion that is lost there. Limits of joints are put aside.

The judge uses forward kinematics and Jacobian of `tests/reference` and a continuation by arc length, written here:

- a line with the singularity in the middle is followed from its first pose, until it is beyond one of its ends;
- a line that starts at the singularity is followed both ways along every solution curve of s(q), of which there is one
  where the direction is lost, the kernel of J. It goes on from rest where s grows, folds back where s falls both
  ways. Where s stays, the tool stands still: the turn comes first, to the nearest point along that curve at which the
  direction is not lost, and the line is followed from there.

A fault: complete, fold or turn is told otherwise, the end of the line is another configuration, or the turn is another
one or a longer one.

    python benchmarks/through.py [--count 200] [--seed 0] [--quick] [--json]
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from typing import NamedTuple

import measure  # first: sets the number of threads
import numpy as np
from reference import kinematics as oracle

from rankdrop.path import check_poses
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot

ARMS = ("irb120", "ur5e", "puma560", "kr6r900", "lrmate200id", "ur10e")
JOINTS = {"wrist": 4, "elbow": 2, "shoulder": 1}
"""Joint whose turn makes the arm singular."""
_HALF = 0.04  # of a line
_STEPS = (1e-2, 1e-5)  # of the arc length: first and least
_CORRECTED = 0.2  # share of a step that the corrector may add
_TURNED = 0.97  # cosine between two steps at least
_STILL = 1e-9  # of s along a self-motion
_AWAY = 0.05  # |Δq| at which a curve from rest has shown where it goes
_NEAR_START = 0.02  # a turn so short at a start is made without a word [rad]
_SAME = 2e-3  # of configurations [rad]


class Line(NamedTuple):
    """A straight way of the tip with a constant turn: its pose at s = 0 and what changes for each s."""

    home: Array
    way: Array

    def at(self, s: float) -> Array:
        """(4, 4) the pose at s."""
        made = self.home.copy()
        made[:3, 3] += s * self.way[:3]
        made[:3, :3] = _rotation(s * self.way[3:]) @ self.home[:3, :3]
        return made


def _rotation(vector: Array) -> Array:
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross)


def _missing(arm: Robot, line: Line, y: Array) -> Array:
    """(6,) what the pose of q is ahead of the line at s, y = (q, s), to first order in the turn."""
    now, goal = oracle.pose(arm, y[:-1]), line.at(float(y[-1]))
    turn = now[:3, :3] @ goal[:3, :3].T
    vector = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return np.concatenate([now[:3, 3] - goal[:3, 3], vector])


def _slope(arm: Robot, line: Line, y: Array) -> Array:
    """(6, 7) of what is missing."""
    return np.hstack([oracle.jacobian(arm, y[:-1]), -line.way[:, None]])


def _corrected(arm: Robot, line: Line, guess: Array, across: Array) -> Array | None:
    """The solution on the plane through a guess across a direction (7,); None where Newton's method fails."""
    y = guess
    for _ in range(8):
        off = np.append(_missing(arm, line, y), across @ (y - guess))
        if np.abs(off).max() < 1e-12:
            return y
        y = y - np.linalg.lstsq(np.vstack([_slope(arm, line, y), across]), off, rcond=1e-14)[0]
    return y if np.abs(off).max() < 1e-10 else None


def walk(arm: Robot, line: Line, y: Array, way: Array, low: float, high: float) -> tuple[str, Array]:
    """("goes on" at `high`, "folds back" at `low` or "?", y there) of a solution curve from y along a direction (7,).
    """
    step, started = _STEPS[0], y
    for _ in range(4000):
        guess = y + step * way
        new = _corrected(arm, line, guess, way)
        done = None if new is None else (new - y) / np.linalg.norm(new - y)
        if done is None or np.linalg.norm(new - guess) > _CORRECTED * step or done @ way < _TURNED:
            step /= 2
            if step < _STEPS[1]:
                return "?", y
            continue
        way, y = done, new
        step = min(1.3 * step, _STEPS[0])
        if y[-1] >= high or y[-1] <= low:
            ahead = y[-1] >= high
            share = (y[-1] - (high if ahead else low)) / way[-1]
            end = y - share * way
            return "goes on" if ahead else "folds back", _at_s(arm, line, end)
        if np.linalg.norm(y - started) < 1e-9:
            return "?", y
    return "?", y


def _at_s(arm: Robot, line: Line, y: Array) -> Array:
    """The solution next to y with the same s."""
    across = np.eye(7)[6]
    found = _corrected(arm, line, y, across)
    return y if found is None else found


def tangent(arm: Robot, line: Line, y: Array) -> Array:
    """(7,) along the solution curve, forwards."""
    way = np.linalg.svd(_slope(arm, line, y))[2][-1]
    return np.asarray(way * (1.0 if way[-1] >= 0.0 else -1.0))


def lost(arm: Robot, q: Array) -> tuple[Array, Array]:
    """u (6,) and the kernel (6,) of J at a singular configuration."""
    u, _, vt = np.linalg.svd(oracle.jacobian(arm, q))
    return u[:, -1], vt[-1]


def singular_near(arm: Robot, q: Array, joint: int) -> Array | None:
    """q with one joint turned to the first zero of det J; None where the zero is not simple, or another one is near."""
    def det(x: float) -> float:
        return float(np.linalg.det(oracle.jacobian(arm, np.concatenate([q[:joint], [x], q[joint + 1 :]]))))

    grid = np.linspace(q[joint], q[joint] + 2.0 * np.pi, 240)
    values = np.array([det(x) for x in grid])
    signs = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    if not len(signs):
        return None
    low, high = grid[signs[0]], grid[signs[0] + 1]
    for _ in range(80):
        middle = (low + high) / 2
        if det(low) * det(middle) > 0.0:
            low = middle
        else:
            high = middle
    found = np.concatenate([q[:joint], [(low + high) / 2], q[joint + 1 :]])
    sigma = np.linalg.svd(oracle.jacobian(arm, found), compute_uv=False)
    return found if sigma[-1] < 1e-10 and sigma[-2] > 0.03 * sigma[0] else None


def free_of_limits(name: str) -> Robot:
    """An arm whose joints may turn as far as they like."""
    arm = open_robot(name)
    return replace(arm, joints=tuple(replace(joint, lower=-40.0, upper=40.0) for joint in arm.joints))


def starts(arm: Robot, line: Line, q: Array, rng: np.random.Generator) -> Array | None:
    """A solution at the first pose near a singular configuration in the middle."""
    for size in (0.1, 0.2, 0.4):
        for _ in range(10):
            y = np.append(q + size * rng.normal(size=6), -_HALF)
            found = _least(arm, line, y)
            if found is not None and np.linalg.svd(oracle.jacobian(arm, found))[1][-1] > 1e-3:
                return found
    return None


def _least(arm: Robot, line: Line, y: Array) -> Array | None:
    for _ in range(30):
        off = _missing(arm, line, y)
        if np.abs(off).max() < 1e-12:
            return np.asarray(y[:-1])
        step = np.linalg.lstsq(oracle.jacobian(arm, y[:-1]), off, rcond=None)[0]
        y = y - np.append(step * min(1.0, 0.3 / max(float(np.abs(step).max()), 1e-300)), 0.0)
    return None


def from_rest(arm: Robot, line: Line, q: Array) -> tuple[str, list[Array]]:
    """What a line does that starts where its direction is lost: "goes on", "folds back", "still" or "?"; ends of it."""
    _, kernel = lost(arm, q)
    kinds, ends = [], []
    for sign in (1.0, -1.0):
        way = np.append(sign * kernel, 0.0)
        y, here = np.append(q, 0.0), way
        for _ in range(20):
            new = _corrected(arm, line, y + _AWAY / 20 * here, here)
            if new is None:
                return "?", []
            here, y = (new - y) / np.linalg.norm(new - y), new
        if abs(y[-1]) <= _STILL:
            kinds.append("still")
        elif y[-1] < 0.0:
            kinds.append("folds back")
        else:
            kind, end = walk(arm, line, y, here, -_HALF, _HALF)
            kinds.append(kind)
            if kind == "goes on":
                ends.append(end[:-1])
    if "goes on" in kinds:
        return "goes on", ends
    if kinds == ["still", "still"]:
        return "still", []
    return ("folds back" if set(kinds) == {"folds back"} else "?"), ends


def regular_start(arm: Robot, line: Line, q: Array) -> tuple[str, list[Array]]:
    """What a line does that starts at a singular configuration whose lost direction it does not need.

    The kernel of (J, −ξ) is a plane there. On solution curves u·F vanishes to second order, a quadratic form on that
    plane: two curves cross where it is indefinite, and the configuration is alone where it is definite.
    """
    u, _ = lost(arm, q)
    plane = np.linalg.svd(_slope(arm, line, np.append(q, 0.0)))[2][5:]
    small = 1e-3

    def form(way: Array) -> float:
        ends = [u @ _missing(arm, line, np.append(q, 0.0) + sign * small * way) for sign in (1.0, -1.0)]
        return float(sum(ends)) / small**2

    a, c = form(plane[0]), form(plane[1])
    b = (form(plane[0] + plane[1]) - a - c) / 2
    if abs(a * c - b * b) < 1e-4:
        return "?", []
    if a * c > b * b:
        return "ends", []
    ends, kinds = [], []
    half = np.arctan2(2 * b, a - c) / 2  # the form is (a + c)/2 + r cos 2(angle − half)
    open_by = np.arccos(np.clip(-(a + c) / np.hypot(a - c, 2 * b), -1.0, 1.0)) / 2
    for angle in (half + open_by, half - open_by):
        way = np.cos(angle) * plane[0] + np.sin(angle) * plane[1]
        if abs(way[-1]) < 1e-3:
            continue
        way = way * np.sign(way[-1])
        y = _corrected(arm, line, np.append(q, 0.0) + 0.02 * way, way)
        if y is None:
            return "?", []
        kind, end = walk(arm, line, y, way, -_HALF, _HALF)
        kinds.append(kind)
        if kind == "goes on":
            ends.append(end[:-1])
    if "goes on" in kinds:
        return "goes on", ends
    return "?", []


def turns(arm: Robot, line: Line, q: Array) -> list[tuple[float, Array]]:
    """Lengths and ends of the turns both ways along the self-motion through q to the first zero of u·ξ."""
    found = []
    for sign in (1.0, -1.0):
        u, kernel = lost(arm, q)
        here, now, length = sign * kernel, q, 0.0
        value = float(u @ line.way)
        for _ in range(1400):
            new = _corrected(arm, line, np.append(now + 5e-3 * here, 0.0), np.append(here, 0.0))
            if new is None:
                break
            other, _ = lost(arm, new[:-1])
            other = other if other @ u > 0.0 else -other
            after = float(other @ line.way)
            step = float(np.linalg.norm(new[:-1] - now))
            if value * after <= 0.0:
                share = value / (value - after)
                found.append((length + share * step, now + share * (new[:-1] - now)))
                break
            here = (new[:-1] - now) / step
            now, u, value, length = new[:-1], other, after, length + step
    return sorted(found, key=lambda one: one[0])


def apart(one: Array, other: Array) -> float:
    """How far two configurations are apart, whole turns aside [rad]."""
    return float(np.abs(np.remainder(one - other + np.pi, 2 * np.pi) - np.pi).max())


def case(number: int, seed: int) -> tuple[Robot, str, Array, Line, bool] | None:
    """An arm, a part of it, its singular configuration, a line, and whether it starts there."""
    rng = np.random.default_rng([41, seed, number])
    arm = free_of_limits(ARMS[number % len(ARMS)])
    part = list(JOINTS)[(number // len(ARMS)) % len(JOINTS)]
    q = singular_near(arm, rng.uniform(-1.4, 1.4, 6), JOINTS[part])
    if q is None:
        return None
    way = rng.normal(size=6) * np.array([1.0, 1.0, 1.0, 0.5, 0.5, 0.5])
    if rng.random() < 0.3:
        way[3:] = 0.0
    u, _ = lost(arm, q)
    if rng.random() < 0.4:
        if rng.random() < 0.5:
            way = way - (u @ way) * u
        else:  # without a turn of the tool where that is possible
            room = float(u[:3] @ u[:3])
            way[3:] = 0.0
            if room > 1e-6:
                way[:3] -= (u[:3] @ way[:3]) / room * u[:3]
    way = way / np.linalg.norm(way)
    return arm, part, q, Line(oracle.pose(arm, q), way), bool(rng.random() < 0.4)


def one(number: int, seed: int) -> measure.Row | None:
    """One line, judged; None where the judge cannot begin or end it."""
    made = case(number, seed)
    if made is None:
        return None
    arm, part, q, line, begins = made
    rng = np.random.default_rng([43, seed, number])
    share = abs(float(lost(arm, q)[0] @ line.way))
    if 1e-9 < share < 0.02:
        return None  # neither lost nor free to a continuation with steps
    ends: list[Array] = []
    turned: list[tuple[float, Array]] = []
    if not begins:
        first = starts(arm, line, q, rng)
        if first is None:
            return None
        y = np.append(first, -_HALF)
        wanted, end = walk(arm, line, y, tangent(arm, line, y), -_HALF - 1e-9, _HALF)
        ends = [end[:-1]]
        low = -_HALF
    else:
        first, low = q, 0.0
        if share <= 1e-9:
            wanted, ends = regular_start(arm, line, q)
        else:
            wanted, ends = from_rest(arm, line, q)
            if wanted == "still":
                turned = turns(arm, line, q)
                wanted = "turn" if turned else "ends"
                if turned and turned[0][0] <= _NEAR_START:
                    return None
    if wanted == "?":
        return None
    poses = np.stack([line.at(low), line.at(_HALF)])
    begun = time.process_time()
    check = check_poses(arm, poses, start=first, branches=False)
    seconds = time.process_time() - begun
    tool = check.tool
    if tool.complete:
        said = "goes on"
    elif tool.turn is not None:
        said = "turn"
    elif tool.folds:
        said = "folds back"
    else:
        said = "ends"
    wrong = []
    if said != wanted:
        wrong.append("kind")
    elif said == "goes on" and ends and min(apart(tool.q[-1], end) for end in ends) > _SAME:
        wrong.append("end")
    elif said == "turn":
        length = turned[0][0]
        near = [end for far, end in turned if far < length + 0.02]
        if min(apart(tool.turn.to, end) for end in near) > 0.02:
            wrong.append("turn")
        if np.abs(oracle.pose(arm, tool.turn.to) - poses[0]).max() > 1e-9:
            wrong.append("pose")
    if check.verdict == "free" and begins:
        wrong.append("free")
    return {"line": number, "arm": arm.name, "part": part, "where": "start" if begins else "middle",
            "u·ξ": share, "judge": wanted, "said": said, "reason": tool.reason, "verdict": str(check.verdict),
            "CPU s": seconds, "wrong": ", ".join(wrong), "faults": float(bool(wrong))}  # fmt: skip


def main() -> None:
    """All lines asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=8 if measure.quick() else 200, help="lines (200)")
    parser.add_argument("--seed", type=int, default=0, help="of the lines (0)")
    measure.options(parser)
    asked = parser.parse_args()
    rows, left_out = measure.collected(one, asked.count, asked.seed)
    faults = sum(row["faults"] > 0 for row in rows)
    kinds = {kind: sum(row["judge"] == kind for row in rows) for kind in sorted({row["judge"] for row in rows})}
    told = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
    measure.report(
        f"{len(rows)} tool lines exactly through singularities ({told}; {left_out} left out that the judge "
        f"could not decide): {faults} told otherwise", rows, ratio="faults", target=0.0, at_most=True, arguments=asked,
    )  # fmt: skip


if __name__ == "__main__":
    main()
