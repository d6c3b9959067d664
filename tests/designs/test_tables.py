"""A sweep as Parquet: partitions, meanings of columns, and what cannot be written."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from rankdrop.designs.tables import check_tables, write_tables
from rankdrop.errors import MissingExtraError, ResultFileError
from rankdrop.schema.design import FAMILY_COLUMNS

parquet = pytest.importorskip("pyarrow.parquet")


def family(number: int) -> dict[str, object]:
    return {"id": f"k1.f{number}", "key": "k1, dim 5", "name": "elbow", "corank": 1, "dimension": 5,
            "conditions": ["sin θ3 = 0", "θ2 = 0"], "sound": [200, 200]}  # fmt: skip


def record(number: int) -> dict[str, object]:
    """A variant with as many families as its number, and the share near the first of them."""
    shares = [{"id": "k1.f0", "share": 0.25, "error": 0.01}] if number else []
    return {"number": number, "values": [0.1 * number], "measures": {"near": 0.5 + number}, "verdict": "agree",
            "error": None, "families": [family(k) for k in range(number)],
            "near": {"families": shares}}  # fmt: skip


def sweep(count: int) -> SimpleNamespace:
    parameter = SimpleNamespace(name="upper_arm", unit="m", places=("2.a",))
    spec = SimpleNamespace(task=SimpleNamespace(name="pose"))
    return SimpleNamespace(parameters=[parameter], measures=["near"], robot="ur5", spec=spec,
                           records=[record(number) for number in range(count)])  # fmt: skip


def test_variants_and_families_are_in_partitions_in_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rankdrop.designs.tables.ROWS", 2)
    folders = write_tables(sweep(5), tmp_path)  # type: ignore[arg-type]
    assert folders == (tmp_path / "variants", tmp_path / "families")
    names = ["part-00000.parquet", "part-00001.parquet", "part-00002.parquet"]
    assert [sorted(path.name for path in folder.iterdir()) for folder in folders] == [names, names]
    variants, families = (parquet.read_table(folder) for folder in folders)
    assert variants["variant"].to_pylist() == [1, 2, 3, 4, 5]
    assert variants["upper_arm_m"].to_pylist() == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert variants["near"].to_pylist() == [0.5, 1.5, 2.5, 3.5, 4.5]
    assert families["variant"].to_pylist() == [2, 3, 3, 4, 4, 4, 5, 5, 5, 5]
    assert families["family"].to_pylist()[:3] == ["k1.f0", "k1.f0", "k1.f1"]


def test_a_family_has_its_own_share_and_the_others_none(tmp_path: Path) -> None:
    _, folder = write_tables(sweep(3), tmp_path)  # type: ignore[arg-type]
    table = parquet.read_table(folder)
    assert table["share"].to_pylist() == [0.25, 0.25, None]
    assert table["conditions"].to_pylist()[0] == "sin θ3 = 0\nθ2 = 0"
    assert (table["sound"].to_pylist()[0], table["tested"].to_pylist()[0]) == (200, 200)


def test_every_column_has_its_meaning_and_the_table_its_arm(tmp_path: Path) -> None:
    _, folder = write_tables(sweep(2), tmp_path)  # type: ignore[arg-type]
    schema = parquet.read_schema(folder / "part-00000.parquet")
    assert {name: schema.field(name).metadata[b"meaning"].decode() for name in schema.names} == {
        name: meaning for name, _, meaning, _ in FAMILY_COLUMNS
    }
    told = {key: schema.metadata[key] for key in (b"schema", b"robot", b"task")}
    assert told == {b"schema": b"rankdrop/sweep-rows/1", b"robot": b"ur5", b"task": b"pose"}


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "variants").write_text("a file in its place")
    with pytest.raises(ResultFileError, match="cannot write") as caught:
        write_tables(sweep(1), tmp_path)  # type: ignore[arg-type]
    assert caught.value.where == str(tmp_path / "variants")


def test_without_pyarrow_the_extra_is_named_before_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    check_tables()
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingExtraError, match="parquet"):
        check_tables()
