"""What else solves a row's equations: parts of lower dimension, which no random start finds.

Equations of coupled joints may all vanish where some joints stand at special values: A·cos θ4 + B·sin θ6 with A and B
long, say, at θ4 = ±π/2, θ6 = 0, whatever the others do. Newton's method from random starts ends on the family itself,
almost surely. So some joints are held at right angles, or where other rows stand, and the equations are solved in the
others. A solution there that is not singular belongs to no family: the row is not sound, though random starts say so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import pi

import numpy as np

from rankdrop.families.linear import Linear, Values
from rankdrop.families.sampling import Setting
from rankdrop.family.equation import Equation
from rankdrop.family.system import System
from rankdrop.local.block import singular_values
from rankdrop.robot.model import Array

RIGHT = (0.0, pi, pi / 2, -pi / 2)
SINGLE, SEVERAL = 24, 40  # sets of one joint held, and of two or more, at most
EACH = 8  # random starts for each
REGULAR = 1e-2
"""σ above this is not zero, however badly the solution is known: |f| ≤ 1e-12 leaves 1e-3 rad at a fourfold zero."""


def elsewhere(
    setting: Setting,
    linear: Linear,
    combinations: Sequence[Values],
    residual: tuple[Equation, ...],
    marks: Mapping[int, Sequence[float]],
    rng: np.random.Generator,
) -> tuple[int, Array]:
    """Solve a row's equations with some of their joints held at special values.

    Args:
        setting: arm, task, corank.
        linear, combinations, residual: the row; each start takes one combination of values by chance.
        marks: further values to hold joints (from 0) at, beside right angles: those of other rows [rad or m].
        rng: of joints, values and starts.

    Returns:
        How many solutions could be judged, and (S, n) those that are regular.
    """
    n = setting.robot.n
    none = np.zeros((0, n))
    if not residual:
        return 0, none
    system = System(residual)
    fixed = set(linear.pivots)
    joints = [j - 1 for j in sorted({j for f in residual for j in f.joints}) if j - 1 not in fixed]
    tested, strangers = 0, [none]
    for held in _held(setting, joints, marks, rng):
        numbers = list(held)
        chosen = [combinations[i] for i in rng.integers(len(combinations), size=EACH)]
        q = setting.random(EACH, rng)
        q[:, numbers] = list(held.values())
        q = linear.place(q, np.array(chosen, dtype=np.float64).reshape(EACH, -1), rng)
        along = _free(linear, numbers, n)
        if not along.shape[1]:
            continue
        q, good = system.solve(q, along=along, iterations=60)
        q = q[good & setting.allowed(q)]
        sigma = singular_values(setting.robot, q, setting.task)[:, setting.rank]
        regular = sigma > REGULAR
        tested += int((regular | (sigma <= setting.tolerances.singular)).sum())
        strangers.append(q[regular])
    return tested, np.concatenate(strangers)


def _held(
    setting: Setting, joints: list[int], marks: Mapping[int, Sequence[float]], rng: np.random.Generator
) -> list[dict[int, float]]:
    """Joints and the values they are held at: each alone, then several by chance."""
    periodic = setting.robot.periodic
    values = {j: list(dict.fromkeys([*(RIGHT if periodic[j] else (0.0,)), *marks.get(j, ())])) for j in joints}
    single = [{j: v} for j in joints for v in values[j]]
    if len(single) > SINGLE:
        single = [single[i] for i in rng.choice(len(single), SINGLE, replace=False)]
    several = []
    for _ in range(SEVERAL if len(joints) > 1 else 0):
        some = rng.choice(joints, size=int(rng.integers(2, len(joints) + 1)), replace=False)
        several.append({int(j): values[int(j)][int(rng.integers(len(values[int(j)])))] for j in some})
    return single + several


def _free(linear: Linear, held: list[int], n: int) -> Array:
    """(n, d) orthonormal basis of the motions that keep the linear values and the joints held."""
    rows = np.concatenate([linear.covectors.astype(np.float64).reshape(-1, n), np.eye(n)[held]])
    return np.asarray(np.linalg.svd(rows)[2][np.linalg.matrix_rank(rows) :].T)
