"""The commands for research."""

from __future__ import annotations

import json
from pathlib import Path

from jsonschema import Draft202012Validator

from rankdrop.schema import load_schema


def test_a_descent_is_told_its_start_its_steps_and_its_ties(run, tmp_path: Path) -> None:
    path = tmp_path / "one.json"
    common = ("find", "pa10", "--corank", "3", "--length-scale", "1", "--seed", "2", "--start", "269", "--quiet")
    line = (*common, "--step", "0", "--iterations", "300")
    plain = run(*line, "--method", "gradient", "--json", str(path))
    assert "random start 269" in plain.out
    assert "method gradient, line search, at most 300 iterations" in " ".join(plain.out.split())
    assert "It ended at σ4 … = 0.13" in " ".join(plain.out.split())
    record = json.loads(path.read_text(encoding="utf-8"))
    Draft202012Validator(load_schema("find")).validate(record)
    assert record["configurations"][0]["outcome"] == "slow"
    treated = run(*line, "--method", "almarkhi", "--tie", "0.01", "--json", str(path))
    assert "1 of 1 starts converged" in treated.out
    assert json.loads(path.read_text(encoding="utf-8"))["configurations"][0]["iterations"] == 34
    run(*common, "--method", "almarkhi", "--tie", "0", "--step", "0.5", "--iterations", "7", "--json", str(path))
    record = json.loads(path.read_text(encoding="utf-8"))
    assert [record["settings"][key] for key in ("step", "tie", "iterations")] == [0.5, 0.0, 7]
    assert record["configurations"][0]["iterations"] == 7
