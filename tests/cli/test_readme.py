"""The documents name commands, options, arms and files that exist."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

from rankdrop.cli import exits, main
from rankdrop.cli.main import app
from rankdrop.robot.open import robot_names

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "docs/json.md", "docs/robot-files.md",
                                    "docs/command-line.md")]  # fmt: skip
README = (ROOT / "README.md").read_text(encoding="utf-8")
COMMAND_LINE = (ROOT / "docs" / "command-line.md").read_text(encoding="utf-8")
EXIT_CODES = (ROOT / "docs" / "exit-codes.md").read_text(encoding="utf-8")
CLAIMS = (ROOT / "docs" / "claims.md").read_text(encoding="utf-8")


def command_lines() -> Iterator[str]:
    """Every `rankdrop …` of the documents, in code blocks and between back-quotes."""
    for path in DOCUMENTS:
        if not path.exists():
            continue
        text = path.read_text(encoding="utf-8")
        blocks = re.findall(r"^```(\w*)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
        inline = re.findall(r"`([^`\n]+)`", re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE))
        for line in [*inline, *(line for kind, code in blocks if kind == "console" for line in code.splitlines())]:
            yield from (part.strip() for part in re.findall(r"(?:^|[$/]\s?)(rankdrop [a-z-].*)", line))


LINES = sorted(set(command_lines()))


def test_there_is_something_to_check() -> None:
    assert any(line.startswith("rankdrop analyze pa10") for line in LINES)


@pytest.mark.parametrize("line", LINES)
def test_commands_and_options_exist(line: str) -> None:
    words = main._expand(shlex.split(re.split(r"\s[|>#]", line)[0])[1:])
    if words[0].startswith("--"):
        assert words[0] in ("--version", "--help")
        return
    assert words[0] in app
    allowed = {name for one in app[words[0]].assemble_argument_collection() for name in one.names} | {"--help"}
    assert {word.partition("=")[0] for word in words if word.startswith("--")} <= allowed
    of_an_arm = words[0] not in ("robots", "completion") and len(words) > 1
    if of_an_arm and words[1].isalnum() and words[1].islower():
        assert words[1] in robot_names()


def test_the_readme_is_short() -> None:
    """At most 600 words before the links, and the install line on the first screen."""
    assert len(README[: README.index("## Links")].split()) <= 600
    assert README.splitlines().index("## Install and try") < 10


def test_every_command_is_on_the_page_of_the_command_line() -> None:
    named = {shlex.split(line)[1] for line in re.findall(r"^rankdrop [a-z]+", COMMAND_LINE, re.MULTILINE)}
    inline = set(re.findall(r"`rankdrop ([a-z]+)", COMMAND_LINE))
    assert {name for name in app if not name.startswith("-")} - named - inline == set()


def test_exit_codes_are_documented() -> None:
    for code, meaning in exits.MEANING.items():
        assert f"| {code} | {meaning} |" in EXIT_CODES


def test_the_checks_run_the_test_command_of_the_readme() -> None:
    commands = re.findall(r"^python3 -m venv .*$", README, re.MULTILINE)
    assert len(commands) == 2
    assert commands[1] in (ROOT / ".ci" / "run").read_text(encoding="utf-8")


def test_tests_and_benchmarks_named_in_the_claims_exist() -> None:
    named = set(re.findall(r"(?:tests|benchmarks)/[\w/.]+", CLAIMS))
    assert len(named) > 5
    assert [name for name in named if not (ROOT / name).exists()] == []


MADE = ("atlas/", "commands/", "gallery/")
"""Folders of the site that its build makes: it refuses a link into them that leads nowhere."""


def test_links_lead_somewhere() -> None:
    for path in (*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")):
        prose = re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
        for target in re.findall(r"\]\(([^)#]+)", prose):
            made = path.parent.name == "docs" and target.startswith(MADE)
            if not made and not target.startswith(("http:", "https:", "mailto:")):
                assert (path.parent / target).exists(), f"{path.name}: {target}"
