"""Shares of a region that are proven."""

from __future__ import annotations

import numpy as np
import pytest

import rankdrop
from rankdrop.cover.setting import enclose, setting_at_tip
from rankdrop.designs.postures import poses_at
from rankdrop.designs.region import _RegionBounds
from rankdrop.local.block import singular_values
from rankdrop.problem import Problem
from rankdrop.robot.drawing import Drawing
from rankdrop.task import resolve_task


@pytest.mark.spread(4)
@pytest.mark.slow
@pytest.mark.parametrize(("name", "task", "rpy"), [
    ("planar3r", "planar-position", None), ("anthropomorphic", "position", None), ("ur5", "pose", None),
    ("ur5", "pose", [0.0, 3.1, 0.4]), ("scara", None, [np.pi, 0.0, 0.3]), ("ur5", "tool-axis-free", [0.0, 3.1, 0.4]),
])  # fmt: skip
def test_what_is_left_out_and_proven_holds_at_random(name: str, task: str | None, rpy: list[float] | None) -> None:
    arm = Drawing.of(name).nominal
    problem = Problem(arm, resolve_task(task, arm), limits=name == "scara")
    turned = None if rpy is None else np.array(rpy)
    proof = _RegionBounds(problem, turned, 12, 0)
    rng = np.random.default_rng(3)
    postures = rankdrop.local.sample(arm, problem.task, 60, 4, limits=True)
    # the task's own σ
    setting = setting_at_tip(arm, problem.task)
    own = enclose(arm, setting, postures, np.zeros_like(postures))[3]
    assert own == pytest.approx(singular_values(arm, postures, problem.task)[:, : setting.rank], abs=1e-10)
    # a posture that reaches the pose is never lost, nor is its σ bounded too low
    at = rankdrop.kinematics.pose(arm, postures)[:, :3, 3]
    q, sigma = proof.postures.solve(poses_at(at, turned), postures)
    good = np.isfinite(sigma)
    assert good.sum() >= 3
    q, sigma, at = q[good], sigma[good], at[good]
    idle = proof._idle()
    for size in (2.0, 0.3, 0.02):
        half = np.where(idle, 0.0, size)[None]
        for one, value, place in zip(q, sigma, at, strict=True):
            centre = np.where(idle, 0.0, one + rng.uniform(-size, size, arm.n))[None]
            c, h = proof._boxes_left(poses_at(place[None], turned)[0], centre, half)
            assert len(c) == 1
            assert (np.abs(c[0] - np.where(idle, 0.0, one)) <= h[0] + 1e-7).all()
            assert proof._most(centre, half)[0] >= value - 1e-9
    # a cell that is proven: the best posture found at its corners is at least so good
    cells = np.full((len(q), 3), 2e-3) * proof.moved
    low = proof.proven(at, q, cells)
    rows = np.flatnonzero(low > 0.0)
    assert len(rows)
    for i in rows[:5]:
        corner = at[i] + cells[i] * rng.choice([-1.0, 1.0], 3)
        _, value = proof.postures.solve(poses_at(corner[None], turned), q[i : i + 1])
        assert value[0] >= low[i] - 1e-9
        assert low[i] > 0.3 * value[0]
