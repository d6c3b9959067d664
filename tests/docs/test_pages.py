"""What the pages of the site show is what is printed: commands in `console` blocks, and Python with `>>>`.

A line "…" in a block stands for lines left out.
"""

from __future__ import annotations

import doctest
import re
import shlex
from pathlib import Path

import pytest
from golden.noise import without_noise, without_time

from rankdrop.cli import main

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGES = [*(DOCS / name for name in ("index.md", "start.md", "choose.md")), *sorted(DOCS.glob("howto/*.md"))]


def commands(page: Path) -> list[tuple[str, str]]:
    """(command, what the page shows of its output), for blocks that begin with a $ prompt."""
    text = page.read_text(encoding="utf-8")
    blocks = re.findall(r"^```console\n\$ (rankdrop .*?)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    return [(command, shown) for command, shown in blocks if shown.strip()]


SHOWN = [(page, command, shown) for page in PAGES for command, shown in commands(page)]


@pytest.fixture(scope="module")
def outputs() -> dict[str, str]:
    """What commands printed: a page shows parts of one output in several places."""
    return {}


@pytest.mark.slow_at("postures-11")
@pytest.mark.slow_at("from-a-pose-7", "postures-10", "postures-8", "postures-9")
@pytest.mark.slow_at("index-0", "start-1", "postures-6", "start-2")
@pytest.mark.parametrize(
    ("page", "command", "shown"), SHOWN, ids=[f"{page.stem}-{i}" for i, (page, _, _) in enumerate(SHOWN)]
)
@pytest.mark.shipped
def test_commands_print_what_is_shown(
    page: Path,
    command: str,
    shown: str,
    outputs: dict[str, str],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.chdir(tmp_path)  # a command may write a figure
    if command not in outputs:
        assert main.run([*shlex.split(command)[1:], *(["--quiet"] if " analyze " in command else [])]) in (0, 3, 4)
        outputs[command] = without_noise(without_time(capsys.readouterr().out))
    printed = outputs[command]
    for piece in filter(str.strip, re.split(r"^…\n", shown, flags=re.MULTILINE)):
        wanted = without_noise(without_time(piece))
        assert wanted in printed, f"{page.name}: {command}"
        printed = printed.partition(wanted)[2]


@pytest.mark.slow_at("from-a-pose")
@pytest.mark.slow_at("nearly-ideal", "comparing-designs", "paths", "postures", "tool-offset", "inside-limits")
@pytest.mark.parametrize("page", PAGES, ids=[page.stem for page in PAGES])
def test_python_prints_what_is_shown(page: Path) -> None:
    failed, _ = doctest.testfile(str(page), module_relative=False, encoding="utf-8", optionflags=doctest.ELLIPSIS)
    assert failed == 0


def test_there_is_something_to_check() -> None:
    assert len(SHOWN) > 6


MESSAGES = [
    (page.stem, command)
    for page in sorted(DOCS.glob("messages/*.md"))
    for command in re.findall(r"^rankdrop explain .*$", page.read_text(encoding="utf-8"), re.MULTILINE)
]


@pytest.mark.parametrize(("page", "command"), MESSAGES)
def test_the_example_of_a_controllers_message_is_near_a_singularity(
    page: str, command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.run(shlex.split(command)[1:]) in (3, 4), f"{page}: {capsys.readouterr().out[:200]}"


SPEEDS = [
    (page.stem, command)
    for page in sorted(DOCS.glob("messages/*.md"))
    for command in re.findall(r"^rankdrop analyze .* --speed .*$", page.read_text(encoding="utf-8"), re.MULTILINE)
]


@pytest.mark.by_hand
@pytest.mark.shipped
@pytest.mark.parametrize(("page", "command"), SPEEDS)
def test_the_distance_of_a_page_is_the_one_that_is_proven(
    page: str, command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.run([*shlex.split(command)[1:], "--quiet"]) == 0
    printed = re.search(r"wrist +\S+ +([\d.]+)° from", capsys.readouterr().out)
    assert printed is not None
    assert f"from {printed[1]}° on" in (DOCS / "messages" / f"{page}.md").read_text(encoding="utf-8")
