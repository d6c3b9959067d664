"""Rates and gains of the joints of a singular set."""

from __future__ import annotations

import numpy as np
import pytest
from reference import arms

from rankdrop.local.ordered import OrderedScrewSet
from rankdrop.local.ordered_report import report
from rankdrop.robot.open import open_robot


@pytest.mark.slow_at("pa10")
@pytest.mark.parametrize("name", ["pa10", "puma"])
def test_rates_and_gains_of_any_singular_set(name: str, rng: np.random.Generator) -> None:
    """The rate is that of σ_r under a small motion; a joint with a rate escapes; one without gains no full rank at
    first order."""
    robot, q = arms.singular_configurations(name, rng, 9)
    escaping = 0
    for configuration in q:
        here = OrderedScrewSet.of(robot, configuration)
        found = report(here)
        assert found.lost > 0
        assert (found.steps[0].name, found.steps[0].last) == ("readoss", robot.n)
        for joint in found.joints:
            sigma = np.linalg.svd(here.moved(joint.number, 1e-5).screws)[1][found.generic - 1]
            assert sigma / 1e-5 == pytest.approx(joint.rate, rel=1e-3, abs=1e-3)
            if joint.rate > 0:
                assert joint.escapes
            escaping += joint.escapes
            assert joint.escapes == (joint.number in found.escapes)
    assert escaping > 5


def test_a_joint_that_escapes_at_second_order_only_escapes() -> None:
    """PA-10 at θ2 = θ4 = 0, joint 4 moved: corank 1 leaves, the rate is zero."""
    robot = open_robot("pa10")
    found = report(OrderedScrewSet.of(robot, [0.3, 0.0, 0.4, 0.0, 0.5, 0.6, 0.7]))
    assert found.lost >= 1
    second = [joint for joint in found.joints if joint.gain > 0 and joint.rate == 0.0]
    assert second, "a gain that no first-order rate tells"
    assert {joint.number for joint in second if joint.escapes} == set(found.escapes) - {
        joint.number for joint in found.joints if joint.rate > 0
    }
    assert any(joint.escapes for joint in second)
