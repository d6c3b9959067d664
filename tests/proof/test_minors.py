"""Singular configurations proven to exist, in rational numbers."""

from __future__ import annotations

import numpy as np
import pytest
from reference import region

from rankdrop.cover.certificates import existence_certificate, verify, write_certificate
from rankdrop.families.searching import search
from rankdrop.proof import minors
from rankdrop.proof.record import Unproven, read_certificate
from rankdrop.robot.open import open_robot


def test_how_far_a_joint_is_put_is_part_of_the_radius(tmp_path):
    """A wrist 0.5e-9 from straight is put there exactly."""
    robot = open_robot("puma560")
    for radius in (1e-9, 4e-10):
        record = existence_certificate(robot, [0.1, 0.5, 0.4, 0.2, 5e-10, 0.6], radius=radius)
        told = read_certificate(write_certificate(record, tmp_path / "e.json"))
        if radius > 5e-10:
            minors.verify_in_minors(told)
        else:
            with pytest.raises(Unproven, match="no single joint"):
                minors.verify_in_minors(told)


@pytest.mark.slow
def test_joints_that_follow_others_are_left_to_intervals(tmp_path):
    robot = region.coupled(np.random.default_rng(6), "r r r1:0.3 r r r r")
    q = search(robot, 1, starts=12, seed=3).converged[0]
    assert verify(write_certificate(existence_certificate(robot, q), tmp_path / "e.json"), robot).holds
    record = existence_certificate(robot, q)
    with pytest.raises(Unproven, match="each for itself"):
        minors.verify_in_minors(read_certificate(write_certificate(record, tmp_path / "e.json")))
