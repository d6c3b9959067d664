"""The nearest singular configuration in a notebook: joints, motions, and that a search proves nothing."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.local.nearest import nearest_singularity
from rankdrop.robot.open import open_robot
from rankdrop.text.nearest import nearest_sections


def test_the_table_is_the_configuration_and_the_motion_to_it() -> None:
    q = np.array([0.3, 0.8, -0.4])
    found = nearest_singularity(open_robot("planar3r"), q)
    assert found is not None
    (section,) = nearest_sections(found)
    numbers, there, way = (np.array(column, dtype=float) for column in zip(*section.rows, strict=True))
    assert numbers.tolist() == [1, 2, 3]
    assert there == pytest.approx(found.q, abs=1e-5)
    assert there - way == pytest.approx(q, abs=1e-5)
    assert np.linalg.norm(way) == pytest.approx(found.distance, rel=1e-5)
    assert section.summary.startswith("0.8 rad away")
    assert section.summary.endswith("corank 1")
    assert all(motion[0] in "+-" for _, _, motion in section.rows)
    assert f"{found.agreeing} of {found.starts} starts" in section.notes[0]
    assert "not proven" in section.notes[1]
