"""The help: groups in order, few lines, aliases, and a whole page for each command."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import pytest

from rankdrop.cli import exits
from rankdrop.cli.main import ALIASES, COMMANDS, FILES, GROUPS, _options, app


@pytest.mark.slow
def test_the_list_of_commands_is_in_groups_and_short(process: Any) -> None:
    text = process("--help", COLUMNS="80").out
    lines = text.splitlines()
    assert len(lines) <= 45
    assert [line.rstrip(":") for line in lines if line.rstrip(":") in GROUPS] == list(GROUPS)
    places = [next(i for i, line in enumerate(lines) if line.startswith(f"  {name} ")) for name in COMMANDS]
    assert places == sorted(places)
    assert not any(f"  {name} " in text for name in ALIASES)
    assert process(COLUMNS="80").out == process("help", COLUMNS="80").out == text


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_the_line_of_a_command_is_the_first_of_its_page(run: Any, name: str) -> None:
    line = next(commands[name] for commands in GROUPS.values() if name in commands)
    text = run(name, "--help").out
    assert text.splitlines()[:3] == [text.splitlines()[0], "", line]
    assert run("help", name).out == text


@pytest.mark.slow
def test_options_of_a_command_stand_before_those_of_the_arm_and_of_the_output(run: Any) -> None:
    text = run("explain", "--help").out
    assert text.index("\nOptions:") < text.index("  --near") < text.index("\nThe arm:") < text.index("\nOutput:")


@pytest.mark.slow
def test_the_help_fills_the_width_of_the_terminal(process: Any) -> None:
    narrow, wide = (process("explain", "--help", COLUMNS=width).out.splitlines() for width in ("80", "120"))
    assert 75 <= max(map(len, narrow)) <= 80 < 115 <= max(map(len, wide)) <= 120


def test_aliases_are_parts_of_explain(run: Any) -> None:
    words = ("puma560", "--q", "0.3 0.5 0.4 0.2 0 0.6")
    for name in ALIASES:
        assert run(name, *words).out == run("explain", *words, "--only", name).out
    assert run("escape", "ur5").err.startswith("rankdrop: error: --q: joint values are missing; allowed: ")
    assert set(ALIASES).isdisjoint(app)


@pytest.mark.slow
def test_words_that_people_expect(run: Any) -> None:
    words = ("explain", "ur5", "--q", "0,-135,45,90,-90,0", "--evaluations", "0")
    assert run(*words, "--degrees").out == run(*words, "--deg").out
    for word in ("-v", "--verbose"):
        assert run(*words, "--deg", word).out == run(*words, "--deg", "--full").out
    assert run("robots", "fanuc", "-v").out == run("robots", "fanuc").out
    assert run("-v").out == run("--version").out


def test_no_arm_of_the_catalogue_fits(run: Any) -> None:
    ended = run("robots", "reachy9")
    assert ended.code == exits.UNEXPLAINED
    assert "reachy2" in ended.out


@pytest.mark.slow
def test_only_the_file_of_the_command_is_imported() -> None:
    program = (
        "import sys; from rankdrop.cli import main; main.run(['robots', 'planar3r']); "
        "print(*(name for name in sys.modules if name.startswith('rankdrop.cli.')), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    imported = set(done.stderr.split())
    assert "rankdrop.cli.arms" in imported
    assert not imported & {f"rankdrop.cli.{FILES.get(name, name)}" for name in COMMANDS if FILES.get(name) != "arms"}


def test_only_switches_that_are_on_have_a_negative() -> None:
    negative = {name: [word for word in _options(name) if word.startswith("--no-")] for name in COMMANDS}
    assert {name: words for name, words in negative.items() if words} == {
        "cover": ["--no-explain"], "report": ["--no-meshes"], "verify": ["--no-limits"], "view": ["--no-browser"],
    }  # fmt: skip
