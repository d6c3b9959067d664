"""The advice "jog joint 5 by +12°; regular from there", followed literally on families of all coranks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known.jogs import FEW, fault, followed, singular_configurations

from rankdrop.local.jog import jog_out
from rankdrop.local.nearest import nearest_singularity
from rankdrop.results.known import known_analysis, shipped
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.task import resolve_task
from rankdrop.verbs.explain import explain

PER_CORANK = 2  # families, of each corank, with one configuration inside the limits


@pytest.mark.slow
@pytest.mark.parametrize("name", FEW)
def test_the_verdict_is_regular_after_the_jog_that_is_advised(name: str) -> None:
    faults = [fault(arm, q) for arm, q in singular_configurations(name, PER_CORANK)]
    assert faults
    assert not any(faults)


def test_the_sigma_that_is_told_is_the_one_after_the_jog() -> None:
    found = explain(open_robot("ur5e"), [0.0, -1.5, 1.5, 0.0, 0.0, 0.3], evaluations=0)
    after = explain(found.robot, followed(found), evaluations=0)
    sigma = float(after.rank.sigma[after.rank.generic_rank - 1])
    assert found.summary.sigma_after == pytest.approx(sigma, rel=0.05)


@pytest.mark.parametrize("name", ["ur5", "pa10"])
def test_proven_ends_change_no_jog_and_save_searches(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    searched = []

    def counted(*arguments: object, **options: object) -> object:
        searched.append(True)
        return nearest_singularity(*arguments, **options)

    monkeypatch.setattr("rankdrop.local.jog.nearest_singularity", counted)
    families = shipped(name).families
    found = [explain(shipped(name).robot, family.witness) for family in families]
    proven, beside_proofs = [one.jog for one in found], len(searched)
    assert [jog_out(one.here, one.options) for one in found] == proven
    assert beside_proofs < len(searched) - beside_proofs


def test_advice_that_does_not_lead_out_is_a_fault() -> None:
    arm, q = open_robot("ur5e"), np.array([0.0, -1.5, 1.5, 0.0, 0.0, 0.3])
    assert fault(arm, q) == ""
    assert fault(arm, q, speed=30.0) == "the verdict is near then"


@pytest.mark.by_hand
def test_nearly_every_singular_configuration_is_left_by_the_advice() -> None:
    rng = np.random.default_rng(1)
    faults: list[str] = []
    for name in rng.permutation(robot_names()):
        arm = open_robot(name)
        if known_analysis(arm, resolve_task(None, arm)) is not None:
            faults += [fault(arm, q) for arm, q in singular_configurations(name, 8, seed=17)]
    assert len(faults) >= 1000
    assert faults.count("") >= 0.98 * len(faults)


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


BESIDE_THE_WRIST = np.radians([39.2, -66.0, 0.0, -138.5, 0.5, 118.2])  # σ₆: more after joint 5 by −8° than by +8°


def test_the_way_out_of_one_singularity_does_not_lead_through_another() -> None:
    found = explain(open_robot("ur5e"), BESIDE_THE_WRIST, evaluations=0).summary
    assert [(number, round(float(np.degrees(step)))) for number, step in found.way_out] == [(3, 8), (5, 8)]
    assert not found.crosses


def test_a_way_out_through_another_singularity_is_told_where_the_limits_leave_no_other() -> None:
    arm, q = open_robot("ur5e"), BESIDE_THE_WRIST
    room_below, room_above = np.array([[0.0, 0.0, 0.5, 0.0, 0.5, 0.0], [0.0, 0.0, 0.5, 0.0, 0.0, 0.0]])
    lower, upper = q - room_below, q + room_above
    joints = [replace(one, lower=low, upper=high) for one, low, high in zip(arm.joints, lower, upper, strict=True)]
    found = explain(replace(arm, joints=tuple(joints)), q, evaluations=0)
    assert dict(found.summary.way_out)[5] < 0.0
    assert found.summary.crosses
    assert "it passes another singularity on the way" in " ".join(found.sections()[0].lines)
