"""∂J/∂q by the bracket equals differences in every frame, task and joint kind, and AM eq. 9 once that is corrected."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference import arms
from reference import kinematics as oracle
from reference.measure import central_differences, relative

from rankdrop.kinematics import jacobian, jacobian_derivative, task_jacobian
from rankdrop.robot.model import Array, Robot
from rankdrop.task import BODY, SPACE, TIP, WORLD_ALIGNED, Frame, resolve_task, task_names

FRAMES = {
    "space": SPACE,
    "body": BODY,
    "world aligned": WORLD_ALIGNED,
    "tip axes, link 1 origin": Frame(TIP, 1, (0.2, 0.1, -0.3)),
    "link 1 axes, tip origin": Frame(1, TIP, (0.0, 0.4, 0.1)),
    "link 1 throughout": Frame(1, 1, (0.5, 0.0, 0.2)),
}


def near_and_far(robot: Robot, rng: np.random.Generator) -> Array:
    """Generic configurations, q = 0 exactly, and one 1e-7 away from it."""
    q = rng.uniform(-np.pi, np.pi, (5, robot.n))
    q[0], q[1] = 0.0, 1e-7 * rng.normal(size=robot.n)
    return q


@pytest.mark.parametrize("frame", FRAMES.values(), ids=FRAMES)
@pytest.mark.parametrize("kinds", arms.CHAINS)
def test_derivative_equals_central_differences(kinds: str, frame: Frame, rng: np.random.Generator) -> None:
    robot = arms.random_chain(rng, kinds)
    q = near_and_far(robot, rng)
    numeric = central_differences(lambda x: jacobian(robot, x, frame), q)
    assert relative(jacobian_derivative(robot, q, frame), numeric) < 1e-10


@pytest.mark.parametrize("name", [*task_names(), "vz,wx"])
def test_derivative_of_every_task(name: str, rng: np.random.Generator) -> None:
    """The rows of the task out of the derivative, translation rows over the length scale, derive the task Jacobian."""
    for kinds in ("rrrrrrr", "rphmr"):
        robot = arms.random_chain(rng, kinds)
        q = near_and_far(robot, rng)
        for frame in FRAMES.values():
            task = resolve_task(name, robot, frame=frame)
            weight = np.array([1 / task.scale(robot) if row < 3 else 1.0 for row in task.rows])
            rows = jacobian_derivative(robot, q, frame)[:, list(task.rows)] * weight[:, None, None]
            assert relative(rows, central_differences(lambda x: task_jacobian(robot, x, task), q)) < 1e-10  # noqa: B023


@pytest.mark.parametrize("name", ["pa10", "puma", "scara", "planar3r"])
def test_derivative_at_exactly_singular_configurations(name: str, rng: np.random.Generator) -> None:
    robot, q = arms.singular_configurations(name, rng, 9)
    for frame in FRAMES.values():
        numeric = central_differences(lambda x: jacobian(robot, x, frame), q)  # noqa: B023
        assert relative(jacobian_derivative(robot, q, frame), numeric) < 1e-10


def test_in_the_space_frame_it_is_the_bracket_and_nothing_else(rng: np.random.Generator) -> None:
    robot = arms.random_chain(rng, "rrhprr")
    q = near_and_far(robot, rng)
    columns = np.swapaxes(jacobian(robot, q, SPACE), -1, -2)
    derivative = jacobian_derivative(robot, q, SPACE)
    for i in range(6):
        for k in range(6):
            want = oracle.bracket(columns[:, k], columns[:, i]) if k < i else np.zeros((5, 6))
            assert relative(derivative[:, :, i, k], want) < 1e-13


def test_hessian_of_the_position_is_symmetric(rng: np.random.Generator) -> None:
    """The tip's position is a function of q, so ∂²p/∂q_i∂q_k does not depend on the order."""
    for kinds in arms.CHAINS:
        robot = arms.random_chain(rng, kinds)
        hessian = jacobian_derivative(robot, near_and_far(robot, rng))[:, :3]
        assert relative(hessian, np.swapaxes(hessian, -1, -2)) < 1e-13


screw = st.lists(st.floats(-3, 3), min_size=6, max_size=6).map(np.array)


@given(screw, screw, screw)
def test_jacobi_identity_of_the_bracket(a: Array, b: Array, c: Array) -> None:
    lie = oracle.bracket
    cyclic = lie(a, lie(b, c)) + lie(b, lie(c, a)) + lie(c, lie(a, b))
    assert np.abs(cyclic).max() < 1e-11
    assert np.abs(lie(a, b) + lie(b, a)).max() < 1e-12


