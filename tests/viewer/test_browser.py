"""The page in a real browser: it draws, it obeys, it complains of nothing, and it asks nothing of other machines."""

from __future__ import annotations

import base64
import re
import shutil
from collections.abc import Callable, Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Event, Thread
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest
from browser.axe import FAINT, axe_program

from rankdrop.local.block import singular_values
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

pytest.importorskip("viser", reason="viser and trimesh are not installed")
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
pytestmark = [
    pytest.mark.browser,
    pytest.mark.slow,  # a minute or two where the browser has to draw by software
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed"),
]

from rankdrop.viewer import session  # noqa: E402  # needs viser
from rankdrop.viewer.server import Viewer, Wishes  # noqa: E402  # needs viser

FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
         "--ignore-gpu-blocklist", "--disable-dev-shm-usage"]  # fmt: skip
WRIST = [0.3, 0.5, 0.4, 0.2, 0.0, 0.6]
LAPTOP, PHONE = (1280, 800), (390, 844)
PATIENCE = 180_000  # ms
ASKED = """for (const name of ['drawElements', 'drawArrays', 'drawElementsInstanced', 'drawArraysInstanced']) {
    const draw = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function (...all) { if (window.drawing) draw.apply(this, all); };
}"""
"""The scene is drawn where a test looks at it: by software, sixty pictures a second keep a processor busy."""
ALONE = "* {visibility: hidden !important} canvas {visibility: visible !important}"


class Tab:
    """A page of the viewer, and all that it said and asked for."""

    def __init__(self, browser: Any, url: str, size: tuple[int, int]) -> None:
        self.page = browser.new_page(viewport={"width": size[0], "height": size[1]})
        self.page.add_init_script(ASKED)
        self.page.set_default_timeout(PATIENCE)  # a busy machine draws by software for longer than the usual 30 s
        self.asked: list[str] = []
        self.said: list[str] = []
        self.page.on("request", lambda one: self.asked.append(one.url))
        self.page.on("websocket", lambda one: self.asked.append(one.url))
        self.page.on("console", lambda one: self.said.append(one.text) if one.type == "error" else None)
        self.page.on("pageerror", lambda one: self.said.append(str(one)))
        self.page.goto(url)

    def until(self, holds: Callable[[], bool], seconds: float = 180.0) -> None:
        """Let the page work until something holds."""
        for _ in range(int(10 * seconds)):
            if holds():
                return
            self.page.wait_for_timeout(100)
        pytest.fail("it never came true")

    def draw(self, drawing: bool = True) -> None:
        """Whether the scene is drawn from now on."""
        self.page.evaluate(f"window.drawing = {str(drawing).lower()}")

    def picture(self) -> bytes:
        """A PNG of the scene alone, by the protocol: `page.screenshot` waits too long on a busy machine."""
        hidden = self.page.add_style_tag(content=ALONE)
        session = self.page.context.new_cdp_session(self.page)
        shot = session.send("Page.captureScreenshot", {"format": "png"})["data"]
        session.detach()
        hidden.evaluate("style => style.remove()")
        return base64.b64decode(shot)

    def still(self) -> bytes:
        """A picture of the scene that does not change by itself: it fades in, and is drawn slowly by software."""
        shown = [self.picture()]

        for _ in range(60):
            self.page.wait_for_timeout(1000)
            shown.append(self.picture())
            if shown[-1] == shown[-2]:
                return shown[-1]
        pytest.fail("the scene is never still")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright (extra browser) is not installed")
    with playwright.sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield started
        started.close()


def opened(browser: Any, size: tuple[int, int], *, dark: bool = False) -> Iterator[tuple[Viewer, Tab]]:
    arm = open_robot("puma560")
    viewer = Viewer(arm, resolve_task(None, arm), Wishes(port=0, dark=dark, q=np.array(WRIST)))
    tab = Tab(browser, viewer.url, size)
    try:
        tab.until(lambda: len(viewer.server.get_clients()) == 1)
        tab.until(lambda: viewer.controls.found is not None)
        yield viewer, tab
        assert tab.said == []
        machines = {urlsplit(url.removeprefix("blob:")).hostname for url in tab.asked}
        assert machines == {"127.0.0.1"}
    finally:
        tab.page.close()
        viewer.close()


