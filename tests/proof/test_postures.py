"""The equations of a pose, as a certificate of a change of posture has them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from reference import region

from rankdrop.cover.certificates import record_of
from rankdrop.cover.setting import best_setting
from rankdrop.proof.arm import BITS, flint
from rankdrop.proof.postures import _Pose
from rankdrop.proof.record import CHANGE, claim_of
from rankdrop.task import resolve_task


@pytest.mark.parametrize("joints", ["r p r h r r", "r r0:0.5 r r h r r", "r r r r r r"])
def test_the_equations_have_the_slopes_of_the_arm(joints: str) -> None:
    rng = np.random.default_rng(3)
    robot = region.coupled(rng, joints)
    q = rng.uniform(-0.5, 0.5, (2, robot.n))
    task = resolve_task("pose", robot)
    setting = best_setting(robot, task)
    made = record_of(robot, task, CHANGE, setting, {"degree": 1, "points": q.tolist(), "radius": 1e-9, "limits": False},
                     {})  # fmt: skip
    with flint().ctx.workprec(BITS):
        pose = _Pose(claim_of(made, Path()), q[0])
        arb = flint().arb
        at = [arb(float(x)) for x in q[1]]
        slope = np.array([[float(x.mid()) for x in row] for row in pose._equations(at)[1].tolist()])
        step = arb(2.0**-30)
        for j in range(robot.n):
            ahead, behind = ([x + (sign * step if k == j else 0) for k, x in enumerate(at)] for sign in (1, -1))
            change = (pose._equations(ahead)[0] - pose._equations(behind)[0]) / (2 * step)
            assert np.abs(slope[:, j] - [float(x.mid()) for x in change.entries()]).max() < 1e-12
