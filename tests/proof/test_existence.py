"""Singular configurations proven to exist."""

from __future__ import annotations

import pytest

from rankdrop.cover.certificates import existence_certificate, write_certificate
from rankdrop.proof.check import arm_of
from rankdrop.proof.existence import _Zero
from rankdrop.proof.record import read_certificate
from rankdrop.robot.open import open_robot

pytestmark = pytest.mark.usefixtures("precise")


def test_a_box_next_to_a_singular_configuration_holds_none(tmp_path):
    """Krawczyk's test about a place 1.5 widths beside the zero of a real arm."""
    robot = open_robot("planar3r")
    claim = read_certificate(write_certificate(existence_certificate(robot, [0.3, 0.0, 0.2]), tmp_path / "e.json"))
    zero = _Zero(arm_of(claim), claim.entries["q"], [0, 1, 5])
    start = zero._start()
    _, slope = zero._equations(start)
    planes, width = zero._planes(slope), 1e-6
    assert zero._krawczyk_inside(start, start, planes, width)
    beside = [x + 1.5 * width * (place == 0) for place, x in enumerate(start)]
    assert not zero._krawczyk_inside(beside, start, planes, width)