@pytest.fixture(scope="module")
def laptop(browser: Any) -> Iterator[tuple[Viewer, Tab]]:
    yield from opened(browser, LAPTOP)


def test_the_page_says_what_the_numbers_say(laptop: tuple[Viewer, Tab]) -> None:
    _, tab = laptop
    tab.page.get_by_text("■ singular").first.wait_for(timeout=PATIENCE)
    tab.page.get_by_text("wrist: joint 5 at 0°").first.wait_for(timeout=PATIENCE)
    assert tab.page.get_by_text("joints 4, 6").count() >= 1


@pytest.mark.spread(1)
@pytest.mark.parametrize("dark", [False, True])
def test_axe_finds_nothing_at_any_width(dark: bool, browser: Any) -> None:
    program = axe_program()
    for viewer, tab in opened(browser, LAPTOP, dark=dark):
        for width in (1440,) if dark else (390, 1440):
            tab.page.set_viewport_size({"width": width, "height": 900})
            tab.page.get_by_text("singular").first.wait_for(timeout=PATIENCE)
            tab.page.wait_for_timeout(1500)
            tab.page.evaluate(program)
            rules = "{runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa']}"
            names = "(r) => r.violations.map((v) => [v.id, v.nodes.length, v.nodes[0].html.slice(0, 200)])"
            found = tab.page.evaluate(f"axe.run(document, {rules}).then({names})")
            assert found == [], width
            for name in ("Joints", "Families", "Share", "View"):
                tab.page.get_by_role("tab", name=name).click()
                tab.page.wait_for_timeout(500)
                assert tab.page.evaluate(FAINT, 4.5) == [], (width, name)
        assert viewer.controls.found is not None


def test_a_state_is_copied(laptop: tuple[Viewer, Tab]) -> None:
    viewer, tab = laptop
    tab.page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    tab.page.get_by_role("tab", name="Share").click()
    for what, shown in (("link", viewer.share.ui.link), ("command", viewer.share.ui.line)):
        tab.page.get_by_role("button", name=f"copy the {what}").click()
        tab.page.get_by_text("copied").first.wait_for(timeout=PATIENCE)
        assert tab.page.evaluate("() => navigator.clipboard.readText()") == shown.value
    tab.page.get_by_role("tab", name="Joints").click()


def test_every_slider_has_its_joint_for_a_name_and_obeys_the_keyboard(laptop: tuple[Viewer, Tab]) -> None:
    viewer, tab = laptop
    tab.page.get_by_role("tab", name="Joints").click()
    slider = tab.page.get_by_role("slider", name="3 joint3")
    before = viewer.session.q[2]
    slider.first.focus()
    slider.first.press("ArrowRight")
    tab.until(lambda: viewer.session.q[2] > before)
    viewer.session.set(np.array(WRIST))


LIT = """() => {
    const page = document.body.cloneNode(true);
    page.querySelectorAll('[style*="opacity:0.4"], [style*="opacity: 0.4"]').forEach((one) => one.remove());
    return page.textContent;
}"""


def test_nearest_never_lags_behind_the_verdict(
    laptop: tuple[Viewer, Tab], monkeypatch: pytest.MonkeyPatch
) -> None:
    """While an explanation is under way nothing of an older one is on the page, but dimmed."""
    viewer, tab = laptop
    regular = np.array([0.3, 0.5, 0.4, 0.2, 0.9, 0.6])
    viewer.session.set(regular)
    told = "Next:"
    wanted = ("● regular", told, "Verified:")  # sections of the page arrive one by one
    tab.until(lambda: all(words in tab.page.evaluate(LIT) for words in wanted))
    held, explain = Event(), session.explain

    def waiting(*args: Any, **named: Any) -> Any:
        held.wait(timeout=180.0)
        return explain(*args, **named)

    monkeypatch.setattr(session, "explain", waiting)
    try:
        viewer.session.set(np.array(WRIST))
        tab.until(lambda: "■ singular" in tab.page.evaluate(LIT))
        tab.page.wait_for_timeout(500)
        lit = tab.page.evaluate(LIT)
        assert "● regular" not in lit
        assert told not in lit
        assert "Verified:" not in lit
        assert "Verified:" in tab.page.evaluate("document.body.textContent")  # there, but dimmed
    finally:
        held.set()
    tab.until(lambda: "to blame" in tab.page.evaluate(LIT))
    viewer.session.set(np.array(WRIST))


