"""Pictures of aspects: which joints, which regions, and what stands where."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from rankdrop.aspects import aspect_maps, aspects_of, count_of_arm
from rankdrop.cli.main import run
from rankdrop.kinematics import task_jacobian
from rankdrop.report.aspects_figure import aspects_figure
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

FigureCanvasAgg = pytest.importorskip("matplotlib.backends.backend_agg").FigureCanvasAgg


def orthogonal() -> Robot:
    """A 3R arm at right angles: det J depends on joints 2 and 3, and one sign has two regions."""
    rows = [(0, 1.0, -np.pi / 2), (1.0, 2.0, np.pi / 2), (0, 1.5, 0)]
    table = [{"d": d, "a": a, "alpha": alpha} for d, a, alpha in rows]
    return from_dh(table, convention="standard", task="position", name="orthogonal")


def test_the_regions_of_two_joints_are_those_of_the_sign_of_det_j() -> None:
    arm = orthogonal()
    task = resolve_task(None, arm)
    count, signs = count_of_arm(arm, task)
    (shown,) = aspect_maps(count, signs)
    assert shown.joints == (2, 3)
    assert shown.slices == shown.held == ()
    assert len(shown.regions) == count.at_least
    size = len(shown.cells)
    middles = -np.pi + (np.arange(size) + 0.5) * 2 * np.pi / size
    at = np.random.default_rng(1).integers(size, size=(200, 2))
    q = np.stack([np.zeros(200), middles[at[:, 0]], middles[at[:, 1]]], axis=1)
    det = np.linalg.det(task_jacobian(arm, q, task))
    sign = np.array([np.prod(one.signs) for one in shown.regions])[shown.cells[at[:, 0], at[:, 1]]]
    clear = np.abs(det) > 1e-6
    assert abs(int((np.sign(det) * sign)[clear].sum())) == clear.sum()


def test_regions_of_one_sign_that_do_not_touch_have_colours_of_their_own() -> None:
    """A 3R arm with two regions of each sign of det J."""
    rows = [(0, 0.71, -np.pi / 2), (0.42, 0.23, np.pi / 2), (0.21, 0.85, 0)]
    table = [{"d": d, "a": a, "alpha": alpha} for d, a, alpha in rows]
    arm = from_dh(table, convention="standard", task="position", name="apart")
    (shown,) = aspect_maps(*count_of_arm(arm, resolve_task(None, arm)))
    assert [(one.signs, one.number, one.parts) for one in shown.regions] == [
        ((sign,), number, 1) for sign in (1, -1) for number in (1, 2)
    ]
    assert sorted(np.unique(shown.cells)) == [0, 1, 2, 3]


def test_every_sign_vector_of_three_joints_has_a_region_in_slices() -> None:
    arm = open_robot("ur5e")
    strip, sliced = aspect_maps(*count_of_arm(arm, resolve_task(None, arm)))
    assert (strip.joints, len(strip.regions)) == ((5,), 2)
    assert (sliced.joints, len(sliced.regions), sliced.cells.shape[0]) == ((2, 3, 4), 4, len(sliced.slices))
    assert [one.parts for one in sliced.regions] == [1, 1, 1, 1]


@pytest.mark.slow
def test_nothing_stands_on_another_text_and_the_legend_beside_the_maps() -> None:
    drawn = aspects_figure(aspects_of(open_robot("ur5e"), poses=1, most=1, starts=50))
    FigureCanvasAgg(drawn).draw()
    axes = [one for row in drawn.subfigs for one in row.axes if one.axison]
    texts = [label for one in axes for label in (*one.get_xticklabels(), *one.get_yticklabels(), one.xaxis.label)]
    boxes = [one.get_window_extent() for one in texts if one.get_text()]
    assert len(boxes) > 15
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    (last,) = [one for one in axes if one.get_title() == "θ4 = 135°"]
    legend = last.get_legend()
    assert legend.get_window_extent().x0 >= last.get_window_extent().x1
    assert [text.get_text() for text in legend.get_texts()] == [
        f"elbow {a}, shoulder {b}: 1 region" for a in "+−" for b in "+−"
    ]


@pytest.mark.slow
def test_the_command_writes_the_picture_or_says_why_not(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["aspects", "planar2r", "--poses", "1", "--figure", str(tmp_path / "a.svg"), "--quiet"]) == 0
    assert "elbow" in (tmp_path / "a.svg").read_text(encoding="utf-8")
    assert run(["aspects", "almarkhi4", "--figure", str(tmp_path / "b.png"), "--quiet"]) == 3
    assert not (tmp_path / "b.png").exists()
    assert "there is nothing to draw" in capsys.readouterr().err
