"""Known answers in closed form, from the papers and from textbooks, and how to hold an analysis against them."""

from __future__ import annotations

from collections.abc import Callable
from math import pi

import numpy as np

from rankdrop.results.analysis import Analysis

Array = np.ndarray
Condition = Callable[[Array], Array]

# Almarkhi & Maciejewski, Tables 3, 4 and 5 (Table 5 restored: its print is cut off): corank -> rows of {joint: values}
ZERO, RIGHT = (0.0, pi), (-pi / 2, pi / 2)
PA10_TABLES: dict[int, list[dict[int, tuple[float, float]]]] = {
    1: [{2: ZERO, 3: RIGHT}, {2: ZERO, 6: ZERO}, {4: ZERO}, {5: RIGHT, 6: ZERO}],
    2: [
        {2: ZERO, 3: ZERO, 4: ZERO},
        {2: ZERO, 4: ZERO, 6: ZERO},
        {4: ZERO, 5: ZERO, 6: ZERO},
        {2: ZERO, 3: RIGHT, 5: RIGHT, 6: ZERO},
    ],
    3: [{2: ZERO, 3: ZERO, 4: ZERO, 5: ZERO, 6: ZERO}],
}


def sin(q: Array, joint: int) -> Array:
    """s_joint."""
    return np.sin(q[..., joint - 1])


def c(q: Array, *joints: int) -> Array:
    """cos of a sum of joint angles."""
    return np.cos(sum(q[..., joint - 1] for joint in joints))


def s(q: Array, *joints: int) -> Array:
    """sin of a sum of joint angles."""
    return np.sin(sum(q[..., joint - 1] for joint in joints))


# Factors of the determinant (corank 1 at the arm's own task): Memon's lecture, Jin's lecture 13 (anthropomorphic);
# PUMA 560 with alpha = 90, 0, -90, 90, -90, 0; UR5; SCARA; planar 3R. Dimensions are of the zero set of each factor.
DETERMINANTS: dict[str, list[Condition]] = {
    "anthropomorphic": [
        lambda q: sin(q, 3),
        lambda q: 0.5 * c(q, 2) + 0.4 * c(q, 2, 3),
        lambda q: sin(q, 5),
    ],
    "puma560": [
        lambda q: sin(q, 5),
        lambda q: 0.4318 * c(q, 3) + 0.0203 * s(q, 3),
        lambda q: 0.4318 * c(q, 2) + 0.0203 * c(q, 2, 3) - 0.4318 * s(q, 2, 3),
    ],
    "ur5": [
        lambda q: sin(q, 3),
        lambda q: sin(q, 5),
        lambda q: -0.425 * c(q, 2) - 0.39225 * c(q, 2, 3) + 0.09465 * s(q, 2, 3, 4),
    ],
    "scara": [lambda q: sin(q, 2)],
    "planar3r": [lambda q: sin(q, 2)],
}


def zeros(condition: Condition, n: int, count: int, rng: np.random.Generator) -> Array:
    """(count, n) points on the zero set of a condition: along random lines, by bisection between signs."""
    found = []
    while len(found) < count:
        start, direction = rng.uniform(-pi, pi, n), rng.normal(size=n)
        along = start + np.linspace(0, 4, 41)[:, None] * direction
        values = condition(along)
        change = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0)
        if not len(change):
            continue
        low, high = along[change[0]], along[change[0] + 1]
        for _ in range(80):
            middle = (low + high) / 2
            if np.sign(condition(middle)) == np.sign(condition(low)):
                low = middle
            else:
                high = middle
        found.append(low)
    return np.array(found)


def text_values(text: str, q: Array) -> Array:
    """What the text of an equation evaluates to, as a user would evaluate it."""
    names = {f"q{i + 1}": q[..., i] for i in range(q.shape[-1])}
    return np.asarray(eval(text, {"__builtins__": {}}, {"sin": np.sin, "cos": np.cos, "pi": pi, **names}))


def all_explained(analysis: Analysis, at_least: int) -> bool:
    """Completeness 1.000 at every corank that exists, on at least so many fresh points."""
    summaries = [summary for summary in analysis.coranks if summary.converged]
    return bool(summaries) and all(
        summary.completeness.tested >= at_least and summary.completeness.agree == summary.completeness.tested
        for summary in summaries
    )


def all_sound(analysis: Analysis) -> bool:
    """Every row is a named one whose equations held at every solution tested."""
    return bool(analysis.families) and all(family.named and family.soundness.holds for family in analysis.families)
