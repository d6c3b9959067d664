"""Verdicts on robot programs: which line, which singularity."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from path.program_data import ASK, DATA

from rankdrop.cli import main
from rankdrop.kinematics import pose
from rankdrop.path.check.program import check_program
from rankdrop.path.read import krl, rapid
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema


@pytest.mark.slow
def test_the_verdict_names_the_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out.json"
    assert main.run(["path", "ur5e", str(DATA / "urscript.script"), "--json", str(out), "--quiet"]) == 3
    written = json.loads(out.read_text())
    Draft202012Validator(load_schema("program")).validate(written)
    (met,) = written["met"]
    assert (met["line"], met["kind"], met["verdict"]) == (10, "joint", "crossing")
    assert abs(met["q"][4]) < 1e-9
    assert "in line 10: movej([0.3, -1.2, 1.4, -1.0, 0.2, 0.4], t=2)" in written["sentence"]
    assert [part["lines"] for part in written["parts"]] == [[5, 7], [9, 10]]
    assert [one["line"] for one in written["skipped"]] == [8, 11, 12]
    assert written["blended"] == [6]
    first = written["parts"][0]
    assert len(first["line_of"]) == first["path"]["rows"] - 1
    assert first["line_of"] == sorted(first["line_of"])
    printed = " ".join(capsys.readouterr().out.split())
    assert "rounds those of line 6" in printed
    assert "line 12: this circular move is not read" in printed


@pytest.mark.parametrize(
    ("line", "speed", "said"),
    [
        ("LIN {X 332.293819, Y 0, Z 621.393159, A 180, B 88, C 180}", "", "0.03398 rad (1.95°) from a singularity in"),
        ("LIN {X 332.293819, Y 0, Z 621.393159, A 180, B 88, C 180}", "$VEL.CP=0.05", "limits and rates kept"),
        ("LIN {X 322.291412, Y 0, Z 586.510622, A 180, B 60, C 180}", "", "joint limits kept."),
    ],
)
def test_a_free_line_near_a_singularity_says_that_its_rates_are_not_known(line: str, speed: str, said: str) -> None:
    """A line of no known speed: what its joints would have to do so near is not known, and the verdict says so."""
    bend = 180 - float(line.split("B ")[1].split(",")[0]) - 90
    text = f"DEF A()\n{speed}\nPTP {{A1 0, A2 -90, A3 90, A4 0, A5 {bend}, A6 0}}\n{line}\nEND\n"
    found = check_program(open_robot("kr3r540"), krl.read(text, "a.src"), ASK)
    assert said in found.sentence
    assert ("where joint rates are not known" in found.sentence) is (not speed and bend < 10)


@pytest.mark.slow
def test_krl_signs_and_rapid_quarters_choose_the_solution() -> None:
    """A PTP to a pose with T, and a MoveJ with cf1, cf4, cf6, end in the configuration that is stated."""
    kuka, abb = open_robot("kr6r900"), open_robot("irb120")
    q = np.radians([20.0, -80, 90, 30, 40, -50])
    for signs in (0b100010, 0b011010):  # A5 positive, and the wrist turned over
        here = pose(kuka, q)
        x, y, z = 1e3 * here[:3, 3]
        a, b, c = np.degrees([np.arctan2(here[1, 0], here[0, 0]), -np.arcsin(here[2, 0]),
                              np.arctan2(here[2, 1], here[2, 2])])  # fmt: skip
        goal = f"X {x:.9f}, Y {y:.9f}, Z {z:.9f}, A {a:.9f}, B {b:.9f}, C {c:.9f}, S 2, T {signs}"
        text = f"PTP {{A1 20,A2 -80,A3 90,A4 10,A5 30,A6 0}}\nPTP {{{goal}}}\n"
        found = check_program(kuka, krl.read(text, "a.src"), ASK)
        end = found.parts[0].check.curve.control[-1, -1]
        assert [bool(signs >> k & 1) for k in range(6)] == (end < 0).tolist()
        np.testing.assert_allclose(pose(kuka, end), here, atol=1e-7)
    home = pose(abb, np.radians([10.0, 5, 10, 100, 40, -120]))
    w = np.sqrt(1 + np.trace(home[:3, :3])) / 2
    x, y, z = (np.array([home[2, 1] - home[1, 2], home[0, 2] - home[2, 0], home[1, 0] - home[0, 1]]) / (4 * w)).tolist()
    place = (1e3 * home[:3, 3]).tolist()
    ends = []
    for four, six in ((1, -2), (-1, 0)):
        goal = f"[{place},[{w},{x},{y},{z}],[0,{four},{six},0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
        text = "MoveAbsJ [[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n"
        text += f"MoveJ {goal},v100,fine,tool0;\n"
        found = check_program(abb, rapid.read(text, "a.mod"), ASK)
        end = np.degrees(found.parts[0].check.curve.control[-1, -1])
        assert (np.floor(end[[0, 3, 5]] / 90) == [0, four, six]).all()
        ends.append(end)
    assert ends[0][4] * ends[1][4] < 0
    text = text.replace("[0,-1,0,0]", "[3,3,3,0]")
    refused = check_program(abb, rapid.read(text, "a.mod"), ASK)
    assert refused.parts[0].ended is not None
    assert str(refused.parts[0].ended.cause) == "no such posture"
    assert {(0, 1, -2), (0, -1, 0)} <= set(refused.parts[0].ended.available)
    said = " ".join(refused.summary)
    assert "has cf1, cf4, cf6 = 3, 3, 3 of its target; available: " in said
    assert "; 0, −1, 0; " in said
    alone = check_program(abb, rapid.read(text[text.index("MoveJ") :], "a.mod"), ASK)  # no move begins anywhere
    assert "Moves" not in [section.title for section in alone.sections()]
