"""What a release is made with agrees with pyproject.toml, and the tools that try it see what they are to see."""

from __future__ import annotations

import re
import runpy
import sqlite3
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

from scripts import tool

ROOT = Path(__file__).resolve().parents[2]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def lowest() -> dict[str, str]:
    """Name -> lowest version of what the plain install asks for."""
    return dict(line.split(">=") for line in PROJECT["dependencies"])


def parts(version: str) -> tuple[int, ...]:
    """1.26.0 and 1.26 are the same version."""
    numbers = [int(part) for part in version.split(".")]
    return tuple(numbers + [0] * (3 - len(numbers)))


def test_the_lowest_versions_are_those_that_are_asked_for() -> None:
    lines = (ROOT / ".ci" / "lowest.txt").read_text(encoding="utf-8").splitlines()
    tried = dict(line.split("==") for line in lines if not line.startswith("#"))
    assert {name: parts(version) for name, version in tried.items()} == {
        name: parts(version) for name, version in lowest().items()
    }


def test_the_recipe_is_of_this_version_and_asks_for_the_same() -> None:
    text = (ROOT / "packaging" / "recipe.yaml").read_text(encoding="utf-8")
    recipe = yaml.safe_load(text.replace("${{", "").replace("}}", ""))
    assert recipe["context"]["version"] == PROJECT["version"]
    run = dict(line.replace("matplotlib-base", "matplotlib").split(" >=") for line in recipe["requirements"]["run"])
    assert run.pop("python") == PROJECT["requires-python"].removeprefix(">=")
    assert run == lowest()
    assert recipe["about"]["summary"] == PROJECT["description"]


def test_every_extra_is_tried_alone() -> None:
    tried = runpy.run_path(str(ROOT / ".ci" / "release"))["TRIED"]
    assert set(tried) == set(PROJECT["optional-dependencies"]) | {""}


def test_every_place_has_the_version_of_the_project() -> None:
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert cited["version"] == PROJECT["version"]
    assert cited["license"] == PROJECT["license"]
    assert len(cited["references"]) == 5
    told = re.findall(r"^## \[(.+?)\](?: - (\d{4}-\d\d-\d\d))?$", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.M)
    released = [(version, date) for version, date in told if version != "Unreleased"]
    assert released[0][0] == PROJECT["version"]


def test_a_version_is_saved_by_what_is_installed_and_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    saver = tool("save_version")
    monkeypatch.setattr(saver, "VERSION", "0.0.0")
    assert saver.main() == 1
    assert "installed is 0.0.0, the source is" in capsys.readouterr().err


def test_the_container_has_the_plain_install_and_no_superuser() -> None:
    lines = (ROOT / "packaging" / "Containerfile").read_text(encoding="utf-8").splitlines()
    said = [line for line in lines if line and not line.startswith("#")]
    assert sum(line.startswith("FROM python:") for line in said) == 2
    assert [line for line in said if line.startswith("USER")] == ["USER user"]
    assert not any(re.search(r"pip install .*\[", line) for line in said)


def test_mutants_are_of_what_they_say() -> None:
    """Each changes one place of the file; the file as it is is none of them."""
    mutate = tool("mutate")
    text = 'def f(x: int = 3) -> int:\n    """One é."""\n    return x + 1 if not x < 2 and True else -x\n'
    made = mutate.of_python(text)
    assert {one.line for one in made} == {1, 3}
    assert all(one.text != text for one in made)
    values = []
    for one in made:
        names: dict[str, Any] = {}
        exec(one.text, names)  # every mutant is Python
        values.append([names["f"](x) for x in (0, 1, 2, 3)] + [names["f"]()])
    names = {}
    exec(text, names)
    want = [names["f"](x) for x in (0, 1, 2, 3)] + [names["f"]()]
    assert sum(value != want for value in values) >= 8
    assert {one.what for one in mutate.of_cpp("if (a < b && c != d) return a + b;  // a < b\n#include <x>\n")} == {
        f"if (a < b && c != d) return a + b;: {change}" for change in ("< -> <=", "&& -> ||", "!= -> ==", "+ -> -")
    }


def test_a_line_is_tried_by_the_tests_that_reach_it(tmp_path: Path) -> None:
    """Those that reach least first; what runs at import alone by all of its file; bits as coverage.py writes them."""
    mutate, recorded = tool("mutate"), tmp_path / "reached"
    with sqlite3.connect(recorded) as data:
        data.execute("create table context (id integer, context text)")
        data.execute("create table file (id integer, path text)")
        data.execute("create table line_bits (file_id integer, context_id integer, numbits blob)")
        data.executemany("insert into context values (?, ?)", [(0, ""), (1, "a.py::wide|run"), (2, "a.py::narrow|run")])
        data.execute("insert into file values (1, '/where/it/was/src/rankdrop/version.py')")
        data.executemany("insert into line_bits values (1, ?, ?)", [(0, b"\x02"), (1, b"\xf0\x01"), (2, b"\x00\x01")])
    data.close()
    file = mutate.ROOT / "src" / "rankdrop" / "version.py"
    reached = mutate.Reached(recorded)
    assert reached.tests(file, 8) == ["a.py::narrow", "a.py::wide"]
    assert reached.tests(file, 4) == ["a.py::wide"]
    assert reached.tests(file, 1) == ["a.py::narrow", "a.py::wide"]
    assert reached.tests(file, 3) == []


def test_memory_that_grows_is_not_flat() -> None:
    soak = tool("soak")
    assert soak.flat([10.0, *[60.0] * 19], 1.0) == 0.0
    assert soak.flat([60.0] * 15 + [60.5] * 5, 1.0) == 0.5
    with pytest.raises(SystemExit):
        soak.flat([60.0 + i for i in range(20)], 8.0)