def test_a_slider_moves_the_arm(laptop: tuple[Viewer, Tab]) -> None:
    viewer, tab = laptop
    tab.page.get_by_role("tab", name="Joints").click()
    tab.draw()
    before, start = tab.still(), viewer.session.q
    slider = tab.page.get_by_role("slider").nth(1)
    slider.focus()
    slider.press("End")
    tab.until(lambda: viewer.session.q[1] > start[1] + 0.5)
    moved = viewer.session.q
    assert (np.delete(moved, 1) == np.delete(start, 1)).all()
    tab.until(lambda: bool(np.allclose(viewer.stage.links[-1].position, viewer.controls.now.links[-1, :3, 3])))
    tab.until(lambda: tab.picture() != before, 6.0)  # sixty pictures
    tab.draw(False)


def test_an_escape_button_leads_out_and_a_family_button_back(laptop: tuple[Viewer, Tab]) -> None:
    viewer, tab = laptop
    live = viewer.controls.live
    viewer.session.set(np.array(WRIST))
    tab.until(lambda: bool((viewer.controls.found.q == WRIST).all()))  # type: ignore[union-attr]
    tab.page.get_by_role("tab", name="Escape").click()
    tab.page.get_by_role("button", name=re.compile(r"^joint 5 .*σ")).click()  # a line of the panel names joint 5 too
    tab.until(lambda: abs(viewer.session.q[4]) > 0.09 and not viewer.session.moving)
    assert singular_values(live.robot, viewer.session.q, live.task)[5] > 1e-3
    tab.page.get_by_role("tab", name="Families").click()
    tab.page.get_by_text("go to the nearest singular configuration").click()
    tab.until(lambda: bool(singular_values(live.robot, viewer.session.q, live.task)[5] < 1e-9))


def test_a_slice_is_drawn(laptop: tuple[Viewer, Tab]) -> None:
    viewer, tab = laptop
    tab.draw()
    before = tab.still()
    tab.page.get_by_role("tab", name="Slice").click()
    tab.page.get_by_text("draw the singular set").click()
    tab.page.get_by_text("starts arrived").first.wait_for(timeout=PATIENCE)
    tab.until(lambda: tab.picture() != before, 6.0)  # sixty pictures
    tab.draw(False)
    viewer.slice.clear()


@pytest.mark.spread(1)
@pytest.mark.parametrize("dark", [False, True])
def test_it_fits_a_phone(browser: Any, dark: bool) -> None:
    for viewer, tab in opened(browser, PHONE, dark=dark):
        tab.page.get_by_text("■ singular").first.wait_for(timeout=PATIENCE)
        wide = tab.page.evaluate("document.documentElement.scrollWidth")
        assert wide <= PHONE[0]
        assert len(viewer.server.get_clients()) == 1


def test_a_page_of_another_origin_cannot_connect(browser: Any, laptop: tuple[Viewer, Tab], tmp_path: Path) -> None:
    viewer, _ = laptop
    (tmp_path / "index.html").write_text("<!DOCTYPE html><title>other</title>", encoding="utf-8")
    handler = partial(_Silent, directory=str(tmp_path))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as other:
        Thread(target=other.serve_forever, daemon=True).start()
        page = browser.new_page()
        page.goto(f"http://127.0.0.1:{other.server_address[1]}/")
        outcome = page.evaluate(
            """url => new Promise(done => {
                const socket = new WebSocket(url, ["viser-v" + "0"]);
                socket.onopen = () => done("open"); socket.onerror = () => done("refused");
            })""",
            viewer.url.replace("http://", "ws://"),
        )
        page.close()
        other.shutdown()
    assert outcome == "refused"


class _Silent(SimpleHTTPRequestHandler):
    def log_message(self, *_: object) -> None:
        return
