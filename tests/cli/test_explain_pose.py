"""`explain --pose`: the command says what `inverse` finds, and `explain --q` where the tool is."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import rankdrop
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema


@pytest.mark.slow
def test_the_command_says_the_same_and_writes_valid_json(run, tmp_path: Path) -> None:
    target = tmp_path / "found.json"
    ended = run("explain", "irb120", "--deg", "--pose", "350mm,0,0.4,180,0,0", "--json", str(target))
    assert ended.code == 0
    assert "8 solutions; a 6R arm has at most 16" in " ".join(ended.out.split())
    record = json.loads(target.read_text())
    Draft202012Validator(load_schema("inverse")).validate(record)
    assert len(record["branches"]) == 8
    found = rankdrop.inverse(open_robot("irb120"), [0.35, 0.0, 0.4, np.pi, 0.0, 0.0])
    np.testing.assert_allclose([one["q"] for one in record["branches"]], [one.q for one in found.branches], atol=1e-9)


@pytest.mark.slow
def test_no_solution_has_an_exit_code(run) -> None:
    ended = run("explain", "irb120", "--pose", "0.9,0,0.4,1,0,0,0")
    assert ended.code == 3
    assert "no solution" in ended.out


@pytest.mark.slow
def test_one_place_is_needed(run) -> None:
    assert run("explain", "irb120").code == 2
    assert run("explain", "irb120", "--pose", "1,2").code == 2
    assert run("explain", "irb120", "--pose", "0,0,1", "--q", "0,0,0,0,0,0").code == 2
    assert run("explain", "irb120", "--pose", "0.35,0,0.4,pi,0,0", "--only", "escape").code == 2


def test_degrees_without_a_unit_are_refused(run) -> None:
    ended = run("explain", "irb120", "--pose", "0.35,0,0.4,180,0,0")
    assert ended.code == 2
    assert "angles look like degrees; got 180; allowed: radians, at most two turns; fix: add --deg" in ended.err
    assert "look like degrees" not in run("explain", "irb120", "--pose", "0.35,0,0.4,180deg,0,0").err


def test_a_pose_of_a_program_is_read_with_a_note(run) -> None:
    ended = run("explain", "kr6r900", "--pose", "{X 500, Y 0, Z 600, A 0, B 90, C 0, S 2}")
    assert "poses as KUKA writes them: x, y, z [mm]" in ended.err
    assert "not used: S" in ended.err
    assert "(500.0, 0.0, 600.0) mm" in ended.out or "8 solutions" in ended.out