def equation_9(robot: Robot, q: Array, *, printed: bool) -> Array:
    """AM eq. 9 for revolute joints, with the last term of the branch k < i as printed (p_k) or corrected (p_i).

    p_i runs from the origin of DH frame i − 1 to the tip, z_i is axis i.
    """
    motions = oracle.carried(robot, q)
    z = oracle.screws(robot, motions)[..., 3:]
    origins = [oracle.link_pose(robot, motions, link)[0][..., :3, 3] for link in range(robot.n)]
    p = oracle.pose(robot, q)[..., None, :3, 3] - np.stack(origins, axis=-2)
    derivative = np.zeros((*q.shape[:-1], 6, robot.n, robot.n))

    def dot(a: Array, b: Array) -> Array:
        return (a * b).sum(-1, keepdims=True)

    for i in range(robot.n):
        zi, pi = z[..., i, :], p[..., i, :]
        for k in range(robot.n):
            zk, pk = z[..., k, :], p[..., k, :]
            if k < i:
                linear = dot(zk, pi) * zi - dot(zk, zi) * (pk if printed else pi)
                angular = oracle.cross(zk, zi)
            else:
                linear, angular = dot(zi, pk) * zk - dot(zk, zi) * pk, np.zeros_like(zi)
            derivative[..., :, i, k] = np.concatenate([linear, angular], axis=-1)
    return derivative


@pytest.mark.parametrize("arm", [arms.pa10, arms.almarkhi4, arms.puma])
def test_equation_9_of_almarkhi_once_corrected_is_the_bracket(
    arm: Callable[[], Robot], rng: np.random.Generator
) -> None:
    robot = arm()
    q = rng.uniform(-np.pi, np.pi, (50, robot.n))
    assert relative(jacobian_derivative(robot, q), equation_9(robot, q, printed=False)) < 1e-13


@pytest.mark.parametrize(("arm", "least", "most"), [(arms.almarkhi4, 2.0, 5.0), (arms.pa10, 0.3, 2.0)])
def test_equation_9_as_printed_is_wrong(
    arm: Callable[[], Robot], least: float, most: float, rng: np.random.Generator
) -> None:
    """Not by rounding: by 2.2 and more on AM's 4-DoF arm, by 0.4 and more on the PA-10."""
    robot = arm()
    q = rng.uniform(-np.pi, np.pi, (2000, robot.n))
    error = np.abs(jacobian_derivative(robot, q) - equation_9(robot, q, printed=True)).max()
    assert least < error < most


def test_gradient_of_singular_values_of_the_pa10() -> None:
    """∂J/∂θ4 and ∂σ6/∂θ (AM eqs 9 and 7) of AM's PA-10 at one configuration, worked out by an independent program."""
    theta = np.array(THETA)
    robot = arms.pa10()
    derivative = jacobian_derivative(robot, theta)
    assert relative(derivative[:, :, 3], np.array(D_THETA4)) < 1e-14
    u, _, vt = np.linalg.svd(jacobian(robot, theta))
    for row, want in GRADIENTS.items():
        gradient = np.einsum("m,mnk,n->k", u[:, row], derivative, vt[row])
        assert relative(gradient, np.array(want)) < 1e-13


THETA = [
    0.8605556614246863, -1.4464727375963786, -2.8841484100105235, -3.03774645687452,
    1.9683349641197863, 2.5934197786078093, 0.6700123395200417,
]  # fmt: skip
D_THETA4 = [
    [
        -0.09094123875700011, 0.07170413188068536, -0.09401549201793633, -0.08968428275793106,
        0.13656300382826012, -0.05139428851726605, 0.0,
    ],
    [
        0.0363224171014923, 0.08338201503593404, 0.07565481246526362, -0.07372127944530754,
        0.16755624933985397, -0.15686439564619103, 0.0,
    ],
    [
        0.0, -0.09263490681526602, -0.031510234276243665, 0.09058461367202642,
        -0.005160271857901813, -0.2232826024569209, 0.0,
    ],
    [0.0, 0.0, 0.0, 0.0, -0.18130605454910764, 0.5823385827093167, 0.28216765416899137],
    [0.0, 0.0, 0.0, 0.0, 0.1775585723059915, 0.7145014830471058, 0.004804339120009653],
    [0.0, 0.0, 0.0, 0.0, 0.9672647352118726, -0.022004681472182562, -0.8303543297622178],
]  # fmt: skip
GRADIENTS = {
    0: [
        0.0, 0.17550656424640096, 0.02752924663754197, -0.07751916693497572,
        0.03460278113908984, -0.04782709749421022, 0.0,
    ],
    5: [
        0.0, -0.0001472697990333701, -8.600209492995059e-05, 0.17826725672000931,
        0.0039464157390310915, -0.027146746576843486, 0.0,
    ],
}  # fmt: skip
