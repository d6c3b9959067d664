"""Random arms as makers build them, and what the rank tree loses of them: the oracle is the numeric search."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rankdrop.families.points import cloud, count_explained
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.verbs.conditions import conditions

H = np.pi / 2


def arm(name: str, alpha: Sequence[float], a: Sequence[float], d: Sequence[float]) -> Robot:
    """A revolute arm from its standard DH table."""
    rows = [[a[i], alpha[i], d[i], 0.0] for i in range(len(a))]
    return from_dh(np.array(rows), convention="standard", name=name)


def structured(seed: int) -> Robot:
    """6R to 8R with twists 0 or ±90° and lengths out of a few, zeros among them."""
    rng = random.Random(f"structured-{seed}")
    n = rng.choice((6, 6, 7, 7, 7, 8))
    twists = (H, -H) if rng.random() < 0.6 else (H, -H, 0.0, H)
    lengths = (0.0, 0.0, 0.2, 0.3, 0.5, 1.0) if rng.random() < 0.5 else (0.0, 0.2, 0.3, 0.5, 1.0)
    alpha = [*(rng.choice(twists) for _ in range(n - 1)), 0.0]
    a = [*[rng.choice(lengths) for _ in range(n)][:-1], 0.0]
    return arm(f"structured{seed}", alpha, a, [rng.choice(lengths) for _ in range(n)])


@dataclass(frozen=True)
class Lost:
    """What the rank tree alone says of an arm, beside singular configurations found without it.

    Attributes:
        complete: the tree says that it has every singular configuration.
        families: how many it has.
        tested: singular configurations found numerically, of every corank.
        left: how many of them lie on no family.
        unfinished: what the tree says it did not finish.
    """

    complete: bool
    families: int
    tested: int
    left: int
    unfinished: tuple[str, ...]


def lost(robot: Robot, *, points: int = 500, seconds: float = 60.0) -> Lost:
    """The rank tree without numeric points, held against `points` starts of the numeric search at every corank."""
    found = conditions(robot, method="tree", points=0, special=False, seconds=seconds)
    tested = left = 0
    for corank in range(1, found.generic_rank + 1):
        met = cloud(robot, found.task, corank, points, 7)
        if not len(met.q):
            break
        check, over = count_explained(met, [family.equations for family in found.families if family.corank >= corank])
        tested, left = tested + check.tested, left + len(over)
    return Lost(found.complete, len(found.families), tested, left, tuple(found.left))


TASKS = ("pose", "pose", "pose", "position", "vx,vy,vz,wx,wy", "vx,vy,vz,wz")


def fifteen(seed: int) -> tuple[Robot, str]:
    """6R to 8R, some with a slide, twists in multiples of 15°, lengths out of a few, and a task."""
    rng = random.Random(f"fifteen-{seed}")
    n, kind = rng.choice((6, 6, 6, 7, 7, 8)), rng.random()
    choices = ((0.3, (90, -90)), (0.6, (90, -90, 0)), (0.85, (90, -90, 0, 30, 45, -45, 60)), (1.0, range(-90, 91, 15)))
    twists = next(tuple(angles) for share, angles in choices if kind < share)
    lengths = (0.0, 0.0, 0.0, 0.2, 0.3, 0.5)
    rows = [
        [
            rng.choice(lengths) if i < n - 1 else 0.0,
            np.radians(rng.choice(twists)) if i < n - 1 else 0.0,
            rng.choice(lengths), 0.0,
        ]
        for i in range(n)
    ]  # fmt: skip
    kinds = ["R"] * n
    if rng.random() < 0.15:
        kinds[rng.randrange(n)] = "P"
    return from_dh(rows, convention="standard", kinds="".join(kinds), name=f"fifteen{seed}"), rng.choice(TASKS)
