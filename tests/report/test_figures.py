"""Figures for papers: each one drawn, the same every time, and refused before the work where it cannot be."""

from __future__ import annotations

import sys
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rankdrop.cli import main
from rankdrop.errors import MissingExtraError, OptionError
from rankdrop.families.pictured import upright
from rankdrop.kinematics import jacobian, pose
from rankdrop.local import drawn_at
from rankdrop.report.chart import angle_ticks, axis_name
from rankdrop.report.content import Content, content
from rankdrop.report.figures import (
    _HALF,
    arm_figure,
    check_figures,
    figure_names,
    figures,
    slice_figure,
    spread_out,
    workspace_figure,
)
from rankdrop.results.known import shipped
from rankdrop.robot import reach
from rankdrop.task import SPACE

pytest.importorskip("matplotlib")

HEAD = {"pdf": b"%PDF", "png": b"\x89PNG", "svg": b"<?xml"}


@pytest.fixture(scope="module")
def shown() -> Content:
    return content(shipped("scara"), exact=False)


@pytest.mark.by_hand_at("pdf", "svg")
@pytest.mark.slow_at("pdf", "svg", "png")
@pytest.mark.parametrize("format", ["pdf", "png", "svg"])
def test_every_figure_is_a_file_of_its_format(shown: Content, format: str) -> None:
    drawn = dict(figures(shown, figure_names(shown), format))
    assert set(drawn) == {"arm-k1.f1", "slice-k1.f1", "workspace", "image-k1.f1", "lines-k1.f1"}
    assert all(data.startswith(HEAD[format]) for data in drawn.values())


@pytest.mark.by_hand_at("pdf")
@pytest.mark.slow
@pytest.mark.slow_at("pdf")
@pytest.mark.parametrize("format", ["pdf", "svg"])
def test_the_same_figure_is_the_same_file(shown: Content, format: str) -> None:
    first, again = (dict(figures(shown, ["arm-k1.f1"], format)) for _ in range(2))
    assert first == again


def test_the_drawn_arm_ends_at_its_tip() -> None:
    for name in ("pa10", "stanford", "fetch8"):
        robot = shipped(name).robot
        q = np.linspace(-0.5, 0.9, robot.n)
        drawn = drawn_at(robot, q)
        assert np.allclose(drawn.links[-1], pose(robot, q)[:3, 3])
        places = spread_out(drawn, 0.1)
        for screw, axis, slides, *at in zip(
            jacobian(robot, q, SPACE).T, drawn.axes, drawn.slides, drawn.middles, places, strict=True
        ):
            assert np.allclose(axis, screw[:3] if slides else screw[3:])
            assert slides or all(np.allclose(np.cross(place, axis), screw[:3], atol=1e-12) for place in at)


def test_joints_whose_axes_meet_are_drawn_apart() -> None:
    robot = shipped("pa10").robot
    drawn = drawn_at(robot, np.zeros(7))
    assert np.allclose(drawn.middles[0], drawn.middles[1])
    places = spread_out(drawn, 0.1)
    assert min(np.linalg.norm(a - b) for a, b in pairwise(places)) > 0.04


def test_figures_are_chosen_by_kind_or_by_name(shown: Content) -> None:
    assert figure_names(shown, ["lines", "workspace"]) == ["workspace", "lines-k1.f1"]
    with pytest.raises(OptionError, match="no such figure"):
        figure_names(shown, ["solid"])


def test_what_no_arm_has_is_refused_at_once(shown: Content) -> None:
    with pytest.raises(OptionError, match="no such figure"):
        check_figures(shown.analysis, ["ellipse"])
    with pytest.raises(OptionError, match="no such figure"):
        check_figures(shown.analysis, ["arm-k9.f9"])


