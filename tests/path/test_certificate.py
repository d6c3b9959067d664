"""A distance that a path keeps, proven again by its certificate."""

from __future__ import annotations

import pytest

from rankdrop.cover.certificates import asked_about, verify, write_certificate
from rankdrop.path.check.certificate import path_certificate
from rankdrop.path.check.check import check_path
from rankdrop.proof.record import with_hash
from rankdrop.robot.open import open_robot


@pytest.mark.by_hand
def test_a_distance_is_proven_again_up_to_nine_tenths_of_the_true_one(tmp_path):
    """Sound and tight: the wrist is 0.4 rad from the first row."""
    robot = open_robot("ur5")
    rows = [[0.1, -0.9, 1.0, 0.4, -0.4, 0.2], [0.3, -0.6, 1.2, 0.1, -0.9, 0.0]]
    for share, holds in ((0.9, True), (1.001, False)):
        record = path_certificate(check_path(robot, rows, min_distance=0.36))
        record["claim"]["min_distance"] = 0.4 * share
        asked = asked_about(robot, rows=rows)
        assert verify(write_certificate(with_hash(record), tmp_path / "p.json"), asked).holds is holds
