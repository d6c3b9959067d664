"""The analysis record: round trip, re-check, damage."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rankdrop.codec import json_text
from rankdrop.errors import ResultFileError
from rankdrop.results.analysis import Analysis


@pytest.mark.slow
def test_round_trip_changes_nothing(found: Analysis, shapes: Analysis, tmp_path: Path) -> None:
    part = replace(found, coranks=found.coranks[:1], families=found.of_corank(1), complete=False, unfinished=2)
    for analysis in (found, shapes, part):
        analysis.save(tmp_path / "one.json")
        text = (tmp_path / "one.json").read_text(encoding="utf-8")
        made_up = analysis is shapes  # for what is shown: its witnesses are no singular configurations
        again = Analysis.from_dict(json.loads(text), believe=True) if made_up else Analysis.load(tmp_path / "one.json")
        assert again == analysis
        again.save(tmp_path / "two.json")
        assert (tmp_path / "one.json").read_bytes() == (tmp_path / "two.json").read_bytes()


def test_a_loaded_analysis_re_checks_itself(found: Analysis, tmp_path: Path) -> None:
    found.save(tmp_path / "one.json")
    residual = Analysis.load(tmp_path / "one.json").residual()
    assert found.families
    assert residual.equation <= 1e-9
    assert residual.sigma <= 1e-9
    assert residual.holds(found.settings.tolerances)


def test_the_check_fails_for_a_witness_off_its_family(found: Analysis) -> None:
    row = found.families[0]
    moved = replace(row, witness=tuple(np.add(row.witness, 0.1)))
    residual = replace(found, families=(moved, *found.families[1:])).residual()
    assert residual.sigma > 1e-3
    assert not residual.holds(found.settings.tolerances)


def test_the_check_fails_for_a_row_of_the_wrong_corank(found: Analysis) -> None:
    row = replace(found.families[0], corank=2)
    assert not replace(found, families=(row,)).residual().holds(found.settings.tolerances)


def test_every_equation_is_text_that_vanishes_at_the_witness(found: Analysis) -> None:
    for row in found.to_dict()["families"]:
        names = {f"q{i}": np.array([value, value]) for i, value in enumerate(row["witness"], start=1)}
        for equation in row["equations"]:
            value = eval(equation, {"sin": np.sin, "cos": np.cos, "pi": np.pi}, names)
            assert np.abs(value).max() <= 1e-9


def test_arrays_are_read_only(found: Analysis) -> None:
    with pytest.raises(ValueError, match="read-only"):
        found.families[0].lost_directions[0, 0] = 1.0


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda record: record.update(schema="rankdrop/analysis/2"), "allowed: rankdrop/analysis/1"),
        (lambda record: record.pop("families"), "required field families"),
        (lambda record: record["families"][0].pop("witness"), "required field witness"),
        (lambda record: record["families"][0]["equations"].append("q1"), "disagree"),
        (lambda record: record["robot"]["chain"][0].update(screw=[1, 2]), "$.robot.chain[0].screw: "),
        (lambda record: record.update(coranks=3), "$.coranks: "),
    ],
)
def test_a_damaged_file_is_refused_in_one_line(found: Analysis, tmp_path: Path, damage, words: str) -> None:
    record = json.loads(json_text(found.to_dict()))
    damage(record)
    path = tmp_path / "bad.json"
    path.write_text(json.dumps(record), encoding="utf-8")
    with pytest.raises(ResultFileError) as caught:
        Analysis.load(path)
    assert words in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_that_is_not_json_or_not_there_is_refused(tmp_path: Path) -> None:
    (tmp_path / "text.json").write_text("not json", encoding="utf-8")
    for name in ("text.json", "nothing.json"):
        with pytest.raises(ResultFileError, match="cannot be read"):
            Analysis.load(tmp_path / name)


def test_entries_of_a_later_version_are_ignored(found: Analysis) -> None:
    record = json.loads(json_text(found.to_dict()))
    record["new"] = 1
    record["settings"]["new"] = 1
    record["settings"]["tolerances"]["new"] = 1
    record["families"][0]["new"] = 1
    record["coranks"][0]["unseen"]["new"] = 1
    assert Analysis.from_dict(record) == found
