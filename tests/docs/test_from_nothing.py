"""A newcomer types the commands of a page in an empty folder: every file that one reads an earlier one has written."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
MADE = ("atlas", "commands", "gallery", "decisions")
"""Folders of pages that are made, or tell of the past."""
WRITTEN = [page for page in sorted(DOCS.rglob("*.md")) if page.relative_to(DOCS).parts[0] not in MADE]
PAGES = [ROOT / "README.md", *WRITTEN]
FILE = re.compile(r"\.(urdf|xacro|xml|mjcf|toml|csv|json|npz|npy|ya?ml|src|mod|script|ls|jbi|cover|h|html|svg|tex)$")
WRITES = {"--json", "--out", "--example", "--fixed", "--certificate", "--latex", "--python", "--c", "--steps-out",
          "--history", "--figure", "--html", "--header", "--rows", "--csv", "--save"}  # fmt: skip
SERVES = ("rankdrop view", "rankdrop completion", "python -m")
"""Commands that go on until they are stopped, or do something to the shell."""


def commands(page: Path) -> Iterator[str]:
    """Commands of rankdrop in the page's console blocks, comments left out."""
    for block in re.findall(r"^```console\n(.*?)^```$", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE):
        for line in block.splitlines():
            typed = line.removeprefix("$ ").strip()
            if typed.startswith(("rankdrop ", "printf ")):
                yield typed


TYPED = {page: tuple(commands(page)) for page in PAGES}
RUN = [page for page, typed in TYPED.items() if typed]


def files(typed: str) -> tuple[set[str], set[str]]:
    """(read, written) files of a command."""
    words = shlex.split(typed, comments=True)
    read, written = set(), set()
    for before, word in zip(["", *words], words, strict=False):
        if before in WRITES or before == ">" or (before == "--path" and words[1] == "aspects"):
            written.add(word)
        elif FILE.search(word) and not word.startswith("-"):
            read.add(word)
    return read, written


@pytest.mark.parametrize("page", RUN, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_a_file_that_is_read_was_written_before(page: Path) -> None:
    there: set[str] = set()
    for typed in TYPED[page]:
        read, written = files(typed)
        assert read <= there, typed
        there |= written


def test_files_of_a_command() -> None:
    assert files("rankdrop path ur5e pick.csv --fixed mended.csv  # now.csv") == ({"pick.csv"}, {"mended.csv"})
    assert files("rankdrop aspects crx10ia --path change.csv") == (set(), {"change.csv"})
    assert files("rankdrop verify a.json --path pick.csv") == ({"a.json", "pick.csv"}, set())
    assert sum(map(len, TYPED.values())) > 100


@pytest.mark.by_hand
@pytest.mark.parametrize("page", RUN, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_commands_end_well_in_an_empty_folder(page: Path, tmp_path: Path) -> None:
    shell = f'rankdrop() {{ "{sys.executable}" -m rankdrop "$@"; }}\n'
    for typed in TYPED[page]:
        if typed.startswith(SERVES):
            continue
        done = subprocess.run(
            ["/bin/bash", "-c", shell + typed], cwd=tmp_path, capture_output=True, text=True, timeout=1800, check=False
        )
        assert done.returncode in (0, 3, 4), f"{typed}: {done.returncode}: {done.stderr.strip()[-300:]}"
