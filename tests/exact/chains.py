"""Chains of joints with exact parameters."""

from __future__ import annotations

from functools import cache

import numpy as np

from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.robot.open import open_robot


@cache
def chain_of(name: str) -> Chain:
    return exact_chain(open_robot(name))


SRS = [(0, -np.pi / 2, 0.34, 0), (0, np.pi / 2, 0.03, 0), (0, -np.pi / 2, 0.4, 0), (0, np.pi / 2, 0.02, 0),
       (0, -np.pi / 2, 0.3, 0), (0, np.pi / 2, 0, 0), (0, 0, 0.1, 0)]  # fmt: skip
"""An S-R-S arm with offsets along axes 2 and 4."""
