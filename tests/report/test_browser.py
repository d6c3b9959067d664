"""The page in a real browser: its kinematics are rankdrop's, sliders move the arm, arrows point where they should."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from browser.chromium import Browser, find_chromium

from rankdrop.kinematics import pose
from rankdrop.local.block import sample, singular_values
from rankdrop.report.content import arrows, content
from rankdrop.report.page import page
from rankdrop.results.known import shipped

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(find_chromium() is None, reason="no Chromium is installed: apt-get install chromium"),
]
ARMS = ["stanford", "pa10", "almarkhi4"]
LAPTOP, PHONE = (1280, 900), (390, 844)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """One browser for all tests of this file."""
    with Browser(find_chromium() or "") as one:
        yield one


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The reports of some arms, written once."""
    folder = tmp_path_factory.mktemp("pages")
    paths = {}
    for name in ARMS:
        paths[name] = folder / f"{name}.html"
        paths[name].write_text(page(content(shipped(name), exact=name == "stanford")), encoding="utf-8")
    return paths


@pytest.fixture(params=ARMS)
def name(request: pytest.FixtureRequest, browser: Browser, pages: dict[str, Path]) -> str:
    """An arm whose page is open."""
    browser.window(*LAPTOP)
    browser.requests.clear()
    browser.complaints.clear()
    browser.open(pages[request.param])
    return str(request.param)


def test_the_kinematics_of_the_page_are_those_of_rankdrop(name: str, browser: Browser) -> None:
    analysis = shipped(name)
    q = sample(analysis.robot, analysis.task, 20, 7)
    poses = browser.run(f"{q.tolist()}.map((q) => rankdropReport.pose(q))")
    assert np.abs(np.array(poses) - pose(analysis.robot, q)).max() < 1e-12
    sigma = browser.run(f"{q.tolist()}.map((q) => rankdropReport.singularValues(q))")
    assert np.abs(np.array(sigma) - singular_values(analysis.robot, q, analysis.task)).max() < 1e-12


def test_a_slider_moves_the_arm(name: str, browser: Browser) -> None:
    picture = "document.getElementById('arm').toDataURL()"
    before, q = browser.run(picture), browser.run("rankdropReport.state.q")
    moved = browser.run(
        "(() => { const s = document.getElementById('slider2'); s.value = 0.7;"
        "s.dispatchEvent(new Event('input')); return rankdropReport.state.q; })()"
    )
    assert moved == [q[0], 0.7, *q[2:]]
    assert browser.run(picture) != before
    assert "40.1°" in browser.run("document.getElementById('value2').textContent")


def test_arrows_point_where_the_numbers_say(name: str, browser: Browser) -> None:
    analysis = shipped(name)
    for family in analysis.families:
        browser.run(f"rankdropReport.goTo('{family.id}', false)")
        drawn = browser.run("rankdropReport.state.arrows.map((one) => [...one.v, ...one.w])")
        assert np.abs(np.array(drawn) - arrows(analysis, family)[1]).max() < 1e-12
        assert browser.run("document.getElementById('verdict').textContent").startswith("Singular")


def test_arrows_follow_the_arm_along_its_family(name: str, browser: Browser) -> None:
    """Turning joint 1 keeps the arm on its family and carries the arrows round with it."""
    family = shipped(name).families[0]
    turned = [0.8, *family.witness[1:]]
    browser.run(f"rankdropReport.goTo('{family.id}', false)")
    lost = browser.run(f"(rankdropReport.setQ({turned}), rankdropReport.state.arrows.map((a) => [...a.v, ...a.w]))")
    robot, angle = shipped(name).robot, 0.8 - family.witness[0]
    axis = robot.joints[0].screw[3:]
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    rotation = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    expected = (arrows(shipped(name), family)[1].reshape(-1, 2, 3) @ rotation.T).reshape(-1, 6)
    same = np.array(lost) @ expected.T
    assert np.abs(np.abs(same) - np.eye(family.corank)).max() < 1e-6


def test_away_from_the_family_the_page_says_regular(name: str, browser: Browser) -> None:
    analysis = shipped(name)
    q = sample(analysis.robot, analysis.task, 1, 11)[0].tolist()
    browser.run(f"rankdropReport.setQ({q})")
    assert "Regular" in browser.run("document.getElementById('verdict').textContent")
    assert browser.run("rankdropReport.state.arrows.every((one) => one.faint)")


def test_nothing_leaves_the_machine_and_nobody_complains(name: str, browser: Browser) -> None:
    browser.run("document.querySelectorAll('button[data-go]').forEach((one) => one.click())")
    browser.receive(0.3)
    assert browser.complaints == []
    assert browser.requests
    assert all(address.startswith(("file:", "data:")) for address in browser.requests)


@pytest.mark.parametrize("dark", [False, True])
def test_the_page_fits_a_phone(name: str, dark: bool, browser: Browser, pages: dict[str, Path]) -> None:
    browser.window(*PHONE, dark=dark, phone=True)
    browser.open(pages[name])
    assert browser.run("document.documentElement.scrollWidth") <= PHONE[0]
    paper = browser.run("getComputedStyle(document.body).backgroundColor")
    assert (paper == "rgb(255, 255, 255)") is not dark


def test_mathematics_is_drawn(browser: Browser, pages: dict[str, Path]) -> None:
    browser.window(*LAPTOP)
    browser.open(pages["stanford"])
    sizes = browser.run("[...document.querySelectorAll('math')].map((m) => m.getBoundingClientRect().width)")
    assert len(sizes) >= 6
    assert min(sizes) > 10


def test_the_set_in_three_joints_is_drawn(browser: Browser, pages: dict[str, Path]) -> None:
    browser.window(*LAPTOP)
    browser.open(pages["almarkhi4"])
    assert browser.run("rankdropReport.solids.length") == 1
    blank = "document.createElement('canvas').toDataURL()"
    assert browser.run(f"document.getElementById('solid1').toDataURL() !== {blank}")


def test_the_page_prints(browser: Browser, pages: dict[str, Path], tmp_path: Path) -> None:
    browser.window(*LAPTOP)
    browser.open(pages["stanford"])
    browser.pdf(tmp_path / "page.pdf")
    assert (tmp_path / "page.pdf").read_bytes().startswith(b"%PDF")