def test_without_matplotlib_the_extra_is_named(shown: Content, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(MissingExtraError, match=r"s source: pip install \.$"):
        check_figures(shown.analysis, [])


@pytest.mark.slow
def test_the_command_writes_a_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "scara.html"
    assert main.run(["report", "scara", "--out", str(target)]) == 0
    assert target.read_text(encoding="utf-8").startswith("<!doctype html>")
    assert "wrote" in capsys.readouterr().err
    assert main.run(["report", "scara", "--out", str(target), "--quiet"]) == 0
    assert capsys.readouterr().err == ""


def test_the_command_reads_an_analysis(tmp_path: Path) -> None:
    saved = tmp_path / "planar.json"
    shipped("planar2r").save(saved)
    assert main.run(["report", str(saved), "--out", str(tmp_path / "p.html"), "--exact-seconds", "0"]) == 0
    assert "planar2r" in (tmp_path / "p.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_command_writes_figures_into_a_folder(tmp_path: Path) -> None:
    folder = tmp_path / "figures"
    options = ["--format", "svg", "--figure", "lines", "--figure", "slice", "--out", str(folder)]
    assert main.run(["report", "planar2r", *options]) == 0
    assert sorted(path.name for path in folder.iterdir()) == ["lines-k1.f1.svg", "slice-k1.f1.svg"]


def test_angles_are_shown_in_degrees_and_legends_outside_the_data(shown: Content) -> None:
    assert angle_ticks(-3.3, 3.3) == [(k * np.pi / 2, f"{90 * k}°".replace("-", "−")) for k in range(-2, 3)]
    assert [word for _, word in angle_ticks(0.0, 0.2)][:3] == ["0°", "2°", "4°"]
    assert (axis_name("θ2", "rad"), axis_name("q3", "m")) == ("θ2", "q3 [m]")
    plane = slice_figure(shown.analysis.robot, shown.slices[0], shown.colours, shown.labels)
    for drawn in (plane, workspace_figure(shown.workspace)):
        axes = drawn.axes[0]
        drawn.canvas.draw()
        assert axes.get_legend().get_window_extent().x0 >= axes.get_window_extent().x1
    told = plane.axes[0].get_legend().get_texts()
    families = [trace.family for trace in shown.slices[0].traces]
    assert [one.get_text().replace("\n", " ") for one in told] == [f"{id} {shown.labels[id]}" for id in families]


@pytest.mark.slow
def test_numbers_of_short_edges_do_not_stand_on_each_other() -> None:
    """A stretched arm is a narrow box: numbers at its two short edges stood on the names of the axes."""
    found = shipped("crx10ial")
    family = next(one for one in found.families if one.id == "k2.f1")
    drawn = arm_figure(found, upright(found.robot, found.task, family, found.families))
    drawn.canvas.draw()
    axes: Any = drawn.axes[0]
    edges = (axes.xaxis, axes.yaxis, axes.zaxis)
    words = [one for edge in edges for one in (edge.label, *edge.get_ticklabels()) if one.get_text()]
    boxes = [one.get_window_extent() for one in (*words, *(one for one in drawn.texts if one.get_text().isdigit()))]
    assert len(words) >= 6
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "place"),
    [("pa10", 1), ("pa10", 3), ("crx10ial", 1), ("yumi", 2), ("ur5e", 3)],
)
def test_an_arm_fills_its_figure_and_no_numbers_stand_on_each_other(name: str, place: int) -> None:
    from mpl_toolkits.mplot3d import proj3d

    found = shipped(name)
    family = upright(found.robot, found.task, found.families[place], found.families)
    drawn = arm_figure(found, family, range(1, found.robot.n + 1))
    drawn.canvas.draw()
    axes: Any = drawn.axes[0]
    arm = drawn_at(found.robot, np.array(family.witness))
    middles, half = spread_out(arm, 0.11 * reach(found.robot)), _HALF * reach(found.robot) * arm.axes
    links = proj3d.proj_transform(*np.vstack([arm.links, middles - half, middles + half]).T, axes.get_proj())[:2]
    flat = axes.transData.transform(np.stack(links, axis=1))
    whole = drawn.get_tightbbox().size * drawn.dpi
    assert (np.ptp(flat, axis=0) / whole).max() >= 0.6
    numbers = [one for one in drawn.texts if one.get_text().isdigit()]
    assert len(numbers) == len(found.robot.joints)
    edges = (axes.xaxis, axes.yaxis, axes.zaxis)
    words = [one for edge in edges for one in (edge.label, *edge.get_ticklabels()) if one.get_text()]
    boxes = [one.get_window_extent() for one in numbers]
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    assert not any(a.overlaps(word.get_window_extent()) for a in boxes for word in words)
    lines = [*pairwise(arm.links), *zip(middles - 1.5 * half, middles + 1.5 * half, strict=True)]
    drawn_over = np.vstack([start + np.linspace(0.0, 1.0, 60)[:, None] * (end - start) for start, end in lines])
    dots = axes.transData.transform(np.stack(proj3d.proj_transform(*drawn_over.T, axes.get_proj())[:2], axis=1))
    assert not any(box.count_contains(dots) for box in boxes)  # none is on a link, a body or an axis
    names = [edge.label.get_window_extent() for edge in edges if edge.label.get_text()]
    assert not any(box.count_contains(dots) for box in names)
    (title,) = (one for one in drawn.texts if one not in numbers)
    assert flat[:, 1].max() <= axes.bbox.y1  # nothing is cut off, and the title stands above
    assert title.get_window_extent().y0 >= flat[:, 1].max()
    assert title.get_text().split(": ")[1].split()[0].rstrip(",") in {"shoulder", "elbow", "wrist"}
