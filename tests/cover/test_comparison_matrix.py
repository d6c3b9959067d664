"""The M-matrix lemma: a box is called free exactly where no E with |E| ≤ B makes Σ + E singular."""

from __future__ import annotations

import numpy as np
import pytest
from reference import arms

from rankdrop.cover.setting import enclose, settings_for
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


def threshold(robot, setting, q):
    """Half-widths just below and just above the size where a cube around each q stops being free."""
    low, high = np.zeros(len(q)), np.full(len(q), 3.0)
    for _ in range(40):
        middle = (low + high) / 2
        free = enclose(robot, setting, q, np.tile(middle[:, None], robot.n))[0].astype(bool)
        low, high = np.where(free, middle, low), np.where(free, high, middle)
    return low, high


@pytest.mark.parametrize("name", ["puma560", "panda", "ur5", "planar3r", "almarkhi4", "scara"])
def test_a_free_box_is_regular_for_every_pattern_of_signs(name):
    robot = open_robot(name)
    rng = np.random.default_rng(1)
    q = rng.uniform(-np.pi, np.pi, (12, robot.n))
    settings = settings_for(robot, resolve_task(None, robot))
    for setting in settings[:: max(1, len(settings) // 4)]:
        low, high = threshold(robot, setting, q)
        assert (low > 1e-3).sum() > 6
        for half, expected in ((low, 1), (high, 0)):
            free, _, bound, sigma, *_ = enclose(robot, setting, q, np.tile(half[:, None], robot.n))
            assert (free == expected).all()
            for i in np.flatnonzero(low > 1e-6):
                rank = setting.rank
                worst = np.linalg.eigvals(np.diag(sigma[i]) - bound[i]).real.min()
                assert (worst > -1e-9) if expected else (worst < 1e-9)  # eigenvalues of an M-matrix lie right of zero
                if not expected:
                    continue
                signs = rng.choice([-1.0, 1.0], (200, rank, rank))
                signs[0] = -1.0
                signs[1:20] = -np.sign(rng.normal(size=(19, rank, 1)) * rng.normal(size=(19, 1, rank)))  # of rank one
                some = np.linalg.det(np.diag(sigma[i]) + signs * bound[i])
                assert (some > -1e-12 * sigma[i].prod()).all()  # the sign of det Σ: none is singular


def test_off_diagonals_count():
    # where the diagonal alone would be regular, but the whole comparison matrix is not, the box is not free
    robot, met = open_robot("puma560"), 0
    setting = settings_for(robot, resolve_task(None, robot))[7]
    q = np.random.default_rng(2).uniform(-np.pi, np.pi, (200, 6))
    for half in (0.05, 0.1, 0.2):
        free, _, bound, sigma, *_ = enclose(robot, setting, q, np.full_like(q, half))
        diagonal = (sigma > np.diagonal(bound, axis1=1, axis2=2)).all(axis=1)
        worst = np.linalg.eigvals(sigma[:, :, None] * np.eye(6) - bound).real.min(axis=1)
        apart = diagonal & (worst < 0.0)
        assert not free[apart].any()
        met += int(apart.sum())
    assert met > 20


@pytest.mark.parametrize("name", ["puma560", "panda", "ur5", "planar3r", "almarkhi4", "scara", "pa10"])
def test_no_ball_is_smaller_than_its_bound_allows(name):
    # at the radius the comparison matrix is singular to a millionth
    robot = open_robot(name)
    q = np.random.default_rng(3).uniform(-np.pi, np.pi, (40, robot.n))
    for setting in settings_for(robot, resolve_task(None, robot))[::5]:
        _, radius, bound, sigma, *_ = enclose(robot, setting, q, radius=3.0)
        met = (radius > 0.0) & (radius < 3.0)
        assert met.sum() > 30
        worst = np.linalg.eigvals(sigma[met][:, :, None] * np.eye(setting.rank) - bound[met]).real.min(axis=1)
        assert (worst > -1e-12).all()
        assert (worst < 1e-6 * sigma[met, 0]).all()


def test_singular_matrices_are_never_free():
    rng = np.random.default_rng(4)
    robot = arms.random_chain(rng, "rrrrrr")
    settings = settings_for(robot, resolve_task("pose", robot))
    parallel = arms.standard_dh("three parallel axes twice", [(0.3, 0, 0, 0)] * 6)
    for setting in settings_for(parallel, resolve_task("pose", parallel)):
        assert setting.rank == 3  # always singular: what is kept is its own generic rank
        assert enclose(parallel, setting, np.array([[0.1, 1.0, 1.2, 0.5, 0.3, 0.2]]))[1][0] > 0.0
    assert settings[0].rank == 6
