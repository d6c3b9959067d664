"""Remarks on an arm that is nearly of a known structure."""

from __future__ import annotations

import pytest

from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.arm.structure import structure_of
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot
from rankdrop.text.remarks import deviation_words


def test_near_structures_of_gen3_are_told_in_millimetres():
    chain = exact_chain(open_robot("gen3"))
    near = {one.joints: one for one in structure_of(chain).near}
    told = deviation_words(near[1, 2, 3], "")
    assert told == "the axes of joints 1, 2, 3 miss a common point by 11.75 mm"
    assert near[5, 6, 7].miss == pytest.approx(0.00035, abs=1e-5)


def test_a_calibrated_twist_is_nearly_parallel():
    robot = from_dh([(1, 0.001, 0, 0), (1, 0, 0, 0)], convention="standard", task="planar-position")
    (near,) = structure_of(exact_chain(robot, "pose")).near
    assert (near.kind, near.joints) == ("parallel", (1, 2))
    assert near.miss == pytest.approx(0.001, rel=1e-3)
    assert "0.057° from parallel" in deviation_words(near, "")
