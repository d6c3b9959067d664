"""Subgroups of motions."""

from __future__ import annotations

import numpy as np
import pytest
from local.screws import C, Z, concurrent, other, parallel, slides

from rankdrop.local.subgroups import closure
from rankdrop.robot.model import Array
from rankdrop.robot.screws import helical, prismatic, revolute


@pytest.mark.parametrize(("screws", "dimension"), [
    (concurrent(2), 3), (parallel(2), 3), (parallel(3), 3), (slides(2), 2), (slides(5), 3),
    ([revolute(Z, C), prismatic(Z)], 2), ([*parallel(2), prismatic(Z)], 4), ([revolute(Z, C), *slides(1)], 4),
    ([helical(Z, (0, 0, 0), 0.2), helical(Z, (1, 0, 0), 0.2)], 3), (other(2), 6), ([revolute(Z, C)], 1),
    ([helical(Z, (0, 0, 0), 0.2), helical(Z, (1, 0, 0), 0.3)], 4),
])  # fmt: skip
def test_dimensions_of_the_algebras(screws: list[Array], dimension: int) -> None:
    basis = closure(np.array(screws))
    assert basis.shape == (dimension, 6)
    assert np.allclose(basis @ basis.T, np.eye(dimension))
