"""The arm of a certificate: which joints decide its rank."""

from __future__ import annotations

from typing import Any

import flint
import numpy as np
import pytest
from reference import arms

from rankdrop.cover.setting import middle_of
from rankdrop.proof.arm import Arm
from rankdrop.proof.record import Link

pytestmark = pytest.mark.usefixtures("precise")


@pytest.mark.parametrize("link", range(7))
def test_every_joint_that_moves_a_column_decides(link):
    """The joints that a covering has to bound are those that change a column in the link's axes, and no others."""
    robot = arms.random_chain(np.random.default_rng(5), "rprrrr")
    links = [Link(str(joint.kind), tuple(joint.screw.tolist()), j) for j, joint in enumerate(robot.joints)]
    arm = Arm(links, 6, link, [flint.arb(float(x)) for x in middle_of(robot)], flint.arb(1))
    q, zero = np.full(6, 0.3), [flint.arb(0)] * 6

    def columns(at: Any) -> Any:
        return arm.jacobian(arm.screws_over([flint.arb(float(x)) for x in at], zero)[0])

    changing = [j for j in range(6) if np.abs(columns(q + 0.5 * np.eye(6)[j]) - columns(q)).max() > 1e-9]
    assert arm.moving == changing
