"""The words of a name of a family."""

from __future__ import annotations

import numpy as np
from families.named import name, ur

from rankdrop.families.searching import search
from rankdrop.task import resolve_task


def test_the_shoulder_of_a_ur_type_arm_is_where_axes_5_and_6_meet() -> None:
    found = search(ur(), 1, task=resolve_task(None, ur()), starts=60, seed=0).converged
    found = found[(np.abs(np.sin(found[:, 2])) > 0.1) & (np.abs(np.sin(found[:, 4])) > 0.1)]
    assert name(ur(), found) == "shoulder: axes 5, 6 meet in plane of axes 1, 2"
