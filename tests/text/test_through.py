"""How a passage through a singularity is worded."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from rankdrop.cli import main
from rankdrop.codec import json_text
from rankdrop.path.mend.time_law import through
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Any:
    def once(*argv: str) -> tuple[int, str, str]:
        capsys.readouterr()
        return (main.run(list(argv)), *capsys.readouterr())

    return once


@pytest.mark.slow
def test_the_command(run: Any, tmp_path: Path) -> None:
    out = tmp_path / "motion.csv"
    code, printed, _ = run("through", "planar2r", "--deg", "--q", "0,180", "--along", "0,1", "--path", str(out))
    assert code == 0
    assert printed.startswith("Trackable through the singularity at any speed")
    assert run("path", "planar2r", str(out), "--quiet")[0] == 3  # it does touch the singularity
    code, printed, _ = run("through", "planar2r", "--q", "0,0", "--along", "-1,0", "--json", "-")
    assert code == 3
    record = json.loads(printed)
    check = Draft202012Validator(load_schema("through"))
    check.validate(record)
    assert record == json.loads(json_text(through(open_robot("planar2r"), [0, 0], [-1, 0]).to_dict()))
    for entry in set(record) - {"units", "turn"}:  # which files of 0.2.0 do not have
        assert not check.is_valid({key: value for key, value in record.items() if key != entry}), entry
    code, _, said = run("through", "planar2r", "--q", "0,0", "--along", "a,b")
    assert code == 2
    assert "--along" in said
