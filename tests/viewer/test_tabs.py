"""What the tabs do, without a browser: walk along a family, play a path, draw a slice, follow a self-motion."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from patience import until

from rankdrop.kinematics import pose
from rankdrop.local.block import singular_values
from rankdrop.robot.model import Array, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import Task, resolve_task

pytest.importorskip("viser", reason="viser and trimesh are not installed")
pytest.importorskip("trimesh", reason="viser and trimesh are not installed")

from rankdrop.path.read.csv_file import parse_trajectory
from rankdrop.viewer.server import Viewer, Wishes
from rankdrop.viewer.tab_families import PACE

ARM = open_robot("pa10")
TASK = resolve_task(None, ARM)
ELBOW = np.array([0.1, 0.6, 0.3, 0.0, 0.4, 0.9, 0.2])


def smallest(q: Array, arm: Robot = ARM, task: Task = TASK) -> float:
    return float(singular_values(arm, q, task)[5])


@pytest.fixture(scope="module")
def viewer() -> Iterator[Viewer]:
    path = parse_trajectory("t,q1,q2,q3,q4,q5,q6,q7\n0,0,1,0,1,0,1,0\n1,0,1,0,-1,0,1,0\n", "over.csv", ARM)
    made = Viewer(ARM, TASK, Wishes(port=0, q=ELBOW, trajectory=path))
    until(lambda: not made.session.moving)
    yield made
    made.close()


@pytest.mark.slow
def test_a_path_plays_to_its_end_through_the_singularity(viewer: Viewer) -> None:
    assert viewer.path.trajectory is not None
    assert np.allclose(viewer.session.q, viewer.path.trajectory.q[0])
    seen: list[float] = []
    plain = viewer.stage.show

    def show(now: object) -> None:
        seen.append(float(now.q[3]))  # type: ignore[attr-defined]
        plain(now)  # type: ignore[arg-type]

    viewer.stage.show = show  # type: ignore[method-assign,assignment]
    viewer.path.ui.speed.value = 3.0
    viewer.path._play()
    until(lambda: bool(np.allclose(viewer.session.q, viewer.path.trajectory.q[-1])))
    assert min(seen) < 0 < max(seen)
    viewer.path._show_worst()
    until(lambda: not viewer.session.moving)


@pytest.mark.slow
def test_a_walk_goes_on_along_the_family_until_it_is_stopped(viewer: Viewer) -> None:
    viewer.session.set(ELBOW)
    tab = viewer._families
    assert tab.family.name.startswith("elbow")
    tab.ui.joint.value = tab.ui.joint.options[1]
    tab._go(1)
    until(lambda: viewer.session.q[1] > ELBOW[1] + 5 * PACE)
    viewer.session.stop()
    q = viewer.session.q
    assert smallest(q) <= 1e-9
    assert q[3] == pytest.approx(0.0, abs=1e-9)
    tab.ui.joint.value = tab.ui.joint.options[3]  # the elbow itself stands still
    tab._step(1)
    assert "stands still" in viewer.controls.message.content


@pytest.mark.slow
def test_the_end_effector_stays_where_it_is_on_a_self_motion_out(viewer: Viewer) -> None:
    start = np.array([0.3, 0.0, np.pi / 2, 0.8, 0.5, 0.7, 0.2])  # AM's shoulder singularity: avoidable
    viewer.session.set(start)
    out = viewer._escape._now()
    if out.still is None:
        pytest.skip("no self-motion leads out of this configuration")
    viewer._escape._keep_still()
    until(lambda: not viewer.session.moving)
    q = viewer.session.q
    assert np.abs(pose(ARM, q) - pose(ARM, start)).max() < 1e-8
    assert smallest(q) > 1e-4


@pytest.mark.slow
def test_a_slice_shows_points_on_the_families(viewer: Viewer) -> None:
    viewer.session.set(ELBOW + 0.2)
    viewer.slice.draw()
    told = viewer.slice.ui.text.content
    assert "starts arrived" in told
    assert "corank" in told
    viewer.slice.clear()


@pytest.mark.slow
def test_what_goes_wrong_behind_a_button_is_told(viewer: Viewer) -> None:
    def act() -> None:
        raise ValueError("<no>")

    viewer.controls.attempt(act)
    assert "&lt;no&gt;" in viewer.controls.message.content
    viewer.controls.attempt(lambda: None)
    assert viewer.controls.message.content == ""
