"""Turns of joints along a path."""

from __future__ import annotations

import numpy as np
import pytest

from path.dipping import smooth
from rankdrop.path.check.turns import far_turns
from rankdrop.path.curve import curve
from rankdrop.robot.open import open_robot


def test_turns_are_found_where_they_are() -> None:
    t = np.arange(500) * 0.01
    q = np.zeros((500, 6))
    q[:, 3] = np.radians(173.0) * smooth((t - 1.2) / 0.6)
    q[:, 0] = np.radians(80.0) * t / t[-1]  # slow: no turn of its own
    (turn,) = far_turns(open_robot("irb120"), curve(q, t))
    assert (turn.joint, round(float(np.degrees(turn.angle)))) == (4, 171)
    assert turn.start.time == pytest.approx(1.2, abs=0.1)
    assert turn.end.time == pytest.approx(1.8, abs=0.1)
