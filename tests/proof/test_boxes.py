"""Boxes of a covering as a tree of bits."""

from __future__ import annotations

from dataclasses import replace

import pytest
from reference.coverings import covering

from rankdrop.proof.boxes import check_plan
from rankdrop.robot.open import open_robot


@pytest.mark.parametrize("change", [
    {"top": 99}, {"top": -1}, {"top": True}, {"depth": (3, -1, 2)}, {"depth": (3, 10**9, 2)}, {"depth": (3, 2.0, 2)},
    {"depth": ()}, {"depth": (1,) * 99}, {"corank": 0}, {"corank": 9},
])  # fmt: skip
def test_each_number_of_boxes_is_looked_at(change):
    plan = covering(open_robot("planar3r"), 0.4).plan
    check_plan(plan)
    with pytest.raises(ValueError, match=r"halvings|depth has|corank is"):
        check_plan(replace(plan, **change))
