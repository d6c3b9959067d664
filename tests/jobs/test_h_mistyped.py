"""Job (h): a beginner. Command lines as people mistype them: one line says what is wrong and what to type instead."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rankdrop.cli import main

SINGULAR = ("explain", "ur5e", "--deg")
LINES = {
    ("explan", "ur5e"): "explain",
    ("explain", "ur5ee", "--q", "0"): "no such robot in the catalogue",
    ("explain", "arm.urdf", "--q", "0"): "there is no such file",
    ("ur5e",): "ur5e is an arm; a command comes first: rankdrop analyze ur5e",
    ("explain", "ur5e"): "--q: joint values are missing",
    ("explain", "ur5e.urdf"): "there is no such file; got 'ur5e.urdf'; fix: did you mean ur5e?",
    (*SINGULAR, "--q", "0", "-60", "0"): '--q 0,-60,0 or --q "0 -60 0"',
    (*SINGULAR, "--q", "0,-60,0"): "6 joint values are needed",
    (*SINGULAR, "--q", "0,5; 1,2; 0; 0,1; 0; 0"): "write decimals with points: 0.5; 1.2",
    (*SINGULAR, "--q", "0,0,0,0,0,0", "--tcp", "0,0,120"): "--tcp: a tool point so far from the tip",
    (*SINGULAR, "--q", "0,0,0,0,0,0", "--near", "4mm"): "--near: the unit is not one that fits here",
    (*SINGULAR, "--q", "0,0,0,0,0,0", "--only", "exit"): "escape",
    (*SINGULAR, "--q", "0,0,0,0,0,0", "--nearr", "1"): "--near",
    (*SINGULAR, "--q", "0,0,0,0,0,0", "--analysis", "none.json"): "none.json",
    ("path", "ur5e"): "no file is named",
    ("path", "pick.csv", "ur5e"): "rankdrop path ur5e pick.csv",
    ("path", "ur5e", "none.csv"): "none.csv: there is no such file",
    ("path", "ur5e", "none.csv", "--topic", "/joint_states"): "none.csv: there is no such file",
    ("path", "ur5e", "pick.csv", "--figure", "x.doc"): "--figure: the ending names no format",
    ("path", "ur5e", "pick.csv", "--json", "none/x.json"): "--json: there is no such folder",
    ("analyze", "ur5e", "--starts", "1.5"): "whole number",
    ("analyze", "ur5e", "--task", "posse"): "allowed: ",
    ("analyze", "ur5e", "--json", "--quiet"): "--json: it needs the name of a file",
    ("analyze", "turned.urdf"): "write 'revolute'",
    ("conditions", "ur5e", "--method", "minors"): "determinant",
    ("find", "ur5e"): "--corank is missing",
    ("jacobian", "ur5e", "--at", "flange"): "allowed: tip, or a link from 1",
    ("compare", "ur5e"): "arms",
    ("sweep",): "no specification is named",
    ("monitor", "ur5e"): "--header is missing",
    ("verify", "none.json"): "none.json",
    ("view", "ur5e", "--host", "0.0.0.0"): "add --expose if that is intended",
}
"""What is typed -> what the one line on stderr holds."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two files of the beginner's, in the folder where the commands run."""
    (tmp_path / "pick.csv").write_text("q1,q2,q3,q4,q5,q6\n0,-1,1,0,1,0\n0,-1,0.9,0,1,0\n", encoding="utf-8")
    (tmp_path / "turned.urdf").write_text(
        '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="Revolute"><parent link="a"/>'
        '<child link="b"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>',
        encoding="utf-8",
    )
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.spread(18)
@pytest.mark.slow
@pytest.mark.parametrize("line", LINES, ids=" ".join)
def test_one_line_says_what_to_type(line: tuple[str, ...], folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(line) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert len(shown.err.splitlines()) == 1
    assert LINES[line] in shown.err


def test_no_match_in_the_catalogue_is_an_answer_of_its_own(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["robots", "reachy9"]) == 3
    assert "reachy2" in capsys.readouterr().out


def test_radians_typed_as_degrees_are_noticed(capsys: pytest.CaptureFixture[str]) -> None:
    main.run([*SINGULAR, "--q", "0,-1.05,0,0.7,0.87,0", "--evaluations", "0"])
    assert "look like radians and are read as degrees" in capsys.readouterr().err


@pytest.mark.parametrize("target", ["list.json", "-", None])
def test_the_catalogue_as_json(target: str | None, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """--json FILE, --json - and --json alone; words that follow are still those to look for."""
    words = ["robots", "--json", "fanuc"] if target is None else ["robots", "fanuc", "--json", target]
    assert main.run(words) == 0
    out = capsys.readouterr().out
    listed: list[dict[str, Any]] = json.loads(
        (folder / target).read_text(encoding="utf-8") if target == "list.json" else out
    )
    assert all(arm["maker"].upper() == "FANUC" for arm in listed)
    assert ("what it is" in out) == (target == "list.json")
