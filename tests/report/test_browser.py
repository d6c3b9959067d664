"""The page in a real browser: its kinematics are rankdrop's, sliders move the arm, arrows point where they should."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from browser.axe import violations
from browser.chromium import Browser, find_chromium

from rankdrop.kinematics import pose
from rankdrop.local.block import sample, singular_values
from rankdrop.report.content import Content, content
from rankdrop.report.page import page
from rankdrop.results.known import shipped

from .lost import arrows

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
def contents() -> dict[str, Content]:
    """What the pages show."""
    return {name: content(shipped(name), exact=name == "stanford") for name in ARMS}


@pytest.fixture(scope="module")
def pages(contents: dict[str, Content], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The reports of some arms, written once."""
    folder = tmp_path_factory.mktemp("pages")
    paths = {}
    for name in ARMS:
        paths[name] = folder / f"{name}.html"
        paths[name].write_text(page(contents[name]), encoding="utf-8")
    return paths


@pytest.fixture(params=ARMS)
def name(request: pytest.FixtureRequest, browser: Browser, pages: dict[str, Path]) -> str:
    """An arm whose page is open."""
    browser.window(*LAPTOP)
    browser.requests.clear()
    browser.complaints.clear()
    browser.open(pages[request.param])
    return str(request.param)


@pytest.mark.spread(1)
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


def test_arrows_point_where_the_numbers_say(name: str, browser: Browser, contents: dict[str, Content]) -> None:
    analysis = contents[name].analysis
    for family in analysis.families:
        browser.run(f"rankdropReport.goTo('{family.id}', false)")
        drawn = browser.run("rankdropReport.state.arrows.map((one) => [...one.v, ...one.w])")
        assert np.abs(np.array(drawn) - arrows(analysis, family)[1]).max() < 1e-12
        assert browser.run("document.getElementById('verdict').textContent").startswith("Singular")


def test_arrows_follow_the_arm_along_its_family(name: str, browser: Browser, contents: dict[str, Content]) -> None:
    """Turning joint 1 keeps the arm on its family and carries the arrows round with it."""
    analysis = contents[name].analysis
    family = analysis.families[0]
    turned = [0.8, *family.witness[1:]]
    browser.run(f"rankdropReport.goTo('{family.id}', false)")
    lost = browser.run(f"(rankdropReport.setQ({turned}), rankdropReport.state.arrows.map((a) => [...a.v, ...a.w]))")
    robot, angle = analysis.robot, 0.8 - family.witness[0]
    axis = robot.joints[0].screw[3:]
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    rotation = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    expected = (arrows(analysis, family)[1].reshape(-1, 2, 3) @ rotation.T).reshape(-1, 6)
    same = np.array(lost) @ expected.T
    assert np.abs(np.abs(same) - np.eye(family.corank)).max() < 1e-6


def test_the_arm_fills_its_picture_and_words_stand_apart(
    name: str, browser: Browser, contents: dict[str, Content]
) -> None:
    for family in contents[name].analysis.families:
        browser.run(f"rankdropReport.goTo('{family.id}', false)")
        large = browser.run("rankdropReport.drawn()")[0]
        assert max(large["shares"]) >= 0.6, family.id
        for (x, y, w, h), (x2, y2, w2, h2) in combinations(large["words"], 2):
            assert abs(x - x2) >= w + w2 - 0.01 or abs(y - y2) >= h + h2 - 0.01, family.id
        for x, y, w, h in large["words"]:
            assert w - 1 <= x <= large["width"] - w + 1
            assert h - 1 <= y <= large["height"] - h + 1
    assert all(max(small["shares"]) >= 0.6 for small in browser.run("rankdropReport.drawn()")[1:])


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
    assert len(re.findall(rb"/Type\s*/Page[^s]", (tmp_path / "page.pdf").read_bytes())) <= 12


@pytest.mark.parametrize(("width", "dark"), [(390, False), (1024, True), (1440, False)])
@pytest.mark.slow
def test_axe_finds_nothing(width: int, dark: bool, browser: Browser, pages: dict[str, Path]) -> None:
    browser.window(width, 900, dark=dark, phone=width < 500)
    browser.open(pages["stanford"])
    assert violations(browser) == []
    assert browser.run("document.documentElement.scrollWidth") <= width


@pytest.mark.slow
def test_axe_would_find_a_picture_without_words(browser: Browser, pages: dict[str, Path]) -> None:
    browser.open(pages["stanford"])
    browser.run("document.getElementById('arm').removeAttribute('aria-label')")
    assert any("role-img-alt" in one for one in violations(browser))


