"""A change that a newcomer makes: a column in the table of families, from two files, in every form that it has."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import rankdrop

SOURCE = Path(rankdrop.__file__).parent
CHANGES = {
    "text/families.py": (
        '        Column("dimension", "dim", lambda row: str(row.dimension)),\n',
        '        Column("codimension", "codim", lambda row: str(robot.n - row.dimension)),\n',
    ),
    "schema/families.py": (
        '    dimension=(Count, "of the family in joint space"),\n    pinned',
        '    codimension=(optional(Count), "", lambda row: len(row.witness) - row.dimension),\n',
    ),
}
"""File -> the line before, and the line that is added."""
PROGRAM = """
import json
from rich.console import Console
from rankdrop.cli.analyze import corank_section
from rankdrop.report.sections import corank_tables
from rankdrop.results.known import shipped
from rankdrop.schema import load_schema

found = shipped("pa10")
console = Console(width=160)
with console.capture() as terminal:
    console.print(*corank_section(console, found, found.coranks[0]), sep="\\n")
print(json.dumps({
    "terminal": terminal.get(), "page": corank_tables(found), "notebook": found._repr_html_(), "latex": found.latex(),
    "plain": str(found), "record": found.to_dict()["families"],
    "schema": load_schema("analysis")["$defs"]["family"]["properties"],
}))
"""


@pytest.mark.slow
def test_a_new_column_reaches_terminal_page_notebook_latex_and_json(tmp_path: Path) -> None:
    copy = tmp_path / "rankdrop"
    shutil.copytree(SOURCE, copy, ignore=shutil.ignore_patterns("__pycache__", "known", "include"))
    (copy / "known").symlink_to(SOURCE / "known")
    assert len(CHANGES) <= 3
    for name, (before, added) in CHANGES.items():
        text = (copy / name).read_text(encoding="utf-8")
        line, rest = before.partition("\n")[0] + "\n", before.partition("\n")[2]
        assert text.count(before) == 1, name
        (copy / name).write_text(text.replace(before, line + added + rest), encoding="utf-8")
    environment = {"PYTHONPATH": str(tmp_path), "PATH": "/usr/bin:/bin", "HOME": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stderr[-2000:]
    told = json.loads(done.stdout)
    assert told["terminal"].count("codim") == 1
    tables = len({row["corank"] for row in told["record"]})
    assert told["page"].count("<th>codim</th>") == tables
    assert told["notebook"].count("<th>codim</th>") == tables
    assert told["latex"].count("& codim &") == tables
    assert told["plain"].count("codim") == tables
    assert [row["codimension"] for row in told["record"]] == [7 - row["dimension"] for row in told["record"]]
    assert told["schema"]["codimension"]["type"] == "integer"
