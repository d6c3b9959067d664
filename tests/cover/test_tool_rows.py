"""Rows in tool axes: enclosures, certificates and coverings of a tool that may turn about its own axis."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from reference import arms
from reference.coverings import covering

from rankdrop.cover import ModelTolerance, asked_about, certified_radius, verify, write_certificate
from rankdrop.cover.ball import displaced_columns
from rankdrop.cover.certificates import ball_certificate, existence_certificate
from rankdrop.cover.covering import SPLIT, _with_tool_axis
from rankdrop.cover.setting import enclose, settings_for
from rankdrop.errors import OptionError
from rankdrop.kinematics import jacobian
from rankdrop.path.check.certificate import path_certificate
from rankdrop.path.check.check import check_path
from rankdrop.proof.record import with_hash
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import BODY, Frame, resolve_task

KUKA = Path(__file__).parents[1] / "data" / "reports" / "05-kr120-without-a6.toml"
"""A KR 120 R2500 without its joint 6, the tool on the axis of that joint (KUKA's data sheet)."""


def tilted(robot: Robot) -> Robot:
    """The same arm with a tool that is mounted askew."""
    angle = 0.7
    turn = np.eye(4)
    turn[:3, :3] = [[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]]
    turn[:3, 3] = [0.02, 0.05, -0.03]
    return Robot(robot.name, robot.joints, robot.home @ turn)


ARMS = {
    "kuka": lambda: open_robot(str(KUKA)), "px150": lambda: open_robot("px150"), "ur5e": lambda: open_robot("ur5e"),
    "askew": lambda: tilted(open_robot(str(KUKA))),
    "slides": lambda: arms.random_chain(np.random.default_rng(4), "rprrpr"),
    "screws": lambda: arms.random_chain(np.random.default_rng(5), "rhrphr"),
}  # fmt: skip


@pytest.mark.parametrize("name", ["tool-axis-free", "across-tool-axis", "vy,wx"])
@pytest.mark.parametrize("arm", ARMS)
def test_nothing_exceeds_the_bound(arm: str, name: str) -> None:
    """|U₁ᵀ J(q + δ) V₁ − Σ| ≤ B, J the rows of the body Jacobian at the task's point."""
    robot = ARMS[arm]()
    frame = Frame(-1, -1, (0.03, -0.02, 0.1))
    task = resolve_task(name, robot, frame=frame)
    rng = np.random.default_rng(3)
    q = rng.uniform(-2, 2, (2, robot.n))
    for setting in settings_for(robot, task):
        assert setting.tool
        factor = np.array([1 / setting.length if row < 3 else 1.0 for row in setting.rows])
        for size in (0.02, 0.3):
            half = size * rng.uniform(0.2, 1.0, q.shape)
            _, _, bound, sigma, u, v, _ = enclose(robot, setting, q, half)
            for i in range(len(q)):
                delta = np.concatenate([rng.choice([-1.0, 1.0], (60, robot.n)), rng.uniform(-1, 1, (60, robot.n))])
                rows = jacobian(robot, q[i] + delta * half[i] * setting.scale, frame)[:, list(setting.rows)]
                error = u[i].T @ (rows * factor[:, None]) @ v[i] - np.diag(sigma[i])
                assert (np.abs(error).max(axis=0) <= bound[i] * (1 + 1e-12)).all()


def test_the_certified_radius_reaches_the_singularity_that_is_known() -> None:
    """For position and tool axis the wrist is singular at θ5 = 0, and nothing is nearer here."""
    robot = open_robot(str(KUKA))
    found = certified_radius(robot, np.radians([0, -60, 90, 0, 10]), "tool-axis-free")
    assert np.radians(9.8) < found.radius <= np.radians(10)


def test_other_axes_than_those_of_the_tool_are_refused() -> None:
    robot = open_robot(str(KUKA))
    with pytest.raises(OptionError, match="axes that the tool does not carry") as error:
        certified_radius(robot, np.zeros(5) + 0.4, "vx,vy,vz,wx,wy")
    assert "tool-axis-free" in str(error.value)
    setting = settings_for(robot, resolve_task("tool-axis-free", robot))[0]
    with pytest.raises(OptionError, match="how the tool is mounted"):
        displaced_columns(robot, setting, ModelTolerance(1e-4, 1e-3), setting.rows)


def test_the_determinant_of_five_rows_is_that_of_six_joints() -> None:
    robot = tilted(open_robot(str(KUKA)))
    six = _with_tool_axis(robot)
    q = np.random.default_rng(5).uniform(-3, 3, (20, 5))
    five = np.linalg.det(jacobian(robot, q, BODY)[:, :5])
    assert np.allclose(np.linalg.det(jacobian(six, np.column_stack([q, np.zeros(20)]), BODY)), five, rtol=1e-11)


def test_a_covering_holds_the_wrist_and_leaves_the_rest_out() -> None:
    robot = open_robot(str(KUKA))
    found = covering(robot, 0.4, task="tool-axis-free")
    assert found.plan.method == SPLIT
    assert found.plan.variables == (2, 3, 4, 5)
    assert found.complete
    q = np.random.default_rng(6).uniform(-3, 3, (200, 5))
    singular = q * [1, 1, 1, 1, 0]
    assert found.holds(singular).all()
    assert found.free_share > 0.2
    assert not found.holds(np.radians([[20.0, -60, 90, 30, 60]])).any()


def _checked(record: dict[str, Any], folder: Path, **asked: Any) -> Any:
    return verify(write_certificate(record, folder / "one.json"), asked_about(None, **asked))


@pytest.mark.parametrize("arm", ["kuka", "askew", "px150"])
def test_certificates_are_confirmed(arm: str, tmp_path: Path) -> None:
    robot = ARMS[arm]()
    ball = ball_certificate(robot, [0.3, -0.8, 1.2, 0.3, 0.6], "tool-axis-free", radius=0.02)
    found = _checked(ball, tmp_path)
    assert found.holds
    assert "vx, vy, vz, wx, wy in the axes of the tip" in "".join(found.statement)
    rows = [[0.1, -0.9, 1.1, 0.3, 0.5], [0.2, -0.8, 1.2, 0.3, 0.6]]
    path = check_path(robot, rows, task="tool-axis-free")
    assert path.clear
    assert _checked(path_certificate(path), tmp_path, rows=rows).holds


@pytest.mark.slow
def test_a_singular_wrist_is_confirmed(tmp_path: Path) -> None:
    robot = open_robot(str(KUKA))
    record = existence_certificate(robot, [0.1, -1.0, 1.5, 0.25, 0.0], "tool-axis-free")
    assert _checked(record, tmp_path).holds
    rows = [[0, -1, 1.5, 0.2, -0.5], [0.2, -1, 1.5, 0.3, 0.5]]
    found = _checked(path_certificate(check_path(robot, rows, task="tool-axis-free")), tmp_path, rows=rows)
    assert found.holds
    assert "1 of them hold a singular configuration" in found.claim


def test_forged_axes_are_not_confirmed(tmp_path: Path) -> None:
    """Near θ5 = 0 the rows in tool axes lose rank; a ball claimed there does not become true by another view."""
    robot = open_robot(str(KUKA))
    record = ball_certificate(robot, [0.3, -0.8, 1.2, 0.3, 0.6], "tool-axis-free", radius=0.02)
    forged = copy.deepcopy(record)
    forged["claim"]["q"][4] = 0.01
    for view in ({}, {"link": 2}, {"link": 0}):
        forged["view"] |= view
        assert not _checked(with_hash(forged), tmp_path).holds
    turned = copy.deepcopy(record)
    turned["arm"]["home"] = tilted(robot).home.tolist()
    asked = asked_about(robot, task="tool-axis-free")
    assert not verify(write_certificate(with_hash(turned), tmp_path / "one.json"), asked).holds
