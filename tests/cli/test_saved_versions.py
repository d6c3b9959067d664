"""What an earlier version wrote is read by this one: results of every kind, saved as each was released."""

from __future__ import annotations

import json
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from rankdrop.cover import asked_about, verify
from rankdrop.cover.covering import Covering, write_covering
from rankdrop.errors import ResultFileError
from rankdrop.proof.boxes import load
from rankdrop.results.analysis import Analysis
from rankdrop.schema import NAMES, load_schema

SAVED = Path(__file__).resolve().parents[1] / "data" / "saved"
FILES = sorted(SAVED.glob("*/*.json"))
COVERINGS = sorted(SAVED.glob("*/*.cover"))


def record(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def label(path: Path) -> str:
    return f"{path.parent.name} {path.stem}"


def test_every_version_has_saved_one_of_most_kinds() -> None:
    assert SAVED.exists()
    for folder in SAVED.iterdir():
        kinds = {record(path)["schema"].split("/")[1] for path in folder.glob("*.json")}
        assert kinds <= set(NAMES)
        assert {"analysis", "conditions", "explanation", "find", "nearest"} <= kinds
        assert list(folder.glob("*.cover"))


@pytest.mark.parametrize("path", FILES, ids=label)
def test_a_saved_file_satisfies_the_schema_of_today(path: Path) -> None:
    saved = record(path)
    _, kind, number = saved["schema"].split("/")
    today = load_schema(kind)["properties"]["schema"]["const"].split("/")[2]
    assert number == today, "a new number reads the old one too"
    Draft202012Validator(load_schema(kind)).validate(saved)


@pytest.mark.parametrize("path", [path for path in FILES if path.stem.startswith("analysis")], ids=label)
def test_a_saved_analysis_is_read_and_holds(path: Path) -> None:
    found, saved = Analysis.load(path), record(path)
    assert found.residual().holds(found.settings.tolerances)
    assert [family.name for family in found.families] == [family["name"] for family in saved["families"]]
    for family, row in zip(found.families, saved["families"], strict=True):
        np.testing.assert_array_equal(family.witness, row["witness"])


@pytest.mark.parametrize("path", [path for path in FILES if "families" in record(path).get("exact", {})], ids=label)
def test_exact_conditions_that_an_old_file_lists_apart_are_those_of_its_families(path: Path) -> None:
    saved = record(path)
    listed = {one["id"]: one for one in saved["exact"]["families"]}
    written = Analysis.load(path).to_dict()
    assert listed.keys() == {family["id"] for family in written["families"]}
    for family in written["families"]:
        own = listed[family["id"]]
        assert family["exact"] == {key: own[key] for key in ("pinned", "conditions", "latex", "reality")}
    assert "families" not in written["exact"]
    del saved["exact"]["matches"]
    saved["exact"]["families"][0]["id"] = "k1.f9"
    with pytest.raises(ResultFileError, match=r"\$.exact.families: .*no such family; got .*k1.f9"):
        Analysis.from_dict(saved)


SINCE = {"inverse", "program"}
"""Kinds of files that came after the newest release; empty when one is saved."""


def test_the_newest_version_has_saved_one_of_every_kind() -> None:
    newest = max(SAVED.iterdir(), key=lambda folder: [int(part) for part in folder.name.split(".")])
    assert {record(path)["schema"].split("/")[1] for path in newest.glob("*.json")} == set(NAMES) - SINCE


@pytest.mark.parametrize("path", [path for path in FILES if path.stem.startswith("certificate")], ids=label)
def test_a_saved_certificate_still_holds(path: Path) -> None:
    saved = record(path)
    found = verify(path, asked_about(None, rows=saved["claim"]["points"]) if saved["kind"] == "path" else None)
    assert found.holds, found.reason


@pytest.mark.parametrize("path", COVERINGS, ids=label)
def test_a_saved_covering_is_read(path: Path) -> None:
    plan, tree, tested, _ = load(path)
    assert (plan.robot, tree.shape) == ("planar3r", plan.shape)
    assert tested > 0


@pytest.mark.parametrize("path", COVERINGS, ids=label)
def test_a_saved_covering_is_written_again_as_it_was(path: Path, tmp_path: Path) -> None:
    """The hash of a plan is over its text: another order of entries would be another file."""
    plan, tree, tested, freed = load(path)
    again = tmp_path / "again.cover"
    write_covering(again, Covering(plan, tree, tested, freed))
    old, new = (content.split(b"\n", 2) for content in (path.read_bytes(), again.read_bytes()))
    assert new[:2] == old[:2]
    assert zlib.decompress(new[2]) == zlib.decompress(old[2])
