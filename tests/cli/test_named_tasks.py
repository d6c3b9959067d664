"""Tasks in tool axes, and what a new named task takes: one line in `rankdrop.named_tasks`."""

from __future__ import annotations

import json

import numpy as np
import pytest

from rankdrop import task as tasks
from rankdrop.kinematics import jacobian
from rankdrop.local.block import sample, singular_values
from rankdrop.robot.open import open_robot
from rankdrop.task import BODY, WORLD_ALIGNED, Frame, resolve_task, task_names
from rankdrop.verbs.explain import explain


def test_tool_axis_free_is_five_rows_in_tool_axes() -> None:
    arm = open_robot("ur5e")
    task = resolve_task("tool-axis-free", arm)
    assert (task.rows, task.frame) == ((0, 1, 2, 3, 4), BODY)
    assert resolve_task("vx,vy,vz,wx,wy", arm).name == "vx,vy,vz,wx,wy"  # these rows in base axes are another task
    q = sample(arm, task, 20, seed=1)
    scale = np.array([1 / task.scale(arm)] * 3 + [1.0] * 2)
    by_hand = np.linalg.svd(jacobian(arm, q, BODY)[:, :5] * scale[:, None], compute_uv=False)
    assert np.allclose(singular_values(arm, q, task), by_hand, atol=1e-13)


def test_a_turn_about_the_tool_axis_changes_nothing() -> None:
    """The flange turns about the tool's z axis, so joint 6 does not move the task, and rank 5 takes joints 1 to 5."""
    arm = open_robot("ur5e")
    task = resolve_task("tool-axis-free", arm)
    q = sample(arm, task, 20, seed=2)
    turned = q + np.array([0, 0, 0, 0, 0, 0.7])
    assert np.allclose(singular_values(arm, q, task), singular_values(arm, turned, task), atol=1e-12)
    assert np.abs(jacobian(arm, q, BODY)[:, :5, 5]).max() < 1e-12


def test_across_the_tool_axis_the_distance_along_it_is_free() -> None:
    """Two rows of the body Jacobian."""
    arm = open_robot("puma560")
    task = resolve_task("across-tool-axis", arm)
    q = sample(arm, task, 5, seed=3)
    assert np.allclose(
        singular_values(arm, q, task),
        np.linalg.svd(jacobian(arm, q, BODY)[:, :2] / task.scale(arm), compute_uv=False), atol=1e-13,
    )  # fmt: skip


@pytest.mark.parametrize("name", ["tool-axis-free", "across-tool-axis"])
def test_named_tasks_are_understood_on_the_command_line(run, name: str) -> None:
    record = json.loads(run("explain", "ur5e", "--deg", "--q", "10,-60,0,40,50,20", "--task", name, "--json", "-").out)
    assert record["robot"]["task"] == name
    assert record["robot"]["rows"] == list(resolve_task(name, open_robot("ur5e")).rows)
    assert record["robot"]["frame"]["axes"] == BODY.axes


def test_a_new_task_is_one_line(run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(tasks._NAMED, "drill", ((0, 1, 2, 3, 4), Frame(axes=3)))
    arm = open_robot("ur5e")
    assert "drill" in task_names()
    found = explain(arm, [0.1, -1.0, 0.4, 0.7, 0.9, 0.2], "drill", evaluations=0)
    assert (found.task.name, found.task.frame.axes) == ("drill", 3)
    assert run("explain", "ur5e", "--q", "0.1,-1,0.4,0.7,0.9,0.2", "--task", "drill").code in (0, 3, 4)
    assert "drill" in run("explain", "ur5e", "--q", "0,0,0,0,0,0", "--task", "nothing").err


def test_names_in_base_axes_are_found_by_their_rows() -> None:
    arm = open_robot("ur5e")
    for name, (rows, frame) in tasks._NAMED.items():
        if frame == WORLD_ALIGNED:
            assert resolve_task(",".join(tasks.ROWS[row] for row in rows), arm).name == name
