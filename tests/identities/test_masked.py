"""Masked configurations are refused: NumPy would compute with the numbers under the mask."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop import explain
from rankdrop.cover import asked_about, certified_radius
from rankdrop.errors import ConfigurationError, RankdropError
from rankdrop.kinematics import pose
from rankdrop.local.nearest import nearest_singularity
from rankdrop.path.check.check import check_path
from rankdrop.robot.model import Joint, with_tool
from rankdrop.robot.open import open_robot
from rankdrop.robot.screws import from_screws


def test_masked_values_are_refused_and_an_empty_mask_is_not() -> None:
    arm = open_robot("planar2r")
    q = np.ma.masked_array([[0.1, 0.2], [0.3, 99.0]], mask=[[False, False], [False, True]])
    with pytest.raises(ConfigurationError, match="q has masked values"):
        pose(arm, q)
    assert pose(arm, np.ma.masked_array([0.1, 0.2], mask=False)).tolist() == pose(arm, [0.1, 0.2]).tolist()


def test_nothing_takes_the_numbers_under_a_mask() -> None:
    """Paths, certified balls, distances, tools and screws took them: NumPy's `asarray` drops the mask."""
    arm = open_robot("planar3r")
    q = np.ma.masked_array([0.1, 0.2, 99.0], mask=[False, False, True])
    rows = np.ma.masked_array([[0.1, 0.2, 0.3], [0.3, 0.4, 99.0]], mask=[[False] * 3, [False, False, True]])
    screws = np.ma.masked_array(np.eye(6), mask=np.eye(6, k=1))
    for call in (
        lambda: certified_radius(arm, q), lambda: nearest_singularity(arm, q), lambda: check_path(arm, rows),
        lambda: explain(arm, q), lambda: with_tool(arm, q), lambda: from_screws(screws, order="linear-first"),
        lambda: asked_about(arm, q=q), lambda: Joint("a", "revolute", screws[0]),  # type: ignore[arg-type]
        lambda: check_path(arm, rows.data % 3, np.ma.masked_array([0.0, 1.0], mask=[False, True])),
    ):  # fmt: skip
        with pytest.raises(RankdropError, match="has masked values"):
            call()
