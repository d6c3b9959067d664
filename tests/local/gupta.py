"""The ordered screws of the seven joints that GR work out by hand."""

from __future__ import annotations

import numpy as np

from rankdrop.local.ordered import OrderedScrewSet

R = 0.5**0.5
SCREWS = np.array([
    [1, 0, 0, 0, 0, -1], [0, 0, 0, 0, 1, 0], [0, 1, 0, 0, 0, 0], [0, 1, 0, 0, 0, 5], [1, 0, 0, 0, 0, 0],
    [0, R, R, 0, -10 * R, 10 * R], [0, R, -R, 0, 10 * R, 10 * R],
])  # fmt: skip
"""GR section 5."""
GR = OrderedScrewSet(SCREWS)
