"""The advice "jog joint 5 by +12°; regular from there", followed literally on families of all coranks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from known.members import members
from rankdrop.results.explanation import Explanation
from rankdrop.results.known import known_analysis
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.task import resolve_task
from rankdrop.verbs.explain import explain

FEW = ["ur5e", "ur16e", "gen3_6dof", "gen3", "panda", "crx10ia", "motomini", "j2s6s300", "sawyer", "puma560", "scara",
       "rizon4"]  # fmt: skip
PER_CORANK = 2  # families, of each corank, with one configuration inside the limits


def singular_configurations(name: str, families: int, seed: int = 5) -> Iterator[tuple[Robot, Array]]:
    """One configuration of some families of coranks 1 to 3, inside the limits where such a one is met."""
    arm = open_robot(name)
    task = resolve_task(None, arm)
    known = known_analysis(arm, task)
    assert known is not None
    rng = np.random.default_rng(seed)
    for corank in (1, 2, 3):
        own = [one for one in known.families if one.corank == corank and one.equations]
        for k in rng.permutation(len(own))[:families]:
            points = members(arm, task, own[k], 40, seed=int(rng.integers(1000)), starts=40)
            inside = points[((points >= arm.lower) & (points <= arm.upper)).all(axis=1)]
            for q in [*inside, *points][:1]:
                yield arm, q


def followed(found: Explanation) -> Array:
    """The configuration after the jogs, as they are printed: to a tenth of a degree, or of a millimetre."""
    q = found.q.copy()
    assert 1 <= len(found.summary.way_out) <= 2
    for number, step in found.summary.way_out:
        turns = found.robot.variables[number - 1].unit == "rad"
        if turns:
            assert abs(step) >= np.radians(0.5)
        q[number - 1] += np.radians(round(np.degrees(step), 1)) if turns else round(step, 4)
        low, high = found.robot.lower[number - 1], found.robot.upper[number - 1]
        before = found.q[number - 1]
        assert min(low, before) <= q[number - 1] <= max(high, before)
    return q


def ends_regular(arm: Robot, q: Array) -> bool:
    found = explain(arm, q, evaluations=0)
    if not found.summary.way_out:
        return False
    after = explain(arm, followed(found), evaluations=0)
    assert found.summary.sigma_after == pytest.approx(float(after.rank.sigma[after.rank.generic_rank - 1]), rel=0.05)
    return after.verdict == ("always-singular" if found.rank.always_singular else "regular")


@pytest.mark.slow
@pytest.mark.parametrize("name", FEW)
def test_the_verdict_is_regular_after_the_jog_that_is_advised(name: str) -> None:
    every = [ends_regular(arm, q) for arm, q in singular_configurations(name, PER_CORANK)]
    assert every
    assert all(every)


@pytest.mark.by_hand
def test_nearly_every_singular_configuration_is_left_by_the_advice() -> None:
    rng = np.random.default_rng(1)
    every: list[bool] = []
    for name in rng.permutation(robot_names()):
        arm = open_robot(name)
        if known_analysis(arm, resolve_task(None, arm)) is not None:
            every += [ends_regular(arm, q) for arm, q in singular_configurations(name, 8, seed=17)]
    assert len(every) >= 1000
    assert np.mean(every) >= 0.98


def test_an_impossible_speed_is_not_promised() -> None:
    arm = open_robot("ur5e")
    found = explain(arm, [0.0, -1.5, 1.5, 0.0, 0.0, 0.0], speed=30.0)
    assert not found.summary.regular_after
    assert "no jog found that ends regular" in found.sections()[0].lines[1]


def test_a_jog_stays_inside_the_limits() -> None:
    arm, q = open_robot("ur5e"), [0.0, -1.5, 1.5, 0.0, 0.0, 0.3]
    ((number, _),) = explain(arm, q, evaluations=0).summary.way_out
    assert number == 5
    joints = [replace(one, lower=0.0) if i == number else one for i, one in enumerate(arm.joints, start=1)]
    ((number, step),) = explain(replace(arm, joints=tuple(joints)), q, evaluations=0).summary.way_out
    assert (number, step > 0.0) == (5, True)
    joints = [replace(one, lower=0.0, upper=0.0) if i == number else one for i, one in enumerate(arm.joints, start=1)]
    shut = explain(replace(arm, joints=tuple(joints)), q, evaluations=0)
    assert shut.summary.way_out == ()
    assert "no jog of one or two joints inside the limits was found" in shut.sections()[0].lines[1]
