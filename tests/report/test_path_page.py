"""The page of a path stands alone, tells what was judged, and its slider and plots move the arm along the path."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser.chromium import Browser, find_chromium

from rankdrop.cli import main
from rankdrop.kinematics import pose
from rankdrop.path import PathCheck, check_path, check_poses
from rankdrop.report.path_page import path_page
from rankdrop.robot import open_robot

ARM = open_robot("ur5")
Q = np.array([[0.3, -1.2, 0.4, -1.0, 0.5, 0.4], [0.5, -1.0, -0.3, -1.2, 0.8, 0.4], [0.7, -0.9, 0.5, -1.1, 0.9, 0.1]])
T = [0.0, 2.0, 5.0]


@pytest.fixture(scope="module")
def found() -> PathCheck:
    """A path that crosses the elbow's singularity twice."""
    return check_path(ARM, Q, T, min_distance=0.05)


def told(page: str) -> dict[str, Any]:
    """The data of a page."""
    script = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    assert script is not None
    return dict(json.loads(script[1]))


@pytest.mark.slow
def test_the_page_stands_alone_and_says_the_verdict(found: PathCheck) -> None:
    page = path_page(found)
    assert not re.search(r"(?:src|href)=[\"'](?!data:|#)", page)
    assert "default-src 'none'" in page
    assert found.sentence in unescape(page)
    assert '<span class="badge bad">crossing</span>' in page


def test_singularities_have_one_name_on_the_page(found: PathCheck) -> None:
    """The sentence named the part of the arm, the buttons and the curves the family."""
    page = unescape(path_page(found))
    first, *_ = found.crossings
    assert "elbow: arm stretched" in found.sentence
    assert first.name not in page
    assert {one["name"] for one in told(page)["stretches"] if not one["free"]} == {"elbow: arm stretched"}


def test_its_numbers_are_those_of_the_path(found: PathCheck) -> None:
    data = told(path_page(found))
    assert data["x"] == sorted(data["x"])
    assert (data["x"][0], data["x"][-1]) == (0.0, 5.0)
    q = np.array(data["q"])
    wanted = np.stack([np.interp(data["x"], T, Q[:, j]) for j in range(6)], axis=1)
    assert np.abs(q - wanted).max() < 1e-5
    assert np.abs(np.array(data["tip"]) - pose(ARM, q)[:, :3, 3]).max() < 1e-5
    met = [one for one in data["stretches"] if not one["free"]]
    assert [one["verdict"] for one in met] == ["crossing", "crossing"]
    for one, stretch in zip(sorted(met, key=lambda one: one["start"]), found.crossings, strict=True):
        assert one["closest"] == pytest.approx(stretch.closest.place.time)
        nearest = int(np.abs(np.array(data["at"]) - one["closest"]).argmin())
        assert data["series"][0]["values"][nearest] < 1e-8
    assert data["min_distance"] == 0.05
    assert data["pose"] is None


def test_stretches_are_listed_with_a_time_where_they_have_one_and_free_ones_as_they_follow(found: PathCheck) -> None:
    buttons = re.findall(r'<button data-stretch="\d+">(.*?)</button>', path_page(found), re.DOTALL)
    when = [unescape(re.sub(r".*<br>|<[^>]*>", "", one)) for one in buttons]
    assert [one.startswith("at ") for one in when] == [True, True, False, False, False]
    starts = [float(one.split()[0]) for one in when[2:]]
    assert starts == sorted(starts)
    assert starts[0] == 0.0


@pytest.mark.slow
def test_poses_of_the_tip_are_counted(tmp_path: Path) -> None:
    free = check_poses(ARM, pose(ARM, [[0.3, -1.2, 1.4, -1, 1.2, 0.4], [0.6, -1, 1.2, -1.2, 1, 0.4]]),
                       start=[0.3, -1.2, 1.4, -1, 1.2, 0.4])  # fmt: skip
    data = told(path_page(free))
    assert (data["pose"][0], data["pose"][-1]) == (1.0, 2.0)
    assert not data["timed"]


def test_names_cannot_end_the_script() -> None:
    from dataclasses import replace

    data = path_page(check_path(replace(ARM, name="</script><b>"), Q[:1]))
    assert "</script><b>" not in data


@pytest.mark.slow
def test_the_command_writes_it_and_refuses_what_it_cannot(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    np.save("a.npy", Q)
    assert main.run(["path", "ur5", "a.npy", "--html", "a.html", "--quiet"]) == 3
    assert told((tmp_path / "a.html").read_text(encoding="utf-8"))["timed"] is False
    capsys.readouterr()
    assert main.run(["path", "ur5", "a.npy", "--html", "a.pdf", "--quiet"]) == 2
    assert "--html: the ending names no format" in capsys.readouterr().err
    assert main.run(["path", "ur5", "a.npy", "a.npy", "--html", "b.html", "--quiet"]) == 2
    assert "--html: this option is for one path" in capsys.readouterr().err


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """One browser for all tests of this file."""
    executable = find_chromium()
    if executable is None:
        pytest.skip("no Chromium is installed: apt-get install chromium")
    with Browser(executable) as one:
        yield one


@pytest.mark.by_hand_at("1024-False", "390-False", "390-True")
@pytest.mark.browser
@pytest.mark.parametrize(("width", "dark"), [(390, False), (390, True), (1024, False), (1024, True)])
def test_in_a_browser_the_slider_moves_the_arm(
    tmp_path: Path, found: PathCheck, browser: Browser, width: int, dark: bool
) -> None:
    (tmp_path / "a.html").write_text(path_page(found), encoding="utf-8")
    browser.requests.clear()
    browser.complaints.clear()
    browser.window(width, 844, dark=dark, phone=width < 500)
    browser.open(tmp_path / "a.html")
    assert browser.run("document.documentElement.scrollWidth <= innerWidth")
    picture = "document.getElementById('arm').toDataURL()"
    plot = "document.querySelector('#plots canvas').toDataURL()"
    before = browser.run(picture), browser.run(plot)
    browser.run("document.getElementById('at').value = 0.4")
    browser.run("document.getElementById('at').dispatchEvent(new Event('input')) && null")
    assert browser.run("rankdropPath.state.x") == pytest.approx(2.0)
    np.testing.assert_allclose(browser.run("rankdropPath.state.q"), Q[1], atol=1e-6)
    np.testing.assert_allclose(browser.run("rankdropPath.drawn()"), Q[1], atol=1e-6)
    assert browser.run("document.getElementById('place').textContent") == "2.000 of 5 s"
    assert browser.run("document.getElementById('verdict').textContent") == "free: proven"
    assert all(one != other for one, other in zip(before, (browser.run(picture), browser.run(plot)), strict=True))
    browser.run("document.querySelector('[data-stretch=\"0\"]').click()")
    assert browser.run("document.getElementById('verdict').textContent").startswith("crossing: elbow")
    browser.run("document.getElementById('play').click()")
    browser.receive(0.4)
    assert browser.run("rankdropPath.state.playing")
    assert browser.run("rankdropPath.state.x") > found.crossings[0].closest.place.time
    assert browser.complaints == []
    assert all(one.startswith("file:") for one in browser.requests)
