"""Real configurations on an irreducible set, with round angles where the set leaves them free."""

from __future__ import annotations

from collections.abc import Iterator
from math import radians

import numpy as np

from rankdrop.exact.algebra.variety import Variety
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.writing.condition import Condition
from rankdrop.exact.writing.pins import RADIANS, pin_text
from rankdrop.family.equation import Equation
from rankdrop.local.block import sampling_box
from rankdrop.robot.model import Array
from rankdrop.units import out_of_units

STARTS = 60
"""Newton iterations begun for one set; a set where none arrives is taken to have no real point, which is no proof."""
_STEPS = 40
_ARRIVED = 1e-13  # of residuals whose largest coefficient is 1
_ROUND = radians(5.0)  # free angles are multiples of this


def words(piece: Variety) -> str:
    """The conditions of a set: "θ3 = 0 and a2 c2 + a3 c23 = 0"."""
    pins = [pin_text(joint, (value,)) for joint, value in sorted(piece.pins.items())]
    return " and ".join([*pins, *(Condition(piece.ring, f).text() for f in piece.equations)]) or "every configuration"


def real_points(piece: Variety, chain: Chain, *, seed: int = 0) -> Iterator[Array]:
    """Real points of a set at the arm's own lengths, one per start that arrives.

    Args:
        piece: its conditions are solved, for as many of its variables as there are conditions, by Newton's method.
        chain: gives the lengths and the room of the slides.
        seed: of the starts.

    Yields:
        (n,) angles θ [rad], variables of slides [m].
    """
    rng = np.random.default_rng(seed)
    conditions = [Condition(piece.ring, chain.own_polynomial(f)) for f in piece.equations]
    equations = [condition.equation(chain.own_numbers, chain.n) for condition in conditions]
    moving = sorted({j for condition in conditions for j in condition.joints} - set(piece.pins))
    low, high = sampling_box(chain.own, chain.own_task, limits=False)
    for _ in range(STARTS):
        theta = np.where([j in piece.ring.revolute for j in range(1, chain.n + 1)],
                         np.round(rng.uniform(-np.pi, np.pi, chain.n) / _ROUND) * _ROUND,
                         np.round(rng.uniform(low, high), 2))  # fmt: skip
        for joint, value in piece.pins.items():
            theta[joint - 1] = RADIANS[value]
        if equations:
            chosen = rng.choice(moving, min(len(equations), len(moving)), replace=False) - 1
            if not _solve(equations, theta, chosen):
                continue
            turning = [j - 1 for j in piece.ring.revolute]
            theta[turning] = np.pi - np.remainder(np.pi - theta[turning], 2 * np.pi)
        yield out_of_units(chain.robot, theta)


def _solve(equations: list[Equation], theta: Array, chosen: Array) -> bool:
    """Newton's method in the chosen variables, in place; whether it arrived."""
    for _ in range(_STEPS):
        both = [equation.with_gradient(theta) for equation in equations]
        values = np.array([float(value) for value, _ in both])
        if np.abs(values).max() <= _ARRIVED:
            return True
        slope = np.array([gradient[chosen] for _, gradient in both])
        step = np.linalg.lstsq(slope, -values, rcond=None)[0]
        theta[chosen] += step * min(1.0, 1.0 / max(float(np.abs(step).max()), 1e-300))
        if not np.isfinite(theta).all():
            return False
    return False

