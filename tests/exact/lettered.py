"""Arms whose lengths are letters."""

from __future__ import annotations

import numpy as np

from rankdrop.robot.dh import from_dh


def arm(lengths=None, *, tool=0.0, task="pose"):
    """A 4R arm with a2 = 0.5, a3 = −0.4, d3 = 0.5 and a tip at (0.3, `tool`, 0.2) in the last link's frame."""
    rows = [(0, "pi/2", 1, 0), (0.5, 0, 0, 0), (-0.4, "pi/2", 0.5, 0), (0.3, 0, 0.2, 0)]
    end = np.eye(4)
    end[1, 3] = tool
    return from_dh(rows, convention="standard", lengths=lengths, tool=end, task=task)
