"""Does anything that is proven free hold a singular configuration? Exact ones are put where it would show.

    python benchmarks/soundness.py [--count 1000000] [--seed 1] [--quick]

For six arms, exact singular configurations q* (`find --method reciprocal`), and around each:

- a ball whose centre is at a random distance from q*, in a random direction: the certified radius must not be larger
  than that distance (measured in the joints that matter); one in a hundred with branch and bound as well;
- a box with q* just inside one of its corners, or anywhere in it: it must not be free;
- a short curve through q*, at its end or anywhere on it: it must not be free;
- coverings of the arms that can be covered: q* must be in a box that is left;
- one in a thousand of the boxes and curves again for the checker in interval arithmetic.

Printed: how many of each, how many were wrongly called free (must be 0), and how near certified radii come to the
distance of q* (at most 1), so that it is seen that the bounds are not merely timid.
"""

from __future__ import annotations

import argparse
import sys
import time

import numpy as np

from rankdrop.cover.ball import certified_radius
from rankdrop.cover.covering import Covering
from rankdrop.cover.setting import Setting, enclose, settings_for
from rankdrop.families.searching import search
from rankdrop.path.check.prove import Along
from rankdrop.proof.arm import BITS, Arm, Region, flint
from rankdrop.proof.record import Link
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.verbs import cover

ARMS = {"ur5": 0.1, "puma560": 0.1, "panda": 0.0, "pa10": 0.0, "almarkhi4": 0.1, "stanford": 0.0}
"""Arm -> width of boxes of its covering [rad]; 0: none."""
PART = 1 << 15


def checker(robot: Robot, setting: Setting) -> Arm:
    """The arm as the checker of certificates sees it."""
    place = {joint.name: k for k, joint in enumerate(robot.variables)}
    links = [Link(str(joint.kind), tuple(joint.screw.tolist()), place[joint.name]) for joint in robot.joints]
    frame = robot.joints[setting.link - 1].frame
    point = frame[:3, :3] @ np.array(setting.point) + frame[:3, 3]
    return Arm(links, robot.n, setting.link, [flint().arb(float(x)) for x in point], flint().arb(setting.length))


def again(arm: Arm, setting: Setting, centre: Array, half: Array, along: Array | None) -> bool:
    """What the checker says of one region."""
    f = flint()
    numbers = [[f.arb(float(x)) for x in row] for row in (centre, half)]
    chord = None if along is None else [f.arb(float(x)) for x in along]
    return arm.keeps_rank(Region(numbers[0], numbers[1], chord), list(setting.rows), setting.rank)


class Tally:
    """What was tried, and what went wrong."""

    def __init__(self) -> None:
        self.tried: dict[str, int] = {}
        self.wrong: dict[str, int] = {}
        self.shares: list[Array] = []

    def add(self, what: str, wrong: Array) -> None:
        """Count the entries of a mask."""
        self.tried[what] = self.tried.get(what, 0) + len(wrong)
        self.wrong[what] = self.wrong.get(what, 0) + int(wrong.sum())


def try_arm(robot: Robot, q: Array, cover: Covering | None, rng: np.random.Generator, tally: Tally) -> None:
    """Put regions around exact singular configurations q (N, n)."""
    task = resolve_task(None, robot)
    settings = settings_for(robot, task)
    n = robot.n
    for begin in range(0, len(q), PART):
        there = q[begin : begin + PART]
        setting = settings[int(rng.integers(len(settings)))]
        scale, matters = np.asarray(setting.scale), setting.matters
        size = 10.0 ** rng.uniform(-4, -0.2, (len(there), 1))
        way = rng.standard_normal((len(there), n))
        way /= np.linalg.norm(way[:, matters], axis=1, keepdims=True)
        centre = np.ascontiguousarray(there + way * size * scale)
        away = np.linalg.norm(((centre - there) / scale)[:, matters], axis=1)
        radius = enclose(robot, setting, centre, radius=np.pi)[1]
        tally.add("balls, one enclosure", radius > away * (1 + 1e-12))
        tally.shares.append(radius / away)
        some = range(0, len(there), 100)
        found = np.array([certified_radius(robot, centre[k], evaluations=1000).radius for k in some])
        tally.add("balls, branch and bound", found > away[::100] * (1 + 1e-12))
        half = np.repeat(size, n, axis=1) * rng.uniform(0.2, 1.0, (len(there), n))
        inside = np.where(rng.random((len(there), 1)) < 0.5, np.sign(way) * (1 - 1e-9), rng.uniform(-1, 1, way.shape))
        middle = np.ascontiguousarray(there - inside * half * scale)
        tally.add("boxes", enclose(robot, setting, middle, half)[0] != 0)
        chord = way * size * scale * (np.abs(way) > 0)
        share = np.where(rng.random((len(there), 1)) < 0.5, 1 - 1e-9, rng.uniform(-1, 1, (len(there), 1)))
        start = np.ascontiguousarray(there - share * chord)
        tally.add("curves", Along(robot, setting).enclose_curves(start, chord, np.zeros_like(chord)).free)
        arm, some = checker(robot, setting), range(0, len(there), 1000)
        none = np.zeros(n)
        wrong = [again(arm, setting, middle[k], half[k] * scale, None) for k in some]
        tally.add("boxes, checker", np.array(wrong, dtype=np.bool_))
        wrong = [again(arm, setting, start[k], none, chord[k]) for k in some]
        tally.add("curves, checker", np.array(wrong, dtype=np.bool_))
        if cover is not None:
            tally.add("coverings", ~cover.holds(there))


def run(count: int, seed: int, names: tuple[str, ...] = tuple(ARMS), *, tell: bool = True) -> Tally:
    """All arms; the same number of configurations for each."""
    tally = Tally()
    with flint().ctx.workprec(BITS):
        for k, name in enumerate(names):
            begun = time.process_time()
            robot = open_robot(name)
            q = search(robot, 1, starts=-(-count // len(names)), seed=seed + k, method="reciprocal").q
            boxes = cover(robot, width=ARMS[name], explain=False).covering if ARMS[name] else None
            try_arm(robot, np.array(q), boxes, np.random.default_rng(seed + k), tally)
            if tell:
                print(f"{name}: {len(q):,} configurations, {time.process_time() - begun:.0f} s of CPU time", flush=True)
    return tally


def main() -> int:
    """Print what was tried; 1 where anything was wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--quick", action="store_true", help="a small run: does the script still work?")
    given = parser.parse_args()
    tally = run(6000 if given.quick else given.count, given.seed)
    print(f"{'what':26} {'tried':>12} {'wrongly free':>14}")
    for what, tried in tally.tried.items():
        print(f"{what:26} {tried:12,} {tally.wrong[what]:14,}")
    shares = np.concatenate(tally.shares)
    at = np.quantile(shares, (0.5, 0.9, 0.99, 1.0))
    print("certified radius / distance of q*, one enclosure: " + ", ".join(f"{x:.4f}" for x in at)
          + " at 50, 90, 99, 100 %")  # fmt: skip
    return int(any(tally.wrong.values()))


if __name__ == "__main__":
    sys.exit(main())
