"""What axes have in common, in words."""

from __future__ import annotations

import numpy as np
from local.related import relation_words

from rankdrop.local.relations import relations_at
from rankdrop.robot.open import open_robot


def test_the_zero_pose_of_the_pa10() -> None:
    found = relations_at(open_robot("pa10"), np.zeros(7))
    assert relation_words(found) == [
        (False, "axes 1, 3, 5, 7 aligned"),
        (False, "axes 1, 2, 3, 5, 7 meet in one point"),
        (False, "axes 1, 3, 4, 5, 7 meet in one point"),
        (False, "axes 1, 3, 5, 6, 7 meet in one point"),
        (False, "axes 2, 4, 6 parallel"),
        (True, "axes 1, 2, 3 meet in one point"),
        (True, "axes 3, 4, 5 meet in one point"),
        (True, "axes 5, 6, 7 meet in one point"),
    ]
    assert found[0].joints == (1, 3, 5, 7)


def test_a_regular_configuration_has_structure_only() -> None:
    found = relations_at(open_robot("ur5"), [0.1, -0.5, 0.7, 0.3, 0.9, 0.2])
    assert relation_words(found) == [
        (True, "axes 1, 2 intersect"), (True, "axes 4, 5 intersect"), (True, "axes 5, 6 intersect"),
        (True, "axes 2, 3, 4 parallel"),
    ]  # fmt: skip
