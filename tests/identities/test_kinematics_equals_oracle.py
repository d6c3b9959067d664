"""The core computes what the plain NumPy oracle computes: every chain, every frame, every batch shape."""

from __future__ import annotations

import numpy as np
import pytest
from reference import arms
from reference import kinematics as oracle
from reference.measure import relative

from rankdrop.kinematics import jacobian, jacobian_derivative, pose, task_jacobian
from rankdrop.robot.model import Robot
from rankdrop.task import BASE, BODY, SPACE, TIP, WORLD_ALIGNED, Frame, resolve_task, task_names

TOLERANCE = 1e-13
BATCHES = [(), (1,), (5,), (0,), (2, 3), (2, 0, 3), (4, 1, 2)]


def frames(robot: Robot) -> list[Frame]:
    """The named frames, and axes, origin and point taken from links all along the chain."""
    last = len(robot.joints)
    mixed = [
        Frame(last, last),
        Frame(1, TIP),
        Frame(TIP, BASE, (0.3, -0.2, 0.5)),
        Frame(last // 2, last // 2, (0.1, 0.7, -0.4)),
        Frame(last // 2 + 1 if last > 1 else 1, last // 2, (-1.0, 0.2, 0.3)),
    ]
    return [SPACE, BODY, WORLD_ALIGNED, *mixed]


def sample(robot: Robot, rng: np.random.Generator, shape: tuple[int, ...] = (9,)) -> np.ndarray:
    """Random configurations; with a batch of some size the first is q = 0 and the second 1e-9 away from it."""
    q = rng.uniform(-np.pi, np.pi, (*shape, robot.n))
    if len(shape) == 1 and shape[0] > 2:
        q[0], q[1] = 0.0, 1e-9
    return q


@pytest.mark.parametrize("kinds", arms.CHAINS)
def test_pose_jacobian_and_derivative_in_every_frame(kinds: str, rng: np.random.Generator) -> None:
    robot = arms.random_chain(rng, kinds)
    q = sample(robot, rng)
    assert relative(pose(robot, q), oracle.pose(robot, q)) < TOLERANCE
    for frame in frames(robot):
        assert relative(jacobian(robot, q, frame), oracle.jacobian(robot, q, frame)) < TOLERANCE, frame
        got, want = jacobian_derivative(robot, q, frame), oracle.jacobian_derivative(robot, q, frame)
        assert relative(got, want) < TOLERANCE, frame


@pytest.mark.parametrize("arm", [arms.pa10, arms.almarkhi4, arms.puma, arms.scara, arms.planar3r])
def test_dh_arms_agree_too(arm: object, rng: np.random.Generator) -> None:
    robot = arm()  # type: ignore[operator]
    q = sample(robot, rng)
    assert relative(pose(robot, q), oracle.pose(robot, q)) < TOLERANCE
    assert relative(jacobian(robot, q), oracle.jacobian(robot, q)) < TOLERANCE
    assert relative(jacobian_derivative(robot, q), oracle.jacobian_derivative(robot, q)) < TOLERANCE


@pytest.mark.parametrize("shape", BATCHES, ids=str)
@pytest.mark.parametrize("kinds", ["rrrrrrr", "rrmrrrr", "hrp"])
def test_leading_axes_are_kept(kinds: str, shape: tuple[int, ...], rng: np.random.Generator) -> None:
    robot = arms.random_chain(rng, kinds)
    q = sample(robot, rng, shape)
    n = robot.n
    assert pose(robot, q).shape == (*shape, 4, 4)
    assert jacobian(robot, q).shape == (*shape, 6, n)
    assert jacobian_derivative(robot, q).shape == (*shape, 6, n, n)
    assert relative(pose(robot, q), oracle.pose(robot, q)) < TOLERANCE
    assert relative(jacobian(robot, q, BODY), oracle.jacobian(robot, q, BODY)) < TOLERANCE
    assert relative(jacobian_derivative(robot, q), oracle.jacobian_derivative(robot, q)) < TOLERANCE


@pytest.mark.parametrize("batch", [1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 17, 33, 1000])
def test_a_configuration_gives_the_same_bits_alone_and_in_a_batch_of_any_length(
    batch: int, rng: np.random.Generator
) -> None:
    robot = arms.pa10()
    q = sample(robot, rng, (batch,))
    together = jacobian(robot, q)
    for b in {0, batch // 2, batch - 1}:
        np.testing.assert_array_equal(together[b], jacobian(robot, q[b]))


def test_lists_integers_and_strided_arrays_are_taken_as_they_are() -> None:
    robot = arms.pa10()
    wide = np.arange(28.0).reshape(2, 14) / 7
    want = oracle.jacobian(robot, wide[:, ::2])
    assert relative(jacobian(robot, wide[:, ::2]), want) < TOLERANCE
    assert relative(jacobian(robot, np.asfortranarray(wide[:, ::2])), want) < TOLERANCE
    assert relative(jacobian(robot, [0, 1, 0, 1, 0, 1, 0]), oracle.jacobian(robot, [0, 1, 0, 1, 0, 1, 0])) < TOLERANCE


def test_the_input_is_not_changed(rng: np.random.Generator) -> None:
    robot, q = arms.pa10(), rng.uniform(-9, 9, (4, 7))
    before = q.copy()
    pose(robot, q), jacobian(robot, q), jacobian_derivative(robot, q)
    np.testing.assert_array_equal(q, before)


@pytest.mark.spread(21)
@pytest.mark.slow
@pytest.mark.parametrize("name", [*task_names(), "vz", "vx,wy,wz"])
@pytest.mark.parametrize("scale", [None, 1.0, 0.25])
def test_task_rows_and_length_scale(name: str, scale: float | None, rng: np.random.Generator) -> None:
    for kinds in ("rrrrrrr", "rprh", "rrmrrrr"):
        robot = arms.random_chain(rng, kinds)
        q = sample(robot, rng)
        for frame in frames(robot):
            task = resolve_task(name, robot, frame=frame, length_scale=scale)
            got = task_jacobian(robot, q, task)
            assert got.shape == (9, task.m, robot.n)
            assert relative(got, oracle.task_jacobian(robot, q, task)) < TOLERANCE


def test_pa10_at_a_configuration_worked_out_elsewhere() -> None:
    """A Jacobian of AM's PA-10 (Table 2) computed once by an independent program, to the last digits."""
    theta = [
        0.8605556614246863, -1.4464727375963786, -2.8841484100105235, -3.03774645687452, 1.9683349641197863,
        2.5934197786078093, 0.6700123395200417,
    ]  # fmt: skip
    want = [
        [
            0.3959945512052935, 0.012938537750143636, 0.03417513038259373, 0.0363224171014923,
            -0.029235585551136315, -0.44200458343087495, 0.0,
        ],
        [
            -0.03847094949479009, 0.015045734756550029, 0.008068140016464317, 0.09094123875700011,
            0.016680397499170937, 0.05947559867276484, 0.0,
        ],
        [
            0.0, 0.3253287256076417, 0.22725834702247324, 0.10997291921293828,
            -0.23207973766894507, 0.059954994692811, 0.0,
        ],
        [
            0.0, -0.7582049802141123, -0.6469838531273985, 0.7538032722649112,
            0.6315922270789502, -0.124667801507472, -0.14027628694874644,
        ],
        [
            0.0, 0.652016263584366, -0.7523529809863957, -0.6065898712525369,
            0.7749333400328628, 0.0711293598294818, -0.9886719550618819,
        ],
        [
            1.0, 0.0, 0.12400357169577365, 0.2526447205396204,
            -0.023865816536693576, -0.9896456706506334, -0.05338846873613477,
        ],
    ]  # fmt: skip
    assert relative(jacobian(arms.pa10(), theta), np.array(want)) < 1e-14
