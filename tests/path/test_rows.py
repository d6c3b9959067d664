"""A judged path row by row: the same numbers in every format, nothing between two rows lost."""

from __future__ import annotations

import builtins
import csv
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from rankdrop.cli import main
from rankdrop.errors import MissingExtraError, OptionError
from rankdrop.local.nearest import nearest_singularity
from rankdrop.path.check.check import check_path
from rankdrop.path.check.rows import check_format, path_rows, rows_file
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema

ARM = open_robot("ur5")
ENDS = np.array([[3, -12, 5, -10, 9, 4], [5, -10, -3, -12, 8, 4], [7, -9, -5, -11, 9, 1]]) / 10
Q = np.stack([np.interp(np.linspace(0, 2, 13), [0, 1, 2], ENDS[:, j]) for j in range(6)], axis=1)
FOUND = check_path(ARM, Q, np.linspace(0, 6, 13))
ROWS = path_rows(FOUND)


def test_each_row_has_its_numbers() -> None:
    columns = ROWS.columns
    assert columns["row"].tolist() == list(range(1, 14))
    for j, joint in enumerate(ARM.variables):
        np.testing.assert_allclose(columns[f"q_{joint.name}_rad"], Q[:, j])
    far = [nearest_singularity(ARM, one).distance for one in Q]
    np.testing.assert_allclose(columns["distance_rad"], far, rtol=1e-6)
    assert (columns["at_least_rad"] <= columns["distance_rad"]).all()
    assert (columns["at_least_rad"] > 0).all()
    assert set(columns) == set(ROWS.about)


def test_what_lies_between_two_rows_is_told_at_the_first_of_them() -> None:
    crossing = FOUND.crossings[0]
    assert len(FOUND.crossings) == 1
    verdicts = ROWS.columns["verdict"]
    assert [k + 1 for k, one in enumerate(verdicts) if one == "crossing"] == [crossing.bracket[0].row]
    assert set(verdicts) == {"crossing", "free"}
    at = check_path(ARM, ENDS * np.array([1, 1, 0, 1, 1, 1]))  # all of it lies in the elbow's singularity
    assert set(path_rows(at).columns["verdict"]) == {"touching"}
    alone = check_path(ARM, Q[:1])
    assert path_rows(alone).columns["verdict"] == ["free"]


def test_every_format_has_the_same_table() -> None:
    record = json.loads(rows_file(ROWS, "a.json"))
    Draft202012Validator(load_schema("path-rows")).validate(record)
    names = [one["name"] for one in record["columns"]]
    read = list(csv.reader(io.StringIO(rows_file(ROWS, "a.csv").decode())))
    assert read[0] == names == list(ROWS.columns)
    assert read[1:] == [["" if one is None else str(one) for one in row] for row in record["rows"]]
    parquet = pytest.importorskip("pyarrow.parquet", reason="Parquet needs pyarrow: the extra parquet")
    table = parquet.read_table(io.BytesIO(rows_file(ROWS, "a.parquet")))
    assert table.column_names == names
    assert [list(row.values()) for row in table.to_pylist()] == record["rows"]
    assert table.schema.metadata[b"schema"] == b"rankdrop/path-rows/1"
    assert table.schema.field("time_s").metadata[b"meaning"] == b"of the sample"


@pytest.mark.slow
def test_the_command_writes_rows_and_refuses_what_it_cannot(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    np.save("a.npy", Q)
    assert main.run(["path", "ur5", "a.npy", "--rows", "a.json", "--quiet"]) == 3
    assert len(json.loads((tmp_path / "a.json").read_text())["rows"]) == 13
    capsys.readouterr()
    assert main.run(["path", "ur5", "a.npy", "--rows", "a.xlsx", "--quiet"]) == 2
    assert "--rows: the ending names no format; got a.xlsx; allowed: .parquet, .json, .csv" in capsys.readouterr().err
    assert main.run(["path", "ur5", "a.npy", "a.npy", "--rows", "b.csv", "--quiet"]) == 2
    assert "--rows: this option is for one path" in capsys.readouterr().err
    with pytest.raises(OptionError, match="the ending names no format"):
        check_format("a.xlsx")


def test_without_pyarrow_the_command_that_helps_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *rest: Any, **more: Any) -> Any:
        if name.startswith("pyarrow"):
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(MissingExtraError, match=r'needs the package pyarrow; .*pip install "\.\[parquet\]"'):
        check_format("a.parquet")
