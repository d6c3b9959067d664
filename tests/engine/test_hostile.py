"""Small texts in job.json, journals and specifications: each is refused in one line, or harmless."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import rankdrop
from rankdrop.errors import RankdropError, ResultFileError
from rankdrop.jobs import Job, progress_of
from rankdrop.jobs.running import Folder

NOTE = json.dumps({
    "schema": "rankdrop/job/1", "items": 4, "sha256": "0" * 64,
    "job": {"kind": "sweep", "work": "a:b", "plan": {}, "chunks": 4, "version": "0.2.0"},
})  # fmt: skip
TEXTS = {
    "items beyond every double": NOTE.replace('"items": 4', '"items": 1e999'),
    "chunks beyond every double": NOTE.replace('"chunks": 4', '"chunks": 1e999'),
    "NaN": NOTE.replace('"items": 4', '"items": NaN'),
    "nested lists": "[" * 100_000,
    "nested objects": '{"job":' * 100_000,
    "5,000 digits": NOTE.replace('"items": 4', f'"items": {"9" * 5000}'),
    "4,000 digits": NOTE.replace('"chunks": 4', f'"chunks": {"9" * 4000}'),
    "fewer than none": NOTE.replace('"chunks": 4', '"chunks": -4'),
    "no chunks": NOTE.replace('"chunks": 4', '"chunks": 0'),
    "a count as text": NOTE.replace('"items": 4', '"items": "4"'),
    "a kind that steers a terminal": NOTE.replace('"sweep"', r'"\u001b[2J"'),
    "not UTF-8": b"\xff\xfe",
    "empty": "",
    "another schema": NOTE.replace("job/1", "job/2"),
}


def write(folder: Path, text: str | bytes) -> None:
    (folder / "job.json").write_bytes(text if isinstance(text, bytes) else text.encode())


def test_the_note_itself_is_read(tmp_path: Path) -> None:
    write(tmp_path, NOTE)
    assert progress_of(tmp_path).chunks == 4


@pytest.mark.parametrize("name", TEXTS)
def test_a_damaged_job_is_refused_in_one_line(name: str, tmp_path: Path) -> None:
    write(tmp_path, TEXTS[name])
    for ask in (lambda: progress_of(tmp_path), lambda: Folder.open(tmp_path, Job("sweep", "a:b", {}, 4, 4))):
        with pytest.raises(ResultFileError) as caught:
            ask()
        assert len(str(caught.value)) < 500
        assert str(caught.value).isprintable()


@pytest.mark.parametrize("line", ["9" * 5000, "²", "-1", "1e3", "٣٣٣٣٣٣٣٣٣٣٣"])
def test_a_damaged_journal_counts_nothing(line: str, tmp_path: Path) -> None:
    write(tmp_path, NOTE)
    (tmp_path / "journal").write_text(f"{line} {'0' * 64}\n", encoding="utf-8")
    assert progress_of(tmp_path).done == 0


SPEC: dict[str, Any] = {"robot": "planar3r", "parameters": {"a": {"sets": "1.a", "values": [1.0]}}}
SPECS = {
    **{f"sets {text[:9]}": SPEC | {"parameters": {"a": {"sets": text, "values": [1.0]}}}
       for text in ("².a", "-².a", "①.a", "9" * 5000 + ".a", "x" * 300 + ".a", "1.²", ".a", "1.", "")},
    **{f"value {text}": SPEC | {"parameters": {"a": {"sets": "1.a", "values": [value]}}}
       for text, value in (("400 digits", 10**400), ("inf", float("inf")), ("nan", float("nan")))},
    "a robot of 300 letters": SPEC | {"robot": "x" * 300},
    "a robot with a zero byte": SPEC | {"robot": "x\0y"},
    "a seed of 400 digits": SPEC | {"seed": 10**400},
    "10^30 steps": SPEC | {"parameters": {"a": {"sets": "1.a", "lower": 1.0, "upper": 2.0, "steps": 10**30}}},
    "a path of 300 letters": SPEC | {"paths": {"files": ["x" * 300]}},
    "10^30 samples": SPEC | {"near": {"samples": 10**30}},
}  # fmt: skip


@pytest.mark.parametrize("name", SPECS)
def test_a_hostile_specification_is_refused_in_one_line(name: str) -> None:
    with pytest.raises(RankdropError) as caught:
        rankdrop.sweep(SPECS[name], workers=1)
    assert len(str(caught.value)) < 2500
    assert "spec" in str(caught.value)


@pytest.mark.slow
def test_a_cluster_without_encryption_is_refused_where_encryption_is_required() -> None:
    dask = pytest.importorskip("dask")
    pytest.importorskip("distributed")
    with (
        dask.config.set({"distributed.comm.require-encryption": True}),
        pytest.raises(RankdropError, match=r"no scheduler answers; got tcp://127.0.0.1:9; allowed: .*tls://HOST"),
    ):
        rankdrop.sweep(SPEC | {"near": {"samples": 100}}, scheduler="tcp://127.0.0.1:9")