@pytest.mark.slow
def test_only_tables_that_are_too_wide_say_so(browser: Browser, pages: dict[str, Path]) -> None:
    seen = "[...document.querySelectorAll('.swipe')].filter((one) => one.offsetHeight > 0).length"
    for (width, height), many in ((PHONE, True), ((1440, 900), False)):
        browser.window(width, height, phone=many)
        browser.open(pages["stanford"])
        assert (browser.run(seen) > 0) is many


@pytest.mark.parametrize("size", [PHONE, LAPTOP])
def test_a_link_of_the_bar_leads_to_a_heading_that_is_seen(
    size: tuple[int, int], browser: Browser, pages: dict[str, Path]
) -> None:
    browser.window(*size, phone=size == PHONE)
    browser.open(pages["stanford"])
    browser.run("document.documentElement.style.scrollBehavior = 'auto'")
    places = "['nav', '#slices h2'].map((one) => document.querySelector(one).getBoundingClientRect())"
    browser.run("document.querySelector('nav a[href=\"#slices\"]').click()")
    bar, heading = browser.run(f"{places}.map((r) => [r.top, r.bottom])")
    assert bar[0] == 0  # it stays
    assert bar[1] <= heading[0] < size[1] / 2


@pytest.mark.slow
def test_sliders_end_at_the_joint_limits_until_told_otherwise(browser: Browser, pages: dict[str, Path]) -> None:
    browser.window(*LAPTOP)
    browser.open(pages["stanford"])
    joint = shipped("stanford").robot.variables[1]
    ends = "[Number(slider2.min), Number(slider2.max)]"
    assert browser.run(ends) == pytest.approx([joint.lower, joint.upper])
    browser.run("document.getElementById('limits').click()")
    assert browser.run(ends) == pytest.approx([-np.pi, np.pi], abs=1e-5)


@pytest.mark.slow
def test_a_button_leads_out(name: str, browser: Browser, contents: dict[str, Content]) -> None:
    shown = contents[name]
    index = next(i for i, ways in enumerate(shown.ways) if ways)
    browser.run(f"rankdropReport.goTo('{shown.analysis.families[index].id}', false)")
    browser.run("document.querySelector('#ways button').click()")
    assert browser.run("rankdropReport.state.q") == pytest.approx(list(shown.ways[index][0][2]))
    assert "Regular" in browser.run("document.getElementById('verdict').textContent")
    assert browser.run("document.querySelectorAll('#ways button').length") == 0


@pytest.mark.slow
def test_what_is_downloaded_is_what_the_page_holds(browser: Browser, pages: dict[str, Path]) -> None:
    browser.window(*LAPTOP)
    browser.open(pages["stanford"])
    browser.run(
        "(() => { window.kept = []; const made = URL.createObjectURL;"
        "URL.createObjectURL = (blob) => { window.kept.push(blob); return made(blob); };"
        "HTMLAnchorElement.prototype.click = () => {};"
        "for (const id of ['save-csv', 'save-json']) document.getElementById(id).click();"
        "document.querySelector('.figure-save').click(); })()"
    )
    csv, record, figure = browser.run("Promise.all(window.kept.map((blob) => blob.text()))")
    assert csv.lstrip("\ufeff").startswith("id,family,corank,dimension,")
    assert json.loads(record)["families"][0]["id"] == "k1.f1"
    assert figure.startswith("<svg")
    assert "var(--" not in figure


@pytest.mark.slow
def test_pictures_on_paper_are_not_wider_than_their_columns(browser: Browser, pages: dict[str, Path]) -> None:
    browser.window(700, 900)
    browser.open(pages["almarkhi4"])
    wide = "Math.max(...[...document.querySelectorAll('canvas')].map((one) => one.width / one.height))"
    before = browser.run(wide)
    browser.run("dispatchEvent(new Event('beforeprint'))")
    assert browser.run(wide) <= 1.26 < before
    browser.run("dispatchEvent(new Event('afterprint'))")
    assert browser.run(wide) == before


def test_print_keeps_ids_legends_and_bars(browser: Browser, pages: dict[str, Path]) -> None:
    browser.window(*LAPTOP)
    browser.open(pages["stanford"])
    browser.send("Emulation.setEmulatedMedia", media="print")
    seen = "(s) => [...document.querySelectorAll(s)].filter((one) => one.getClientRects().length > 0).length"
    for kept in (".scroll button", ".stage .key", "#sigma i", ".card h4"):
        assert browser.run(f"({seen})('{kept}')") > 0, kept
    for gone in (".screen", "#ways", ".sliders", "nav", ".card button"):
        assert browser.run(f"({seen})('{gone}')") == 0, gone
    assert "Drag" not in browser.run("document.body.innerText")
    browser.send("Emulation.setEmulatedMedia", media="")
