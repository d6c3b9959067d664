"""The advice "jog joint 5 by +12°; regular from there", followed literally: for a test and `benchmarks/jog.py`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from known.members import members
from rankdrop.results.explanation import Explanation
from rankdrop.results.known import known_analysis
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.verbs.explain import explain

FEW = ["ur5e", "ur16e", "gen3_6dof", "gen3", "panda", "crx10ia", "motomini", "j2s6s300", "sawyer", "puma560", "scara",
       "rizon4"]  # fmt: skip
"""Arms on whose singular configurations jogs are followed."""

SPEED = 0.025
"""At which the verdict after the jogs has to be regular, the default of `rankdrop explain` [m/s]."""
LEAST = np.radians(0.5)
"""A smaller jog of a turning joint is no advice that a person can follow [rad]."""


def singular_configurations(name: str, families: int, seed: int = 5, each: int = 1) -> Iterator[tuple[Robot, Array]]:
    """Configurations of some families of every corank, inside the limits where such are met.

    Args:
        name: an arm of the catalogue.
        families: at most so many of each corank.
        seed: of the choice of families and of the configurations.
        each: at most so many configurations of each family.
    """
    arm = open_robot(name)
    task = resolve_task(None, arm)
    known = known_analysis(arm, task)
    assert known is not None
    rng = np.random.default_rng(seed)
    for corank in sorted({one.corank for one in known.families}):
        own = [one for one in known.families if one.corank == corank and one.equations]
        for k in rng.permutation(len(own))[:families]:
            points = members(arm, task, own[k], 40, seed=int(rng.integers(1000)), starts=40)
            inside = points[((points >= arm.lower) & (points <= arm.upper)).all(axis=1)]
            for q in [*inside, *points][:each]:
                yield arm, q


def followed(found: Explanation) -> Array:
    """The configuration after the jogs, as they are printed: to a tenth of a degree, or of a millimetre."""
    q = found.q.copy()
    for number, step in found.summary.way_out:
        turns = found.robot.variables[number - 1].unit == "rad"
        q[number - 1] += np.radians(round(np.degrees(step), 1)) if turns else round(step, 4)
    return q


def fault(arm: Robot, q: Array, speed: float = SPEED) -> str:
    """Why the advice at a singular configuration is none that leads out; "" where it is.

    Args:
        arm, q: where the arm stands.
        speed: at which the verdict has to be regular [m/s].
    """
    found = explain(arm, q, evaluations=0, speed=speed)
    jogs = found.summary.way_out
    if not jogs:
        return "no jog is advised"
    if len(jogs) > 2:
        return f"{len(jogs)} jogs are advised"
    if any(abs(step) < LEAST for number, step in jogs if arm.variables[number - 1].unit == "rad"):
        return "a jog is too small"
    at = followed(found)
    if ((at < np.minimum(arm.lower, q)) | (at > np.maximum(arm.upper, q))).any():
        return "a joint ends beyond its limits"
    after = explain(arm, at, evaluations=0, speed=speed)
    want = "always-singular" if found.rank.always_singular else "regular"
    return "" if after.verdict == want else f"the verdict is {after.verdict} then"
