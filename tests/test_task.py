"""Frames of a task."""

from __future__ import annotations

import numpy as np
import pytest
from known.planar import ARM, A

import rankdrop
from rankdrop.errors import TaskError
from rankdrop.task import BODY, SPACE, WORLD_ALIGNED


def test_a_frame_has_a_name() -> None:
    for name, frame in (("base", WORLD_ALIGNED), ("tip", BODY), ("space", SPACE)):
        np.testing.assert_array_equal(rankdrop.jacobian(ARM, A, name), rankdrop.jacobian(ARM, A, frame))
        derivative = rankdrop.jacobian_derivative(ARM, A, name)
        np.testing.assert_array_equal(derivative, rankdrop.jacobian_derivative(ARM, A, frame))
    for wrong in ("world", None, 3, ["base"]):
        with pytest.raises(TaskError, match=r"there is no such frame; got .*; allowed: base, tip, space, or a Frame"):
            rankdrop.jacobian(ARM, A, wrong)  # type: ignore[arg-type]
