"""Hunt's matrix of cofactors is that of the Jacobian, names the dependent screws, and is judged by finite motion."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.kinematics import task_jacobian
from rankdrop.local.cofactors import hunt
from rankdrop.local.ways_out import escape
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.text.procedure import hunt_words

PLACES = {
    "wrist": ("puma560", [0.3, 0.5, 0.4, 0.2, 0.0, 0.6]),
    "elbow": ("ur5", [0.3, -1.0, 0.0, 0.4, 1.2, 0.3]),
    "elbow, decoupled": ("anthropomorphic", [0.2, 0.4, 0.0, 0.3, 0.7, 0.1]),
    "planar": ("planar2r", [0.3, 0.0]),
    "slides": ("stanford", [0.1, 0.2, 0.5, 0.3, 0.0, 0.4]),
    "scara": ("scara", [0.1, 0.0, 0.2, 0.3]),
}


def cofactors(matrix: np.ndarray) -> np.ndarray:
    """By minors, one by one."""
    n = len(matrix)
    minor = [[np.delete(np.delete(matrix, i, 0), j, 1) for j in range(n)] for i in range(n)]
    return np.array([[(-1) ** (i + j) * np.linalg.det(minor[i][j]) for j in range(n)] for i in range(n)])


@pytest.mark.parametrize("place", PLACES)
def test_the_matrix_is_that_of_the_minors(place: str) -> None:
    name, q = PLACES[place]
    robot = open_robot(name)
    task = resolve_task(None, robot)
    found = hunt(robot, np.array(q), task)
    wanted = cofactors(task_jacobian(robot, q, task))
    np.testing.assert_allclose(found.matrix, wanted / np.abs(wanted).max(), atol=1e-9)
    assert found.applies
    assert [one.named for one in found.joints] == list(np.abs(wanted).max(axis=0) > 1e-9 * np.abs(wanted).max())


@pytest.mark.parametrize("place", PLACES)
def test_its_rate_is_that_of_the_determinant_and_finite_motion_agrees(place: str) -> None:
    """∂ det J/∂q_j by central differences, over the other singular values; and what `escape` finds of each joint."""
    name, q = PLACES[place]
    robot = open_robot(name)
    task = resolve_task(None, robot)
    found = hunt(robot, np.array(q), task)
    others = np.prod(np.linalg.svd(task_jacobian(robot, q, task), compute_uv=False)[:-1])
    ways = {one.number: one for one in escape(robot, q, task).single}
    assert all(one.tells == one.escapes for one in found.joints)
    for one in found.joints:
        step = 1e-5 * np.eye(robot.n)[one.number - 1]
        ahead, behind = (np.linalg.det(task_jacobian(robot, q + sign * step, task)) for sign in (1, -1))
        unit = 1.0 if robot.variables[one.number - 1].unit == "rad" else task.scale(robot)
        assert abs(one.rate) == pytest.approx(abs(ahead - behind) / 2e-5 / others * unit, abs=1e-8)
        assert one.tells == (ways[one.number].order == 1)
        assert one.escapes == (ways[one.number].order is not None)


def test_where_it_names_nobody() -> None:
    """GR: it is for arms without redundancy, and tells nothing where more than one freedom is lost."""
    arm = open_robot("rcrrrr")
    assert "6 rows, 7 joints" in hunt_words(hunt(arm, np.zeros(7), resolve_task(None, arm)))
    arm = open_robot("anthropomorphic")
    task = resolve_task(None, arm)
    found = hunt(arm, np.array([0.2, np.pi / 2, 0.0, 0.3, 0.0, 0.1]), task)
    assert not found.applies
    assert "is zero where" in hunt_words(found)
    assert not hunt(arm, np.array([0.2, 0.4, 0.5, 0.3, 0.7, 0.1]), task).applies


def test_grs_procedure_names_the_same_joint_at_a_wrist() -> None:
    """Joints 4 and 6 make the dependency, joint 5 undoes it: by Hunt, by GR and by finite motion."""
    arm = open_robot("puma560")
    found = hunt(arm, np.array(PLACES["wrist"][1]), resolve_task(None, arm))
    assert [one.number for one in found.joints if one.named] == [4, 6]
    for said in ("tells", "actuator", "escapes"):
        assert [one.number for one in found.joints if getattr(one, said)] == [5]
