"""Charts: data at its place, ticks at round numbers, curves cut where they leave the cube, maps as images."""

from __future__ import annotations

import re
import struct
import zlib
from base64 import b64decode
from math import degrees, pi
from types import SimpleNamespace

import numpy as np
import pytest

from rankdrop.report.chart import (
    COLOURS,
    LOOKS,
    Chart,
    angle_ticks,
    axis_name,
    look_of,
    pieces,
    plain_ticks,
    slice_chart,
    sweep_chart,
)
from rankdrop.robot.open import open_robot

ARM = open_robot("planar3r")


def test_the_corners_of_the_data_are_the_corners_of_the_plot() -> None:
    chart = Chart((-1.0, 3.0), (10.0, 20.0), size=(200, 100), margins=(40, 30, 5, 7))
    corners = chart.place(np.array([[-1.0, 10.0], [3.0, 20.0], [1.0, 15.0]]))
    np.testing.assert_allclose(corners, [[40.0, 105.0], [240.0, 5.0], [140.0, 55.0]])  # y grows downwards in SVG


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (-0.3, 0.7), (12.0, 4711.0), (-1e-3, 2e-3)])
def test_ticks_are_round_evenly_spaced_and_inside(low: float, high: float) -> None:
    values = [value for value, _ in plain_ticks(low, high)]
    assert low <= values[0]
    assert values[-1] <= high
    steps = np.diff(values)
    np.testing.assert_allclose(steps, steps[0])
    digit = steps[0] / 10.0 ** np.floor(np.log10(steps[0]) + 1e-9)
    assert any(digit == pytest.approx(round_number) for round_number in (1, 2, 5, 10))
    assert 3 <= len(values) <= 11
    assert [float(word.replace("−", "-")) for _, word in plain_ticks(low, high)] == pytest.approx(values)


@pytest.mark.parametrize(("low", "high"), [(-pi, pi), (-0.5, 0.5), (0.0, 3 * pi)])
def test_ticks_of_angles_are_in_degrees(low: float, high: float) -> None:
    ticks = angle_ticks(low, high)
    assert len(ticks) >= 3
    for value, word in ticks:
        assert low - 1e-9 <= value <= high + 1e-9
        assert float(word.removesuffix("°").replace("−", "-")) == pytest.approx(degrees(value))
    if high - low >= pi:
        assert {round(degrees(value)) % 90 for value, _ in ticks} == {0}


def test_angles_have_their_unit_at_the_ticks_and_lengths_at_the_axis() -> None:
    assert (axis_name("θ2", "rad"), axis_name("d3", "m")) == ("θ2", "d3 [m]")


def test_families_beyond_the_colours_begin_anew() -> None:
    looks = [look_of(index) for index in range(2 * len(COLOURS))]
    assert looks[: len(COLOURS)] == looks[len(COLOURS) :]
    assert [LOOKS[look][0] for look in looks[: len(COLOURS)]] == list(COLOURS)


def test_a_curve_past_half_a_turn_comes_back_on_the_other_side() -> None:
    line = np.stack([np.linspace(2.0, 5.0, 61), np.linspace(0.0, 0.6, 61)], axis=1)
    first, second = pieces(line)
    assert len(first) + len(second) == 61
    assert np.abs(np.concatenate([first, second])).max() <= pi
    assert first[-1, 0] > 3.0
    assert second[0, 0] < -3.0
    np.testing.assert_allclose(np.diff(first, axis=0), np.diff(line[: len(first)], axis=0), atol=1e-12)


def test_vertices_on_a_straight_line_are_left_out_and_corners_are_not() -> None:
    straight = np.stack([np.linspace(0, 1, 101), np.linspace(0, 1, 101)], axis=1)
    corner = np.concatenate([straight, [[1.0, 0.0]]])
    svg = Chart((0, 1), (0, 1), [([corner], "s1", 0.0, "")], margins=(0, 0, 0, 0), size=(100, 100)).svg("a curve")
    (path,) = re.findall(r'<path class="s1" d="([^"]*)"', svg)
    assert path == "M0 100L100 0L100 100"


def test_a_curve_of_many_vertices_is_drawn_by_fewer_at_the_same_place() -> None:
    angle = np.linspace(0.0, 1.5 * pi, 5001)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    svg = Chart((-1, 1), (-1, 1), [([circle], "s1", 0.0, "")], margins=(0, 0, 0, 0), size=(200, 200)).svg("a circle")
    (path,) = re.findall(r'<path class="s1" d="M([^"]*)"', svg)
    drawn = np.array([point.split() for point in path.split("L")], dtype=float) - 100.0
    assert 20 < len(drawn) < 500
    middles = (drawn[1:] + drawn[:-1]) / 2
    np.testing.assert_allclose(np.linalg.norm(np.concatenate([drawn, middles]), axis=1), 100.0, atol=0.5)


