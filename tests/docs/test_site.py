"""The site builds without a warning, and nothing in it is loaded from elsewhere.

In the checks the atlas has the pages of a few arms; the whole site is built by hand.
"""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from browser.axe import violations
from browser.chromium import Browser

ROOT = Path(__file__).resolve().parents[2]
SECONDS = 3000  # a build takes a minute; one that hangs fails
PHONE = 390  # pixels
LOADING = {"src", "srcset", "poster", "data", "action", "formaction", "background", "xlink:href", "style"}
MISSING = [name for name in ("sphinx", "furo", "myst_parser", "latex2mathml") if importlib.util.find_spec(name) is None]
ATLAS = ("almarkhi4", "canadarm2", "gen3", "pa10", "ur10", "ur10e", "yumi")
"""Arms whose pages are looked at: four joints and seven, many rows and few, an arm alike another of its maker."""
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(bool(MISSING), reason=f"the extra `docs` is not installed: {', '.join(MISSING)}"),
]


class Loads(HTMLParser):
    """What a page makes a browser fetch, where its links lead, and the names in it that links can have."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.loaded: list[str] = []
        self.links: list[str] = []
        self.names: set[str] = set()
        self.maths = 0
        self.inside = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.inside = tag
        self.maths += tag == "math"
        for name, value in attrs:
            text = value or ""
            if name == "style":
                self.loaded += addresses(text)
            elif name == "srcset":
                self.loaded += [part.split()[0] for part in text.split(",")]
            elif name in LOADING or (tag in ("link", "use", "image") and name == "href"):
                self.loaded.append(text)
            elif tag == "a" and name == "href":
                self.links.append(text)
            elif name == "id":
                self.names.add(text)
        if tag in ("base", "meta") and any(value and "url=" in value.lower() for _, value in attrs):
            self.loaded.append("a page that sends its reader elsewhere")

    def handle_data(self, data: str) -> None:
        if self.inside == "style":
            self.loaded += addresses(data)


def addresses(css: str) -> list[str]:
    """What a style sheet fetches."""
    found = re.findall(r"""url\(\s*["']?([^"')]+)|@import\s+["']([^"']+)""", css)
    return [first or second for first, second in found]


def elsewhere(address: str) -> bool:
    """Whether an address is not a file of the site, nor data written into the page."""
    parts = urlsplit(address)
    return bool(parts.netloc) or parts.scheme not in ("", "data")


def built(folder: Path, *arms: str) -> Path:
    """The site, whose atlas has the pages of these arms, or of all."""
    for name in ("docs", "examples"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("atlas", "__pycache__"))
    shutil.copy(ROOT / "CHANGELOG.md", folder)
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-n", "-d", str(folder / "trees")]
    command += ["-D", f"atlas_arms={','.join(arms)}"] * bool(arms)
    command += [str(folder / "docs"), str(folder / "html")]
    done = subprocess.run(command, timeout=SECONDS, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return folder / "html"


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(tmp_path_factory.mktemp("site"), *ATLAS)


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Loads]:
    return {page: Loads(page.read_text(encoding="utf-8")) for page in site.rglob("*.html")}


def test_pages_load_nothing_from_elsewhere(site: Path, pages: dict[Path, Loads]) -> None:
    assert len(pages) > 50
    for page, found in pages.items():
        for address in found.loaded:
            assert not elsewhere(address), f"{page.name}: {address}"
            path = unquote(urlsplit(address).path)
            assert address.startswith("data:") or not path or (page.parent / path).exists(), f"{page.name}: {address}"


def test_styles_and_scripts_load_nothing_from_elsewhere(site: Path) -> None:
    for sheet in (*site.rglob("*.css"), *site.rglob("*.svg")):
        assert [one for one in addresses(sheet.read_text(encoding="utf-8")) if elsewhere(one)] == [], sheet.name
    called = r"(?:import|fetch|importScripts|open|EventSource|WebSocket)\W{1,3}"
    fetches = rf"""(?:{called}|\.src\s*=\s*)["'`](?:\w+:)?//"""
    for script in site.rglob("*.js"):
        assert re.findall(fetches, script.read_text(encoding="utf-8")) == [], script.name


def test_links_lead_to_a_page_and_a_place(pages: dict[Path, Loads]) -> None:
    known = {page.resolve(): found.names for page, found in pages.items()}
    for page, found in pages.items():
        for address in found.links:
            parts = urlsplit(address)
            if parts.scheme or parts.netloc or address in ("", "#"):
                continue
            target = (page.parent / unquote(parts.path)).resolve() if parts.path else page.resolve()
            assert target.exists(), f"{page.name}: {address}"
            if parts.fragment and target in known:
                assert unquote(parts.fragment) in known[target], f"{page.name}: {address}"


def test_mathematics_is_in_the_page(site: Path, pages: dict[Path, Loads]) -> None:
    assert pages[site / "mathematics" / "escape.html"].maths > 20
    for page in pages:
        assert re.search(r"mathjax\.|katex|\$\$", page.read_text(encoding="utf-8"), re.IGNORECASE) is None, page.name


def test_every_public_name_and_example_has_an_entry(site: Path, pages: dict[Path, Loads]) -> None:
    import rankdrop

    names = pages[site / "api" / "public.html"].names
    assert {f"rankdrop.{name}" for name in rankdrop.__all__} <= names
    assert {page.stem for page in (site / "gallery").glob("*.html")} == {
        script.stem for script in (ROOT / "examples").glob("[0-9]*_*.py")
    }


def test_the_atlas_has_a_page_for_every_arm_and_finds_them(site: Path, pages: dict[Path, Loads]) -> None:
    index = (site / "atlas" / "index.html").read_text(encoding="utf-8")
    assert {page.stem for page in (site / "atlas").glob("*.html")} == {*ATLAS, "index"}
    for name in ATLAS:
        assert f"{name}.html" in pages[site / "atlas" / "index.html"].links
    assert index.count("<tr data-words=") == len(ATLAS)
    row = next(part for part in index.split("<tr ") if '<td><a href="ur10e.html">ur10e</a>' in part)
    for part in ("Universal Robots", "elbow: axes 2, 3, 4 coplanar", "5 of corank 2", "alike: ", 'href="ur10.html"'):
        assert part in row
    ur10e = (site / "atlas" / "ur10e.html").read_text(encoding="utf-8")
    assert "<title>Singularities of the Universal Robots UR10e" in ur10e
    assert "ur10e" in (site / "searchindex.js").read_text(encoding="utf-8")


@pytest.mark.by_hand
def test_without_a_choice_every_arm_has_a_page(tmp_path: Path) -> None:
    from rankdrop.robot.open import robot_names

    whole = built(tmp_path)
    assert {page.stem for page in (whole / "atlas").glob("*.html")} == {*robot_names(), "index"}
    test_links_lead_to_a_page_and_a_place(
        {page: Loads(page.read_text(encoding="utf-8")) for page in whole.rglob("*.html")}
    )


def test_every_command_has_a_page_with_its_help(site: Path) -> None:
    from rankdrop.cli.main import app

    names = {name for name in app if not name.startswith("-")}
    assert {page.stem for page in (site / "commands").glob("*.html")} == {*names, "index"}
    for name in names:
        assert f"Usage: rankdrop {name}" in (site / "commands" / f"{name}.html").read_text(encoding="utf-8")


@pytest.mark.browser
@pytest.mark.skipif(CHROMIUM is None, reason="no chromium was found")
@pytest.mark.parametrize("dark", [False, True])
def test_axe_finds_nothing_on_the_site(dark: bool, site: Path) -> None:
    names = ("index", "atlas/ur10e", "commands/explain") if dark else ("start", "glossary", "atlas/index", "gallery")
    with Browser(str(CHROMIUM)) as browser:
        for width in (PHONE, 1440):
            browser.window(width, 900, dark=dark, phone=width == PHONE)
            for name in names:
                browser.open(site / f"{name}.html")
                assert violations(browser, tags=("wcag2a", "wcag2aa", "wcag21a", "wcag21aa")) == [], (name, width)


@pytest.mark.spread(4)
@pytest.mark.browser
@pytest.mark.skipif(CHROMIUM is None, reason="no chromium was found")
@pytest.mark.parametrize(
    "name",
    [
        "index",
        "start",
        "choose",
        "commands/analyze",
        "mathematics/escape",
        "mathematics/distance",
        "api/local",
        "atlas/index",
        "atlas/ur10e",
    ],
)
def test_pages_fit_a_phone_and_show_no_error(name: str, site: Path, tmp_path: Path) -> None:
    """The page, in a frame as wide as a phone (no window is so narrow), tells its own width once it is laid out."""
    script = (
        "<script>addEventListener('load', () => {const e = document.documentElement;"
        "const m = document.querySelector('math');"
        "parent.postMessage('laid out ' + e.scrollWidth + ' of ' + e.clientWidth + ' math '"
        " + (m ? Math.round(m.getBoundingClientRect().height) : -1), '*');});</script>"
    )
    page = site / f"{name}.html"
    probe, frame = page.with_name(f"probe-{page.name}"), tmp_path / "frame.html"
    probe.write_text(page.read_text(encoding="utf-8").replace("</head>", f"{script}</head>"), encoding="utf-8")
    frame.write_text(
        "<script>addEventListener('message', event => {document.title = event.data;});</script>"
        f'<iframe src="{probe.as_uri()}" style="width: {PHONE}px; height: 844px; border: 0"></iframe>',
        encoding="utf-8",
    )
    command = [str(CHROMIUM), "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=5000", "--dump-dom"]
    command += ["--enable-logging=stderr", f"--user-data-dir={tmp_path}", frame.as_uri()]
    environment = {**os.environ, "HOME": str(tmp_path)}
    try:
        done = subprocess.run(command, timeout=600, capture_output=True, text=True, check=False, env=environment)
    finally:
        probe.unlink()
    assert "CONSOLE" not in done.stderr
    told = re.search(r"laid out (\d+) of (\d+) math (-?\d+)", done.stdout)
    assert told, done.stderr
    width, room, math = map(int, told.groups())
    assert width <= room <= PHONE  # a scroll bar takes some
    assert math == -1 or math > 5