def test_dots_are_all_drawn_and_what_is_seen_is_escaped() -> None:
    marks = [([np.array([[0.0, 0.0], [0.5, 0.5]])], "f3", 4.0, "")]
    svg = Chart((0, 1), (0, 1), marks, names=("a < b", ""), margins=(0, 0, 0, 0), size=(100, 100)).svg('<"σ">')
    assert 'd="M0 100h0M50 50h0"' in svg
    assert "stroke:var(--f3)" in svg
    assert 'aria-label="&lt;&quot;σ&quot;&gt;"' in svg
    assert ">a &lt; b</text>" in svg


def opacity(svg: str) -> np.ndarray:
    """(rows, columns) opacity of the image in an SVG, read from its PNG."""
    data = b64decode(re.findall(r"base64,([^\"]+)", svg)[0])
    chunks, at = {}, 8
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        assert struct.unpack(">I", data[at + 8 + length : at + 12 + length]) == (zlib.crc32(kind + body),)
        chunks[kind] = body
        at += 12 + length
    width, height = struct.unpack(">II", chunks[b"IHDR"][:8])
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), dtype=np.uint8).reshape(height, 1 + 2 * width)
    assert (rows[:, 0] == 0).all()
    return rows[:, 2::2]


def test_a_map_is_an_image_whose_first_index_goes_right_and_second_up() -> None:
    image = np.array([[0.0, 0.2], [0.4, 0.6], [0.8, 1.0]])
    np.testing.assert_array_equal(opacity(Chart((0, 1), (0, 1), image=image).svg("a map")),
                                  np.round(255 * np.array([[0.2, 0.6, 1.0], [0.0, 0.4, 0.8]])))  # fmt: skip


def test_a_slice_is_dark_where_sigma_is_small_and_has_the_colours_of_its_families() -> None:
    sigma = np.ones((5, 5))
    sigma[2, 2] = 0.0
    curve, dot = np.array([[0.0, 0.0], [1.0, 1.0]]), np.array([[0.5, 0.5]])
    traces = [SimpleNamespace(family="k1.f2", curves=[curve], points=np.empty((0, 2))),
              SimpleNamespace(family="k1.f1", curves=[], points=dot)]  # fmt: skip
    plane = SimpleNamespace(joints=(1, 2), x=np.linspace(-1, 1, 5), y=np.linspace(-2, 2, 5), sigma=sigma, traces=traces)
    chart = slice_chart(ARM, plane, {"k1.f1": 0, "k1.f2": 1}, {"k1.f1": "elbow", "k1.f2": "wrist"})  # type: ignore[arg-type]
    assert (chart.x, chart.y) == ((-1.0, 1.0), (-2.0, 2.0))
    assert chart.image is not None
    assert np.unravel_index(chart.image.argmax(), chart.image.shape) == (1, 1)
    assert [(look, radius, label) for _, look, radius, label in chart.marks if label] == [
        ("f2", 0.0, "k1.f2 wrist"), ("f1", 4.0, "k1.f1 elbow"),
    ]  # fmt: skip


def test_a_sweep_draws_what_is_lost_in_bold_and_above_the_rest() -> None:
    values = np.linspace(-pi, pi, 9)
    sigma = np.stack([2.0 + 0 * values, 1.0 + 0 * values, np.abs(np.sin(values))], axis=1)
    sweep = SimpleNamespace(values=values, sigma=sigma, number=2, at=0.0)
    chart = sweep_chart(ARM, sweep, 1)  # type: ignore[arg-type]
    assert [look for _, look, _, _ in chart.marks] == ["s1", "s0"]
    (lines, *_) = chart.marks[-1]
    np.testing.assert_array_equal(lines[0], np.stack([values, sigma[:, 2]], axis=1))
    assert chart.at == 0.0
    assert chart.y[1] >= 1.0
    assert 'class="here"' in chart.svg("σ")


def test_a_chart_is_drawn_by_matplotlib_with_its_ranges_and_legend() -> None:
    pytest.importorskip("matplotlib")
    from matplotlib.figure import Figure

    axes = Figure().subplots()
    line = np.array([[0.0, 0.0], [1.0, 2.0]])
    Chart((0.0, 1.0), (0.0, 2.0), [([line], "f1", 0.0, "elbow"), ([line], "pass", 0.9, "")], ("a", "b"),
          ticks=([(0.5, "half")], []), title="title").draw(axes)  # fmt: skip
    assert (axes.get_xlim(), axes.get_ylim()) == ((0.0, 1.0), (0.0, 2.0))
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["elbow"]
    assert [tick.get_text() for tick in axes.get_xticklabels()] == ["half"]
    assert axes.lines[0].get_color() == COLOURS[0]
    assert axes.lines[1].get_linestyle() == "None"
